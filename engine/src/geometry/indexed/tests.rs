use super::*;
use crate::simd::{Level, Pair, at_level};

type Triangle = (PrimitiveId, [u32; 3], [Vec3; 3]);

/// Triangles whose corners are among this number of vertices.
fn triangles(random: &mut fastrand::Rng, count: usize, vertices: u32) -> Vec<Triangle> {
    let at: Vec<Vec3> = (0..vertices)
        .map(|_| Vec3::new(random.f32(), -random.f32(), random.f32()))
        .collect();
    (0..count)
        .map(|_| {
            let corners = [(); 3].map(|()| random.u32(..vertices));
            (
                PrimitiveId(random.u32(..)),
                corners,
                corners.map(|corner| at[corner as usize]),
            )
        })
        .collect()
}

#[inline(always)]
fn is_unpacked<V: TriangleLanes>(simd: V::Simd, low: &[Triangle], high: &[Triangle]) {
    let blocks = [low, high].map(|all| IndexedBlock::new(all).expect("few vertices"));
    let mut columns = [[Column::splat(0.0); 3]; 3];
    for (corner, columns) in IndexedBlock::corners::<V>(simd, blocks.each_ref())
        .into_iter()
        .zip(&mut columns)
    {
        corner.store(columns);
    }
    for (i, &(id, _, at)) in low.iter().enumerate() {
        let whole = blocks[0].whole(simd);
        assert_eq!((whole.triangle(i), whole.id[i]), (at, id.0));
        assert_eq!((blocks[0].triangle(i), blocks[0].id(i)), (at, id.0));
    }
    let lanes = low
        .iter()
        .enumerate()
        .chain(high.iter().enumerate().map(|(i, t)| (LANES + i, t)));
    for (lane, &(_, _, at)) in lanes.take_while(|&(lane, _)| lane < V::COUNT) {
        for (column, corner) in columns.iter().zip(at) {
            assert_eq!(column.each_ref().map(|axis| axis.0[lane]), corner.to_array());
        }
    }
}

#[inline(always)]
fn is_unpacked_at<S: Simd>(simd: S, low: &[Triangle], high: &[Triangle]) {
    is_unpacked::<S::V8>(simd, low, high);
    is_unpacked::<Pair<S::V8>>(simd, low, high);
    is_unpacked::<S::V16>(simd, low, high);
}

#[test]
fn triangles_come_out_as_they_went_in() {
    let mut random = fastrand::Rng::with_seed(3);
    for round in 0..2000 {
        let count = 1 + round % LANES;
        let (low, high) = (
            triangles(&mut random, count, 12),
            triangles(&mut random, LANES, 9),
        );
        for level in Level::all() {
            at_level!(level, |simd| is_unpacked_at(simd, &low, &high));
        }
    }
}

#[test]
fn lanes_past_the_last_triangle_are_a_point() {
    let mut random = fastrand::Rng::with_seed(4);
    let block = IndexedBlock::new(&triangles(&mut random, 5, 12)).expect("few vertices");
    for lane in 5..LANES {
        let [a, b, c] = block.triangle(lane);
        assert!(a == b && b == c);
    }
}

#[test]
fn a_block_has_no_more_than_twelve_vertices() {
    let mut random = fastrand::Rng::with_seed(5);
    let mut too_many = 0;
    for _ in 0..2000 {
        let all = triangles(&mut random, LANES, 16);
        let mut names: Vec<u32> = all.iter().flat_map(|t| t.1).collect();
        names.sort_unstable();
        names.dedup();
        let fits = names.len() <= IndexedBlock::MOST_VERTICES;
        assert_eq!(IndexedBlock::new(&all).is_some(), fits);
        assert_eq!(IndexedBlock::fits(all.iter().map(|t| t.1)), fits);
        too_many += usize::from(!fits);
    }
    assert!((500..1500).contains(&too_many), "{too_many} of 2000 do not fit");
}

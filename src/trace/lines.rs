//! Leaf blocks against packets whose rays have their own origins: at first rays and edges are lines in Plücker
//! coordinates.

use super::{
    PACKETS, bits,
    bundle::Culling,
    leaf::{hit, in_order, interval, spheres, vector},
    rays::Packet,
};
use crate::{
    accel::{Bvh, Child},
    geometry::{EdgeLines, Edges, TriangleBlock, padded_boxes},
    simd::{
        F32x8, LANES, lane,
        lanes::{Column, LaneMask, Lanes, Vec3Lanes},
        splat,
    },
};

/// A packet and a triangle, as seen at first look.
///
/// In one number, which is stored at once: the lanes of [`Sides::above`] are its lowest sixteen bits, those of
/// [`Sides::below`] the next; above them is the packet times eight plus the triangle.
#[derive(Clone, Copy, Debug, Default)]
struct Look(u64);

impl Look {
    #[inline(always)]
    fn new(packet: usize, triangle: usize, sides: Sides) -> Self {
        let pair = (packet * LANES + triangle) as u64;
        Self(u64::from(sides.above | sides.below << 16) | pair << 32)
    }

    /// Whether any lane may hit.
    #[inline(always)]
    fn is_close(self) -> bool {
        self.0 as u32 != 0
    }

    #[inline(always)]
    fn packet(self) -> usize {
        (self.0 >> 32) as usize / LANES % PACKETS
    }

    #[inline(always)]
    fn triangle(self) -> usize {
        (self.0 >> 32) as usize % LANES
    }

    /// The lanes that may hit, now that those are known which the canonical test turns.
    #[inline(always)]
    fn ahead(self, turned: u32) -> u32 {
        let (above, below) = (self.0 as u32, (self.0 >> 16) as u32);
        ((above & !turned) | (below & turned)) & 0xffff
    }
}

/// Memory for what passes the first look at a block. (Made anew for each block, and so filled with zeros, mirror rays
/// lost 4 to 6 %.)
#[derive(Debug)]
pub(super) struct Looks([Look; PACKETS * LANES]);

impl Looks {
    pub const EMPTY: Self = Self([Look(0); PACKETS * LANES]);
}

/// A block against packets whose rays have their own origins: first as lines, which takes half the operations of the
/// canonical edge functions, then canonically those pairs that are left. (Mirror rays: interior 9.9 to 11.2 Mrays/s,
/// figure 46 to 51, terrain 4.7 to 4.9.)
///
/// A line does not tell what is behind a ray, and every ray that a mirror sends out passes through the triangle it comes
/// from: half of the pairs that were left, on curved meshes. So the canonical test ends where no ray starts on the side
/// from which its line would hit. (Mirror rays: cow +4 to +6 %, figure 0 to +5 %, interior, terrain and blobs 0 to
/// +2 %. With a loop of its own for this, in place of a branch within the canonical test: 2 to 3 % less.)
#[inline(always)]
pub(super) fn separate_origins<V: Lanes, const ANY: bool>(
    bvh: &Bvh,
    leaf: Child,
    culling: &Culling<'_, V>,
    packets: u32,
    moments: &[[Column; 3]; PACKETS],
    looks: &mut Looks,
    states: &mut [Packet; PACKETS],
) -> u32 {
    if !leaf.is_triangles() {
        let block = &bvh.sphere_blocks()[leaf.index()];
        return spheres::<V, ANY, false>(block, leaf.count_bits(), culling, packets, states);
    }
    let block = &bvh.triangle_blocks()[leaf.index()];
    let corners8 = TriangleBlock::corners::<F32x8>([block, block]);
    let edges8 = Edges::new(&corners8);
    let point8 = Vec3Lanes::splat(culling.point);
    let lines8 = EdgeLines::new(&corners8, &edges8, point8, splat(culling.extent));
    let (lowest8, look_lowest8) = (-lines8.tolerance, -lines8.look_tolerance);
    let Looks(looks) = looks;
    let mut count = 0;
    for p in bits(packets) {
        let state = &states[p % PACKETS];
        let d = Vec3Lanes::<V>::load(&state.direction);
        let m = Vec3Lanes::<V>::load(&moments[p % PACKETS]);
        let live = state.live_bits::<V>();
        for i in 0..leaf.count() {
            let look = Look::new(p, i, Sides::new(&d, &m, &lines8, &look_lowest8, i).of(live));
            looks[count % (PACKETS * LANES)] = look;
            count += usize::from(look.is_close());
        }
    }
    if count == 0 {
        return 0;
    }
    let (lower8, upper8) = padded_boxes(&corners8);
    let (first8, last8) = in_order(lower8, upper8, culling.down);
    let mut taken = 0;
    for &look in &looks[..count] {
        let (p, i) = (look.packet(), look.triangle());
        let state = &mut states[p];
        let o = Vec3Lanes::<V>::load(&state.origin);
        let d = Vec3Lanes::<V>::load(&state.direction);
        let a = Vec3Lanes::<V>::splat(block.v0.lane(i)) - o;
        let normal = vector::<V>(&edges8.normal, i);
        let plane = normal.dot(a);
        if look.ahead(plane.sign_bits()) == 0 {
            continue;
        }
        let b = Vec3Lanes::<V>::splat(block.v1.lane(i)) - o;
        let c = Vec3Lanes::<V>::splat(block.v2.lane(i)) - o;
        let flip = plane.sign();
        let weights = [
            d.dot(vector::<V>(&edges8.u, i).cross(c + a)).turn(flip),
            d.dot(vector::<V>(&edges8.v, i).cross(a + b)).turn(flip),
            d.dot(vector::<V>(&edges8.w, i).cross(b + c)).turn(flip),
        ];
        let tolerance = [V::splat(lane(&lowest8, i)), V::splat(lane(&lines8.tolerance, i))];
        let bounds = interval::<V>(state, vector(&first8, i) - o, vector(&last8, i) - o, culling);
        // Turned before the product, as elsewhere: the sign of a determinant of 0 depends on it.
        let determinant = d.dot(normal.turn(flip));
        let t = plane.turn(flip) / determinant;
        let hit = hit::<V, ANY>(state, block, i, tolerance, weights, t, bounds);
        taken |= u32::from(hit) << p;
    }
    taken
}

/// Lanes whose rays, taken as lines, do not clearly pass outside a triangle, by the side of it from which they come.
#[derive(Clone, Copy, Debug)]
struct Sides {
    /// No edge function is clearly negative: those that may hit if they start where the canonical test turns nothing.
    above: u32,
    /// None is clearly positive: those that may hit if they start where it turns all of them.
    below: u32,
}

impl Sides {
    /// Of triangle `i`.
    #[inline(always)]
    fn new<V: Lanes>(
        d: &Vec3Lanes<V>,
        m: &Vec3Lanes<V>,
        lines8: &EdgeLines,
        lowest8: &F32x8,
        i: usize,
    ) -> Self {
        let u = beside(d, m, vector(&lines8.edges[0], i), vector(&lines8.moments[0], i));
        let v = beside(d, m, vector(&lines8.edges[1], i), vector(&lines8.moments[1], i));
        let w = beside(d, m, vector(&lines8.edges[2], i), vector(&lines8.moments[2], i));
        let (lowest, highest) = (
            V::splat(lane(lowest8, i)),
            V::splat(lane(&lines8.look_tolerance, i)),
        );
        Self {
            above: !u.min(v).min(w).lt(lowest).bits(),
            below: !u.max(v).max(w).gt(highest).bits(),
        }
    }

    /// Those of `lanes`.
    #[inline(always)]
    fn of(self, lanes: u32) -> Self {
        Self {
            above: self.above & lanes,
            below: self.below & lanes,
        }
    }
}

/// The edge function: on which side of the line with `edge` and `moment` rays pass.
#[inline(always)]
fn beside<V: Lanes>(d: &Vec3Lanes<V>, m: &Vec3Lanes<V>, edge: Vec3Lanes<V>, moment: Vec3Lanes<V>) -> V {
    let by_moment = d.x.mul_add(moment.x, d.y.mul_add(moment.y, d.z * moment.z));
    let by_edge = m.x.mul_add(edge.x, m.y.mul_add(edge.y, m.z * edge.z));
    by_moment - by_edge
}

#[cfg(test)]
mod tests {
    use super::{super::leaf, *};
    use crate::{
        geometry::passes_through,
        ray::{PrimitiveId, RayPacket},
        simd::Vec3x8,
    };
    use glam::Vec3;

    /// Rays at corners, at edges and past them, of triangles of all shapes, near and far from their origins.
    #[test]
    fn first_looks_lose_no_ray_that_passes_through() {
        let mut random = fastrand::Rng::with_seed(11);
        let mut unit = move || random.f32() * 2.0 - 1.0;
        let mut vector = |size: f32| Vec3::new(unit(), unit(), unit()) * size;
        let mut passing = 0;
        for round in 0..20_000 {
            let size = [1e-3, 1.0, 1e3, 1e15][round % 4];
            let around = vector([0.0, 1.0, 1e4][round % 3] * size);
            let corners = [(); 3].map(|()| around + vector(size));
            let sliver = [corners[0], corners[1], (corners[0] + corners[1]) * 0.5];
            let corners = if round % 5 == 0 { sliver } else { corners };
            let block = TriangleBlock::new(&[(PrimitiveId(0), corners)]);
            let origins = [(); LANES].map(|()| around + vector(3.0 * size));
            let mut part = vector(1.0);
            let directions = origins.map(|origin| {
                part = Vec3::new(part.y, part.z, (part.x * 7.0).fract());
                let at = corners[0]
                    + (corners[1] - corners[0]) * part.x.abs()
                    + (corners[2] - corners[0]) * [0.0, part.y][round % 2];
                (at - origin).normalize()
            });
            let rays = RayPacket {
                direction: Vec3x8::from_lanes(directions),
                t_max: splat(f32::MAX),
            };
            let point = origins.into_iter().fold(origins[0], Vec3::min);
            let extent = (origins.into_iter().fold(origins[0], Vec3::max) - point).length();
            let mut packet = Packet::EMPTY;
            let origin8 = Vec3x8::from_lanes(origins);
            packet.set::<F32x8>(&rays, &rays);
            packet.start_at::<F32x8>(&origin8, &origin8);
            let corners8 = TriangleBlock::corners::<F32x8>([&block, &block]);
            let lines = EdgeLines::new(
                &corners8,
                &Edges::new(&corners8),
                Vec3Lanes::splat(point),
                splat(extent),
            );
            let d = Vec3Lanes::<F32x8>::load(&packet.direction);
            let m = packet.moments::<F32x8>(point);
            let sides = Sides::new(&d, &m, &lines, &-lines.look_tolerance, 0);
            let normal = leaf::vector::<F32x8>(&Edges::new(&corners8).normal, 0);
            let turned = normal
                .dot(Vec3Lanes::splat(corners[0]) - Vec3Lanes::load(&packet.origin))
                .sign_bits();
            let ahead = Look::new(0, 0, sides).ahead(turned);
            for (lane, (origin, direction)) in origins.into_iter().zip(directions).enumerate() {
                let edges = block.edge_functions(Vec3x8::splat(origin));
                let weights = edges.weights(&Vec3x8::splat(direction));
                let look = edges.first_look(weights) & 1;
                let passes = passes_through(
                    origin,
                    direction,
                    corners,
                    weights.map(|w| crate::simd::lane(&w, 0)),
                );
                passing += u32::from(passes);
                assert!(
                    !passes || look != 0 && ahead >> lane & 1 != 0,
                    "round {round}: {corners:?} {origin} {direction}"
                );
            }
        }
        assert!(
            (40_000..120_000).contains(&passing),
            "{passing} of 160,000 pass through"
        );
    }
}

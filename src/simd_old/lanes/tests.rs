use super::*;
#[cfg(target_arch = "x86_64")]
use crate::simd_old::avx512;

fn each_row_is_reduced<V: TriangleLanes>() {
    let mut random = fastrand::Rng::with_seed(7);
    for _ in 0..1000 {
        let numbers =
            [(); REGISTER_LANES].map(|()| Column([(); REGISTER_LANES].map(|()| random.f32() - 0.5)));
        let rows = numbers.each_ref().map(V::load);
        let [mut least, mut largest] = [Column::splat(0.0); 2];
        V::least_of_each(&rows).store(&mut least);
        V::largest_of_each(&rows).store(&mut largest);
        for (i, row) in numbers.iter().enumerate() {
            let row = &row.0[..V::COUNT];
            assert_eq!(
                least.0[i],
                row.iter().copied().fold(f32::MAX, f32::min),
                "row {i}"
            );
            assert_eq!(
                largest.0[i],
                row.iter().copied().fold(-f32::MAX, f32::max),
                "row {i}"
            );
        }
    }
}

/// Zeros of both signs among few others, so that some are equal.
fn column(random: &mut fastrand::Rng) -> Column {
    let numbers = [0.0, -0.0, 1.0, -1.0, 0.3, -0.3, 1e30, -1e-30];
    Column([(); REGISTER_LANES].map(|()| match random.usize(..16) {
        i if i < numbers.len() => numbers[i],
        _ => random.f32() - 0.5,
    }))
}

/// The lanes of a vector, as bits, and zeros.
fn bits_of<V: Lanes>(v: V) -> [u32; 32] {
    let mut memory = V::Memory::ZERO;
    v.store(&mut memory);
    std::array::from_fn(|i| {
        if i < V::COUNT {
            memory.place(i).to_bits()
        } else {
            0
        }
    })
}

/// The lanes of a vector, and zeros.
fn numbers_of<V: Lanes>(v: V) -> [f32; 32] {
    bits_of(v).map(f32::from_bits)
}

fn eights(column: &WideColumn) -> [F32x8; 4] {
    std::array::from_fn(|i| column.eight(i))
}

/// More lanes do what eight do, eight by eight.
#[expect(clippy::cognitive_complexity, reason = "one line an operation")]
fn eights_are_as_eight_lanes<V: Lanes>() {
    let mut random = fastrand::Rng::with_seed(11);
    for _ in 0..2000 {
        let columns = [(); 3].map(|()| WideColumn([column(&mut random), column(&mut random)]));
        let of_eights = || columns.each_ref().map(|column| V::of_eights(eights(column)));
        let eight = |i: usize| columns.each_ref().map(|column| column.eight(i));
        macro_rules! same {
            (|$a:ident, $b:ident, $c:ident| $result:expr) => {{
                let whole = {
                    let [$a, $b, $c] = of_eights();
                    bits_of($result)
                };
                for i in 0..V::COUNT / LANES {
                    let [$a, $b, $c] = eight(i);
                    let (of_eight, of_whole) = (bits_of($result), &whole[i * 8..][..8]);
                    assert_eq!(&of_eight[..8], of_whole, stringify!($result));
                }
            }};
        }
        macro_rules! same_bits {
            (|$a:ident, $b:ident| $result:expr) => {{
                let whole = {
                    let [$a, $b, _] = of_eights();
                    $result
                };
                let mut together = 0;
                for i in 0..V::COUNT / LANES {
                    let [$a, $b, _] = eight(i);
                    together |= $result << (8 * i);
                }
                assert_eq!(together, whole, stringify!($result));
            }};
        }
        same!(|a, b, _c| a + b);
        same!(|a, b, _c| a - b);
        same!(|a, b, _c| a * b);
        same!(|a, b, _c| a / b);
        same!(|a, _b, _c| -a);
        same!(|a, b, c| Lanes::mul_add(a, b, c));
        same!(|a, b, c| Lanes::mul_sub(a, b, c));
        same!(|a, b, _c| Lanes::min(a, b));
        same!(|a, b, _c| Lanes::max(a, b));
        same!(|a, _b, _c| Lanes::abs(a));
        same!(|a, _b, _c| Lanes::sqrt(Lanes::abs(a)));
        same!(|a, _b, _c| Lanes::sign(a));
        same!(|a, b, _c| Lanes::turn(a, Lanes::sign(b)));
        same!(|a, b, c| Lanes::select(Lanes::lt(a, b), b, c));
        same!(|a, b, c| Lanes::select(Lanes::le(a, b) & Lanes::gt(b, c), b, c));
        same!(|a, b, c| Lanes::select(Lanes::ge(a, b) | Lanes::lt(b, c), b, c));
        same_bits!(|a, b| Lanes::lt(a, b).bits());
        same_bits!(|a, b| Lanes::le(a, b).bits());
        same_bits!(|a, b| Lanes::gt(a, b).bits());
        same_bits!(|a, b| Lanes::ge(a, b).bits());
        same_bits!(|a, _b| Lanes::sign_bits(a));
        // Also of 0 / 0.
        same_bits!(|a, b| Lanes::not_lt(a / b, b, Lanes::ge(a, b * b)).bits());
        same_bits!(|a, b| Lanes::not_gt(a / b, b, Lanes::ge(a, b * b)).bits());

        let [whole, ..] = of_eights();
        let mut memory = V::Memory::ZERO;
        whole.store(&mut memory);
        assert_eq!(bits_of(V::load(&memory)), bits_of(whole));
        for i in 0..V::COUNT {
            assert_eq!(memory.place(i), memory.eight(i / LANES).as_array()[i % LANES]);
            *memory.place_mut(i) += 1.0;
            assert_eq!(memory.place(i), numbers_of(whole)[i] + 1.0);
        }
        let lanes = &numbers_of(whole)[..V::COUNT];
        let least = |lanes: &mut dyn Iterator<Item = f32>| lanes.fold(f32::MAX, f32::min);
        let most = |lanes: &mut dyn Iterator<Item = f32>| lanes.fold(-f32::MAX, f32::max);
        let (smallest8, largest8) = (numbers_of(whole.fold_min()), numbers_of(whole.fold_max()));
        for i in 0..LANES {
            let own = || lanes.iter().copied().skip(i).step_by(LANES);
            assert_eq!(smallest8[i], least(&mut own()));
            assert_eq!(largest8[i], most(&mut own()));
        }
        let (smallest, largest) = (
            numbers_of(whole.fold_min_to_16()),
            numbers_of(whole.fold_max_to_16()),
        );
        for i in 0..V::Triangles::COUNT {
            let own = || lanes.iter().copied().skip(i).step_by(REGISTER_LANES);
            assert_eq!(smallest[i], least(&mut own()));
            assert_eq!(largest[i], most(&mut own()));
        }
        assert_eq!(whole.largest(), most(&mut lanes.iter().copied()));

        let chosen = random.u32(..256);
        let near = Lanes::abs(eight(0)[0]);
        let (entries, count) = V::nearest_last(near, chosen);
        let mut expected: Vec<u32> = (0..LANES)
            .filter(|lane| chosen >> lane & 1 != 0)
            .map(|lane| entry(near.to_array()[lane], lane))
            .collect();
        expected.sort_by(|a, b| b.cmp(a));
        assert_eq!(entries[..count], expected);
        for (near_of_entry, lane) in expected.into_iter().map(unpack) {
            let near = near.to_array()[lane];
            assert!((near * (1.0 - 1e-6)..=near).contains(&near_of_entry), "{near}");
        }
    }
    for _ in 0..1 << 16 {
        let bits = random.u32(..) & random.u32(..);
        assert_eq!(V::Mask::from_bits(bits).bits(), bits & !0 >> (32 - V::COUNT));
    }
}

/// Lanes that are triangles: what only they do.
fn triangles_are_as_eight_lanes<V: TriangleLanes>() {
    let mut random = fastrand::Rng::with_seed(12);
    for _ in 0..2000 {
        let columns = [column(&mut random), column(&mut random)];
        let [low, high] = *columns[0].halves();
        assert_eq!(bits_of(V::join(low, high)), bits_of(V::load(&columns[0])));
        let places = [random.u32(..), random.u32(..)];
        let picked = bits_of(V::picked(columns.each_ref(), places));
        for (i, word) in places.into_iter().enumerate() {
            let of_half = bits_of(F32x8::picked([&columns[i], &columns[i]], [word, word]));
            if i < V::COUNT / LANES {
                assert_eq!(of_half[..8], picked[i * 8..][..8]);
            }
            assert_eq!(
                bits_of(V::picked8(&columns[i], word)),
                bits_of(F32x8::picked8(&columns[i], word))
            );
        }
    }
}

#[test]
fn more_lanes_are_as_eight() {
    eights_are_as_eight_lanes::<F32x8>();
    eights_are_as_eight_lanes::<F32x8x2>();
    triangles_are_as_eight_lanes::<F32x8>();
    triangles_are_as_eight_lanes::<F32x8x2>();
    #[cfg(target_arch = "x86_64")]
    if avx512::is_available() {
        eights_are_as_eight_lanes::<avx512::F32x16>();
        eights_are_as_eight_lanes::<avx512::F32x16x2>();
        triangles_are_as_eight_lanes::<avx512::F32x16>();
    }
}

#[test]
fn each_row_is_reduced_to_its_lane() {
    each_row_is_reduced::<F32x8>();
    each_row_is_reduced::<F32x8x2>();
    #[cfg(target_arch = "x86_64")]
    if avx512::is_available() {
        each_row_is_reduced::<avx512::F32x16>();
    }
}

use super::{lanes::entry, portable::V8 as Portable8, *};
use crate::lanes::LANES;

#[inline(always)]
fn each_row_is_reduced<V: TriangleLanes>(simd: V::Simd) {
    let mut random = fastrand::Rng::with_seed(7);
    for _ in 0..1000 {
        let numbers =
            [(); REGISTER_LANES].map(|()| Column([(); REGISTER_LANES].map(|()| random.f32() - 0.5)));
        let rows = numbers.each_ref().map(|row| V::load(simd, row));
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

fn eights(column: &WideColumn) -> [&F32x8; 4] {
    std::array::from_fn(|i| column.eight(i))
}

/// They do what eight portable ones do, eight by eight.
#[expect(
    clippy::cognitive_complexity,
    clippy::too_many_lines,
    reason = "one line an operation"
)]
#[inline(always)]
fn eights_are_as_eight_lanes<V: Lanes>(simd: V::Simd) {
    let mut random = fastrand::Rng::with_seed(11);
    for _ in 0..2000 {
        let columns = [(); 3].map(|()| WideColumn([column(&mut random), column(&mut random)]));
        let of_eights = || {
            columns
                .each_ref()
                .map(|column| V::of_eights(simd, eights(column)))
        };
        let eight = |i: usize| {
            columns
                .each_ref()
                .map(|column| super::Portable.load(column.eight(i)))
        };
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
        same!(|a, _b, _c| a * 0.3);
        same!(|a, _b, _c| -a);
        same!(|a, b, c| Lanes::mul_add(a, b, c));
        same!(|a, b, c| Lanes::mul_sub(a, b, c));
        same!(|a, b, _c| Lanes::min(a, b));
        same!(|a, b, _c| Lanes::max(a, b));
        same!(|a, _b, _c| Lanes::abs(a));
        same!(|a, _b, _c| Lanes::sqrt(Lanes::abs(a)));
        same!(|a, _b, _c| Lanes::sign(a));
        same!(|a, b, _c| Lanes::flip_signs(a, Lanes::sign(b)));
        same!(|a, b, c| Lanes::select(Lanes::lt(a, b), b, c));
        same!(|a, b, c| Lanes::select(Lanes::le(a, b) & Lanes::gt(b, c), b, c));
        same!(|a, b, c| Lanes::select(Lanes::ge(a, b) | Lanes::lt(b, c), b, c));
        same_bits!(|a, b| Lanes::lt(a, b).bits());
        same_bits!(|a, b| Lanes::le(a, b).bits());
        same_bits!(|a, b| Lanes::gt(a, b).bits());
        same_bits!(|a, b| Lanes::ge(a, b).bits());
        same_bits!(|a, b| Lanes::eq(a, b).bits());
        same_bits!(|a, b| (!Lanes::eq(a, b)).bits());
        same_bits!(|a, _b| Lanes::sign_bits(a));
        // Also of 0 / 0.
        same_bits!(|a, b| Lanes::not_lt(a / b, b, Lanes::ge(a, b * b)).bits());
        same_bits!(|a, b| Lanes::not_gt(a / b, b, Lanes::ge(a, b * b)).bits());

        let [whole, ..] = of_eights();
        let mut memory = V::Memory::ZERO;
        whole.store(&mut memory);
        assert_eq!(bits_of(V::load(simd, &memory)), bits_of(whole));
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
    }
    for _ in 0..1 << 16 {
        let bits = random.u32(..) & random.u32(..);
        assert_eq!(V::mask(simd, bits).bits(), bits & !0 >> (32 - V::COUNT));
    }
}

/// Eight lanes: what only they do.
#[inline(always)]
fn eight_are_as_portable<S: Simd>(simd: S) {
    let mut random = fastrand::Rng::with_seed(13);
    for _ in 0..2000 {
        let columns = [column(&mut random), column(&mut random)];
        let ([a, b], portable) = (columns.map(|column| column.halves()[0]), super::Portable);
        let ([a8, b8], [a, b]) = (
            [simd.load(&a), simd.load(&b)],
            [portable.load(&a), portable.load(&b)],
        );
        assert_eq!(a8.same_bits(b8), a.same_bits(b));
        assert_eq!(bits_of(a8.swap_halves()), bits_of(a.swap_halves()));
        assert_eq!(
            bits_of(a8.min_everywhere().abs()),
            bits_of(a.min_everywhere().abs())
        );
        assert_eq!(a8.largest_of_eight(), a.largest_of_eight());
        assert_eq!((a8 * 1e-25).trunc(), (a * 1e-25).trunc());
        assert_eq!(bits_of(a8.abs().scale_to_one()), bits_of(a.abs().scale_to_one()));
        assert_eq!(bits_of(a8.powi(5)), bits_of(a.powi(5)));
        let bytes = [(); 3].map(|()| F32x8::new([(); LANES].map(|()| random.f32() * 256.0)));
        let pairs = S::V8::byte_pairs(bytes.each_ref().map(|b| simd.load(b)));
        for (i, pair) in pairs.into_iter().enumerate() {
            let pixel = |lane: usize| {
                let [r, g, b] = bytes.each_ref().map(|b| b.as_array()[lane] as u64);
                r | g << 8 | b << 16
            };
            assert_eq!(pair, pixel(2 * i) | pixel(2 * i + 1) << 24);
        }
        let [x, y, z] = [0, 1, 2].map(|i| columns[1].place(i));
        assert_eq!(
            simd.mul_add(x, y, z).to_bits(),
            portable.mul_add(x, y, z).to_bits()
        );
        let word = random.u32(..);
        let picked = S::V8::picked8(simd, &columns[0], word);
        assert_eq!(
            bits_of(picked),
            bits_of(Portable8::picked8(portable, &columns[0], word))
        );

        let chosen = random.u32(..256);
        let near = a8.abs();
        let (entries, count) = near.nearest_last(chosen);
        let near = near.to8();
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
}

/// Lanes that are triangles: what only they do.
#[inline(always)]
fn triangles_are_as_eight_lanes<V: TriangleLanes>(simd: V::Simd) {
    let mut random = fastrand::Rng::with_seed(12);
    for _ in 0..2000 {
        let columns = [column(&mut random), column(&mut random)];
        let [low, high] = columns[0].halves();
        assert_eq!(
            bits_of(V::join(simd, low, high)),
            bits_of(V::load(simd, &columns[0]))
        );
        let places = [random.u32(..), random.u32(..)];
        let picked = bits_of(V::picked(simd, columns.each_ref(), places));
        for (i, word) in places.into_iter().enumerate().take(V::COUNT / LANES) {
            let of_half = bits_of(Portable8::picked8(super::Portable, &columns[i], word));
            assert_eq!(of_half[..8], picked[i * 8..][..8]);
        }
    }
}

#[inline(always)]
fn are_as_portable<S: Simd>(simd: S) {
    eight_are_as_portable(simd);
    eights_are_as_eight_lanes::<S::V8>(simd);
    eights_are_as_eight_lanes::<Pair<S::V8>>(simd);
    triangles_are_as_eight_lanes::<S::V8>(simd);
    triangles_are_as_eight_lanes::<Pair<S::V8>>(simd);
    each_row_is_reduced::<S::V8>(simd);
    each_row_is_reduced::<Pair<S::V8>>(simd);
}

#[test]
fn lanes_of_every_level_are_as_portable_ones() {
    for level in Level::all() {
        at_level!(level, |simd| are_as_portable(simd));
        #[cfg(target_arch = "x86_64")]
        if let Token::Avx512(simd) = level.token() {
            eights_are_as_eight_lanes::<avx512::V16>(simd);
            eights_are_as_eight_lanes::<Pair<avx512::V16>>(simd);
            triangles_are_as_eight_lanes::<avx512::V16>(simd);
            each_row_is_reduced::<avx512::V16>(simd);
        }
    }
}

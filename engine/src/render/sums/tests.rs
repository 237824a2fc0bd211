//! Tests of `sums`.

use super::*;
use crate::simd::Portable;

const MANY: u32 = 1 << 20;

#[test]
fn many_samples_keep_their_mean() {
    for c in [0.1_f32, 0.7, 1.0] {
        let mut samples = Samples::default();
        let mut tile = (Blocks::default(), TileColors::default());
        let one = TileColors {
            packets: vec![[F32x8::splat(c); 3]],
            alpha: vec![F32x8::splat(c)],
        };
        for i in 0..MANY {
            samples.begin();
            samples.add([c; 4]);
            add(&mut tile, &one, i);
        }
        let (mut blocks, mut sum) = tile;
        assert_eq!(blocks.finish(&mut sum, MANY), 1);
        let found = samples.mean();
        assert!((found[0] - c).abs() < 2e-6, "{} {c}", found[0]);
        assert_eq!(sum.packets, [[F32x8::splat(found[0]); 3]]);
        assert_eq!(sum.alpha, [F32x8::splat(found[3])]);
    }
}

/// As tiles add sample `i`.
fn add((blocks, sum): &mut (Blocks, TileColors), one: &TileColors, i: u32) {
    if begins_block(i) {
        blocks.add(sum);
    }
    if i.is_multiple_of(BLOCK) {
        (sum.packets, sum.alpha) = (one.packets.clone(), one.alpha.clone());
    } else {
        sum.add_all(Portable, one);
    }
}

#[test]
fn few_samples_are_summed_as_ever() {
    let mut samples = Samples::default();
    let mut sum = 0.0_f32;
    for i in 0..BLOCK {
        let c = 1.0 / (3.0 + i as f32);
        samples.begin();
        samples.add([c; 4]);
        sum += c;
    }
    assert_eq!(samples.mean(), [sum / BLOCK as f32; 4]);
}

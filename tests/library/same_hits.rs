//! Bundles, packets, single rays, the scalar BVH and brute force find the same hits, bit for bit.
//!
//! `OCTRAY_LONG=1` tries more scenes, and traces 1,000,000 rays in each of 200.

use crate::long::{is_long, rounds};
use octray::{
    accel::{BuildQuality, Bvh, Layout},
    verify::{Counts, Random, check_equivalence, implementations, scenes},
};
use std::ops::RangeInclusive;

fn check(seed: u64, count: usize, rays: u64) -> Result<(), String> {
    let mut random = Random::new(seed, 0);
    let scene = scenes::small(&mut random, count).map_err(|error| error.to_string())?;
    let layout = random.pick(&[Layout::Whole, Layout::Indexed]);
    let bvh = Bvh::build_as(&scene, BuildQuality::Best, layout);
    let mut counts = Counts::default();
    check_equivalence(
        &scene,
        &bvh,
        &implementations,
        &mut random,
        rays,
        &mut counts,
        &|| false,
    )
    .map_err(|difference| format!("scene seed {seed}, {count} primitives: {difference:#?}"))?;
    assert_eq!(counts.rays, rays);
    Ok(())
}

/// Scenes that are new in every run; what fails names its seed.
fn check_new_scenes(counts: RangeInclusive<usize>, rays: u64) {
    let mut random = fastrand::Rng::new();
    for _ in 0..rounds(80, 400) {
        let result = check(random.u64(..), random.usize(counts.clone()), rays);
        result.unwrap_or_else(|difference| panic!("{difference}"));
    }
}

#[test]
fn all_methods_agree_with_brute_force() {
    check_new_scenes(0..=64, 1_000);
}

#[test]
fn all_methods_agree_on_larger_scenes() {
    check_new_scenes(65..=400, 300);
}

#[test]
fn long_run() {
    if !is_long() {
        println!("skipped: set OCTRAY_LONG=1 to trace 1,000,000 rays in each of 200 scenes");
        return;
    }
    for seed in 0..200 {
        let count = 1 + seed as usize % 64;
        check(seed, count, 1_000_000).unwrap();
    }
}

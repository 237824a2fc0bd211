//! Bundles, packets, single rays, the scalar BVH and brute force find the same hits, bit for bit.
//!
//! `OCTRAY_LONG=1` tries more scenes, and traces 1,000,000 rays in each of 200.

use crate::long::{is_long, rounds};
use octray::{
    accel::{BuildQuality, Bvh, Layout},
    verify::{Counts, Random, check_equivalence, implementations, scenes},
};
use proptest::prelude::*;

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

proptest! {
    #![proptest_config(ProptestConfig { cases: rounds(80, 400), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn all_methods_agree_with_brute_force(seed in any::<u64>(), count in 0_usize..=64) {
        check(seed, count, 1_000).map_err(TestCaseError::fail)?;
    }

    #[test]
    fn all_methods_agree_on_larger_scenes(seed in any::<u64>(), count in 65_usize..=400) {
        check(seed, count, 300).map_err(TestCaseError::fail)?;
    }
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

use super::*;

/// How many bundles go ray by ray until one is tried.
fn until_tried(policy: &mut CoherencePolicy, kind: RayKind) -> usize {
    let mut count = 0;
    while policy.begin_bundle(kind) {
        policy.end_bundle(kind, 256, 256, true, false);
        count += 1;
    }
    count
}

#[test]
fn rays_go_one_by_one_for_longer_each_time_that_a_bundle_was_incoherent() {
    let mut policy = CoherencePolicy::new(Method::Adaptive);
    let kind = RayKind::Separate;
    let mut counts = Vec::new();
    for _ in 0..6 {
        assert!(!policy.begin_bundle(kind));
        policy.end_bundle(kind, 256, 257, false, false);
        counts.push(until_tried(&mut policy, kind));
    }
    assert_eq!(counts, [3, 6, 12, 24, 48, 48]);
    assert!(!policy.begin_bundle(RayKind::Camera), "kinds do not mix");
    policy.end_bundle(kind, 256, 10, false, false);
    policy.end_bundle(kind, 256, 257, false, false);
    assert_eq!(until_tried(&mut policy, kind), 3, "a coherent bundle forgets");
}

#[test]
fn bundles_are_given_up_where_triangles_are_smaller_than_what_is_between_rays() {
    let given_up = |kind, rays, leaves, packets, is_small| {
        let mut policy = CoherencePolicy::new(Method::Adaptive);
        policy.begin_bundle(kind);
        policy.visited(leaves, packets);
        policy.end_bundle(kind, rays, 0, false, is_small);
        policy.begin_bundle(kind)
    };
    // About as measured: pipes, twenty million triangles in blobs, and most other scenes.
    let camera = RayKind::Camera;
    assert!(!given_up(camera, 512, 2000, 18_000, false));
    assert!(given_up(camera, 256, 700, 850, false));
    assert!(!given_up(camera, 256, 60, 70, false));
    assert!(!given_up(camera, 256, 700, 850, true), "a picture's edge");
    // Small triangles anywhere, and hair.
    assert!(given_up(RayKind::Shadow, 512, 2300, 3200, false));
    assert!(!given_up(RayKind::Shadow, 512, 3700, 6500, false));
}

#[test]
fn shadow_rays_are_sorted_after_an_expensive_group() {
    let mut policy = CoherencePolicy::new(Method::Adaptive);
    let kind = RayKind::Shadow;
    let mut after = |rays, packets, alone| {
        policy.begin_bundle(kind);
        policy.visited(1, packets);
        policy.end_bundle(kind, rays, alone, false, false);
        policy.wants_sorting(kind)
    };
    assert!(!after(0, 0, 0), "nothing was traced yet");
    assert!(!after(256, 128, 0));
    assert!(after(256, 129, 0));
    assert!(after(256, 0, 17), "a ray alone counts as {ALONE} packets");
    assert!(!after(512, 129, 0), "the last group alone counts, ray by ray");
}

#[test]
fn sorting_in_vain_is_not_tried_again_at_once() {
    let mut policy = CoherencePolicy::new(Method::Adaptive);
    let kind = RayKind::Separate;
    assert!(policy.wants_sorting(kind));
    policy.traced_sorted(kind);
    assert!(policy.wants_sorting(kind), "bundles were coherent");
    policy.end_bundle(kind, 256, 257, false, false);
    policy.traced_sorted(kind);
    let skipped = (0..99).take_while(|_| !policy.wants_sorting(kind)).count();
    assert_eq!(skipped, SKIPPED_SORTS as usize);
}

#[test]
fn rays_are_sorted_where_enough_packets_diverge() {
    assert!(CoherencePolicy::sorts_mixed(16, 64) && !CoherencePolicy::sorts_mixed(15, 64));
    assert!(CoherencePolicy::sorts_spread(4, 64) && !CoherencePolicy::sorts_spread(3, 64));
    assert!(CoherencePolicy::is_small(7) && !CoherencePolicy::is_small(8));
}

#[test]
fn rays_go_singly_through_instances_whose_triangles_are_smaller_than_the_gaps_between_them() {
    let suited = |method, rays, primitives| {
        let mut policy = CoherencePolicy::new(Method::Adaptive);
        policy.suit_instance(method, rays, primitives);
        policy.method()
    };
    // A tree of 100,000 triangles far away, and filling the picture.
    assert_eq!(suited(Method::Adaptive, 200, 100_000.0), Method::Single);
    assert_eq!(suited(Method::Adaptive, 2048, 10_000.0), Method::Adaptive);
    assert_eq!(suited(Method::Packet, 200, 100_000.0), Method::Packet);
}

#[test]
fn a_method_that_is_asked_for_is_kept_to() {
    for kind in [RayKind::Camera, RayKind::Shadow, RayKind::Separate] {
        let mut packets = CoherencePolicy::new(Method::Packet);
        packets.end_bundle(kind, 256, 1000, false, false);
        assert!(!packets.begin_bundle(kind) && !packets.is_bundled());
        let mut single = CoherencePolicy::new(Method::Single);
        assert!(single.begin_bundle(kind));
        for mut policy in [packets, single] {
            assert!(!policy.wants_sorting(kind) && !policy.shares_entry(kind));
            assert_eq!(policy.group(kind, 1000), 1000);
        }
    }
}

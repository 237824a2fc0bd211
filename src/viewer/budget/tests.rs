use super::*;

const WINDOW: [u32; 2] = [1280, 720];

/// Traces frames whose pixels cost this many nanoseconds each.
fn run(budget: &mut Budget, nanoseconds: f64, frames: u32) -> Plan {
    for _ in 0..frames {
        let Plan { size: [w, h], .. } = budget.plan(WINDOW);
        let pixels = u64::from(w) * u64::from(h);
        budget.learn(
            pixels,
            Duration::from_secs_f64(pixels as f64 * nanoseconds * 1e-9),
        );
    }
    budget.plan(WINDOW)
}

#[test]
fn fast_scenes_are_sharp_at_the_second_frame() {
    let mut budget = Budget::new(DEFAULT_BUDGET);
    assert_eq!(budget.plan(WINDOW).size, [320, 180]);
    let plan = run(&mut budget, 10.0, 1);
    assert_eq!((plan.size, plan.full), (WINDOW, true));
}

#[test]
fn slow_scenes_keep_the_budget() {
    for (nanoseconds, width, seconds) in [
        (40.0, 640, 0.016),
        (50.0, 640, 0.016),
        (200.0, 320, 0.016),
        // A quarter of the sides, as long as that leaves 20 frames per second.
        (400.0, 320, 0.032),
        (800.0, 320, 0.048),
        (1200.0, 240, 0.06),
    ] {
        let mut budget = Budget::new(DEFAULT_BUDGET);
        let plan = run(&mut budget, nanoseconds, 20);
        assert_eq!((plan.size[0], plan.full), (width, false), "{nanoseconds}");
        let pixels = f64::from(plan.size[0]) * f64::from(plan.size[1]);
        assert!(pixels * nanoseconds * 1e-9 <= seconds, "{nanoseconds}: {plan:?}");
    }
    let mut budget = Budget::new(DEFAULT_BUDGET);
    let plan = run(&mut budget, 1e7, 3);
    assert_eq!((plan.size, plan.coarsest), ([40, 23], true));
}

#[test]
fn all_pixels_may_take_twice_the_budget() {
    // 33 frames per second of all pixels, then 27.
    let cost = |milliseconds: f64| milliseconds * 1e6 / (1280.0 * 720.0);
    let mut budget = Budget::new(DEFAULT_BUDGET);
    for milliseconds in [15.0, 20.0, 28.0, 30.0, 10.0] {
        for _ in 0..60 {
            assert!(run(&mut budget, cost(milliseconds), 1).full, "{milliseconds}");
        }
    }
    // It is also found from a coarser picture.
    assert!(!run(&mut budget, cost(80.0), 60).full);
    assert!(run(&mut budget, cost(27.0), 60).full);
    let tried = (0..2000).filter(|_| run(&mut budget, cost(37.0), 1).full);
    assert!(tried.count() < 20);
    assert_eq!(run(&mut budget, cost(37.0), 4).size[0], 640);
}

#[test]
fn resolution_returns() {
    let mut budget = Budget::new(DEFAULT_BUDGET);
    assert!(run(&mut budget, 10.0, 3).full);
    assert!(!run(&mut budget, 100.0, 3).full);
    assert!(run(&mut budget, 10.0, 40).full);
}

#[test]
fn it_does_not_flicker() {
    // A full frame takes one budget, or two; or a quarter of the sides does.
    for milliseconds in [15.0, 30.0, 16.0 * 15.0, 16.0 * 18.0] {
        let cost = milliseconds * 1e6 / (1280.0 * 720.0);
        let mut budget = Budget::new(DEFAULT_BUDGET);
        let settled = run(&mut budget, cost, 60);
        for i in 0..40 {
            let noise = if i % 2 == 0 { 0.97 } else { 1.03 };
            assert_eq!(run(&mut budget, cost * noise, 1), settled, "{milliseconds}");
        }
    }
}

#[test]
fn a_stutter_changes_nothing_and_slowness_does() {
    let mut budget = Budget::new(DEFAULT_BUDGET);
    run(&mut budget, 10.0, 10);
    assert!(run(&mut budget, 90.0, 1).full);
    assert!(run(&mut budget, 10.0, 4).full);
    assert!(run(&mut budget, 90.0, 2).full);
    assert!(run(&mut budget, 10.0, 4).full);
    assert!(!run(&mut budget, 90.0, 3).full);
}

#[test]
fn one_given_up_frame_is_a_stutter_and_two_are_not() {
    let fail = |budget: &mut Budget| {
        budget.plan(WINDOW);
        budget.learn_failure(1000, Duration::from_millis(70));
        budget.plan(WINDOW)
    };
    let mut budget = Budget::new(DEFAULT_BUDGET);
    for _ in 0..5 {
        assert!(run(&mut budget, 10.0, 20).full);
        assert!(fail(&mut budget).full);
    }
    assert!(!fail(&mut budget).full);
    // Without enough frames before, it is no stutter.
    let mut budget = Budget::new(DEFAULT_BUDGET);
    assert!(run(&mut budget, 10.0, 2).full);
    assert!(!fail(&mut budget).full);
}

#[test]
fn a_level_that_is_fast_again_is_used_again() {
    let mut budget = Budget::new(DEFAULT_BUDGET);
    for _ in 0..10 {
        assert!(!run(&mut budget, 90.0, 10).full);
        // After many failures it would wait for hundreds of frames.
        assert!(run(&mut budget, 10.0, 80).full);
    }
}

#[test]
fn a_slow_level_is_tried_less_and_less_often() {
    // Half a millisecond a frame plus 10 ns a pixel: half of the sides fit, all pixels do not.
    let mut budget = Budget::new(Duration::from_micros(4750));
    let mut tried = Vec::new();
    for frame in 0..3000 {
        let Plan {
            size: [w, h], full, ..
        } = budget.plan(WINDOW);
        let pixels = u64::from(w) * u64::from(h);
        if full {
            tried.push(frame);
        }
        budget.learn(pixels, Duration::from_secs_f64(5e-4 + pixels as f64 * 1e-8));
    }
    assert!(!tried.is_empty() && tried.len() < 20, "{tried:?}");
    assert_eq!(budget.plan(WINDOW).size, [640, 360]);
}

#[test]
fn resolution_stays_where_lowering_it_does_not_help() {
    // Each frame takes 60 ms at any resolution.
    let mut budget = Budget::new(DEFAULT_BUDGET);
    let mut coarser = 0;
    for _ in 0..200 {
        let Plan { size: [w, h], .. } = budget.plan(WINDOW);
        coarser += u32::from(w < 320);
        budget.learn(u64::from(w) * u64::from(h), Duration::from_millis(60));
    }
    assert!(coarser < 10, "{coarser}");
    // Afterwards all pixels return.
    assert!(run(&mut budget, 10.0, 40).full);
}

#[test]
fn small_windows_have_pixels() {
    let mut budget = Budget::new(DEFAULT_BUDGET);
    assert_eq!(budget.plan([1, 3]).size, [1, 1]);
    budget.learn(0, DEFAULT_BUDGET);
    assert!(budget.is_overdrawn(Duration::from_millis(65)) && !budget.is_overdrawn(DEFAULT_BUDGET));
}

use super::*;
use crate::ray::PrimitiveId;

fn go_on(_: Done) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// Returns one hit in a thousand with a distance that is off by one ulp.
struct Faulty<'a>(Box<dyn Implementation + 'a>);

impl Implementation for Faulty<'_> {
    fn name(&self) -> &'static str {
        "faulty"
    }

    fn trace(&mut self, group: &Group, found: &mut Vec<Found>) {
        self.0.trace(group, found);
        for found in found.iter_mut().filter(|found| found.hit.is_hit()) {
            if found.hit.t.to_bits() % 1000 == 77 {
                found.hit.hit.t = found.hit.t.next_up();
            }
        }
    }
}

fn with_a_fault<'a>(scene: &'a Scene, bvh: &'a Bvh) -> Vec<Box<dyn Implementation + 'a>> {
    let mut all = implementations(scene, bvh);
    if let Some(last) = all.pop() {
        all.push(Box::new(Faulty(last)));
    }
    all
}

#[test]
fn any_number_of_threads_traces_the_same_scenes() {
    let counts = |threads| {
        let settings = Settings {
            seed: 3,
            rays: Some(20_000),
            threads: Some(threads),
            ..Settings::default()
        };
        let outcome = run(&settings, &implementations, &go_on).unwrap();
        assert!(outcome.fault.is_none(), "{:?}", outcome.fault);
        (outcome.done, outcome.counts)
    };
    let (done, all) = counts(1);
    assert_eq!((done, all.clone()), counts(3));
    assert!(done.rays >= 20_000 && done.scenes == 10 && all.rays == done.rays);
    // The rays are aimed at the scene.
    assert!(all.hits > all.rays / 4 && all.hits < all.rays);
    for implementation in &all.implementations {
        assert_eq!(
            (implementation.rays, implementation.hits, implementation.blocked),
            (all.rays, all.hits, all.blocked)
        );
    }
}

#[test]
fn one_ray_in_a_hundred_is_on_a_large_scene() {
    let plans = (0..100_000).map(|number| Plan::new(1, number));
    let (mut all, mut large, mut largest, mut smallest) = (0, 0, 0, usize::MAX);
    for plan in plans {
        all += plan.rays;
        if plan.is_large {
            large += plan.rays;
            largest = largest.max(plan.primitives);
        } else {
            assert!((1..=64).contains(&plan.primitives));
            smallest = smallest.min(plan.primitives);
        }
    }
    assert!(
        (0.009..0.013).contains(&(large as f64 / all as f64)),
        "{large} of {all}"
    );
    assert!(largest > 90_000 && smallest == 1);
}

#[test]
fn a_fault_is_found_and_can_be_repeated() {
    let settings = Settings {
        seed: 5,
        rays: Some(10_000_000),
        ..Settings::default()
    };
    let fault = |settings: &Settings| {
        let outcome = run(settings, &with_a_fault, &go_on).unwrap();
        let fault = outcome.fault.expect("there is a fault");
        let FaultKind::Differs(difference) = fault.kind else {
            panic!("{:?}", fault.kind);
        };
        (fault.scene, difference)
    };
    let (scene, first) = fault(&settings);
    let (name, found) = first.found.last().unwrap();
    assert_eq!(name, "faulty");
    assert_eq!(found.hit.t, first.expected.hit.t.next_up());
    assert!(
        first.found[..first.found.len() - 1]
            .iter()
            .all(|(_, found)| found.same(&first.expected))
    );

    let just_that = Settings {
        scene: Some(scene),
        rays: None,
        ..settings
    };
    let (again, second) = fault(&just_that);
    assert_eq!(
        (scene, first.ray_i, first.ray()),
        (again, second.ray_i, second.ray())
    );
}

#[test]
fn a_panic_is_a_fault() {
    fn broken<'a>(_: &'a Scene, _: &'a Bvh) -> Vec<Box<dyn Implementation + 'a>> {
        panic!("out of order")
    }
    let settings = Settings {
        rays: Some(1),
        ..Settings::default()
    };
    let fault = run(&settings, &broken, &go_on).unwrap().fault.unwrap();
    assert!(matches!(fault.kind, FaultKind::Panicked(text) if text == "out of order"));
}

#[test]
fn a_run_can_be_stopped() {
    let settings = Settings::default();
    let outcome = run(&settings, &implementations, &|done| {
        if done.rays > 0 {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    });
    let outcome = outcome.unwrap();
    assert!(outcome.fault.is_none() && outcome.done.rays > 0);
}

#[test]
fn bits_are_compared_not_values() {
    let hit = crate::ray::Hit {
        t: 0.0,
        u: 0.5,
        v: 0.5,
        primitive: PrimitiveId(1),
    };
    let found = |hit: crate::ray::Hit, blocked| Found {
        hit: hit.into(),
        blocked,
    };
    let one = found(hit, true);
    assert!(one.same(&one));
    assert!(!one.same(&found(hit, false)));
    for other in [
        crate::ray::Hit { t: -0.0, ..hit },
        crate::ray::Hit {
            u: 0.5_f32.next_up(),
            ..hit
        },
        crate::ray::Hit {
            v: 0.5_f32.next_down(),
            ..hit
        },
        crate::ray::Hit {
            primitive: PrimitiveId(2),
            ..hit
        },
    ] {
        assert!(!one.same(&found(other, true)));
    }
    let mut elsewhere = one;
    elsewhere.hit.instance = crate::ray::InstanceId(0);
    assert!(!one.same(&elsewhere));
}

use super::*;
use crate::{
    accel::Bvh,
    scene::Scene,
    verify::{Found, Group, Implementation},
};
use std::path::Path;

/// Inverts the occlusion of one ray in some hundreds.
struct Faulty<'a>(Box<dyn Implementation + 'a>);

impl Implementation for Faulty<'_> {
    fn name(&self) -> &'static str {
        "faulty"
    }

    fn trace(&mut self, group: &Group, found: &mut Vec<Found>) {
        self.0.trace(group, found);
        for (found, ray) in found.iter_mut().zip(&group.rays) {
            found.blocked ^= ray.direction.x.to_bits() % 509 == 5;
        }
    }
}

fn with_a_fault<'a>(scene: &'a Scene, bvh: &'a Bvh) -> Vec<Box<dyn Implementation + 'a>> {
    let mut all = verify::implementations(scene, bvh);
    all.truncate(1);
    all.extend(
        verify::implementations(scene, bvh)
            .pop()
            .map(|last| -> Box<dyn Implementation> { Box::new(Faulty(last)) }),
    );
    all
}

fn plan(folder: &Path, scene: Option<u64>) -> VerifyPlan {
    VerifyPlan {
        settings: verify::Settings {
            seed: 7,
            rays: Some(10_000_000),
            scene,
            threads: Some(2),
        },
        time_limit: None,
        json: Some(JsonTarget::File(folder.join("counts.json"))),
    }
}

#[test]
fn a_fault_exits_with_5_and_is_repeated_by_what_it_says() {
    let folder = tempfile::tempdir().unwrap();
    let fails = |scene| {
        let interrupt = Interrupt::default();
        let error = run_with(&plan(folder.path(), scene), &with_a_fault, &interrupt).unwrap_err();
        assert_eq!(error.exit_code(), 5);
        error.text().unwrap()
    };
    let first = fails(None);
    let command = first
        .lines()
        .find_map(|line| line.strip_prefix("repeat it: octray verify --seed 7 --scene "));
    let scene = command.unwrap_or_else(|| panic!("{first}")).parse().unwrap();
    for words in [
        "brute force",
        "scalar BVH",
        "faulty",
        "0x",
        "origin",
        "direction",
        "t_max",
    ] {
        assert!(first.contains(words), "{words}: {first}");
    }
    assert_eq!(first, fails(Some(scene)));

    let json = std::fs::read_to_string(folder.path().join("counts.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(
        (&json["agree"], &json["fault"]["scene"]),
        (&false.into(), &scene.into())
    );
}

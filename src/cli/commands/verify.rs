//! `octray verify`: checks that every tracing method finds what brute force finds.

use crate::{
    cli::{
        CliError,
        plan::{JsonTarget, VerifyPlan},
        process::Interrupt,
        report::{
            self, SCHEMA, VerifyBar,
            verify::{Json, difference, text},
        },
        write::{json_line, write_json},
    },
    verify::{self, Done, Implementations},
};
use std::{
    ops::ControlFlow,
    time::{Duration, Instant},
};

/// A large scene takes less than this on a busy machine. The counts are printed once it is done.
const PATIENCE: Duration = Duration::from_secs(5);

/// Verifies and prints the counts.
///
/// # Errors
/// [`CliError::Differs`] with the command that repeats it, [`CliError::Interrupted`] after the counts so far.
pub fn run(plan: &VerifyPlan) -> Result<(), CliError> {
    run_with(
        plan,
        &verify::implementations,
        &Interrupt::install_with(PATIENCE)?,
    )
}

fn run_with(
    plan: &VerifyPlan,
    implementations: &Implementations,
    interrupt: &Interrupt,
) -> Result<(), CliError> {
    let VerifyPlan {
        settings,
        time_limit: limit,
        json,
    } = plan;
    let start = Instant::now();
    let is_quiet = *json == Some(JsonTarget::Stdout);
    let bar = VerifyBar::new(!is_quiet && report::notes_to_terminal(), settings.rays);
    let report = |done: Done| {
        bar.show(done, start.elapsed(), *limit);
        if interrupt.requested() || limit.is_some_and(|limit| start.elapsed() >= limit) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    };
    let outcome = verify::run(settings, implementations, &report);
    bar.clear();
    let outcome = outcome.map_err(|error| CliError::Failed(error.to_string()))?;
    let took = start.elapsed();

    let stopped = interrupt.requested();
    if !is_quiet {
        report::print(&text(settings, &outcome, took, stopped))?;
    }
    if let Some(target) = json {
        let json = Json::new(SCHEMA, settings, &outcome, took);
        write_json(target, &json_line(&json))?;
    }
    match &outcome.fault {
        Some(fault) => Err(CliError::Differs(difference(fault))),
        None if stopped => Err(CliError::Interrupted),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
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
}

//! `octray verify`: whether every way of tracing finds what brute force finds.

use super::{
    CliError,
    interrupt::Interrupt,
    report::{SCHEMA, grouped},
    verify_report::{Json, difference, text},
};
use crate::verify::{self, Done, Implementations, Settings};
use clap::Args;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::{
    io::{self, IsTerminal},
    ops::ControlFlow,
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

/// Some seconds on most machines.
const DEFAULT_RAYS: u64 = 10_000_000;

/// Arguments of `octray verify`.
#[derive(Args, Debug)]
pub struct VerifyArgs {
    /// How many rays, rounded up to whole scenes [default: 10000000, unless --seconds are given]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub rays: Option<u64>,

    /// Stop after so many seconds
    #[arg(long, value_name = "T", value_parser = seconds)]
    pub seconds: Option<f64>,

    /// Other seeds make other scenes and rays
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub seed: u64,

    /// Repeat just this scene
    #[arg(long, value_name = "N", conflicts_with_all = ["rays", "seconds"])]
    pub scene: Option<u64>,

    /// How many threads trace [default: as many as the machine has]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub threads: Option<u32>,

    /// Write the counts as JSON to a file, or to standard output (-)
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// A time in seconds, above 0 and at most a hundred days.
fn seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok();
    seconds
        .filter(|seconds| *seconds > 0.0 && *seconds <= 8_640_000.0)
        .ok_or_else(|| "expected a number of seconds, more than 0 and at most 8640000".into())
}

/// Verifies, and prints what was counted.
///
/// # Errors
/// [`CliError::Differs`] with all that is needed to repeat it, [`CliError::Interrupted`] after the counts so far.
pub fn run(args: &VerifyArgs) -> Result<(), CliError> {
    run_with(args, &verify::implementations, &Interrupt::install()?)
}

fn run_with(
    args: &VerifyArgs,
    implementations: &Implementations,
    interrupt: &Interrupt,
) -> Result<(), CliError> {
    let settings = Settings {
        seed: args.seed,
        rays: args.rays.or(args.seconds.is_none().then_some(DEFAULT_RAYS)),
        scene: args.scene,
        threads: args.threads.map(|threads| threads as usize),
    };
    let start = Instant::now();
    let limit = args.seconds.map(Duration::from_secs_f64);
    let is_quiet = args.json.as_deref() == Some(Path::new("-"));
    let bar = Bar::new(!is_quiet && io::stderr().is_terminal(), settings.rays);
    let report = |done: Done| {
        bar.show(done, start.elapsed(), limit);
        if interrupt.requested() || limit.is_some_and(|limit| start.elapsed() >= limit) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    };
    let outcome = verify::run(&settings, implementations, &report);
    bar.clear();
    let outcome = outcome.map_err(|error| CliError::Failed(error.to_string()))?;
    let took = start.elapsed();

    let stopped = interrupt.requested();
    if !is_quiet {
        super::print(&text(&settings, &outcome, took, stopped))?;
    }
    if let Some(path) = &args.json {
        super::bench::write_json(path, &Json::new(SCHEMA, &settings, &outcome, took))?;
    }
    match &outcome.fault {
        Some(fault) => Err(CliError::Differs(difference(fault))),
        None if stopped => Err(CliError::Interrupted),
        None => Ok(()),
    }
}

/// How far it has come, on a terminal.
struct Bar(Option<(ProgressBar, Option<u64>)>);

impl Bar {
    fn new(visible: bool, rays: Option<u64>) -> Self {
        Self(visible.then(|| {
            // Thousandths: of the rays or of the time, whichever ends sooner.
            let bar = ProgressBar::with_draw_target(Some(1000), ProgressDrawTarget::stderr());
            let style = ProgressStyle::with_template("{bar:40} {percent:>3} %  {msg}");
            // The template is a constant; indicatif's own look would do as well.
            let bar = match style {
                Ok(style) => bar.with_style(style),
                Err(_) => bar,
            };
            (bar, rays)
        }))
    }

    fn show(&self, done: Done, elapsed: Duration, limit: Option<Duration>) {
        let Some((bar, rays)) = &self.0 else { return };
        let of_rays = rays.map_or(0.0, |rays| done.rays as f64 / rays as f64);
        let of_time = limit.map_or(0.0, |limit| elapsed.as_secs_f64() / limit.as_secs_f64());
        bar.set_position((1000.0 * of_rays.max(of_time).min(1.0)) as u64);
        bar.set_message(format!("{} rays", grouped(done.rays)));
    }

    fn clear(&self) {
        if let Some((bar, _)) = &self.0 {
            bar.finish_and_clear();
        }
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

    /// Takes one ray in some hundreds for blocked that is not, or the other way round.
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

    fn args(folder: &Path, scene: Option<u64>) -> VerifyArgs {
        VerifyArgs {
            rays: None,
            seconds: None,
            seed: 7,
            scene,
            threads: Some(2),
            json: Some(folder.join("counts.json")),
        }
    }

    #[test]
    fn a_fault_exits_with_5_and_is_repeated_by_what_it_says() {
        let folder = tempfile::tempdir().unwrap();
        let fails = |scene| {
            let interrupt = Interrupt::default();
            let error = run_with(&args(folder.path(), scene), &with_a_fault, &interrupt).unwrap_err();
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

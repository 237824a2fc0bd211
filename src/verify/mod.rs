//! Equivalence checks: every tracing implementation must find what brute force finds, bit for bit, for closest hits and
//! occlusion. The random scenes and rays are of the kinds that break ray tracers.
//!
//! A scene and its rays depend only on the seed and the scene's number, so each can be repeated by itself.
//!
//! ```
//! use octray::verify::{Settings, implementations, run};
//! use std::ops::ControlFlow;
//!
//! let settings = Settings { rays: Some(10_000), ..Settings::default() };
//! let outcome = run(&settings, &implementations, &|_| ControlFlow::Continue(())).unwrap();
//! assert!(outcome.fault.is_none() && outcome.counts.rays >= 10_000);
//! ```

mod equivalence;
mod implementations;
mod random;
pub mod rays;
pub mod scenes;

pub use equivalence::{Counts, Difference, ImplementationCounts, check_equivalence};
pub use implementations::{Found, Implementation, Implementations, implementations};
pub use random::Random;
pub use rays::Group;

use crate::{
    accel::{BuildQuality, Bvh, Layout},
    scene::Scene,
};
use std::{
    fmt,
    ops::ControlFlow,
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{
        Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, Ordering},
        mpsc::{self, RecvTimeoutError},
    },
    time::Duration,
};

/// Interval between calls of a run's callback.
const TICK: Duration = Duration::from_millis(100);
/// One scene in this many is large; with the ray counts of [`Plan::new`], so is about one ray in a hundred.
const LARGE_EVERY: u64 = 100;
/// The most primitives of a small scene.
const SMALL: u32 = 64;
/// The most primitives of a large scene.
const LARGE: u32 = 100_000;
const SMALL_RAYS: u64 = 2048;
/// Rays of a large scene with [`SMALL`] primitives. Larger ones get fewer, because brute force is slow.
const LARGE_RAYS: f64 = 8192.0;

/// Selects what to verify.
#[derive(Clone, Copy, Debug, Default)]
pub struct Settings {
    /// The seed of all scenes and rays.
    pub seed: u64,
    /// The run ends with the scene that reaches this many rays; `None`: at the callback's `Break`.
    pub rays: Option<u64>,
    /// Traces only the scene with this number, completely.
    pub scene: Option<u64>,
    /// Number of threads; `None` for one per CPU.
    pub threads: Option<usize>,
}

/// The result of a run.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// The scenes and rays done.
    pub done: Done,
    /// The counts of each implementation.
    pub counts: Counts,
    /// The fault with the lowest scene number.
    pub fault: Option<Fault>,
}

/// The progress of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Done {
    /// All scenes.
    pub scenes: u64,
    /// Large scenes among them.
    pub large_scenes: u64,
    /// Rays in all scenes.
    pub rays: u64,
    /// Rays in large scenes.
    pub large_rays: u64,
}

/// A scene on which an implementation differs or panics.
#[derive(Clone, Debug)]
pub struct Fault {
    /// The run's seed.
    pub seed: u64,
    /// The scene's number.
    pub scene: u64,
    /// Number of primitives in the scene.
    pub primitives: usize,
    /// The kind of fault.
    pub kind: FaultKind,
}

/// The kind of a [`Fault`].
#[derive(Clone, Debug)]
pub enum FaultKind {
    /// An implementation differs from brute force.
    Differs(Box<Difference>),
    /// Making, building or tracing the scene panicked, with this message.
    Panicked(String),
}

/// The threads of a run could not be started.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ThreadsError(String);

impl fmt::Display for ThreadsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "cannot start threads: {}", self.0)
    }
}

impl std::error::Error for ThreadsError {}

/// The size of scene `number`, and the random stream that makes it.
#[derive(Clone, Debug)]
struct Plan {
    number: u64,
    is_large: bool,
    primitives: usize,
    rays: u64,
    random: Random,
}

impl Plan {
    fn new(seed: u64, number: u64) -> Self {
        let mut random = Random::new(seed, number);
        let is_large = number % LARGE_EVERY == LARGE_EVERY - 1;
        let (primitives, rays) = if is_large {
            let ratio = f64::from(LARGE) / f64::from(SMALL + 1);
            let size = f64::from(SMALL + 1) * libm::pow(ratio, f64::from(random.unit()));
            let rays = LARGE_RAYS * libm::sqrt(f64::from(SMALL) / size);
            (size as usize, rays as u64)
        } else {
            (1 + random.below(SMALL) as usize, SMALL_RAYS)
        };
        Self {
            number,
            is_large,
            primitives,
            rays,
            random,
        }
    }

    fn scene(&mut self) -> Scene {
        let made = if self.is_large {
            scenes::large(&mut self.random, self.primitives)
        } else {
            scenes::small(&mut self.random, self.primitives)
        };
        made.unwrap_or_else(|error| panic!("the scene is refused: {error}"))
    }
}

/// State shared by the threads of a run.
struct Shared {
    settings: Settings,
    /// The next scene's number, and the rays of the scenes before it.
    next: Mutex<(u64, u64)>,
    outcome: Mutex<Outcome>,
    stop: AtomicBool,
}

/// Ignores poisoning: no panic can leave the value half changed.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Shared {
    fn stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Returns the next scene. Which scenes are traced does not depend on the number of threads.
    fn next(&self) -> Option<Plan> {
        let mut next = lock(&self.next);
        let (number, rays) = *next;
        if let Some(scene) = self.settings.scene {
            *next = (number + 1, rays);
            return (number == 0).then(|| Plan::new(self.settings.seed, scene));
        }
        if self.settings.rays.is_some_and(|most| rays >= most) || self.stopped() {
            return None;
        }
        let plan = Plan::new(self.settings.seed, number);
        *next = (number + 1, rays + plan.rays);
        Some(plan)
    }

    fn work(&self, implementations: &Implementations) {
        while let Some(mut plan) = self.next() {
            let mut counts = Counts::default();
            let traced = catch_unwind(AssertUnwindSafe(|| {
                let scene = plan.scene();
                let quality = plan
                    .random
                    .pick(&[BuildQuality::Fast, BuildQuality::Best, BuildQuality::Ploc]);
                let layout = plan.random.pick(&[Layout::Whole, Layout::Indexed]);
                let bvh = Bvh::build_as(&scene, quality, layout);
                let random = &mut plan.random;
                let stop = || self.stopped();
                check_equivalence(
                    &scene,
                    &bvh,
                    implementations,
                    random,
                    plan.rays,
                    &mut counts,
                    &stop,
                )
                .map_err(|difference| (scene.primitive_count(), difference))
            }));
            let fault = match traced {
                Ok(Ok(())) => None,
                Ok(Err((primitives, difference))) => Some((primitives, FaultKind::Differs(difference))),
                Err(panic) => Some((plan.primitives, FaultKind::Panicked(message(panic.as_ref())))),
            };
            let fault = fault.map(|(primitives, kind)| Fault {
                seed: self.settings.seed,
                scene: plan.number,
                primitives,
                kind,
            });
            self.add(&plan, &counts, fault);
        }
    }

    fn add(&self, plan: &Plan, counts: &Counts, fault: Option<Fault>) {
        let mut outcome = lock(&self.outcome);
        let large = u64::from(plan.is_large);
        outcome.done.scenes += 1;
        outcome.done.large_scenes += large;
        outcome.done.rays += counts.rays;
        outcome.done.large_rays += counts.rays * large;
        outcome.counts.add(counts);
        let Some(fault) = fault else { return };
        self.stop.store(true, Ordering::Relaxed);
        if outcome
            .fault
            .as_ref()
            .is_none_or(|known| fault.scene < known.scene)
        {
            outcome.fault = Some(fault);
        }
    }
}

fn message(panic: &(dyn std::any::Any + Send)) -> String {
    match (panic.downcast_ref::<&str>(), panic.downcast_ref::<String>()) {
        (Some(text), _) => (*text).to_string(),
        (_, Some(text)) => text.clone(),
        _ => "no message".into(),
    }
}

/// Traces scene after scene with all `implementations` (usually [`implementations()`]) and by brute force.
///
/// Ends at the first fault, when everything is done, or soon after `report` returns `Break`. `report` is called on the
/// calling thread ten times a second.
///
/// # Errors
/// [`ThreadsError`] if threads cannot be started.
pub fn run(
    settings: &Settings,
    implementations: &Implementations,
    report: &dyn Fn(Done) -> ControlFlow<()>,
) -> Result<Outcome, ThreadsError> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(settings.threads.unwrap_or_else(rayon::current_num_threads))
        .build()
        .map_err(|error| ThreadsError(error.to_string()))?;
    let shared = Shared {
        settings: *settings,
        next: Mutex::default(),
        outcome: Mutex::default(),
        stop: AtomicBool::new(false),
    };
    let (finished, wait) = mpsc::channel::<()>();
    std::thread::scope(|scope| {
        let (pool, shared) = (&pool, &shared);
        std::thread::Builder::new()
            .spawn_scoped(scope, move || {
                pool.broadcast(|_| shared.work(implementations));
                drop(finished);
            })
            .map_err(|error| ThreadsError(error.to_string()))?;
        while wait.recv_timeout(TICK) == Err(RecvTimeoutError::Timeout) {
            let done = lock(&shared.outcome).done;
            if report(done).is_break() {
                shared.stop.store(true, Ordering::Relaxed);
            }
        }
        Ok(())
    })?;
    Ok(shared
        .outcome
        .into_inner()
        .unwrap_or_else(PoisonError::into_inner))
}

#[cfg(test)]
mod tests;

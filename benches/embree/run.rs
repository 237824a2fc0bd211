//! Measures builds, and rays of each kind in every mode of Embree that could win.

use crate::{
    device::{Buffers, Build, EmbreeScene},
    ffi::Api,
    inputs::Input,
    rays::{Differences, Disputes, Prepared},
    single::Single,
    truth::{self, Right},
};
use octray::{
    Level,
    accel::Bvh,
    bench::{Kind, RaySet, Results, Workload, reference, trace_set},
    scene::Scene,
    trace::Tracer,
};
use std::time::Instant;

/// Modes within this factor of the fastest in the first trial are measured properly.
const WORTH_MEASURING: f64 = 1.3;
const TRIALS: usize = 2;

/// How Embree traces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mode {
    build: Build,
    width: usize,
    coherent: bool,
    /// Shadow rays: from the light to the surface.
    from_light: bool,
}

impl Mode {
    /// For example "16 coherent, avx2, high, from light".
    pub fn name(&self) -> String {
        let coherence = if self.coherent { "coherent" } else { "incoherent" };
        let mut name = format!("{} {coherence}", self.width);
        for (told, word) in [
            (self.build.avx2, "avx2"),
            (self.build.high, "high"),
            (self.build.robust, "robust"),
            (self.build.own_spheres, "own spheres"),
            (self.from_light, "from light"),
        ] {
            if told {
                name = name + ", " + word;
            }
        }
        name
    }

    fn all(kind: Kind, builds: impl Iterator<Item = Build>) -> Vec<Self> {
        let mut modes = Vec::new();
        for build in builds {
            for width in [1, 8, 16] {
                for coherent in [true, false] {
                    for from_light in [false, true] {
                        if kind == Kind::Shadow || !from_light {
                            modes.push(Self {
                                build,
                                width,
                                coherent,
                                from_light,
                            });
                        }
                    }
                }
            }
        }
        modes
    }
}

/// What can be built; the scene with medium quality and Embree's own spheres comes first.
fn builds(robust: bool, only_avx2: bool, has_spheres: bool) -> Vec<Build> {
    let mut builds = Vec::new();
    for own_spheres in if has_spheres {
        vec![false, true]
    } else {
        vec![false]
    } {
        for &avx2 in if only_avx2 { &[true][..] } else { &[false, true] } {
            for high in [false, true] {
                builds.push(Build {
                    avx2,
                    high,
                    robust,
                    own_spheres,
                });
            }
        }
    }
    builds
}

/// One line of results.
pub struct Row {
    pub scene: String,
    pub kind: Kind,
    pub robust: bool,
    /// Mrays/s, and (slowest - fastest) / median.
    pub ours: (f64, f64),
    pub embree: (f64, f64),
    pub mode: Mode,
    pub differences: Differences,
    /// Which is right where one hits and the other does not.
    pub right: Right,
    /// Which is right where both hit, at different distances.
    pub right_distance: Right,
    /// Whether octray's hits are those of the scalar reference, bit for bit.
    pub exact: bool,
}

impl Row {
    pub fn ratio(&self) -> f64 {
        self.ours.0 / self.embree.0
    }

    pub fn agree(&self) -> bool {
        self.exact && self.differences.agree()
    }
}

/// Seconds to build, best of a few.
#[derive(Clone, Copy)]
pub struct Builds {
    pub ours: [f64; 2],
    pub embree_medium: [f64; 2],
}

/// Builds on one thread and on two, alternating.
///
/// # Errors
/// An error of Embree or of the system.
pub fn builds_of(api: &Api, scene: &Scene, plan: Plan) -> Result<Builds, String> {
    let buffers = Buffers::new(scene);
    let medium = Build {
        avx2: plan.avx2,
        ..Build::default()
    };
    let mut best = Builds {
        ours: [f64::INFINITY; 2],
        embree_medium: [f64::INFINITY; 2],
    };
    for (i, threads) in [1, 2].into_iter().enumerate() {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|error| error.to_string())?;
        let start = Instant::now();
        let mut rounds = 0;
        // Small scenes build in a millisecond: those need many rounds to show their best.
        while rounds < 2 || (rounds < 50 && start.elapsed().as_secs_f64() < 2.0) {
            let ours = Instant::now();
            let bvh = pool.install(|| Bvh::build(scene));
            best.ours[i] = best.ours[i].min(ours.elapsed().as_secs_f64());
            drop(bvh);
            let embree = EmbreeScene::new(api, &buffers, medium, threads)?;
            best.embree_medium[i] = best.embree_medium[i].min(embree.build_seconds);
            rounds += 1;
        }
    }
    Ok(best)
}

/// The settings of a run.
#[derive(Clone, Copy)]
pub struct Plan {
    pub size: u32,
    pub repeat: usize,
    pub robust: bool,
    /// Both are held to AVX2.
    pub avx2: bool,
    /// Print each mode's speed in the first trial, and what it finds.
    pub all_modes: bool,
    /// Also one ray a call, through octray's queries.
    pub one_by_one: bool,
    /// The CPU to stay on; the last one by default.
    pub cpu: Option<usize>,
}

impl Plan {
    /// The level of octray.
    fn level(self) -> Level {
        match "avx2".parse() {
            Ok(level) if self.avx2 => level,
            _ => Level::current(),
        }
    }

    /// The instruction set of that level.
    pub fn isa(self) -> &'static str {
        self.level().instructions()
    }
}

/// Traces every kind of rays of a scene: rows of Embree's best mode, then of its best robust one if wanted.
///
/// # Errors
/// An error of Embree or of the system.
pub fn rows_of(api: &Api, input: &Input, plan: Plan) -> Result<Vec<Row>, String> {
    let scene = &input.scene;
    let bvh = Bvh::build(scene);
    let workload = Workload::new(scene, &bvh, &input.camera, plan.size, plan.size);
    let buffers = Buffers::new(scene);
    let mut rows = Vec::new();
    let robust_or_not: &[bool] = if plan.robust { &[false, true] } else { &[false] };
    for &robust in robust_or_not {
        let mut scenes = Vec::new();
        for build in builds(robust, plan.avx2, buffers.has_spheres()) {
            scenes.push(EmbreeScene::new(api, &buffers, build, 1)?);
        }
        // A thread of its own, so that builds keep all CPUs.
        let traced = std::thread::scope(|scope| {
            let tracing = || -> Result<Vec<Row>, String> {
                pin(plan.cpu)?;
                let sets = workload.sets.iter().filter(|set| set.count > 0);
                Ok(sets
                    .map(|set| row(input, &bvh, set, &scenes, plan, robust))
                    .collect())
            };
            scope.spawn(tracing).join()
        });
        rows.extend(traced.map_err(|_| "the tracing thread has panicked".to_string())??);
    }
    Ok(rows)
}

/// Embree with one set of rays in all its layouts.
struct Embree<'a> {
    scenes: &'a [EmbreeScene<'a>],
    /// From the surface, and for shadow rays from the light.
    prepared: Vec<Prepared>,
}

impl<'a> Embree<'a> {
    fn new(scenes: &'a [EmbreeScene<'a>], set: &RaySet) -> Self {
        let directions: &[bool] = if set.kind == Kind::Shadow {
            &[false, true]
        } else {
            &[false]
        };
        let prepared = directions
            .iter()
            .map(|&from_light| Prepared::new(set, from_light));
        Self {
            scenes,
            prepared: prepared.collect(),
        }
    }

    /// Seconds for the whole set.
    fn time(&mut self, mode: &Mode) -> f64 {
        let scene = self.scenes.iter().find(|scene| scene.build == mode.build);
        let prepared = &mut self.prepared[usize::from(mode.from_light)];
        let start = Instant::now();
        if let Some(scene) = scene {
            prepared.trace(scene, mode.width, mode.coherent);
        }
        start.elapsed().as_secs_f64()
    }

    /// The results of the last mode of that width and direction.
    fn differences(&self, mode: &Mode, set: &RaySet, ours: &Results) -> (Differences, Disputes) {
        self.prepared[usize::from(mode.from_light)].differences(mode.width, set, ours)
    }
}

fn row(input: &Input, bvh: &Bvh, set: &RaySet, scenes: &[EmbreeScene<'_>], plan: Plan, robust: bool) -> Row {
    eprintln!("{}: {} rays", input.name, set.kind.name());
    let mut embree = Embree::new(scenes, set);
    let mut tracer = Tracer::new(bvh)
        .at_level(plan.level())
        .with_instances(&input.scene);
    let mut results = Results::default();
    trace_set(&mut tracer, set, &mut results);
    let exact = results.same(&reference(&input.scene, bvh, set));

    let mut looked_at = Vec::new();
    for mode in Mode::all(set.kind, scenes.iter().map(|scene| scene.build)) {
        let looks = (0..TRIALS).map(|_| embree.time(&mode));
        looked_at.push((looks.fold(f64::INFINITY, f64::min), mode));
        if plan.all_modes {
            let (d, _) = embree.differences(&mode, set, &results);
            let speed = set.count as f64 / looked_at[looked_at.len() - 1].0 / 1e6;
            println!(
                "  {speed:>8.2} Mrays/s, differ {} in hit/miss and {} in distance: {}",
                d.hit_miss,
                d.distance,
                mode.name()
            );
        }
    }
    looked_at.sort_by(|a, b| a.0.total_cmp(&b.0));
    if plan.one_by_one {
        one_by_one(input, set, &mut embree, &looked_at, plan);
    }
    let worth = looked_at[0].0 * WORTH_MEASURING;
    let modes: Vec<Mode> = looked_at
        .iter()
        .filter(|(time, _)| *time <= worth)
        .map(|&(_, mode)| mode)
        .collect();

    let mut our_times = Vec::new();
    let mut embree_times = vec![Vec::new(); modes.len()];
    for _ in 0..plan.repeat {
        let start = Instant::now();
        trace_set(&mut tracer, set, &mut results);
        our_times.push(start.elapsed().as_secs_f64());
        for (mode, times) in modes.iter().zip(&mut embree_times) {
            times.push(embree.time(mode));
        }
    }
    let speed = |times: &mut Vec<f64>| {
        times.sort_by(f64::total_cmp);
        let median = times[times.len() / 2];
        let spread = (times[times.len() - 1] - times[0]) / median;
        (set.count as f64 / median / 1e6, spread)
    };
    let (mode, embree_speed) = modes.iter().zip(embree_times.iter_mut().map(speed)).fold(
        (modes[0], (0.0, 0.0)),
        |best, (&mode, speed)| {
            if speed.0 > best.1.0 { (mode, speed) } else { best }
        },
    );
    // Once more, because other modes of that width may have traced since.
    embree.time(&mode);
    let (differences, disputes) = embree.differences(&mode, set, &results);
    Row {
        scene: input.name.clone(),
        kind: set.kind,
        robust,
        ours: speed(&mut our_times),
        embree: embree_speed,
        mode,
        differences,
        right: truth::decide(&input.scene, &disputes.hit_miss),
        right_distance: truth::decide_distances(&input.scene, &disputes.distance),
        exact,
    }
}

/// Prints nanoseconds per ray with one ray per call: octray's queries, and Embree's best mode of that width.
fn one_by_one(input: &Input, set: &RaySet, embree: &mut Embree<'_>, looked_at: &[(f64, Mode)], plan: Plan) {
    let best = looked_at.iter().find(|(_, mode)| mode.width == 1);
    let (Some((_, mode)), Some(single)) = (best, Single::new(&input.scene, set, plan.level())) else {
        return;
    };
    let (mut ours, mut theirs) = (Vec::new(), Vec::new());
    for _ in 0..plan.repeat {
        ours.push(single.time());
        theirs.push(embree.time(mode));
    }
    let [ours, theirs] = [ours, theirs].map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2] / set.count as f64 * 1e9
    });
    println!(
        "{:<10} {:<8} one ray a call: octray {ours:.0} ns, Embree {theirs:.0} ns ({:.2}x its time; {})",
        input.name,
        set.kind.name(),
        ours / theirs,
        mode.name()
    );
}

/// Keeps the calling thread on one CPU, so that both programs share its caches and its clock.
#[cfg(target_os = "linux")]
fn pin(cpu: Option<usize>) -> Result<(), String> {
    let size = size_of::<libc::cpu_set_t>();
    // SAFETY: the sets are plain bits of the size that is given with them.
    unsafe {
        let mut allowed: libc::cpu_set_t = std::mem::zeroed();
        libc::sched_getaffinity(0, size, &raw mut allowed);
        let last = (0..libc::CPU_SETSIZE as usize)
            .rev()
            .find(|&cpu| libc::CPU_ISSET(cpu, &allowed));
        let cpu = cpu.or(last).unwrap_or(0);
        let mut one: libc::cpu_set_t = std::mem::zeroed();
        libc::CPU_SET(cpu, &mut one);
        if libc::sched_setaffinity(0, size, &raw const one) == 0 {
            Ok(())
        } else {
            Err(format!("cannot stay on CPU {cpu}"))
        }
    }
}

#[cfg(not(target_os = "linux"))]
fn pin(_: Option<usize>) -> Result<(), String> {
    Ok(())
}

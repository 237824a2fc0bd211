//! Compares builders, and the speed of rays through each tree: the suite's scenes, built fast, best and by obvhs' PLOC; the
//! same rays through all trees alternately, on one thread, median of seven. The last column is best relative to PLOC.
//! Threads are not pinned, and each tree is built once: differences below 10 % mean little.
//!
//! ```text
//! cargo bench --bench builds
//! cargo bench --bench builds -- figure terrain
//! ```

use octray::{
    accel::{BuildQuality, Bvh},
    bench::{RaySet, Results, SuiteScene, Workload, suite, trace_set},
    scene::Scene,
    trace::Tracer,
};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::{
    error::Error,
    iter::repeat_with,
    time::{Duration, Instant},
};

const QUALITIES: [BuildQuality; 3] = [BuildQuality::Fast, BuildQuality::Best, BuildQuality::Ploc];
const ROUNDS: usize = 7;
/// Pixels along a side of the picture whose rays are traced.
const SIDE: u32 = 1024;

fn main() -> Result<(), Box<dyn Error>> {
    let named: Vec<String> = std::env::args().skip(1).filter(|arg| arg != "--bench").collect();
    let scenes = suite();
    if let Some(unknown) = named
        .iter()
        .find(|name| scenes.iter().all(|scene| scene.name != **name))
    {
        return Err(format!("no scene of the suite is called {unknown}").into());
    }
    let wanted = |scene: &&SuiteScene| named.is_empty() || named.iter().any(|name| name == scene.name);
    println!("{}", octray::bench::machine());
    println!("scene      what                  fast        best        ploc   best/ploc");
    for scene in scenes.iter().filter(wanted) {
        run(scene)?;
    }
    Ok(())
}

fn run(suite_scene: &SuiteScene) -> Result<(), Box<dyn Error>> {
    let (scene, camera) = suite_scene.make()?;
    let name = suite_scene.name;
    for threads in [1, 2] {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build()?;
        let times = medians(|quality| build_time(&pool, &scene, quality));
        row(
            name,
            &format!("build, {threads} thr., ms"),
            times.map(|time| time * 1e3),
        );
    }
    let bvhs = QUALITIES.map(|quality| Bvh::build_with(&scene, quality));
    let bytes = bvhs.each_ref().map(|bvh| bvh.stats().memory_bytes as f64);
    row(
        name,
        "bytes a primitive",
        bytes.map(|bytes| bytes / scene.primitive_count() as f64),
    );
    let workload = Workload::new(&scene, &bvhs[0], &camera, SIDE, SIDE);
    for set in &workload.sets {
        let mut tracers = bvhs.each_ref().map(Tracer::new);
        let mut results: [Results; 3] = Default::default();
        for (tracer, results) in tracers.iter_mut().zip(&mut results) {
            trace_set(tracer, set, results);
        }
        if !results.iter().all(|other| other.same(&results[0])) {
            return Err(format!(
                "{name}: {} rays hit something else in another tree",
                set.kind.name()
            )
            .into());
        }
        let times = medians(|quality| {
            let i = QUALITIES.iter().position(|&other| other == quality).unwrap_or(0);
            trace_time(&mut tracers[i], set, &mut results[i])
        });
        let rates = times.map(|time| set.count as f64 / time / 1e6);
        row(name, &format!("{}, Mrays/s", set.kind.name()), rates);
    }
    Ok(())
}

fn build_time(pool: &ThreadPool, scene: &Scene, quality: BuildQuality) -> Duration {
    pool.install(|| Bvh::build_with(scene, quality))
        .stats()
        .build_time
}

fn trace_time(tracer: &mut Tracer<'_>, set: &RaySet, results: &mut Results) -> Duration {
    let start = Instant::now();
    trace_set(tracer, set, results);
    start.elapsed()
}

/// Median times of alternating runs.
fn medians(mut take: impl FnMut(BuildQuality) -> Duration) -> [f64; 3] {
    let rounds: Vec<_> = repeat_with(|| QUALITIES.map(&mut take)).take(ROUNDS).collect();
    [0, 1, 2].map(|i| {
        let mut times: Vec<Duration> = rounds.iter().map(|round| round[i]).collect();
        times.sort_unstable();
        times[ROUNDS / 2].as_secs_f64()
    })
}

fn row(scene: &str, what: &str, numbers: [f64; 3]) {
    let [fast, best, ploc] = numbers;
    println!(
        "{scene:9}  {what:17} {fast:8.2}    {best:8.2}    {ploc:8.2}       {:5.2}",
        best / ploc
    );
}

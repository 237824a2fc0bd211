//! octray against Intel's Embree 4.4: the same rays, alternately in one process, on one thread.
//!
//! ```text
//! bash benches/embree/fetch.sh
//! cargo bench --bench embree --features embree-bench -- --json embree.json
//! cargo bench --bench embree --features embree-bench -- --only cow,terrain
//! cargo bench --bench embree --features embree-bench -- my.scn --eye 3,2,1 --target 0,0,0.5
//! ```
//!
//! The rays are those of [`octray::bench::Workload`]; the time runs from rays in memory to hits in memory. octray traces
//! as the renderer does, but camera and mirror rays in one call. Embree runs in every mode that could win: 1, 8 or 16 rays
//! per call, coherent or not, best instruction set or AVX2, medium or high build quality, spheres as its own geometry or
//! ours, shadow rays from either end. All modes are tried briefly; those near the fastest alternate with octray, and the best
//! median is reported. Embree's rays are prepared in its own layout, 16 rays as 4x4 pixels, without empty packets. The rays
//! of both are in large pages.

mod device;
mod ffi;
mod inputs;
mod rays;
mod report;
mod run;
mod single;
mod spheres;
mod truth;
#[path = "../common/view.rs"]
mod view;

use clap::Parser;
use inputs::{Source, View};
use std::{path::PathBuf, process::ExitCode};

#[path = "../../src/allocator.rs"]
mod allocator;

#[global_allocator]
static ALLOCATOR: allocator::Limited = allocator::Limited::new();

/// octray against Embree on the same rays.
#[derive(Parser)]
#[command(
    name = "cargo bench --bench embree --features embree-bench --",
    max_term_width = 110
)]
struct Arguments {
    /// Scenes or meshes of any format that octray reads, instead of the suite
    #[arg(value_name = "SCENE_OR_MESH")]
    files: Vec<PathBuf>,

    /// Write the results as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,

    /// Suite: only these scenes
    #[arg(long, value_name = "NAME,NAME", value_delimiter = ',')]
    only: Vec<String>,

    /// How often each program traces the rays; the median counts
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), default_value_t = 7)]
    repeat: u32,

    /// Camera rays across and down
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=8192), default_value_t = 1024)]
    size: u32,

    /// Suite: triangles of the blobs
    #[arg(long, value_name = "N", default_value_t = 1_000_000)]
    blobs: usize,

    /// Also against Embree's robust scene flag
    #[arg(long)]
    robust: bool,

    /// Hold both to AVX2
    #[arg(long)]
    avx2: bool,

    /// Print the speed of every mode of Embree in the first trial
    #[arg(long)]
    all_modes: bool,

    /// Also one ray per call, through octray's queries
    #[arg(long)]
    one_by_one: bool,

    /// Skip the builds, which take long for large scenes
    #[arg(long)]
    no_builds: bool,

    /// Trace on this CPU [default: the last one]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(..1024))]
    cpu: Option<u32>,

    #[command(flatten)]
    view: View,

    /// Passed by cargo bench
    #[arg(long, hide = true)]
    bench: bool,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), String> {
    if arguments.avx2 && "avx2".parse::<octray::Level>().is_err() {
        return Err("--avx2 wants a CPU with AVX2".into());
    }
    let sources = sources(arguments)?;
    let api = match ffi::Api::load() {
        Ok(api) => api,
        Err(missing) => {
            println!("skipped: {missing}");
            return Ok(());
        }
    };
    device::self_check(&api)?;
    let plan = run::Plan {
        size: arguments.size,
        repeat: arguments.repeat as usize,
        robust: arguments.robust,
        avx2: arguments.avx2,
        all_modes: arguments.all_modes,
        one_by_one: arguments.one_by_one,
        cpu: arguments.cpu.map(|cpu| cpu as usize),
    };
    println!("{}", report::heading(plan));
    let (mut rows, mut builds) = (Vec::new(), Vec::new());
    for source in sources {
        let input = source.load(&arguments.view)?;
        if !arguments.no_builds {
            eprintln!("{}: builds", input.name);
            let of_scene = run::builds_of(&api, &input.scene, plan)?;
            println!("{}", report::build_line(&input.name, &of_scene));
            builds.push((input.name.clone(), of_scene));
        }
        for row in run::rows_of(&api, &input, plan)? {
            println!("{}", report::line(&row));
            rows.push(row);
        }
    }
    print!("{}", report::means(&rows, &builds));
    if let Some(path) = &arguments.json {
        report::write_json(path, plan, &rows, &builds)?;
    }
    match rows.iter().filter(|row| !row.exact).count() {
        0 => Ok(()),
        differing => Err(format!(
            "{differing} of {} rows are not what the scalar reference finds: their speeds mean nothing",
            rows.len()
        )),
    }
}

fn sources(arguments: &Arguments) -> Result<Vec<Source>, String> {
    if !arguments.files.is_empty() {
        return Ok(arguments.files.iter().cloned().map(Source::File).collect());
    }
    let suite = inputs::suite(arguments.blobs);
    if arguments.only.is_empty() {
        return Ok(suite);
    }
    let names: Vec<String> = suite.iter().map(Source::name).collect();
    if let Some(unknown) = arguments.only.iter().find(|name| !names.contains(name)) {
        return Err(format!("{unknown} is not in the suite: {}", names.join(", ")));
    }
    let wanted = |source: &Source| arguments.only.contains(&source.name());
    Ok(suite.into_iter().filter(wanted).collect())
}

//! `octray bench`: ways of tracing against each other, on the same rays.

use super::{
    BenchArgs, CliError,
    bench_args::{BenchMethod, LayoutArg},
    input::{self, Input},
    interrupt::Interrupt,
    memory::MemoryArgs,
    report::{SCHEMA, grouped},
    trace_args::BuildArg,
    whole_file,
};
use crate::{
    accel::Bvh,
    bench::{
        FrameTimes, Kind, Measurement, Method, Workload, compare, frame_times, machine, quick_suite, suite,
    },
    render::Settings,
    scene::{Camera, Scene},
    simd,
};
use clap::ValueEnum;
use serde::Serialize;
use std::{fmt::Write as _, io::Write as _, path::Path, time::Duration};

/// Times ways of tracing a scene's rays, or those of a suite of scenes, on one thread.
///
/// # Errors
/// [`CliError`]; [`CliError::Differs`] if a method does not find the reference's hits.
pub fn run(args: &BenchArgs) -> Result<(), CliError> {
    let methods: Vec<Method> = if args.methods.is_empty() {
        Method::ALL.to_vec()
    } else {
        args.methods.iter().map(|&m| method(m)).collect()
    };
    let settings = Settings {
        width: args.size.width,
        height: args.size.height,
        threads: Some(1),
        ..Settings::default()
    };
    settings.validate()?;
    let bench = Bench {
        methods,
        settings,
        repeat: args.frames.unwrap_or(args.repeat) as usize,
        frames_only: args.frames.is_some(),
        build: args.build,
        layout: args.layout,
        quiet: args.json.as_deref() == Some(Path::new("-")),
    };

    let mut results = Vec::new();
    if let Some(path) = &args.scene {
        let aspect = f64::from(args.size.width) / f64::from(args.size.height);
        let memory = MemoryArgs::default().limit();
        let Input { scene, camera, .. } = input::load(path, &args.camera, &args.mesh, aspect, memory)?;
        let name = path.display().to_string();
        bench.print(&bench.heading())?;
        let rows = bench.scene(&name, &scene, &camera)?;
        results.push((name, rows));
    } else {
        bench.print(&bench.heading())?;
        for suite_scene in if args.quick { quick_suite() } else { suite() } {
            let (scene, camera) = suite_scene
                .make()
                .map_err(|error| CliError::Failed(error.to_string()))?;
            let rows = bench.scene(suite_scene.name, &scene, &camera)?;
            results.push((suite_scene.name.to_string(), rows));
        }
        if !bench.frames_only {
            bench.print(&means(&results))?;
        }
    }
    if let Some(path) = &args.json {
        write_json(path, &Json::new(args, &results))?;
    }
    if results.iter().flat_map(|(_, rows)| rows).all(|row| row.agree) {
        Ok(())
    } else {
        Err(CliError::Differs(
            "some hits differ from the scalar reference's".into(),
        ))
    }
}

/// What is done with each scene.
struct Bench {
    methods: Vec<Method>,
    settings: Settings,
    repeat: usize,
    /// Frames are all that is timed.
    frames_only: bool,
    build: BuildArg,
    layout: LayoutArg,
    quiet: bool,
}

impl Bench {
    fn scene(&self, name: &str, scene: &Scene, camera: &Camera) -> Result<Vec<Measurement>, CliError> {
        self.print(&format!("\n{name}\n"))?;
        let Settings { width, height, .. } = self.settings;
        let lights = scene.lights().x.len() as f64;
        let rays = f64::from(width) * f64::from(height) * (1.0 + lights) * self.repeat as f64;
        let quality = self.build.quality(rays, scene.primitive_count());
        let bvh = Bvh::build_as(scene, quality, self.layout.layout(scene));
        if self.frames_only {
            self.print(&self.frames(scene, &bvh, camera)?)?;
            return Ok(Vec::new());
        }
        let workload = Workload::new(scene, &bvh, camera, width, height);
        let mut results = Vec::new();
        for set in workload.sets.iter().filter(|set| set.count > 0) {
            let rows = compare(scene, &bvh, set, &self.methods, self.repeat);
            self.print(&table(&rows))?;
            results.extend(rows);
        }
        self.print(&self.frames(scene, &bvh, camera)?)?;
        Ok(results)
    }

    fn frames(&self, scene: &Scene, bvh: &Bvh, camera: &Camera) -> Result<String, CliError> {
        let all = std::thread::available_parallelism().map_or(1, usize::from);
        let threads: &[usize] = if all > 1 { &[1, all] } else { &[1] };
        let frames = frame_times(scene, bvh, camera, &self.settings, threads, self.repeat)?;
        Ok(frame_table(&frames))
    }

    fn print(&self, text: &str) -> Result<(), CliError> {
        if self.quiet { Ok(()) } else { super::print(text) }
    }

    fn heading(&self) -> String {
        if self.frames_only {
            return format!(
                "{}x{}, shadows, {} levels, medians of {} frames in turns\n{}, {}\n",
                self.settings.width,
                self.settings.height,
                self.settings.max_depth,
                self.repeat,
                machine(),
                simd::isa()
            );
        }
        format!(
            "{}x{}, one thread, median of {}\n{}, {}\n\n{:8}{:8}{:>12}{:>12}{:>10}{:>9}{:>10}  hits agree\n",
            self.settings.width,
            self.settings.height,
            self.repeat,
            machine(),
            simd::isa(),
            "rays",
            "method",
            "rays",
            "hits",
            "Mrays/s",
            "spread",
            "speed-up"
        )
    }
}

/// The speed-ups over the scalar method, where that was measured: geometric means over the scenes.
fn means(results: &[(String, Vec<Measurement>)]) -> String {
    let mut text = format!(
        "\ngeometric mean of the speed-ups over {} scenes\n",
        results.len()
    );
    for kind in Kind::ALL {
        for method in Method::ALL {
            let speed = |rows: &[Measurement], method: Method| {
                let row = rows.iter().find(|row| row.kind == kind && row.method == method);
                row.map(|row| row.mrays_per_s)
            };
            let ratio = |rows: &[Measurement]| Some(speed(rows, method)? / speed(rows, Method::Scalar)?);
            let ratios = results.iter().filter_map(|(_, rows)| ratio(rows));
            let logarithms: Vec<f64> = ratios.map(f64::ln).collect();
            if method != Method::Scalar && !logarithms.is_empty() {
                let mean = (logarithms.iter().sum::<f64>() / logarithms.len() as f64).exp();
                // Writing to a string cannot fail.
                let _ = writeln!(text, "{:8}{:8}{mean:.2}x", kind.name(), method.name());
            }
        }
    }
    text
}

fn method(method: BenchMethod) -> Method {
    match method {
        BenchMethod::Scalar => Method::Scalar,
        BenchMethod::Packet => Method::Packet,
        BenchMethod::Single => Method::Single,
        BenchMethod::Render => Method::Render,
    }
}

fn table(rows: &[Measurement]) -> String {
    let scalar = rows
        .iter()
        .find(|row| row.method == Method::Scalar)
        .map(|row| row.mrays_per_s);
    let mut text = String::new();
    for row in rows {
        let speed_up = match scalar {
            Some(scalar) => format!("{:.2}x", row.mrays_per_s / scalar),
            None => "-".into(),
        };
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{:8}{:8}{:>12}{:>12}{:>10.2}{:>8.1}%{:>10}  {}",
            row.kind.name(),
            row.method.name(),
            grouped(row.rays),
            grouped(row.hits),
            row.mrays_per_s,
            row.spread * 100.0,
            speed_up,
            if row.agree { "ok" } else { "NO" }
        );
    }
    text
}

/// Whole frames, with shadows and reflections; the last four columns are of the threads' time within tiles.
fn frame_table(frames: &[FrameTimes]) -> String {
    let mut text = format!(
        "{:>7}{:>13}{:>10}{:>10}{:>10}{:>10}{:>10}{:>12}{:>10}{:>8}\n",
        "threads",
        "ms a frame",
        "spread",
        "frames/s",
        "Mrays/s",
        "speed-up",
        "tracing",
        "shading",
        "ray gen.",
        "film"
    );
    for f in frames {
        let seconds = f.frame.as_secs_f64().max(1e-9);
        let tiles = f.tiles.ray_generation + f.tiles.tracing + f.tiles.shading + f.tiles.film;
        let share = |part: Duration| 100.0 * part.as_secs_f64() / tiles.as_secs_f64().max(1e-9);
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{:>7}{:>13.2}{:>9.1}%{:>10.1}{:>10.1}{:>9.2}x{:>9.1}%{:>11.1}%{:>9.1}%{:>7.1}%",
            f.threads,
            seconds * 1e3,
            f.spread * 100.0,
            1.0 / seconds,
            f.rays.total() as f64 / seconds / 1e6,
            frames[0].frame.as_secs_f64() / seconds,
            share(f.tiles.tracing),
            share(f.tiles.shading),
            share(f.tiles.ray_generation),
            share(f.tiles.film),
        );
    }
    text
}

#[derive(Serialize)]
struct Json {
    schema: u32,
    machine: String,
    isa: &'static str,
    version: &'static str,
    threads: usize,
    /// Of the pictures whose rays are traced.
    width: u32,
    height: u32,
    /// Each speed is the median of so many.
    repeat: u32,
    /// As asked for.
    build: String,
    /// As asked for.
    layout: String,
    results: Vec<JsonRow>,
}

#[derive(Serialize)]
struct JsonRow {
    scene: String,
    kind: &'static str,
    method: &'static str,
    rays: u64,
    hits: u64,
    mrays_per_s: f64,
    spread: f64,
    agree: bool,
}

impl Json {
    fn new(args: &BenchArgs, results: &[(String, Vec<Measurement>)]) -> Self {
        let row = |scene: &str, row: &Measurement| JsonRow {
            scene: scene.to_string(),
            kind: row.kind.name(),
            method: row.method.name(),
            rays: row.rays,
            hits: row.hits,
            mrays_per_s: row.mrays_per_s,
            spread: row.spread,
            agree: row.agree,
        };
        Self {
            schema: SCHEMA,
            machine: machine(),
            isa: simd::isa(),
            version: env!("CARGO_PKG_VERSION"),
            threads: 1,
            width: args.size.width,
            height: args.size.height,
            repeat: args.repeat,
            build: name(&args.build),
            layout: name(&args.layout),
            results: results
                .iter()
                .flat_map(|(scene, rows)| rows.iter().map(|r| row(scene, r)))
                .collect(),
        }
    }
}

/// A value as it is given on the command line.
fn name(value: &impl ValueEnum) -> String {
    let value = value.to_possible_value();
    value.map_or_else(String::new, |value| value.get_name().to_string())
}

/// Writes an answer as JSON to a file, or to standard output (-).
pub fn write_json(path: &Path, json: &impl Serialize) -> Result<(), CliError> {
    // Plain structs of numbers and strings always serialize.
    let mut text = serde_json::to_string_pretty(json).unwrap_or_default();
    text.push('\n');
    if path == Path::new("-") {
        return super::print(&text);
    }
    whole_file::write(path, &Interrupt::default(), |out| out.write_all(text.as_bytes()))
        .map_err(|error| CliError::writing(&path.display().to_string(), &error))
}

//! `octray bench`: ways of tracing against each other, on the same rays.

use super::{
    BenchArgs, CliError,
    args::BenchMethod,
    report::{SCHEMA, grouped},
};
use crate::{
    accel::Bvh,
    bench::{FrameTimes, Measurement, Method, Workload, compare, frame_times, machine},
    format,
    render::Settings,
    simd,
};
use serde::Serialize;
use std::{fmt::Write as _, io::Write as _, path::Path};

/// Times ways of tracing a scene's rays, on one thread.
///
/// # Errors
/// [`CliError`]; [`CliError::Differs`] if a method does not find the reference's hits.
pub fn run(args: &BenchArgs) -> Result<(), CliError> {
    let camera = args.camera.camera()?;
    let settings = Settings {
        width: args.size.width,
        height: args.size.height,
        threads: Some(1),
        ..Settings::default()
    };
    settings.validate()?;
    let scene = format::load(&args.scene)?;
    let bvh = Bvh::build(&scene);
    let methods: Vec<Method> = if args.methods.is_empty() {
        Method::ALL.to_vec()
    } else {
        args.methods.iter().map(|&m| method(m)).collect()
    };
    let repeat = args.repeat as usize;
    let name = args.scene.display().to_string();

    let workload = Workload::new(&scene, &bvh, &camera, args.size.width, args.size.height);
    let mut results = Vec::new();
    let quiet = args.json.as_deref() == Some(Path::new("-"));
    let mut text = heading(&name, args);
    for set in workload.sets.iter().filter(|set| set.count > 0) {
        let rows = compare(&scene, &bvh, set, &methods, repeat);
        text.push_str(&table(&rows));
        results.extend(rows);
    }
    let frame = frame_times(&scene, &bvh, &camera, &settings, repeat)?;
    text.push_str(&frame_text(&frame));
    if !quiet {
        super::print(&text)?;
    }
    if let Some(path) = &args.json {
        write_json(path, &Json::new(&name, &results))?;
    }
    if results.iter().all(|row| row.agree) {
        Ok(())
    } else {
        Err(CliError::Differs(
            "some hits differ from the scalar reference's".into(),
        ))
    }
}

fn method(method: BenchMethod) -> Method {
    match method {
        BenchMethod::Scalar => Method::Scalar,
        BenchMethod::Packet => Method::Packet,
        BenchMethod::Single => Method::Single,
        BenchMethod::Render => Method::Render,
    }
}

fn heading(name: &str, args: &BenchArgs) -> String {
    format!(
        "{name}, {}x{}, one thread, median of {}\n{}, {}\n\n{:8}{:8}{:>12}{:>12}{:>10}{:>9}{:>10}  hits agree\n",
        args.size.width,
        args.size.height,
        args.repeat,
        machine(),
        simd::ISA,
        "rays",
        "method",
        "rays",
        "hits",
        "Mrays/s",
        "spread",
        "speed-up"
    )
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

fn frame_text(frame: &FrameTimes) -> String {
    let ms = |time: std::time::Duration| time.as_secs_f64() * 1e3;
    format!(
        "\nframe with shadows and reflections, one thread: {:.2} ms \
         (ray generation {:.2}, tracing {:.2}, shading and the rest {:.2})\n",
        ms(frame.frame),
        ms(frame.ray_generation),
        ms(frame.tracing),
        ms(frame.shading)
    )
}

#[derive(Serialize)]
struct Json {
    schema: u32,
    machine: String,
    isa: &'static str,
    threads: usize,
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
    fn new(scene: &str, rows: &[Measurement]) -> Self {
        let row = |row: &Measurement| JsonRow {
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
            isa: simd::ISA,
            threads: 1,
            results: rows.iter().map(row).collect(),
        }
    }
}

fn write_json(path: &Path, json: &Json) -> Result<(), CliError> {
    // Plain structs of numbers and strings always serialize.
    let mut text = serde_json::to_string_pretty(json).unwrap_or_default();
    text.push('\n');
    if path == Path::new("-") {
        return super::print(&text);
    }
    super::whole_file::write(path, |out| out.write_all(text.as_bytes()))
        .map_err(|error| CliError::writing(&path.display().to_string(), &error))
}

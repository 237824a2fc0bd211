//! The output of `octray bench`: tables and JSON.

use super::{SCHEMA, grouped};
use crate::{
    bench::{FrameTimes, Kind, Measurement, Method, machine},
    cli::plan::BenchPlan,
};
use serde::Serialize;
use std::{fmt::Write as _, time::Duration};

/// What is measured, on which machine, and the columns of [`table`].
pub fn heading(plan: &BenchPlan) -> String {
    let (width, height, repeat) = (plan.settings.width, plan.settings.height, plan.repeat);
    let machine = format!("{}, {}", machine(), crate::isa());
    if plan.frames_only {
        let depth = plan.settings.max_depth;
        return format!(
            "{width}x{height}, shadows, depth {depth}, medians of {repeat} frames in turn\n{machine}\n"
        );
    }
    format!(
        "{width}x{height}, one thread, median of {repeat}\n{machine}\n\n\
         {:8}{:8}{:>12}{:>12}{:>10}{:>9}{:>10}  hits agree\n",
        "rays", "method", "rays", "hits", "Mrays/s", "spread", "speed-up"
    )
}

/// Geometric means over the scenes of the speed-ups over the scalar method.
pub fn means(results: &[(String, Vec<Measurement>)]) -> String {
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

/// The results of one set of rays.
pub fn table(rows: &[Measurement]) -> String {
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

/// Times of whole frames, with shadows and reflections. The last four columns are shares of the threads' time in tiles.
pub fn frame_table(frames: &[FrameTimes]) -> String {
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

/// The results as JSON.
#[derive(Serialize)]
pub struct Json {
    schema: u32,
    machine: String,
    isa: &'static str,
    version: &'static str,
    threads: usize,
    width: u32,
    height: u32,
    /// Each speed is the median of this many runs.
    repeat: u32,
    /// As on the command line.
    build: &'static str,
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
    /// The results of each scene, by name.
    pub fn new(plan: &BenchPlan, results: &[(String, Vec<Measurement>)]) -> Self {
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
            isa: crate::isa(),
            version: env!("CARGO_PKG_VERSION"),
            threads: 1,
            width: plan.settings.width,
            height: plan.settings.height,
            repeat: plan.repeat,
            build: plan.build.name(),
            results: results
                .iter()
                .flat_map(|(scene, rows)| rows.iter().map(|r| row(scene, r)))
                .collect(),
        }
    }
}

//! The table and the JSON.

use crate::{
    run::{Builds, Plan, Row},
    truth::Right,
};
use octray::bench::{Kind, machine};
use serde::Serialize;
use std::path::Path;

/// The table's heading, with the machine and settings.
pub fn heading(plan: Plan) -> String {
    let Plan { size, repeat, .. } = plan;
    format!(
        "{}, octray on {}; one thread, {size}x{size} rays, median of {repeat}, alternating\n\n\
         {:<10} {:<7} {:>8} {:>6} {:>8} {:>6}  {:<42} {:>6}  {:>9} {:>9}  {}\n\
         {:<10} {:<7} {:>15} {:>15}  {:<42} {:>6}  {:>19}\n",
        machine(),
        plan.isa(),
        "scene",
        "rays",
        "octray",
        "spread",
        "Embree",
        "spread",
        "Embree's best mode",
        "ratio",
        "hit/miss",
        "distance",
        "agree",
        "",
        "",
        "Mrays/s",
        "Mrays/s",
        "",
        "",
        "differ per million"
    )
}

/// A line of the table.
pub fn line(row: &Row) -> String {
    let d = &row.differences;
    let decided = |what: &str, right: &Right| match right.disputes {
        0 => String::new(),
        n => format!(
            "; of {n} {what}in f64 octray is right on {}, Embree on {}",
            right.ours, right.embree
        ),
    };
    let decided = decided("", &row.right) + &decided("distances ", &row.right_distance);
    format!(
        "{:<10} {:<7} {:>8.2} {:>5.0}% {:>8.2} {:>5.0}%  {:<42} {:>5.2}x  {:>9.1} {:>9.1}  {}{decided}",
        row.scene,
        row.kind.name(),
        row.ours.0,
        row.ours.1 * 100.0,
        row.embree.0,
        row.embree.1 * 100.0,
        row.mode.name(),
        row.ratio(),
        d.per_million(d.hit_miss),
        d.per_million(d.distance),
        match (row.exact, d.agree()) {
            (true, true) => "yes",
            (true, false) => "no",
            (false, _) => "NO: octray differs from its own reference",
        }
    )
}

/// A line on builds.
pub fn build_line(scene: &str, builds: &Builds) -> String {
    let [ours, embree] = [builds.ours, builds.embree_medium].map(|b| b.map(|seconds| seconds * 1e3));
    format!(
        "{scene:<10} build   1 thread: octray {:.1} ms, Embree medium {:.1} ms ({:.2}x its time); 2 threads: \
         octray {:.1} ms, Embree medium {:.1} ms ({:.2}x)",
        ours[0],
        embree[0],
        ours[0] / embree[0],
        ours[1],
        embree[1],
        ours[1] / embree[1],
    )
}

/// Geometric means of the ratios, by kind of rays, and of the builds' times relative to Embree's; if the suite's spheres
/// are among other scenes, also without them.
pub fn means(rows: &[Row], builds: &[(String, Builds)]) -> String {
    let mut text = String::from("\ngeometric means\n");
    let is_triangles = |scene: &str| scene != "spheres";
    let mixed =
        rows.iter().any(|row| is_triangles(&row.scene)) && !rows.iter().all(|row| is_triangles(&row.scene));
    for without_spheres in if mixed { vec![true, false] } else { vec![false] } {
        let chosen = |scene: &str| !without_spheres || is_triangles(scene);
        let note = if without_spheres {
            ", without the spheres"
        } else {
            ""
        };
        for robust in [false, true] {
            for kind in Kind::ALL {
                let wanted = |row: &&Row| row.kind == kind && row.robust == robust && chosen(&row.scene);
                let ratios: Vec<f64> = rows.iter().filter(wanted).map(Row::ratio).collect();
                if let Some(worst) = ratios.iter().copied().reduce(f64::min) {
                    let against = if robust { ", against robust Embree" } else { "" };
                    text += &format!(
                        "{:<7} {:.2}x over {}, worst {worst:.2}x{note}{against}\n",
                        kind.name(),
                        geometric_mean(&ratios),
                        ratios.len()
                    );
                }
            }
        }
        for (i, threads) in ["1 thread", "2 threads"].into_iter().enumerate() {
            let of_scenes = builds.iter().filter(|(scene, _)| chosen(scene));
            let ratios: Vec<f64> = of_scenes.map(|(_, b)| b.ours[i] / b.embree_medium[i]).collect();
            if let Some(worst) = ratios.iter().copied().reduce(f64::max) {
                let mean = geometric_mean(&ratios);
                text +=
                    &format!("build, {threads}: {mean:.2}x Embree medium's time, worst {worst:.2}x{note}\n");
            }
        }
    }
    text
}

fn geometric_mean(ratios: &[f64]) -> f64 {
    (ratios.iter().map(|ratio| ratio.ln()).sum::<f64>() / ratios.len() as f64).exp()
}

#[derive(Serialize)]
struct Json {
    schema: u32,
    machine: String,
    isa: &'static str,
    version: &'static str,
    /// Both were held to AVX2.
    avx2: bool,
    /// Camera rays across and down.
    size: u32,
    /// Rounds; each speed is their median.
    repeat: usize,
    results: Vec<JsonRow>,
    builds: Vec<JsonBuilds>,
}

#[derive(Serialize)]
struct JsonRow {
    scene: String,
    kind: &'static str,
    ours: f64,
    embree: f64,
    /// (slowest - fastest) / median.
    ours_spread: f64,
    embree_spread: f64,
    embree_mode: String,
    ratio: f64,
    agree: bool,
    /// Rays that only one program hits: how many were decided in `f64`, and how often each was right.
    disputes: usize,
    ours_right: usize,
    embree_right: usize,
    /// The same for rays that both hit, at different distances.
    distance_disputes: usize,
    ours_distance_right: usize,
    embree_distance_right: usize,
}

#[derive(Serialize)]
struct JsonBuilds {
    scene: String,
    ours_1: f64,
    ours_2: f64,
    embree_medium_1: f64,
    embree_medium_2: f64,
}

/// Writes the results, the robust rows left out; times in seconds, speeds in Mrays/s.
///
/// # Errors
/// If the file cannot be written.
pub fn write_json(path: &Path, plan: Plan, rows: &[Row], builds: &[(String, Builds)]) -> Result<(), String> {
    let row = |row: &Row| JsonRow {
        scene: row.scene.clone(),
        kind: row.kind.name(),
        ours: row.ours.0,
        embree: row.embree.0,
        ours_spread: row.ours.1,
        embree_spread: row.embree.1,
        embree_mode: row.mode.name(),
        ratio: row.ratio(),
        agree: row.agree(),
        disputes: row.right.disputes,
        ours_right: row.right.ours,
        embree_right: row.right.embree,
        distance_disputes: row.right_distance.disputes,
        ours_distance_right: row.right_distance.ours,
        embree_distance_right: row.right_distance.embree,
    };
    let build = |(scene, b): &(String, Builds)| JsonBuilds {
        scene: scene.clone(),
        ours_1: b.ours[0],
        ours_2: b.ours[1],
        embree_medium_1: b.embree_medium[0],
        embree_medium_2: b.embree_medium[1],
    };
    let json = Json {
        schema: 1,
        machine: machine(),
        isa: plan.isa(),
        version: env!("CARGO_PKG_VERSION"),
        avx2: plan.avx2,
        size: plan.size,
        repeat: plan.repeat,
        results: rows.iter().filter(|row| !row.robust).map(row).collect(),
        builds: builds.iter().map(build).collect(),
    };
    let mut text = serde_json::to_string_pretty(&json).map_err(|error| error.to_string())?;
    text.push('\n');
    std::fs::write(path, text).map_err(|error| format!("cannot write {}: {error}", path.display()))
}

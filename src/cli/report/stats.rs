//! `--stats` and `--json`: statistics of one picture.

use super::{AovReport, SCHEMA, faults_text, grouped};
use crate::{
    accel::Bvh,
    cli::load::{Legend, faults::Faults},
    error::{clip, in_bytes},
    render::{FrameStats, Mode, Settings},
    scene::Scene,
};
use serde::Serialize;
use std::{fmt::Write, path::Path, time::Duration};

/// Statistics of one picture.
#[derive(Debug, Serialize)]
pub struct RenderReport {
    schema: u32,
    scene: String,
    output: String,
    /// The number of the frame in a series of them.
    #[serde(skip_serializing_if = "Option::is_none")]
    frame: Option<u32>,
    width: u32,
    height: u32,
    samples: u64,
    /// Whether `samples` are the most that a pixel takes.
    adaptive: bool,
    max_depth: u32,
    shadows: bool,
    mode: &'static str,
    /// The quality of the BVH: "fast", "best" or "ploc".
    build: &'static str,
    isa: &'static str,
    threads: usize,
    primitives: Primitives,
    rays: Rays,
    seconds: Seconds,
    /// All rays per second of `render`.
    rays_per_s: f64,
    memory_bytes: Memory,
    #[serde(skip_serializing_if = "Option::is_none")]
    aov: Option<AovReport>,
    /// What the colours of a mesh mean.
    #[serde(skip_serializing_if = "Option::is_none")]
    color_by: Option<Legend>,
}

#[derive(Debug, Serialize)]
struct Primitives {
    triangles: usize,
    spheres: usize,
    /// Number of instances; the primitives of their prototypes are counted above.
    instances: usize,
    degenerate_triangles: usize,
    /// Not counted in large meshes.
    duplicate_triangles: Option<usize>,
    /// Not counted in large meshes.
    inverted_triangles: Option<usize>,
}

#[derive(Debug, Serialize)]
struct Rays {
    camera: u64,
    shadow: u64,
    ambient: u64,
    reflection: u64,
    total: u64,
}

/// Wall-clock times. `total` runs from the start of the program or the end of the previous picture, so it exceeds the
/// sum. Loading and building count for a scene's first picture; later frames of what moves build a part.
#[derive(Debug, Serialize)]
struct Seconds {
    load: f64,
    build: f64,
    render: f64,
    write: f64,
    total: f64,
}

#[derive(Debug, Serialize)]
struct Memory {
    scene: usize,
    bvh: usize,
}

/// Wall-clock times that are not in [`FrameStats`].
pub struct Times {
    pub load: Duration,
    pub build: Duration,
    pub write: Duration,
    pub total: Duration,
}

impl RenderReport {
    /// The report on a picture of the scene at `path`, written to `output`.
    pub fn new(
        (path, scene, faults): (&Path, &Scene, &Faults),
        bvh: &Bvh,
        output: &str,
        settings: &Settings,
        frame: &FrameStats,
        times: &Times,
    ) -> Self {
        let render = frame.elapsed.as_secs_f64();
        let rays = frame.rays;
        Self {
            schema: SCHEMA,
            scene: path.to_string_lossy().into_owned(),
            output: output.to_owned(),
            frame: None,
            width: settings.window().width(),
            height: settings.window().height(),
            samples: u64::from(settings.samples),
            adaptive: settings.adaptive,
            max_depth: settings.max_depth,
            shadows: settings.shadows,
            mode: match settings.mode {
                Mode::Packet => "packet",
                Mode::Scalar => "scalar",
            },
            build: bvh.stats().quality.name(),
            isa: crate::isa(),
            threads: settings
                .threads
                .unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from)),
            primitives: Primitives {
                triangles: scene.triangles().corners.len(),
                spheres: scene.spheres().radius.len(),
                instances: scene.instances().len(),
                degenerate_triangles: scene.degenerate_triangles(),
                duplicate_triangles: faults.duplicate,
                inverted_triangles: faults.inverted,
            },
            rays: Rays {
                camera: rays.camera,
                shadow: rays.shadow,
                ambient: rays.ambient,
                reflection: rays.reflection,
                total: rays.total(),
            },
            seconds: Seconds {
                load: times.load.as_secs_f64(),
                build: times.build.as_secs_f64(),
                render,
                write: times.write.as_secs_f64(),
                total: times.total.as_secs_f64(),
            },
            rays_per_s: if render > 0.0 {
                rays.total() as f64 / render
            } else {
                0.0
            },
            memory_bytes: Memory {
                scene: scene.memory_bytes(),
                bvh: bvh.stats().memory_bytes,
            },
            aov: None,
            color_by: None,
        }
    }

    /// Adds the number of the frame, the report on AOVs and what colours mean.
    pub fn with(self, frame: Option<u32>, aov: Option<AovReport>, color_by: Option<Legend>) -> Self {
        Self {
            frame,
            aov,
            color_by,
            ..self
        }
    }

    /// A few lines of text.
    pub fn text(&self) -> String {
        let Self {
            primitives,
            rays,
            seconds,
            memory_bytes: memory,
            ..
        } = self;
        let faults = faults_text(
            primitives.degenerate_triangles,
            primitives.duplicate_triangles,
            primitives.inverted_triangles,
        );
        let [total, load, build, render, write] = [
            seconds.total,
            seconds.load,
            seconds.build,
            seconds.render,
            seconds.write,
        ]
        .map(|seconds| seconds * 1e3);
        let instances = match primitives.instances {
            0 => String::new(),
            count => format!(", {} instances", grouped(count as u64)),
        };
        let lines = [
            ("scene", clip(&self.scene)),
            (
                "primitives",
                format!(
                    "{} triangles ({faults}), {} spheres{instances}",
                    grouped(primitives.triangles as u64),
                    grouped(primitives.spheres as u64)
                ),
            ),
            ("picture", self.picture_text()),
            ("traced by", self.traced_by_text()),
            (
                "rays",
                format!(
                    "{}: {} camera, {} shadow, {} ambient, {} reflection",
                    grouped(rays.total),
                    grouped(rays.camera),
                    grouped(rays.shadow),
                    grouped(rays.ambient),
                    grouped(rays.reflection)
                ),
            ),
            ("speed", format!("{:.2} million rays/s", self.rays_per_s / 1e6)),
            (
                "time",
                format!(
                    "{total:.1} ms: load {load:.1}, build {build:.1}, render {render:.1}, write {write:.1}"
                ),
            ),
            (
                "memory",
                format!(
                    "scene {}, BVH {}",
                    in_bytes(memory.scene as u64),
                    in_bytes(memory.bvh as u64)
                ),
            ),
        ];
        let mut text = String::new();
        for (name, value) in lines
            .into_iter()
            .chain(self.color_by.iter().map(|legend| ("colours", legend.text())))
            .chain(self.aov.iter().flat_map(AovReport::lines))
        {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{name:11} {value}");
        }
        text
    }

    fn picture_text(&self) -> String {
        format!(
            "{}, {}x{}, {}{} {} per pixel, depth {}, shadows {}",
            clip(&self.output),
            self.width,
            self.height,
            if self.adaptive { "up to " } else { "" },
            self.samples,
            if self.samples == 1 { "sample" } else { "samples" },
            self.max_depth,
            if self.shadows { "on" } else { "off" },
        )
    }

    fn traced_by_text(&self) -> String {
        format!(
            "{}, {} build, {}, {} {}",
            self.mode,
            self.build,
            self.isa,
            self.threads,
            if self.threads == 1 { "thread" } else { "threads" }
        )
    }
}

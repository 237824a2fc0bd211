//! What `--stats` prints.

use super::aov::AovReport;
use crate::error::in_bytes;
use serde::Serialize;
use std::fmt::Write;

/// Bumped when a field changes its meaning or goes.
pub const SCHEMA: u32 = 1;

/// The figures of one picture.
#[derive(Debug, Serialize)]
pub struct Report {
    pub schema: u32,
    pub scene: String,
    pub output: String,
    pub width: u32,
    pub height: u32,
    pub samples: u64,
    pub max_depth: u32,
    pub shadows: bool,
    pub mode: &'static str,
    /// Which BVH was built: "fast", "best" or "ploc".
    pub build: &'static str,
    pub isa: &'static str,
    pub threads: usize,
    pub primitives: Primitives,
    pub rays: Rays,
    pub seconds: Seconds,
    /// All rays over the seconds of `render`.
    pub rays_per_s: f64,
    pub memory_bytes: Memory,
    /// Of `--aov`, where it needs words.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub aov: Option<AovReport>,
}

#[derive(Debug, Serialize)]
pub struct Primitives {
    pub triangles: usize,
    pub spheres: usize,
    pub degenerate_triangles: usize,
    /// Not counted in large meshes.
    pub duplicate_triangles: Option<usize>,
    /// Not counted in large meshes.
    pub inverted_triangles: Option<usize>,
}

#[derive(Debug, Serialize)]
pub struct Rays {
    pub camera: u64,
    pub shadow: u64,
    pub reflection: u64,
    pub total: u64,
}

/// Wall-clock times. `total` runs from the start of the program or the end of the picture before, so it is more than the
/// sum. A scene is loaded and built for its first picture.
#[derive(Debug, Serialize)]
pub struct Seconds {
    pub load: f64,
    pub build: f64,
    pub render: f64,
    pub write: f64,
    pub total: f64,
}

#[derive(Debug, Serialize)]
pub struct Memory {
    pub scene: usize,
    pub bvh: usize,
}

impl Report {
    /// One line.
    pub fn json(&self) -> String {
        // Plain structs of numbers and strings always serialize.
        let mut line = serde_json::to_string(self).unwrap_or_default();
        line.push('\n');
        line
    }

    /// A few lines to read.
    pub fn text(&self) -> String {
        let mut text = String::new();
        let ms = |seconds: f64| seconds * 1e3;
        let mut line = |name: &str, value: String| {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{name:11} {value}");
        };
        let Self {
            primitives,
            rays,
            seconds,
            memory_bytes,
            ..
        } = self;
        line("scene", self.scene.clone());
        line(
            "primitives",
            format!(
                "{} triangles ({}), {} spheres",
                grouped(primitives.triangles as u64),
                faults_text(
                    primitives.degenerate_triangles,
                    primitives.duplicate_triangles,
                    primitives.inverted_triangles
                ),
                grouped(primitives.spheres as u64)
            ),
        );
        line(
            "picture",
            format!(
                "{}, {}x{}, {} {} a pixel, depth {}, shadows {}",
                self.output,
                self.width,
                self.height,
                self.samples,
                if self.samples == 1 { "sample" } else { "samples" },
                self.max_depth,
                if self.shadows { "on" } else { "off" },
            ),
        );
        line(
            "traced by",
            format!(
                "{}, {} build, {}, {} {}",
                self.mode,
                self.build,
                self.isa,
                self.threads,
                if self.threads == 1 { "thread" } else { "threads" }
            ),
        );
        line(
            "rays",
            format!(
                "{}: {} camera, {} shadow, {} reflection",
                grouped(rays.total),
                grouped(rays.camera),
                grouped(rays.shadow),
                grouped(rays.reflection)
            ),
        );
        line("speed", format!("{:.2} million rays/s", self.rays_per_s / 1e6));
        line(
            "time",
            format!(
                "{:.1} ms: load {:.1}, build {:.1}, render {:.1}, write {:.1}",
                ms(seconds.total),
                ms(seconds.load),
                ms(seconds.build),
                ms(seconds.render),
                ms(seconds.write)
            ),
        );
        line(
            "memory",
            format!(
                "scene {}, BVH {}",
                in_bytes(memory_bytes.scene as u64),
                in_bytes(memory_bytes.bvh as u64)
            ),
        );
        for (name, value) in self.aov.iter().flat_map(AovReport::lines) {
            line(name, value);
        }
        text
    }
}

/// "1 without area, 2 duplicate, 3 inverted".
pub fn faults_text(degenerate: usize, duplicate: Option<usize>, inverted: Option<usize>) -> String {
    let mut text = format!("{} without area", grouped(degenerate as u64));
    for (count, what) in [(duplicate, "duplicate"), (inverted, "inverted")] {
        if let Some(count) = count {
            text.push_str(&format!(", {} {what}", grouped(count as u64)));
        }
    }
    text
}

/// `1234567` as `1 234 567`.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_readable() {
        assert_eq!(grouped(0), "0");
        assert_eq!(grouped(999), "999");
        assert_eq!(grouped(1000), "1 000");
        assert_eq!(grouped(12_345_678), "12 345 678");
        assert_eq!(in_bytes(1023), "1023 B");
        assert_eq!(in_bytes(1536), "1.5 KiB");
        assert_eq!(in_bytes(3 << 30), "3.0 GiB");
    }
}

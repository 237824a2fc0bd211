//! `octray info`: what a scene holds and what its BVH is made of.

use super::{
    CliError,
    args::InfoArgs,
    report::{SCHEMA, bytes, grouped},
};
use crate::{
    accel::{Bvh, BvhStats},
    format,
    scene::{Material, Scene},
};
use serde::Serialize;
use std::{
    fmt::Write,
    time::{Duration, Instant},
};

/// Prints what is in a scene.
///
/// # Errors
/// [`CliError`].
pub fn run(args: &InfoArgs) -> Result<(), CliError> {
    let start = Instant::now();
    let scene = format::load(&args.scene)?;
    let load_time = start.elapsed();
    let bvh = Bvh::build(&scene);
    let info = Info::new(args.scene.display().to_string(), &scene, bvh.stats(), load_time);
    if args.json {
        // Plain structs of numbers and strings always serialize.
        let mut line = serde_json::to_string(&info).unwrap_or_default();
        line.push('\n');
        super::print(&line)
    } else {
        super::print(&info.text())
    }
}

#[derive(Debug, Serialize)]
struct Info {
    schema: u32,
    scene: String,
    vertices: usize,
    triangles: usize,
    degenerate_triangles: usize,
    spheres: usize,
    lights: usize,
    materials: Vec<MaterialUse>,
    /// None if there are no primitives.
    bounds: Option<Bounds>,
    columns: Vec<Column>,
    scene_bytes: usize,
    load_s: f64,
    bvh: BvhInfo,
}

#[derive(Debug, Serialize)]
struct MaterialUse {
    index: usize,
    kind: &'static str,
    primitives: usize,
}

#[derive(Debug, Serialize)]
struct Bounds {
    lower: [f32; 3],
    upper: [f32; 3],
}

#[derive(Debug, Serialize)]
struct Column {
    name: &'static str,
    length: usize,
    bytes: usize,
}

#[derive(Debug, Serialize)]
struct BvhInfo {
    /// Which was built: "fast" or "best".
    build: &'static str,
    depth: usize,
    nodes: usize,
    triangle_blocks: usize,
    sphere_blocks: usize,
    /// How many leaf blocks hold 1, 2, ... 8 primitives.
    leaf_sizes: [usize; 8],
    /// How many nodes have 1, 2, ... 8 children.
    child_counts: [usize; 8],
    bytes: usize,
    build_s: f64,
}

impl Info {
    fn new(name: String, scene: &Scene, bvh: &BvhStats, load_time: Duration) -> Self {
        let bounds = scene.bounds();
        Self {
            schema: SCHEMA,
            scene: name,
            vertices: scene.vertices().x.len(),
            triangles: scene.triangles().v0.len(),
            degenerate_triangles: scene.degenerate_triangles(),
            spheres: scene.spheres().radius.len(),
            lights: scene.lights().x.len(),
            materials: materials_used(scene),
            bounds: (!bounds.is_empty()).then(|| Bounds {
                lower: bounds.lower.to_array(),
                upper: bounds.upper.to_array(),
            }),
            columns: columns(scene),
            scene_bytes: scene.memory_bytes(),
            load_s: load_time.as_secs_f64(),
            bvh: BvhInfo {
                build: bvh.quality.name(),
                depth: bvh.depth,
                nodes: bvh.nodes,
                triangle_blocks: bvh.triangle_blocks,
                sphere_blocks: bvh.sphere_blocks,
                leaf_sizes: bvh.leaf_sizes,
                child_counts: bvh.child_counts,
                bytes: bvh.memory_bytes,
                build_s: bvh.build_time.as_secs_f64(),
            },
        }
    }

    fn text(&self) -> String {
        let mut text = String::new();
        let mut line = |name: &str, value: String| {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{name:18} {value}");
        };
        let count = |number: usize| grouped(number as u64);
        line("scene", self.scene.clone());
        line("vertices", count(self.vertices));
        line(
            "triangles",
            format!(
                "{} ({} without area)",
                count(self.triangles),
                count(self.degenerate_triangles)
            ),
        );
        line("spheres", count(self.spheres));
        line("lights", count(self.lights));
        for used in &self.materials {
            line(
                &format!("material {}", used.index),
                format!("{}, {} primitives", used.kind, count(used.primitives)),
            );
        }
        match &self.bounds {
            Some(Bounds { lower, upper }) => {
                line("bounds, lower", format!("{} {} {}", lower[0], lower[1], lower[2]));
                line("bounds, upper", format!("{} {} {}", upper[0], upper[1], upper[2]));
            }
            None => line("bounds", "empty".into()),
        }
        line("load time", format!("{:.1} ms", self.load_s * 1e3));
        line("columns", bytes(self.scene_bytes));
        for column in &self.columns {
            line(
                &format!("  {}", column.name),
                format!("{} x {}", count(column.length), bytes_each(column)),
            );
        }
        let bvh = &self.bvh;
        line("BVH", bytes(bvh.bytes));
        line("  build", bvh.build.into());
        line("  build time", format!("{:.1} ms", bvh.build_s * 1e3));
        line("  depth", count(bvh.depth));
        line("  nodes", count(bvh.nodes));
        line("  triangle blocks", count(bvh.triangle_blocks));
        line("  sphere blocks", count(bvh.sphere_blocks));
        line("  leaf sizes 1..8", bvh.leaf_sizes.map(count).join(", "));
        line("  children 1..8", bvh.child_counts.map(count).join(", "));
        text
    }
}

fn bytes_each(column: &Column) -> String {
    format!(
        "{} = {}",
        bytes(column.bytes.checked_div(column.length).unwrap_or(0)),
        bytes(column.bytes)
    )
}

/// The materials that at least one primitive has.
fn materials_used(scene: &Scene) -> Vec<MaterialUse> {
    let mut primitives = vec![0; scene.materials().len()];
    for id in scene.triangles().material.iter().chain(&scene.spheres().material) {
        if let Some(count) = primitives.get_mut(id.0 as usize) {
            *count += 1;
        }
    }
    let kind = |material: &Material| match material {
        Material::Silhouette { .. } => "silhouette",
        Material::Matte { .. } => "matte",
        Material::BlinnPhong { .. } => "Blinn-Phong",
        Material::Reflection { .. } => "reflection",
    };
    scene
        .materials()
        .iter()
        .zip(primitives)
        .enumerate()
        .filter(|&(_, (_, primitives))| primitives > 0)
        .map(|(index, (material, primitives))| MaterialUse {
            index,
            kind: kind(material),
            primitives,
        })
        .collect()
}

/// Every column of the scene that holds something.
fn columns(scene: &Scene) -> Vec<Column> {
    fn column<T>(name: &'static str, column: &[T]) -> Column {
        Column {
            name,
            length: column.len(),
            bytes: size_of_val(column),
        }
    }
    let (v, t, s, l) = (
        scene.vertices(),
        scene.triangles(),
        scene.spheres(),
        scene.lights(),
    );
    let mut columns = vec![
        column("vertex x", &v.x),
        column("vertex y", &v.y),
        column("vertex z", &v.z),
        column("vertex normal", &v.normals),
        column("triangle v0", &t.v0),
        column("triangle v1", &t.v1),
        column("triangle v2", &t.v2),
        column("triangle material", &t.material),
        column("sphere x", &s.center_x),
        column("sphere y", &s.center_y),
        column("sphere z", &s.center_z),
        column("sphere radius", &s.radius),
        column("sphere material", &s.material),
        column("light x", &l.x),
        column("light y", &l.y),
        column("light z", &l.z),
        column("light intensity", &l.intensity),
        column("material", scene.materials()),
    ];
    columns.retain(|column| column.length > 0);
    columns
}

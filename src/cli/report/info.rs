//! The output of `octray info`: the contents of a scene and of its BVH.

use super::{
    SCHEMA,
    bvh::BvhInfo,
    cameras::{AnimationInfo, CameraInfo},
    faults_text, grouped,
    lights::{LightInfo, lights},
    materials::{MaterialUse, materials_used},
    positions::Positions,
    scalars::ScalarInfo,
};
use crate::{
    accel::Bvh,
    error::{clip, in_bytes},
    format::mesh::{MeshAnimation, Scalar},
    scene::{Environment, EnvironmentPicture, Image, MeshFaults, Scene},
};
use serde::Serialize;
use std::{fmt::Write, time::Duration};

/// The most lights, materials, cameras, included files or notes in the text; JSON has all of them.
const MOST_LINES: usize = 6;

/// The contents of a scene and of its BVH.
#[derive(Debug, Serialize)]
pub struct Info {
    schema: u32,
    scene: String,
    vertices: usize,
    triangles: usize,
    degenerate_triangles: usize,
    duplicate_triangles: usize,
    inverted_triangles: usize,
    spheres: usize,
    planes: usize,
    /// Number of prototypes; their primitives are counted above.
    prototypes: usize,
    instances: usize,
    /// Up to the last keyframe; 1 if nothing moves.
    frames: u32,
    keyframes: usize,
    moving_instances: usize,
    moving_cameras: usize,
    /// The animations of a glTF file.
    animations: Vec<AnimationInfo>,
    /// The numbers of vertices and faces of a PLY or glTF file.
    scalars: Vec<ScalarInfo>,
    lights: usize,
    light_list: Vec<LightInfo>,
    materials: Vec<MaterialUse>,
    ambient: f32,
    /// Scene units; null without ambient occlusion.
    ambient_reach: Option<f32>,
    ambient_specular: bool,
    smooth_shadows: bool,
    background: BackgroundInfo,
    cameras: Vec<CameraInfo>,
    /// Included scene files.
    includes: Vec<String>,
    /// What was left out or missing without being an error.
    notes: Vec<String>,
    /// `None` without primitives.
    bounds: Option<Bounds>,
    arrays: Vec<Array>,
    scene_bytes: usize,
    load_s: f64,
    bvh: BvhInfo,
}

/// Bottom and top are equal for a constant background.
#[derive(Debug, Serialize)]
struct BackgroundInfo {
    /// `null` with an environment map.
    bottom: Option<[f32; 3]>,
    top: Option<[f32; 3]>,
    /// Whether it lights the surfaces.
    is_environment: bool,
    /// Width and height of an environment map.
    picture: Option<[u32; 2]>,
    /// Its rotation, degrees.
    rotate: Option<f64>,
    intensity: Option<f32>,
}

#[derive(Debug, Serialize)]
struct Bounds {
    lower: [f64; 3],
    upper: [f64; 3],
}

#[derive(Debug, Serialize)]
struct Array {
    name: &'static str,
    length: usize,
    bytes: usize,
}

impl Info {
    /// The contents of the scene called `name`.
    pub fn new(name: String, scene: &Scene, faults: MeshFaults, bvh: &Bvh, load_time: Duration) -> Self {
        let (bounds, positions) = (scene.bounds(), Positions::of(scene));
        Self {
            schema: SCHEMA,
            scene: name,
            vertices: scene.vertices().x.len(),
            triangles: scene.triangles().corners.len(),
            degenerate_triangles: faults.degenerate,
            duplicate_triangles: faults.duplicate,
            inverted_triangles: faults.inverted,
            spheres: scene.spheres().radius.len(),
            planes: scene.planes().len(),
            prototypes: scene.prototypes().len(),
            instances: scene.instances().len(),
            frames: scene.frame_count(),
            keyframes: scene.keyframe_count(),
            moving_instances: scene.moving_counts()[0],
            moving_cameras: scene.moving_counts()[1],
            animations: Vec::new(),
            scalars: Vec::new(),
            lights: scene.lights().len(),
            light_list: lights(scene),
            materials: materials_used(scene),
            ambient: scene.ambient(),
            ambient_reach: scene.ambient_reach(),
            ambient_specular: scene.ambient_specular(),
            smooth_shadows: scene.smooth_shadows(),
            background: BackgroundInfo::of(scene),
            cameras: scene
                .cameras()
                .iter()
                .chain(scene.mesh_cameras())
                .map(|camera| CameraInfo::new(camera, positions))
                .collect(),
            includes: scene
                .sources()
                .includes
                .iter()
                .map(|path| path.to_string_lossy().into_owned())
                .collect(),
            notes: scene.sources().notes.clone(),
            bounds: (!bounds.is_empty()).then(|| Bounds {
                lower: positions.within(bounds.lower),
                upper: positions.within(bounds.upper),
            }),
            arrays: arrays(scene),
            scene_bytes: scene.memory_bytes(),
            load_s: load_time.as_secs_f64(),
            bvh: BvhInfo::new(bvh),
        }
    }

    /// With the animations of a mesh's file.
    pub fn with_animations(self, animations: Vec<MeshAnimation>) -> Self {
        Self {
            animations: animations.into_iter().map(AnimationInfo::new).collect(),
            ..self
        }
    }

    /// With the numbers of a mesh's file.
    pub(in crate::cli) fn with_scalars(self, scalars: Vec<Scalar>) -> Self {
        Self {
            scalars: scalars.into_iter().map(ScalarInfo::new).collect(),
            ..self
        }
    }

    /// As text, one line for each item.
    pub fn text(&self) -> String {
        let mut lines = self.scene_lines();
        lines.extend(self.memory_lines());
        let mut text = String::new();
        for (name, value) in lines {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{name:18} {value}");
        }
        text
    }

    fn scene_lines(&self) -> Vec<(String, String)> {
        let mut lines = Vec::new();
        let mut line = |name: &str, value: String| lines.push((name.to_owned(), value));
        let faults = faults_text(
            self.degenerate_triangles,
            Some(self.duplicate_triangles),
            Some(self.inverted_triangles),
        );
        line("scene", clip(&self.scene));
        line("vertices", self.colored(self.vertices, "vertex color"));
        line("triangles", format!("{} ({faults})", count(self.triangles)));
        line("spheres", self.colored(self.spheres, "sphere color"));
        if self.planes > 0 {
            line("planes", count(self.planes));
        }
        if self.instances > 0 {
            let (instances, meshes) = (count(self.instances), count(self.prototypes));
            line(
                "instances",
                format!("{instances} of {meshes} meshes, which are counted above"),
            );
        }
        if self.keyframes > 0 {
            line("frames", self.frames_text());
        }
        line("lights", count(self.lights));
        some(&mut lines, "", &self.light_list, LightInfo::text);
        some(&mut lines, "material", &self.materials, MaterialUse::text);
        let mut line = |name: &str, value: String| lines.push((name.to_owned(), value));
        line(
            "ambient",
            match self.ambient_reach {
                Some(reach) => format!("{} reach {reach}", self.ambient),
                None => self.ambient.to_string(),
            },
        );
        for (name, is_on) in [
            ("ambient_specular", self.ambient_specular),
            ("smooth_shadows", self.smooth_shadows),
        ] {
            if is_on {
                line(name, "on".into());
            }
        }
        line("background", self.background.text());
        some(&mut lines, "camera", &self.cameras, CameraInfo::text);
        some(&mut lines, "animation", &self.animations, AnimationInfo::text);
        some(&mut lines, "scalar", &self.scalars, ScalarInfo::text);
        some(&mut lines, "includes", &self.includes, |path| clip(path));
        some(&mut lines, "note", &self.notes, |note| clip(note));
        let mut line = |name: &str, value: String| lines.push((name.to_owned(), value));
        match &self.bounds {
            Some(Bounds { lower, upper }) => {
                line("bounds, lower", list(*lower));
                line("bounds, upper", list(*upper));
            }
            None => line("bounds", "empty".into()),
        }
        line("load time", format!("{:.1} ms", self.load_s * 1e3));
        lines
    }

    /// `48 (5 keyframes move 2 instances and 1 camera)`.
    fn frames_text(&self) -> String {
        let some = |number: usize, what: &str| {
            let plural = if number == 1 { "" } else { "s" };
            (number > 0).then(|| format!("{} {what}{plural}", count(number)))
        };
        let moving = [
            some(self.moving_instances, "instance"),
            some(self.moving_cameras, "camera"),
        ];
        let moving: Vec<String> = moving.into_iter().flatten().collect();
        format!(
            "{} ({} keyframes move {})",
            count(self.frames as usize),
            count(self.keyframes),
            if moving.is_empty() {
                "nothing".to_owned()
            } else {
                moving.join(" and ")
            }
        )
    }

    /// A count, with the remark that there are colours if the scene has an array of that name.
    fn colored(&self, number: usize, array: &str) -> String {
        let has_colors = self.arrays.iter().any(|known| known.name == array);
        let colors = if has_colors { " (with colours)" } else { "" };
        count(number) + colors
    }

    fn memory_lines(&self) -> Vec<(String, String)> {
        let mut lines = Vec::new();
        let mut line = |name: &str, value: String| lines.push((name.to_owned(), value));
        line("arrays", in_bytes(self.scene_bytes as u64));
        for array in &self.arrays {
            line(
                &format!("  {}", array.name),
                format!("{} x {}", count(array.length), bytes_each(array)),
            );
        }
        lines.extend(self.bvh.lines());
        lines
    }
}

/// Adds a line for each of the first items, and one that counts the others.
fn some<T>(lines: &mut Vec<(String, String)>, name: &str, items: &[T], text: impl Fn(&T) -> String) {
    let shown = items.iter().take(MOST_LINES);
    lines.extend(shown.map(|item| (name.to_owned(), text(item))));
    if let more @ 1.. = items.len().saturating_sub(MOST_LINES) {
        lines.push((name.to_owned(), format!("and {} more", count(more))));
    }
}

pub(super) fn count(number: usize) -> String {
    grouped(number as u64)
}

impl BackgroundInfo {
    fn of(scene: &Scene) -> Self {
        let picture = match scene.environment() {
            Some(Environment::Picture(picture)) => Some(picture),
            _ => None,
        };
        let shown = |color| picture.is_none().then_some(color);
        Self {
            bottom: shown(scene.background().bottom),
            top: shown(scene.background().top),
            is_environment: scene.environment().is_some(),
            picture: picture.map(EnvironmentPicture::size),
            rotate: picture.map(EnvironmentPicture::degrees),
            intensity: picture.map(EnvironmentPicture::intensity),
        }
    }

    fn text(&self) -> String {
        let mut text = match (self.picture, self.bottom, self.top) {
            (Some([width, height]), ..) => format!("picture of {width}x{height} pixels"),
            (None, Some(bottom), Some(top)) if bottom != top => {
                format!("bottom {} top {}", list(bottom), list(top))
            }
            (None, _, top) => top.map(list).unwrap_or_default(),
        };
        if let Some(degrees) = self.rotate.filter(|degrees| *degrees != 0.0) {
            text += &format!(", rotate {degrees}");
        }
        if let Some(intensity) = self.intensity.filter(|intensity| *intensity != 1.0) {
            text += &format!(", intensity {intensity}");
        }
        if self.is_environment {
            text += ", lights the scene";
        }
        text
    }
}

/// Three numbers as in a scene file.
pub(super) fn list<T: std::fmt::Display>([a, b, c]: [T; 3]) -> String {
    format!("{a} {b} {c}")
}

fn bytes_each(array: &Array) -> String {
    format!(
        "{} = {}",
        in_bytes(array.bytes.checked_div(array.length).unwrap_or(0) as u64),
        in_bytes(array.bytes as u64)
    )
}

/// All arrays of the scene that are not empty.
fn arrays(scene: &Scene) -> Vec<Array> {
    fn array<T>(name: &'static str, array: &[T]) -> Array {
        Array {
            name,
            length: array.len(),
            bytes: size_of_val(array),
        }
    }
    let (v, t, s) = (scene.vertices(), scene.triangles(), scene.spheres());
    let mut arrays = vec![
        array("vertex x", &v.x),
        array("vertex y", &v.y),
        array("vertex z", &v.z),
        array("vertex normal", &v.normals),
        array("vertex color", &v.colors),
        array("vertex uv", &v.uvs),
        array("vertex tangent", &v.tangents),
        array("triangle corners", &t.corners),
        array("triangle material", &t.material),
        array("sphere x", &s.center_x),
        array("sphere y", &s.center_y),
        array("sphere z", &s.center_z),
        array("sphere radius", &s.radius),
        array("sphere material", &s.material),
        array("sphere color", &s.color),
        array("instance", scene.instances()),
        array("light", scene.lights()),
        array("material", scene.materials()),
    ];
    let sizes = || scene.images().iter().map(Image::size);
    arrays.push(Array {
        name: "image",
        length: scene.images().len(),
        bytes: sizes().map(Image::bytes).sum(),
    });
    arrays.retain(|array| array.length > 0);
    arrays
}

#[cfg(test)]
mod tests;

//! The scenes to measure: the suite, or named files.

use crate::view;
use clap::Args;
use glam::{DQuat, DVec3, Vec3};
use octray::{
    bench::SuiteScene,
    classic,
    format::{self, mesh::MeshFormat},
    math::Aabb,
    scene::{Camera, NamedCamera, Scene, SceneBuilder, TriangleMesh},
};
use std::path::{Path, PathBuf};

/// A scene that can be loaded when its turn comes.
#[derive(Clone, Debug)]
pub enum Source {
    /// A scene or a mesh, of any format that octray reads.
    File(PathBuf),
    /// A file with a name of its own.
    Classic(PathBuf),
    /// A generated scene.
    Generated(SuiteScene),
}

/// A scene and its camera.
pub struct Input {
    pub name: String,
    pub scene: Scene,
    pub camera: Camera,
}

/// The view of named files.
#[derive(Args, Clone, Copy, Debug)]
pub struct View {
    /// Named scenes: a classic viewpoint, 1 to 6
    #[arg(long = "view", value_name = "1..6", value_parser = clap::value_parser!(u32).range(1..=6))]
    viewpoint: Option<u32>,

    /// Named scenes: where the camera stands
    #[arg(long, value_name = "x,y,z", value_parser = vector, allow_hyphen_values = true)]
    eye: Option<DVec3>,

    /// Named scenes: what the camera looks at
    #[arg(long, value_name = "x,y,z", value_parser = vector, allow_hyphen_values = true)]
    target: Option<DVec3>,

    /// Named scenes: vertical field of view, degrees
    #[arg(long, value_name = "DEG", default_value_t = classic::FOV_DEGREES)]
    fov: f64,
}

fn vector(text: &str) -> Result<DVec3, &'static str> {
    view::vector(text).ok_or("expected three numbers, such as 1,2.5,-3")
}

/// The suite of `octray bench --all`, with `blobs` triangles in its blobs. The classic cow replaces the figurine if its
/// file is at hand.
pub fn suite(blobs: usize) -> Vec<Source> {
    let shared = std::env::var_os("OCTRAY_SHARED").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared"),
        PathBuf::from,
    );
    let cow = shared.join("course/framework/cow.scn");
    let source = |scene: SuiteScene| match scene.name {
        "figurine" if cow.is_file() => Source::Classic(cow.clone()),
        "blobs" => Source::Generated(SuiteScene {
            count: blobs,
            ..scene
        }),
        _ => Source::Generated(scene),
    };
    octray::bench::suite().map(source).into()
}

impl Source {
    pub fn name(&self) -> String {
        match self {
            Self::File(path) => path.display().to_string(),
            Self::Classic(path) => path.file_stem().unwrap_or_default().to_string_lossy().into(),
            Self::Generated(scene) => scene.name.into(),
        }
    }

    /// # Errors
    /// If the scene cannot be loaded or seen.
    pub fn load(&self, view: &View) -> Result<Input, String> {
        let (scene, camera) = match self {
            Self::Generated(scene) => scene.make().map_err(text)?,
            Self::Classic(path) => (load_file(path)?.0, classic_camera(1)?),
            Self::File(path) => {
                let (scene, up) = load_file(path)?;
                let camera = view.camera(&scene, up, path)?;
                (scene, camera)
            }
        };
        Ok(Input {
            name: self.name(),
            scene,
            camera,
        })
    }
}

#[expect(clippy::needless_pass_by_value, reason = "map_err passes errors by value")]
fn text(error: impl ToString) -> String {
    error.to_string()
}

fn classic_camera(view: u32) -> Result<Camera, String> {
    Camera::classic_view(view).ok_or_else(|| format!("there is no viewpoint {view}"))
}

fn is_mesh(path: &Path) -> bool {
    MeshFormat::of_path(path).is_some()
}

/// Rotates `direction` as Z must be rotated to become `up`.
fn turned(direction: DVec3, up: DVec3) -> DVec3 {
    DQuat::from_rotation_arc(DVec3::Z, up) * direction
}

/// The scene, and which way is up in it.
fn load_file(path: &Path) -> Result<(Scene, DVec3), String> {
    if !is_mesh(path) {
        let scene = format::load(path).map_err(|error| error.report())?;
        return Ok((scene, classic::UP));
    }
    let mesh = format::mesh::load(path).map_err(|error| error.report())?;
    for note in &mesh.notes {
        eprintln!("{}: {note}", path.display());
    }
    let up = mesh.up.vector();
    let TriangleMesh { x, y, z, .. } = &mesh.columns;
    let corners = (0..x.len()).map(|i| Vec3::new(x[i], y[i], z[i]));
    let bounds = Aabb::around(corners);
    let mut builder = SceneBuilder::new();
    let material = builder.classic_material(1).map_err(text)?;
    if let Some(camera) = mesh.cameras.first() {
        let view = camera.view();
        let camera = Camera::new(&view).map_err(text)?;
        builder.add_camera(NamedCamera { name: None, camera });
    }
    mesh.add_to(&mut builder, Some(material)).map_err(text)?;
    // The two lights of a classic scene, scaled to the mesh.
    let center = (bounds.lower + bounds.upper) * 0.5;
    for (direction, intensity) in [([3.0, -1.5, 3.0], 0.7), ([-3.0, 0.6, 4.5], 0.3)] {
        let direction = turned(DVec3::from(direction), up).as_vec3();
        let position = center + direction * bounds.diagonal();
        builder.add_light(position, intensity).map_err(text)?;
    }
    Ok((builder.finish(), up))
}

impl View {
    /// Without options: the scene's first camera, or the one in the file's comments (`octray generate` writes one), or the
    /// first classic viewpoint if the scene is where classic scenes are, or a view of the whole scene.
    fn camera(&self, scene: &Scene, up: DVec3, path: &Path) -> Result<Camera, String> {
        let classic_eye = classic::viewpoint(self.viewpoint.unwrap_or(1)).unwrap_or(DVec3::X);
        let look = |eye: DVec3, target: DVec3| Camera::look_at(eye, target, up, self.fov).map_err(text);
        if self.viewpoint.is_some() || self.eye.is_some() || self.target.is_some() {
            return look(
                self.eye.unwrap_or(classic_eye),
                self.target.unwrap_or(classic::TARGET),
            );
        }
        if let Some(first) = scene.cameras().first() {
            return Ok(first.camera);
        }
        if !is_mesh(path) {
            let told = std::fs::read_to_string(path)
                .ok()
                .as_deref()
                .and_then(view::told_in);
            if let Some(camera) = told {
                return Ok(camera);
            }
        }
        let bounds = scene.bounds();
        let center = ((bounds.lower + bounds.upper) * 0.5).as_dvec3();
        let size = f64::from(bounds.diagonal());
        let at_home = classic::TARGET.distance(center) < size && (1.0..30.0).contains(&size);
        if at_home && !is_mesh(path) {
            return look(classic_eye, classic::TARGET);
        }
        let away = turned(DVec3::new(1.0, -0.8, 0.6).normalize(), up);
        look(center + away * size * 1.2, center)
    }
}

//! Procedural scenes of any size, for demos, benchmarks and tests.
//!
//! A scene depends on its kind, seed and count alone and is the same on every machine: coordinates are computed with f64
//! `+ - * /`, `sqrt` and `libm`, never with the platform's own trigonometry.
//!
//! ```
//! use octray::generate::{Kind, Options, generate};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let options = Options { seed: 1, count: Some(1000) };
//! let scene = generate(Kind::Flake, options)?.into_scene()?;
//! assert_eq!(scene.spheres().radius.len(), 1000);
//! # Ok(())
//! # }
//! ```

mod blobs;
mod figure;
mod flake;
mod interior;
mod mesh;
mod pipes;
mod random;
mod spheres;
mod terrain;
mod write;

#[cfg(feature = "cli")]
pub(crate) use write::is_generated;
pub use write::write_ply;

use crate::{
    classic,
    error::SceneError,
    scene::{Camera, CameraError, Scene, SceneBuilder, TriangleMesh},
};
use glam::{DVec3, Vec3};
use std::fmt;

/// The kind of a generated scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A sphere flake: spheres on spheres on spheres.
    Flake,
    /// A height field of ridged fractal noise.
    Terrain,
    /// The inside of a hall: columns, curtains, railings, plants.
    Interior,
    /// A ring of finely tessellated, displaced spheres.
    Blobs,
    /// A closed, smooth statue on a slab, as dense as a scan.
    Figure,
    /// A cloud of small spheres.
    Spheres,
    /// Pipes at random angles: long thin triangles.
    Pipes,
}

impl Kind {
    /// All kinds, in the order for users.
    pub const ALL: [Self; 7] = [
        Self::Flake,
        Self::Terrain,
        Self::Interior,
        Self::Blobs,
        Self::Figure,
        Self::Spheres,
        Self::Pipes,
    ];

    /// Returns the name on the command line and of the files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Flake => "flake",
            Self::Terrain => "terrain",
            Self::Interior => "interior",
            Self::Blobs => "blobs",
            Self::Figure => "figure",
            Self::Spheres => "spheres",
            Self::Pipes => "pipes",
        }
    }

    /// Returns a one-line description.
    #[must_use]
    pub fn summary(self) -> &'static str {
        match self {
            Self::Flake => "sphere flake: mirrors on mirrors on mirrors",
            Self::Terrain => "mountains: a height field of fractal noise",
            Self::Interior => "a hall seen from inside: columns, curtains, railings, plants",
            Self::Blobs => "a ring of finely tessellated, displaced spheres",
            Self::Figure => "a smooth statue on a slab, as dense as a scan",
            Self::Spheres => "a cloud of small spheres",
            Self::Pipes => "pipes at all angles: long thin triangles",
        }
    }

    /// Returns the default number of spheres (flake, spheres) or triangles (all others).
    #[must_use]
    pub fn default_count(self) -> usize {
        match self {
            Self::Flake | Self::Spheres => 100_000,
            Self::Terrain | Self::Blobs => 1_000_000,
            Self::Interior => 370_000,
            Self::Figure => 70_000,
            Self::Pipes => 192_000,
        }
    }

    /// Returns the smallest count that still makes the shape.
    #[must_use]
    pub fn min_count(self) -> usize {
        match self {
            Self::Flake | Self::Spheres => 1,
            Self::Terrain => 2,
            Self::Blobs | Self::Figure => 1_000,
            Self::Interior => 20_000,
            Self::Pipes => pipes::TRIANGLES_PER_PIPE,
        }
    }

    /// Checks a number of spheres or triangles.
    ///
    /// # Errors
    /// [`GenerateError::Count`] if it is below [`Self::min_count`] or above [`MAX_COUNT`].
    pub fn check_count(self, count: usize) -> Result<(), GenerateError> {
        if (self.min_count()..=MAX_COUNT).contains(&count) {
            Ok(())
        } else {
            Err(GenerateError::Count {
                kind: self,
                found: count,
            })
        }
    }
}

/// The largest count: vertex indices must fit into the 32-bit `int` of PLY files.
pub const MAX_COUNT: usize = 200_000_000;

/// The parameters of a generated scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// The seed of the random numbers.
    pub seed: u64,
    /// The number of spheres, or the most triangles (meshes come close to it); `None` for [`Kind::default_count`].
    pub count: Option<usize>,
}

/// The reasons for which nothing is generated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GenerateError {
    /// The count is out of range.
    Count {
        /// The kind of scene.
        kind: Kind,
        /// The count asked for.
        found: usize,
    },
}

impl fmt::Display for GenerateError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self::Count { kind, found } = self;
        write!(
            f,
            "a count of {found} for {}, expected {} to {MAX_COUNT}",
            kind.name(),
            kind.min_count()
        )
    }
}

impl std::error::Error for GenerateError {}

/// The view of a generated scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Position of the eye, scene units.
    pub eye: DVec3,
    /// The point to look at, scene units.
    pub target: DVec3,
    /// Vertical field of view, degrees.
    pub fov_degrees: f64,
}

impl View {
    /// Returns the camera of this view; z is up.
    ///
    /// # Errors
    /// [`CameraError`]; never for the views of generated scenes.
    pub fn camera(&self) -> Result<Camera, CameraError> {
        Camera::look_at(self.eye, self.target, classic::UP, self.fov_degrees)
    }
}

/// A point light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Position, scene units.
    pub position: Vec3,
    /// Intensity I_i.
    pub intensity: f32,
}

/// A sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Centre, scene units.
    pub center: Vec3,
    /// Radius, scene units.
    pub radius: f32,
}

/// The geometry of a part.
#[derive(Debug)]
pub enum Shape {
    /// A mesh, written to a file of its own.
    Mesh(TriangleMesh),
    /// Spheres, written as lines of the scene file.
    Spheres(Vec<Sphere>),
}

/// A part of a generated scene with one material.
#[derive(Debug)]
pub struct Part {
    /// The suffix of the mesh file: "" for `KIND.ply`, "floor" for `KIND-floor.ply`.
    pub name: &'static str,
    /// The number of a classic material, 0 to 3.
    pub material: u32,
    /// The geometry.
    pub shape: Shape,
}

/// A generated scene.
#[derive(Debug)]
pub struct Generated {
    /// The kind.
    pub kind: Kind,
    /// The seed.
    pub seed: u64,
    /// The count that was asked for.
    pub count: usize,
    /// The parts, in the order of their primitive ids.
    pub parts: Vec<Part>,
    /// The lights.
    pub lights: Vec<Light>,
    /// The view that shows the scene best.
    pub view: View,
}

/// Generates a scene.
///
/// # Errors
/// As of [`Kind::check_count`].
pub fn generate(kind: Kind, options: Options) -> Result<Generated, GenerateError> {
    let count = options.count.unwrap_or(kind.default_count());
    kind.check_count(count)?;
    let seed = options.seed;
    let Content { parts, lights, view } = match kind {
        Kind::Flake => flake::make(seed, count),
        Kind::Terrain => terrain::make(seed, count),
        Kind::Interior => interior::make(seed, count),
        Kind::Blobs => blobs::make(seed, count),
        Kind::Figure => figure::make(seed, count),
        Kind::Spheres => spheres::make(seed, count),
        Kind::Pipes => pipes::make(seed, count),
    };
    Ok(Generated {
        kind,
        seed,
        count,
        parts,
        lights,
        view,
    })
}

impl Generated {
    /// Builds the scene, the same as the written files give when they are loaded.
    ///
    /// # Errors
    /// [`SceneError`]; never for scenes made by [`generate`].
    pub fn into_scene(self) -> Result<Scene, SceneError> {
        let mut builder = SceneBuilder::new();
        for light in &self.lights {
            builder.add_light(light.position, light.intensity)?;
        }
        for part in self.parts {
            let material = builder.classic_material(part.material)?;
            match part.shape {
                Shape::Mesh(mesh) => builder.add_mesh(mesh, material)?,
                Shape::Spheres(spheres) => {
                    for sphere in spheres {
                        builder.add_sphere(sphere.center, sphere.radius, material)?;
                    }
                }
            }
        }
        Ok(builder.finish())
    }

    /// Returns the file name of a part's mesh; `None` for spheres.
    #[must_use]
    pub fn mesh_file_name(&self, part: &Part) -> Option<String> {
        let kind = self.kind.name();
        match (&part.shape, part.name) {
            (Shape::Spheres(_), _) => None,
            (Shape::Mesh(_), "") => Some(format!("{kind}.ply")),
            (Shape::Mesh(_), name) => Some(format!("{kind}-{name}.ply")),
        }
    }
}

/// The result of a kind's `make`.
struct Content {
    parts: Vec<Part>,
    lights: Vec<Light>,
    view: View,
}

fn light(x: f32, y: f32, z: f32, intensity: f32) -> Light {
    Light {
        position: Vec3::new(x, y, z),
        intensity,
    }
}

/// Returns the lights of classic scenes: a bright one in front, a dim one behind.
fn classic_lights() -> Vec<Light> {
    vec![light(9.0, -4.0, 10.0, 0.7), light(-10.0, 2.0, 15.0, 0.3)]
}

/// Returns a view with the classic field of view.
fn view(eye: [f64; 3], target: [f64; 3]) -> View {
    View {
        eye: eye.into(),
        target: target.into(),
        fov_degrees: classic::FOV_DEGREES,
    }
}

#[cfg(test)]
mod tests;

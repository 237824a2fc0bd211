//! Made-up scenes of any size, the same on every machine: for trying octray out, for benches and for tests.
//!
//! Every kind is a function of a seed and a count alone. Arithmetic that decides a coordinate is f64 `+ - * /`
//! and `sqrt`, or `libm`; nothing is left to the platform's own trigonometry.
//!
//! ```
//! use octray::generate::{Kind, Options, generate};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let options = Options { seed: 1, count: Some(1000) };
//! let generated = generate(Kind::Flake, options)?;
//! let camera = generated.view.camera()?;
//! let scene = generated.into_scene()?;
//! assert_eq!(scene.spheres().radius.len(), 1000);
//! # let _ = camera;
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

pub use write::write_ply;

use crate::{
    classic,
    error::SceneError,
    scene::{Camera, CameraError, MeshColumns, Scene, SceneBuilder},
};
use glam::{DVec3, Vec3};
use std::fmt;

/// What can be generated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A sphere flake: spheres on spheres on spheres.
    Flake,
    /// A height field of ridged fractal noise.
    Terrain,
    /// A hall seen from inside: columns, curtains, railings, plants.
    Interior,
    /// A ring of finely tessellated, displaced spheres.
    Blobs,
    /// A closed, smooth statue on a slab, as dense as a scan.
    Figure,
    /// A cloud of small spheres.
    Spheres,
    /// Pipes at all angles: long thin triangles.
    Pipes,
}

impl Kind {
    /// All kinds, in the order in which they are listed to users.
    pub const ALL: [Self; 7] = [
        Self::Flake,
        Self::Terrain,
        Self::Interior,
        Self::Blobs,
        Self::Figure,
        Self::Spheres,
        Self::Pipes,
    ];

    /// The name on the command line and of the files.
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

    /// One line that says what it is.
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

    /// Spheres (flake, spheres) or triangles (the others) when no count is given.
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

    /// The smallest count that still makes the shape.
    #[must_use]
    pub fn least_count(self) -> usize {
        match self {
            Self::Flake | Self::Spheres => 1,
            Self::Terrain => 2,
            Self::Blobs | Self::Figure => 1_000,
            Self::Interior => 20_000,
            Self::Pipes => pipes::PIPE,
        }
    }
}

/// The largest count: below it, every vertex index fits the PLY files' 32-bit `int`.
pub const MAX_COUNT: usize = 200_000_000;

/// What may be chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// Another seed, another scene of the same kind.
    pub seed: u64,
    /// How many spheres or triangles: exactly so many spheres; meshes come close and do not exceed it.
    /// `None` for [`Kind::default_count`].
    pub count: Option<usize>,
}

/// Why nothing was generated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GenerateError {
    /// The count is out of its limits.
    Count {
        /// What was to be generated.
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
            kind.least_count()
        )
    }
}

impl std::error::Error for GenerateError {}

/// Where to look at a generated scene from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Where the eye stands, scene units.
    pub eye: DVec3,
    /// What it looks at, scene units.
    pub target: DVec3,
    /// Vertical field of view, degrees.
    pub fov_degrees: f64,
}

impl View {
    /// The camera of this view, z up.
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
    /// Where it is, scene units.
    pub position: Vec3,
    /// Its intensity I_i.
    pub intensity: f32,
}

/// A sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Its centre, scene units.
    pub center: Vec3,
    /// Its radius, scene units.
    pub radius: f32,
}

/// What a part is made of.
#[derive(Debug)]
pub enum Shape {
    /// A mesh, in a file of its own when written.
    Mesh(MeshColumns),
    /// Spheres, written as lines of the scene file.
    Balls(Vec<Ball>),
}

/// A piece of a generated scene with one material.
#[derive(Debug)]
pub struct Part {
    /// Distinguishes the mesh files of one scene: "" for `KIND.ply`, "floor" for `KIND-floor.ply`.
    pub name: &'static str,
    /// The number of a classic material, 0 to 3.
    pub material: u32,
    /// What it is made of.
    pub shape: Shape,
}

/// A generated scene, in memory.
#[derive(Debug)]
pub struct Generated {
    /// What it is.
    pub kind: Kind,
    /// The seed that it was made from.
    pub seed: u64,
    /// The count that was asked for.
    pub count: usize,
    /// Its pieces, in the order in which their primitives are numbered.
    pub parts: Vec<Part>,
    /// Its lights.
    pub lights: Vec<Light>,
    /// Where to look at it from.
    pub view: View,
}

/// Generates a scene.
///
/// # Errors
/// [`GenerateError::Count`], if the count is below [`Kind::least_count`] or above [`MAX_COUNT`].
pub fn generate(kind: Kind, options: Options) -> Result<Generated, GenerateError> {
    let count = options.count.unwrap_or(kind.default_count());
    if !(kind.least_count()..=MAX_COUNT).contains(&count) {
        return Err(GenerateError::Count { kind, found: count });
    }
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
    /// Builds the scene. The same columns as loading the written files gives.
    ///
    /// # Errors
    /// [`SceneError`]; never for what [`generate`] made.
    pub fn into_scene(self) -> Result<Scene, SceneError> {
        let mut builder = SceneBuilder::new();
        for light in &self.lights {
            builder.add_light(light.position, light.intensity)?;
        }
        for part in self.parts {
            let material = builder.classic_material(part.material)?;
            match part.shape {
                Shape::Mesh(mesh) => builder.add_mesh(mesh, material)?,
                Shape::Balls(balls) => {
                    for ball in balls {
                        builder.add_sphere(ball.center, ball.radius, material)?;
                    }
                }
            }
        }
        Ok(builder.finish())
    }

    /// The file name of a part's mesh; `None` for spheres.
    #[must_use]
    pub fn mesh_file_name(&self, part: &Part) -> Option<String> {
        let kind = self.kind.name();
        match (&part.shape, part.name) {
            (Shape::Balls(_), _) => None,
            (Shape::Mesh(_), "") => Some(format!("{kind}.ply")),
            (Shape::Mesh(_), name) => Some(format!("{kind}-{name}.ply")),
        }
    }
}

/// What each kind's own file makes.
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

/// The two lights of the course's scenes: one in front, bright; one behind, dim.
fn classic_lights() -> Vec<Light> {
    vec![light(9.0, -4.0, 10.0, 0.7), light(-10.0, 2.0, 15.0, 0.3)]
}

/// A view of the course's field of view.
fn view(eye: [f64; 3], target: [f64; 3]) -> View {
    View {
        eye: eye.into(),
        target: target.into(),
        fov_degrees: classic::FOV_DEGREES,
    }
}

#[cfg(test)]
mod tests;

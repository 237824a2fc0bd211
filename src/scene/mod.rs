//! A scene as columns: built and validated once by [`SceneBuilder`], immutable after.

mod background;
mod builder;
mod camera;
mod faults;
mod fit;
mod material;
mod origin;
mod smooth;
mod transform;
mod weld;

pub use background::Background;
pub(crate) use builder::check_memory;
pub use builder::{BVH_BYTES, MAX_LIGHTS, MeshColumns, SceneBuilder};
pub use camera::{Camera, CameraError, NamedCamera, PixelRays, View, for_each_packet};
pub use faults::MeshFaults;
pub use fit::{Fit, FitView};
pub use material::{MAX_ALPHA, Material};
pub use transform::Transform;
#[cfg(feature = "viewer")]
pub(crate) use weld::first_at_place;

use crate::{math::Aabb, ray::PrimitiveId};
use glam::Vec3;
use std::path::PathBuf;

/// The largest absolute coordinate, radius or intensity that a scene may hold: the kernels take products of up
/// to four differences of coordinates, which must stay finite in `f32`.
pub const MAX_COORDINATE: f32 = 1e9;

/// Whether a scene may hold this coordinate. False for NaN.
#[inline]
#[must_use]
pub fn is_usable(value: f32) -> bool {
    value.abs() <= MAX_COORDINATE
}

/// An index into [`Scene::materials`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct MaterialId(pub u32);

/// Vertices, shared by the triangles of a mesh. Columns of equal length.
#[derive(Debug, Default)]
pub struct Vertices {
    /// Position, relative to [`Scene::origin`], scene units.
    pub x: Vec<f32>,
    /// Position, relative to [`Scene::origin`], scene units.
    pub y: Vec<f32>,
    /// Position, relative to [`Scene::origin`], scene units.
    pub z: Vec<f32>,
    /// Vertex normals (not necessarily unit length; zero where a vertex has none). Empty if no vertex of
    /// the scene has one, else as long as the positions.
    pub normals: Vec<Vec3>,
}

impl Vertices {
    /// Position of vertex `i`.
    #[inline]
    #[must_use]
    pub fn position(&self, i: u32) -> Vec3 {
        let i = i as usize;
        Vec3::new(self.x[i], self.y[i], self.z[i])
    }
}

/// Triangles. Columns of equal length.
#[derive(Debug, Default)]
pub struct Triangles {
    /// Three indices into [`Vertices`]: one column, because they are always asked for together and, when rays hit or the
    /// BVH is written, in no order. It is also the column that mesh files are read into.
    pub corners: Vec<[u32; 3]>,
    /// Material of each triangle.
    pub material: Vec<MaterialId>,
}

/// Spheres. Columns of equal length.
#[derive(Debug, Default)]
pub struct Spheres {
    /// Centre, relative to [`Scene::origin`], scene units.
    pub center_x: Vec<f32>,
    /// Centre, relative to [`Scene::origin`], scene units.
    pub center_y: Vec<f32>,
    /// Centre, relative to [`Scene::origin`], scene units.
    pub center_z: Vec<f32>,
    /// Radius, scene units, above 0.
    pub radius: Vec<f32>,
    /// Material of each sphere.
    pub material: Vec<MaterialId>,
}

impl Spheres {
    /// Centre of sphere `i`.
    #[inline]
    #[must_use]
    pub fn center(&self, i: usize) -> Vec3 {
        Vec3::new(self.center_x[i], self.center_y[i], self.center_z[i])
    }
}

/// Point lights. Columns of equal length.
#[derive(Debug, Default)]
pub struct Lights {
    /// Position, relative to [`Scene::origin`], scene units.
    pub x: Vec<f32>,
    /// Position, relative to [`Scene::origin`], scene units.
    pub y: Vec<f32>,
    /// Position, relative to [`Scene::origin`], scene units.
    pub z: Vec<f32>,
    /// Intensity I_i; it does not fall off with distance.
    pub intensity: Vec<f32>,
    /// Colour, linear RGB from 0 to 1; white unless a scene says otherwise.
    pub color: Vec<[f32; 3]>,
}

impl Lights {
    /// Position of light `i`.
    #[inline]
    #[must_use]
    pub fn position(&self, i: usize) -> Vec3 {
        Vec3::new(self.x[i], self.y[i], self.z[i])
    }

    /// Intensity of light `i` in each channel: its intensity times its colour.
    #[inline]
    #[must_use]
    pub fn power(&self, i: usize) -> [f32; 3] {
        self.color[i].map(|channel| self.intensity[i] * channel)
    }
}

/// Where a scene comes from, for those who ask what is in it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Sources {
    /// The scene files that it includes, in the order in which they are read, each time anew.
    pub includes: Vec<PathBuf>,
    /// What was left out or missing and is no error, a sentence each.
    pub notes: Vec<String>,
}

/// A finished scene: immutable columns. Primitive ids count the triangles first, then the spheres.
///
/// Positions in its columns, and so rays and hits, are relative to [`Scene::origin`].
#[derive(Debug)]
pub struct Scene {
    vertices: Vertices,
    triangles: Triangles,
    spheres: Spheres,
    lights: Lights,
    materials: Vec<Material>,
    ambient: f32,
    background: Background,
    cameras: Vec<NamedCamera>,
    mesh_cameras: Vec<NamedCamera>,
    sources: Sources,
    origin: Vec3,
    bounds: Aabb,
    degenerate: usize,
}

impl Scene {
    /// The vertices of all meshes.
    #[must_use]
    pub fn vertices(&self) -> &Vertices {
        &self.vertices
    }

    /// The triangles of all meshes, in the order in which they were added.
    #[must_use]
    pub fn triangles(&self) -> &Triangles {
        &self.triangles
    }

    /// The spheres, in the order in which they were added.
    #[must_use]
    pub fn spheres(&self) -> &Spheres {
        &self.spheres
    }

    /// The lights, in the order in which they were added.
    #[must_use]
    pub fn lights(&self) -> &Lights {
        &self.lights
    }

    /// The materials that [`MaterialId`]s index.
    #[must_use]
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// Ambient light I_a.
    #[must_use]
    pub fn ambient(&self) -> f32 {
        self.ambient
    }

    /// Colour of a ray that hits nothing.
    #[must_use]
    pub fn background(&self) -> Background {
        self.background
    }

    /// Puts another scene's lights in the place of this one's.
    pub fn take_lights(&mut self, other: Self) {
        self.lights = other.lights;
        self.lights.translate(other.origin - self.origin);
    }

    /// Where the origin of all positions in the columns is, as positions were given: 0 in each axis unless the scene is
    /// further away from there than it is long. It is near there then, because what is computed from large coordinates
    /// is rounded in large steps: where rays start, above all.
    #[must_use]
    pub fn origin(&self) -> Vec3 {
        self.origin
    }

    /// The scene's own cameras, in the order in which they were added. The first is the one that it is meant to be
    /// seen by.
    #[must_use]
    pub fn cameras(&self) -> &[NamedCamera] {
        &self.cameras
    }

    /// The cameras of the scene's meshes, where those stand: to choose from, the scene's own come first.
    #[must_use]
    pub fn mesh_cameras(&self) -> &[NamedCamera] {
        &self.mesh_cameras
    }

    /// Where the scene comes from.
    #[must_use]
    pub fn sources(&self) -> &Sources {
        &self.sources
    }

    /// The smallest box around all primitives, as positions were given, not relative to [`Scene::origin`]; empty if there
    /// are none.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// How many triangles have no area; no ray ever hits them.
    #[must_use]
    pub fn degenerate_triangles(&self) -> usize {
        self.degenerate
    }

    /// Triangles and spheres together.
    #[must_use]
    pub fn primitive_count(&self) -> usize {
        self.triangles.corners.len() + self.spheres.radius.len()
    }

    /// The three corners of triangle `i`.
    #[inline]
    #[must_use]
    pub fn triangle(&self, i: usize) -> [Vec3; 3] {
        self.triangles.corners[i].map(|v| self.vertices.position(v))
    }

    /// What a primitive id stands for.
    #[inline]
    #[must_use]
    pub fn primitive(&self, id: PrimitiveId) -> Primitive {
        let i = id.0 as usize;
        match i.checked_sub(self.triangles.corners.len()) {
            None => Primitive::Triangle(i),
            Some(sphere_i) => Primitive::Sphere(sphere_i),
        }
    }

    /// The shape of a primitive.
    #[inline]
    #[must_use]
    pub fn shape(&self, id: PrimitiveId) -> Shape {
        match self.primitive(id) {
            Primitive::Triangle(i) => Shape::Triangle(self.triangle(i)),
            Primitive::Sphere(i) => Shape::Sphere(self.spheres.center(i), self.spheres.radius[i]),
        }
    }

    /// The smallest box around sphere `i`, from its rounded extremes.
    #[inline]
    #[must_use]
    pub fn sphere_bounds(&self, i: usize) -> Aabb {
        let (center, radius) = (self.spheres.center(i), Vec3::splat(self.spheres.radius[i]));
        Aabb {
            lower: center - radius,
            upper: center + radius,
        }
    }

    /// Whether triangle `i` has an area; no ray ever hits one that has none.
    #[inline]
    #[must_use]
    pub fn has_area(&self, i: usize) -> bool {
        builder::has_area(self.triangle(i))
    }

    /// The material of a primitive.
    #[inline]
    #[must_use]
    pub fn material_of(&self, id: PrimitiveId) -> MaterialId {
        match self.primitive(id) {
            Primitive::Triangle(i) => self.triangles.material[i],
            Primitive::Sphere(i) => self.spheres.material[i],
        }
    }

    /// Bytes that the columns take.
    #[must_use]
    pub fn memory_bytes(&self) -> usize {
        fn bytes<T>(column: &[T]) -> usize {
            std::mem::size_of_val(column)
        }
        let (v, t, s, l) = (&self.vertices, &self.triangles, &self.spheres, &self.lights);
        [
            &v.x,
            &v.y,
            &v.z,
            &s.center_x,
            &s.center_y,
            &s.center_z,
            &s.radius,
            &l.x,
            &l.y,
            &l.z,
            &l.intensity,
        ]
        .iter()
        .map(|c| bytes(c))
        .sum::<usize>()
            + bytes(&t.corners)
            + bytes(&v.normals)
            + bytes(&l.color)
            + bytes(&t.material)
            + bytes(&s.material)
            + bytes(&self.materials)
    }
}

/// The shape of a primitive, out of the columns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// Three corners, scene units.
    Triangle([Vec3; 3]),
    /// Centre and radius, scene units.
    Sphere(Vec3, f32),
}

impl Shape {
    /// The shape's numbers as bits, after a 0 for triangles and a 1 for spheres: equal for shapes that are
    /// the same bit for bit (unlike `==` this tells 0 from -0).
    #[must_use]
    pub fn bits(&self) -> [u32; 10] {
        match self {
            Self::Triangle([a, b, c]) => [0.0, a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z].map(f32::to_bits),
            Self::Sphere(c, radius) => {
                [1.0, c.x, c.y, c.z, *radius, 0.0, 0.0, 0.0, 0.0, 0.0].map(f32::to_bits)
            }
        }
    }
}

/// A primitive, by its index in its own columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Primitive {
    /// Index into [`Scene::triangles`].
    Triangle(usize),
    /// Index into [`Scene::spheres`].
    Sphere(usize),
}

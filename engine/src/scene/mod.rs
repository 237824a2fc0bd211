//! Scenes as structures of arrays: built and validated by [`SceneBuilder`], immutable afterwards.

mod background;
mod builder;
mod camera;
mod checker;
mod distortion;
mod edges;
mod environment;
mod faults;
mod fit;
mod image;
mod image_plane;
mod instance;
mod lift;
mod light;
mod material;
mod motion;
mod moving;
mod normal_map;
mod occlusion_map;
mod one_sided;
mod opacity;
mod origin;
mod passage;
mod pixel_rays;
mod placed;
mod plane;
mod smooth;
mod texture;
mod transform;
mod view;
mod weld;

pub use crate::ray::SceneHit;
pub use background::Background;
pub use builder::{BVH_BYTES, MAX_LIGHTS, SceneBuilder, SphereCloud, TriangleMesh};
pub use camera::{Camera, MAX_SIDE_SAMPLES, NamedCamera, for_each_packet};
pub use checker::Checker;
pub use distortion::Distortion;
pub use environment::{Environment, EnvironmentPicture, MAX_ENVIRONMENT_SIDE};
pub use faults::MeshFaults;
pub use fit::{Fit, FitView};
pub use image::{Curve, Image, MAX_IMAGE_SIDE, Texture, Wrap};
pub use image_plane::{ImagePlane, Intrinsics};
pub(crate) use instance::{ImageRay, Placement};
pub use instance::{Instance, MAX_INSTANCES, MAX_PROTOTYPES, Prototype, PrototypeId};
pub(crate) use lift::Base;
pub use light::{Light, LightShape, Spot};
pub(crate) use material::{AMBIENT_SPECULAR, MOST_POLISH};
pub use material::{INDEX_RANGE, MAX_ALPHA, Material};
pub use motion::{CameraMotion, MAX_KEYFRAMES, MAX_STEPS, MAX_TIME, Motion, Step, slerp};
use moving::Moving;
pub use normal_map::{MAX_NORMAL_SCALE, NormalMap};
pub use occlusion_map::OcclusionMap;
pub use opacity::Opacity;
pub(crate) use passage::{Crossing, Passage, skipped};
pub use pixel_rays::RayCone;
pub use placed::PlacedMesh;
pub use plane::{MAX_PLANES, Plane};
pub use texture::{CutOut, MAX_EMISSION, SurfaceTextures, TexturePoint, TexturedPoint};
pub use transform::Transform;
pub use view::{CameraError, Lens, Projection, View};
#[doc(hidden)]
pub use {
    builder::{INSTANCE_BYTES, MAX_MATERIALS, MAX_TEXTURES, check_memory},
    edges::{EdgeLines, TriangleEdges},
    instance::Placing,
    origin::origin_of,
    pixel_rays::PixelRays,
    weld::weld,
};

use crate::{math::Aabb, ray::PrimitiveId};
use glam::{DVec3, Vec3};
use std::{
    collections::BTreeSet,
    ops::Range,
    path::PathBuf,
    sync::{Arc, atomic},
};

/// The largest absolute coordinate, radius or intensity of a scene. The kernels multiply up to four differences of
/// coordinates, which must stay finite in `f32`.
pub const MAX_COORDINATE: f32 = 1e9;

/// Returns whether a coordinate is within [`MAX_COORDINATE`]; false for NaN.
#[inline]
#[must_use]
pub fn is_usable(value: f32) -> bool {
    value.abs() <= MAX_COORDINATE
}

/// An index into [`Scene::materials`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct MaterialId(pub u32);

/// The vertices of all meshes: arrays of equal length.
#[derive(Debug, Default)]
pub struct Vertices {
    /// Position, relative to [`Scene::origin`], scene units.
    pub x: Vec<f32>,
    /// Position, relative to [`Scene::origin`], scene units.
    pub y: Vec<f32>,
    /// Position, relative to [`Scene::origin`], scene units.
    pub z: Vec<f32>,
    /// Vertex normals of any length, zero where a vertex has none. Empty if no vertex has one.
    pub normals: Vec<Vec3>,
    /// Base colours from 0 to 1, as linear as those of materials, which they multiply; white
    /// where a vertex has none. Empty if no vertex has one.
    pub colors: Vec<[f32; 3]>,
    /// Texture coordinates: 0, 0 is the upper left corner of an image, 1, 1 the lower right one; 0, 0 where a vertex has
    /// none. Empty if no vertex has any.
    pub uvs: Vec<[f32; 2]>,
    /// Tangents, as [`TriangleMesh::tangents`]; zero where a vertex has none. Empty if no vertex has one.
    pub tangents: Vec<[f32; 4]>,
}

impl Vertices {
    /// Returns the position of vertex `i`.
    #[inline]
    #[must_use]
    pub fn position(&self, i: u32) -> Vec3 {
        let i = i as usize;
        Vec3::new(self.x[i], self.y[i], self.z[i])
    }
}

/// The triangles of all meshes: arrays of equal length.
#[derive(Debug, Default)]
pub struct Triangles {
    /// Three indices into [`Vertices`]. One array, because they are always read together and in random order.
    pub corners: Vec<[u32; 3]>,
    /// Material of each triangle.
    pub material: Vec<MaterialId>,
    /// See [`SceneBuilder::add_mesh_without_edges`]; by index, in ascending order.
    edgeless: Vec<Range<u32>>,
}

/// The spheres: arrays of equal length.
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
    /// Base colours, as [`Vertices::colors`]. Empty if no sphere has one.
    pub color: Vec<[f32; 3]>,
}

impl Spheres {
    /// Returns the centre of sphere `i`.
    #[inline]
    #[must_use]
    pub fn center(&self, i: usize) -> Vec3 {
        Vec3::new(self.center_x[i], self.center_y[i], self.center_z[i])
    }
}

/// The files that a scene was read from, and notes about them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Sources {
    /// Included scene files in the order of reading, one entry for each inclusion.
    pub includes: Vec<PathBuf>,
    /// Files of textures that the meshes name, read or not.
    pub textures: BTreeSet<PathBuf>,
    /// What was ignored or missing without being an error, a sentence each.
    pub notes: Vec<String>,
}

/// A finished, immutable scene. Primitive ids count the triangles first, then the spheres, then the planes.
///
/// Positions in its arrays, and so rays and hits, are relative to [`Scene::origin`], except those of its
/// [prototypes](Scene::prototypes).
#[derive(Debug)]
pub struct Scene {
    // Shared by scenes that differ in their instances only.
    vertices: Arc<Vertices>,
    triangles: Arc<Triangles>,
    spheres: Arc<Spheres>,
    planes: Vec<Plane>,
    prototypes: Vec<Prototype>,
    instances: Vec<Instance>,
    lights: Vec<Light>,
    materials: Vec<Material>,
    /// By material; empty if none has any.
    textures: Vec<Option<SurfaceTextures>>,
    /// By material, up to the last one that is; empty if none is.
    one_sided: Vec<bool>,
    images: Vec<Image>,
    has_cut_outs: bool,
    has_blending: bool,
    has_glass: bool,
    ambient: f32,
    ambient_reach: Option<f32>,
    smooth_shadows: bool,
    ambient_specular: bool,
    background: Background,
    environment: Option<Environment>,
    cameras: Vec<NamedCamera>,
    mesh_cameras: Vec<NamedCamera>,
    sources: Sources,
    offset: DVec3,
    origin: Vec3,
    bounds: Aabb,
    degenerate: usize,
    id: SceneId,
    moving: Moving,
}

/// Identifies a scene: only clones share an id.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SceneId(u64);

impl SceneId {
    pub(crate) fn next() -> Self {
        static NEXT: atomic::AtomicU64 = atomic::AtomicU64::new(0);
        Self(NEXT.fetch_add(1, atomic::Ordering::Relaxed))
    }
}

impl Scene {
    pub(crate) fn id(&self) -> SceneId {
        self.id
    }

    /// The id of the meshes, which do not move.
    pub(crate) fn meshes_id(&self) -> SceneId {
        self.moving.meshes
    }

    /// Returns the vertices of all meshes.
    #[must_use]
    pub fn vertices(&self) -> &Vertices {
        &self.vertices
    }

    /// Returns the triangles of all meshes, in the order of their addition.
    #[must_use]
    pub fn triangles(&self) -> &Triangles {
        &self.triangles
    }

    /// Returns the spheres, in the order of their addition.
    #[must_use]
    pub fn spheres(&self) -> &Spheres {
        &self.spheres
    }

    /// Returns the lights, in the order of their addition.
    #[must_use]
    pub fn lights(&self) -> &[Light] {
        &self.lights
    }

    /// Returns the materials that [`MaterialId`]s index.
    #[must_use]
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// Returns the ambient light I_a.
    #[must_use]
    pub fn ambient(&self) -> f32 {
        self.ambient
    }

    /// Returns the distance within which other surfaces block ambient light, scene units; `None` if it reaches every
    /// surface.
    #[must_use]
    pub fn ambient_reach(&self) -> Option<f32> {
        self.ambient_reach
    }

    /// Returns whether colours are means over random directions: of soft lights, of the environment, or of ambient occlusion.
    #[must_use]
    pub fn is_sampled(&self) -> bool {
        self.ambient_reach.is_some()
            || self.environment.is_some()
            || self.lights.iter().any(|light| light.shape.is_soft())
    }

    /// Returns the background.
    #[must_use]
    pub fn background(&self) -> Background {
        self.background
    }

    /// Returns the environment, if it lights the scene.
    #[inline]
    #[must_use]
    pub fn environment(&self) -> Option<&Environment> {
        self.environment.as_ref()
    }

    /// Returns the light to which each sample is clamped: 1, or none with an environment or a soft light with falloff, whose
    /// samples are right only in the mean.
    #[inline]
    pub(crate) fn most_light(&self) -> f32 {
        let is_uneven = |light: &Light| light.falloff.is_some() && light.shape.is_soft();
        if self.environment.is_some() || self.lights.iter().any(is_uneven) {
            f32::MAX
        } else {
            1.0
        }
    }

    /// Returns the number of rays per point to the environment: two if it has suns.
    #[inline]
    #[doc(hidden)]
    pub fn environment_rays(&self) -> usize {
        (self.environment.as_ref()).map_or(0, |environment| 1 + usize::from(environment.has_suns()))
    }

    /// Returns the number of random points per depth: for ambient light, for each light and for the environment.
    #[inline]
    pub(crate) fn draws_per_depth(&self) -> usize {
        1 + self.lights.len() + self.environment_rays()
    }

    /// Returns the scene's own cameras, in the order of their addition; the first is the default view.
    #[must_use]
    pub fn cameras(&self) -> &[NamedCamera] {
        &self.cameras
    }

    /// Returns the cameras that the scene's mesh files define, in world space; none of them is a default view.
    #[must_use]
    pub fn mesh_cameras(&self) -> &[NamedCamera] {
        &self.mesh_cameras
    }

    /// Returns the files that the scene was read from, and notes about them.
    #[must_use]
    pub fn sources(&self) -> &Sources {
        &self.sources
    }

    /// Returns the bounding box of all triangles, spheres and instances in world space, less [`Scene::offset`] but not
    /// relative to [`Scene::origin`]; empty without any.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Returns the number of triangles without area; no ray ever hits them.
    #[must_use]
    pub fn degenerate_triangles(&self) -> usize {
        self.degenerate
    }

    /// Returns whether vertices or spheres have colours.
    #[inline]
    #[must_use]
    pub fn has_colors(&self) -> bool {
        !self.vertices.colors.is_empty() || !self.spheres.color.is_empty()
    }

    /// Returns the number of triangles and spheres, those of prototypes included.
    #[must_use]
    pub fn primitive_count(&self) -> usize {
        self.triangles.corners.len() + self.spheres.radius.len()
    }

    /// Returns the three corners of triangle `i`.
    #[inline]
    #[must_use]
    pub fn triangle(&self, i: usize) -> [Vec3; 3] {
        let [a, b, c] = self.triangles.corners[i];
        let vertices = &self.vertices;
        [vertices.position(a), vertices.position(b), vertices.position(c)]
    }

    /// Returns the primitive with this id.
    #[inline]
    #[must_use]
    pub fn primitive(&self, id: PrimitiveId) -> Primitive {
        let i = id.0 as usize;
        match i.checked_sub(self.triangles.corners.len()) {
            None => Primitive::Triangle(i),
            Some(sphere_i) => match sphere_i.checked_sub(self.spheres.radius.len()) {
                None => Primitive::Sphere(sphere_i),
                Some(plane_i) => Primitive::Plane(plane_i),
            },
        }
    }

    /// Returns the shape of a triangle or sphere.
    ///
    /// # Panics
    /// For the id of a plane.
    #[inline]
    #[must_use]
    pub fn shape(&self, id: PrimitiveId) -> Shape {
        let i = id.0 as usize;
        match i.checked_sub(self.triangles.corners.len()) {
            None => Shape::Triangle(self.triangle(i)),
            Some(i) => Shape::Sphere(self.spheres.center(i), self.spheres.radius[i]),
        }
    }

    /// Returns the bounding box of sphere `i`, rounded to nearest.
    #[inline]
    #[must_use]
    pub fn sphere_bounds(&self, i: usize) -> Aabb {
        let (center, radius) = (self.spheres.center(i), Vec3::splat(self.spheres.radius[i]));
        Aabb {
            lower: center - radius,
            upper: center + radius,
        }
    }

    /// Returns whether triangle `i` has an area; no ray ever hits one without.
    #[inline]
    #[must_use]
    pub fn has_area(&self, i: usize) -> bool {
        builder::has_area(self.triangle(i))
    }

    /// Returns the material of a primitive.
    #[inline]
    #[must_use]
    pub fn material_of(&self, id: PrimitiveId) -> MaterialId {
        match self.primitive(id) {
            Primitive::Triangle(i) => self.triangles.material[i],
            Primitive::Sphere(i) => self.spheres.material[i],
            Primitive::Plane(i) => self.planes[i].material,
        }
    }

    /// Returns the size of all arrays, bytes.
    #[must_use]
    pub fn memory_bytes(&self) -> usize {
        use std::mem::size_of_val as bytes;
        let (v, t, s) = (&self.vertices, &self.triangles, &self.spheres);
        [&v.x, &v.y, &v.z, &s.center_x, &s.center_y, &s.center_z, &s.radius]
            .iter()
            .map(|c| bytes(&c[..]))
            .sum::<usize>()
            + bytes(&t.corners[..])
            + bytes(&v.normals[..])
            + bytes(&v.colors[..])
            + bytes(&v.uvs[..])
            + bytes(&v.tangents[..])
            + self
                .images
                .iter()
                .map(|image| Image::bytes(image.size()))
                .sum::<usize>()
            + bytes(&self.textures[..])
            + bytes(&s.color[..])
            + bytes(&self.lights[..])
            + self.environment.as_ref().map_or(0, Environment::memory_bytes)
            + bytes(&t.material[..])
            + bytes(&s.material[..])
            + bytes(&self.materials[..])
            + bytes(&self.prototypes[..])
            + bytes(&self.instances[..])
            + self.moving.bytes()
    }
}

/// The shape of a primitive, relative to [`Scene::origin`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// Three corners, scene units.
    Triangle([Vec3; 3]),
    /// Centre and radius, scene units.
    Sphere(Vec3, f32),
}

impl Shape {
    /// Returns the coordinates as bits: equal for shapes that are the same bit for bit, with 0 and -0 apart.
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

/// A primitive, by its index among those of its kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Primitive {
    /// Index into [`Scene::triangles`].
    Triangle(usize),
    /// Index into [`Scene::spheres`].
    Sphere(usize),
    /// Index into [`Scene::planes`].
    Plane(usize),
}

//! The scene builder: rejects what cannot be rendered, so that no later layer meets a NaN, an index out of range or a
//! radius of 0.

mod instances;
mod lights;
mod memory;
mod mesh;
mod offset;
mod spheres;
mod textures;

pub use instances::INSTANCE_BYTES;
pub use memory::{BVH_BYTES, check_memory};
pub use mesh::TriangleMesh;
pub use spheres::SphereCloud;
pub(super) use {instances::bounds as placed_bounds, mesh::expect_length};

use super::{
    Background, Environment, Image, Light, MAX_PLANES, Material, MaterialId, NamedCamera, Plane, Prototype,
    Scene, SceneId, Sources, Spheres, SurfaceTextures, Triangles, Vertices, instance::Unplaced, is_usable,
    material::check_color, moving::Moving,
};
use crate::{
    classic,
    error::SceneError,
    math::{Aabb, expansion::Expansion},
};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::{collections::HashMap, ops::Range, path::PathBuf};

/// The most primitives and the most vertices of a scene: ids have 32 bits, and one value means "none".
const MAX_COUNT: usize = u32::MAX as usize - 8 - MAX_PLANES;

/// The most materials: each render thread keeps a queue for each.
#[doc(hidden)]
pub const MAX_MATERIALS: usize = 1 << 20;
/// The most lights of a scene: each costs a shadow ray for every visible point.
pub const MAX_LIGHTS: usize = 1024;
/// The most textures that a scene lists.
#[doc(hidden)]
pub const MAX_TEXTURES: usize = 10_000;

/// A material and its entry among the ids, both in arrays that have room for twice as many.
const MATERIAL_BYTES: u64 = 200;

/// The colour of a vertex or sphere without one.
const WHITE: [f32; 3] = [1.0; 3];

/// The fewest elements that are worth another thread.
pub(super) const MIN_PIECE: usize = 1 << 14;

/// Builds a [`Scene`]. Everything is validated when it is added, so that the caller can name its source.
///
/// ```
/// # use octray_engine as octray;
/// use glam::Vec3;
/// use octray::scene::SceneBuilder;
///
/// # fn main() -> Result<(), octray::error::SceneError> {
/// let mut builder = SceneBuilder::new();
/// builder.add_light(Vec3::new(9.0, -4.0, 10.0), 0.7)?;
/// let matte = builder.classic_material(1)?;
/// builder.add_sphere(Vec3::new(0.0, 0.0, 0.4), 0.4, matte)?;
/// let scene = builder.finish();
/// assert_eq!(scene.primitive_count(), 1);
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct SceneBuilder {
    vertices: Vertices,
    triangles: Triangles,
    spheres: Spheres,
    pub(super) planes: Vec<Plane>,
    pub(super) prototypes: Vec<Prototype>,
    pub(super) instances: Vec<Unplaced>,
    pub(super) moving: Moving,
    lights: Vec<Light>,
    materials: Vec<Material>,
    /// The id of each material, by its bits.
    material_ids: HashMap<[u32; 10], MaterialId>,
    /// By material; those of the last ones are missing if they have none.
    textures: Vec<Option<SurfaceTextures>>,
    one_sided: Vec<bool>,
    images: Vec<Image>,
    /// Memory of the images, bytes.
    image_bytes: u64,
    ambient: f32,
    ambient_reach: Option<f32>,
    smooth_shadows: bool,
    ambient_specular: bool,
    background: Background,
    environment: Option<Environment>,
    pub(super) cameras: Vec<NamedCamera>,
    mesh_cameras: Vec<NamedCamera>,
    sources: Sources,
    offset: DVec3,
    /// Limit for the scene and its BVH, bytes.
    memory: u64,
}

impl Default for SceneBuilder {
    fn default() -> Self {
        Self::new()
    }
}

pub(super) fn usable(what: &'static str, value: f32) -> Result<(), SceneError> {
    if is_usable(value) {
        Ok(())
    } else {
        Err(SceneError::NotUsable { what, value })
    }
}

pub(super) fn usable_point(p: Vec3) -> Result<(), SceneError> {
    usable("x", p.x)?;
    usable("y", p.y)?;
    usable("z", p.z)
}

/// Returns whether a triangle has an area. In f64 the edges and their products are (nearly always) exact, so collinear
/// corners give exactly 0.
#[inline]
#[must_use]
pub(super) fn has_area([v0, v1, v2]: [Vec3; 3]) -> bool {
    // Not `map` of the array: it is not inlined here.
    let (v0, v1, v2) = (v0.as_dvec3(), v1.as_dvec3(), v2.as_dvec3());
    (v1 - v0).cross(v2 - v0) != DVec3::ZERO || has_exact_area([v0, v1, v2])
}

/// [`has_area`] where rounding may lose the whole area: corners whose coordinates have very different magnitudes.
#[cold]
fn has_exact_area(corners: [DVec3; 3]) -> bool {
    let [v0, v1, v2] = corners;
    if v0 == v1 || v1 == v2 || v2 == v0 {
        return false;
    }
    // Edges without rounding (Knuth's difference of two) that fit an `f32` have exact products.
    let is_exact = |to: DVec3| {
        let edge = to - v0;
        let back = to - edge;
        let rounding = (to - (edge + back)) + (back - v0);
        rounding == DVec3::ZERO && edge.as_vec3().as_dvec3() == edge
    };
    if is_exact(v1) && is_exact(v2) {
        return false;
    }
    [[0, 1], [1, 2], [2, 0]].into_iter().any(|[i, j]| {
        let mut area = Expansion::default();
        for (from, to) in [(0, 1), (1, 2), (2, 0)] {
            let (from, to) = (corners[from], corners[to]);
            // Products of two `f32` numbers are exact.
            area.add(from[i] * to[j]);
            area.add(-(from[j] * to[i]));
        }
        area.sign() != 0.0
    })
}

impl SceneBuilder {
    /// Makes an empty scene with the classic materials, ambient light and background.
    #[must_use]
    pub fn new() -> Self {
        Self {
            vertices: Vertices::default(),
            triangles: Triangles::default(),
            spheres: Spheres::default(),
            planes: Vec::new(),
            prototypes: Vec::new(),
            instances: Vec::new(),
            moving: Moving::default(),
            lights: Vec::new(),
            materials: Material::CLASSIC.to_vec(),
            material_ids: (0..)
                .map(MaterialId)
                .zip(Material::CLASSIC)
                .map(|(id, material)| (material.bits(), id))
                .collect(),
            textures: Vec::new(),
            one_sided: Vec::new(),
            images: Vec::new(),
            image_bytes: 0,
            ambient: classic::AMBIENT,
            ambient_reach: None,
            smooth_shadows: false,
            ambient_specular: false,
            background: Background::constant(classic::BACKGROUND),
            environment: None,
            cameras: Vec::new(),
            mesh_cameras: Vec::new(),
            sources: Sources::default(),
            offset: DVec3::ZERO,
            memory: u64::MAX,
        }
    }

    /// Makes an empty scene like [`SceneBuilder::new`], limited to `memory` bytes including the build of its BVH. Sizes are
    /// estimated, and whatever would exceed the limit is refused before it is allocated.
    #[must_use]
    pub fn within(memory: u64) -> Self {
        Self {
            memory,
            ..Self::new()
        }
    }

    /// Returns the id of classic material `number`: 0 silhouette, 1 matte, 2 Blinn-Phong, 3 reflection.
    ///
    /// # Errors
    /// [`SceneError::UnknownMaterial`] for another number.
    pub fn classic_material(&self, number: u32) -> Result<MaterialId, SceneError> {
        let materials = Material::CLASSIC.len();
        if (number as usize) < materials {
            Ok(MaterialId(number))
        } else {
            Err(SceneError::UnknownMaterial {
                index: number,
                materials,
            })
        }
    }

    /// Adds a material, or returns the id of an equal one.
    ///
    /// # Errors
    /// [`SceneError::OutOfRange`], [`SceneError::TooMany`] or [`SceneError::OverLimit`].
    pub fn add_material(&mut self, material: Material) -> Result<MaterialId, SceneError> {
        self.add_sided_material(material, false)
    }

    /// As [`Self::add_material`], seen from one side or from both.
    fn add_sided_material(&mut self, material: Material, one_sided: bool) -> Result<MaterialId, SceneError> {
        material.check()?;
        let mut bits = material.bits();
        // The kind is a small number.
        bits[0] |= u32::from(one_sided) << 31;
        if let Some(&id) = self.material_ids.get(&bits) {
            return Ok(id);
        }
        let id = self.push_material(material)?;
        self.material_ids.insert(bits, id);
        Ok(id)
    }

    /// Adds a material without looking for an equal one.
    fn push_material(&mut self, material: Material) -> Result<MaterialId, SceneError> {
        if self.materials.len() >= MAX_MATERIALS {
            return Err(SceneError::TooMany {
                what: "materials",
                limit: MAX_MATERIALS,
            });
        }
        let id = MaterialId(self.materials.len() as u32);
        let needed = u64::from(id.0) * MATERIAL_BYTES;
        if needed > self.memory {
            let limit = self.memory;
            return Err(SceneError::OverLimit { needed, limit });
        }
        self.materials.push(material);
        Ok(id)
    }

    /// Sets the environment: the background or an image, which then also lights the scene.
    ///
    /// # Errors
    /// [`SceneError::OutOfRange`] for a colour that is not from 0 to 1, [`SceneError::OverLimit`].
    pub fn set_environment(&mut self, environment: Environment) -> Result<(), SceneError> {
        if let Environment::Background(background) = environment {
            self.set_background(background)?;
        }
        let former = self.environment.as_ref().map_or(0, Environment::memory_bytes);
        let needed = self.image_bytes - former as u64 + environment.memory_bytes() as u64;
        if needed > self.memory {
            let limit = self.memory;
            return Err(SceneError::OverLimit { needed, limit });
        }
        self.image_bytes = needed;
        self.environment = Some(environment);
        Ok(())
    }

    /// Sets the background.
    ///
    /// # Errors
    /// [`SceneError::OutOfRange`] if a channel is not from 0 to 1.
    pub fn set_background(&mut self, background: Background) -> Result<(), SceneError> {
        check_color(background.bottom)?;
        check_color(background.top)?;
        self.background = background;
        if let Some(Environment::Background(shown)) = &mut self.environment {
            *shown = background;
        }
        Ok(())
    }

    /// Adds a camera that a mesh file defines; it is never the default view.
    pub fn add_mesh_camera(&mut self, camera: NamedCamera) {
        self.mesh_cameras.push(camera);
    }

    /// Records an included file.
    pub fn add_include(&mut self, path: PathBuf) {
        self.sources.includes.push(path);
    }

    /// Records files of textures.
    pub fn add_texture_files(&mut self, paths: Vec<PathBuf>) {
        for path in paths {
            if self.sources.textures.len() < MAX_TEXTURES {
                self.sources.textures.insert(path);
            }
        }
    }

    /// Records a note: a sentence about something that was ignored or missing, which is no error.
    pub fn add_note(&mut self, note: String) {
        self.sources.notes.push(note);
    }

    pub(super) fn check_material(&self, material: MaterialId) -> Result<(), SceneError> {
        if (material.0 as usize) < self.materials.len() {
            Ok(())
        } else {
            Err(SceneError::UnknownMaterial {
                index: material.0,
                materials: self.materials.len(),
            })
        }
    }

    /// Checks the limits of counts and memory before adding this many more. `vectors`: the total number of normals,
    /// colours and texture coordinates afterwards.
    fn check_limits(
        &self,
        [triangles, spheres, vertices]: [usize; 3],
        vectors: usize,
    ) -> Result<(), SceneError> {
        let [triangles, spheres, vertices] = [
            self.triangles.corners.len().saturating_add(triangles),
            self.spheres.radius.len().saturating_add(spheres),
            self.vertices.x.len().saturating_add(vertices),
        ];
        for (what, count) in [
            ("primitives", triangles.saturating_add(spheres)),
            ("vertices", vertices),
        ] {
            if count > MAX_COUNT {
                return Err(SceneError::TooMany {
                    what,
                    limit: MAX_COUNT,
                });
            }
        }
        check_memory(
            [triangles, spheres, vertices + vectors],
            self.other_bytes(0),
            self.memory,
        )
    }

    /// Memory beside primitives and vertices, with this many more instances.
    fn other_bytes(&self, more: usize) -> u64 {
        let instances = (self.instances.len() + more) as u64 * INSTANCE_BYTES;
        self.image_bytes + instances + self.moving.bytes() as u64
    }

    /// The number of normals, colours, texture coordinates and tangents so far.
    fn vectors(&self) -> usize {
        let v = &self.vertices;
        v.normals.len() + v.colors.len() + v.uvs.len() + v.tangents.len() + self.spheres.color.len()
    }

    /// Finishes the scene: bounds, the number of triangles without area, and the scene's origin.
    #[must_use]
    pub fn finish(self) -> Scene {
        let Self {
            vertices,
            triangles,
            spheres,
            planes,
            prototypes,
            instances,
            mut moving,
            lights,
            materials,
            material_ids: _,
            textures,
            one_sided,
            images,
            image_bytes: _,
            ambient,
            ambient_reach,
            smooth_shadows,
            ambient_specular,
            background,
            environment,
            cameras,
            mesh_cameras,
            sources,
            offset,
            memory: _,
        } = self;
        let has_glass = materials.iter().any(|m| matches!(m, Material::Glass { .. }));
        let mut scene = Scene {
            vertices: vertices.into(),
            triangles: triangles.into(),
            spheres: spheres.into(),
            planes,
            prototypes,
            instances: Vec::new(),
            lights,
            has_glass,
            materials,
            has_cut_outs: textures.iter().flatten().any(SurfaceTextures::lets_rays_pass),
            has_blending: textures.iter().flatten().any(|all| all.opacity.is_some()),
            textures,
            one_sided,
            images,
            ambient,
            ambient_reach,
            smooth_shadows,
            ambient_specular,
            background,
            environment,
            cameras,
            mesh_cameras,
            sources,
            offset,
            origin: Vec3::ZERO,
            bounds: Aabb::EMPTY,
            degenerate: 0,
            id: SceneId::next(),
            moving: Moving::default(),
        };
        let mut bounds = Aabb::EMPTY;
        for range in scene.ids_of(None) {
            bounds = bounds.union(scene.bounds_of(range));
        }
        moving.find_still(bounds, &scene.prototypes, &instances);
        scene.moving = moving;
        scene.bounds = bounds.union(instances::bounds(&scene.prototypes, &instances));
        scene.degenerate = scene.triangle_extent(0..scene.triangles.corners.len()).1;
        scene.move_to_origin();
        scene.instances = instances::placed(&instances, scene.origin);
        scene
    }
}

impl Scene {
    /// Returns the bounding box of primitives, given by their ids.
    fn bounds_of(&self, ids: Range<u32>) -> Aabb {
        let count = self.triangles.corners.len();
        let (first, end) = (ids.start as usize, ids.end as usize);
        let (mut bounds, _) = self.triangle_extent(first.min(count)..end.min(count));
        for i in first.max(count) - count..end.max(count) - count {
            bounds = bounds.union(self.sphere_bounds(i));
        }
        bounds
    }

    /// Returns the bounding box of triangles and the number of those without area.
    fn triangle_extent(&self, triangles: Range<usize>) -> (Aabb, usize) {
        let pieces = self.triangles.corners[triangles].par_chunks(MIN_PIECE);
        let of_piece = |piece: &[[u32; 3]]| {
            let (mut bounds, mut degenerate) = (Aabb::EMPTY, 0);
            for &[v0, v1, v2] in piece {
                let position = |v| self.vertices.position(v);
                let corners = [position(v0), position(v1), position(v2)];
                bounds = bounds.union(Aabb::around(corners));
                degenerate += usize::from(!has_area(corners));
            }
            (bounds, degenerate)
        };
        let both = |a: (Aabb, usize), b: (Aabb, usize)| (a.0.union(b.0), a.1 + b.1);
        pieces.map(of_piece).reduce(|| (Aabb::EMPTY, 0), both)
    }
}

//! Collects the pieces of a scene, refuses what cannot be rendered, and finishes the columns.

use super::{
    Background, Lights, Material, MaterialId, NamedCamera, Scene, Sources, Spheres, Triangles, Vertices,
    is_usable,
    material::{check_color, check_share},
};
use crate::{
    classic,
    error::SceneError,
    math::{Aabb, max_abs},
};
use glam::{DVec3, Vec3};
use rayon::{iter::repeat_n, prelude::*};
use std::{collections::HashMap, path::PathBuf};

/// The most primitives, and the most vertices, that a scene may have: ids are 32 bits, and one value stands
/// for "none".
const MAX_COUNT: usize = u32::MAX as usize - 8;

/// The most materials: each thread that renders keeps a queue for each.
const MAX_MATERIALS: usize = 1 << 20;
/// The most lights: each is one shadow ray more for every point that is seen.
pub const MAX_LIGHTS: usize = 1024;

/// What building the BVH takes at its height for each primitive, bytes, the hierarchy included: measured on a terrain of
/// two million triangles (91 to 97) and on a million spheres (71).
pub const BVH_BYTES: u64 = 100;
/// Rows of the columns: corners and material; centre, radius and material.
const TRIANGLE_BYTES: u64 = 16;
const SPHERE_BYTES: u64 = 20;
/// Three coordinates, of a position or a normal.
const VECTOR_BYTES: u64 = 12;

/// Fewer rows than this are not worth another thread.
pub(super) const MIN_PIECE: usize = 1 << 14;

/// A mesh as columns, on its way into a scene.
#[derive(Debug, Default)]
pub struct MeshColumns {
    /// Vertex positions, scene units. Columns of equal length.
    pub x: Vec<f32>,
    /// Vertex positions, scene units.
    pub y: Vec<f32>,
    /// Vertex positions, scene units.
    pub z: Vec<f32>,
    /// A normal for every vertex, of any length (zero: none), or empty.
    pub normals: Vec<Vec3>,
    /// Indices of each triangle's corners, 0-based.
    pub triangles: Vec<[u32; 3]>,
}

/// Builds a [`Scene`]. Pieces are validated as they are added, so that an error can name their place.
///
/// ```
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
    lights: Lights,
    materials: Vec<Material>,
    /// Where each material is, by its bits.
    material_ids: HashMap<[u32; 10], MaterialId>,
    ambient: f32,
    background: Background,
    cameras: Vec<NamedCamera>,
    mesh_cameras: Vec<NamedCamera>,
    sources: Sources,
    /// What all of it may take with its BVH, bytes.
    memory: u64,
}

impl Default for SceneBuilder {
    fn default() -> Self {
        Self::new()
    }
}

/// Whether so many triangles, spheres, and positions and normals together, have room in so many bytes of memory, the building
/// of their BVH included. Counts are those of a scene: within 32 bits, so that no sum is too large.
///
/// # Errors
/// [`SceneError::OverLimit`].
pub(crate) fn check_memory(counts: [usize; 3], limit: u64) -> Result<(), SceneError> {
    let [triangles, spheres, vectors] = counts.map(|count| count as u64);
    let needed = triangles * TRIANGLE_BYTES
        + spheres * SPHERE_BYTES
        + vectors * VECTOR_BYTES
        + (triangles + spheres) * BVH_BYTES;
    if needed > limit {
        return Err(SceneError::OverLimit { needed, limit });
    }
    Ok(())
}

fn usable(what: &'static str, value: f32) -> Result<(), SceneError> {
    if is_usable(value) {
        Ok(())
    } else {
        Err(SceneError::NotUsable { what, value })
    }
}

fn usable_point(p: Vec3) -> Result<(), SceneError> {
    usable("x", p.x)?;
    usable("y", p.y)?;
    usable("z", p.z)
}

fn expect_length(what: &'static str, found: usize, expected: usize) -> Result<(), SceneError> {
    if found == expected {
        Ok(())
    } else {
        Err(SceneError::ColumnLength {
            what,
            found,
            expected,
        })
    }
}

/// Whether a triangle has an area. Decided in f64, where edges of `f32` corners and their products are
/// (nearly always) exact, so that collinear corners give exactly zero.
#[inline]
#[must_use]
pub(super) fn has_area([v0, v1, v2]: [Vec3; 3]) -> bool {
    // Written out, because arrays' own `map` is a call here.
    let (v0, v1, v2) = (v0.as_dvec3(), v1.as_dvec3(), v2.as_dvec3());
    (v1 - v0).cross(v2 - v0) != DVec3::ZERO
}

impl SceneBuilder {
    /// An empty scene with the four classic materials and the course's ambient light and background.
    #[must_use]
    pub fn new() -> Self {
        Self {
            vertices: Vertices::default(),
            triangles: Triangles::default(),
            spheres: Spheres::default(),
            lights: Lights::default(),
            materials: Material::CLASSIC.to_vec(),
            material_ids: (0..)
                .map(MaterialId)
                .zip(Material::CLASSIC)
                .map(|(id, material)| (material.bits(), id))
                .collect(),
            ambient: classic::AMBIENT,
            background: Background::constant(classic::BACKGROUND),
            cameras: Vec::new(),
            mesh_cameras: Vec::new(),
            sources: Sources::default(),
            memory: u64::MAX,
        }
    }

    /// As [`SceneBuilder::new`], of a scene that may take so many bytes of memory, the building of its BVH included. What
    /// it takes is estimated; what would be too much is refused before it is there.
    #[must_use]
    pub fn within(memory: u64) -> Self {
        Self {
            memory,
            ..Self::new()
        }
    }

    /// The id of classic material `number`: 0 silhouette, 1 matte, 2 Blinn-Phong, 3 reflection.
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

    /// Adds a material. One that is there already, bit for bit, is not added again.
    ///
    /// # Errors
    /// [`SceneError::OutOfRange`] or [`SceneError::TooMany`].
    pub fn add_material(&mut self, material: Material) -> Result<MaterialId, SceneError> {
        material.check()?;
        let bits = material.bits();
        if let Some(&id) = self.material_ids.get(&bits) {
            return Ok(id);
        }
        if self.materials.len() >= MAX_MATERIALS {
            return Err(SceneError::TooMany {
                what: "materials",
                limit: MAX_MATERIALS,
            });
        }
        let id = MaterialId(self.materials.len() as u32);
        self.materials.push(material);
        self.material_ids.insert(bits, id);
        Ok(id)
    }

    /// Sets the ambient light I_a, the same in all channels.
    ///
    /// # Errors
    /// [`SceneError::OutOfRange`]: not from 0 to 1.
    pub fn set_ambient(&mut self, ambient: f32) -> Result<(), SceneError> {
        check_share("ambient", ambient)?;
        self.ambient = ambient;
        Ok(())
    }

    /// Sets what rays see that leave the scene.
    ///
    /// # Errors
    /// [`SceneError::OutOfRange`]: a channel that is not from 0 to 1.
    pub fn set_background(&mut self, background: Background) -> Result<(), SceneError> {
        check_color(background.bottom)?;
        check_color(background.top)?;
        self.background = background;
        Ok(())
    }

    /// Adds a camera to choose from; the first is what the scene is seen by unless somebody asks otherwise.
    pub fn add_camera(&mut self, camera: NamedCamera) {
        self.cameras.push(camera);
    }

    /// Adds a camera of a mesh, which is never what the scene is seen by unless somebody asks for it.
    pub fn add_mesh_camera(&mut self, camera: NamedCamera) {
        self.mesh_cameras.push(camera);
    }

    /// Notes that the scene includes a file.
    pub fn add_include(&mut self, path: PathBuf) {
        self.sources.includes.push(path);
    }

    /// Notes what was left out or missing and is no error, a sentence.
    pub fn add_note(&mut self, note: String) {
        self.sources.notes.push(note);
    }

    fn check_material(&self, material: MaterialId) -> Result<(), SceneError> {
        if (material.0 as usize) < self.materials.len() {
            Ok(())
        } else {
            Err(SceneError::UnknownMaterial {
                index: material.0,
                materials: self.materials.len(),
            })
        }
    }

    /// Whether so many more triangles, spheres and vertices have room.
    fn check_room(&self, triangles: usize, spheres: usize, vertices: usize) -> Result<(), SceneError> {
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
        let vectors = vertices + self.vertices.normals.len();
        check_memory([triangles, spheres, vectors], self.memory)
    }

    /// Adds a white point light.
    ///
    /// # Errors
    /// [`SceneError::NotUsable`], [`SceneError::IntensityNegative`] or [`SceneError::TooMany`], above [`MAX_LIGHTS`].
    pub fn add_light(&mut self, position: Vec3, intensity: f32) -> Result<(), SceneError> {
        self.add_colored_light(position, intensity, [1.0; 3])
    }

    /// Adds a point light of a colour, linear RGB.
    ///
    /// # Errors
    /// As [`SceneBuilder::add_light`], or [`SceneError::OutOfRange`] for a colour whose channels are not from 0 to 1.
    pub fn add_colored_light(
        &mut self,
        position: Vec3,
        intensity: f32,
        color: [f32; 3],
    ) -> Result<(), SceneError> {
        usable_point(position)?;
        usable("intensity", intensity)?;
        if intensity < 0.0 {
            return Err(SceneError::IntensityNegative { intensity });
        }
        check_color(color)?;
        if self.lights.x.len() >= MAX_LIGHTS {
            return Err(SceneError::TooMany {
                what: "lights",
                limit: MAX_LIGHTS,
            });
        }
        self.lights.x.push(position.x);
        self.lights.y.push(position.y);
        self.lights.z.push(position.z);
        self.lights.intensity.push(intensity);
        self.lights.color.push(color);
        Ok(())
    }

    /// Adds a sphere.
    ///
    /// # Errors
    /// [`SceneError::NotUsable`], [`SceneError::RadiusNotPositive`], [`SceneError::UnknownMaterial`] or
    /// [`SceneError::TooMany`].
    pub fn add_sphere(&mut self, center: Vec3, radius: f32, material: MaterialId) -> Result<(), SceneError> {
        usable_point(center)?;
        usable("radius", radius)?;
        if radius <= 0.0 {
            return Err(SceneError::RadiusNotPositive { radius });
        }
        self.check_material(material)?;
        self.check_room(0, 1, 0)?;
        self.spheres.center_x.push(center.x);
        self.spheres.center_y.push(center.y);
        self.spheres.center_z.push(center.z);
        self.spheres.radius.push(radius);
        self.spheres.material.push(material);
        Ok(())
    }

    /// Adds a triangle. One without area is kept (its id counts) and never hit.
    ///
    /// # Errors
    /// [`SceneError::NotUsable`], [`SceneError::UnknownMaterial`] or [`SceneError::TooMany`].
    pub fn add_triangle(&mut self, corners: [Vec3; 3], material: MaterialId) -> Result<(), SceneError> {
        corners.into_iter().try_for_each(usable_point)?;
        self.check_material(material)?;
        self.check_room(1, 0, 3)?;
        let base = self.vertices.x.len() as u32;
        let all = &mut self.vertices;
        all.x.extend(corners.map(|corner| corner.x));
        all.y.extend(corners.map(|corner| corner.y));
        all.z.extend(corners.map(|corner| corner.z));
        if !all.normals.is_empty() {
            all.normals.resize(all.x.len(), Vec3::ZERO);
        }
        self.triangles.corners.push([base, base + 1, base + 2]);
        self.triangles.material.push(material);
        Ok(())
    }

    /// Adds a mesh. Triangles without area are kept (their ids count) and never hit.
    ///
    /// # Errors
    /// [`SceneError::NotUsable`], [`SceneError::ColumnLength`], [`SceneError::VertexIndex`],
    /// [`SceneError::UnknownMaterial`] or [`SceneError::TooMany`]; the scene is as before then.
    pub fn add_mesh(&mut self, mesh: MeshColumns, material: MaterialId) -> Result<(), SceneError> {
        self.check_material(material)?;
        make_room(&mut self.triangles.material, mesh.triangles.len())?;
        self.add_triangles(mesh)?;
        let materials = repeat_n(
            material,
            self.triangles.corners.len() - self.triangles.material.len(),
        );
        self.triangles.material.par_extend(materials);
        Ok(())
    }

    /// Adds a mesh, as [`SceneBuilder::add_mesh`] does, with a material for each of its triangles.
    ///
    /// # Errors
    /// As [`SceneBuilder::add_mesh`]; [`SceneError::ColumnLength`] also where `materials` is not as long as the
    /// triangles.
    pub fn add_mesh_with_materials(
        &mut self,
        mesh: MeshColumns,
        materials: Vec<MaterialId>,
    ) -> Result<(), SceneError> {
        expect_length("materials", materials.len(), mesh.triangles.len())?;
        materials.iter().try_for_each(|&id| self.check_material(id))?;
        make_room_to_append(&mut self.triangles.material, &materials)?;
        self.add_triangles(mesh)?;
        append(&mut self.triangles.material, materials);
        Ok(())
    }

    /// The vertices and corners of a mesh; the caller adds the materials.
    fn add_triangles(&mut self, mesh: MeshColumns) -> Result<(), SceneError> {
        Self::check_mesh(&mesh)?;
        let MeshColumns {
            x,
            y,
            z,
            normals,
            mut triangles,
        } = mesh;
        let base = self.vertices.x.len();
        self.check_room(triangles.len(), 0, x.len())?;
        let all = &mut self.vertices;
        for (column, more) in [(&mut all.x, &x), (&mut all.y, &y), (&mut all.z, &z)] {
            make_room_to_append(column, more)?;
        }
        make_room_to_append(&mut self.triangles.corners, &triangles)?;
        if !normals.is_empty() || !all.normals.is_empty() {
            let missing = base + x.len() - all.normals.len();
            if base > 0 {
                make_room(&mut all.normals, missing)?;
                all.normals.resize(base, Vec3::ZERO);
            }
            append(&mut all.normals, normals);
            all.normals.resize(base + x.len(), Vec3::ZERO);
        }
        append(&mut all.x, x);
        append(&mut all.y, y);
        append(&mut all.z, z);
        if base > 0 {
            let base = base as u32;
            let indices = triangles.as_flattened_mut().par_iter_mut();
            indices.with_min_len(MIN_PIECE).for_each(|index| *index += base);
        }
        append(&mut self.triangles.corners, triangles);
        Ok(())
    }

    fn check_mesh(mesh: &MeshColumns) -> Result<(), SceneError> {
        let vertices = mesh.x.len();
        expect_length("y coordinates", mesh.y.len(), vertices)?;
        expect_length("z coordinates", mesh.z.len(), vertices)?;
        if !mesh.normals.is_empty() {
            expect_length("normals", mesh.normals.len(), vertices)?;
        }
        for (what, column) in [("x", &mesh.x), ("y", &mesh.y), ("z", &mesh.z)] {
            let unusable = first_where(column, |&value| !is_usable(value));
            unusable.map_or(Ok(()), |i| usable(what, column[i]))?;
        }
        let unusable = first_where(&mesh.normals, |n| {
            !(is_usable(n.x) & is_usable(n.y) & is_usable(n.z))
        });
        unusable.map_or(Ok(()), |i| usable("normal", max_abs_or_nan(mesh.normals[i])))?;
        let is_beyond = |&[a, b, c]: &[u32; 3]| a.max(b).max(c) as usize >= vertices;
        match first_where(&mesh.triangles, is_beyond) {
            Some(triangle) => {
                let corners = mesh.triangles[triangle].into_iter();
                let index = corners.filter(|&index| index as usize >= vertices).min();
                Err(SceneError::VertexIndex {
                    triangle,
                    index: index.unwrap_or_default(),
                    vertices,
                })
            }
            None => Ok(()),
        }
    }

    /// Finishes the columns: bounds, the count of triangles without area, and the scene's origin.
    #[must_use]
    pub fn finish(self) -> Scene {
        let Self {
            vertices,
            triangles,
            spheres,
            lights,
            materials,
            material_ids: _,
            ambient,
            background,
            cameras,
            mesh_cameras,
            sources,
            memory: _,
        } = self;
        let mut scene = Scene {
            vertices,
            triangles,
            spheres,
            lights,
            materials,
            ambient,
            background,
            cameras,
            mesh_cameras,
            sources,
            origin: Vec3::ZERO,
            bounds: Aabb::EMPTY,
            degenerate: 0,
        };
        (scene.bounds, scene.degenerate) = scene.triangle_extent();
        for i in 0..scene.spheres.radius.len() {
            scene.bounds = scene.bounds.union(scene.sphere_bounds(i));
        }
        scene.move_to_origin();
        scene
    }
}

impl Scene {
    /// The box around all triangles, and how many of them have no area.
    fn triangle_extent(&self) -> (Aabb, usize) {
        let pieces = self.triangles.corners.par_chunks(MIN_PIECE);
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
        // Neither a box nor a count depends on the order.
        pieces.map(of_piece).reduce(|| (Aabb::EMPTY, 0), both)
    }
}

/// The first row that `is_wrong` holds for.
fn first_where<T: Sync>(column: &[T], is_wrong: impl Fn(&T) -> bool + Sync) -> Option<usize> {
    let wrong_piece = column
        .par_chunks(MIN_PIECE)
        // Without a way out of the loop it runs several rows at a time.
        .position_first(|piece| piece.iter().fold(false, |any, row| any | is_wrong(row)))?;
    let start = wrong_piece * MIN_PIECE;
    let row = column[start..].iter().position(is_wrong)?;
    Some(start + row)
}

/// Makes room for `more` rows, or says that there is none.
fn make_room<T>(column: &mut Vec<T>, more: usize) -> Result<(), SceneError> {
    let room = column.try_reserve(more);
    room.map_err(|_| SceneError::NoMemory { what: "triangles" })
}

/// What [`append`] needs.
fn make_room_to_append<T>(column: &mut Vec<T>, more: &[T]) -> Result<(), SceneError> {
    if column.is_empty() {
        return Ok(());
    }
    make_room(column, more.len())
}

/// Moves `from` to the end of `to`; no copy where `to` is empty.
fn append<T>(to: &mut Vec<T>, mut from: Vec<T>) {
    if to.is_empty() {
        *to = from;
    } else {
        to.append(&mut from);
    }
}

fn max_abs_or_nan(v: Vec3) -> f32 {
    if v.is_finite() { max_abs(v) } else { f32::NAN }
}

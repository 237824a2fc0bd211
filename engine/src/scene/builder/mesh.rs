//! Adding meshes: checks their arrays and appends them to the scene's, moved instead of copied where possible.

use super::{MIN_PIECE, SceneBuilder, WHITE, usable, usable_point};
use crate::{
    error::SceneError,
    math::max_abs,
    scene::{MaterialId, is_usable, material::check_color},
};
use glam::Vec3;
use rayon::{iter::repeat_n, prelude::*};

/// A triangle mesh as a structure of arrays.
#[derive(Clone, Debug, Default)]
pub struct TriangleMesh {
    /// Vertex positions, scene units; the three arrays have equal lengths.
    pub x: Vec<f32>,
    /// Vertex positions, scene units.
    pub y: Vec<f32>,
    /// Vertex positions, scene units.
    pub z: Vec<f32>,
    /// One normal per vertex, of any length (zero: none), or empty.
    pub normals: Vec<Vec3>,
    /// One base colour per vertex, as [`Vertices::colors`](crate::scene::Vertices::colors), or empty.
    pub colors: Vec<[f32; 3]>,
    /// Texture coordinates of each vertex, as [`Vertices::uvs`](crate::scene::Vertices::uvs), or empty.
    pub uvs: Vec<[f32; 2]>,
    /// One tangent per vertex for normal maps, or empty. x, y, z, of any length (zero: none), point to the image's right. w is
    /// above 0 if the cross product of normal and tangent points to the image's top, and below 0 if it points away.
    ///
    /// A triangle that lacks one at a corner, or whose corners have different signs of w, takes its own from its texture
    /// coordinates.
    pub tangents: Vec<[f32; 4]>,
    /// Vertex indices of each triangle, 0-based.
    pub triangles: Vec<[u32; 3]>,
}

impl SceneBuilder {
    /// Adds a triangle. One without area keeps its id but is never hit.
    ///
    /// # Errors
    /// [`SceneError::NotUsable`], [`SceneError::UnknownMaterial`] or [`SceneError::TooMany`].
    pub fn add_triangle(&mut self, corners: [Vec3; 3], material: MaterialId) -> Result<(), SceneError> {
        corners.into_iter().try_for_each(usable_point)?;
        self.check_material(material)?;
        self.check_limits([1, 0, 3], self.vectors())?;
        let base = self.vertices.x.len() as u32;
        let all = &mut self.vertices;
        all.x.extend(corners.map(|corner| corner.x));
        all.y.extend(corners.map(|corner| corner.y));
        all.z.extend(corners.map(|corner| corner.z));
        if !all.normals.is_empty() {
            all.normals.resize(all.x.len(), Vec3::ZERO);
        }
        if !all.colors.is_empty() {
            all.colors.resize(all.x.len(), WHITE);
        }
        if !all.uvs.is_empty() {
            all.uvs.resize(all.x.len(), [0.0; 2]);
        }
        if !all.tangents.is_empty() {
            all.tangents.resize(all.x.len(), [0.0; 4]);
        }
        self.triangles.corners.push([base, base + 1, base + 2]);
        self.triangles.material.push(material);
        Ok(())
    }

    /// Adds a mesh. Triangles without area keep their ids but are never hit.
    ///
    /// # Errors
    /// [`SceneError::NotUsable`], [`SceneError::OutOfRange`] if a channel of a colour is not from 0 to 1,
    /// [`SceneError::ArrayLength`], [`SceneError::VertexIndex`], [`SceneError::UnknownMaterial`],
    /// [`SceneError::TooMany`], [`SceneError::OverLimit`] or [`SceneError::NoMemory`]; the scene is unchanged then.
    pub fn add_mesh(&mut self, mesh: TriangleMesh, material: MaterialId) -> Result<(), SceneError> {
        self.check_material(material)?;
        reserve(&mut self.triangles.material, mesh.triangles.len(), TRIANGLES)?;
        self.add_triangles(mesh)?;
        let materials = repeat_n(
            material,
            self.triangles.corners.len() - self.triangles.material.len(),
        );
        self.triangles.material.par_extend(materials);
        Ok(())
    }

    /// Adds a mesh whose triangles show no edges in pictures: see `render::Edges`.
    ///
    /// # Errors
    /// As [`SceneBuilder::add_mesh`].
    pub fn add_mesh_without_edges(
        &mut self,
        mesh: TriangleMesh,
        material: MaterialId,
    ) -> Result<(), SceneError> {
        let first = self.triangles.corners.len() as u32;
        self.add_mesh(mesh, material)?;
        let end = self.triangles.corners.len() as u32;
        self.triangles.edgeless.push(first..end);
        Ok(())
    }

    /// Adds a mesh with one material per triangle.
    ///
    /// # Errors
    /// As [`SceneBuilder::add_mesh`]; also [`SceneError::ArrayLength`] if `materials` and the triangles differ in
    /// length.
    pub fn add_mesh_with_materials(
        &mut self,
        mesh: TriangleMesh,
        materials: Vec<MaterialId>,
    ) -> Result<(), SceneError> {
        expect_length("materials", materials.len(), mesh.triangles.len())?;
        materials.iter().try_for_each(|&id| self.check_material(id))?;
        reserve_for_append(&mut self.triangles.material, &materials, TRIANGLES)?;
        self.add_triangles(mesh)?;
        append(&mut self.triangles.material, materials);
        Ok(())
    }

    /// Checks that this many triangles, spheres and vertices can be added, with `vectors` more normals, colours and
    /// texture coordinates, before they are made.
    ///
    /// # Errors
    /// [`SceneError::TooMany`] or [`SceneError::OverLimit`].
    #[doc(hidden)]
    pub fn check_room(&self, counts: [usize; 3], vectors: usize) -> Result<(), SceneError> {
        self.check_limits(counts, self.vectors().saturating_add(vectors))
    }

    /// Adds the vertices and triangles of a mesh; the caller adds the materials.
    fn add_triangles(&mut self, mesh: TriangleMesh) -> Result<(), SceneError> {
        Self::check_mesh(&mesh)?;
        let TriangleMesh {
            x,
            y,
            z,
            normals,
            colors,
            uvs,
            tangents,
            mut triangles,
        } = mesh;
        let (base, end) = (self.vertices.x.len(), self.vertices.x.len() + x.len());
        let has_normals = !normals.is_empty() || !self.vertices.normals.is_empty();
        let has_colors = !colors.is_empty() || !self.vertices.colors.is_empty();
        let has_uvs = !uvs.is_empty() || !self.vertices.uvs.is_empty();
        let has_tangents = !tangents.is_empty() || !self.vertices.tangents.is_empty();
        let arrays = [has_normals, has_colors, has_uvs, has_tangents].map(usize::from);
        let vectors = arrays.iter().sum::<usize>() * end + self.spheres.color.len();
        self.check_limits([triangles.len(), 0, x.len()], vectors)?;
        let all = &mut self.vertices;
        for (coordinates, more) in [(&mut all.x, &x), (&mut all.y, &y), (&mut all.z, &z)] {
            reserve_for_append(coordinates, more, TRIANGLES)?;
        }
        reserve_for_append(&mut self.triangles.corners, &triangles, TRIANGLES)?;
        // A first mesh is moved.
        let room = |has_any: bool| if has_any && base > 0 { end } else { 0 };
        reserve_up_to(&mut all.normals, room(has_normals))?;
        reserve_up_to(&mut all.colors, room(has_colors))?;
        reserve_up_to(&mut all.uvs, room(has_uvs))?;
        reserve_up_to(&mut all.tangents, room(has_tangents))?;
        if has_normals {
            append_padded(&mut all.normals, normals, [base, end], Vec3::ZERO);
        }
        if has_colors {
            append_padded(&mut all.colors, colors, [base, end], WHITE);
        }
        if has_uvs {
            append_padded(&mut all.uvs, uvs, [base, end], [0.0; 2]);
        }
        if has_tangents {
            append_padded(&mut all.tangents, tangents, [base, end], [0.0; 4]);
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

    fn check_mesh(mesh: &TriangleMesh) -> Result<(), SceneError> {
        let vertices = mesh.x.len();
        expect_length("y coordinates", mesh.y.len(), vertices)?;
        expect_length("z coordinates", mesh.z.len(), vertices)?;
        if !mesh.normals.is_empty() {
            expect_length("normals", mesh.normals.len(), vertices)?;
        }
        for (what, coordinates) in [("x", &mesh.x), ("y", &mesh.y), ("z", &mesh.z)] {
            let unusable = first_where(coordinates, |&value| !is_usable(value));
            unusable.map_or(Ok(()), |i| usable(what, coordinates[i]))?;
        }
        let unusable = first_where(&mesh.normals, |n| {
            !(is_usable(n.x) & is_usable(n.y) & is_usable(n.z))
        });
        unusable.map_or(Ok(()), |i| usable("normal", max_abs_or_nan(mesh.normals[i])))?;
        check_colors(&mesh.colors, vertices)?;
        if !mesh.uvs.is_empty() {
            expect_length("texture coordinates", mesh.uvs.len(), vertices)?;
        }
        let unusable = first_where(&mesh.uvs, |&[u, v]| !(is_usable(u) & is_usable(v)));
        unusable.map_or(Ok(()), |i| {
            mesh.uvs[i]
                .into_iter()
                .try_for_each(|value| usable("texture coordinate", value))
        })?;
        if !mesh.tangents.is_empty() {
            expect_length("tangents", mesh.tangents.len(), vertices)?;
        }
        let numbers = mesh.tangents.as_flattened();
        let unusable = first_where(numbers, |&value| !is_usable(value));
        unusable.map_or(Ok(()), |i| usable("tangent", numbers[i]))?;
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
}

/// Rejects channels outside [0, 1], and numbers of colours other than 0 and `count`.
pub(super) fn check_colors(colors: &[[f32; 3]], count: usize) -> Result<(), SceneError> {
    if colors.is_empty() {
        return Ok(());
    }
    expect_length("colours", colors.len(), count)?;
    let is_share = |channel: f32| (0.0..=1.0).contains(&channel);
    let wrong = first_where(colors, |&[r, g, b]| !(is_share(r) & is_share(g) & is_share(b)));
    wrong.map_or(Ok(()), |i| check_color(colors[i]))
}

pub(in crate::scene) fn expect_length(
    what: &'static str,
    found: usize,
    expected: usize,
) -> Result<(), SceneError> {
    if found == expected {
        Ok(())
    } else {
        Err(SceneError::ArrayLength {
            what,
            found,
            expected,
        })
    }
}

/// Returns the index of the first element for which `is_wrong` returns true.
pub(super) fn first_where<T: Sync>(array: &[T], is_wrong: impl Fn(&T) -> bool + Sync) -> Option<usize> {
    let wrong_piece = array
        .par_chunks(MIN_PIECE)
        // No early exit, so that the loop vectorises.
        .position_first(|piece| piece.iter().fold(false, |any, value| any | is_wrong(value)))?;
    let start = wrong_piece * MIN_PIECE;
    let i = array[start..].iter().position(is_wrong)?;
    Some(start + i)
}

/// The name in errors of memory.
const TRIANGLES: &str = "triangles";

pub(super) fn reserve<T>(array: &mut Vec<T>, more: usize, what: &'static str) -> Result<(), SceneError> {
    let reserved = array.try_reserve(more);
    reserved.map_err(|_| SceneError::NoMemory { what })
}

/// Reserves memory for `count` elements of a mesh in all.
fn reserve_up_to<T>(array: &mut Vec<T>, count: usize) -> Result<(), SceneError> {
    reserve(array, count.saturating_sub(array.len()), TRIANGLES)
}

/// Reserves the memory that [`append`] needs: none if it moves.
pub(super) fn reserve_for_append<T>(
    array: &mut Vec<T>,
    more: &[T],
    what: &'static str,
) -> Result<(), SceneError> {
    if array.is_empty() {
        return Ok(());
    }
    reserve(array, more.len(), what)
}

/// Appends the values `from` of the elements from `base` to `end`, or nothing. `to` is padded with `missing` for elements
/// without a value.
pub(super) fn append_padded<T: Copy>(to: &mut Vec<T>, from: Vec<T>, [base, end]: [usize; 2], missing: T) {
    to.resize(base, missing);
    append(to, from);
    to.resize(end, missing);
}

/// Appends `from` to `to`, without a copy if `to` is empty.
pub(super) fn append<T>(to: &mut Vec<T>, mut from: Vec<T>) {
    if to.is_empty() {
        *to = from;
    } else {
        to.append(&mut from);
    }
}

fn max_abs_or_nan(v: Vec3) -> f32 {
    if v.is_finite() { max_abs(v) } else { f32::NAN }
}

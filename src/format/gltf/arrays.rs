//! The arrays of a mesh, to which shapes are added.

use super::{Surface, buffers::Buffers, materials::display_value, morphs::Attribute, shapes::Shape};
use crate::{
    error::{LoadError, SceneError},
    format::{
        mesh::{LINE_VERTICES, channels},
        textures,
        vertices::add_position,
    },
    scene::{Placing, TriangleMesh, is_usable},
};
use glam::{DMat3, DMat4, DVec3, DVec4, Vec3};
use std::ops::Range;

/// A triangle without a material.
pub(super) const NO_SURFACE: u32 = u32::MAX;

/// A triangle without a material whose vertices have colours.
pub(super) const COLORED: u32 = u32::MAX - 1;

/// A mesh so far.
#[derive(Default)]
pub(super) struct Arrays {
    pub(super) columns: TriangleMesh,
    /// The segments of lines.
    pub(super) lines: Vec<[u32; 2]>,
    /// The index of each triangle's material in the file.
    pub(super) material_of: Vec<u32>,
    has_normals: bool,
    pub(super) has_colors: bool,
    has_uvs: bool,
    has_tangents: bool,
    /// Triangles without texture coordinates whose material shows a texture.
    untextured: Vec<Range<usize>>,
    /// How many texture coordinates are not finite.
    pub(super) odd_uvs: usize,
    /// How many colours were not from 0 to 1.
    pub(super) clamped: usize,
    /// The largest absolute coordinate of the vertices as stored, times the scale of their node.
    pub(super) reach: f32,
    /// The error about the first position that is NaN or too large.
    pub(super) unusable: Option<LoadError>,
}

impl Arrays {
    /// Makes room for shapes.
    pub(super) fn reserve(&mut self, room: &Room, buffers: &Buffers<'_>) -> Result<(), LoadError> {
        let [normals, colors, uvs, tangents] = room.vectors();
        let (budget, columns) = (buffers.budget(), &mut self.columns);
        [&mut columns.x, &mut columns.y, &mut columns.z]
            .into_iter()
            .try_for_each(|column| budget.reserve(column, room.vertices))
            .and_then(|()| budget.reserve(&mut columns.normals, normals))
            .and_then(|()| budget.reserve(&mut columns.colors, colors))
            .and_then(|()| budget.reserve(&mut columns.uvs, uvs))
            .and_then(|()| budget.reserve(&mut columns.tangents, tangents))
            .and_then(|()| budget.reserve(&mut self.lines, room.lines))
            .and_then(|()| budget.reserve(&mut columns.triangles, room.triangles))
            .and_then(|()| budget.reserve(&mut self.material_of, room.triangles))
            .map_err(|error| buffers.no_room(error))
    }

    /// Adds a shape, placed by `world`.
    pub(super) fn place(
        &mut self,
        shape: &Shape<'_>,
        world: &DMat4,
        buffers: &Buffers<'_>,
    ) -> Result<(), LoadError> {
        let (base, more) = (self.columns.x.len(), shape.used_count());
        let (budget, columns) = (buffers.budget(), &mut self.columns);
        self.has_normals |= shape.normals.is_some();
        let is_valued = buffers.scalars().is_named();
        self.has_colors |= shape.colors.is_some() || shape.tint.is_some() || is_valued;
        self.has_uvs |= shape.uvs.is_some();
        self.has_tangents |= shape.tangents.is_some();
        let missing = |has: bool, length: usize| if has { base + more - length } else { 0 };
        let missing_normals = missing(self.has_normals, columns.normals.len());
        let missing_colors = missing(self.has_colors, columns.colors.len());
        let missing_uvs = missing(self.has_uvs, columns.uvs.len());
        let missing_tangents = missing(self.has_tangents, columns.tangents.len());
        [&mut columns.x, &mut columns.y, &mut columns.z]
            .into_iter()
            .try_for_each(|column| budget.reserve(column, more))
            .and_then(|()| budget.reserve(&mut columns.normals, missing_normals))
            .and_then(|()| budget.reserve(&mut columns.colors, missing_colors))
            .and_then(|()| budget.reserve(&mut columns.uvs, missing_uvs))
            .and_then(|()| budget.reserve(&mut columns.tangents, missing_tangents))
            .map_err(|error| buffers.no_room(error))?;
        let is_mirrored = self.positions(shape, world, buffers)?;
        self.normals(shape, base, world, buffers)?;
        if is_valued {
            self.values(shape);
        } else {
            self.colors(shape, base, buffers)?;
        }
        self.uvs(shape, base);
        self.tangents(shape, base, world, buffers)?;
        shape.add_lines(&mut self.lines, base as u32);
        let triangles = &mut self.columns.triangles;
        let before = triangles.len();
        shape.add_triangles(triangles, base as u32);
        if is_mirrored {
            // Mirrored triangles keep their front.
            triangles[before..]
                .iter_mut()
                .for_each(|corners| corners.swap(1, 2));
        }
        let none = if shape.colors.is_some() {
            COLORED
        } else {
            NO_SURFACE
        };
        let material = shape.material.map_or(none, |i| i as u32);
        if shape.is_textured && shape.uvs.is_none() {
            self.untextured.push(self.material_of.len()..triangles.len());
        }
        self.material_of.resize(triangles.len(), material);
        Ok(())
    }

    /// Adds positions. Returns whether the shape is mirrored: one with joints as its first vertex is.
    fn positions(
        &mut self,
        shape: &Shape<'_>,
        world: &DMat4,
        buffers: &Buffers<'_>,
    ) -> Result<bool, LoadError> {
        let mut is_mirrored = None;
        let mut reach = 0.0_f32;
        let is_identity = *world == DMat4::IDENTITY && !shape.is_skinned();
        for i in shape.used() {
            let matrix = shape.matrix(i, world, buffers)?;
            is_mirrored.get_or_insert_with(|| matrix.determinant() < 0.0);
            let position = shape.positions.vector(i);
            let usable = position.iter().filter(|x| is_usable(**x));
            reach = usable.fold(reach, |reach, x| reach.max(x.abs()));
            let position = shape.morphed(Attribute::Position, i, position);
            let position = if is_identity {
                position
            } else {
                (matrix * position.extend(1.0)).truncate()
            };
            let added = add_position(&mut self.columns, position.as_vec3().to_array());
            if let (Err(error), None) = (added, &self.unusable) {
                self.unusable = Some(buffers.refused(format!(
                    "accessors[{}]: vertex {} of {}: {error}",
                    shape.positions.accessor,
                    i + 1,
                    shape.positions.count
                )));
            }
        }
        self.reach = self.reach.max(reach * scale(world));
        Ok(is_mirrored.unwrap_or(false))
    }

    /// Adds the normals of the vertices from `base` on. Missing and degenerate ones are zero.
    fn normals(
        &mut self,
        shape: &Shape<'_>,
        base: usize,
        world: &DMat4,
        buffers: &Buffers<'_>,
    ) -> Result<(), LoadError> {
        let columns = &mut self.columns;
        if let Some(normals) = &shape.normals {
            let of_world = cofactors(world);
            columns.normals.resize(base, Vec3::ZERO);
            for i in shape.used() {
                let matrix = if shape.is_skinned() {
                    cofactors(&shape.matrix(i, world, buffers)?)
                } else {
                    of_world
                };
                let turned = matrix * shape.morphed(Attribute::Normal, i, normals.vector(i));
                columns.normals.push(turned.normalize_or_zero().as_vec3());
            }
        } else if self.has_normals {
            columns.normals.resize(columns.x.len(), Vec3::ZERO);
        }
        Ok(())
    }

    /// Adds the colours of the vertices from `base` on, as display values. Missing ones are white.
    fn colors(&mut self, shape: &Shape<'_>, base: usize, buffers: &Buffers<'_>) -> Result<(), LoadError> {
        const WHITE: [f32; 3] = [1.0; 3];
        let columns = &mut self.columns;
        let tint = shape.tint.unwrap_or(WHITE);
        if let Some(colors) = &shape.colors {
            columns.colors.resize(base, WHITE);
            for i in shape.used() {
                let mut linear = colors.color(i);
                if shape.is_morphed() {
                    let morphed = shape.morphed(Attribute::Color, i, linear);
                    linear = morphed
                        .as_vec3()
                        .to_array()
                        .map(|channel| channel.clamp(0.0, 1.0));
                }
                for (what, value) in ["red", "green", "blue"].into_iter().zip(linear) {
                    if !value.is_finite() {
                        let error = SceneError::NotUsable { what, value };
                        let (accessor, count) = (colors.accessor, colors.count);
                        let message = format!("accessors[{accessor}]: colour {} of {count}: {error}", i + 1);
                        return Err(buffers.refused(message));
                    }
                }
                self.clamped += usize::from(linear.iter().any(|channel| !(0.0..=1.0).contains(channel)));
                let color = linear.map(display_value);
                columns.colors.push([0, 1, 2].map(|i| color[i] * tint[i]));
            }
        } else if self.has_colors {
            columns.colors.resize(base, WHITE);
            columns.colors.resize(columns.x.len(), tint);
        }
        Ok(())
    }

    /// Adds the numbers of the vertices, in the place of colours. Missing ones are NaN.
    fn values(&mut self, shape: &Shape<'_>) {
        let values = shape.values.as_deref();
        let value = |i| channels(values.map_or(f64::NAN, |values| values.value(i)));
        self.columns.colors.extend(shape.used().map(value));
    }

    /// Adds the texture coordinates of the vertices from `base` on.
    fn uvs(&mut self, shape: &Shape<'_>, base: usize) {
        let columns = &mut self.columns;
        if let Some((uvs, placement)) = &shape.uvs {
            columns.uvs.resize(base, [0.0; 2]);
            for i in shape.used() {
                let [u, v, _] = shape
                    .morphed(Attribute::TexCoord, i, uvs.vector(i))
                    .as_vec3()
                    .to_array();
                let uv = placement.apply([u, v]);
                let is_odd = !uv.into_iter().all(is_usable);
                self.odd_uvs += usize::from(is_odd);
                columns.uvs.push(if is_odd { [0.0; 2] } else { uv });
            }
        } else if self.has_uvs {
            columns.uvs.resize(columns.x.len(), [0.0; 2]);
        }
    }

    /// Adds the tangents of the vertices from `base` on. Missing and degenerate ones are zero.
    fn tangents(
        &mut self,
        shape: &Shape<'_>,
        base: usize,
        world: &DMat4,
        buffers: &Buffers<'_>,
    ) -> Result<(), LoadError> {
        let columns = &mut self.columns;
        if let Some(tangents) = &shape.tangents {
            columns.tangents.resize(base, [0.0; 4]);
            for i in shape.used() {
                let [x, y, z, w] = tangents.numbers(i);
                let matrix = shape.matrix(i, world, buffers)?;
                let tangent = shape.morphed(Attribute::Tangent, i, [x, y, z]);
                let [x, y, z] = turned(&matrix, tangent).to_array();
                // A mirror image has a mirrored normal map.
                let is_mirrored = matrix.determinant() < 0.0;
                let sign = if is_mirrored { -w.signum() } else { w.signum() };
                let is_whole = w != 0.0 && !w.is_nan() && [x, y, z] != [0.0; 3];
                columns
                    .tangents
                    .push(if is_whole { [x, y, z, sign] } else { [0.0; 4] });
            }
        } else if self.has_tangents {
            columns.tangents.resize(columns.x.len(), [0.0; 4]);
        }
        Ok(())
    }

    /// What checks placements, by the usable vertices.
    pub(super) fn placing(&self) -> Placing {
        if self.unusable.is_none() {
            return Placing::of(&self.columns);
        }
        let TriangleMesh { x, y, z, .. } = &self.columns;
        let mut usable = TriangleMesh::default();
        for ((&x, &y), &z) in x.iter().zip(y).zip(z) {
            if [x, y, z].into_iter().all(is_usable) {
                usable.x.push(x);
                usable.y.push(y);
                usable.z.push(z);
            }
        }
        Placing::of(&usable)
    }

    /// Gives triangles without texture coordinates surfaces without textures. Returns how many there are.
    pub(super) fn leave_untextured(&mut self, surfaces: &mut Vec<Surface>) -> usize {
        // Ascending, as the triangles.
        let mut ranges = self.untextured.iter().peekable();
        textures::leave_untextured(surfaces, &mut self.material_of, |i| {
            while ranges.next_if(|range| range.end <= i).is_some() {}
            ranges.peek().is_some_and(|range| range.contains(&i))
        })
    }
}

/// The largest factor by which an axis is scaled.
pub(super) fn scale(world: &DMat4) -> f32 {
    let axes = [world.x_axis, world.y_axis, world.z_axis];
    axes.map(DVec4::length).into_iter().fold(0.0, f64::max) as f32
}

/// The matrix that normals are transformed by: the cofactors, which exist for every matrix. Their sign would follow the
/// winding, which a mirror reverses.
fn cofactors(matrix: &DMat4) -> DMat3 {
    let m = DMat3::from_mat4(*matrix);
    let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
    DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * m.determinant().signum()
}

/// The unit image of a direction, zero if it has none.
fn turned(matrix: &DMat4, direction: DVec3) -> Vec3 {
    let turned = DMat3::from_mat4(*matrix) * direction;
    turned.normalize_or_zero().as_vec3()
}

/// How much room shapes take, as far as that is known without reading them.
#[derive(Default)]
pub(super) struct Room {
    pub(super) triangles: usize,
    /// Segments of lines, and at most this many points and ends of lines.
    pub(super) lines: usize,
    pub(super) points: usize,
    pub(super) vertices: usize,
    /// Normals, colours, texture coordinates, tangents.
    has: [bool; 4],
}

impl Room {
    /// Adds shapes that stand in `placements` places.
    pub(super) fn add(&mut self, shapes: &[Shape<'_>], placements: usize) {
        for shape in shapes {
            let more = |count: usize| placements.saturating_mul(count);
            for (sum, count) in [
                (&mut self.triangles, shape.triangle_count()),
                (&mut self.lines, shape.line_count()),
                (&mut self.points, shape.point_count()),
                (&mut self.vertices, shape.vertices_at_least()),
            ] {
                *sum = sum.saturating_add(more(count));
            }
            let has = [
                shape.normals.is_some(),
                shape.colors.is_some() || shape.values.is_some(),
                shape.uvs.is_some(),
                shape.tangents.is_some(),
            ];
            for (any, has) in self.has.iter_mut().zip(has) {
                *any |= has;
            }
        }
    }

    /// How many normals, colours, texture coordinates and tangents there are.
    fn vectors(&self) -> [usize; 4] {
        self.has.map(|has| if has { self.vertices } else { 0 })
    }

    /// How many vectors there are, positions and those of the tubes of lines too.
    pub(super) fn all_vectors(&self) -> usize {
        let [_, has_colors, ..] = self.has;
        let of_line = LINE_VERTICES * (2 + usize::from(has_colors));
        self.vectors()
            .into_iter()
            .chain([self.lines.saturating_mul(of_line)])
            .fold(self.vertices, usize::saturating_add)
    }
}

/// Gives surfaces to triangles without a material, or no surfaces to any if none has one.
pub(super) fn name_surfaces(surfaces: &mut Vec<Surface>, parts: &mut [Arrays]) {
    let has_colors = parts.iter().any(|part| part.has_colors);
    let none = if has_colors { COLORED } else { NO_SURFACE };
    if parts
        .iter()
        .all(|part| part.material_of.iter().all(|&material| material == none))
    {
        surfaces.clear();
        for part in &mut *parts {
            part.material_of.clear();
        }
    }
    for (none, surface) in [(NO_SURFACE, Surface::NEUTRAL), (COLORED, Surface::WHITE)] {
        if parts.iter().any(|part| part.material_of.contains(&none)) {
            let index = surfaces.len() as u32;
            surfaces.push(surface);
            let all = parts.iter_mut().flat_map(|part| &mut part.material_of);
            for material in all.filter(|material| **material == none) {
                *material = index;
            }
        }
    }
}

//! Primitives: which vertices they use, and which triangles or lines these are.

use super::{
    buffers::Buffers,
    elements::Elements,
    materials::{Placement, Shown},
    morphs::{self, Attribute, Difference, MorphTargets},
    skins::{Joints, Skinning},
};
use crate::{
    error::LoadError,
    format::{budget::Budget, left_out::counted},
};
use glam::{DMat4, DVec3};
use gltf::{Mesh, Primitive, Semantic, mesh::Mode};
use std::rc::Rc;

/// What changes the vertices of a mesh.
pub(super) struct Pose<'p> {
    pub(super) targets: &'p MorphTargets<'p>,
    /// The weights of the targets.
    pub(super) weights: &'p [f32],
    /// `None` without a skin.
    pub(super) joints: Option<Joints>,
}

/// A primitive of triangles, or of points or lines.
pub(super) struct Shape<'a> {
    mode: Mode,
    /// The index of its material in the file.
    pub(super) material: Option<usize>,
    pub(super) positions: Rc<Elements<'a>>,
    /// As many as positions.
    pub(super) normals: Option<Rc<Elements<'a>>>,
    /// As many as positions; `None` without normals, or if no normal map is shown.
    pub(super) tangents: Option<Rc<Elements<'a>>>,
    /// As many as positions.
    pub(super) colors: Option<Rc<Elements<'a>>>,
    /// What is shown instead, as many as positions; `None` if nothing is, or the primitive has no such numbers.
    pub(super) values: Option<Rc<Elements<'a>>>,
    /// The factor of the colours of points and lines, display values.
    pub(super) tint: Option<[f32; 3]>,
    /// Whether the material shows a texture.
    pub(super) is_textured: bool,
    /// Texture coordinates, one for each position, and how they are moved; `None` if the material shows no texture, or
    /// the file has no coordinates for it.
    pub(super) uvs: Option<(Rc<Elements<'a>>, Placement)>,
    differences: Vec<Difference<'a>>,
    skinning: Option<Skinning<'a>>,
    /// `None` if each vertex is a corner.
    indices: Option<Rc<Elements<'a>>>,
    /// From [`Shape::prepare`] until [`Shape::release`].
    corners: Option<Corners>,
}

/// The corners of a shape.
struct Corners {
    /// The vertices that it uses, ascending; `None` if it has no more than it has corners: then all count as used.
    used: Option<Vec<u32>>,
    /// For each corner the number of its vertex among those used.
    vertices: Vec<u32>,
}

/// The shapes of a mesh that have triangles, or points and lines if it `is_cloud`.
pub(super) fn shapes_of<'a>(
    mesh: &Mesh<'_>,
    materials: &[Shown],
    is_cloud: bool,
    pose: &Pose<'_>,
    buffers: &mut Buffers<'a>,
) -> Result<Vec<Shape<'a>>, LoadError> {
    let mut shapes = Vec::new();
    for primitive in mesh.primitives() {
        let material = primitive.material().index();
        let is_cut_away = material.is_some_and(|i| materials.get(i).is_some_and(|shown| shown.is_cut_away));
        if is_cut_away || is_cloud != is_of_cloud(primitive.mode()) {
            continue;
        }
        let shape = Shape::new(mesh.index(), &primitive, materials, pose, buffers)?;
        shapes.extend(shape.filter(|shape| is_cloud || shape.triangle_count() > 0));
    }
    Ok(shapes)
}

/// Whether primitives of this mode are points or lines.
fn is_of_cloud(mode: Mode) -> bool {
    matches!(
        mode,
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip
    )
}

/// Refuses an attribute that not all vertices have. `what` is one element, and several.
fn check_count(
    elements: &Elements<'_>,
    [one, many]: [&str; 2],
    positions: &Elements<'_>,
    buffers: &Buffers<'_>,
) -> Result<(), LoadError> {
    if elements.count == positions.count {
        return Ok(());
    }
    Err(buffers.refused(format!(
        "accessors[{}] has {}, but the primitive has {}",
        elements.accessor,
        counted(elements.count, one, many),
        counted(positions.count, "vertex", "vertices")
    )))
}

impl<'a> Shape<'a> {
    /// `None` for primitives without positions.
    fn new(
        mesh: usize,
        primitive: &Primitive<'_>,
        materials: &[Shown],
        pose: &Pose<'_>,
        buffers: &mut Buffers<'a>,
    ) -> Result<Option<Self>, LoadError> {
        let Some(positions) = primitive.get(&Semantic::Positions) else {
            return Ok(None);
        };
        buffers.decode_primitive(mesh, primitive)?;
        let positions = buffers.vectors(&positions)?;
        let indices = match primitive.indices() {
            Some(indices) => Some(buffers.indices(&indices)?),
            None => None,
        };
        let normals = match primitive.get(&Semantic::Normals) {
            Some(normals) => Some(buffers.vectors(&normals)?),
            None => None,
        };
        let values = buffers.values([mesh, primitive.index()], positions.count)?;
        let shows_colors = buffers.scalars().shows_colors();
        let colors = match primitive.get(&Semantic::Colors(0)).filter(|_| shows_colors) {
            Some(colors) => Some(buffers.colors(&colors)?),
            None => None,
        };
        let material = primitive.material().index();
        let tint = material.and_then(|i| Some(materials.get(i)?.surface.diffuse));
        let tint = tint.filter(|_| shows_colors && is_of_cloud(primitive.mode()));
        let placement = material.and_then(|i| materials.get(i)?.placement);
        let uvs = placement.and_then(|placement| {
            let accessor = primitive.get(&Semantic::TexCoords(placement.set))?;
            Some((accessor, placement))
        });
        let uvs = match uvs {
            Some((accessor, placement)) => Some((buffers.pairs(&accessor)?, placement)),
            None => None,
        };
        let tangents = Self::tangents(primitive, materials, buffers)?;
        let tangents = tangents.filter(|tangents| tangents.count == positions.count && uvs.is_some());
        if let Some(colors) = &colors {
            check_count(colors, ["colour", "colours"], &positions, buffers)?;
        }
        if let Some(values) = &values {
            check_count(values, ["number", "numbers"], &positions, buffers)?;
        }
        let uv_set = uvs.as_ref().map(|(_, placement)| placement.set);
        let (index, targets) = ([mesh, primitive.index()], pose.targets);
        let read = (uv_set, tangents.is_some());
        let differences = targets.of_primitive(index, pose.weights, read, buffers)?;
        for difference in &differences {
            let what = ["difference", "differences"];
            check_count(&difference.elements, what, &positions, buffers)?;
        }
        let skinning = match &pose.joints {
            Some(joints) => Skinning::of(mesh, primitive, joints, buffers)?,
            None => None,
        };
        for elements in skinning.iter().flat_map(Skinning::elements) {
            check_count(elements, ["element", "elements"], &positions, buffers)?;
        }
        Ok(Some(Self {
            mode: primitive.mode(),
            tint,
            material,
            is_textured: placement.is_some(),
            uvs: uvs.filter(|(uvs, _)| uvs.count == positions.count),
            normals: normals.filter(|normals| normals.count == positions.count),
            tangents,
            colors,
            values,
            positions,
            differences,
            skinning,
            indices,
            corners: None,
        }))
    }

    /// The tangents of a primitive, if its material shows a normal map. Without normals they do not count, as the specification
    /// says.
    fn tangents(
        primitive: &Primitive<'_>,
        materials: &[Shown],
        buffers: &mut Buffers<'a>,
    ) -> Result<Option<Rc<Elements<'a>>>, LoadError> {
        let shown = primitive.material().index().and_then(|i| materials.get(i));
        let is_mapped = shown.is_some_and(|shown| shown.surface.textures.normal_map.is_some());
        let has_normals = primitive.get(&Semantic::Normals).is_some();
        let accessor = primitive.get(&Semantic::Tangents);
        match accessor.filter(|_| is_mapped && has_normals) {
            Some(accessor) => Ok(Some(buffers.tangents(&accessor)?)),
            None => Ok(None),
        }
    }

    /// Whether joints place it.
    pub(super) fn is_skinned(&self) -> bool {
        self.skinning.is_some()
    }

    /// Whether morph targets change it.
    pub(super) fn is_morphed(&self) -> bool {
        !self.differences.is_empty()
    }

    /// How many differences and sets of joints place its vertices; 0 before it is prepared.
    pub(super) fn pose_steps(&self) -> usize {
        let sets = self.skinning.as_ref().map_or(0, Skinning::set_count);
        self.used_count()
            .saturating_mul(sets.saturating_add(self.differences.len()))
    }

    /// What the morph targets make of an attribute of vertex `i`.
    pub(super) fn morphed(&self, attribute: Attribute, i: usize, numbers: [f32; 3]) -> DVec3 {
        let vector = DVec3::from_array(numbers.map(f64::from));
        if self.is_morphed() {
            vector + morphs::sum(&self.differences, attribute, i)
        } else {
            vector
        }
    }

    /// What places vertex `i`, if `world` places the shape.
    pub(super) fn matrix(&self, i: usize, world: &DMat4, buffers: &Buffers<'_>) -> Result<DMat4, LoadError> {
        match &self.skinning {
            Some(skinning) => Ok(*world * skinning.matrix(i, buffers)?),
            None => Ok(*world),
        }
    }

    fn corner_count(&self) -> usize {
        self.indices.as_ref().unwrap_or(&self.positions).count
    }

    pub(super) fn triangle_count(&self) -> usize {
        match self.mode {
            mode if is_of_cloud(mode) => 0,
            Mode::TriangleStrip | Mode::TriangleFan => self.corner_count().saturating_sub(2),
            _ => self.corner_count() / 3,
        }
    }

    /// How many segments of lines it has.
    pub(super) fn line_count(&self) -> usize {
        let corners = self.corner_count();
        match self.mode {
            Mode::LineStrip => corners.saturating_sub(1),
            Mode::LineLoop if corners > 2 => corners,
            // A loop of two corners would have its segment twice.
            Mode::Lines | Mode::LineLoop => corners / 2,
            _ => 0,
        }
    }

    /// How many points it has at most.
    pub(super) fn point_count(&self) -> usize {
        if is_of_cloud(self.mode) {
            self.positions.count.min(self.corner_count())
        } else {
            0
        }
    }

    /// Whether it leaves vertices to other shapes: most of them, or any if each would be visible.
    fn uses_few(&self) -> bool {
        let is_seen = is_of_cloud(self.mode) && self.indices.is_some();
        is_seen || self.positions.count > self.corner_count()
    }

    /// How many vertices it adds, as far as that is known without reading it.
    pub(super) fn vertices_at_least(&self) -> usize {
        if self.uses_few() { 0 } else { self.positions.count }
    }

    /// Reads and checks the corners.
    pub(super) fn prepare(&mut self, buffers: &Buffers<'_>) -> Result<(), LoadError> {
        if self.corners.is_some() {
            return Ok(());
        }
        let (count, vertices) = (self.corner_count(), self.positions.count);
        let mut corners = Vec::new();
        let room = buffers.budget().reserve(&mut corners, count);
        room.map_err(|error| buffers.no_room(error))?;
        match &self.indices {
            Some(indices) => {
                corners.extend((0..count).map(|i| indices.index(i)));
                if let Some(i) = corners.iter().position(|&index| index as usize >= vertices) {
                    return Err(buffers.refused(format!(
                        "accessors[{}]: vertex index {} (number {}), but the primitive has only {vertices} vertices",
                        indices.accessor,
                        corners[i],
                        i + 1
                    )));
                }
            }
            None => corners.extend(0..count as u32),
        }
        let mut used = None;
        if self.uses_few() {
            let mut all = Vec::new();
            let room = buffers.budget().reserve(&mut all, count);
            room.map_err(|error| buffers.no_room(error))?;
            all.extend_from_slice(&corners);
            all.sort_unstable();
            all.dedup();
            for corner in &mut corners {
                *corner = all.partition_point(|vertex| vertex < corner) as u32;
            }
            used = Some(all);
        }
        self.corners = Some(Corners {
            used,
            vertices: corners,
        });
        Ok(())
    }

    /// Forgets the corners.
    pub(super) fn release(&mut self, budget: &Budget) {
        let Some(corners) = self.corners.take() else {
            return;
        };
        let used = corners.used.map_or(0, |used| used.capacity());
        budget.give_back((used + corners.vertices.capacity()) * size_of::<u32>());
    }

    /// How many vertices it uses; 0 before it is prepared.
    pub(super) fn used_count(&self) -> usize {
        match &self.corners {
            None => 0,
            Some(Corners { used: Some(used), .. }) => used.len(),
            Some(_) => self.positions.count,
        }
    }

    /// The vertices that it uses.
    pub(super) fn used(&self) -> impl Iterator<Item = usize> {
        let used = self.corners.as_ref().and_then(|corners| corners.used.as_deref());
        (0..self.used_count()).map(move |i| used.map_or(i, |used| used[i] as usize))
    }

    /// Adds its segments of lines; the first of the vertices that it uses has the index `base`.
    pub(super) fn add_lines(&self, lines: &mut Vec<[u32; 2]>, base: u32) {
        let Some(corners) = &self.corners else { return };
        let count = corners.vertices.len();
        let step = if self.mode == Mode::Lines { 2 } else { 1 };
        lines.extend((0..self.line_count()).map(|i| {
            // Only a loop returns to its first corner.
            [i * step, (i * step + 1) % count].map(|i| corners.vertices[i] + base)
        }));
    }

    /// Adds its triangles; the first of the vertices that it uses has the index `base`.
    pub(super) fn add_triangles(&self, triangles: &mut Vec<[u32; 3]>, base: u32) {
        let Some(corners) = &self.corners else { return };
        let corner = |i: usize| corners.vertices[i] + base;
        let all = 0..self.triangle_count();
        match self.mode {
            // Every other triangle of a strip has the opposite winding.
            Mode::TriangleStrip => triangles.extend(all.map(|i| {
                let (a, b) = if i % 2 == 0 { (i, i + 1) } else { (i + 1, i) };
                [a, b, i + 2].map(corner)
            })),
            Mode::TriangleFan => triangles.extend(all.map(|i| [0, i + 1, i + 2].map(corner))),
            _ => triangles.extend(all.map(|i| [3 * i, 3 * i + 1, 3 * i + 2].map(corner))),
        }
    }
}

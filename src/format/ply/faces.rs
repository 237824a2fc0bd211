//! The faces of a mesh, or its lines, while they are read.

use super::{fault::Fault, painted::Paint};
use crate::{
    format::{
        budget::{Budget, BudgetError},
        mesh::{Scalars, Unusable},
        polygon::Fans,
    },
    scene::is_usable,
};

/// The faces or lines of a mesh; all indices are checked.
pub(super) struct Faces<'a> {
    pub(super) triangles: Vec<[u32; 3]>,
    /// The ends of lines, if there are no faces.
    pub(super) lines: Vec<[u32; 2]>,
    /// Which of them are polygons.
    pub(super) fans: Fans,
    /// Their colours and textures.
    pub(super) paint: Paint,
    /// How many faces have fewer than three corners; they are left out.
    pub(super) small: usize,
    /// Numbers that are shown instead of colours.
    pub(super) values: Scalars,
    /// Vertices that are not usable.
    pub(super) unusable: Unusable<Fault>,
    /// How many normals are not usable.
    pub(super) odd_normals: usize,
    /// What is less than opaque.
    pub(super) translucent: Translucent,
    /// How many texture coordinates are not usable.
    pub(super) odd_uvs: usize,
    /// The memory budget of all.
    pub(super) budget: &'a Budget,
}

/// Whether an alpha is less than 1.
#[derive(Clone, Copy, Default)]
pub(super) struct Translucent {
    pub(super) vertex: bool,
    pub(super) face: bool,
}

/// What replaces a texture coordinate that is not usable.
pub(super) const UNKNOWN_UV: [f32; 2] = [0.0; 2];

/// A texture coordinate with its origin at the upper left corner; the file's is the lower left one. `None` if it is not
/// usable.
pub(super) fn upper_left([u, v]: [f32; 2]) -> Option<[f32; 2]> {
    (is_usable(u) && is_usable(v)).then_some([u, 1.0 - v])
}

impl<'a> Faces<'a> {
    pub(super) fn new(budget: &'a Budget) -> Self {
        Self {
            triangles: Vec::new(),
            lines: Vec::new(),
            fans: Fans::default(),
            paint: Paint::default(),
            small: 0,
            values: Scalars::default(),
            unusable: Unusable::default(),
            odd_normals: 0,
            translucent: Translucent::default(),
            odd_uvs: 0,
            budget,
        }
    }

    /// Adds a part of the faces, which has no paint.
    pub(super) fn append(&mut self, mut part: Self) -> Result<(), BudgetError> {
        self.small += part.small;
        self.fans.append(part.fans, self.triangles.len(), self.budget)?;
        if self.triangles.capacity() == 0 {
            self.triangles = part.triangles;
        } else {
            self.budget.reserve(&mut self.triangles, part.triangles.len())?;
            self.triangles.append(&mut part.triangles);
        }
        Ok(())
    }

    /// Adds a polygon with this many corners, whose triangles follow.
    #[inline]
    pub(super) fn add_fan(&mut self, corners: usize) -> Result<(), BudgetError> {
        self.small += usize::from(corners < 3);
        let triangles = corners.saturating_sub(2);
        self.budget.reserve(&mut self.triangles, triangles)?;
        self.fans.add(self.triangles.len(), triangles, 1, self.budget)
    }
}

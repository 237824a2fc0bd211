//! The faces of a mesh, while they are read.

use crate::{
    format::{
        budget::{Budget, BudgetError},
        polygon::Fans,
    },
    scene::TriangleMesh,
};

/// The faces of a mesh; all indices are checked.
pub(super) struct Faces<'a> {
    pub(super) triangles: Vec<[u32; 3]>,
    /// Which of them are polygons.
    pub(super) fans: Fans,
    /// What both take their memory from.
    pub(super) budget: &'a Budget,
}

impl<'a> Faces<'a> {
    pub(super) fn new(budget: &'a Budget) -> Self {
        Self {
            triangles: Vec::new(),
            fans: Fans::default(),
            budget,
        }
    }

    /// Adds a part of the faces.
    pub(super) fn append(&mut self, mut part: Self) -> Result<(), BudgetError> {
        self.fans.append(part.fans, self.triangles.len(), self.budget)?;
        if self.triangles.capacity() == 0 {
            self.triangles = part.triangles;
        } else {
            self.budget.reserve(&mut self.triangles, part.triangles.len())?;
            self.triangles.append(&mut part.triangles);
        }
        Ok(())
    }

    /// Adds a polygon of triangles that follow.
    #[inline]
    pub(super) fn add_fan(&mut self, triangles: usize) -> Result<(), BudgetError> {
        self.budget.reserve(&mut self.triangles, triangles)?;
        self.fans.add(self.triangles.len(), triangles, 1, self.budget)
    }

    /// Moves them into the mesh that has their vertices.
    pub(super) fn add_to(self, mesh: &mut TriangleMesh) {
        mesh.triangles = self.triangles;
        self.fans.cut_concave(mesh);
    }
}

//! Parts of meshes that are stored once and placed several times.

use super::LoadedMesh;
use crate::scene::{PlacedMesh, Transform, TriangleMesh};

/// A part of a mesh that is stored once and placed several times.
#[derive(Clone, Debug, Default)]
pub struct SharedMesh {
    /// Positions, normals, colours and triangles, before they are placed; else as [`LoadedMesh::columns`].
    pub columns: TriangleMesh,
    /// An index into [`LoadedMesh::surfaces`] for each triangle; empty if the mesh has no surfaces.
    pub surface_of: Vec<u32>,
    /// Its placements, in the file's coordinates less [`LoadedMesh::offset`]. Each of them can place an instance.
    pub placements: Vec<Transform>,
}

/// How a mesh that a file places several times is stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sharing {
    /// Baked: once for each placement.
    #[default]
    Never,
    /// Once if that saves much memory, because instances are slower to trace.
    WherePays,
    /// Once.
    Always,
}

impl LoadedMesh {
    /// The arrays of all parts.
    pub(crate) fn arrays(&self) -> impl Iterator<Item = &TriangleMesh> {
        std::iter::once(&self.columns).chain(self.shared.iter().map(|part| &part.columns))
    }

    /// The arrays of all parts.
    pub(crate) fn arrays_mut(&mut self) -> impl Iterator<Item = &mut TriangleMesh> {
        let shared = self.shared.iter_mut().map(|part| &mut part.columns);
        std::iter::once(&mut self.columns).chain(shared)
    }

    /// Whether any vertex has a colour.
    pub(super) fn has_colors(&self) -> bool {
        self.arrays().any(|columns| !columns.colors.is_empty())
    }

    /// Returns all parts and their placements.
    #[must_use]
    pub fn placed(&self) -> Vec<PlacedMesh<'_>> {
        let shared = self.shared.iter().map(|part| PlacedMesh {
            mesh: &part.columns,
            placements: &part.placements,
        });
        std::iter::once(PlacedMesh::in_place(&self.columns))
            .chain(shared)
            .collect()
    }
}

//! Parts of meshes that stand in several places and are stored once.

use super::LoadedMesh;
use crate::scene::{PlacedMesh, Transform, TriangleMesh};

/// A part of a mesh that is stored once and stands in several places.
#[derive(Debug, Default)]
pub struct SharedMesh {
    /// Positions, normals, colours and triangles, before they are placed; else as [`LoadedMesh::columns`].
    pub columns: TriangleMesh,
    /// An index into [`LoadedMesh::surfaces`] for each triangle; empty if there are none.
    pub surface_of: Vec<u32>,
    /// Where it stands, in the file's coordinates. Each of these can place an instance.
    pub placements: Vec<Transform>,
}

/// What becomes of a mesh that a file places several times.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sharing {
    /// It is stored once for each place.
    #[default]
    Never,
    /// It is stored once where that saves much memory: instances take more time to trace.
    WherePays,
    /// It is stored once.
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

    /// Returns all parts and where they stand.
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

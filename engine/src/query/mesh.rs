//! Geometries of meshes from files, and of vertices as they were kept.

use super::{Geometry, QueryError};
use crate::scene::TriangleMesh;
use glam::DVec3;

impl Geometry {
    /// Makes a geometry of the triangles of a mesh. Normals, colours and texture coordinates are ignored.
    ///
    /// # Errors
    /// As [`Geometry::from_triangles`], or [`QueryError::Length`] if `x`, `y` and `z` differ in length.
    pub fn from_mesh(mesh: &TriangleMesh) -> Result<Self, QueryError> {
        let expected = mesh.x.len();
        for (what, found) in [("values of y", mesh.y.len()), ("values of z", mesh.z.len())] {
            if found != expected {
                return Err(QueryError::Length {
                    what,
                    found,
                    expected,
                });
            }
        }
        let mut positions: Vec<[f32; 3]> = Vec::new();
        let what = "the vertices";
        (positions.try_reserve_exact(expected)).map_err(|_| QueryError::NoMemory { what })?;
        positions.extend((0..expected).map(|i| [mesh.x[i], mesh.y[i], mesh.z[i]]));
        Self::from_triangles(&positions, &mesh.triangles)
    }

    /// As [`Geometry::from_mesh`], for a mesh that is relative to `offset`, as octray's `format::mesh::load`
    /// reads those in coordinates of a map. Queries are in world space.
    ///
    /// ```
    /// # use octray_engine as octray;
    /// # use octray::scene::TriangleMesh;
    /// use octray::{Geometry, glam::DVec3};
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # let mesh = TriangleMesh { x: vec![0.0, 1.0, 0.0], y: vec![0.0, 0.0, 1.0], z: vec![0.0; 3], triangles: vec![[0, 1, 2]], ..TriangleMesh::default() };
    /// let geometry = Geometry::from_mesh_at(&mesh, DVec3::new(450_000.0, 5_400_000.0, 200.0))?;
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// As [`Geometry::from_mesh`], or [`QueryError::Middle`] if the offset is not finite.
    pub fn from_mesh_at(mesh: &TriangleMesh, offset: DVec3) -> Result<Self, QueryError> {
        Self::from_mesh(mesh)?.moved_by(offset)
    }

    /// Makes a geometry again of what [`vertices`](Self::vertices) and [`triangles`](Self::triangles) returned. Its
    /// answers are the same, to the bit.
    ///
    /// # Errors
    /// As [`Geometry::from_triangles`], or [`QueryError::Middle`] if `middle` is not finite.
    pub fn from_relative(
        positions: &[[f32; 3]],
        middle: DVec3,
        triangles: &[[u32; 3]],
    ) -> Result<Self, QueryError> {
        Self::from_triangles(positions, triangles)?.moved_by(middle)
    }

    fn moved_by(mut self, offset: DVec3) -> Result<Self, QueryError> {
        let values = offset.to_array();
        if let Some(axis) = values.iter().position(|value| !value.is_finite()) {
            return Err(QueryError::Middle {
                axis,
                value: values[axis],
            });
        }
        self.offset += offset;
        Ok(self)
    }
}

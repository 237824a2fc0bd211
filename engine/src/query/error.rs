//! Errors of geometries and queries.

use crate::error::SceneError;
use std::fmt;

/// Says why a geometry or a query was refused.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum QueryError {
    /// A coordinate is NaN, infinite, or farther than [`MAX_COORDINATE`](crate::scene::MAX_COORDINATE) from 0 (from the
    /// middle of the geometry, if that is far from 0).
    Coordinate {
        /// "vertex", "sphere" or "instance".
        what: &'static str,
        /// Its index.
        index: usize,
        /// The coordinate found.
        value: f64,
    },
    /// The point that coordinates are relative to is not finite.
    Middle {
        /// 0 for x, 1 for y, 2 for z.
        axis: usize,
        /// The coordinate found.
        value: f64,
    },
    /// A sphere's radius is not a number above 0 and at most [`MAX_COORDINATE`](crate::scene::MAX_COORDINATE).
    Radius {
        /// The sphere's index.
        sphere: usize,
        /// The radius found.
        radius: f32,
    },
    /// A triangle has an index beyond the vertices.
    VertexIndex {
        /// The triangle's index.
        triangle: usize,
        /// The vertex index found.
        index: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// More than 32-bit ids or the hierarchy can count.
    TooMany {
        /// "primitives", "vertices", "meshes", "instances" or "pixels along a side".
        what: &'static str,
        /// The largest number allowed.
        limit: usize,
    },
    /// Memory ran out.
    NoMemory {
        /// Its purpose.
        what: &'static str,
    },
    /// An array's length does not match the others.
    Length {
        /// Which array.
        what: &'static str,
        /// Its length.
        found: usize,
        /// The length expected.
        expected: usize,
    },
    /// The triangles do not enclose a space: an edge belongs to an odd number of them.
    NotClosed {
        /// The vertices at its ends; of several vertices at one position the first.
        edge: [u32; 2],
    },
    /// Spheres have no inside in these queries.
    HasSpheres,
    /// An instance has the index of a mesh that does not exist.
    MeshIndex {
        /// The instance's index.
        instance: usize,
        /// The mesh index found.
        index: usize,
        /// How many meshes there are.
        meshes: usize,
    },
    /// A transform has a number that is NaN or infinite.
    NotFinite {
        /// The instance's index.
        instance: usize,
    },
    /// A transform flattens its mesh, or nearly so, or scales it by less than `f32` resolves.
    Flat {
        /// The instance's index.
        instance: usize,
    },
}

impl fmt::Display for QueryError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Coordinate { what, index, value } if value.is_finite() => write!(
                f,
                "{what} {index} has the coordinate {value:e}, but numbers above 1e9 are not supported"
            ),
            Self::Coordinate { what, index, value } => {
                write!(
                    f,
                    "{what} {index} has the coordinate {value}, expected a finite number"
                )
            }
            Self::Middle { axis, value } => write!(
                f,
                "the middle of the geometry has the {} {value}, expected a finite number",
                ["x", "y", "z"].get(*axis).unwrap_or(&"")
            ),
            Self::Radius { sphere, radius } => {
                write!(
                    f,
                    "sphere {sphere} has radius {radius}, expected a number above 0 and at most 1e9"
                )
            }
            Self::VertexIndex {
                triangle,
                index,
                vertices,
            } => write!(
                f,
                "triangle {triangle} has vertex index {index}, but there are only {vertices} vertices"
            ),
            Self::TooMany { what, limit } => write!(f, "too many {what}, at most {limit} are supported"),
            Self::NoMemory { what } => write!(f, "not enough memory for {what}"),
            Self::Length {
                what,
                found,
                expected,
            } => write!(f, "{found} {what}, expected {expected}"),
            Self::NotClosed { edge: [a, b] } => write!(
                f,
                "the mesh is not closed: the edge between vertices {a} and {b} belongs to an odd number of triangles"
            ),
            Self::HasSpheres => {
                f.write_str("inside and outside are told for triangles alone, without spheres")
            }
            Self::MeshIndex {
                instance,
                index,
                meshes,
            } => write!(
                f,
                "instance {instance} is of mesh {index}, but there are only {meshes} meshes"
            ),
            Self::NotFinite { instance } => write!(
                f,
                "the transform of instance {instance} has a number that is not finite"
            ),
            Self::Flat { instance } => write!(
                f,
                "the transform of instance {instance} flattens it: it has no inverse in single precision"
            ),
        }
    }
}

impl std::error::Error for QueryError {}

impl From<SceneError> for QueryError {
    /// What the scene builder refuses after positions, radii and indices were checked.
    fn from(error: SceneError) -> Self {
        match error {
            SceneError::VertexIndex {
                triangle,
                index,
                vertices,
            } => Self::VertexIndex {
                triangle,
                index,
                vertices,
            },
            SceneError::TooMany { what, limit } => Self::TooMany { what, limit },
            SceneError::NoMemory { what } => Self::NoMemory { what },
            _ => Self::NoMemory { what: "the geometry" },
        }
    }
}

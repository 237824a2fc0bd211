//! The canonical tests: one primitive against eight rays, and eight primitives against one ray.
//!
//! Only this module decides what is a hit, by one function for each primitive, generic over lanes: triangles for one
//! ray, or rays for one triangle. Its scalar twin is in [`reference`](mod@crate::reference) and must agree bit for bit.
//! Callers may hoist subexpressions that rays share, such as the edge functions of a triangle seen from a shared origin,
//! but may not reorder or replace an operation.
//!
//! A hit must also lie in the interval in which its ray passes the primitive's own padded box. So it lies in every
//! box of any tree above it, and rounding never puts a sliver's hit far from the sliver.

mod block;
mod bounds;
mod doubt;
mod indexed;
mod plane;
mod sphere;
mod triangle;

pub use block::TriangleBlock;
pub use bounds::padded;
pub(crate) use bounds::{ENTRY_SCALE, EXIT_SCALE, Slabs, interval};
pub(crate) use doubt::{meets, starts_on_planes};
pub use indexed::IndexedBlock;
pub(crate) use plane::plane_hits;
pub use sphere::SphereBlock;
pub(crate) use sphere::{chord, padded_sphere_boxes, sphere_exit, sphere_hits};
pub(crate) use triangle::{
    CANDIDATE_SLACK, EdgeFunctions, Edges, TriangleHits, TriangleTest, edge_functions, may_hit, padded_boxes,
    weights,
};

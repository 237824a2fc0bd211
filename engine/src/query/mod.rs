//! Ray queries: geometry from arrays, rays in world space, closest hit, any hit, all hits, closest point, inside or
//! outside.
//!
//! ```text
//! positions, triangles, spheres -> Geometry: scene relative to its centre, BVH
//! rays (any length, f32 or f64) -> unit rays in f32 (unit) -> many: packets through the tracer (worker)
//!                                                          -> one: a visit with a sink (sinks, crossings, exact, places)
//! geometries, transforms -> InstancedGeometry: prototypes and instances, by the same paths (instanced)
//! camera -> a ray per pixel (camera)
//! points -> in Z order (z_order) -> closest point (nearest; of placed geometries instanced::nearest)
//!        -> inside (inside: crossings on the way out)
//! ```
//! All hits are those of the canonical test: the same for one ray and for many, at every level, on any number of threads.

mod all;
mod camera;
mod coordinates;
mod crossings;
mod error;
#[doc(hidden)]
pub mod exact;
mod geometry;
mod inside;
mod instanced;
mod mesh;
#[doc(hidden)]
pub mod nearest;
mod order;
mod places;
mod points;
mod rays;
#[doc(hidden)]
pub mod sinks;
#[doc(hidden)]
pub mod starts;
#[doc(hidden)]
pub mod unit;
mod worker;
mod z_order;

pub use all::AllHits;
pub use camera::CameraRays;
pub use error::QueryError;
pub use geometry::{Geometry, Sphere, SurfacePoint};
pub use instanced::{InstancedClosestPoint, InstancedGeometry, InstancedHit};
pub use nearest::ClosestPoint;
pub use rays::{Ends, Points, Ray, Rays};
pub use worker::Worker;

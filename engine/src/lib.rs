//! The engine of octray: scenes, hierarchies, traced rays, shading, queries.
//!
//! Use the crate `octray`: it has this crate's API, reads files and is documented. What is hidden here may change with
//! every version.

pub use glam;
pub use math::Aabb;
pub use query::{Geometry, InstancedGeometry, InstancedHit, QueryError, Ray, Rays};
pub use ray::{Hit, InstanceId, PrimitiveId};
pub use simd::{Level, LevelError, isa};

pub mod accel;
#[doc(hidden)]
pub mod classic;
pub mod error;
#[doc(hidden)]
pub mod geometry;
#[doc(hidden)]
pub mod lanes;
#[doc(hidden)]
pub mod math;
pub mod query;
#[doc(hidden)]
pub mod ray;
#[doc(hidden)]
pub mod reference;
pub mod render;
pub mod scene;
#[doc(hidden)]
pub mod shade;
#[doc(hidden)]
pub mod simd;
#[doc(hidden)]
pub mod sobol;
#[doc(hidden)]
pub mod trace;
#[doc(hidden)]
pub mod whole_file;

//! octray traces rays through scenes of triangle meshes and spheres on the CPU.

pub mod accel;
pub mod bench;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;
pub mod course;
pub mod error;
pub mod format;
pub mod generate;
pub mod geometry;
pub mod math;
pub mod ray;
pub mod reference;
pub mod render;
pub mod scene;
pub mod shade;
pub mod simd;
pub mod trace;

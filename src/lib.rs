//! octray traces rays through scenes of triangle meshes and spheres on the CPU.

pub mod accel;
pub mod course;
pub mod error;
pub mod format;
pub mod generate;
pub mod math;
pub mod ray;
pub mod render;
pub mod scene;
pub mod simd;

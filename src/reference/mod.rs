//! The scalar truth, written plainly and separately from the kernels: one ray at a time, over every primitive
//! ([`brute`], the oracle) or over a binary BVH ([`bvh`], the honest baseline), and the shading of one ray.

pub mod brute;
pub mod bvh;
pub mod cost;
mod primitive;
pub mod shade;

pub use primitive::{RaySlabs, intersect_shape};

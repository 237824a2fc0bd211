//! The scalar reference, written independently of the SIMD kernels.
//!
//! It traces one ray at a time, over every primitive ([`brute`], the test oracle) or a binary BVH ([`bvh`], the speed
//! baseline), and shades one ray ([`mod@shade`]).

pub mod brute;
pub mod bvh;
pub mod cost;
mod draw;
mod primitive;
pub mod shade;

use primitive::{RaySlabs, intersect_shape};

#[cfg(test)]
mod tests;

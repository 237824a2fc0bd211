//! The scalar reference, written independently of the SIMD kernels.
//!
//! It traces one ray at a time, over every primitive ([`brute`], the test oracle) or a binary BVH ([`bvh`], the speed
//! baseline), and shades one ray ([`mod@shade`]).

pub mod brute;
pub mod bvh;
pub mod cost;
mod draw;
mod glass;
mod instances;
pub(crate) mod light;
mod planes;
mod primitive;
pub mod shade;
mod surface;

use crate::{ray::Hit, scene::Scene};
pub(crate) use draw::disc;
pub(crate) use planes::{block as planes_block, closest as closest_plane};
use primitive::{RaySlabs, intersect_shape};

/// Whether a hit counts; `cut_outs` is the scene if rays pass where its surfaces are cut out.
#[inline(always)]
fn counts(cut_outs: Option<&Scene>, hit: &Hit) -> bool {
    cut_outs.is_none_or(|scene| !scene.is_cut_out(hit.primitive, [hit.u, hit.v]))
}

#[cfg(test)]
mod tests;

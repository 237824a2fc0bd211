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
#[doc(hidden)]
pub mod light;
mod medium;
mod planes;
mod primitive;
pub mod shade;
mod surface;
mod through;

use crate::{
    ray::{Hit, Ray},
    scene::Scene,
};
pub(crate) use draw::disc;
#[doc(hidden)]
pub use medium::medium_at;
use primitive::{RaySlabs, intersect_shape};
#[doc(hidden)]
pub use through::first_hit_at;
pub(crate) use through::seen_at;

/// Where rays pass surfaces.
#[derive(Clone, Copy)]
pub enum Passing<'a> {
    /// Nowhere: cut-outs are ignored.
    Nowhere,
    /// Where the scene's surfaces are cut out.
    CutOuts(&'a Scene),
    /// For ambient rays: at cut-outs, glass and surfaces of low opacity.
    Light(&'a Scene),
    /// Wherever surfaces are not opaque.
    NotOpaque(&'a Scene),
    /// At cut-outs and the backs of one-sided surfaces.
    Backs(&'a Scene),
    /// At the backs of one-sided surfaces and wherever surfaces are not opaque.
    BacksNotOpaque(&'a Scene),
}

impl<'a> Passing<'a> {
    fn of(scene: Option<&'a Scene>, passing: fn(&'a Scene) -> Self) -> Self {
        scene.map_or(Self::Nowhere, passing)
    }

    /// Whether a ray stops at a hit.
    #[inline(always)]
    fn counts(self, ray: &Ray, hit: &Hit) -> bool {
        match self {
            Self::Nowhere => true,
            Self::CutOuts(scene) => !scene.is_cut_out(hit.primitive, [hit.u, hit.v]),
            Self::Light(scene) => !scene.lets_light_pass(hit.primitive, [hit.u, hit.v]),
            Self::NotOpaque(scene) => scene.is_opaque(hit.primitive, [hit.u, hit.v]),
            Self::Backs(scene) => {
                !scene.is_back(ray, hit.primitive) && !scene.is_cut_out(hit.primitive, [hit.u, hit.v])
            }
            Self::BacksNotOpaque(scene) => {
                !scene.is_back(ray, hit.primitive) && scene.is_opaque(hit.primitive, [hit.u, hit.v])
            }
        }
    }
}

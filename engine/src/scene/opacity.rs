//! Half-transparent surfaces: their opacity, and the rays that they stop.

use super::{Primitive, Scene, SurfaceTextures, Texture, material::check_share};
use crate::{error::SceneError, ray::PrimitiveId};

/// No ray hits surfaces with an opacity below this.
const LEAST: f32 = 1.0 / 512.0;

/// From this opacity on, surfaces stop ambient rays.
const STOPS_LIGHT: f32 = 0.5;

/// The opacity of a surface. The rest of the light from behind passes straight through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Opacity {
    /// From 0, invisible, to 1.
    pub factor: f32,
    /// The image whose alpha multiplies it, on triangles; mipmaps are not used.
    pub map: Option<Texture>,
    /// Whether light from behind is multiplied by the base colour, with its textures, as by coloured glass.
    pub is_tinted: bool,
}

impl Opacity {
    /// Returns that of a factor and an image; `None` if they leave the surface opaque.
    #[must_use]
    pub fn new(factor: f32, map: Option<Texture>) -> Option<Self> {
        (factor < 1.0 || map.is_some()).then_some(Self {
            factor,
            map,
            is_tinted: false,
        })
    }

    /// Returns the same with another image; `None` if the surface is opaque then.
    #[must_use]
    #[doc(hidden)]
    pub fn with_map(self, map: Option<Texture>) -> Option<Self> {
        let is_tinted = self.is_tinted;
        Self::new(self.factor, map).map(|opacity| Self { is_tinted, ..opacity })
    }

    /// Refuses a factor out of range.
    pub(super) fn check(&self) -> Result<(), SceneError> {
        check_share("opacity", self.factor)
    }

    fn at(&self, scene: &Scene, triangle: Option<usize>, weights: [f32; 2]) -> f32 {
        let (Some(map), Some(i)) = (self.map, triangle) else {
            return self.factor;
        };
        let at = scene.texture_coordinates(i, weights);
        let [.., alpha] = scene.images[map.image as usize].color(map, at, 0.0);
        self.factor * alpha
    }
}

impl SurfaceTextures {
    /// Returns whether some rays may pass, because of cut-outs or low opacity.
    pub(super) fn lets_rays_pass(&self) -> bool {
        let may_pass = |opacity: Opacity| opacity.map.is_some() || opacity.factor < STOPS_LIGHT;
        self.cut_out.is_some() || self.opacity.is_some_and(may_pass)
    }

    /// Returns whether all rays stop everywhere.
    fn stops_rays(&self) -> bool {
        let stops = |opacity: Opacity| opacity.map.is_none() && opacity.factor >= 1.0;
        self.cut_out.is_none() && self.opacity.is_none_or(stops)
    }
}

impl Scene {
    /// Returns whether a surface is half-transparent.
    #[inline]
    #[must_use]
    pub fn has_blending(&self) -> bool {
        self.has_blending
    }

    /// Returns whether some rays may pass surfaces; see [`is_cut_out`](Self::is_cut_out) and
    /// [`lets_light_pass`](Self::lets_light_pass).
    #[inline]
    #[must_use]
    pub fn has_cut_outs(&self) -> bool {
        self.has_cut_outs || self.has_glass
    }

    /// Returns whether any surface may be [cut out](Self::is_cut_out).
    pub(crate) fn has_holes(&self) -> bool {
        self.has_cut_outs
    }

    /// Returns the opacity of a primitive: of a triangle at the point with these weights of its second and third corner.
    #[must_use]
    pub fn opacity(&self, id: PrimitiveId, weights: [f32; 2]) -> f32 {
        self.found(id).map_or(1.0, |(textures, triangle)| {
            let opacity = textures.opacity;
            opacity.map_or(1.0, |opacity| opacity.at(self, triangle, weights))
        })
    }

    /// Returns whether all rays pass the surface there.
    #[must_use]
    pub fn is_cut_out(&self, id: PrimitiveId, weights: [f32; 2]) -> bool {
        // A tinted surface is visible by its tint.
        self.is_less_opaque(id, weights, |opacity| if opacity.is_tinted { 0.0 } else { LEAST })
    }

    /// Returns whether ambient rays pass the surface there: glass, and what is not very opaque.
    #[must_use]
    pub fn lets_light_pass(&self, id: PrimitiveId, weights: [f32; 2]) -> bool {
        self.is_glass(id) || self.is_less_opaque(id, weights, |_| STOPS_LIGHT)
    }

    /// Returns whether some rays may pass through a primitive.
    pub(crate) fn lets_rays_pass(&self, id: PrimitiveId) -> bool {
        let textures = self.textures_of(id);
        self.is_glass(id) || textures.is_some_and(SurfaceTextures::lets_rays_pass)
    }

    /// Returns whether all rays stop everywhere at a primitive, and all light.
    pub(crate) fn stops_rays(&self, id: PrimitiveId) -> bool {
        !self.is_glass(id) && self.textures_of(id).is_none_or(SurfaceTextures::stops_rays)
    }

    /// Returns whether all rays stop at the surface there, and all light.
    pub(crate) fn is_opaque(&self, id: PrimitiveId, weights: [f32; 2]) -> bool {
        !self.is_glass(id) && self.opacity(id, weights) >= 1.0 && !self.is_cut_out(id, weights)
    }

    fn is_less_opaque(&self, id: PrimitiveId, weights: [f32; 2], limit: impl Fn(&Opacity) -> f32) -> bool {
        if !self.lets_rays_pass(id) {
            return false;
        }
        let Some((textures, triangle)) = self.found(id) else {
            return false;
        };
        let passes = |opacity: Opacity| opacity.at(self, triangle, weights) < limit(&opacity);
        let is_cut = triangle.is_some_and(|i| self.cuts_out(textures, i, weights));
        is_cut || textures.opacity.is_some_and(passes)
    }

    /// The textures of a primitive, and its number if it is a triangle.
    fn found(&self, id: PrimitiveId) -> Option<(&SurfaceTextures, Option<usize>)> {
        let textures = self.textures_of(id)?;
        let triangle = match self.primitive(id) {
            Primitive::Triangle(i) => Some(i),
            Primitive::Sphere(_) | Primitive::Plane(_) => None,
        };
        Some((textures, triangle))
    }
}

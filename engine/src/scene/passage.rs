//! Light that passes straight through surfaces to a point: through half-transparent ones and through glass, where it is
//! dimmed by each side's reflection and tinted inside. It is not refracted, so there are no caustics.

use super::{Material, MaterialId, Scene};
use crate::{
    math::min,
    ray::{Hit, PrimitiveId, Ray, T_MAX},
    simd::Simd,
};
use glam::Vec3;

/// Light counts as blocked if less than this share is left in all channels.
const LEAST: f32 = 1.0 / 512.0;

/// The most surfaces that light passes; the next one is opaque.
const MOST_SURFACES: u8 = 64;

/// Length of [`skipped`] in offsets: one before the surface, one behind it, and one for rounding.
const SKIPPED: f32 = 3.0;

/// The least cosine between light and a normal.
const MIN_COSINE: f32 = 1e-6;

/// Where light meets a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing {
    pub primitive: PrimitiveId,
    /// Weights of the second and third corner of a triangle.
    pub weights: [f32; 2],
    /// Distance from the last surface or the start, scene units.
    pub distance: f32,
    pub direction: Vec3,
    /// Unit geometric normal against the direction.
    pub geometric_normal: Vec3,
    /// Unit shading normal.
    pub normal: Vec3,
    /// Whether the back of the surface is hit.
    pub from_behind: bool,
    /// The base colour there, with those of vertices and textures.
    pub base: [f32; 3],
}

impl Crossing {
    /// A hit on a surface with this base colour; the rest is set later.
    pub fn at(hit: &Hit, base: [f32; 3]) -> Self {
        Self {
            primitive: hit.primitive,
            weights: [hit.u, hit.v],
            distance: hit.t,
            direction: Vec3::ZERO,
            geometric_normal: Vec3::ZERO,
            normal: Vec3::ZERO,
            from_behind: false,
            base,
        }
    }
}

/// Light on its way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Passage {
    /// The share that is left, by channel; 0 if it is blocked.
    pub left: [f32; 3],
    /// The glass that it is in.
    medium: Option<MaterialId>,
    /// The tinted glass at its start and at its end, as far as the ray that is shaded knows it.
    known: [Option<MaterialId>; 2],
    /// How far it went before the first glass, which it may have started in; `None` once it has met any.
    before_glass: Option<f32>,
    /// Where it ends, unless it comes from infinity.
    end: Option<Vec3>,
    surfaces: u8,
}

impl Passage {
    /// Light along a shadow ray, from the light or towards it. `medium` is the tinted glass at the surface.
    pub fn along(ray: &Ray, is_from_light: bool, medium: Option<MaterialId>) -> Self {
        Self {
            left: [1.0; 3],
            medium: None,
            known: if is_from_light {
                [None, medium]
            } else {
                [medium, None]
            },
            before_glass: Some(0.0),
            end: (ray.t_max < T_MAX).then(|| ray.origin + ray.direction * ray.t_max),
            surfaces: 0,
        }
    }

    /// Returns the ray that continues at `origin`, to the same end: offsets from surfaces do not add up. Its `t_max` is 0 if
    /// the end is not ahead.
    #[inline(always)]
    pub fn onward<S: Simd>(&self, simd: S, origin: Vec3, direction: Vec3) -> Ray {
        let Some(end) = self.end else {
            return Ray::new(origin, direction);
        };
        let way = end - origin;
        let length = simd.dot(way, way).sqrt();
        if simd.dot(way, direction) > 0.0 {
            Ray {
                t_max: length,
                ..Ray::new(origin, way * (1.0 / length))
            }
        } else {
            Ray {
                t_max: 0.0,
                ..Ray::new(origin, direction)
            }
        }
    }

    /// Passes a surface, and returns whether any light is left. Both modes call it.
    #[inline(always)]
    pub fn cross<S: Simd>(&mut self, simd: S, scene: &Scene, at: &Crossing) -> bool {
        let id = scene.material_of(at.primitive);
        let material = scene.materials()[id.0 as usize];
        if let Material::Glass { index, .. } = material {
            if let Some(before) = self.before_glass.take() {
                self.medium = if at.from_behind { Some(id) } else { self.known[0] };
                self.tint(scene, before);
            }
            self.tint(scene, at.distance);
            self.medium = (!at.from_behind).then_some(id);
            let passed = 1.0 - reflected(simd, index, at);
            self.left = self.left.map(|left| left * passed);
        } else {
            self.tint(scene, at.distance);
            if let Some(before) = &mut self.before_glass {
                *before += at.distance;
            }
            let share = 1.0 - scene.opacity(at.primitive, at.weights);
            let textures = scene.textures_of(at.primitive);
            let is_tinted = textures.is_some_and(|all| all.opacity.is_some_and(|one| one.is_tinted));
            let tint = if is_tinted { at.base } else { [1.0; 3] };
            self.left = std::array::from_fn(|c| self.left[c] * (share * tint[c]));
        }
        self.surfaces += 1;
        let is_left = self.left.iter().any(|&left| left >= LEAST) && self.surfaces <= MOST_SURFACES;
        if !is_left {
            self.left = [0.0; 3];
        }
        is_left
    }

    /// Reaches the end, at this distance behind the last surface. Behind a single surface of glass infinity is not tinted, as
    /// for camera rays.
    pub fn arrive(&mut self, scene: &Scene, distance: f32) {
        if self.end.is_none() {
            return;
        }
        let [start, end] = self.known;
        if let Some(before) = self.before_glass {
            self.medium = start.or(end);
            self.tint(scene, before + distance);
        } else {
            self.medium = self.medium.or(end);
            self.tint(scene, distance);
        }
    }

    fn tint(&mut self, scene: &Scene, distance: f32) {
        if let Some(medium) = self.medium {
            let passed = scene.materials()[medium.0 as usize].transmittance(distance);
            self.left = std::array::from_fn(|c| self.left[c] * passed[c]);
        }
    }
}

/// Returns the short ray through what a ray skips that passes a surface at `t`, since it continues at an offset behind the
/// surface. An opaque surface there is hit first, so that no light leaks past it. `None` if the ray starts or ends there:
/// then the surface that it leaves or reaches may be the opaque one. Both modes call it.
#[inline(always)]
pub(crate) fn skipped<S: Simd>(
    simd: S,
    ray: &Ray,
    t: f32,
    (point, normal): (Vec3, Vec3),
    offset: f32,
) -> Option<Ray> {
    let along_ray = min(t, ray.t_max - t);
    let is_apart = -simd.dot(ray.direction, normal) * along_ray > offset;
    is_apart.then(|| Ray {
        origin: simd.mul_add3(normal, offset, point),
        direction: -normal,
        t_max: offset * SKIPPED,
    })
}

impl Scene {
    /// Returns whether a material is glass.
    #[must_use]
    pub fn has_glass(&self) -> bool {
        self.has_glass
    }

    /// Returns whether a primitive is of glass.
    pub(super) fn is_glass(&self, id: PrimitiveId) -> bool {
        self.has_glass
            && matches!(
                self.materials()[self.material_of(id).0 as usize],
                Material::Glass { .. }
            )
    }

    /// Returns whether a material is opaque anywhere.
    pub(crate) fn may_be_opaque(&self, id: MaterialId) -> bool {
        let opacity = self.textures(id).and_then(|textures| textures.opacity);
        let is_dim = opacity.is_some_and(|opacity| opacity.factor < 1.0);
        !is_dim && !matches!(self.materials()[id.0 as usize], Material::Glass { .. })
    }

    /// Returns whether light may pass a material.
    pub(crate) fn passes_light(&self, id: MaterialId) -> bool {
        let is_glass = matches!(self.materials()[id.0 as usize], Material::Glass { .. });
        is_glass
            || self
                .textures(id)
                .is_some_and(|textures| textures.opacity.is_some())
    }

    /// Returns whether light may pass some surfaces in part.
    pub(crate) fn dims_light(&self) -> bool {
        self.has_glass() || self.has_blending()
    }
}

/// The share that glass reflects, by Fresnel's equations for unpolarised light from outside, also for light from inside:
/// both directions along a ray have the same.
#[inline(always)]
fn reflected<S: Simd>(simd: S, index: f32, at: &Crossing) -> f32 {
    let facing = -simd.dot(at.direction, at.normal);
    let cosine = if facing > 0.0 {
        facing
    } else {
        -simd.dot(at.direction, at.geometric_normal)
    };
    let cosine = cosine.clamp(MIN_COSINE, 1.0);
    let ratio = 1.0 / index;
    let bent = (1.0 - ratio * ratio * (1.0 - cosine * cosine)).max(0.0).sqrt();
    let across = (ratio * cosine - bent) / (ratio * cosine + bent);
    let along = (cosine - ratio * bent) / (cosine + ratio * bent);
    0.5 * (across * across + along * along)
}

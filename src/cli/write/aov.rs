//! Converts AOVs to pictures of bytes and EXR channels, for `--aov`.
//!
//! No scale depends on the picture's pixels, so the files of a crop are parts of the whole picture's.

use super::exr_layers::{Channel, Values};
use crate::{
    heat::heat,
    math::Aabb,
    ray::{InstanceId, PrimitiveId},
    render::{Aov, Aovs, ByteFilm, Transfer, quantize},
    scene::{Camera, Projection},
};
use glam::Vec3;
use serde::Serialize;

/// Which AOV (arbitrary output variable).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum AovKind {
    /// Distance from the eye.
    Depth,
    /// Shading normal.
    Normal,
    /// The material's own colour.
    Albedo,
    /// Which triangle or sphere.
    Id,
    /// How many nodes and primitives the ray visited.
    Heat,
}

impl AovKind {
    /// As on the command line and in file names.
    pub fn name(self) -> &'static str {
        match self {
            Self::Depth => "depth",
            Self::Normal => "normal",
            Self::Albedo => "albedo",
            Self::Id => "id",
            Self::Heat => "heat",
        }
    }
}

/// The depths that are shown as white and as black: the nearest and farthest points of the scene's bounds. The
/// scale between is logarithmic, so small things on a wide ground stay visible.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DepthRange {
    pub white: f32,
    pub black: f32,
}

impl DepthRange {
    /// As seen by `camera`.
    pub fn of(bounds: Aabb, camera: &Camera) -> Self {
        match camera.view().projection {
            Projection::Perspective { .. } => Self::from(bounds, camera.eye()),
            Projection::Orthographic { .. } => Self::along(bounds, camera.eye(), camera.forward()),
        }
    }

    fn along(bounds: Aabb, eye: Vec3, forward: Vec3) -> Self {
        let [a, b] = [bounds.lower, bounds.upper].map(|corner| (corner - eye) * forward);
        let black = a.max(b).element_sum().max(f32::MIN_POSITIVE);
        Self {
            white: a.min(b).element_sum().max(black * NEAREST),
            black,
        }
    }

    fn from(bounds: Aabb, eye: Vec3) -> Self {
        if bounds.lower.cmpgt(bounds.upper).any() {
            return Self {
                white: 0.0,
                black: 1.0,
            };
        }
        let nearest = eye.clamp(bounds.lower, bounds.upper);
        let farthest = (bounds.lower - eye).abs().max((bounds.upper - eye).abs());
        let black = farthest.length();
        Self {
            white: (nearest - eye).length().max(black * NEAREST),
            black,
        }
    }

    fn gray(self, depth: f32) -> u8 {
        let [white, black, depth] = [self.white, self.black, depth].map(|t| libm::log(f64::from(t)));
        quantize(((black - depth) / (black - white).max(f64::MIN_POSITIVE)) as f32)
    }
}

/// White starts at this share of the farthest distance at least: the eye may be inside the bounds.
const NEAREST: f32 = 1e-4;

/// A colour for an id of a primitive and of its instance; neighbouring ids get different ones.
fn id_color(PrimitiveId(id): PrimitiveId, InstanceId(instance): InstanceId) -> [u8; 3] {
    // Fibonacci hashing (Knuth): the golden ratio's share of 2^32. Without an instance the second term is 0.
    let bits = id.wrapping_add(1).wrapping_mul(0x9e37_79b9);
    let bits = bits ^ instance.wrapping_add(1).wrapping_mul(0xc2b2_ae35).rotate_left(7);
    let bits = (bits ^ bits >> 15).wrapping_mul(0x85eb_ca6b);
    [24, 16, 8].map(|shift| 55 + ((bits >> shift & 0xff) * 200 / 255) as u8)
}

/// The AOV as a picture of bytes.
pub fn picture(aovs: &Aovs, which: AovKind, range: DepthRange, transfer: Transfer) -> ByteFilm {
    let color = |pixel: &Aov| match which {
        AovKind::Heat => heat(pixel.cost.total()),
        AovKind::Albedo => transfer.encode(pixel.albedo),
        _ if pixel.primitive == PrimitiveId::NONE => [0; 3],
        AovKind::Depth => [range.gray(pixel.depth); 3],
        AovKind::Normal => pixel.normal.map(|c| quantize(c * 0.5 + 0.5)),
        AovKind::Id => id_color(pixel.primitive, pixel.instance),
    };
    let mut film = ByteFilm::black(aovs.width, aovs.height);
    for (to, pixel) in film.pixels_mut().iter_mut().zip(&aovs.pixels) {
        *to = color(pixel);
    }
    film
}

/// The AOV's EXR channels, unscaled.
pub fn channels(aovs: &Aovs, which: AovKind) -> Vec<Channel> {
    let floats = |name: &'static str, value: &dyn Fn(&Aov) -> f32| Channel {
        name: name.into(),
        values: Values::Floats(aovs.pixels.iter().map(value).collect()),
    };
    let whole = |name: &'static str, value: &dyn Fn(&Aov) -> u32| Channel {
        name: name.into(),
        values: Values::Whole(aovs.pixels.iter().map(value).collect()),
    };
    match which {
        AovKind::Depth => vec![floats("depth.Z", &|p| p.depth)],
        AovKind::Normal => vec![
            floats("normal.X", &|p| p.normal[0]),
            floats("normal.Y", &|p| p.normal[1]),
            floats("normal.Z", &|p| p.normal[2]),
        ],
        AovKind::Albedo => vec![
            floats("albedo.R", &|p| p.albedo[0]),
            floats("albedo.G", &|p| p.albedo[1]),
            floats("albedo.B", &|p| p.albedo[2]),
        ],
        AovKind::Id if aovs.have_instances => vec![
            whole("id.instance", &|p| p.instance.0),
            whole("id.primitive", &|p| p.primitive.0),
        ],
        AovKind::Id => vec![whole("id.primitive", &|p| p.primitive.0)],
        AovKind::Heat => vec![
            whole("heat.nodes", &|p| p.cost.nodes),
            whole("heat.primitives", &|p| p.cost.primitives),
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depth_spans_the_scene() {
        let bounds = Aabb {
            lower: Vec3::ZERO,
            upper: Vec3::splat(2.0),
        };
        let range = DepthRange::from(bounds, Vec3::new(-3.0, 1.0, 1.0));
        assert_eq!(
            (range.white, range.gray(3.0), range.gray(range.black)),
            (3.0, 255, 0)
        );
        let within = DepthRange::from(bounds, Vec3::ONE);
        assert!(within.white > 0.0 && within.gray(0.0) == 255);
        DepthRange::from(Aabb::EMPTY, Vec3::ONE);
        let parallel = DepthRange::along(bounds, Vec3::new(-3.0, 9.0, 1.0), Vec3::X);
        assert_eq!((parallel.white, parallel.black), (3.0, 5.0));
        assert!(DepthRange::along(Aabb::EMPTY, Vec3::ONE, Vec3::X).white > 0.0);
    }
}

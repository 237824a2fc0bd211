//! Converts AOVs to pictures of bytes and EXR channels, for `--aov`.
//!
//! No scale depends on the picture's pixels, so the files of a crop are parts of the whole picture's.

use super::{
    exr_layers::{Channel, Values},
    picture::Pixels,
};
use crate::{
    heat::heat,
    math::Aabb,
    ray::{InstanceId, PrimitiveId},
    render::{Aov, Aovs, ByteFilm, Settings, Transfer, nearest_byte, quantize},
    scene::{Camera, PixelRays, Plane, Projection, Scene},
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
    /// Whether the ray hit anything.
    Mask,
    /// Depth along the view.
    Z,
    /// Which instance.
    Instance,
}

impl AovKind {
    pub const ALL: [Self; 8] = [
        Self::Depth,
        Self::Normal,
        Self::Albedo,
        Self::Id,
        Self::Heat,
        Self::Mask,
        Self::Z,
        Self::Instance,
    ];

    /// As on the command line and in file names.
    pub fn name(self) -> &'static str {
        match self {
            Self::Depth => "depth",
            Self::Normal => "normal",
            Self::Albedo => "albedo",
            Self::Id => "id",
            Self::Heat => "heat",
            Self::Mask => "mask",
            Self::Z => "z",
            Self::Instance => "instance",
        }
    }

    /// Whether programs read its numbers, in grey PNG files: the others show colours.
    pub fn is_exact(self) -> bool {
        matches!(self, Self::Mask | Self::Z | Self::Instance)
    }
}

/// The depths that are shown as white and as black: the nearest and farthest points of the scene's bounds, and of infinite
/// planes the eye's distance from each and [`PLANE_REACH`] times that. It does not depend on what a picture shows of them,
/// so crops fit together. The scale between is logarithmic, so small things on a wide ground stay visible.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DepthRange {
    pub white: f32,
    pub black: f32,
}

impl DepthRange {
    /// As seen by `camera`.
    pub fn of(scene: &Scene, camera: &Camera) -> Self {
        let view = camera.view();
        let (bounds, eye) = (scene.bounds(), (view.eye - scene.offset()).as_vec3());
        let to_plane = |plane: &Plane| {
            let apart = (plane.point - eye).dot(plane.normal);
            match view.projection {
                Projection::Perspective { .. } => [apart.abs(); 2],
                // It may be nearer than in the middle of the picture, or only be seen away from it.
                Projection::Orthographic { height } => {
                    let (height, middle) = (height as f32, apart / camera.forward().dot(plane.normal));
                    [middle.max(height / PLANE_REACH), middle.max(0.0) + height]
                }
            }
        };
        let planes = scene.planes().iter().map(to_plane);
        let is_empty = bounds.lower.cmpgt(bounds.upper).any();
        match view.projection {
            _ if is_empty => Self::nothing().with_planes(planes),
            Projection::Perspective { .. } => Self::from(bounds, eye).with_planes(planes),
            Projection::Orthographic { .. } => Self::along(bounds, eye, camera.forward()).with_planes(planes),
        }
    }

    /// That of no primitives.
    fn nothing() -> Self {
        Self {
            white: f32::INFINITY,
            black: 0.0,
        }
    }

    /// With the nearest and farthest distances of planes. A plane through the eye, or along parallel rays, is seen as nothing.
    fn with_planes(self, distances: impl Iterator<Item = [f32; 2]>) -> Self {
        let (mut nearest, mut farthest) = (f32::INFINITY, 0.0_f32);
        for [near, far] in distances.filter(|[near, far]| *near > 0.0 && far.is_finite()) {
            nearest = nearest.min(near);
            farthest = farthest.max(far);
        }
        let range = Self {
            white: self.white.min(nearest).max(self.black.max(farthest) * NEAREST),
            black: self.black.max((farthest * PLANE_REACH).min(f32::MAX)),
        };
        if range.white < range.black || self.black > 0.0 {
            range
        } else {
            Self {
                white: 0.0,
                black: 1.0,
            }
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
        let nearest = eye.clamp(bounds.lower, bounds.upper);
        let farthest = (bounds.lower - eye).abs().max((bounds.upper - eye).abs());
        let black = farthest.length();
        Self {
            white: (nearest - eye).length().max(black * NEAREST),
            black,
        }
    }

    /// At least 1: 0 is for what hits nothing.
    fn gray(self, depth: f32) -> u8 {
        let [white, black, depth] = [self.white, self.black, depth].map(|t| libm::log(f64::from(t)));
        quantize(((black - depth) / (black - white).max(f64::MIN_POSITIVE)) as f32).max(1)
    }
}

/// White starts at this share of the farthest distance at least: the eye may be inside the bounds.
const NEAREST: f32 = 1e-4;

/// A plane is black from this multiple of its distance: over a ground, half a degree below the horizon.
const PLANE_REACH: f32 = 100.0;

/// A colour for an id of a primitive and of its instance; neighbouring ids get different ones.
fn id_color(PrimitiveId(id): PrimitiveId, InstanceId(instance): InstanceId) -> [u8; 3] {
    // Fibonacci hashing (Knuth): the golden ratio's share of 2^32. Without an instance the second term is 0.
    let bits = id.wrapping_add(1).wrapping_mul(0x9e37_79b9);
    let bits = bits ^ instance.wrapping_add(1).wrapping_mul(0xc2b2_ae35).rotate_left(7);
    let bits = (bits ^ bits >> 15).wrapping_mul(0x85eb_ca6b);
    [24, 16, 8].map(|shift| 55 + ((bits >> shift & 0xff) * 200 / 255) as u8)
}

/// The rows of a picture's pixels and the depth along the view of what they see.
#[derive(Clone, Copy, Debug)]
pub struct Axis {
    /// The first column and row.
    first: [u32; 2],
    /// Columns of the crop.
    width: u32,
    /// The principal point, pixels.
    middle: [f64; 2],
    /// Focal lengths, pixels; infinite if rays are parallel.
    focal: [f64; 2],
    /// The traced rays and the direction of the view, if there is a distortion.
    distorted: Option<(PixelRays, Vec3)>,
}

impl Axis {
    /// The axis of a picture with these settings.
    pub fn of(scene: &Scene, camera: &Camera, settings: &Settings) -> Self {
        let (width, height) = (settings.width, settings.height);
        let intrinsics = camera.intrinsics(width, height);
        let (middle, focal) = intrinsics.map_or(([0.0; 2], [f64::INFINITY; 2]), |intrinsics| {
            (intrinsics.principal_point, intrinsics.focal)
        });
        let crop = settings.crop;
        Self {
            first: crop.map_or([0, 0], |crop| [crop.x0, crop.y0]),
            width: crop.map_or(settings.width, |crop| crop.width()),
            middle,
            focal,
            distorted: camera
                .distortion()
                .map(|_| (camera.pixel_rays(scene, width, height, 1), camera.forward())),
        }
    }

    /// The depth along the view of the pixel with that index.
    pub fn z(&self, index: usize, pixel: &Aov) -> f64 {
        let (x, y) = (index as u32 % self.width, index as u32 / self.width);
        let [x, y] = [self.first[0] + x, self.first[1] + y];
        let depth = f64::from(pixel.depth);
        if let Some((rays, forward)) = self.distorted.filter(|_| depth.is_finite()) {
            let direction = rays.direction(x, y, [0, 0]).as_dvec3();
            return depth * direction.dot(forward.as_dvec3());
        }
        let point = [x, y].map(|at| f64::from(at) + 0.5);
        let [x, y] = [0, 1].map(|axis| (point[axis] - self.middle[axis]) / self.focal[axis]);
        depth / (1.0 + x * x + y * y).sqrt()
    }
}

/// 0 for a miss, 1 outside of instances, then the instances.
pub fn instance_number(pixel: &Aov) -> u32 {
    match (pixel.primitive, pixel.instance) {
        (PrimitiveId::NONE, _) => 0,
        (_, InstanceId::NONE) => 1,
        (_, InstanceId(id)) => id.saturating_add(2),
    }
}

/// Scene units of a step of depth in a PNG file, unless another is given.
pub const Z_STEP: f64 = 0.001;

/// The last step of depth that a PNG file holds.
const LAST_STEP: f64 = 65535.0;

/// The farthest depth that a PNG file holds, scene units.
pub fn farthest_z(step: f64) -> f64 {
    LAST_STEP / (1.0 / step)
}

/// Depth in steps.
fn z_steps(z: f64, step: f64) -> f64 {
    libm::round(z * (1.0 / step))
}

/// How many pixels show something beyond [`farthest_z`].
pub fn beyond_z(aovs: &Aovs, axis: Axis, step: f64) -> usize {
    let pixels = aovs.pixels.iter().enumerate();
    pixels
        .filter(|(i, pixel)| {
            pixel.primitive != PrimitiveId::NONE && z_steps(axis.z(*i, pixel), step) > LAST_STEP
        })
        .count()
}

/// An AOV whose numbers programs read, as grey pixels.
pub fn exact(aovs: &Aovs, which: AovKind, axis: Axis, z_step: f64) -> Pixels {
    let wide = |value: &dyn Fn(usize, &Aov) -> u16| {
        let values = aovs.pixels.iter().enumerate().map(|(i, pixel)| value(i, pixel));
        values.flat_map(u16::to_be_bytes).collect::<Vec<u8>>()
    };
    let (bytes, pixel_bytes) = match which {
        AovKind::Z => {
            let known = |steps: f64| if steps <= LAST_STEP { steps as u16 } else { 0 };
            (wide(&|i, pixel| known(z_steps(axis.z(i, pixel), z_step))), 2)
        }
        AovKind::Instance => (wide(&|_, pixel| instance_number(pixel).min(65535) as u16), 2),
        _ => (aovs.pixels.iter().map(mask).collect(), 1),
    };
    Pixels::Gray {
        size: [aovs.width, aovs.height],
        bytes,
        pixel_bytes,
    }
}

fn mask(pixel: &Aov) -> u8 {
    if pixel.primitive == PrimitiveId::NONE {
        0
    } else {
        255
    }
}

/// The AOV as a picture of colours.
pub fn picture(aovs: &Aovs, which: AovKind, range: DepthRange, transfer: Transfer) -> ByteFilm {
    let color = |pixel: &Aov| match which {
        AovKind::Heat => heat(pixel.cost.total()),
        AovKind::Albedo => transfer.encode(pixel.albedo),
        _ if pixel.primitive == PrimitiveId::NONE => [0; 3],
        AovKind::Depth => [range.gray(pixel.depth); 3],
        AovKind::Normal => pixel.normal.map(|c| nearest_byte(c * 0.5 + 0.5)),
        AovKind::Id => id_color(pixel.primitive, pixel.instance),
        AovKind::Mask | AovKind::Z | AovKind::Instance => [255; 3],
    };
    let mut film = ByteFilm::black(aovs.width, aovs.height);
    for (to, pixel) in film.pixels_mut().iter_mut().zip(&aovs.pixels) {
        *to = color(pixel);
    }
    film
}

/// The AOV's EXR channels, unscaled.
pub fn channels(aovs: &Aovs, which: AovKind, axis: Axis) -> Vec<Channel> {
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
        AovKind::Mask => vec![floats("mask.Y", &|p| f32::from(mask(p) / 255))],
        AovKind::Z => {
            let z = aovs.pixels.iter().enumerate().map(|(i, p)| axis.z(i, p) as f32);
            vec![Channel {
                name: "z.Z".into(),
                values: Values::Floats(z.collect()),
            }]
        }
        AovKind::Instance => vec![whole("instance.number", &instance_number)],
    }
}

#[cfg(test)]
mod tests;

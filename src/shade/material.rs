//! One pass for each kind of material: light to colour, and mirrored rays into the next queue.

use super::{SURFACE_OFFSET, TileColors, queue::RayQueue, surface::SurfacePacket};
use crate::{
    ray::{RayPacket, T_MAX},
    scene::{Material, Scene},
    simd::{F32x8, Mask8, Vec3x8, gt, max, min, mul_add, powi, splat},
};

/// The light that arrives at eight points, over all lights so far, by channel.
#[derive(Clone, Copy, Debug)]
pub struct Light8 {
    /// Sum of I_i max(0, n.l_i).
    diffuse: [F32x8; 3],
    /// Sum of I_i max(0, n.h_i)^alpha.
    specular: [F32x8; 3],
}

impl Light8 {
    /// No light.
    pub const NONE: Self = Self {
        diffuse: [F32x8::ZERO; 3],
        specular: [F32x8::ZERO; 3],
    };
}

/// What one light brings to the points of one material.
#[derive(Clone, Copy, Debug)]
pub struct OneLight<'a> {
    /// Its intensities.
    pub power: [f32; 3],
    /// n.l at the points; 0: hidden or behind.
    pub arriving: &'a [F32x8],
    /// The unit directions to it.
    pub toward: &'a [Vec3x8],
}

impl Light8 {
    #[inline(always)]
    fn add(sums: &mut [F32x8; 3], power8: [F32x8; 3], share: F32x8) {
        for (sum, power8) in sums.iter_mut().zip(power8) {
            *sum = mul_add(power8, share, *sum);
        }
    }

    /// With one more light on a surface that only scatters.
    #[inline(always)]
    fn with_diffuse(mut self, power8: [F32x8; 3], facing: F32x8) -> Self {
        Self::add(&mut self.diffuse, power8, facing);
        self
    }

    /// With one more light on a surface with highlights.
    #[inline(always)]
    fn with_gloss(
        mut self,
        power8: [F32x8; 3],
        facing: F32x8,
        toward: Vec3x8,
        s: &SurfacePacket,
        alpha: u32,
    ) -> Self {
        Self::add(&mut self.diffuse, power8, facing);
        let halfway = (toward - s.direction).normalize();
        let highlight = powi(max(s.normal.dot(halfway), splat(0.0)), alpha);
        let lit = gt(facing, splat(0.0)).select(highlight, splat(0.0));
        Self::add(&mut self.specular, power8, lit);
        self
    }
}

/// Adds a light to `light`, which holds the sums of the lights before; the first one puts its own there. (Sums that were
/// made 0 first, and highlights in a loop of their own: shading of the course's blinn_phong.scn took 7 % longer.)
pub fn add_light(
    material: &Material,
    one: OneLight<'_>,
    surfaces: &[SurfacePacket],
    light: &mut [Light8],
    is_first: bool,
) {
    let power8 = one.power.map(splat);
    let arriving = one.arriving.iter().zip(one.toward).zip(surfaces);
    let before = |sum: &Light8| if is_first { Light8::NONE } else { *sum };
    if let Material::BlinnPhong { alpha, .. } = material {
        for (sum, ((&facing, &toward), s)) in light.iter_mut().zip(arriving) {
            *sum = before(sum).with_gloss(power8, facing, toward, s, *alpha);
        }
    } else {
        for (sum, &facing) in light.iter_mut().zip(one.arriving) {
            *sum = before(sum).with_diffuse(power8, facing);
        }
    }
}

/// Colours the points of one material, and queues the rays that it mirrors.
pub fn color(
    scene: &Scene,
    material: &Material,
    surfaces: &[SurfacePacket],
    light: &[Light8],
    colors: &mut TileColors,
    next: &mut RayQueue,
) {
    let ambient = splat(scene.ambient());
    match material {
        Material::Silhouette { color } => silhouette(*color, surfaces, colors),
        Material::Matte { color } => matte(*color, 1.0, ambient, surfaces, light, colors),
        Material::BlinnPhong {
            diffuse,
            specular,
            k_d,
            k_s,
            ..
        } => {
            let lobes = [(*diffuse, *k_d), (*specular, *k_s)];
            blinn_phong(lobes, ambient, surfaces, light, colors);
        }
        Material::Reflection { color, mirror_share } => {
            matte(*color, 1.0 - mirror_share, ambient, surfaces, light, colors);
            mirror(*mirror_share, surfaces, next);
        }
    }
}

fn silhouette(color: [f32; 3], surfaces: &[SurfacePacket], colors: &mut TileColors) {
    for s in surfaces {
        colors.add(s.active, &s.pixel, s.weight, color.map(splat));
    }
}

fn matte(
    color: [f32; 3],
    share: f32,
    ambient: F32x8,
    surfaces: &[SurfacePacket],
    light: &[Light8],
    colors: &mut TileColors,
) {
    for (s, light) in surfaces.iter().zip(light) {
        let channel = |i: usize| splat(color[i]) * min(ambient + light.diffuse[i], splat(1.0));
        let weight = s.weight * splat(share);
        colors.add(s.active, &s.pixel, weight, [channel(0), channel(1), channel(2)]);
    }
}

fn blinn_phong(
    [(diffuse, k_d), (specular, k_s)]: [([f32; 3], f32); 2],
    ambient: F32x8,
    surfaces: &[SurfacePacket],
    light: &[Light8],
    colors: &mut TileColors,
) {
    for (s, light) in surfaces.iter().zip(light) {
        let channel = |i: usize| {
            let body = mul_add(splat(k_d), light.diffuse[i], ambient);
            let gloss = splat(k_s) * light.specular[i];
            let sum = mul_add(splat(diffuse[i]), body, splat(specular[i]) * gloss);
            min(max(sum, splat(0.0)), splat(1.0))
        };
        colors.add(s.active, &s.pixel, s.weight, [channel(0), channel(1), channel(2)]);
    }
}

/// Mirrored directions d - 2 (d.n) n, from just off the surface.
fn mirror(share: f32, surfaces: &[SurfacePacket], next: &mut RayQueue) {
    for s in surfaces {
        let along = s.direction.dot(s.normal);
        let direction = s.normal.mul_add(splat(-2.0) * along, s.direction).normalize();
        let origin = s
            .geometric_normal
            .mul_add(s.magnitude * splat(SURFACE_OFFSET), s.point);
        let t_max = Mask8::from_bits(s.active).select(splat(T_MAX), splat(0.0));
        next.push_from(
            origin,
            RayPacket { direction, t_max },
            s.pixel,
            s.weight * splat(share),
        );
    }
}

/// What rays see that leave the scene along `direction`. Twin of [`Background::color`](crate::scene::Background::color).
#[inline(always)]
pub(crate) fn background(scene: &Scene, direction: &Vec3x8) -> [F32x8; 3] {
    let background = scene.background();
    let share = mul_add(direction.z, splat(0.5), splat(0.5));
    let share = min(max(share, splat(0.0)), splat(1.0));
    let rise = background.rise();
    std::array::from_fn(|channel| mul_add(share, splat(rise[channel]), splat(background.bottom[channel])))
}

/// Gives the rays of a queue that is not traced any further the background.
pub fn end_of_depth(scene: &Scene, rays: &RayQueue, colors: &mut TileColors) {
    for (p, packet) in rays.rays.packets().iter().enumerate() {
        let active = gt(packet.t_max, splat(0.0)).bits();
        let background = background(scene, &packet.direction);
        colors.add(active, &rays.pixel(p), rays.weight(p), background);
    }
}

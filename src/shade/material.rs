//! One pass for each kind of material: light to colour, and mirrored rays into the next queue.

use super::{SURFACE_OFFSET, TileColors, queue::RayQueue, surface::SurfacePacket};
use crate::{
    ray::{RayPacket, T_MAX},
    scene::{Material, Scene},
    simd::{F32x8, Mask8, Vec3x8, gt, max, min, mul_add, powi, splat},
};
use glam::Vec3;

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

/// Adds a light of intensities `power` at `position` that arrives with `arriving` = n.l (0: hidden or behind).
pub fn add_light(
    material: &Material,
    position: Vec3,
    power: [f32; 3],
    surfaces: &[SurfacePacket],
    arriving: &[F32x8],
    light: &mut [Light8],
) {
    let power8 = power.map(splat);
    let add = |sum: &mut [F32x8; 3], share: F32x8| {
        for (sum, power8) in sum.iter_mut().zip(power8) {
            *sum = mul_add(power8, share, *sum);
        }
    };
    for (sum, &facing) in light.iter_mut().zip(arriving) {
        add(&mut sum.diffuse, facing);
    }
    if let Material::BlinnPhong { alpha, .. } = material {
        let position8 = Vec3x8::splat(position);
        for ((sum, &facing), s) in light.iter_mut().zip(arriving).zip(surfaces) {
            let to_light = (position8 - s.point).normalize();
            let halfway = (to_light - s.direction).normalize();
            let highlight = powi(max(s.normal.dot(halfway), splat(0.0)), *alpha);
            let lit = gt(facing, splat(0.0)).select(highlight, splat(0.0));
            add(&mut sum.specular, lit);
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
pub(super) fn background(scene: &Scene, direction: &Vec3x8) -> [F32x8; 3] {
    let background = scene.background();
    let share = mul_add(direction.z, splat(0.5), splat(0.5));
    let share = min(max(share, splat(0.0)), splat(1.0));
    let rise = background.rise();
    std::array::from_fn(|channel| mul_add(share, splat(rise[channel]), splat(background.bottom[channel])))
}

/// Gives the rays of a queue that is not traced any further the background.
pub fn end_of_depth(scene: &Scene, rays: &RayQueue, colors: &mut TileColors) {
    for ((packet, pixel), &weight) in rays.rays.packets().iter().zip(&rays.pixel).zip(&rays.weight) {
        let background = background(scene, &packet.direction);
        colors.add(gt(packet.t_max, splat(0.0)).bits(), pixel, weight, background);
    }
}

//! Material passes: one for each kind of material, from light to colour and to mirrored rays.

use super::{SURFACE_OFFSET, TileColors, queue::RayQueue, surface::SurfacePacket};
use crate::{
    ray::{RayPacket, T_MAX},
    scene::{Material, Scene},
    simd_old::{F32x8, Mask8, Vec3x8, gt, max, min, mul_add, powi, splat},
};

/// The incident light at eight points, summed over the lights, by channel.
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

/// One light at the points of one material.
#[derive(Clone, Copy, Debug)]
pub struct IncidentLight<'a> {
    /// Intensity times colour.
    pub power: [f32; 3],
    /// n.l at each point; 0 if the light is occluded or behind the surface.
    pub n_dot_l: &'a [F32x8],
    /// The unit direction l from each point.
    pub to_light: &'a [Vec3x8],
}

impl Light8 {
    #[inline(always)]
    fn add(sums: &mut [F32x8; 3], power8: [F32x8; 3], share: F32x8) {
        for (sum, power8) in sums.iter_mut().zip(power8) {
            *sum = mul_add(power8, share, *sum);
        }
    }

    /// Returns the sums with one more light on a diffuse surface.
    #[inline(always)]
    fn with_diffuse(mut self, power8: [F32x8; 3], n_dot_l: F32x8) -> Self {
        Self::add(&mut self.diffuse, power8, n_dot_l);
        self
    }

    /// Returns the sums with one more light on a glossy surface.
    #[inline(always)]
    fn with_gloss(
        mut self,
        power8: [F32x8; 3],
        n_dot_l: F32x8,
        to_light: Vec3x8,
        s: &SurfacePacket,
        alpha: u32,
    ) -> Self {
        Self::add(&mut self.diffuse, power8, n_dot_l);
        let halfway = (to_light - s.direction).normalize();
        let highlight = powi(max(s.normal.dot(halfway), splat(0.0)), alpha);
        let lit = gt(n_dot_l, splat(0.0)).select(highlight, splat(0.0));
        Self::add(&mut self.specular, power8, lit);
        self
    }
}

/// Adds a light to the sums `light`; the first light overwrites them.
// Tuned: see docs/lab-notes.md#add-light
pub fn add_light(
    material: &Material,
    incident: IncidentLight<'_>,
    surfaces: &[SurfacePacket],
    light: &mut [Light8],
    is_first: bool,
) {
    let power8 = incident.power.map(splat);
    let before = |sum: &Light8| if is_first { Light8::NONE } else { *sum };
    if let Material::BlinnPhong { alpha, .. } = material {
        let points = incident.n_dot_l.iter().zip(incident.to_light).zip(surfaces);
        for (sum, ((&n_dot_l, &to_light), s)) in light.iter_mut().zip(points) {
            *sum = before(sum).with_gloss(power8, n_dot_l, to_light, s, *alpha);
        }
    } else {
        for (sum, &n_dot_l) in light.iter_mut().zip(incident.n_dot_l) {
            *sum = before(sum).with_diffuse(power8, n_dot_l);
        }
    }
}

/// Adds the colours of one material's points to the tile, and queues mirrored rays.
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

/// Queues rays along d - 2 (d.n) n, from just off the surface.
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

/// Returns the background along eight directions. Twin of [`Background::color`](crate::scene::Background::color).
#[inline(always)]
pub(crate) fn background(scene: &Scene, direction: &Vec3x8) -> [F32x8; 3] {
    let background = scene.background();
    let share = mul_add(direction.z, splat(0.5), splat(0.5));
    let share = min(max(share, splat(0.0)), splat(1.0));
    let difference = background.difference();
    std::array::from_fn(|channel| {
        mul_add(
            share,
            splat(difference[channel]),
            splat(background.bottom[channel]),
        )
    })
}

/// Adds the background for all rays of a queue, those beyond the maximum depth.
pub fn background_pass(scene: &Scene, rays: &RayQueue, colors: &mut TileColors) {
    for (p, packet) in rays.rays.packets().iter().enumerate() {
        let active = gt(packet.t_max, splat(0.0)).bits();
        let background = background(scene, &packet.direction);
        colors.add(active, &rays.pixel(p), rays.weight(p), background);
    }
}

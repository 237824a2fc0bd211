//! Material passes, one for each kind of material: incident light to colours and mirrored rays.

use super::{SURFACE_OFFSET, TileColors, queue::RayQueue, surface::SurfacePacket, tint::Tint8};
use crate::{
    lanes::{F32x8, LANES, Vec3x8},
    ray::{RayPacket, T_MAX},
    scene::{AMBIENT_SPECULAR, Environment, MOST_POLISH, Material, Scene},
    simd::{EightLanes, LaneMask, Lanes, Simd, Vec3Eight},
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
    /// The power that arrives at each point; empty if it is the same everywhere.
    pub powers: &'a [[F32x8; 3]],
    /// n.l at each point; 0 if the light is occluded or behind the surface.
    pub n_dot_l: &'a [F32x8],
    /// The unit direction l from each point.
    pub to_light: &'a [Vec3x8],
}

/// The points on one material, and the light there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Points<'a> {
    pub surfaces: &'a [SurfacePacket],
    pub light: &'a [Light8],
    /// Factors of the base colour; empty if only materials have colours.
    pub tints: &'a [Tint8],
    /// Factors of the highlight's colour; empty if the material has no map of it.
    pub speculars: &'a [Tint8],
    /// The ambient light; empty if it is the scene's everywhere.
    pub ambient: &'a [F32x8],
    /// The lengths of the paths from the camera; empty in scenes without textures.
    pub distance: &'a [F32x8],
}

impl Points<'_> {
    /// Returns the ambient light at packet `i`, that of the scene by default.
    #[inline(always)]
    fn ambient<S: Simd>(&self, simd: S, i: usize, scene: S::V8) -> S::V8 {
        self.ambient.get(i).map_or(scene, |ambient| simd.load(ambient))
    }
}

/// Adds one more light to a sum.
#[inline(always)]
fn add_power<S: Simd>(simd: S, sums: &mut [F32x8; 3], power: [S::V8; 3], share: S::V8) {
    for (i, sum) in sums.iter_mut().enumerate() {
        *sum = power[i].mul_add(share, simd.load(sum)).to8();
    }
}

/// Returns max(0, n.h)^alpha where light arrives, else 0.
#[inline(always)]
fn highlight<S: Simd>(
    simd: S,
    n_dot_l: S::V8,
    to_light: Vec3Eight<S>,
    s: &SurfacePacket,
    alpha: u32,
) -> S::V8 {
    let halfway = (to_light - simd.load3(&s.direction)).normalize();
    let zero = simd.splat(0.0);
    let highlight = simd.load3(&s.normal).dot(halfway).max(zero).powi(alpha);
    S::V8::select(n_dot_l.gt(zero), highlight, zero)
}

/// Adds a light to the sums `light`; the first light overwrites them.
// Tuned: see docs/lab-notes.md#add-light
#[inline(always)]
pub(super) fn add_light<S: Simd>(
    simd: S,
    material: &Material,
    incident: IncidentLight<'_>,
    surfaces: &[SurfacePacket],
    light: &mut [Light8],
    is_first: bool,
) {
    if is_first {
        for sum in &mut *light {
            *sum = Light8::NONE;
        }
    }
    // Two copies, so that lights of the same power everywhere load none.
    if incident.powers.is_empty() {
        let [r, g, b] = incident.power;
        let power = [simd.splat(r), simd.splat(g), simd.splat(b)];
        add_powers(
            simd,
            material,
            incident,
            #[inline(always)]
            |_| power,
            surfaces,
            light,
        );
    } else {
        add_powers(
            simd,
            material,
            incident,
            #[inline(always)]
            |i: usize| {
                let [r, g, b] = &incident.powers[i];
                [simd.load(r), simd.load(g), simd.load(b)]
            },
            surfaces,
            light,
        );
    }
}

/// Adds a light to the sums `light`; `power` gives its power at a packet.
#[inline(always)]
fn add_powers<S: Simd>(
    simd: S,
    material: &Material,
    incident: IncidentLight<'_>,
    power: impl Fn(usize) -> [S::V8; 3],
    surfaces: &[SurfacePacket],
    light: &mut [Light8],
) {
    if let Material::BlinnPhong { alpha, .. } = material {
        for (i, sum) in light.iter_mut().enumerate() {
            let n_dot_l = simd.load(&incident.n_dot_l[i]);
            add_power(simd, &mut sum.diffuse, power(i), n_dot_l);
            let to_light = simd.load3(&incident.to_light[i]);
            let highlight = highlight(simd, n_dot_l, to_light, &surfaces[i], *alpha);
            add_power(simd, &mut sum.specular, power(i), highlight);
        }
    } else {
        for (i, sum) in light.iter_mut().enumerate() {
            add_power(simd, &mut sum.diffuse, power(i), simd.load(&incident.n_dot_l[i]));
        }
    }
}

/// Adds the colours of one material's points to the tile, and queues mirrored rays.
#[inline(always)]
pub(super) fn color<S: Simd>(
    simd: S,
    scene: &Scene,
    material: &Material,
    points: Points<'_>,
    colors: &mut TileColors,
    next: &mut RayQueue,
) {
    let Points { surfaces, tints, .. } = points;
    let base = match *material {
        Material::Silhouette { color } | Material::Matte { color } | Material::Reflection { color, .. } => {
            color
        }
        // Glass has no colour of its own: see `glass::pass`.
        Material::Glass { .. } => return,
        Material::BlinnPhong { diffuse, .. } => diffuse,
    };
    // Two copies, so that scenes without tints pay nothing for them.
    if tints.is_empty() {
        body(
            simd,
            scene,
            material,
            #[inline(always)]
            |_, channel| simd.splat(base[channel]),
            points,
            colors,
        );
    } else {
        body(
            simd,
            scene,
            material,
            #[inline(always)]
            |i: usize, channel: usize| simd.splat(base[channel]) * simd.load(&tints[i][channel]),
            points,
            colors,
        );
    }
    if let Material::Reflection { mirror_share, .. } = material {
        mirror(simd, *mirror_share, surfaces, next);
        for &distance in points.distance {
            next.push_travelled(distance);
        }
    }
}

/// Adds the light that surfaces emit.
#[inline(always)]
pub(super) fn emission<S: Simd>(
    simd: S,
    surfaces: &[SurfacePacket],
    light: &[Tint8],
    colors: &mut TileColors,
) {
    for (s, light) in surfaces.iter().zip(light) {
        let light = [simd.load(&light[0]), simd.load(&light[1]), simd.load(&light[2])];
        colors.add(simd, s.active, &s.pixel, simd.load(&s.weight), light);
    }
}

#[inline(always)]
fn silhouette<S: Simd>(
    simd: S,
    base: impl Fn(usize, usize) -> S::V8,
    surfaces: &[SurfacePacket],
    colors: &mut TileColors,
) {
    for (i, s) in surfaces.iter().enumerate() {
        let color = [base(i, 0), base(i, 1), base(i, 2)];
        colors.add(simd, s.active, &s.pixel, simd.load(&s.weight), color);
    }
}

/// Adds the light that a material scatters; `base` gives a channel of its colour at the points of a packet.
#[inline(always)]
fn body<S: Simd>(
    simd: S,
    scene: &Scene,
    material: &Material,
    base: impl Fn(usize, usize) -> S::V8,
    points: Points<'_>,
    colors: &mut TileColors,
) {
    let ambient = simd.splat(scene.ambient());
    let most = simd.splat(scene.most_light());
    match *material {
        Material::Silhouette { .. } => silhouette(simd, base, points.surfaces, colors),
        Material::Glass { .. } => {}
        Material::Matte { .. } => matte(simd, base, 1.0, (ambient, most), points, colors),
        Material::Reflection { mirror_share, .. } => {
            matte(simd, base, 1.0 - mirror_share, (ambient, most), points, colors);
        }
        Material::BlinnPhong {
            specular, k_d, k_s, ..
        } => {
            let lit = (ambient, scene.ambient_specular(), most);
            // Two copies, as for tints.
            if points.speculars.is_empty() {
                blinn_phong(
                    simd,
                    (base, k_d),
                    #[inline(always)]
                    |_, channel| simd.splat(specular[channel]),
                    k_s,
                    lit,
                    points,
                    colors,
                );
            } else {
                blinn_phong(
                    simd,
                    (base, k_d),
                    #[inline(always)]
                    |i: usize, channel: usize| {
                        simd.splat(specular[channel]) * simd.load(&points.speculars[i][channel])
                    },
                    k_s,
                    lit,
                    points,
                    colors,
                );
            }
        }
    }
}

#[inline(always)]
fn matte<S: Simd>(
    simd: S,
    base: impl Fn(usize, usize) -> S::V8,
    share: f32,
    (ambient, most): (S::V8, S::V8),
    points: Points<'_>,
    colors: &mut TileColors,
) {
    for (i, s) in points.surfaces.iter().enumerate() {
        let light = &points.light[i];
        let ambient = points.ambient(simd, i, ambient);
        let mut channels = [ambient; 3];
        for (c, channel) in channels.iter_mut().enumerate() {
            let arriving = (ambient + simd.load(&light.diffuse[c])).min(most);
            *channel = base(i, c) * arriving;
        }
        colors.add(simd, s.active, &s.pixel, simd.load(&s.weight) * share, channels);
    }
}

#[inline(always)]
fn blinn_phong<S: Simd>(
    simd: S,
    (diffuse, k_d): (impl Fn(usize, usize) -> S::V8, f32),
    specular: impl Fn(usize, usize) -> S::V8,
    k_s: f32,
    (ambient, is_reflected, most): (S::V8, bool, S::V8),
    points: Points<'_>,
    colors: &mut TileColors,
) {
    for (i, s) in points.surfaces.iter().enumerate() {
        let light = &points.light[i];
        let ambient = points.ambient(simd, i, ambient);
        let reflected = if is_reflected {
            ambient * reflectance(simd, s)
        } else {
            simd.splat(0.0)
        };
        let mut channels = [ambient; 3];
        for (c, channel) in channels.iter_mut().enumerate() {
            let body = simd.splat(k_d).mul_add(simd.load(&light.diffuse[c]), ambient);
            let gloss = simd.splat(k_s) * simd.load(&light.specular[c]);
            let specular = specular(i, c);
            let polish = (specular * simd.splat(k_s)).min(simd.splat(MOST_POLISH));
            let gloss = polish.mul_add(reflected, specular * gloss);
            let sum = diffuse(i, c).mul_add(body, gloss);
            *channel = sum.max(simd.splat(0.0)).min(most);
        }
        colors.add(simd, s.active, &s.pixel, simd.load(&s.weight), channels);
    }
}

/// How much ambient light a surface reflects, as a factor: see [`Scene::ambient_specular`].
#[inline(always)]
fn reflectance<S: Simd>(simd: S, s: &SurfacePacket) -> S::V8 {
    let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
    let along = simd.load3(&s.normal).dot(simd.load3(&s.direction));
    let grazing = (one + along).max(zero).min(one);
    let squared = grazing * grazing;
    let [least, more] = AMBIENT_SPECULAR;
    (squared * squared * grazing).mul_add(simd.splat(more), simd.splat(least))
}

/// Queues rays along d - 2 (d.n) n, from just off the surface.
#[inline(always)]
fn mirror<S: Simd>(simd: S, share: f32, surfaces: &[SurfacePacket], next: &mut RayQueue) {
    for s in surfaces {
        let (d, normal) = (simd.load3(&s.direction), simd.load3(&s.normal));
        let direction = normal.mul_add(simd.splat(-2.0) * d.dot(normal), d).normalize();
        let origin = simd
            .load3(&s.geometric_normal)
            .mul_add(simd.load(&s.magnitude) * SURFACE_OFFSET, simd.load3(&s.point));
        let t_max = S::V8::select(simd.mask(s.active), simd.splat(T_MAX), simd.splat(0.0));
        next.push_from(
            origin.to8(),
            RayPacket {
                direction: direction.to8(),
                t_max: t_max.to8(),
            },
            s.pixel,
            (simd.load(&s.weight) * share).to8(),
        );
    }
}

/// Returns the background along eight directions; see [`Scene::background_color`].
#[inline(always)]
pub(crate) fn background<S: Simd>(simd: S, scene: &Scene, direction: &Vec3x8) -> [S::V8; 3] {
    if let Some(environment @ Environment::Picture(_)) = scene.environment() {
        return picture(environment, direction).map(
            #[inline(always)]
            |channel| simd.load(&channel),
        );
    }
    let background = scene.background();
    let half = simd.splat(0.5);
    let share = simd.load(&direction.z).mul_add(half, half);
    let share = share.max(simd.splat(0.0)).min(simd.splat(1.0));
    let [r, g, b] = background.difference();
    let [bottom_r, bottom_g, bottom_b] = background.bottom;
    [
        share.mul_add(simd.splat(r), simd.splat(bottom_r)),
        share.mul_add(simd.splat(g), simd.splat(bottom_g)),
        share.mul_add(simd.splat(b), simd.splat(bottom_b)),
    ]
}

#[inline(never)]
fn picture(environment: &Environment, direction: &Vec3x8) -> [F32x8; 3] {
    let mut colors = [F32x8::ZERO; 3];
    for lane in 0..LANES {
        for (channel, value) in colors.iter_mut().zip(environment.color(direction.lane(lane))) {
            channel.as_mut_array()[lane] = value;
        }
    }
    colors
}

/// Adds the background for all rays of a queue, those beyond the maximum depth.
#[inline(always)]
pub(super) fn background_pass<S: Simd>(simd: S, scene: &Scene, rays: &RayQueue, colors: &mut TileColors) {
    for (p, packet) in rays.rays.packets().iter().enumerate() {
        let active = simd.load(&packet.t_max).gt(simd.splat(0.0)).bits();
        let background = background(simd, scene, &packet.direction);
        colors.add(
            simd,
            active,
            &rays.pixel(p),
            simd.load(&rays.weight(p)),
            background,
        );
    }
}

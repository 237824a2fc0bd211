//! Glass: each ray that meets it splits into a reflected and a refracted ray, its branches.
//!
//! ```text
//! depth d      rays, a colour each   -- pass -->   depth d + 1: branches, a colour each
//!   ^                                                             |
//!   +--------------- colour += factor x colour ------- add_to ----+
//! ```
//!
//! Weights follow Fresnel's equations for unpolarised light, absorption the law of Beer and Lambert. Branches with a weight
//! below [`MIN_WEIGHT`] take the background instead of being traced, so a pixel has at most `3 / MIN_WEIGHT` rays at a
//! depth, and usually a few.

use super::{SURFACE_OFFSET, TileColors, material::Points, material::background, queue::RayQueue};
use crate::{
    lanes::{F32x8, LANES},
    ray::{HitPacket, PrimitiveId, RayPacket, T_MAX},
    scene::{Material, MaterialId, Scene},
    shade::surface::SurfacePacket,
    simd::{EightLanes, LaneMask, Lanes, Simd, Vec3Eight, Vec3Lanes},
};

/// Branches are not traced if their weight in the pixel is less in all channels.
pub const MIN_WEIGHT: f32 = 1.0 / 512.0;

/// The least cosine between a ray and a normal, so that weights at grazing angles are not NaN.
const MIN_COSINE: f32 = 1e-6;

const ALL_LANES: u32 = u32::MAX >> (32 - LANES);

/// The paths that eight rays of a queue continue.
#[derive(Clone, Copy, Debug)]
pub(super) struct Branch8 {
    /// Factors of their colours in those of their parents, by channel.
    pub(super) factor: [F32x8; 3],
    /// Factors of their colours in the pixels, by channel.
    pub(super) weight: [F32x8; 3],
    /// The tinted glass that they are in.
    pub(super) medium: [Option<MaterialId>; LANES],
    /// Number of half-transparent surfaces on their paths.
    pub(super) layers: [u8; LANES],
    /// Lanes whose path went straight on from the camera.
    pub(super) straight: u32,
    /// Lanes beyond the maximum depth, which are not traced.
    pub(super) ended: u32,
}

impl Branch8 {
    /// The value for camera rays.
    const CAMERA: Self = Self {
        factor: [F32x8::splat(1.0); 3],
        weight: [F32x8::splat(1.0); 3],
        medium: [None; LANES],
        layers: [0; LANES],
        straight: ALL_LANES,
        ended: 0,
    };

    /// Gathers the branches of the rays with these indices.
    #[inline(always)]
    pub(super) fn gather(rays: &RayQueue, ray_i: &[u32; LANES]) -> Self {
        let mut gathered = Self::CAMERA;
        if rays.branches.is_empty() {
            gathered.medium = [rays.medium; LANES];
            return gathered;
        }
        gathered.straight = 0;
        for (to, &i) in ray_i.iter().enumerate() {
            let (from, lane) = (&rays.branches[i as usize / LANES], i as usize % LANES);
            for c in 0..3 {
                gathered.weight[c].as_mut_array()[to] = from.weight[c].as_array()[lane];
            }
            gathered.medium[to] = from.medium[lane];
            gathered.layers[to] = from.layers[lane];
            gathered.straight |= (from.straight >> lane & 1) << to;
        }
        gathered
    }
}

/// The rays of one depth and their colours.
#[derive(Debug, Default)]
pub(super) struct Depth {
    pub rays: RayQueue,
    pub colors: TileColors,
    /// The numbers of the first random points of the pixels of `rays`, in scenes that are sampled.
    pub first_points: Vec<[u32; LANES]>,
}

impl Depth {
    pub fn swap(
        &mut self,
        rays: &mut RayQueue,
        colors: &mut TileColors,
        first_points: &mut Vec<[u32; LANES]>,
    ) {
        std::mem::swap(&mut self.rays, rays);
        std::mem::swap(&mut self.colors, colors);
        std::mem::swap(&mut self.first_points, first_points);
    }

    /// Gives the rays the random points of their parents.
    pub fn take_first_points(&mut self, parents: &[[u32; LANES]]) {
        self.first_points.clear();
        if parents.is_empty() {
            return;
        }
        for p in 0..self.rays.rays.packets().len() {
            let first = |i: u32| parents[i as usize / LANES][i as usize % LANES];
            self.first_points.push(self.rays.parent(p).map(first));
        }
    }

    /// Sets the colours of all rays to the background: they are beyond the maximum depth.
    #[inline(always)]
    pub fn set_background<S: Simd>(&mut self, simd: S, scene: &Scene) {
        self.colors.resize(self.rays.rays.packets().len());
        for (p, packet) in self.rays.rays.packets().iter().enumerate() {
            let color = background(simd, scene, &packet.direction);
            self.colors.set(simd, p, ALL_LANES, color);
        }
    }

    /// Ends the rays beyond the maximum depth. Half-transparent surfaces do not count: `depth` is that of rays that passed none.
    /// Returns the number of remaining rays.
    pub fn end(&mut self, depth: u32, max_depth: u32) -> u64 {
        let branches = &mut self.rays.branches;
        for (packet, branch) in self.rays.rays.packets_mut().iter_mut().zip(branches) {
            for (lane, t_max) in packet.t_max.as_mut_array().iter_mut().enumerate() {
                if *t_max > 0.0 && depth - u32::from(branch.layers[lane]) >= max_depth {
                    branch.ended |= 1 << lane;
                    *t_max = 0.0;
                }
            }
        }
        self.rays.active_rays()
    }

    /// Sets the colours of the ended rays to the background.
    #[inline(always)]
    pub fn add_ended<S: Simd>(&mut self, simd: S, scene: &Scene) {
        for (p, branch) in self.rays.branches.iter().enumerate() {
            if branch.ended != 0 {
                let color = background(simd, scene, &self.rays.rays.packets()[p].direction);
                let own = self.rays.pixel(p);
                self.colors.add(simd, branch.ended, &own, simd.splat(1.0), color);
            }
        }
    }

    /// Adds the colours to those of the parents, the last ray first.
    #[inline(always)]
    pub fn add_to<S: Simd>(&self, simd: S, parents: &mut TileColors) {
        for (p, packet) in self.rays.rays.packets().iter().enumerate().rev() {
            let Branch8 {
                factor,
                ended,
                straight,
                ..
            } = &self.rays.branches[p];
            let active = simd.load(&packet.t_max).gt(simd.splat(0.0)).bits() | ended;
            let (parent, colors, share) = (self.rays.parent(p), &self.colors.packets[p], self.rays.share(p));
            for (lane, &parent) in parent.iter().enumerate() {
                if active >> lane & 1 == 0 {
                    continue;
                }
                let sums = &mut parents.packets[parent as usize / LANES];
                for (c, sums) in sums.iter_mut().enumerate() {
                    let sum = &mut sums.as_mut_array()[parent as usize % LANES];
                    *sum = simd.mul_add(factor[c].as_array()[lane], colors[c].as_array()[lane], *sum);
                }
                if straight >> lane & 1 == 1
                    && let Some(alpha) = self.colors.alpha.get(p)
                {
                    let sum = &mut parents.alpha[parent as usize / LANES];
                    let sum = &mut sum.as_mut_array()[parent as usize % LANES];
                    *sum = simd.mul_add(share.as_array()[lane], alpha.as_array()[lane], *sum);
                }
            }
        }
    }
}

/// Tints the branches that reach a surface through glass, by the distance in it.
pub(super) fn absorb(scene: &Scene, rays: &mut RayQueue, hits: &[HitPacket]) {
    for (branch, hits) in rays.branches.iter_mut().zip(hits) {
        for lane in 0..LANES {
            let Some(medium) = branch.medium[lane] else {
                continue;
            };
            if hits.primitive[lane] == PrimitiveId::NONE.0 {
                continue;
            }
            let passed = scene.materials()[medium.0 as usize].transmittance(hits.t.as_array()[lane]);
            for (c, passed) in passed.into_iter().enumerate() {
                branch.factor[c].as_mut_array()[lane] *= passed;
                branch.weight[c].as_mut_array()[lane] *= passed;
            }
        }
    }
}

/// Sets the tinted glass that each surface packet is seen in; empty if none is in any.
pub(super) fn media_of(
    rays: &RayQueue,
    surfaces: &[SurfacePacket],
    media: &mut Vec<[Option<MaterialId>; LANES]>,
) {
    media.clear();
    let is_tinted = |branch: &Branch8| branch.medium != [None; LANES];
    if rays.medium.is_some() || rays.branches.iter().any(is_tinted) {
        media.extend(surfaces.iter().map(|s| Branch8::gather(rays, &s.pixel).medium));
    }
}

/// Sets the transmittance of camera rays that start in a material, by channel; 1 for rays that hit nothing.
pub(super) fn passed(material: &Material, hits: &[HitPacket], passed: &mut Vec<[F32x8; 3]>) {
    passed.clear();
    passed.extend(hits.iter().map(|hits| {
        let mut of_packet = [F32x8::splat(1.0); 3];
        for lane in (0..LANES).filter(|&lane| hits.primitive[lane] != PrimitiveId::NONE.0) {
            let by_channel = material.transmittance(hits.t.as_array()[lane]);
            for (passed, one) in of_packet.iter_mut().zip(by_channel) {
                passed.as_mut_array()[lane] = one;
            }
        }
        of_packet
    }));
}

/// Makes branches of the rays that mirrors have queued since the last call.
pub(super) fn branch_mirrored(rays: &RayQueue, next: &mut RayQueue) {
    for p in next.branches.len()..next.rays.packets().len() {
        let share = next.share(p);
        let mut branch = Branch8::gather(rays, &next.parent(p));
        (branch.factor, branch.straight) = ([share; 3], 0);
        for weight in &mut branch.weight {
            for (weight, share) in weight.as_mut_array().iter_mut().zip(share.as_array()) {
                *weight *= share;
            }
        }
        next.branches.push(branch);
    }
}

/// The reflected and refracted directions.
struct Split<S: Simd> {
    reflected: Vec3Eight<S>,
    refracted: Vec3Eight<S>,
    /// The share of reflected light: 1 in total internal reflection.
    share: S::V8,
}

/// Refracts by Snell's law, with shares by Fresnel's equations.
#[inline(always)]
fn split<S: Simd>(simd: S, index: f32, s: &SurfacePacket) -> Split<S> {
    let (one, d) = (simd.splat(1.0), simd.load3(&s.direction));
    let (geometric, normal) = (simd.load3(&s.geometric_normal), simd.load3(&s.normal));
    // Shading normals may face away from the viewer.
    let is_facing = d.dot(normal).lt(simd.splat(0.0));
    let normal = Vec3Lanes::select(is_facing, normal, geometric);
    let cosine = (-d.dot(normal)).max(simd.splat(MIN_COSINE)).min(one);
    let ratio = S::V8::select(
        simd.mask(s.from_behind),
        simd.splat(index),
        simd.splat(1.0 / index),
    );
    let sine_squared = one - cosine * cosine;
    let bent = (one - ratio * ratio * sine_squared).max(simd.splat(0.0)).sqrt();
    let across = (ratio * cosine - bent) / (ratio * cosine + bent);
    let along = (cosine - ratio * bent) / (cosine + ratio * bent);
    Split {
        reflected: normal.mul_add(cosine + cosine, d).normalize(),
        refracted: normal.mul_add(ratio * cosine - bent, d * ratio).normalize(),
        share: across.mul_add(across, along * along) * simd.splat(0.5),
    }
}

/// Queues first the reflected and then the refracted rays of one material's points, which keeps packets coherent; those of
/// low weight add the background.
#[inline(always)]
pub(super) fn pass<S: Simd>(
    simd: S,
    scene: &Scene,
    glass: (MaterialId, f32),
    points: Points<'_>,
    rays: &RayQueue,
    colors: &mut TileColors,
    next: &mut RayQueue,
) {
    for crosses in [false, true] {
        for (i, s) in points.surfaces.iter().enumerate() {
            let queued = branch(simd, scene, glass, (s, crosses), rays, colors, next);
            if let Some(&distance) = points.distance.get(i)
                && queued
            {
                next.push_travelled(distance);
            }
        }
    }
}

/// Queues the rays of eight points that cross the surface or not, and returns whether there are any.
#[inline(always)]
fn branch<S: Simd>(
    simd: S,
    scene: &Scene,
    (id, index): (MaterialId, f32),
    (s, crosses): (&SurfacePacket, bool),
    rays: &RayQueue,
    colors: &mut TileColors,
    next: &mut RayQueue,
) -> bool {
    let split = split(simd, index, s);
    let offset = simd.load(&s.magnitude) * SURFACE_OFFSET;
    let (direction, share, offset) = if crosses {
        (split.refracted, simd.splat(1.0) - split.share, -offset)
    } else {
        (split.reflected, split.share, offset)
    };
    let (direction, from) = (direction.to8(), Branch8::gather(rays, &s.pixel));
    let weight = from.weight.map(|weight| share * simd.load(&weight));
    let largest = weight[0].max(weight[1]).max(weight[2]);
    let traced = s.active & largest.ge(simd.splat(MIN_WEIGHT)).bits();
    if s.active & !traced != 0 {
        let color = background(simd, scene, &direction).map(|color| color * share);
        colors.add(simd, s.active & !traced, &s.pixel, simd.splat(1.0), color);
    }
    if traced == 0 {
        return false;
    }
    let origin = simd
        .load3(&s.geometric_normal)
        .mul_add(offset, simd.load3(&s.point));
    let t_max = S::V8::select(simd.mask(traced), simd.splat(T_MAX), simd.splat(0.0)).to8();
    next.push_from(origin.to8(), RayPacket { direction, t_max }, s.pixel, share.to8());
    next.branches.push(Branch8 {
        factor: [share.to8(); 3],
        weight: to8::<S>(weight),
        medium: media(scene, id, (s, crosses), from.medium),
        straight: 0,
        ..from
    });
    true
}

#[inline(always)]
pub(super) fn to8<S: Simd>([r, g, b]: [S::V8; 3]) -> [F32x8; 3] {
    [r.to8(), g.to8(), b.to8()]
}

/// The media behind the surface, or those before it for rays that do not cross it.
fn media(
    scene: &Scene,
    id: MaterialId,
    (s, crosses): (&SurfacePacket, bool),
    mut medium: [Option<MaterialId>; LANES],
) -> [Option<MaterialId>; LANES] {
    let is_tinted = scene.materials()[id.0 as usize].tints();
    for (lane, medium) in medium.iter_mut().enumerate() {
        if (s.from_behind >> lane & 1 == 1) != crosses {
            *medium = is_tinted.then_some(id);
        } else if crosses {
            *medium = None;
        }
    }
    medium
}

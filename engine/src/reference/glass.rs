//! The scalar version of `shade::glass` and `shade::blend`, with the same operations in the same order; branches are in a
//! list instead of queues.

use super::{
    shade::{
        Draw, Intersect, Limits, PixelSample, SURFACE_OFFSET, SecondaryRays, Surface, add, mirrored, scatter,
        tinted,
    },
    surface::surface,
    through::opaque_first,
};
use crate::{
    math::{max, min},
    ray::{Ray, SceneHit},
    scene::{Material, MaterialId, Scene},
    simd::Simd,
};
use glam::Vec3;

const MIN_WEIGHT: f32 = 1.0 / 512.0;
const MIN_COSINE: f32 = 1e-6;
const MAX_LAYERS: u32 = 64;

/// A ray and its colour.
#[derive(Clone, Copy)]
struct Branch {
    ray: Ray,
    /// Index of the parent branch in the list.
    parent: usize,
    /// The camera ray's is 0.
    depth: u32,
    /// The factor of its colour in its parent's, by channel.
    factor: [f32; 3],
    /// The factor of its colour in the pixel's, by channel.
    weight: [f32; 3],
    /// The tinted glass that it is in.
    medium: Option<MaterialId>,
    /// The length of the path from the camera to its origin.
    travelled: f32,
    /// Number of half-transparent surfaces on the path.
    layers: u32,
    /// Whether the path is straight from the camera.
    is_straight: bool,
    /// The factor of its opacity in its parent's, if the path is straight.
    share: f32,
    color: [f32; 3],
    alpha: f32,
}

/// Returns the colour and the opacity of a camera ray in a scene with glass or blending. Branches are shaded by depth,
/// then added up from the last.
#[inline(always)]
pub(super) fn radiance<S: Simd>(
    simd: S,
    scene: &Scene,
    intersect: &mut dyn Intersect,
    (camera_ray, sample): (Ray, PixelSample),
    limits: Limits,
    rays: &mut SecondaryRays,
) -> ([f32; 3], f32) {
    let mut branches = vec![Branch {
        ray: camera_ray,
        parent: 0,
        depth: 0,
        factor: [1.0; 3],
        weight: [1.0; 3],
        medium: limits.medium,
        travelled: 0.0,
        layers: 0,
        is_straight: true,
        share: 1.0,
        color: [0.0; 3],
        alpha: 0.0,
    }];
    let mut i = 0;
    while i < branches.len() {
        shade(simd, scene, intersect, sample, limits, (&mut branches, i), rays);
        i += 1;
    }
    for i in (1..branches.len()).rev() {
        let Branch {
            parent,
            factor,
            is_straight,
            share,
            color,
            alpha,
            ..
        } = branches[i];
        for (c, sum) in branches[parent].color.iter_mut().enumerate() {
            *sum = simd.mul_add(factor[c], color[c], *sum);
        }
        if is_straight {
            let sum = &mut branches[parent].alpha;
            *sum = simd.mul_add(share, alpha, *sum);
        }
    }
    let Branch {
        mut color,
        factor,
        alpha,
        ..
    } = branches[0];
    if limits.medium.is_some() {
        color = std::array::from_fn(|c| color[c] * factor[c]);
    }
    (color, if limits.transparent { alpha } else { 1.0 })
}

/// Traces and shades branch `i`, and appends its branches.
#[inline(always)]
fn shade<S: Simd>(
    simd: S,
    scene: &Scene,
    intersect: &mut dyn Intersect,
    sample: PixelSample,
    limits: Limits,
    (branches, i): (&mut Vec<Branch>, usize),
    rays: &mut SecondaryRays,
) {
    let own = &mut branches[i];
    if own.depth - own.layers == limits.max_depth {
        own.color = scene.background_color(simd, own.ray.direction);
        return;
    }
    rays.reflection += u64::from(own.depth > 0);
    let hit = opaque_first(simd, scene, intersect, &own.ray, true);
    let shows_nothing = limits.transparent && own.is_straight;
    if !hit.is_hit() {
        if !shows_nothing {
            own.color = scene.background_color(simd, own.ray.direction);
        }
        return;
    }
    let opacity = if own.layers < MAX_LAYERS {
        scene.opacity(hit.primitive, [hit.u, hit.v])
    } else {
        1.0
    };
    own.alpha = opacity;
    if let Some(medium) = own.medium {
        let passed = scene.materials()[medium.0 as usize].transmittance(hit.t);
        for (c, passed) in passed.into_iter().enumerate() {
            own.factor[c] *= passed;
            if own.depth > 0 {
                own.weight[c] *= passed;
            }
        }
    }
    let mut parent = *own;
    parent.travelled += hit.t;
    let at = (&parent.ray, &hit, sample.cone.width(parent.travelled));
    let medium = parent.medium;
    let draw = (Draw::at(scene, sample, parent.depth), Limits { medium, ..limits });
    let scattered = scatter(simd, scene, intersect, at, draw, (&mut own.color, opacity), rays);
    match scattered {
        Some((Material::Reflection { mirror_share, .. }, surface)) => {
            let share = opacity * mirror_share;
            branches.push(Branch {
                ray: mirrored(simd, &surface),
                factor: [share; 3],
                weight: parent.weight.map(|weight| weight * share),
                ..child(&parent, i)
            });
        }
        Some((Material::Glass { index, .. }, surface)) => {
            let id = scene.material_of(hit.primitive);
            split(simd, scene, (id, index), &surface, (&parent, i), branches);
        }
        _ => {}
    }
    if opacity < 1.0 {
        let surface = surface(simd, scene, &parent.ray, &hit);
        let tint = filter_color(simd, scene, at);
        pass(
            simd,
            scene,
            (&surface, opacity, tint),
            shows_nothing,
            (&parent, i),
            branches,
        );
    }
}

/// The factor of light that passes straight through a half-transparent surface. `width` is that of the ray's cone there.
#[inline(always)]
fn filter_color<S: Simd>(simd: S, scene: &Scene, (ray, hit, width): (&Ray, &SceneHit, f32)) -> [f32; 3] {
    let opacity = scene
        .textures_of(hit.primitive)
        .and_then(|textures| textures.opacity);
    if opacity.is_some_and(|opacity| opacity.is_tinted) {
        tinted(simd, scene, ray, hit, width).0.base_color()
    } else {
        [1.0; 3]
    }
}

/// Appends the branch that continues straight on; one of low weight adds the background, unless that `shows_nothing`.
#[inline(always)]
fn pass<S: Simd>(
    simd: S,
    scene: &Scene,
    (s, opacity, tint): (&Surface, f32, [f32; 3]),
    shows_nothing: bool,
    (parent, i): (&Branch, usize),
    branches: &mut Vec<Branch>,
) {
    let share = 1.0 - opacity;
    let factor = tint.map(|tint| share * tint);
    let weight: [f32; 3] = std::array::from_fn(|c| factor[c] * parent.weight[c]);
    let direction = parent.ray.direction;
    if max(max(weight[0], weight[1]), weight[2]) >= MIN_WEIGHT {
        let offset = -(s.magnitude * SURFACE_OFFSET);
        branches.push(Branch {
            ray: Ray::new(simd.mul_add3(s.geometric_normal, offset, s.point), direction),
            factor,
            weight,
            layers: parent.layers + 1,
            is_straight: parent.is_straight,
            share,
            ..child(parent, i)
        });
    } else if !shows_nothing {
        let background = scene.background_color(simd, direction);
        let color = std::array::from_fn(|c| background[c] * tint[c]);
        add(simd, &mut branches[i].color, share, color);
    }
}

/// A branch of `parent`, branch `i`, in another direction.
#[inline(always)]
fn child(parent: &Branch, i: usize) -> Branch {
    Branch {
        parent: i,
        depth: parent.depth + 1,
        is_straight: false,
        color: [0.0; 3],
        alpha: 0.0,
        ..*parent
    }
}

/// Appends the reflected and the refracted branch; those of low weight add the background.
#[inline(always)]
fn split<S: Simd>(
    simd: S,
    scene: &Scene,
    (id, index): (MaterialId, f32),
    s: &Surface,
    (parent, i): (&Branch, usize),
    branches: &mut Vec<Branch>,
) {
    let glass = &scene.materials()[id.0 as usize];
    let inside = glass.tints().then_some(id);
    let (reflected, refracted, share) = directions(simd, index, s);
    let offset = s.magnitude * SURFACE_OFFSET;
    let both = [
        (reflected, share, offset, false),
        (refracted, 1.0 - share, -offset, true),
    ];
    for (direction, share, offset, crosses) in both {
        let factor = [share; 3];
        let weight = parent.weight.map(|weight| share * weight);
        if max(max(weight[0], weight[1]), weight[2]) < MIN_WEIGHT {
            let background = scene.background_color(simd, direction);
            let color = std::array::from_fn(|c| background[c] * factor[c]);
            add(simd, &mut branches[i].color, 1.0, color);
            continue;
        }
        let medium = if s.from_behind != crosses {
            inside
        } else if crosses {
            None
        } else {
            parent.medium
        };
        branches.push(Branch {
            ray: Ray::new(simd.mul_add3(s.geometric_normal, offset, s.point), direction),
            factor,
            weight,
            medium,
            ..child(parent, i)
        });
    }
}

/// Returns the reflected and the refracted direction, and the share of reflected light.
#[inline(always)]
fn directions<S: Simd>(simd: S, index: f32, s: &Surface) -> (Vec3, Vec3, f32) {
    let d = s.direction;
    let normal = if simd.dot(d, s.normal) < 0.0 {
        s.normal
    } else {
        s.geometric_normal
    };
    let cosine = min(max(-simd.dot(d, normal), MIN_COSINE), 1.0);
    let ratio = if s.from_behind { index } else { 1.0 / index };
    let sine_squared = 1.0 - cosine * cosine;
    let bent = max(1.0 - ratio * ratio * sine_squared, 0.0).sqrt();
    let across = (ratio * cosine - bent) / (ratio * cosine + bent);
    let along = (cosine - ratio * bent) / (cosine + ratio * bent);
    (
        simd.normalize(simd.mul_add3(normal, cosine + cosine, d)),
        simd.normalize(simd.mul_add3(normal, ratio * cosine - bent, d * ratio)),
        simd.mul_add(across, across, along * along) * 0.5,
    )
}

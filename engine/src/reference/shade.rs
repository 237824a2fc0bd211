//! The scalar version of the `shade` module: Whitted's algorithm as a loop, with the same operations in the same order.

use super::{
    draw::scattered,
    glass, light,
    surface::{interpolate, mapped, surface},
    through::{light_through, seen},
};
use crate::{
    math::{max, min, powi},
    ray::{Hit, Ray, SceneHit, T_MAX},
    scene::{AMBIENT_SPECULAR, MOST_POLISH, Material, MaterialId, Primitive, RayCone, Scene, TexturePoint},
    simd::{Level, Simd, at_level},
    sobol,
};
use glam::Vec3;

pub(super) const SURFACE_OFFSET: f32 = 32.0 / 16_777_216.0;

/// A tracing method: brute force or a BVH.
pub trait Intersect {
    /// Returns the closest hit; at equal t the one with the lowest id of instance, none first, then of primitive.
    fn closest_hit(&mut self, ray: &Ray) -> SceneHit;
    /// Returns the closest hit on an opaque surface.
    fn opaque_hit(&mut self, ray: &Ray) -> SceneHit;
    /// Returns whether anything is hit before the ray's end.
    fn occluded(&mut self, ray: &Ray) -> bool;
    /// Returns the closest hit that is not on the back of a one-sided surface; on an opaque surface if `only_opaque`. By
    /// default no surface is one-sided.
    fn visible_hit(&mut self, ray: &Ray, only_opaque: bool) -> SceneHit {
        if only_opaque {
            self.opaque_hit(ray)
        } else {
            self.closest_hit(ray)
        }
    }
}

/// A point on a surface; the fields are those of `shade::surface::SurfacePacket`.
pub(super) struct Surface {
    pub point: Vec3,
    pub rise: f32,
    pub geometric_normal: Vec3,
    pub normal: Vec3,
    pub direction: Vec3,
    pub magnitude: f32,
    /// Whether the ray comes from behind: the geometric normal was turned.
    pub from_behind: bool,
    /// The factor of ambient light and of the environment by an occlusion map, or 1.
    pub occlusion: f32,
}

/// The number of secondary rays traced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SecondaryRays {
    /// Shadow rays.
    pub shadow: u64,
    /// Ambient occlusion rays.
    pub ambient: u64,
    /// Reflection and refraction rays.
    pub reflection: u64,
}

/// A camera ray's sample in the picture, which seeds its random directions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PixelSample {
    /// Absolute column and row.
    pub pixel: [u32; 2],
    /// Index of the sample in its pixel.
    pub number: u32,
    /// Samples per pixel.
    pub count: u32,
    /// The width of the ray, which selects mipmap levels.
    pub cone: RayCone,
}

impl PixelSample {
    /// Returns a point of the unit square from the sequence `pair`.
    #[inline(always)]
    fn point(self, pair: usize) -> [f32; 2] {
        let first = sobol::first_point(self.pixel, self.count);
        sobol::point(pair as u32, first.wrapping_add(self.number))
    }
}

/// Returns the colour of a camera ray, linear RGB, and adds the secondary rays to `rays`.
pub fn radiance(
    scene: &Scene,
    intersect: &mut dyn Intersect,
    camera_ray: Ray,
    sample: PixelSample,
    max_depth: u32,
    shadows: bool,
    rays: &mut SecondaryRays,
) -> [f32; 3] {
    let limits = Limits {
        max_depth,
        shadows,
        transparent: false,
        medium: None,
    };
    let from = (camera_ray, sample);
    radiance_at(Level::current(), scene, intersect, from, limits, rays).0
}

/// The settings of [`radiance`].
#[derive(Clone, Copy)]
#[doc(hidden)]
pub struct Limits {
    pub max_depth: u32,
    pub shadows: bool,
    /// Whether straight paths from the camera that hit nothing are transparent.
    pub transparent: bool,
    /// The tinted glass that camera rays start in.
    pub medium: Option<MaterialId>,
}

/// [`radiance`] at a level. Also returns the opacity of what the ray hits.
#[doc(hidden)]
pub fn radiance_at(
    level: Level,
    scene: &Scene,
    intersect: &mut dyn Intersect,
    from: (Ray, PixelSample),
    limits: Limits,
    rays: &mut SecondaryRays,
) -> ([f32; 3], f32) {
    at_level!(level, |simd| follow(simd, scene, intersect, from, limits, rays))
}

#[inline(always)]
fn follow<S: Simd>(
    simd: S,
    scene: &Scene,
    intersect: &mut dyn Intersect,
    (camera_ray, sample): (Ray, PixelSample),
    limits: Limits,
    rays: &mut SecondaryRays,
) -> ([f32; 3], f32) {
    if scene.has_glass() || scene.has_blending() {
        return glass::radiance(simd, scene, intersect, (camera_ray, sample), limits, rays);
    }
    let mut color = [0.0; 3];
    let mut ray = camera_ray;
    let mut weight = 1.0;
    let mut travelled = 0.0;
    for level in 0.. {
        if level == limits.max_depth {
            let background = scene.background_color(simd, ray.direction);
            add(simd, &mut color, weight, background);
            break;
        }
        rays.reflection += u64::from(level > 0);
        let hit = seen(simd, scene, intersect, &ray);
        if !hit.is_hit() {
            let background = scene.background_color(simd, ray.direction);
            add(simd, &mut color, weight, background);
            break;
        }
        travelled += hit.t;
        let at = (&ray, &hit, sample.cone.width(travelled));
        let draw = (Draw::at(scene, sample, level), limits);
        let Some((Material::Reflection { mirror_share, .. }, surface)) =
            scatter(simd, scene, intersect, at, draw, (&mut color, weight), rays)
        else {
            break;
        };
        weight *= mirror_share;
        ray = mirrored(simd, &surface);
    }
    (color, 1.0)
}

/// Adds the light that a surface scatters and emits, weighted; `width` is that of the ray's cone. Returns the surface
/// unless it is a silhouette.
#[inline(always)]
pub(super) fn scatter<S: Simd>(
    simd: S,
    scene: &Scene,
    intersect: &mut dyn Intersect,
    (ray, hit, width): (&Ray, &SceneHit, f32),
    draw: (Draw, Limits),
    (color, weight): (&mut [f32; 3], f32),
    rays: &mut SecondaryRays,
) -> Option<(Material, Surface)> {
    let (material, emitted) = tinted(simd, scene, ray, hit, width);
    if let Material::Silhouette { color: own } = material {
        add(simd, color, weight, own);
        emit(simd, color, weight, emitted);
        return None;
    }
    let surface = mapped(scene, hit, width, surface(simd, scene, ray, hit));
    if !matches!(material, Material::Glass { .. }) {
        let light = gather_light(simd, scene, intersect, (&surface, &material), draw, rays);
        body(simd, (color, weight), &material, &light, scene.most_light());
    }
    emit(simd, color, weight, emitted);
    Some((material, surface))
}

/// Adds the light that a material scatters.
#[inline(always)]
fn body<S: Simd>(
    simd: S,
    (color, weight): (&mut [f32; 3], f32),
    material: &Material,
    light: &Light,
    most: f32,
) {
    match *material {
        Material::Silhouette { .. } | Material::Glass { .. } => {}
        Material::Matte { color: own } => add(simd, color, weight, matte(own, light, most)),
        Material::BlinnPhong {
            diffuse,
            specular,
            k_d,
            k_s,
            ..
        } => {
            let mut own = [0.0; 3];
            for i in 0..3 {
                let body = simd.mul_add(k_d, light.diffuse[i], light.ambient);
                let gloss = k_s * light.specular[i];
                let polish = min(specular[i] * k_s, MOST_POLISH);
                let gloss = simd.mul_add(polish, light.reflected, specular[i] * gloss);
                let sum = simd.mul_add(diffuse[i], body, gloss);
                own[i] = min(max(sum, 0.0), most);
            }
            add(simd, color, weight, own);
        }
        Material::Reflection {
            color: own,
            mirror_share,
        } => add(
            simd,
            color,
            weight * (1.0 - mirror_share),
            matte(own, light, most),
        ),
    }
}

/// Adds the light that a surface emits, if it does.
#[inline(always)]
fn emit<S: Simd>(simd: S, color: &mut [f32; 3], weight: f32, emitted: Option<[f32; 3]>) {
    if let Some(emitted) = emitted {
        add(simd, color, weight, emitted);
    }
}

#[inline(always)]
pub(super) fn add<S: Simd>(simd: S, color: &mut [f32; 3], weight: f32, more: [f32; 3]) {
    for (sum, c) in color.iter_mut().zip(more) {
        *sum = simd.mul_add(weight, c, *sum);
    }
}

#[inline(always)]
fn matte(color: [f32; 3], light: &Light, most: f32) -> [f32; 3] {
    std::array::from_fn(|i| color[i] * min(light.ambient + light.diffuse[i], most))
}

#[inline(always)]
pub(super) fn mirrored<S: Simd>(simd: S, s: &Surface) -> Ray {
    let along = simd.dot(s.direction, s.normal);
    let direction = simd.normalize(simd.mul_add3(s.normal, -2.0 * along, s.direction));
    light::leaving(simd, (s, light::offset(s)), direction, T_MAX)
}

/// The incident light at a point, summed over the lights that reach it, by channel.
struct Light {
    /// I_a, or 0 where it is blocked.
    ambient: f32,
    diffuse: [f32; 3],
    specular: [f32; 3],
    /// I_a times how much of it surfaces reflect, or 0.
    reflected: f32,
}

/// The random points of one depth.
#[derive(Clone, Copy)]
pub(super) struct Draw {
    sample: PixelSample,
    /// The sample dimensions of ambient light; those of the lights follow.
    first_pair: usize,
}

impl Draw {
    #[inline(always)]
    pub(super) fn at(scene: &Scene, sample: PixelSample, level: u32) -> Self {
        Self {
            sample,
            first_pair: level as usize * scene.draws_per_depth(),
        }
    }
}

#[inline(always)]
fn gather_light<S: Simd>(
    simd: S,
    scene: &Scene,
    intersect: &mut dyn Intersect,
    (s, material): (&Surface, &Material),
    (draw, Limits { shadows, medium, .. }): (Draw, Limits),
    rays: &mut SecondaryRays,
) -> Light {
    let lights = scene.lights();
    let mut sum = Light {
        ambient: scene.ambient(),
        diffuse: [0.0; 3],
        specular: [0.0; 3],
        reflected: 0.0,
    };
    if let Some(reach) = scene.ambient_reach()
        && shadows
    {
        let point = draw.sample.point(draw.first_pair);
        let direction = scattered(simd, s.normal, s.geometric_normal, point);
        rays.ambient += 1;
        if intersect.occluded(&light::leaving(simd, (s, light::offset(s)), direction, reach)) {
            sum.ambient = 0.0;
        }
    }
    sum.ambient *= s.occlusion;
    if scene.ambient_specular() {
        sum.reflected = sum.ambient * reflectance(simd, s);
    }
    for (i, light) in lights.iter().enumerate() {
        let point = || draw.sample.point(draw.first_pair + 1 + i);
        let seen = light::seen(simd, &light.shape, s.point, point);
        let n_dot_l = simd.dot(s.normal, seen.to_light);
        if n_dot_l <= 0.0 || n_dot_l.is_nan() {
            continue;
        }
        let share = (!light.is_even()).then(|| light::share(simd, light, &seen));
        if share.is_some_and(|share| share <= 0.0) {
            continue;
        }
        let ray = light::ray_of(simd, &light.shape, s, &seen);
        let mut left = [1.0; 3];
        if let Some(ray) = ray.filter(|_| shadows) {
            rays.shadow += 1;
            match light_through(simd, scene, intersect, ray, medium) {
                Some(some) => left = some,
                None => continue,
            }
        }
        let power = light.power().map(|c| share.map_or(c, |share| c * share));
        let power = std::array::from_fn(|c| power[c] * left[c]);
        sum.add(simd, (s, material), (seen.to_light, n_dot_l), power);
    }
    if let Some(environment) = scene.environment() {
        for i in 0..scene.environment_rays() {
            let point = draw.sample.point(draw.first_pair + 1 + lights.len() + i);
            let (to_light, power) = match i {
                0 => light::from_environment(simd, environment, s.normal, point),
                _ => environment.sample_suns(point),
            };
            let n_dot_l = simd.dot(s.normal, to_light);
            rays.shadow += u64::from(shadows && n_dot_l > 0.0);
            let ray = light::leaving(simd, (s, light::lift(simd, s, to_light)), to_light, T_MAX);
            if n_dot_l > 0.0 {
                let left = if shadows {
                    light_through(simd, scene, intersect, (ray, false), medium)
                } else {
                    Some([1.0; 3])
                };
                if let Some(left) = left {
                    let power = std::array::from_fn(|c| power[c] * left[c] * s.occlusion);
                    sum.add(simd, (s, material), (to_light, n_dot_l), power);
                }
            }
        }
    }
    sum
}

/// How much ambient light a surface reflects, as a factor.
#[inline(always)]
fn reflectance<S: Simd>(simd: S, s: &Surface) -> f32 {
    let grazing = min(max(1.0 + simd.dot(s.normal, s.direction), 0.0), 1.0);
    let squared = grazing * grazing;
    let [least, more] = AMBIENT_SPECULAR;
    simd.mul_add(squared * squared * grazing, more, least)
}

impl Light {
    /// Adds the light from one direction.
    #[inline(always)]
    fn add<S: Simd>(
        &mut self,
        simd: S,
        (s, material): (&Surface, &Material),
        (to_light, n_dot_l): (Vec3, f32),
        power: [f32; 3],
    ) {
        add(simd, &mut self.diffuse, n_dot_l, power);
        if let Material::BlinnPhong { alpha, .. } = material {
            let halfway = simd.normalize(to_light - s.direction);
            let highlight = powi(max(simd.dot(s.normal, halfway), 0.0), *alpha);
            add(simd, &mut self.specular, highlight, power);
        }
    }
}

/// Returns the material at a hit, with its base colour times that of the vertices or the sphere and that of the texture,
/// and the light that it emits; `width` is that of the ray's cone.
#[inline(always)]
pub(super) fn tinted<S: Simd>(
    simd: S,
    scene: &Scene,
    ray: &Ray,
    hit: &SceneHit,
    width: f32,
) -> (Material, Option<[f32; 3]>) {
    let mut material = scene.materials()[scene.material_of(hit.primitive).0 as usize];
    let (mut emitted, mut shine) = (None, [1.0; 3]);
    if scene.has_colors() || scene.has_textures() {
        let mut tint = if scene.has_colors() {
            tint(simd, scene, hit)
        } else {
            [1.0; 3]
        };
        if let Some(textures) = scene.textures_of(hit.primitive) {
            let (mut point, mut normal) = (Vec3::ZERO, Vec3::ZERO);
            if textures.checker.is_some() {
                let surface = surface(simd, scene, ray, hit);
                (point, normal) = (surface.point, surface.geometric_normal);
            }
            let own = scene.textured(&TexturePoint {
                hit: *hit,
                point,
                normal,
                direction: ray.direction,
                width,
            });
            tint = std::array::from_fn(|i| tint[i] * own.base[i]);
            shine = own.specular;
            emitted = textures.emits().then_some(own.emitted);
        }
        if let Material::BlinnPhong { specular, .. } = &mut material {
            *specular = std::array::from_fn(|i| specular[i] * shine[i]);
        }
        match &mut material {
            Material::Glass { .. } => {}
            Material::Silhouette { color }
            | Material::Matte { color }
            | Material::Reflection { color, .. }
            | Material::BlinnPhong { diffuse: color, .. } => {
                *color = std::array::from_fn(|i| color[i] * tint[i]);
            }
        }
    }
    (material, emitted)
}

/// Returns the colour that the vertices or the sphere give to a hit; white without one.
#[inline(always)]
fn tint<S: Simd>(simd: S, scene: &Scene, hit: &Hit) -> [f32; 3] {
    let color = |colors: &[[f32; 3]], i: usize| colors.get(i).map_or(Vec3::ONE, |&c| Vec3::from_array(c));
    let own = match scene.primitive(hit.primitive) {
        Primitive::Triangle(i) => {
            let corners = scene.triangles().corners[i];
            let colors = corners.map(|vertex| color(&scene.vertices().colors, vertex as usize));
            interpolate(simd, colors, hit)
        }
        Primitive::Sphere(i) => color(&scene.spheres().color, i),
        Primitive::Plane(_) => Vec3::ONE,
    };
    own.to_array().map(|channel| min(max(channel, 0.0), 1.0))
}

/// Returns the base colour of the surface at a hit (c_d of Blinn-Phong), with the colours of vertices, spheres and
/// textures. `width` is that of the ray's cone at the hit.
#[must_use]
pub fn albedo(scene: &Scene, ray: &Ray, hit: &SceneHit, width: f32) -> [f32; 3] {
    match at_level!(Level::current(), |simd| tinted(simd, scene, ray, hit, width)).0 {
        Material::Silhouette { color } | Material::Matte { color } | Material::Reflection { color, .. } => {
            color
        }
        Material::BlinnPhong { diffuse, .. } => diffuse,
        Material::Glass { .. } => [1.0; 3],
    }
}

/// Returns the shading normal of a hit, a unit vector on the viewer's side.
#[must_use]
pub fn shading_normal(scene: &Scene, ray: &Ray, hit: &SceneHit) -> Vec3 {
    at_level!(Level::current(), |simd| surface(simd, scene, ray, hit)).normal
}

/// Returns the geometric normal of a hit, a unit vector on the viewer's side.
#[must_use]
pub fn geometric_normal(scene: &Scene, ray: &Ray, hit: &SceneHit) -> Vec3 {
    at_level!(Level::current(), |simd| surface(simd, scene, ray, hit)).geometric_normal
}

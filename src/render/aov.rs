//! Arbitrary output variables: what else is known of a pixel besides its colour.
//!
//! They are those of one ray through the pixel's centre, whatever the samples: an average of two distances or ids
//! would be neither's. One ray at a time over the wide hierarchy, in every mode.

use super::{Crop, OnProgress, RenderError, Renderer, Settings, renderer::Watch};
use crate::{
    accel::Bvh,
    ray::{Hit, PrimitiveId, Ray},
    reference::{
        cost::{self, Cost, Todo},
        shade::shading_normal,
    },
    scene::{Camera, Material, PixelRays, Scene},
};
use rayon::prelude::*;

/// What the ray through a pixel's centre meets first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aov {
    /// Distance from the eye along the ray, scene units; infinite where nothing is hit.
    pub depth: f32,
    /// Shading normal, a unit vector on the viewer's side; 0 where nothing is hit.
    pub normal: [f32; 3],
    /// The material's own colour, linear RGB, without light: that of a silhouette, matte or mirror, c_d of
    /// Blinn-Phong; 0 where nothing is hit.
    pub albedo: [f32; 3],
    /// Which primitive; [`PrimitiveId::NONE`] where nothing is hit.
    pub primitive: PrimitiveId,
    /// What the ray cost.
    pub cost: Cost,
}

/// The variables of all pixels of a picture, or of its crop.
#[derive(Clone, Debug, PartialEq)]
pub struct Aovs {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Row by row, row 0 on top.
    pub pixels: Vec<Aov>,
}

impl Renderer<'_> {
    /// Finds the variables of every pixel, on the threads that [`Renderer::render`] uses.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn aovs(
        &mut self,
        camera: &Camera,
        settings: &Settings,
        on_progress: OnProgress<'_>,
    ) -> Result<Aovs, RenderError> {
        settings.validate()?;
        let (scene, bvh) = self.scene();
        let window = settings.window();
        let rays = camera.pixel_rays(settings.width, settings.height, 1);
        let watch = Watch::new(window, on_progress);
        let find = || {
            let rows = (window.y0..window.y1).into_par_iter();
            let pixels = rows.map_init(Todo::default, |todo, y| {
                row(scene, bvh, &rays, window, y, todo, &watch)
            });
            pixels.flatten_iter().collect()
        };
        let pixels = match self.pool(settings.threads)? {
            Some(pool) => pool.install(find),
            None => find(),
        };
        watch.finish()?;
        Ok(Aovs {
            width: window.width(),
            height: window.height(),
            pixels,
        })
    }
}

fn row(
    scene: &Scene,
    bvh: &Bvh,
    rays: &PixelRays,
    window: Crop,
    y: u32,
    todo: &mut Todo,
    watch: &Watch<'_>,
) -> Vec<Aov> {
    if watch.is_cancelled() {
        return Vec::new();
    }
    let pixel = |x| {
        let ray = Ray::new(rays.eye(), rays.direction(x, y, [0, 0]));
        let (hit, cost) = cost::closest_hit(scene, bvh, todo, &ray);
        Aov::new(scene, &ray, &hit, cost)
    };
    let pixels: Vec<Aov> = (window.x0..window.x1).map(pixel).collect();
    watch.done(u64::from(window.width()));
    pixels
}

impl Aov {
    fn new(scene: &Scene, ray: &Ray, hit: &Hit, cost: Cost) -> Self {
        if !hit.is_hit() {
            return Self {
                depth: f32::INFINITY,
                normal: [0.0; 3],
                albedo: [0.0; 3],
                primitive: PrimitiveId::NONE,
                cost,
            };
        }
        let material = &scene.materials()[scene.material_of(hit.primitive).0 as usize];
        Self {
            depth: hit.t,
            normal: shading_normal(scene, ray, hit).to_array(),
            albedo: match *material {
                Material::Silhouette { color }
                | Material::Matte { color }
                | Material::Reflection { color, .. } => color,
                Material::BlinnPhong { diffuse, .. } => diffuse,
            },
            primitive: hit.primitive,
            cost,
        }
    }
}

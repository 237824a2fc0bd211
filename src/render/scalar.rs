//! Renders a tile with the scalar reference, pixel by pixel.

use super::{
    Pixel, RayCounts,
    frame::{FrameContext, TileRect},
};
use crate::{
    accel::BinaryBvh,
    ray::{Hit, Ray},
    reference::{
        bvh::{self, Stack},
        shade::{Intersect, Limits, PixelSample, SecondaryRays, radiance_at},
    },
    scene::Scene,
    simd::{Level, Simd, at_level},
};

struct OverBvh<'a> {
    bvh: &'a BinaryBvh,
    stack: Stack,
    level: Level,
    /// The scene, if parts of its surfaces are cut out.
    cut_outs: Option<&'a Scene>,
}

impl Intersect for OverBvh<'_> {
    fn closest_hit(&mut self, ray: &Ray) -> Hit {
        bvh::closest_hit_at(self.level, self.bvh, &mut self.stack, ray, self.cut_outs)
    }

    fn occluded(&mut self, ray: &Ray) -> bool {
        bvh::occluded_at(self.level, self.bvh, &mut self.stack, ray, self.cut_outs)
    }
}

/// Renders a tile into `band`, the rows of the film from `rect.y` on.
pub(super) fn render_tile<P: Pixel>(context: &FrameContext<'_>, rect: TileRect, band: &mut [P]) -> RayCounts {
    at_level!(context.settings.level, |simd| pixels(simd, context, rect, band))
}

#[inline(always)]
fn pixels<S: Simd, P: Pixel>(
    simd: S,
    context: &FrameContext<'_>,
    rect: TileRect,
    band: &mut [P],
) -> RayCounts {
    let &FrameContext {
        scene,
        bvh,
        camera_rays,
        window,
        settings,
    } = context;
    let mut intersect = OverBvh {
        bvh: bvh.binary(scene),
        stack: Stack::default(),
        level: settings.level,
        cut_outs: scene.has_cut_outs().then_some(scene),
    };
    let limits = Limits {
        max_depth: settings.max_depth,
        shadows: settings.shadows,
    };
    let mut rays = SecondaryRays::default();
    for (row, y) in band
        .chunks_exact_mut(window.width() as usize)
        .take(rect.height as usize)
        .zip(window.y0 + rect.y..)
    {
        for (pixel, x) in row[rect.x as usize..][..rect.width as usize]
            .iter_mut()
            .zip(window.x0 + rect.x..)
        {
            let mut sum = [0.0; 3];
            let mut covered = 0;
            for sample in camera_rays.samples() {
                let ray = Ray::new(camera_rays.eye(), camera_rays.direction(simd, [x, y], sample));
                if P::HAS_ALPHA && !intersect.closest_hit(&ray).is_hit() {
                    continue;
                }
                covered += 1;
                let number = camera_rays.index(sample);
                let sample = PixelSample {
                    pixel: [x, y],
                    number,
                    count: settings.samples,
                    width: camera_rays.pixel_width(),
                };
                let color = radiance_at(simd, scene, &mut intersect, (ray, sample), limits, &mut rays);
                for (sum, c) in sum.iter_mut().zip(color) {
                    *sum += c;
                }
            }
            let samples = settings.samples as f32;
            *pixel = P::from_linear(sum.map(|sum| sum / samples), covered as f32 / samples);
        }
    }
    RayCounts {
        camera: u64::from(rect.width) * u64::from(rect.height) * u64::from(settings.samples),
        shadow: rays.shadow,
        ambient: rays.ambient,
        reflection: rays.reflection,
    }
}

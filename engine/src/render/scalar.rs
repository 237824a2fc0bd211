//! Renders a tile with the scalar reference, pixel by pixel.

use super::{
    Pixel, RayCounts,
    adaptive::Neighborhood,
    frame::{FrameContext, TileRect},
    sums::Samples,
};
use crate::{
    reference::{
        bvh::OverScene,
        first_hit_at, seen_at,
        shade::{Limits, PixelSample, SecondaryRays, radiance_at},
    },
    simd::at_level,
};

/// Renders a tile into `band`, the rows of the film from `rect.y` on.
pub(super) fn render_tile<P: Pixel>(context: &FrameContext<'_>, rect: TileRect, band: &mut [P]) -> RayCounts {
    let mut tile = ScalarTile {
        context,
        intersect: OverScene::new(context.scene, context.bvh, context.settings.level),
        transparent: P::HAS_ALPHA,
        camera_rays: 0,
        rays: SecondaryRays::default(),
    };
    if context.settings.adaptive {
        tile.render_adaptive(rect, band);
    } else {
        tile.render(rect, band);
    }
    RayCounts {
        camera: tile.camera_rays,
        shadow: tile.rays.shadow,
        ambient: tile.rays.ambient,
        reflection: tile.rays.reflection,
    }
}

struct ScalarTile<'a> {
    context: &'a FrameContext<'a>,
    intersect: OverScene<'a>,
    /// Whether pixels have an opacity.
    transparent: bool,
    camera_rays: u64,
    rays: SecondaryRays,
}

impl ScalarTile<'_> {
    fn render<P: Pixel>(&mut self, rect: TileRect, band: &mut [P]) {
        let window = self.context.window;
        for (row, y) in band
            .chunks_exact_mut(window.width() as usize)
            .take(rect.height as usize)
            .zip(window.y0 + rect.y..)
        {
            for (to, x) in row[rect.x as usize..][..rect.width as usize]
                .iter_mut()
                .zip(window.x0 + rect.x..)
            {
                let mut samples = Samples::default();
                self.add_samples([x, y], self.context.settings.samples, &mut samples);
                let [r, g, b, alpha] = samples.mean();
                *to = P::from_linear([r, g, b], alpha);
            }
        }
    }

    /// The first samples of the tile and of the ring around it, then more of pixels that differ.
    fn render_adaptive<P: Pixel>(&mut self, rect: TileRect, band: &mut [P]) {
        let &FrameContext { window, settings, .. } = self.context;
        let tile = rect.absolute(window);
        let mut neighborhood = Neighborhood::default();
        let first_samples = self.context.first_samples();
        let area = neighborhood.restart(tile, &settings, first_samples);
        for pixel in area.each_pixel() {
            let mut samples = Samples::default();
            self.add_samples(pixel, first_samples, &mut samples);
            neighborhood.set(pixel, samples);
        }
        neighborhood.compare();
        for pixel in tile.each_pixel() {
            let mut grades = self.context.grades();
            if let Some(grade) = grades.find(|&grade| neighborhood.is_of(pixel, grade)) {
                let mut samples = neighborhood.samples(pixel);
                self.add_samples(pixel, grade.samples, &mut samples);
                neighborhood.set(pixel, samples);
                neighborhood.average(pixel);
            }
        }
        at_level!(settings.level, |simd| neighborhood.store(
            simd,
            tile,
            rect.x,
            window.width() as usize,
            band
        ));
    }

    /// Adds the missing samples of an absolute pixel, up to `count`.
    fn add_samples(&mut self, pixel: [u32; 2], count: u32, samples: &mut Samples) {
        let &FrameContext {
            scene,
            camera_rays,
            settings,
            medium,
            edges,
            ..
        } = self.context;
        let limits = Limits {
            max_depth: settings.max_depth,
            shadows: settings.shadows,
            transparent: self.transparent,
            medium,
        };
        for sample in camera_rays
            .samples()
            .take(count as usize)
            .skip(samples.count as usize)
        {
            self.camera_rays += 1;
            samples.begin();
            let ray = at_level!(settings.level, |simd| camera_rays.ray(simd, pixel, sample));
            if self.transparent && !seen_at(settings.level, scene, &mut self.intersect, &ray).is_hit() {
                continue;
            }
            let sample = PixelSample {
                pixel,
                number: camera_rays.index(sample),
                count: settings.samples,
                cone: camera_rays.cone(),
            };
            let ([r, g, b], alpha) = radiance_at(
                settings.level,
                scene,
                &mut self.intersect,
                (ray, sample),
                limits,
                &mut self.rays,
            );
            let mut rgba = [r, g, b, alpha];
            if let Some(edges) = &edges {
                let hit = first_hit_at(settings.level, scene, &mut self.intersect, &ray);
                rgba = edges.over(rgba, edges.cover(scene, &ray, &hit));
            }
            samples.add(rgba);
        }
    }
}

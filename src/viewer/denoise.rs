//! Denoises soft light and ambient occlusion in pictures of few samples per pixel.
//!
//! ```text
//! picture of few samples / unoccluded light = share of light --+
//!                                                              | mean over pixels of the same surface
//! denoised picture = unoccluded light x share of light <-------+
//! ```
//!
//! The unoccluded light needs no random rays, so edges and textures stay sharp, and means keep the brightness. Hard shadows
//! and highlights are smoothed with it if there is also soft light. The mean is an a-trous filter that stops at edges of
//! normals and planes: Dammertz et al., *Edge-Avoiding A-Trous Wavelet Transform for Fast Global Illumination Filtering*,
//! 2010.

use super::{
    first_hits::{BAND, FirstHits},
    surface,
    timeline::Model,
};
use crate::{
    reference::shade::shading_normal,
    render::{CameraRays, Film, Pattern, Settings, bands::Bands},
    scene::Camera,
};
use glam::Vec3;
use rayon::prelude::*;

/// The fewest pixels of a thread's piece of work.
const CHUNK: usize = 1 << 13;
/// Distances of the pixels that each pass averages, pixels: 15 pixels per side together. With four times as many samples
/// there is one pass less.
const PASSES: [usize; 3] = [1, 2, 4];
/// Weights of a neighbour, the middle, and the other neighbour in a row or column.
const KERNEL: [f32; 3] = [1.0, 2.0, 1.0];
/// The weight of the middle alone.
const OWN_WEIGHT: f32 = KERNEL[1] * KERNEL[1];
/// Enough weight of similar neighbours; 12 is the most.
const ENOUGH: f32 = 2.0;
/// Added to the light, so that black surfaces have a share.
const LEAST_LIGHT: f32 = 0.004;
/// Below this cosine between normals (29 degrees), pixels lie on different surfaces.
const LEAST_COSINE: f32 = 0.875;
/// Beyond this distance from the other's tangent plane, in distances of the pixels, pixels lie on different surfaces.
const MOST_STEP: f32 = 2.0;

/// What a pixel shows.
#[derive(Clone, Copy, Debug, Default)]
struct Surface {
    point: Vec3,
    /// Zero where nothing is averaged.
    normal: Vec3,
    /// Width of the pixel there.
    width: f32,
    /// Unoccluded light.
    light: Vec3,
}

impl Surface {
    /// Returns the similarity of another pixel, `distance` pixels away: 1 for the same surface, 0 for another one.
    fn likeness(&self, other: &Self, distance: usize) -> f32 {
        let cosine = self.normal.dot(other.normal);
        let step = self.normal.dot(other.point - self.point).abs();
        let alike = (cosine - LEAST_COSINE) / (1.0 - LEAST_COSINE);
        let near = 1.0 - step / (MOST_STEP * distance as f32 * self.width);
        alike.max(0.0) * near.max(0.0)
    }
}

/// The filter, which keeps its memory for the next picture.
#[derive(Debug, Default)]
pub struct Denoiser {
    surfaces: Vec<Surface>,
    /// Pixels that show another surface than a neighbour.
    edges: Vec<bool>,
    /// Shares of light, before and after a pass.
    shares: [Vec<Vec3>; 2],
}

impl Denoiser {
    /// Denoises a picture of these settings. With several samples per pixel, pixels at edges stay as they are: they show more
    /// than the surface in their centre.
    pub fn run(&mut self, model: &Model, camera: &Camera, settings: &Settings, film: &mut Film) {
        self.find_surfaces(model, camera, settings);
        let (pixels, width) = (film.pixels_mut(), settings.width as usize);
        let passes = match settings.samples {
            0..4 => &PASSES[..],
            4..16 => &PASSES[..2],
            _ => &PASSES[..1],
        };
        if settings.samples > 1 {
            self.leave_out_edges(width);
        }
        let [before, after] = &mut self.shares;
        after.resize(pixels.len(), Vec3::ZERO);
        pixels
            .par_iter()
            .zip(&self.surfaces)
            .with_min_len(CHUNK)
            .map(|(&rgb, surface)| Vec3::from(rgb) / (surface.light + LEAST_LIGHT))
            .collect_into_vec(before);
        for &distance in passes {
            let (surfaces, from) = (&self.surfaces, &*before);
            after.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
                for (x, to) in row.iter_mut().enumerate() {
                    *to = mean(surfaces, from, width, [x, y], distance);
                }
            });
            std::mem::swap(before, after);
        }
        pixels
            .par_iter_mut()
            .zip(&self.surfaces)
            .zip(&*before)
            .with_min_len(CHUNK)
            .filter(|((_, surface), _)| surface.normal != Vec3::ZERO)
            .for_each(|((rgb, surface), &share)| *rgb = (share * (surface.light + LEAST_LIGHT)).to_array());
    }

    fn leave_out_edges(&mut self, width: usize) {
        let surfaces = &self.surfaces;
        self.edges.resize(surfaces.len(), false);
        self.edges.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
            for (x, to) in row.iter_mut().enumerate() {
                *to = is_edge(surfaces, width, [x, y]);
            }
        });
        for (surface, _) in self
            .surfaces
            .iter_mut()
            .zip(&self.edges)
            .filter(|(_, edge)| **edge)
        {
            surface.normal = Vec3::ZERO;
        }
    }

    fn find_surfaces(&mut self, model: &Model, camera: &Camera, settings: &Settings) {
        let centre = Settings {
            samples: 1,
            adaptive: false,
            pattern: Pattern::Grid,
            ..*settings
        };
        let rays = CameraRays::new(&model.scene, camera, &centre);
        let (width, cone, edges) = (settings.width as usize, rays.cone(), rays.edges(&centre));
        self.surfaces.clear();
        self.surfaces
            .resize(width * settings.height as usize, Surface::default());
        Bands::new(&mut self.surfaces, settings.width, BAND)
            .in_turn()
            .for_each_init(
                || FirstHits::new(model, settings.level),
                |first_hits, (y, band)| {
                    let size = [width, band.len() / width];
                    first_hits.trace(&rays, size, y, [0, 0], &mut |i, ray, hit| {
                        // Edges of triangles are no noise.
                        let is_edge = edges.is_some_and(|edges| edges.cover(&model.scene, ray, hit) > 0.0);
                        if !hit.is_hit() || is_edge {
                            return;
                        }
                        let normal = shading_normal(&model.scene, ray, hit);
                        let light = surface::unoccluded(&model.scene, ray, hit, normal, cone);
                        if let Some(light) = light {
                            band[i] = Surface {
                                point: surface::point(ray, hit),
                                normal,
                                width: cone.width(hit.t),
                                light: light.into(),
                            };
                        }
                    });
                },
            );
    }
}

/// Whether a pixel shows another surface than a neighbour.
fn is_edge(surfaces: &[Surface], width: usize, [x, y]: [usize; 2]) -> bool {
    let height = surfaces.len() / width;
    let around = |at: usize, end: usize| at.saturating_sub(1)..(at + 2).min(end);
    let own = &surfaces[y * width + x];
    around(y, height).any(|row| {
        let row = &surfaces[row * width..][..width];
        around(x, width).any(|column| own.likeness(&row[column], 1) <= 0.0)
    })
}

/// Returns the mean share of light of a pixel and its neighbours on the same surface, or of all neighbours if hardly any is
/// on it.
fn mean(surfaces: &[Surface], shares: &[Vec3], width: usize, [x, y]: [usize; 2], distance: usize) -> Vec3 {
    let (height, at) = (surfaces.len() / width, y * width + x);
    let own = &surfaces[at];
    if own.normal == Vec3::ZERO {
        return shares[at];
    }
    let mut same = (shares[at] * OWN_WEIGHT, OWN_WEIGHT);
    let mut all = same;
    let steps = |at: usize, end: usize| {
        let near = (0..3).map(move |i| (i, (at + i * distance).wrapping_sub(distance)));
        near.filter(move |&(_, at)| at < end)
    };
    for (i, row) in steps(y, height) {
        for (j, column) in steps(x, width) {
            let at = row * width + column;
            let other = &surfaces[at];
            if (i, j) == (1, 1) || other.normal == Vec3::ZERO {
                continue;
            }
            let weight = KERNEL[i] * KERNEL[j];
            for (sum, weight) in [
                (&mut all, weight),
                (&mut same, weight * own.likeness(other, distance)),
            ] {
                sum.0 += shares[at] * weight;
                sum.1 += weight;
            }
        }
    }
    let alone = 1.0 - ((same.1 - OWN_WEIGHT) / ENOUGH).min(1.0);
    (same.0 / same.1).lerp(all.0 / all.1, alone)
}

//! Adaptive sampling: which pixels of a tile take all samples.
//!
//! ```text
//! tile and a ring of one pixel -- first samples --> means --> display values
//!                                                                |
//! pixels of the tile  <-- remaining samples --  those that differ from a neighbour
//! ```
//!
//! After Mitchell, *Generating Antialiased Images at Low Sampling Densities*, 1987. Colour alone decides, because what
//! does not show in it (an edge, a crease, a shadow) needs no more samples. Both modes decide by this code. The ring makes
//! a pixel independent of its tile and of the crop.

use super::{
    Pixel, Settings,
    frame::{FrameContext, TileRect},
};
use crate::scene::Scene;

/// First samples where light comes from points.
const FIRST: u32 = 1;

/// First samples where light is sampled too: the first four points of a sequence, one in each quarter of the pixel and of
/// the light. After one, grain would look like edges everywhere.
const FIRST_OF_SOFT: u32 = 4;

/// The largest difference between neighbours that is not refined, in display values: less than one of four rays of ambient
/// occlusion makes, more than the grain of soft light on a smooth surface.
const MAX_CONTRAST: f32 = 8.0 / 255.0;

impl FrameContext<'_> {
    /// Returns the samples that every pixel takes.
    pub fn first_samples(&self) -> u32 {
        let Settings {
            samples, adaptive, ..
        } = self.settings;
        match (adaptive, self.scene.is_sampled()) {
            (false, _) => samples,
            (true, false) => samples.min(FIRST),
            (true, true) => samples.min(FIRST_OF_SOFT),
        }
    }

    /// Returns the context of the whole picture. Its tiles lie at absolute pixels.
    pub fn whole(&self) -> Self {
        let settings = Settings {
            crop: None,
            ..self.settings
        };
        Self {
            window: settings.window(),
            settings,
            ..*self
        }
    }
}

impl Settings {
    /// Returns the camera rays that a pixel of `scene` is expected to take; shares of refined pixels as measured.
    pub(crate) fn expected_samples(&self, scene: &Scene) -> f64 {
        let (first, share) = if scene.is_sampled() {
            (FIRST_OF_SOFT, 0.6)
        } else {
            (FIRST, 0.1)
        };
        if !self.adaptive || self.samples <= first {
            return f64::from(self.samples);
        }
        f64::from(first) + share * f64::from(self.samples - first)
    }
}

/// The samples of the pixels of a tile and of the ring around it, as far as that is in the picture.
#[derive(Debug, Default)]
pub(super) struct Neighborhood {
    /// Absolute.
    area: TileRect,
    /// Row by row.
    pixels: Vec<Samples>,
    /// The display values of the means of the first samples.
    display: Vec<[f32; 4]>,
    /// Their ranges over each pixel and its neighbours to the left and right.
    rows: Vec<Range4>,
}

/// The range of each of four channels.
#[derive(Clone, Copy, Debug)]
struct Range4 {
    low: [f32; 4],
    high: [f32; 4],
}

impl Range4 {
    const EMPTY: Self = Self {
        low: [f32::INFINITY; 4],
        high: [f32::NEG_INFINITY; 4],
    };

    fn of(values: &[[f32; 4]]) -> Self {
        let ranges = values.iter().map(|&value| Self {
            low: value,
            high: value,
        });
        ranges.fold(Self::EMPTY, Self::union)
    }

    // One instruction each; `f32::min` would take care of NaN.
    fn union(self, other: Self) -> Self {
        let less = |a: f32, b: f32| if a < b { a } else { b };
        let more = |a: f32, b: f32| if a > b { a } else { b };
        Self {
            low: std::array::from_fn(|i| less(self.low[i], other.low[i])),
            high: std::array::from_fn(|i| more(self.high[i], other.high[i])),
        }
    }
}

/// The samples of a pixel.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Samples {
    /// Linear RGB and coverage.
    pub sum: [f32; 4],
    pub count: u32,
}

impl Neighborhood {
    /// Reserves memory for tiles of `width` x `height` pixels.
    pub fn reserve(&mut self, [width, height]: [u32; 2]) {
        let pixels = (width + 2) as usize * (height + 2) as usize;
        self.pixels.reserve(pixels);
        self.display.reserve(pixels);
        self.rows.reserve(pixels);
    }

    /// Forgets all samples. Returns the pixels around a tile, its own included; both are absolute.
    pub fn restart(&mut self, tile: TileRect, settings: &Settings) -> TileRect {
        let (x, y) = (tile.x.saturating_sub(1), tile.y.saturating_sub(1));
        self.area = TileRect {
            x,
            y,
            width: settings.width.min(tile.x + tile.width + 1) - x,
            height: settings.height.min(tile.y + tile.height + 1) - y,
        };
        self.pixels.clear();
        let pixels = self.area.width as usize * self.area.height as usize;
        self.pixels.resize(pixels, Samples::default());
        self.area
    }

    fn index(&self, [x, y]: [u32; 2]) -> usize {
        (y - self.area.y) as usize * self.area.width as usize + (x - self.area.x) as usize
    }

    /// Returns the samples of an absolute pixel of the area.
    pub fn at(&mut self, pixel: [u32; 2]) -> &mut Samples {
        let index = self.index(pixel);
        &mut self.pixels[index]
    }

    /// Takes in that all pixels have their first samples.
    pub fn finish_first(&mut self) {
        self.display.clear();
        self.display.extend(self.pixels.iter().map(Samples::display));
        self.rows.clear();
        let width = self.area.width as usize;
        for row in self.display.chunks_exact(width) {
            let near = |x: usize| &row[x.saturating_sub(1)..width.min(x + 2)];
            self.rows.extend((0..width).map(|x| Range4::of(near(x))));
        }
    }

    /// Returns whether an absolute pixel of the tile and its neighbours differ.
    pub fn differs(&self, [x, y]: [u32; 2]) -> bool {
        let bottom = self.area.y + self.area.height - 1;
        let rows = self.area.y.max(y.saturating_sub(1))..=bottom.min(y + 1);
        let rows = rows.map(|y| self.rows[self.index([x, y])]);
        let Range4 { low, high } = rows.fold(Range4::EMPTY, Range4::union);
        low.iter().zip(high).any(|(low, high)| high - low > MAX_CONTRAST)
    }

    /// Writes the means of a tile's samples to its columns of `band`, of rows of `row_length`.
    pub fn store<P: Pixel>(&self, tile: TileRect, column: u32, row_length: usize, band: &mut [P]) {
        let rows = band.chunks_exact_mut(row_length).take(tile.height as usize);
        for (row, y) in rows.zip(tile.y..) {
            let start = self.index([tile.x, y]);
            let columns = &mut row[column as usize..][..tile.width as usize];
            for (to, samples) in columns.iter_mut().zip(&self.pixels[start..]) {
                let [r, g, b, alpha] = samples.mean();
                *to = P::from_linear([r, g, b], alpha);
            }
        }
    }
}

impl Samples {
    /// Returns linear RGB and alpha.
    pub fn mean(&self) -> [f32; 4] {
        self.sum.map(|sum| sum / self.count as f32)
    }

    /// Returns the mean's square root, which is about what the sRGB curve makes of it. Where linear values are shown, it
    /// refines more than is needed in the dark, and up to half in the light.
    fn display(&self) -> [f32; 4] {
        self.mean().map(|c| c.clamp(0.0, 1.0).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The area of a tile whose pixels have these grey values as their mean of four samples.
    fn neighborhood(
        tile: TileRect,
        [width, height]: [u32; 2],
        grey: impl Fn([u32; 2]) -> f32,
    ) -> Neighborhood {
        let settings = Settings {
            width,
            height,
            ..Settings::default()
        };
        let mut neighborhood = Neighborhood::default();
        for pixel in neighborhood.restart(tile, &settings).each_pixel() {
            let sum = grey(pixel) * 4.0;
            *neighborhood.at(pixel) = Samples {
                sum: [0.0, sum, 0.0, 4.0],
                count: 4,
            };
        }
        neighborhood.finish_first();
        neighborhood
    }

    #[test]
    fn a_step_is_seen_from_all_sides_and_only_there() {
        let size = [20, 9];
        let tiles = [
            [0, 0, 20, 9],
            [3, 2, 5, 4],
            [6, 4, 1, 1],
            [12, 5, 8, 4],
            [0, 8, 20, 1],
        ];
        for [x, y, width, height] in tiles {
            let tile = TileRect { x, y, width, height };
            for step in [[6, 4], [0, 0], [19, 8], [2, 1], [11, 4]] {
                let picture = |value: f32| {
                    neighborhood(tile, size, move |pixel| if pixel == step { value } else { 0.25 })
                };
                // Squares of 0.5 and a little more or less than 8 levels of 255.
                for (value, is_seen) in [(0.2826, true), (0.2810, false), (0.2157, true), (0.2200, false)] {
                    let neighborhood = picture(value);
                    for pixel in tile.each_pixel() {
                        let is_near = (0..2).all(|i| pixel[i].abs_diff(step[i]) <= 1);
                        assert_eq!(
                            neighborhood.differs(pixel),
                            is_near && is_seen,
                            "{pixel:?} {step:?}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn what_a_screen_cannot_show_is_no_difference() {
        let tile = TileRect {
            x: 1,
            y: 1,
            width: 3,
            height: 3,
        };
        for (a, b, differ) in [(1.0, 9.0, false), (0.0, -3.0, false), (0.0, 0.01, true)] {
            let neighborhood = neighborhood(tile, [5, 5], |[x, _]| if x == 2 { a } else { b });
            assert_eq!(neighborhood.differs([2, 2]), differ, "{a} {b}");
        }
    }
}

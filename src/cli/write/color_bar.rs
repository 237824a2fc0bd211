//! The colours of numbers and what they mean, drawn over the right side of a picture.
//!
//! The bar depends on the whole picture's size alone, so that crops have their part of it.

use super::letters::{LETTER, fitting, ink};
use crate::cli::{
    load::Legend,
    plan::{ColorMap, color_of},
};

/// Width and height of the smallest picture that has room, pixels.
pub const SMALLEST: [u32; 2] = [160, 120];

/// Larger pictures, by their smaller side in pixels, enlarge the bar by whole numbers.
const USUAL: u32 = 400;
/// Width of the bar, and distances from the side of the picture and from the numbers, pixels.
const WIDTH: u32 = 16;
const MARGIN: u32 = 8;
const GAP: u32 = 6;
/// Numbers beside the bar.
const TICKS: u32 = 5;

/// Letters are dark with a light border, so that they are legible on everything.
const INK: [u8; 3] = [20; 3];
const PAPER: [u8; 3] = [245; 3];

/// A bar for a picture of a size, with its numbers.
pub struct ColorBar<'a> {
    name: &'a str,
    map: ColorMap,
    /// The numbers with the first and the last colour.
    range: [f64; 2],
    size: [u32; 2],
}

impl<'a> ColorBar<'a> {
    /// The bar of a picture of that size, at least [`SMALLEST`]; `None` if no number has a colour.
    pub fn new(legend: &'a Legend, size: [u32; 2]) -> Option<Self> {
        Some(Self {
            name: &legend.name,
            map: ColorMap::named(legend.map)?,
            range: [legend.low?, legend.high?],
            size,
        })
    }

    /// Calls `put` with the x and y of each pixel of the bar and its colour, an sRGB or linear byte like those of the colours.
    /// Later colours replace earlier ones.
    pub fn draw(&self, put: &mut dyn FnMut([u32; 2], [u8; 3])) {
        let [width, height] = self.size;
        let scale = (width.min(height) / USUAL).max(1);
        let labels = self.labels();
        let longest = labels.iter().map(|(_, label)| label.len()).max().unwrap_or(0) as u32;
        let right = width - MARGIN * scale;
        let text_left = right - longest * LETTER * scale;
        let left = text_left - (GAP + WIDTH) * scale;
        let rows = height * 3 / 5;
        let top = (height - rows) / 2 + LETTER * scale;
        let bar = [left, top, left + WIDTH * scale, top + rows];
        fill(grown(bar, 2 * scale), PAPER, put);
        fill(grown(bar, scale), INK, put);
        let colors = self
            .map
            .colors()
            .map(|color| color.map(|channel| (channel * 255.0).round() as u8));
        for row in 0..rows {
            let share = (f64::from(row) + 0.5) / f64::from(rows);
            let color = color_of(self.value(1.0 - share), self.range).map_or(INK, |i| colors[i]);
            fill([bar[0], top + row, bar[2], top + row + 1], color, put);
        }
        for (share, label) in &labels {
            let y = top + ((1.0 - share) * f64::from(rows)).round() as u32;
            write(
                &label.chars().collect::<Vec<_>>(),
                [text_left, y - LETTER / 2 * scale],
                scale,
                put,
            );
        }
        let most = (right - MARGIN * scale) / (LETTER * scale);
        let name = fitting(self.name, most as usize);
        let left = left.min(right - name.len() as u32 * LETTER * scale);
        write(&name, [left, top - (LETTER * 5 / 2) * scale], scale, put);
    }

    /// The number at a share of the bar's height: numbers grow upwards, also if the map is reversed.
    fn value(&self, share: f64) -> f64 {
        let [low, high] = self.range;
        low.min(high) * (1.0 - share) + low.max(high) * share
    }

    /// Numbers beside the bar, and at which share of its height.
    fn labels(&self) -> Vec<(f64, String)> {
        let [low, high] = self.range;
        if low == high {
            return vec![(0.5, text(low, low.abs() / 1000.0))];
        }
        let step = (high / f64::from(TICKS - 1) - low / f64::from(TICKS - 1)).abs();
        let shares = (0..TICKS).map(|i| f64::from(i) / f64::from(TICKS - 1));
        shares
            .map(|share| (share, text(self.value(share), step)))
            .collect()
    }
}

/// A rectangle (left, top, and the first column and row outside) with a border.
fn grown([left, top, right, bottom]: [u32; 4], by: u32) -> [u32; 4] {
    [left - by, top - by, right + by, bottom + by]
}

fn fill([left, top, right, bottom]: [u32; 4], color: [u8; 3], put: &mut dyn FnMut([u32; 2], [u8; 3])) {
    for y in top..bottom {
        for x in left..right {
            put([x, y], color);
        }
    }
}

/// Writes a line whose pixels are squares of `scale`.
fn write(line: &[char], [left, top]: [u32; 2], scale: u32, put: &mut dyn FnMut([u32; 2], [u8; 3])) {
    for (border, color) in [(scale, PAPER), (0, INK)] {
        for [x, y] in ink(line.iter().copied()) {
            let [x, y] = [left + x * scale, top + y * scale];
            fill(grown([x, y, x + scale, y + scale], border), color, put);
        }
    }
}

/// A number with as many digits as tell it from another that is a `step` away.
fn text(value: f64, step: f64) -> String {
    /// Letters of the longest number that is not written with a power of ten.
    const LONGEST: usize = 10;
    let digits = |number: f64| number.abs().log10().floor() as i32;
    if value == 0.0 {
        return "0".to_owned();
    }
    // Two digits of the step, such as 0.25 and 0.50, or three if it then is exact: 1.25.
    let is_exact = |decimals: i32| (step * 10_f64.powi(decimals)).fract().abs() < 1e-9;
    let two = 1_i32.saturating_sub(digits(step));
    let decimals = if !is_exact(two) && is_exact(two.saturating_add(1)) {
        two + 1
    } else {
        two
    };
    let decimals = decimals.max(0) as usize;
    if value.abs() < 10_f64.powi(LONGEST as i32) && decimals < LONGEST {
        let text = format!("{value:.decimals$}");
        if text.len() <= LONGEST {
            return text;
        }
    }
    let decimals = digits(value)
        .saturating_sub(digits(step))
        .saturating_add(1)
        .clamp(1, 6) as usize;
    format!("{value:.decimals$e}")
}

#[cfg(test)]
mod tests;

//! Height maps as normal maps (Blinn, *Simulation of Wrinkled Surfaces*, SIGGRAPH 1978).

use rayon::prelude::*;

/// How many texels white is above black. Material libraries leave it open.
const WHITE: f32 = 2.0;

/// How much the channels of a grey texel differ at most, in 255ths: JPEG rounds them.
const MOST_COLOR: u8 = 8;

/// Whether an image is grey, and so no normal map.
pub(super) fn is_grey(texels: &[[u8; 4]]) -> bool {
    texels.iter().all(|&[red, green, blue, _]| {
        let most = red.max(green).max(blue);
        most - red.min(green).min(blue) <= MOST_COLOR
    })
}

/// The normal map of a grey image that repeats, rows from the top.
pub(super) fn normals([width, height]: [u32; 2], heights: &[[u8; 4]]) -> Vec<[u8; 4]> {
    let [width, height] = [width as usize, height as usize];
    let at = |x: usize, y: usize| f32::from(heights[y % height * width + x % width][0]) / 255.0;
    let mut normals = vec![[0; 4]; heights.len()];
    normals.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        for (x, texel) in row.iter_mut().enumerate() {
            let right = (at(x + 1, y) - at(x + width - 1, y)) * (0.5 * WHITE);
            let top = (at(x, y + height - 1) - at(x, y + 1)) * (0.5 * WHITE);
            let length = (right * right + top * top + 1.0).sqrt();
            let [red, green, blue] = [-right, -top, 1.0].map(|n| ((n / length + 1.0) * 127.5 + 0.5) as u8);
            *texel = [red, green, blue, u8::MAX];
        }
    });
    normals
}

#[cfg(test)]
mod tests;

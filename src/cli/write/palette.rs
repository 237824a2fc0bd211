//! Palettes for small GIF pictures. The gif crate's NeuQuant learns from the pixels, and too few of them lose rare colours.

use std::collections::HashMap;

/// The colours of a GIF picture.
const MOST_COLORS: usize = 256;

/// Colours that one of the palette stands for.
struct ColorBox {
    colors: Vec<[u8; 3]>,
    low: [u8; 3],
    high: [u8; 3],
}

/// Replaces colours of RGB pixels by near ones, so that at most 256 are left; fewer stay as they are. The box of colours with the
/// longest side is halved again and again, which bounds the largest error.
pub fn reduce(rgb: &mut [u8]) {
    let (pixels, _) = rgb.as_chunks_mut::<3>();
    let mut colors = pixels.to_vec();
    colors.sort_unstable();
    colors.dedup();
    if colors.len() <= MOST_COLORS {
        return;
    }
    let mut boxes = vec![ColorBox::new(colors)];
    while boxes.len() < MOST_COLORS
        && let Some(longest) = boxes.iter_mut().max_by_key(|colors| colors.longest_side().0)
        && longest.longest_side().0 > 0
    {
        let half = longest.split();
        boxes.push(half);
    }
    let mut palette = HashMap::new();
    for colors in &boxes {
        let middle = colors.middle();
        palette.extend(colors.colors.iter().map(|&color| (color, middle)));
    }
    for pixel in pixels {
        *pixel = palette[pixel];
    }
}

impl ColorBox {
    fn new(colors: Vec<[u8; 3]>) -> Self {
        let mut this = Self {
            colors,
            low: [u8::MAX; 3],
            high: [0; 3],
        };
        for color in &this.colors {
            for (channel, &value) in color.iter().enumerate() {
                this.low[channel] = this.low[channel].min(value);
                this.high[channel] = this.high[channel].max(value);
            }
        }
        this
    }

    /// Its length, and its channel.
    fn longest_side(&self) -> (u8, usize) {
        let sides = [0, 1, 2].map(|channel| (self.high[channel].saturating_sub(self.low[channel]), channel));
        sides.into_iter().max().unwrap_or_default()
    }

    fn middle(&self) -> [u8; 3] {
        [0, 1, 2].map(|channel| self.low[channel].midpoint(self.high[channel]))
    }

    /// Keeps the darker half, and returns the other one.
    fn split(&mut self) -> Self {
        let (_, channel) = self.longest_side();
        let middle = self.middle()[channel];
        let colors = std::mem::take(&mut self.colors);
        let (dark, bright) = colors.into_iter().partition(|color| color[channel] <= middle);
        *self = Self::new(dark);
        Self::new(bright)
    }
}

#[cfg(test)]
mod tests;

//! Palettes for small GIF pictures. The gif crate's NeuQuant learns from the pixels, and too few of them lose rare colours.

use std::collections::HashMap;

/// The colours of a GIF picture.
const MOST_COLOURS: usize = 256;

/// Colours that one of the palette stands for.
struct ColourBox {
    colours: Vec<[u8; 3]>,
    low: [u8; 3],
    high: [u8; 3],
}

/// Replaces colours of RGB pixels by near ones, so that at most 256 are left; fewer stay as they are. The box of colours with the
/// longest side is halved again and again, which bounds the largest error.
pub fn reduce(rgb: &mut [u8]) {
    let (pixels, _) = rgb.as_chunks_mut::<3>();
    let mut colours = pixels.to_vec();
    colours.sort_unstable();
    colours.dedup();
    let mut boxes = vec![ColourBox::new(colours)];
    while boxes.len() < MOST_COLOURS
        && let Some(longest) = boxes.iter_mut().max_by_key(|colours| colours.longest_side().0)
        && longest.longest_side().0 > 0
    {
        let half = longest.split();
        boxes.push(half);
    }
    let mut palette = HashMap::new();
    for colours in &boxes {
        let middle = colours.middle();
        palette.extend(colours.colours.iter().map(|&colour| (colour, middle)));
    }
    for pixel in pixels {
        *pixel = palette[pixel];
    }
}

impl ColourBox {
    fn new(colours: Vec<[u8; 3]>) -> Self {
        let mut this = Self {
            colours,
            low: [u8::MAX; 3],
            high: [0; 3],
        };
        for colour in &this.colours {
            for (channel, &value) in colour.iter().enumerate() {
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
        let colours = std::mem::take(&mut self.colours);
        let (dark, bright) = colours.into_iter().partition(|colour| colour[channel] <= middle);
        *self = Self::new(dark);
        Self::new(bright)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_colours_stay_and_many_stay_near() {
        let mut few: Vec<u8> = (0..256_u32)
            .flat_map(|i| [i * 7 % 256, i, i * i % 256].map(|value| value as u8))
            .collect();
        let before = few.clone();
        reduce(&mut few);
        assert_eq!(few, before);
        // A ramp of 766 colours, each step one of a channel.
        let ramp = |i: u32| [0, 255, 510].map(|start| i.saturating_sub(start).min(255) as u8);
        let before: Vec<u8> = (0..766).flat_map(ramp).collect();
        let mut many = before.clone();
        reduce(&mut many);
        let largest = many.iter().zip(&before).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(largest <= Some(2), "{largest:?}");
        let mut colours = many.as_chunks::<3>().0.to_vec();
        colours.sort_unstable();
        colours.dedup();
        assert!(colours.len() <= MOST_COLOURS);
        reduce(&mut []);
    }
}

//! Pixels of the window: the traced picture, enlarged, and text.

use crate::render::ByteFilm;
use font8x8::legacy::BASIC_LEGACY;
use rayon::prelude::*;

/// Side of a character, pixels.
const CELL: usize = 8;
/// Pixels between lines, and around a panel.
const GAP: usize = 3;

/// A picture of 0RGB pixels, row by row.
pub struct Canvas<'a> {
    /// The pixels.
    pub pixels: &'a mut [u32],
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
}

/// Enlarges a traced picture to `width` x `height` pixels. Each takes the nearest traced one.
pub fn spread(film: &ByteFilm, [width, height]: [u32; 2], to: &mut Vec<u32>) {
    let pack = |[r, g, b]: [u8; 3]| u32::from_be_bytes([0, r, g, b]);
    let from_width = film.width() as usize;
    let nearest = |i: usize, from: u32, to: u32| i * from as usize / to as usize;
    let columns: Vec<usize> = (0..width as usize)
        .map(|x| nearest(x, film.width(), width))
        .collect();
    to.resize(width as usize * height as usize, 0);
    to.par_chunks_mut(width as usize)
        .enumerate()
        .for_each(|(y, row)| {
            let from = &film.pixels()[nearest(y, film.height(), height) * from_width..][..from_width];
            if film.width() == width {
                for (to, &from) in row.iter_mut().zip(from) {
                    *to = pack(from);
                }
            } else {
                for (to, &x) in row.iter_mut().zip(&columns) {
                    *to = pack(from[x]);
                }
            }
        });
}

/// The width and height of a panel with lines of at most `longest` letters, pixels.
#[must_use]
pub fn panel_size(longest: usize, lines: usize, scale: usize) -> [usize; 2] {
    [longest * CELL + 2 * GAP, lines * (CELL + GAP) + GAP].map(|side| side * scale)
}

/// Draws lines of text on a darkened panel whose top left corner is at (`x`, `y`). Returns the row below it. Letters are
/// `scale` times 8 pixels large. Other characters than ASCII are shown as `?`; text beyond the edge is cut off.
pub fn panel(
    canvas: &mut Canvas<'_>,
    [x, y]: [usize; 2],
    lines: &[String],
    color: u32,
    scale: usize,
) -> usize {
    let longest = lines.iter().map(|line| line.chars().count()).max().unwrap_or(0);
    let (width, height) = (canvas.width as usize, canvas.height as usize);
    let pitch = (CELL + GAP) * scale;
    let [panel_width, panel_height] = panel_size(longest, lines.len(), scale);
    let right = (x + panel_width).min(width);
    let bottom = (y + panel_height).min(height);
    for row in canvas.pixels.chunks_exact_mut(width).take(bottom).skip(y) {
        for pixel in &mut row[x.min(right)..right] {
            // A quarter of the brightness.
            *pixel = *pixel >> 2 & 0x003f_3f3f;
        }
    }
    for (i, line) in lines.iter().enumerate() {
        let at = [x + GAP * scale, y + GAP * scale + i * pitch];
        text(canvas, at, line, color, scale);
    }
    bottom
}

fn text(canvas: &mut Canvas<'_>, [x, y]: [usize; 2], line: &str, color: u32, scale: usize) {
    for (i, c) in line.chars().enumerate() {
        let glyph = BASIC_LEGACY
            .get(c as usize)
            .unwrap_or(&BASIC_LEGACY['?' as usize]);
        for (row, bits) in glyph.iter().enumerate() {
            for column in (0..CELL).filter(|column| bits >> column & 1 == 1) {
                let (left, top) = (x + (i * CELL + column) * scale, y + row * scale);
                for (px, py) in (0..scale).flat_map(|dy| (0..scale).map(move |dx| (left + dx, top + dy))) {
                    if px < canvas.width as usize && py < canvas.height as usize {
                        canvas.pixels[py * canvas.width as usize + px] = color;
                    }
                }
            }
        }
    }
}

/// Cuts text into lines of at most `columns` characters, between words if that wastes less than half a line.
#[must_use]
pub fn wrap(text: &str, columns: usize) -> Vec<String> {
    let columns = columns.max(8);
    let mut lines = Vec::new();
    for line in text.lines() {
        let letters: Vec<char> = line.chars().collect();
        let mut rest = &letters[..];
        while rest.len() > columns {
            let space = (columns / 2..=columns).rev().find(|&i| rest[i] == ' ');
            lines.push(rest[..space.unwrap_or(columns)].iter().collect());
            rest = &rest[space.map_or(columns, |space| space + 1)..];
        }
        lines.push(rest.iter().collect());
    }
    lines
}

#[cfg(test)]
mod tests;

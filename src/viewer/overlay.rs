//! Text over the picture.

use super::{
    keys,
    mailbox::Picture,
    screen::{self, Canvas},
};
use std::ops::RangeInclusive;

/// Pixels between the edge of the window and a panel, and between panels.
const MARGIN: usize = 8;

const WHITE: u32 = 0x00ff_ffff;
const RED: u32 = 0x00ff_8080;
/// Colour where there is no picture.
const EMPTY: u32 = 0x0040_4040;

/// The panels to draw.
#[derive(Default)]
pub struct Overlay<'a> {
    /// Whether the help is shown.
    pub help: bool,
    /// Frames and rays per second.
    pub figures: Option<Vec<String>>,
    /// Description of the pixel under the mouse.
    pub probed: Option<&'a [String]>,
    /// The share of the next picture that is done, 0 to 1.
    pub progress: Option<f32>,
    /// Why the files could not be loaded.
    pub error: Option<&'a str>,
    /// What a key did.
    pub message: Option<&'a str>,
}

/// Columns and lines that a panel other than the help should have room for.
const PANEL: [usize; 2] = [24, 3];

/// How many times the 8 x 8 font is enlarged for panels: to 12 points, smaller in a small window, but to no less than 6
/// points. A point is 4/3 pixels times the scale factor of the screen.
fn text_scale(size: [u32; 2], scale_factor: f64) -> usize {
    let [least, most] = scales(scale_factor);
    largest_fit(PANEL, size, least..=most)
}

/// The same for the help, which shrinks until all of it fits into the window.
fn help_scale(size: [u32; 2], scale_factor: f64) -> usize {
    let [_, most] = scales(scale_factor);
    largest_fit(help_size(), size, 1..=most)
}

/// Those of 6 and 12 points.
fn scales(scale_factor: f64) -> [usize; 2] {
    [1.0, 2.0].map(|scale| ((scale * scale_factor).round() as usize).max(1))
}

/// The largest scale with which a panel of these columns and lines fits into the window; the smallest if none does.
fn largest_fit(
    [columns, lines]: [usize; 2],
    [width, height]: [u32; 2],
    scales: RangeInclusive<usize>,
) -> usize {
    let fits = |&scale: &usize| {
        let [w, h] = screen::panel_size(columns, lines, scale);
        w + 2 * MARGIN <= width as usize && h + 2 * MARGIN <= height as usize
    };
    let least = *scales.start();
    scales.rev().find(fits).unwrap_or(least)
}

/// Columns and lines of the help.
fn help_size() -> [usize; 2] {
    let longest = keys::HELP.iter().map(|line| line.len()).max();
    [longest.unwrap_or(0), keys::HELP.len()]
}

/// Draws the panels from the top down, in letters that suit the scale factor of the screen.
pub fn draw(canvas: &mut Canvas<'_>, scale_factor: f64, overlay: &Overlay<'_>) {
    let size = [canvas.width, canvas.height];
    let scale = text_scale(size, scale_factor);
    let mut y = MARGIN;
    let mut show = |text: &str, color: u32, scale: usize| {
        let columns = (canvas.width as usize).saturating_sub(4 * MARGIN) / (8 * scale);
        let lines = screen::wrap(text, columns);
        y = screen::panel(canvas, [MARGIN, y], &lines, color, scale) + MARGIN;
    };
    if let Some(error) = overlay.error {
        show(error, RED, scale);
    }
    if overlay.help {
        show(&keys::HELP.join("\n"), WHITE, help_scale(size, scale_factor));
    }
    for lines in [overlay.figures.as_deref(), overlay.probed].into_iter().flatten() {
        show(&lines.join("\n"), WHITE, scale);
    }
    if let Some(progress) = overlay.progress {
        let text = format!("next picture: {:.0} %", progress * 100.0);
        show(&text, WHITE, scale);
    }
    if let Some(message) = overlay.message {
        show(message, WHITE, scale);
    }
}

/// Draws nothing but a message.
pub fn only(canvas: &mut Canvas<'_>, scale_factor: f64, message: &str) {
    canvas.pixels.fill(EMPTY);
    let overlay = Overlay {
        message: Some(message),
        ..Overlay::default()
    };
    draw(canvas, scale_factor, &overlay);
}

/// Copies a picture. One of another size, from before the window was resized, covers a part.
pub fn copy(picture: &Picture, to: &mut Canvas<'_>) {
    if picture.size == [to.width, to.height] {
        to.pixels.copy_from_slice(&picture.pixels);
        return;
    }
    to.pixels.fill(EMPTY);
    let columns = picture.size[0].min(to.width) as usize;
    if columns > 0 {
        let from = picture.pixels.chunks_exact(picture.size[0] as usize);
        for (to, from) in to.pixels.chunks_exact_mut(to.width as usize).zip(from) {
            to[..columns].copy_from_slice(&from[..columns]);
        }
    }
}

#[cfg(test)]
mod tests;

//! What the window shows over a picture.

use super::{
    keys,
    mailbox::Picture,
    screen::{self, Canvas},
};

const WHITE: u32 = 0x00ff_ffff;
const RED: u32 = 0x00ff_8080;

/// What is written over a picture.
pub struct Overlay<'a> {
    /// The keys.
    pub help: bool,
    /// Frames and rays a second.
    pub figures: Option<Vec<String>>,
    /// What is under the mouse.
    pub probed: Option<&'a [String]>,
    /// How much of the next picture is done, 0 to 1.
    pub progress: Option<f32>,
    /// What is wrong with the files.
    pub error: Option<&'a str>,
    /// What a key has done.
    pub message: Option<&'a str>,
}

/// Writes it, from the top down.
pub fn overlay(canvas: &mut Canvas<'_>, overlay: &Overlay<'_>) {
    const MARGIN: usize = 8;
    // Twice as large where all keys still fit.
    let scale = if canvas.width >= 1000 && canvas.height >= 600 {
        2
    } else {
        1
    };
    let columns = (canvas.width as usize).saturating_sub(4 * MARGIN) / (8 * scale);
    let mut y = MARGIN;
    let mut show = |text: &str, color: u32| {
        let lines = screen::wrap(text, columns);
        y = screen::panel(canvas, [MARGIN, y], &lines, color, scale) + MARGIN;
    };
    if let Some(error) = overlay.error {
        show(error, RED);
    }
    if overlay.help {
        show(&keys::HELP.join("\n"), WHITE);
    }
    if let Some(lines) = &overlay.figures {
        show(&lines.join("\n"), WHITE);
    }
    if let Some(lines) = overlay.probed {
        show(&lines.join("\n"), WHITE);
    }
    if let Some(progress) = overlay.progress {
        show(&format!("next picture {:.0} %", progress * 100.0), WHITE);
    }
    if let Some(message) = overlay.message {
        show(message, WHITE);
    }
}

/// Copies a picture; one of another size, from before the window had its own, fills what it can.
pub fn copy(picture: &Picture, to: &mut [u32], [width, height]: [u32; 2]) {
    if picture.size == [width, height] {
        to.copy_from_slice(&picture.pixels);
        return;
    }
    to.fill(0x0040_4040);
    let columns = picture.size[0].min(width) as usize;
    if columns > 0 {
        let from = picture.pixels.chunks_exact(picture.size[0] as usize);
        for (to, from) in to.chunks_exact_mut(width as usize).zip(from) {
            to[..columns].copy_from_slice(&from[..columns]);
        }
    }
}

//! Contact sheets: all pictures of a call in one, each with its name below.

use super::{
    output::Output,
    picture::{Picture, Pixels},
};
use crate::{cli::CliError, render::ByteFilm};
use font8x8::legacy::BASIC_LEGACY;

/// Pixels between pictures, and around them.
const GAP: u32 = 8;
/// Rows of a name.
const NAME: u32 = 16;
/// Side of a letter, pixels.
const LETTER: u32 = 8;

const PAPER: [u8; 3] = [255; 3];
const INK: [u8; 3] = [40; 3];
const GREY: [u8; 3] = [140; 3];
/// Where a name was cut.
const CUT: &str = "..";

/// A sheet that is being filled, row by row.
pub struct Sheet {
    film: ByteFilm,
    columns: u32,
    /// Width and height of a picture.
    cell: [u32; 2],
    next: u32,
}

/// Returns width and height of a sheet; `None` if it has too many pixels.
pub fn sheet_size([width, height]: [u32; 2], columns: u32, count: u32) -> Option<[u32; 2]> {
    let columns = columns.min(count.max(1));
    let along = |cells: u32, side: u32| cells.checked_mul(side.checked_add(GAP)?)?.checked_add(GAP);
    Some([
        along(columns, width)?,
        along(count.max(1).div_ceil(columns), height.checked_add(NAME)?)?,
    ])
}

impl Sheet {
    /// Makes a sheet for `count` pictures of a size.
    ///
    /// # Errors
    /// [`CliError::Memory`] if it does not fit into memory.
    pub fn new(cell: [u32; 2], columns: u32, count: u32) -> Result<Self, CliError> {
        let too_large = || CliError::Memory("the sheet does not fit into memory".to_owned());
        let [width, height] = sheet_size(cell, columns, count).ok_or_else(too_large)?;
        let mut film = ByteFilm::black(0, 0);
        film.try_resize(width, height).map_err(|_| too_large())?;
        film.pixels_mut().fill(PAPER);
        Ok(Self {
            film,
            columns: columns.min(count.max(1)),
            cell,
            next: 0,
        })
    }

    /// Width and height, pixels.
    pub fn size(&self) -> (u32, u32) {
        (self.film.width(), self.film.height())
    }

    /// Adds a picture, or leaves its place empty and says that it was skipped.
    pub fn add(&mut self, name: &str, picture: Option<&Picture>) {
        let [width, height] = self.cell;
        let (column, row) = (self.next % self.columns, self.next / self.columns);
        let left = GAP + column * (width + GAP);
        let top = GAP + row * (height + NAME + GAP);
        self.next += 1;
        let row_length = self.film.width() as usize;
        if let Some(picture) = picture {
            let bytes = picture.bytes();
            let (pixels, _) = bytes.as_chunks::<3>();
            for (y, from) in (top as usize..).zip(pixels.chunks_exact(width as usize)) {
                self.film.pixels_mut()[y * row_length + left as usize..][..width as usize]
                    .copy_from_slice(from);
            }
        }
        let below = top + height;
        if picture.is_some() {
            self.write(name, [left, below + (NAME - LETTER) / 2], INK);
        } else {
            self.write(name, [left, below], INK);
            self.write("skipped", [left, below + LETTER + 2], GREY);
        }
    }

    /// Writes a line below a picture, in the middle.
    fn write(&mut self, name: &str, [left, top]: [u32; 2], ink: [u8; 3]) {
        let most = (self.cell[0] / LETTER) as usize;
        let letters = fitting(name, most);
        let first = left + (self.cell[0] - letters.len() as u32 * LETTER) / 2;
        let row_length = self.film.width() as usize;
        let pixels = self.film.pixels_mut();
        for (i, letter) in (0..).zip(letters) {
            let glyph = BASIC_LEGACY
                .get(letter as usize)
                .unwrap_or(&BASIC_LEGACY['?' as usize]);
            for (y, bits) in (top..).zip(glyph) {
                for x in (0..LETTER).filter(|x| bits >> x & 1 == 1) {
                    pixels[y as usize * row_length + (first + i * LETTER + x) as usize] = ink;
                }
            }
        }
    }

    /// Writes the sheet.
    ///
    /// # Errors
    /// [`CliError`].
    pub fn finish(self, output: &Output) -> Result<(), CliError> {
        output.write(&mut Picture::from(Pixels::Bytes(self.film)))
    }
}

/// A name of at most that many letters; one that is too long loses its middle, since names differ at their ends.
fn fitting(name: &str, most: usize) -> Vec<char> {
    let letters: Vec<char> = name.chars().collect();
    let kept = most.saturating_sub(CUT.len());
    if letters.len() <= most || kept < 2 {
        return letters.into_iter().take(most).collect();
    }
    let (head, tail) = (kept.div_ceil(2), kept / 2);
    let tail = &letters[letters.len() - tail..];
    letters[..head]
        .iter()
        .copied()
        .chain(CUT.chars())
        .chain(tail.iter().copied())
        .collect()
}

#[cfg(test)]
mod tests;

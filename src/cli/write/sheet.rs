//! Contact sheets: all pictures of a call in one, each with its name below.

use super::{
    letters::{LETTER, fitting, ink},
    output::Output,
    picture::{Picture, Pixels},
};
use crate::{cli::CliError, render::ByteFilm};

/// Pixels between pictures, and around them.
const GAP: u32 = 8;
/// Rows of a name.
const NAME: u32 = 16;

const PAPER: [u8; 3] = [255; 3];
const INK: [u8; 3] = [40; 3];
const GREY: [u8; 3] = [140; 3];

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
    fn write(&mut self, name: &str, [left, top]: [u32; 2], color: [u8; 3]) {
        let most = (self.cell[0] / LETTER) as usize;
        let letters = fitting(name, most);
        let first = left + (self.cell[0] - letters.len() as u32 * LETTER) / 2;
        let row_length = self.film.width() as usize;
        let pixels = self.film.pixels_mut();
        for [x, y] in ink(letters) {
            pixels[(top + y) as usize * row_length + (first + x) as usize] = color;
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

#[cfg(test)]
mod tests;

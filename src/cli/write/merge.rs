//! `octray merge`: joins tiles, the files of `--crop`, into the file of the whole picture.
//!
//! Samples are copied unchanged and encoded like `octray render` does, which gives the same bytes.

use super::{
    decode::Source,
    encode::Format,
    mark::read_ends,
    place::Place,
    samples::{Samples, changed, cover, read_exr},
};
use crate::{
    cli::{
        CliError,
        load::memory::{self, PixelBytes},
    },
    error::clip_path,
    render::Crop,
};
use image::{DynamicImage, ImageError, ImageFormat};
use std::path::{Path, PathBuf};

/// The largest pixel of an EXR file with all AOVs, bytes, with room for compression that makes it larger.
const EXR_PIXEL_BYTES: u64 = 128;

/// The file of a crop.
#[derive(Debug)]
pub struct Tile {
    path: PathBuf,
    place: Place,
    format: Format,
}

/// Tiles that cover one picture.
#[derive(Debug)]
pub struct Tiles(Vec<Tile>);

impl Tile {
    /// Reads the place of a tile.
    ///
    /// # Errors
    /// [`CliError::Failed`] if it cannot be read or is not a tile.
    fn open(path: &Path) -> Result<Self, CliError> {
        let name = clip_path(path);
        let known = path.extension().and_then(Format::from_extension);
        let why = match known {
            None => format!("unknown extension, expected {}", Format::MERGED),
            Some(Format::Jpeg) => "JPEG loses detail in each tile; render the tiles as .png".into(),
            Some(format) if format.is_animation() => {
                "animations are not merged; render frames as .png".into()
            }
            Some(format) => {
                let ends = read_ends(path).map_err(|error| {
                    let size = (0, 0);
                    let source = Source {
                        path,
                        role: "tile",
                        size,
                    };
                    source.unreadable(&ImageError::IoError(error))
                })?;
                if let Some(place) = Place::find(format, &ends.0, &ends.1) {
                    return Ok(Self {
                        path: path.to_owned(),
                        place,
                        format,
                    });
                }
                "not a tile: only pictures of octray render --crop record their place".into()
            }
        };
        Err(CliError::Failed(format!("{name}: {why}")))
    }

    fn name(&self) -> String {
        clip_path(&self.path)
    }

    fn source(&self) -> Source<'_> {
        let crop = self.place.crop;
        Source {
            path: &self.path,
            role: "tile",
            size: (crop.width(), crop.height()),
        }
    }

    /// Whether the tile is of the same picture as `first`, as far as that is known without its pixels.
    fn check_fits(&self, first: &Self) -> Result<(), CliError> {
        let kinds = [self, first].map(|Self { place, format, .. }| {
            let [width, height] = place.whole;
            [
                format!("is {}", format.name()),
                format!("is of a picture of {width}x{height}"),
                format!("was rendered with --samples {}", place.samples()),
                format!("shows {}", place.shows),
            ]
        });
        match kinds[0]
            .iter()
            .zip(&kinds[1])
            .find(|(ours, firsts)| ours != firsts)
        {
            Some((ours, firsts)) => Err(self.differs(ours, first, firsts)),
            None => Ok(()),
        }
    }

    fn differs(&self, ours: &str, first: &Self, firsts: &str) -> CliError {
        let (name, first) = (self.name(), first.name());
        CliError::Failed(format!("{name} {ours}, but {first} {firsts}"))
    }

    fn read(&self) -> Result<Samples, CliError> {
        let (width, height) = self.source().size;
        let samples = match self.format {
            Format::Exr => {
                let read = |bytes: &[u8]| read_exr(bytes, [width as usize, height as usize]);
                return self.source().read_bytes(EXR_PIXEL_BYTES, read).map(Samples::Exr);
            }
            Format::Png => self.source().decode(Some(ImageFormat::Png))?,
            Format::Ppm => self.source().decode(Some(ImageFormat::Pnm))?,
            Format::Qoi => self.source().decode(Some(ImageFormat::Qoi))?,
            Format::Bmp => self.source().decode(Some(ImageFormat::Bmp))?,
            _ => self.source().decode(Some(ImageFormat::Tiff))?,
        };
        match samples {
            _ if (samples.width(), samples.height()) != (width, height) => {
                Err(self.source().unreadable(&changed()))
            }
            DynamicImage::ImageRgb8(image) => Ok(Samples::Bytes(image.into_raw(), 3)),
            DynamicImage::ImageRgba8(image) => Ok(Samples::Bytes(image.into_raw(), 4)),
            DynamicImage::ImageLuma8(image) => Ok(Samples::Bytes(image.into_raw(), 1)),
            DynamicImage::ImageLuma16(image) => {
                let bytes = image.into_raw().into_iter().flat_map(u16::to_be_bytes);
                Ok(Samples::Bytes(bytes.collect(), 2))
            }
            _ => Err(self.source().unreadable(&changed())),
        }
    }
}

impl Tiles {
    /// Looks into all files: whether they are tiles of one picture and cover it, within `memory` bytes.
    ///
    /// # Errors
    /// [`CliError::Failed`].
    pub fn open(paths: &[PathBuf], memory: u64) -> Result<Self, CliError> {
        let tiles: Vec<Tile> = paths
            .iter()
            .map(|path| Tile::open(path))
            .collect::<Result<_, _>>()?;
        let this = Self(tiles);
        for tile in &this.0 {
            tile.check_fits(this.first()?)?;
        }
        let [width, height] = this.size()?;
        this.check_memory(memory, 1, false)?;
        let mut covered = vec![false; width as usize * height as usize];
        for tile in &this.0 {
            cover(&mut covered, width, tile.place.crop);
        }
        match first_gap(&covered, width) {
            None => Ok(this),
            Some(gap) => Err(CliError::Failed(format!(
                "tiles are missing: none covers --crop {gap} of {width}x{height}"
            ))),
        }
    }

    fn first(&self) -> Result<&Tile, CliError> {
        self.0.first().ok_or_else(no_tiles)
    }

    /// Width and height of the whole picture, pixels.
    ///
    /// # Errors
    /// [`CliError::Usage`] if there are no tiles.
    pub fn size(&self) -> Result<[u32; 2], CliError> {
        Ok(self.first()?.place.whole)
    }

    /// The format of all tiles.
    ///
    /// # Errors
    /// [`CliError::Usage`] if there are no tiles.
    pub fn format(&self) -> Result<Format, CliError> {
        Ok(self.first()?.format)
    }

    fn check_memory(&self, memory: u64, film: u64, exr: bool) -> Result<(), CliError> {
        let [width, height] = self.size()?;
        let pixel = PixelBytes {
            film,
            exr,
            ..PixelBytes::default()
        };
        memory::beside_picture(memory, (width, height), pixel).map(drop)
    }

    /// The bytes of the whole picture's file.
    ///
    /// # Errors
    /// [`CliError::Failed`]: a broken tile, tiles of different channels, or that differ where they overlap.
    pub fn merge(&self, memory: u64, check: impl Fn() -> Result<(), CliError>) -> Result<Vec<u8>, CliError> {
        let first = self.first()?;
        let size @ [width, height] = self.size()?;
        let count = width as usize * height as usize;
        let mut covered = vec![false; count];
        let mut whole: Option<Samples> = None;
        for tile in &self.0 {
            check()?;
            let samples = tile.read()?;
            if whole.is_none() {
                let exr = matches!(samples, Samples::Exr(_));
                // Beside the samples: which pixels are covered, and the film of an EXR picture.
                let film = samples.pixel_bytes() + if exr { 12 } else { 1 };
                self.check_memory(memory, film, exr)?;
            }
            let whole = whole.get_or_insert_with(|| samples.black(count));
            let (ours, firsts) = (samples.kind(), whole.kind());
            if ours != firsts {
                let [ours, firsts] = [ours, firsts].map(|kind| format!("has the channels {kind}"));
                return Err(tile.differs(&ours, first, &firsts));
            }
            if let Some([x, y]) = whole.paste(&samples, width, tile.place.crop, &covered) {
                let name = tile.name();
                return Err(CliError::Failed(format!(
                    "{name} overlaps a tile before it and differs from it, first at pixel {x},{y}"
                )));
            }
            cover(&mut covered, width, tile.place.crop);
        }
        drop(covered);
        let whole = whole.ok_or_else(no_tiles)?;
        whole.encode(first.format, size)
    }
}

fn no_tiles() -> CliError {
    CliError::Usage("no tiles to merge".into())
}

/// The first rectangle that no tile covers.
fn first_gap(covered: &[bool], width: u32) -> Option<Crop> {
    let first = covered.iter().position(|covered| !covered)?;
    let across = width as usize;
    let (x0, y0) = (first % across, first / across);
    let line = &covered[first..(y0 + 1) * across];
    let x1 = x0 + line.iter().position(|&covered| covered).unwrap_or(line.len());
    let open = |row: &&[bool]| row[x0..x1].iter().all(|covered| !covered);
    let rows = covered[y0 * across..].chunks(across).take_while(open).count();
    Some(Crop {
        x0: x0 as u32,
        y0: y0 as u32,
        x1: x1 as u32,
        y1: (y0 + rows) as u32,
    })
}

#[cfg(test)]
mod tests;

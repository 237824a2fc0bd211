//! The images of a mesh's textures, decoded after the mesh is read, on all threads, each only once.
//!
//! A texture that cannot be shown is a note, not an error: the shape is still shown.

pub(super) mod names;

use super::{
    OpenMesh,
    budget::{Budget, BudgetError},
    left_out::{add_to_note, counted, name_list},
    mesh::{MAX_NAME, Surface},
};
use crate::{
    error::{LoadError, clip, clip_path},
    scene::{CutOut, Image, MAX_TEXTURES, SurfaceTextures, Texture},
};
use std::{
    collections::HashMap,
    ffi::OsStr,
    path::{Component, Path, PathBuf},
    sync::Arc,
};

/// Memory of an image's path beside its letters, bytes: its allocation, and its entries in a map and an array.
const PATH_BYTES: usize = 160;

/// The image files that a mesh names, each once.
#[derive(Default)]
pub(super) struct Images {
    paths: Vec<Arc<Path>>,
    /// As the mesh writes them, if they are absolute paths.
    absolute: Vec<Option<Box<str>>>,
    numbers: HashMap<Arc<Path>, u32>,
}

impl Images {
    pub(super) fn is_empty(&self) -> bool {
        self.paths.is_empty()
    }

    /// The number of the image that the file `by` names; `None` if there are too many, or the name is too long.
    pub(super) fn number(
        &mut self,
        by: &Path,
        name: &str,
        budget: &Budget,
    ) -> Result<Option<u32>, BudgetError> {
        if name.len() > MAX_NAME || name.is_empty() {
            return Ok(None);
        }
        let path = names::joined(by, name);
        let is_named = |part: &Component<'_>| *part != Component::CurDir;
        let path: PathBuf = path.components().filter(is_named).collect();
        if let Some(&number) = self.numbers.get(path.as_path()) {
            return Ok(Some(number));
        }
        if self.paths.len() >= MAX_TEXTURES {
            return Ok(None);
        }
        let absolute = names::last_of_absolute(name).map(|_| name);
        budget.take(path.as_os_str().len() + absolute.map_or(0, str::len) + PATH_BYTES)?;
        let (path, number): (Arc<Path>, u32) = (path.into(), self.paths.len() as u32);
        self.numbers.insert(Arc::clone(&path), number);
        self.paths.push(path);
        self.absolute.push(absolute.map(Into::into));
        Ok(Some(number))
    }

    /// Reads and decodes the images that triangles show: those of `surfaces`, which `surface_of` numbers. `path` is the
    /// mesh's.
    pub(super) fn read(
        &self,
        (surfaces, surface_of): (&mut [Surface], &[u32]),
        path: &Path,
        open: OpenMesh<'_>,
        budget: &Budget,
        notes: &mut Vec<String>,
    ) -> Vec<Image> {
        if !budget.wants_images() {
            return Vec::new();
        }
        let used = used_surfaces(surfaces.len(), surface_of);
        let used = surfaces.iter().zip(used);
        let used = used.filter_map(|(surface, is_used)| is_used.then_some(surface));
        let used = used_images(self.paths.len(), used);
        let mut beside = names::Beside::new(path);
        let mut read: Vec<Option<Result<Vec<u8>, String>>> = Vec::new();
        for ((file, name), is_used) in self.paths.iter().zip(&self.absolute).zip(used) {
            read.push(is_used.then(|| {
                (open)(file).or_else(|error| beside.read((name.as_deref(), file, &error), &mut *open))
            }));
        }
        notes.extend(beside.note());
        let mut encoded = Vec::new();
        for ((file, name), read) in self.paths.iter().zip(&self.absolute).zip(&read) {
            encoded.push(read.as_ref().map(|read| Encoded {
                name: match name {
                    Some(name) => name.to_string(),
                    None => file.to_string_lossy().into_owned(),
                },
                bytes: read.as_deref().map_err(Clone::clone),
            }));
        }
        let Decoded { images, lost_alpha } = decode(&encoded, surfaces, path, budget, notes);
        // No texture of these formats but `map_d` says how opaque a surface is.
        let names = lost_alpha.iter().filter_map(|&i| self.paths.get(i)?.file_name());
        let names = name_list(names.map(OsStr::as_encoded_bytes));
        if !names.is_empty() {
            let noun = if lost_alpha.len() == 1 {
                "texture"
            } else {
                "textures"
            };
            add_to_note(notes, path, &format!("alpha of {noun} {names}"));
        }
        for bytes in read.iter().flatten().flatten() {
            budget.give_back(bytes.capacity());
        }
        images
    }
}

/// An image that surfaces name, and its file's bytes.
pub(super) struct Encoded<'a> {
    /// What notes call it.
    pub(super) name: String,
    /// Its bytes, or why they could not be read.
    pub(super) bytes: Result<&'a [u8], String>,
}

/// Why a file could not be read, without its name.
pub(super) fn reason(error: &LoadError) -> String {
    error
        .chain()
        .last()
        .map_or_else(String::new, |error| error.message.clone())
}

/// Which of `count` images any of these surfaces shows.
pub(super) fn used_images<'a>(count: usize, surfaces: impl Iterator<Item = &'a Surface>) -> Vec<bool> {
    let mut used = vec![false; count];
    for surface in surfaces {
        for texture in surface.textures.all().into_iter().flatten() {
            if let Some(used) = used.get_mut(texture.image as usize) {
                *used = true;
            }
        }
    }
    used
}

/// Which images, the first of equal ones each, say how opaque any of these surfaces are; the alpha of others means nothing.
fn images_with_opacity(first: &[Option<usize>], surfaces: &[Surface]) -> Vec<bool> {
    let mut used = vec![false; first.len()];
    for surface in surfaces {
        let SurfaceTextures { cut_out, opacity, .. } = surface.textures;
        let cut_out = cut_out.map(|cut_out| cut_out.texture);
        for texture in [cut_out, opacity.and_then(|opacity| opacity.map)]
            .into_iter()
            .flatten()
        {
            if let Some(&Some(first)) = first.get(texture.image as usize) {
                used[first] = true;
            }
        }
    }
    used
}

/// A surface without textures, for triangles without texture coordinates and images that are missing.
pub(super) fn untextured(surface: &Surface) -> Surface {
    let mut surface = *surface;
    if surface.textures.base.is_some() {
        // Textures are rarely white.
        for (channel, neutral) in surface.diffuse.iter_mut().zip(Surface::NEUTRAL.diffuse) {
            *channel *= neutral;
        }
    }
    let emission = match surface.textures.emission_map {
        Some(_) => [0.0; 3],
        None => surface.textures.emission,
    };
    let opacity = surface.textures.opacity;
    surface.textures = SurfaceTextures {
        emission,
        opacity: opacity.and_then(|opacity| opacity.with_map(None)),
        ..SurfaceTextures::NONE
    };
    surface
}

/// Gives triangles that lack texture coordinates surfaces without textures. Returns how many there are.
pub(super) fn leave_untextured(
    surfaces: &mut Vec<Surface>,
    surface_of: &mut [u32],
    mut lacks: impl FnMut(usize) -> bool,
) -> usize {
    let (mut copies, mut count) = (HashMap::new(), 0);
    for (i, index) in surface_of.iter_mut().enumerate() {
        let surface = surfaces.get(*index as usize).copied();
        let Some(surface) =
            surface.filter(|surface| surface.textures.all().iter().any(Option::is_some) && lacks(i))
        else {
            continue;
        };
        count += 1;
        *index = *copies.entry(*index).or_insert_with(|| {
            surfaces.push(untextured(&surface));
            surfaces.len() as u32 - 1
        });
    }
    count
}

/// The note about them.
pub(super) fn untextured_note(count: usize, path: &Path) -> Option<String> {
    let triangles = counted(count, "triangle has", "triangles have");
    (count > 0).then(|| {
        format!(
            "{}: {triangles} no texture coordinates: shown without texture",
            clip_path(path)
        )
    })
}

/// Which surfaces any triangle has.
pub(super) fn used_surfaces(count: usize, surface_of: &[u32]) -> Vec<bool> {
    let mut used = vec![false; count];
    for &surface in surface_of {
        if let Some(used) = used.get_mut(surface as usize) {
            *used = true;
        }
    }
    used
}

/// The images of a mesh.
#[derive(Default)]
pub(super) struct Decoded {
    pub(super) images: Vec<Image>,
    /// Which of the encoded images had an alpha below 1 that is not shown.
    pub(super) lost_alpha: Vec<usize>,
}

/// Decodes the images that are used; `path` is the mesh's. Surfaces name the images that it returns then, and those that
/// cannot be decoded become notes.
pub(super) fn decode(
    encoded: &[Option<Encoded<'_>>],
    surfaces: &mut [Surface],
    path: &Path,
    budget: &Budget,
    notes: &mut Vec<String>,
) -> Decoded {
    if !budget.wants_images() {
        return Decoded::default();
    }
    let first = first_of_equal(encoded);
    let keeps_alpha = images_with_opacity(&first, surfaces);
    let decoded = decoding::all(encoded, &first, &keeps_alpha, budget);
    let (mut images, mut lost_alpha) = (Vec::new(), Vec::new());
    let mut numbers: Vec<Option<u32>> = vec![None; encoded.len()];
    for (i, (encoded, decoded)) in encoded.iter().zip(decoded).enumerate() {
        match (encoded, decoded) {
            (Some(_), Some(Ok((image, loses_alpha)))) => {
                lost_alpha.extend(loses_alpha.then_some(i));
                numbers[i] = Some(images.len() as u32);
                images.push(image);
            }
            (Some(encoded), Some(Err(reason))) => {
                let (path, name) = (clip_path(path), clip(&encoded.name));
                notes.push(format!("{path}: texture {name} is not shown: {}", clip(&reason)));
            }
            _ => numbers[i] = first[i].and_then(|first| numbers[first]),
        }
    }
    for surface in surfaces {
        renumber(surface, &numbers, &images);
    }
    Decoded { images, lost_alpha }
}

/// For each image the first one with the same bytes, the same part of the same file.
fn first_of_equal(encoded: &[Option<Encoded<'_>>]) -> Vec<Option<usize>> {
    let mut known = HashMap::new();
    let place = |bytes: &[u8]| (bytes.as_ptr() as usize, bytes.len());
    let all = encoded.iter().enumerate();
    all.map(|(i, encoded)| {
        let bytes = encoded.as_ref()?.bytes.as_ref().ok()?;
        Some(*known.entry(place(bytes)).or_insert(i))
    })
    .collect()
}

/// Gives a surface's textures the numbers of decoded images, and drops those that were not decoded.
fn renumber(surface: &mut Surface, numbers: &[Option<u32>], images: &[Image]) {
    let number = |texture: Texture| {
        let image = numbers.get(texture.image as usize).copied().flatten()?;
        Some(Texture { image, ..texture })
    };
    if surface.textures.base.is_some_and(|base| number(base).is_none()) {
        surface.diffuse = untextured(surface).diffuse;
    }
    let all = &mut surface.textures;
    all.base = all.base.and_then(number);
    if all.emission_map.is_some() && all.emission_map.and_then(number).is_none() {
        all.emission = [0.0; 3];
    }
    all.emission_map = all.emission_map.and_then(number);
    all.opacity = all.opacity.and_then(|opacity| {
        let map = opacity.map.and_then(number);
        let has_alpha = |map: &Texture| images.get(map.image as usize).is_some_and(Image::has_alpha);
        opacity.with_map(map.filter(has_alpha))
    });
    all.cut_out = all.cut_out.and_then(|cut_out| {
        let texture = number(cut_out.texture)?;
        let has_alpha = images.get(texture.image as usize)?.has_alpha();
        // Opacity is in alpha, or in the colour of an image without alpha.
        let channel = if has_alpha { 3 } else { cut_out.channel };
        (channel < 3 || has_alpha).then_some(CutOut {
            texture,
            channel,
            ..cut_out
        })
    });
}

#[cfg(feature = "textures")]
pub(super) mod decoding {
    use super::{Budget, Encoded, Image};
    use crate::{
        error::{decoder_reason, in_bytes},
        scene::MAX_IMAGE_SIDE,
    };
    use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits};
    use rayon::prelude::*;
    use std::{
        io::Cursor,
        panic::{AssertUnwindSafe, catch_unwind},
        path::Path,
    };

    /// Memory of a decoder beside the pixels, bytes.
    pub(in crate::format) const DECODER_BYTES: u64 = 1 << 20;

    /// Memory for all that comes before the pixels, such as colour profiles, bytes.
    pub(in crate::format) const HEADER_BYTES: u64 = 8 << 20;

    /// An image whose header was read.
    struct Known<'a> {
        bytes: &'a [u8],
        format: ImageFormat,
        keeps_alpha: bool,
        /// What the image takes, bytes.
        kept: usize,
        /// What decoding it takes until the image is made, bytes.
        needed: u64,
    }

    /// Decodes each image that is the first of equal ones; alpha stays where `keeps_alpha`. With each image comes whether it
    /// loses an alpha below 1.
    pub(super) fn all(
        encoded: &[Option<Encoded<'_>>],
        first: &[Option<usize>],
        keeps_alpha: &[bool],
        budget: &Budget,
    ) -> Vec<Option<Result<(Image, bool), String>>> {
        // In order, so that it does not depend on threads which images fit.
        let known: Vec<Option<Result<Known<'_>, String>>> = encoded
            .iter()
            .enumerate()
            .map(|(i, encoded)| {
                let encoded = encoded.as_ref()?;
                if first[i].is_some_and(|first| first != i) {
                    return None;
                }
                let bytes = encoded.bytes.clone();
                Some(bytes.and_then(|bytes| known(bytes, &encoded.name, keeps_alpha[i], budget)))
            })
            .collect();
        let largest = known
            .iter()
            .flatten()
            .flatten()
            .map(|known| known.needed)
            .max()
            .unwrap_or(0);
        let decode = |known: Option<Result<Known<'_>, String>>| {
            Some(known?.and_then(|known| {
                let decoded = catch_unwind(AssertUnwindSafe(|| decode(&known)));
                let decoded = decoded.unwrap_or_else(|_| Err("its decoder failed".to_owned()));
                decoded.inspect_err(|_| budget.give_back(known.kept))
            }))
        };
        let at_once = rayon::current_num_threads() as u64;
        if largest.saturating_mul(at_once) <= budget.left() {
            known.into_par_iter().with_max_len(1).map(decode).collect()
        } else {
            known.into_iter().map(decode).collect()
        }
    }

    /// Reads the header and takes the image from the budget.
    fn known<'a>(
        bytes: &'a [u8],
        name: &str,
        keeps_alpha: bool,
        budget: &Budget,
    ) -> Result<Known<'a>, String> {
        use ImageFormat::{Bmp, Gif, Jpeg, Png, Tga, Tiff, WebP};
        let by_name = || ImageFormat::from_path(Path::new(name)).ok();
        let format = image::guess_format(bytes).ok().or_else(by_name);
        let format = format.filter(|format| matches!(format, Png | Jpeg | WebP | Bmp | Tga | Gif | Tiff));
        let expected = "unknown kind of picture, expected PNG, JPEG, WebP, BMP, TGA, GIF or TIFF";
        let format = format.ok_or(expected)?;
        let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
        reader.limits(limits(HEADER_BYTES));
        let decoder = reader.into_decoder();
        let decoder = decoder.map_err(|error| sentence(&error))?;
        let (width, height) = decoder.dimensions();
        if width.max(height) > MAX_IMAGE_SIDE || width.min(height) == 0 {
            return Err(format!(
                "it has {width}x{height} pixels, expected at most {MAX_IMAGE_SIDE}x{MAX_IMAGE_SIDE}"
            ));
        }
        let pixels = u64::from(width) * u64::from(height);
        // Decoded, as RGBA, and what a decoder keeps beside: coefficients or planes.
        let needed = decoder.total_bytes().saturating_mul(2) + 4 * pixels + DECODER_BYTES;
        let kept = Image::bytes([width, height]);
        if needed + kept as u64 > budget.left() {
            return Err(format!(
                "it takes {}, above what is left of the memory limit",
                in_bytes(needed + kept as u64)
            ));
        }
        budget.take(kept).map_err(|error| error.to_string())?;
        Ok(Known {
            bytes,
            format,
            keeps_alpha,
            kept,
            needed,
        })
    }

    fn decode(known: &Known<'_>) -> Result<(Image, bool), String> {
        let mut reader = ImageReader::with_format(Cursor::new(known.bytes), known.format);
        reader.limits(limits(known.needed));
        let decoded: DynamicImage = reader.decode().map_err(|error| sentence(&error))?;
        let mut image = decoded.into_rgba8();
        let mut least_alpha = u8::MAX;
        if !known.keeps_alpha {
            for pixel in image.pixels_mut() {
                least_alpha = least_alpha.min(pixel.0[3]);
                pixel.0[3] = u8::MAX;
            }
        }
        let (width, height) = image.dimensions();
        let pixels = bytemuck::allocation::try_cast_vec(image.into_raw());
        let pixels = pixels.map_err(|_| "it does not fit into memory".to_owned())?;
        let image = Image::new([width, height], pixels).map_err(|error| error.to_string())?;
        Ok((image, least_alpha < u8::MAX))
    }

    pub(in crate::format) fn limits(bytes: u64) -> Limits {
        let mut limits = Limits::default();
        limits.max_alloc = Some(bytes);
        limits
    }

    pub(in crate::format) fn sentence(error: &ImageError) -> String {
        decoder_reason(&error.to_string())
    }
}

#[cfg(not(feature = "textures"))]
mod decoding {
    use super::{Budget, Encoded, Image};

    pub(super) fn all(
        encoded: &[Option<Encoded<'_>>],
        _: &[Option<usize>],
        _: &[bool],
        _: &Budget,
    ) -> Vec<Option<Result<(Image, bool), String>>> {
        let missing = || Err("octray was built without its feature `textures`".to_owned());
        encoded
            .iter()
            .map(|encoded| encoded.as_ref().map(|_| missing()))
            .collect()
    }
}

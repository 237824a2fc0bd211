//! The images of a mesh's textures, decoded after the mesh is read, on all threads, once for each role: colours, normals, or
//! highlights of a roughness and its metal.
//!
//! A texture that cannot be shown is a note, not an error: the shape is still shown.

#[cfg(feature = "textures")]
pub(super) mod decoding;
#[cfg(feature = "textures")]
mod heights;
mod highlight;
pub(super) mod names;

pub(super) use highlight::Highlight;
#[cfg(feature = "gltf")]
pub(super) use highlight::STRONGEST;

use super::{
    OpenMesh,
    budget::{Budget, BudgetError},
    left_out::{add_to_note, counted, name_list},
    mesh::{MAX_NAME, Surface},
};
use crate::{
    error::{LoadError, clip, clip_path},
    scene::{CutOut, Image, MAX_TEXTURES, NormalMap, OcclusionMap, SurfaceTextures, Texture},
};
use std::{
    collections::{BTreeMap, HashMap, HashSet},
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
    /// See [`Encoded::is_normal_map`].
    normal_maps: Vec<bool>,
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
        self.normal_maps.push(false);
        Ok(Some(number))
    }

    /// Records that an image is a normal map where it is shown as one, whatever it looks like.
    pub(super) fn set_normal_map(&mut self, number: u32) {
        if let Some(is_normal_map) = self.normal_maps.get_mut(number as usize) {
            *is_normal_map = true;
        }
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
        let named = self.paths.iter().zip(&self.absolute).zip(&self.normal_maps);
        for (((file, name), &is_normal_map), read) in named.zip(&read) {
            encoded.push(read.as_ref().map(|read| Encoded {
                is_normal_map,
                name: match name {
                    Some(name) => name.to_string(),
                    None => file.to_string_lossy().into_owned(),
                },
                bytes: read.as_deref().map_err(Clone::clone),
            }));
        }
        let Decoded {
            images, lost_alpha, ..
        } = decode(&encoded, (surfaces, &[]), path, budget, notes);
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
    /// Whether it is a normal map where it is shown as one; else its pixels tell.
    pub(super) is_normal_map: bool,
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

/// The factor of highlights whose map is not shown.
const NEUTRAL_SPECULAR: f32 = 0.5;

/// A surface without textures, for triangles without texture coordinates and images that are missing.
pub(super) fn untextured(surface: &Surface) -> Surface {
    let mut surface = *surface;
    if surface.textures.base.is_some() {
        // Textures are rarely white.
        for (channel, neutral) in surface.diffuse.iter_mut().zip(Surface::NEUTRAL.diffuse) {
            *channel *= neutral;
        }
    }
    if surface.textures.specular_map.is_some() {
        surface.specular = surface.specular.map(|channel| channel * NEUTRAL_SPECULAR);
    }
    let emission = match surface.textures.emission_map {
        Some(_) => [0.0; 3],
        None => surface.textures.emission,
    };
    let opacity = surface.textures.opacity;
    surface.textures = SurfaceTextures {
        emission,
        opacity: opacity.and_then(|opacity| opacity.with_map(None)),
        one_sided: surface.textures.one_sided,
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
    /// The mean smoothness of images made of roughness, in 255ths.
    #[cfg_attr(not(feature = "gltf"), allow(dead_code, reason = "only glTF has such images"))]
    pub(super) smoothness: Vec<Option<u8>>,
}

/// A decoded image.
pub(super) struct Made {
    image: Image,
    loses_alpha: bool,
    /// See [`Decoded::smoothness`].
    smoothness: Option<u8>,
}

/// Decodes the used images; `path` is the mesh's. The specular map of a surface with a value in `highlights`, by its index, is
/// an image of roughness and metal. On return, textures index the returned images, and those that cannot be decoded
/// are notes.
pub(super) fn decode(
    encoded: &[Option<Encoded<'_>>],
    (surfaces, highlights): (&mut [Surface], &[Option<Highlight>]),
    path: &Path,
    budget: &Budget,
    notes: &mut Vec<String>,
) -> Decoded {
    if !budget.wants_images() {
        return Decoded::default();
    }
    let uses = name_uses(surfaces, highlights);
    let by_number = |image: u32| encoded.get(image as usize)?.as_ref();
    let encoded: Vec<Option<&Encoded<'_>>> = uses.iter().map(|&(image, _)| by_number(image)).collect();
    let first = first_of_equal(&encoded, &uses);
    let keeps_alpha = images_with_opacity(&first, surfaces);
    let content = |(&(image, role), keeps_alpha): (&Use, bool)| match role {
        Role::Color if keeps_alpha => Content::ColorsAndAlpha,
        Role::Color => Content::Colors,
        Role::Normal => Content::Normals {
            is_sure: by_number(image).is_some_and(|encoded| encoded.is_normal_map),
        },
        Role::Occlusion => Content::Numbers,
        Role::Highlight(highlight) => Content::Highlight(highlight, highlight.base().and_then(by_number)),
    };
    let contents: Vec<Content<'_>> = uses.iter().zip(keeps_alpha).map(content).collect();
    let decoded = decoding::all(&encoded, &first, &contents, budget);
    let (mut images, mut lost_alpha, mut smoothness) = (Vec::new(), Vec::new(), Vec::new());
    let mut numbers: Vec<Option<u32>> = vec![None; encoded.len()];
    for (i, (encoded, decoded)) in encoded.iter().zip(decoded).enumerate() {
        match (encoded, decoded) {
            (Some(_), Some(Ok(made))) => {
                lost_alpha.extend(made.loses_alpha.then_some(uses[i].0 as usize));
                numbers[i] = Some(images.len() as u32);
                images.push(made.image);
                smoothness.push(made.smoothness);
            }
            (Some(encoded), Some(Err(reason))) => {
                let (path, name) = (clip_path(path), clip(&encoded.name));
                let note = format!("{path}: texture {name} is not shown: {}", clip(&reason));
                // An image with several roles is read for each.
                if notes.last() != Some(&note) {
                    notes.push(note);
                }
            }
            _ => numbers[i] = first[i].and_then(|first| numbers[first]),
        }
    }
    for surface in surfaces {
        renumber(surface, &numbers, &images);
    }
    Decoded {
        images,
        lost_alpha,
        smoothness,
    }
}

/// What a surface takes an image for.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
enum Role {
    Color,
    Normal,
    Occlusion,
    Highlight(Highlight),
}

/// An image with more kinds of highlights has their roughness rounded to as many steps, and no metal, since each is decoded
/// for itself.
const MOST_HIGHLIGHTS: usize = 16;

/// The number of an image, and its role.
type Use = (u32, Role);

/// Lists each image and role that surfaces use, ascending, and replaces the textures' image numbers by indices into this list:
/// an image with two roles is decoded twice.
fn name_uses(surfaces: &mut [Surface], highlights: &[Option<Highlight>]) -> Vec<Use> {
    let mut kinds: HashMap<u32, HashSet<Highlight>> = HashMap::new();
    for (surface, highlight) in surfaces.iter().zip(highlights) {
        if let (Some(map), Some(highlight)) = (surface.textures.specular_map, highlight) {
            kinds.entry(map.image).or_default().insert(*highlight);
        }
    }
    let role = |surface: usize, place: usize, image: u32| match (place, highlights.get(surface)) {
        (SurfaceTextures::NORMAL, _) => Role::Normal,
        (SurfaceTextures::OCCLUSION, _) => Role::Occlusion,
        (SurfaceTextures::SPECULAR, Some(Some(highlight))) => {
            let are_many = kinds[&image].len() > MOST_HIGHLIGHTS;
            Role::Highlight(if are_many {
                highlight.rounded(MOST_HIGHLIGHTS as f32)
            } else {
                *highlight
            })
        }
        _ => Role::Color,
    };
    let mut uses = BTreeMap::new();
    for (i, surface) in surfaces.iter().enumerate() {
        for (place, texture) in surface.textures.all().into_iter().enumerate() {
            if let Some(texture) = texture {
                uses.insert((texture.image, role(i, place, texture.image)), 0);
            }
        }
    }
    for (number, of_use) in uses.values_mut().enumerate() {
        *of_use = number as u32;
    }
    for (i, surface) in surfaces.iter_mut().enumerate() {
        for (place, texture) in surface.textures.all_mut().into_iter().enumerate() {
            if let Some(texture) = texture {
                texture.image = uses[&(texture.image, role(i, place, texture.image))];
            }
        }
    }
    uses.into_keys().collect()
}

/// What an image's pixels become.
#[derive(Clone, Copy)]
#[cfg_attr(not(feature = "textures"), allow(dead_code, reason = "nothing is decoded"))]
enum Content<'a> {
    Colors,
    ColorsAndAlpha,
    Normals {
        /// Whether it may look like anything.
        is_sure: bool,
    },
    Numbers,
    /// With the image of the base colour.
    Highlight(Highlight, Option<&'a Encoded<'a>>),
}

/// For each use the first one with the same bytes, the same part of the same file, and the same role.
fn first_of_equal(encoded: &[Option<&Encoded<'_>>], uses: &[Use]) -> Vec<Option<usize>> {
    let mut known = HashMap::new();
    let place = |bytes: &[u8]| (bytes.as_ptr() as usize, bytes.len());
    let all = encoded.iter().zip(uses).enumerate();
    all.map(|(i, (encoded, (_, role)))| {
        let bytes = encoded.as_ref()?.bytes.as_ref().ok()?;
        Some(*known.entry((place(bytes), *role)).or_insert(i))
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
    if surface
        .textures
        .specular_map
        .is_some_and(|map| number(map).is_none())
    {
        surface.specular = untextured(surface).specular;
    }
    let all = &mut surface.textures;
    all.specular_map = all.specular_map.and_then(number);
    all.base = all.base.and_then(number);
    if all.emission_map.is_some() && all.emission_map.and_then(number).is_none() {
        all.emission = [0.0; 3];
    }
    all.emission_map = all.emission_map.and_then(number);
    all.normal_map = all.normal_map.and_then(|map| {
        let texture = number(map.texture)?;
        Some(NormalMap { texture, ..map })
    });
    all.occlusion_map = all.occlusion_map.and_then(|map| {
        let texture = number(map.texture)?;
        Some(OcclusionMap { texture, ..map })
    });
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

#[cfg(not(feature = "textures"))]
mod decoding {
    use super::{Budget, Content, Encoded, Made};

    pub(super) fn all(
        encoded: &[Option<&Encoded<'_>>],
        _: &[Option<usize>],
        _: &[Content<'_>],
        _: &Budget,
    ) -> Vec<Option<Result<Made, String>>> {
        let missing = || Err("octray was built without its feature `textures`".to_owned());
        encoded
            .iter()
            .map(|encoded| encoded.as_ref().map(|_| missing()))
            .collect()
    }
}

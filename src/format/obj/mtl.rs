//! Material libraries: `newmtl`, `Kd`, `Ks`, `Ke`, `Ns`, `illum`, `d`, `Tr`, and the textures `map_Kd`, `map_Ks`, `map_Ke`,
//! `map_d`, `norm`, `bump` and `map_Bump`, in upper or lower case. Faults and whatever else a library contains become notes;
//! the mesh is shown all the same.

use super::super::{
    budget::{Budget, BudgetError},
    left_out::{LeftOut, MOST_NAMES, counted, name_list},
    mesh::{Surface, add_texture_file},
    place::{TextFault, Words, after_mark},
    reason::Reason,
    textures::Images,
};
use super::{
    texture_files::{TextureFile, texture_file},
    textures::Shift,
};
use crate::{
    error::quote,
    scene::{CutOut, MAX_MATERIALS, NormalMap, Opacity, SurfaceTextures, Texture},
};
use std::path::{Path, PathBuf};

/// Memory of a material's name beside its letters, bytes: its allocation, and its entry in a map.
pub(super) const NAME_BYTES: usize = 80;

/// Materials that are less opaque would be invisible.
const LEAST_OPACITY: f32 = 1.0 / 512.0;

/// Parts of `map_d` below this are cut out.
const CUT_OUT_LIMIT: f32 = 0.5;

/// The surfaces by name, at most `most`, and how they place their textures. If a name comes twice, the last one counts.
///
/// # Errors
/// There are too many materials, or they do not fit into the budget.
pub(super) fn parse(
    text: &[u8],
    path: &Path,
    notes: &mut Vec<String>,
    (texture_files, images): (&mut Vec<PathBuf>, &mut Images),
    budget: &Budget,
    most: usize,
) -> Result<Vec<(Vec<u8>, Surface, Shift)>, Reason> {
    let mut materials: Vec<Reading<'_>> = Vec::new();
    let mut left_out = NotRead::default();
    let (mut start, mut has_faults, mut has_bright) = (after_mark(text), false, false);
    for line in text[start..].split_inclusive(|&byte| byte == b'\n') {
        let mut words = Words::new(text, start..start + line.len());
        start += line.len();
        let Some((written, place)) = words.next() else {
            continue;
        };
        // Some programs write `map_kd` or `MAP_KD`.
        let keyword = written.to_ascii_lowercase();
        if keyword == b"newmtl" {
            if materials.len() == most {
                return Err(Reason::limit(format!("more than {MAX_MATERIALS} materials")));
            }
            start_material(&mut materials, words.text(words.rest()), budget)?;
            continue;
        }
        let Some(material) = materials.last_mut() else {
            continue;
        };
        let is_bright = matches!(keyword.as_slice(), b"kd" | b"ks" | b"ke") && is_above_1(words.clone());
        let read = match keyword.as_slice() {
            b"kd" => color(words).map(|color| material.diffuse = Some(color)),
            b"ks" => color(words).map(|color| material.specular = Some(color)),
            b"ns" => number(&mut words).map(|exponent| material.exponent = exponent),
            b"illum" => number(&mut words).map(|model| {
                material.has_highlight = model >= 2.0;
                material.is_traced = (3.0..=9.0).contains(&model);
            }),
            b"ke" => color(words).map(|color| material.emission = color),
            b"d" => opacity(words).map(|opacity| material.opaque = Some(opacity)),
            b"tr" => number(&mut words).map(|share| material.transparent = share),
            b"disp" | b"decal" | b"refl" => {
                left_out.add_texture(written);
                add_texture_file(texture_files, path, &texture_file(words).name());
                Some(())
            }
            name if name.starts_with(b"map_") || matches!(name, b"bump" | b"norm") => {
                let file = texture_file(words);
                add_texture_file(texture_files, path, &file.name());
                let read = material.read_map(&keyword, &file, (path, &mut *images), budget)?;
                left_out.turbulent += usize::from(read && file.options.is_turbulent);
                if !read && keyword != b"map_ka" {
                    left_out.add_texture(written);
                }
                Some(())
            }
            _ => {
                left_out.add_statement(written, words);
                Some(())
            }
        };
        let fault = match read {
            None => Some((&mut has_faults, "without valid numbers, ignored")),
            Some(()) if is_bright => Some((&mut has_bright, "above 1, taken as 1")),
            Some(()) => None,
        };
        // One note is enough to find the others.
        if let Some((is_noted, what)) = fault
            && !std::mem::replace(is_noted, true)
        {
            let message = format!("{} {what}", quote(written));
            notes.push(TextFault::new(place, message).into_error(text, path).to_string());
        }
    }
    notes.extend(left_out.list(&materials).note(path));
    let surfaces = materials.into_iter().map(Reading::finish);
    Ok(surfaces.collect())
}

fn start_material(materials: &mut Vec<Reading<'_>>, name: &[u8], budget: &Budget) -> Result<(), BudgetError> {
    budget.take(name.len() + NAME_BYTES)?;
    budget.reserve(materials, 1)?;
    materials.push(Reading::new(name.to_vec()));
    Ok(())
}

/// What the library contains but octray does not read.
#[derive(Default)]
struct NotRead<'a> {
    /// Keywords of textures, likewise as those of other statements.
    textures: Vec<&'a [u8]>,
    /// Textures with turbulence.
    turbulent: usize,
    /// Keywords of other statements, each once, and not more than are listed.
    statements: Vec<&'a [u8]>,
}

impl<'a> NotRead<'a> {
    fn add_texture(&mut self, keyword: &'a [u8]) {
        if self.textures.len() <= MOST_NAMES && !self.textures.contains(&keyword) {
            self.textures.push(keyword);
        }
    }

    /// A statement of no known kind. Programs write many with values that change nothing.
    fn add_statement(&mut self, keyword: &'a [u8], mut words: Words<'_>) {
        let neutral = match keyword.to_ascii_lowercase().as_slice() {
            // Ambient light takes the diffuse colour. The others matter to refraction only, which `illum` asks for.
            [b'#', ..] | b"ka" | b"ni" | b"sharpness" => return,
            // A filter of white changes nothing.
            b"tf" => 1.0,
            _ => 0.0,
        };
        let is_neutral =
            words.all(|(word, _)| std::str::from_utf8(word).is_ok_and(|word| word.parse() == Ok(neutral)));
        if !is_neutral && self.statements.len() <= MOST_NAMES && !self.statements.contains(&keyword) {
            self.statements.push(keyword);
        }
    }

    fn list(&mut self, materials: &[Reading<'_>]) -> LeftOut {
        // Ambient light takes the diffuse colour, and so its texture.
        let has_ambient = |material: &Reading<'_>| {
            material.ambient_file.is_some() && material.ambient_file != material.base_file
        };
        if materials.iter().any(has_ambient) {
            self.add_texture(b"map_Ka");
        }
        let mut left_out = LeftOut::default();
        if !self.textures.is_empty() {
            let what = if self.textures.len() == 1 {
                "texture"
            } else {
                "textures"
            };
            left_out.add(&format!("{what} {}", name_list(self.textures.iter().copied())));
        }
        left_out.count(
            self.turbulent,
            "turbulence of a texture",
            "turbulences of textures",
        );
        left_out.count(
            materials.iter().map(Reading::other_shifts).sum(),
            "offset or scale of a texture",
            "offsets or scales of textures",
        );
        let count = |is: fn(&&Reading<'_>) -> bool| materials.iter().filter(is).count();
        for (what, count) in [
            (
                "full transparency",
                count(|material| material.opacity().is_none()),
            ),
            ("reflection or refraction", count(|material| material.is_traced)),
        ] {
            if count > 0 {
                left_out.add(&format!("{what} of {}", counted(count, "material", "materials")));
            }
        }
        if !self.statements.is_empty() {
            left_out.add(&format!(
                "statements {}",
                name_list(self.statements.iter().copied())
            ));
        }
        left_out
    }
}

/// A material that is being read.
struct Reading<'a> {
    name: Vec<u8>,
    diffuse: Option<[f32; 3]>,
    specular: Option<[f32; 3]>,
    exponent: f32,
    has_highlight: bool,
    base: Option<Texture>,
    mask: Option<Texture>,
    /// How `map_Kd`, `map_d`, `map_Ke`, `map_Ks` and the normal map are placed.
    shifts: [Option<Shift>; 5],
    /// The files of `map_Kd` and `map_Ka`, as written.
    base_file: Option<&'a [u8]>,
    ambient_file: Option<&'a [u8]>,
    /// `d`, and its complement `Tr`.
    opaque: Option<f32>,
    transparent: f32,
    emission: [f32; 3],
    emission_map: Option<Texture>,
    specular_map: Option<Texture>,
    normals: Option<Texture>,
    has_norm: bool,
    normal_scale: f32,
    /// By its illumination model.
    is_traced: bool,
}

impl<'a> Reading<'a> {
    fn new(name: Vec<u8>) -> Self {
        Self {
            name,
            diffuse: None,
            specular: None,
            exponent: 0.0,
            has_highlight: true,
            base: None,
            mask: None,
            shifts: [None; 5],
            base_file: None,
            ambient_file: None,
            opaque: None,
            transparent: 0.0,
            emission: [0.0; 3],
            emission_map: None,
            specular_map: None,
            normals: None,
            has_norm: false,
            normal_scale: 1.0,
            is_traced: false,
        }
    }

    /// Reads a statement `map_...`, `norm` or `bump`, whose keyword is in lower case. Returns whether its texture is shown.
    ///
    /// # Errors
    /// The images do not fit into the budget.
    fn read_map(
        &mut self,
        keyword: &[u8],
        file: &TextureFile<'a>,
        (path, images): (&Path, &mut Images),
        budget: &Budget,
    ) -> Result<bool, BudgetError> {
        let [of_base, of_mask, of_emission, of_specular, of_normals] = &mut self.shifts;
        let (map, shift) = match keyword {
            b"map_kd" => {
                self.base_file = Some(file.written);
                (&mut self.base, of_base)
            }
            b"map_d" => (&mut self.mask, of_mask),
            b"map_ke" => (&mut self.emission_map, of_emission),
            b"map_ks" => (&mut self.specular_map, of_specular),
            // Programs write the name of a normal map after any of these, so a height map is known by its pixels; `norm` is
            // never one.
            b"bump" | b"map_bump" if self.has_norm => return Ok(false),
            b"norm" | b"bump" | b"map_bump" => {
                self.has_norm = keyword == b"norm";
                self.normal_scale = file.options.strength;
                (&mut self.normals, of_normals)
            }
            b"map_ka" => {
                self.ambient_file = Some(file.written);
                return Ok(false);
            }
            _ => return Ok(false),
        };
        let image = images.number(path, &file.name(), budget)?;
        if let (Some(image), b"norm") = (image, keyword) {
            images.set_normal_map(image);
        }
        *map = image.map(|image| Texture {
            image,
            wrap: [file.options.wrap; 2],
            nearest: false,
        });
        *shift = map.is_some().then_some(file.options.shift);
        Ok(map.is_some())
    }

    /// The offset and scale of its textures: those of the first one, for all.
    fn shift(&self) -> Shift {
        self.shifts.into_iter().flatten().next().unwrap_or(Shift::NONE)
    }

    /// How many of its textures have another offset or scale than [`Self::shift`], which all of them get.
    fn other_shifts(&self) -> usize {
        let all = self.shifts.iter().flatten();
        all.filter(|shift| **shift != self.shift()).count()
    }

    /// How opaque it is; `None` if it would be invisible. That is mostly a mistake: some programs write `Tr 1` or `d 0` for
    /// opaque materials.
    fn opacity(&self) -> Option<f32> {
        let opacity = self.opaque.unwrap_or(1.0 - self.transparent).clamp(0.0, 1.0);
        (opacity >= LEAST_OPACITY).then_some(opacity)
    }

    fn finish(self) -> (Vec<u8>, Surface, Shift) {
        let shift = self.shift();
        // The factor of a texture; black is a placeholder for white.
        let is_placeholder = |map: Option<Texture>, color: [f32; 3]| map.is_some() && color == [0.0; 3];
        let diffuse = match self.diffuse {
            Some(color) if !is_placeholder(self.base, color) => color,
            _ if self.base.is_some() => [1.0; 3],
            _ => Surface::NEUTRAL.diffuse,
        };
        let emission = if is_placeholder(self.emission_map, self.emission) {
            [1.0; 3]
        } else {
            self.emission
        };
        let specular = self.specular.unwrap_or_default();
        let specular = if is_placeholder(self.specular_map, specular) {
            [1.0; 3]
        } else {
            specular
        };
        // The highlight of a low exponent covers the whole surface, and would hide its colour.
        let highlight = if self.has_highlight {
            ((self.exponent - 1.0) / 9.0).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let surface = Surface {
            diffuse,
            specular: specular.map(|channel| channel * highlight),
            alpha: (self.exponent as u32).clamp(1, 10_000),
            is_unlit: false,
            glass: None,
            textures: SurfaceTextures {
                base: self.base,
                checker: None,
                // In an image without alpha, its red is the opacity.
                cut_out: self.mask.map(|texture| CutOut {
                    texture,
                    channel: 0,
                    limit: CUT_OUT_LIMIT,
                }),
                opacity: Opacity::new(self.opacity().unwrap_or(1.0), None),
                emission,
                specular_map: self.specular_map,
                emission_map: self.emission_map,
                normal_map: self.normals.map(|texture| NormalMap {
                    texture,
                    scale: self.normal_scale,
                }),
                occlusion_map: None,
                one_sided: false,
            },
        };
        (self.name, surface, shift)
    }
}

/// A colour, clamped to 0 to 1.
fn color(words: Words<'_>) -> Option<[f32; 3]> {
    channels(words).map(|color| color.map(|channel| channel.clamp(0.0, 1.0)))
}

fn is_above_1(words: Words<'_>) -> bool {
    channels(words).is_some_and(|color| color.iter().any(|&channel| channel > 1.0))
}

/// One number for all channels, or three.
fn channels(mut words: Words<'_>) -> Option<[f32; 3]> {
    let red = number(&mut words)?;
    Some(match number(&mut words) {
        None => [red; 3],
        Some(green) => [red, green, number(&mut words)?],
    })
}

/// The number after `d` and its option `-halo`.
fn opacity(mut words: Words<'_>) -> Option<f32> {
    let mut halo = words.clone();
    match halo.next() {
        Some((b"-halo", _)) => number(&mut halo),
        _ => number(&mut words),
    }
}

pub(super) fn number(words: &mut Words<'_>) -> Option<f32> {
    let (word, _) = words.next()?;
    let number: f32 = fast_float2::parse(word).ok()?;
    number.is_finite().then_some(number)
}

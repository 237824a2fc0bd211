//! Material libraries: `newmtl`, `Kd`, `Ks`, `Ns`, `illum`. Faults and whatever else a library holds become notes; the
//! mesh is shown all the same.

use super::super::{
    budget::Budget,
    left_out::{LeftOut, counted},
    mesh::{Surface, add_texture},
    place::{TextFault, Words, after_mark},
};
use crate::{error::quote, scene::MAX_MATERIALS};
use std::path::{Path, PathBuf};

/// Memory of a material's name beside its letters, bytes: its allocation, and its entry in a map.
const NAME_BYTES: usize = 80;

/// The surfaces by name, at most `most`. If a name comes twice, the last one counts.
///
/// # Errors
/// There are too many materials, or they do not fit into the budget.
pub(super) fn parse(
    text: &[u8],
    path: &Path,
    notes: &mut Vec<String>,
    texture_files: &mut Vec<PathBuf>,
    budget: &Budget,
    most: usize,
) -> Result<Vec<(Vec<u8>, Surface)>, String> {
    let mut materials: Vec<Reading> = Vec::new();
    let (mut start, mut textures, mut has_faults) = (after_mark(text), 0, false);
    for line in text[start..].split_inclusive(|&byte| byte == b'\n') {
        let mut words = Words::new(text, start..start + line.len());
        start += line.len();
        let Some((keyword, place)) = words.next() else {
            continue;
        };
        if keyword == b"newmtl" {
            if materials.len() == most {
                return Err(format!("more than {MAX_MATERIALS} materials"));
            }
            let name = words.text(words.rest());
            let room = budget.take(name.len() + NAME_BYTES);
            room.and_then(|()| budget.reserve(&mut materials, 1))
                .map_err(|error| error.to_string())?;
            materials.push(Reading::new(name.to_vec()));
            continue;
        }
        let Some(material) = materials.last_mut() else {
            continue;
        };
        let read = match keyword {
            b"Kd" => color(words).map(|color| material.diffuse = Some(color)),
            b"Ks" => color(words).map(|color| material.specular = Some(color)),
            b"Ns" => number(&mut words).map(|exponent| material.exponent = exponent),
            b"illum" => number(&mut words).map(|model| {
                material.has_highlight = model >= 2.0;
                material.is_traced = (3.0..=9.0).contains(&model);
            }),
            b"Ke" => color(words).map(|color| material.is_emissive = color != [0.0; 3]),
            b"d" => opacity(words).map(|opacity| material.is_transparent |= opacity < 1.0),
            b"Tr" => number(&mut words).map(|share| material.is_transparent |= share > 0.0),
            b"disp" | b"decal" | b"bump" | b"refl" | b"norm" => {
                textures += 1;
                add_texture(texture_files, path, &texture_file(words));
                Some(())
            }
            _ if keyword.starts_with(b"map_") => {
                textures += 1;
                add_texture(texture_files, path, &texture_file(words));
                material.has_texture |= keyword == b"map_Kd";
                material.is_transparent |= keyword == b"map_d";
                material.is_emissive |= keyword == b"map_Ke";
                Some(())
            }
            _ => Some(()),
        };
        // One is enough to look there.
        if read.is_none() && !std::mem::replace(&mut has_faults, true) {
            let message = format!("{} without valid numbers, ignored", quote(keyword));
            notes.push(TextFault::new(place, message).into_error(text, path).to_string());
        }
    }
    notes.extend(left_out(&materials, textures).note(path));
    let surfaces = materials.into_iter().map(Reading::finish);
    Ok(surfaces.collect())
}

/// What the library holds and is not read.
fn left_out(materials: &[Reading], textures: usize) -> LeftOut {
    let mut left_out = LeftOut::default();
    left_out.count(textures, "texture", "textures");
    let count = |is: fn(&&Reading) -> bool| materials.iter().filter(is).count();
    for (what, count) in [
        ("transparency", count(|material| material.is_transparent)),
        ("emission", count(|material| material.is_emissive)),
        ("reflection or refraction", count(|material| material.is_traced)),
    ] {
        if count > 0 {
            left_out.add(&format!("{what} of {}", counted(count, "material", "materials")));
        }
    }
    left_out
}

/// A material that is being read.
struct Reading {
    name: Vec<u8>,
    diffuse: Option<[f32; 3]>,
    specular: Option<[f32; 3]>,
    exponent: f32,
    has_highlight: bool,
    has_texture: bool,
    is_transparent: bool,
    is_emissive: bool,
    /// By its illumination model.
    is_traced: bool,
}

impl Reading {
    fn new(name: Vec<u8>) -> Self {
        Self {
            name,
            diffuse: None,
            specular: None,
            exponent: 0.0,
            has_highlight: true,
            has_texture: false,
            is_transparent: false,
            is_emissive: false,
            is_traced: false,
        }
    }

    fn finish(self) -> (Vec<u8>, Surface) {
        let neutral = Surface::NEUTRAL;
        let diffuse = match self.diffuse {
            // Black under a texture is a placeholder.
            Some(color) if !(self.has_texture && color == [0.0; 3]) => color,
            _ => neutral.diffuse,
        };
        // An exponent near 0 would light up the whole surface.
        let shiny = self.has_highlight && self.exponent >= 1.0;
        let surface = Surface {
            diffuse,
            specular: self.specular.filter(|_| shiny).unwrap_or_default(),
            alpha: (self.exponent as u32).clamp(1, 10_000),
        };
        (self.name, surface)
    }
}

/// The file that a texture statement names behind its options.
fn texture_file(mut words: Words<'_>) -> String {
    let mut name = words.rest();
    while let Some((option @ [b'-', ..], _)) = words.next() {
        match option {
            b"-mm" => _ = words.nth(1),
            b"-o" | b"-s" | b"-t" => {
                let mut numbers = words.clone();
                while number(&mut numbers).is_some() {
                    words = numbers.clone();
                }
            }
            _ => _ = words.next(),
        }
        name.start = words.position();
    }
    let name = words.text(name).trim_ascii_start();
    let unquoted = name.strip_prefix(b"\"").and_then(|name| name.strip_suffix(b"\""));
    // As Windows writes it.
    String::from_utf8_lossy(unquoted.unwrap_or(name)).replace('\\', "/")
}

/// One number for all channels, or three; clamped to 0 to 1.
fn color(mut words: Words<'_>) -> Option<[f32; 3]> {
    let red = number(&mut words)?;
    let color = match number(&mut words) {
        None => [red; 3],
        Some(green) => [red, green, number(&mut words)?],
    };
    Some(color.map(|channel| channel.clamp(0.0, 1.0)))
}

/// The number after `d` and its option `-halo`.
fn opacity(mut words: Words<'_>) -> Option<f32> {
    let mut halo = words.clone();
    match halo.next() {
        Some((b"-halo", _)) => number(&mut halo),
        _ => number(&mut words),
    }
}

fn number(words: &mut Words<'_>) -> Option<f32> {
    let (word, _) = words.next()?;
    let number: f32 = fast_float2::parse(word).ok()?;
    number.is_finite().then_some(number)
}

//! Material libraries: `newmtl`, `Kd`, `Ks`, `Ns`, `illum`. Nothing here stops a mesh from being shown: what is not
//! understood becomes a note.

use super::super::{
    mesh::Surface,
    place::{TextFault, Words},
};
use crate::error::quote;
use std::path::Path;

/// Diffuse and specular colour of the materials, by name. A name may come twice: the last one counts.
pub(super) fn parse(text: &[u8], path: &Path, notes: &mut Vec<String>) -> Vec<(Vec<u8>, Surface)> {
    let mut materials: Vec<Reading> = Vec::new();
    let (mut start, mut textures, mut faults) = (0, false, 0);
    for line in text.split_inclusive(|&byte| byte == b'\n') {
        let mut words = Words::new(text, start..start + line.len());
        start += line.len();
        let Some((keyword, place)) = words.next() else {
            continue;
        };
        if keyword == b"newmtl" {
            let name = words.text(words.rest()).to_vec();
            materials.push(Reading::new(name));
            continue;
        }
        let Some(material) = materials.last_mut() else {
            continue;
        };
        let read = match keyword {
            b"Kd" => color(words).map(|color| material.diffuse = Some(color)),
            b"Ks" => color(words).map(|color| material.specular = Some(color)),
            b"Ns" => number(&mut words).map(|exponent| material.exponent = exponent),
            b"illum" => number(&mut words).map(|model| material.has_highlight = model >= 2.0),
            b"map_Kd" => {
                textures = true;
                material.has_texture = true;
                Some(())
            }
            _ => Some(()),
        };
        if read.is_none() {
            faults += 1;
            // One is enough to look there.
            if faults == 1 {
                let message = format!("{} without numbers that are understood", quote(keyword));
                notes.push(TextFault::new(place, message).into_error(text, path).to_string());
            }
        }
    }
    if textures {
        notes.push(format!("{}: textures are not read, only colours", path.display()));
    }
    materials.into_iter().map(Reading::finish).collect()
}

/// A material as far as it has been read.
struct Reading {
    name: Vec<u8>,
    diffuse: Option<[f32; 3]>,
    specular: Option<[f32; 3]>,
    exponent: f32,
    has_highlight: bool,
    has_texture: bool,
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
        }
    }

    fn finish(self) -> (Vec<u8>, Surface) {
        let neutral = Surface::NEUTRAL;
        let diffuse = match self.diffuse {
            // Black below a texture is not meant to be seen.
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

/// One number for all channels, or three; clamped to 0 to 1.
fn color(mut words: Words<'_>) -> Option<[f32; 3]> {
    let red = number(&mut words)?;
    let color = match number(&mut words) {
        None => [red; 3],
        Some(green) => [red, green, number(&mut words)?],
    };
    Some(color.map(|channel| channel.clamp(0.0, 1.0)))
}

fn number(words: &mut Words<'_>) -> Option<f32> {
    let (word, _) = words.next()?;
    let number: f32 = fast_float2::parse(word).ok()?;
    number.is_finite().then_some(number)
}

//! How pictures are made, and what their pixels hold.

use crate::{
    cli::write::AovKind,
    render::{Settings, Transfer},
};
use std::str::FromStr;

/// How pictures are made.
#[derive(Debug, PartialEq)]
pub struct Look {
    pub settings: Settings,
    pub picture: PictureOptions,
}

/// The looks of scenes and of meshes. Both have the same size, crop and AOVs, and that of meshes takes at least as much
/// memory.
#[derive(Debug)]
pub struct Looks {
    pub scene: Look,
    pub mesh: Look,
}

impl Looks {
    /// The look of a mesh, or of a scene.
    pub fn of(&self, is_mesh: bool) -> &Look {
        if is_mesh { &self.mesh } else { &self.scene }
    }
}

/// What is behind everything in a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Backdrop {
    /// The scene's background.
    #[default]
    Scene,
    /// Nothing: alpha 0.
    Transparent,
    /// A colour, in the picture's bytes.
    Color([u8; 3]),
}

impl Backdrop {
    /// Whether the file has alpha.
    pub fn is_transparent(self) -> bool {
        self == Self::Transparent
    }

    /// Bytes of a pixel in all films of a picture. `floats`: the film of the scene's own background has floats.
    pub fn film_bytes(self, floats: bool) -> u64 {
        match self {
            Self::Scene if floats => 12,
            Self::Scene => 3,
            Self::Transparent => 16,
            Self::Color(_) => 16 + 12,
        }
    }
}

impl FromStr for Backdrop {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let digits = text.strip_prefix('#').unwrap_or(text);
        match text {
            "scene" => Ok(Self::Scene),
            "transparent" => Ok(Self::Transparent),
            "white" => Ok(Self::Color([255; 3])),
            "black" => Ok(Self::Color([0; 3])),
            _ if digits.len() == 6 && digits.bytes().all(|digit| digit.is_ascii_hexdigit()) => {
                let color = u32::from_str_radix(digits, 16).unwrap_or_default();
                let [_, r, g, b] = color.to_be_bytes();
                Ok(Self::Color([r, g, b]))
            }
            _ => Err("expected scene, transparent, white, black, or a colour of six hexadecimal digits, such as 336699".into()),
        }
    }
}

/// What the pixels hold.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureOptions {
    /// How linear channels become bytes.
    pub transfer: Transfer,
    /// The same for a file of bytes: the backdrop's colour is such bytes, and an EXR picture may be compared with some.
    pub byte_transfer: Transfer,
    pub backdrop: Backdrop,
    pub aovs: Vec<AovKind>,
    /// Units of a step of depth in a PNG file.
    pub z_step: f64,
    /// Whether the numbers of colours are explained in the picture.
    pub has_color_bar: bool,
}

//! Numbers of a mesh that are shown as colours.

use crate::format::mesh::Wanted;
use colorous::Gradient;
use std::fmt;

/// The names of the coordinates, which every mesh has.
const COORDINATES: [&str; 3] = ["x", "y", "z"];

/// Which numbers of a mesh are shown as colours, and how.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ColorBy {
    pub values: Shading,
    pub map: ColorMap,
    /// The numbers that have the first and the last colour; the smallest and the largest if `None`.
    pub range: Option<[f64; 2]>,
}

/// What has the numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Shading {
    /// Nothing: the mesh has its own colours.
    #[default]
    Own,
    /// A coordinate in the file: 0 for x, 1 for y, 2 for z.
    Coordinate(usize),
    /// The vertices or faces of the file, by this name.
    Property(String),
}

impl Shading {
    /// Of this name.
    pub fn named(name: &str) -> Self {
        match COORDINATES.iter().position(|known| *known == name) {
            Some(axis) => Self::Coordinate(axis),
            None => Self::Property(name.to_owned()),
        }
    }

    /// Its name.
    pub fn name(&self) -> Option<&str> {
        match self {
            Self::Own => None,
            Self::Coordinate(axis) => COORDINATES.get(*axis).copied(),
            Self::Property(name) => Some(name),
        }
    }

    /// What a load reads.
    pub(in crate::cli) fn wanted(&self) -> Wanted {
        match self {
            Self::Own => Wanted::Nothing,
            Self::Coordinate(_) => Wanted::Coordinates,
            Self::Property(name) => Wanted::Named(name.clone()),
        }
    }
}

/// How many colours a map has.
pub const COLORS: usize = 256;

/// A map from numbers to colours.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
pub struct ColorMap(usize);

/// The maps, by matplotlib's names in lower case. Its `rainbow` is another one, and most of the others differ a little.
const MAPS: [(&str, Gradient); 17] = [
    ("viridis", colorous::VIRIDIS),
    ("magma", colorous::MAGMA),
    ("inferno", colorous::INFERNO),
    ("plasma", colorous::PLASMA),
    ("cividis", colorous::CIVIDIS),
    ("turbo", colorous::TURBO),
    ("cubehelix", colorous::CUBEHELIX),
    ("greys", colorous::GREYS),
    ("blues", colorous::BLUES),
    ("reds", colorous::REDS),
    ("ylorrd", colorous::YELLOW_ORANGE_RED),
    ("rdbu", colorous::RED_BLUE),
    ("rdylbu", colorous::RED_YELLOW_BLUE),
    ("brbg", colorous::BROWN_GREEN),
    ("piyg", colorous::PINK_GREEN),
    ("spectral", colorous::SPECTRAL),
    ("rainbow", colorous::RAINBOW),
];

impl ColorMap {
    /// All maps.
    pub const ALL: [Self; MAPS.len()] = {
        let mut all = [Self(0); MAPS.len()];
        let mut i = 0;
        while i < all.len() {
            all[i] = Self(i);
            i += 1;
        }
        all
    };

    /// Its name.
    pub fn name(self) -> &'static str {
        MAPS[self.0].0
    }

    /// The map of this name, in upper or lower case.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|map| map.name().eq_ignore_ascii_case(name))
    }

    /// Its colours, display values from 0 to 1.
    pub fn colors(self) -> [[f32; 3]; COLORS] {
        std::array::from_fn(|i| {
            let color = MAPS[self.0].1.eval_rational(i, COLORS);
            [color.r, color.g, color.b].map(|channel| f32::from(channel) / 255.0)
        })
    }
}

impl fmt::Debug for ColorMap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Which of a map's colours a number has, if `low` has the first and `high` the last. Outside of these it is the first or the
/// last, in the middle if both are equal. `None` for what is not finite.
pub fn color_of(value: f64, [low, high]: [f64; 2]) -> Option<usize> {
    if !value.is_finite() {
        return None;
    }
    if low == high {
        return Some(COLORS / 2);
    }
    // Halves, whose difference is finite.
    let share = (0.5 * value - 0.5 * low) / (0.5 * high - 0.5 * low);
    Some(((share * COLORS as f64) as usize).min(COLORS - 1))
}

#[cfg(test)]
mod tests;

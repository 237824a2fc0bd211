//! Numbers that a file has for its vertices or faces, such as `quality`: the program shows them as colours.
//!
//! While a mesh is loaded, numbers of vertices are where their colours would be, as the bits of an `f64` in two channels
//! ([`channels`]). So whatever drops or copies vertices takes them along, and other loads take no memory for them.

#![cfg_attr(
    not(feature = "cli"),
    allow(dead_code, reason = "only the program asks for numbers")
)]

use crate::{
    error::{LoadErrorKind, quote},
    format::reason::Reason,
};

/// Which numbers a load reads.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) enum Wanted {
    /// None.
    #[default]
    Nothing,
    /// None, and no colours: the coordinates are shown as colours.
    Coordinates,
    /// Those with this name, instead of colours.
    Named(String),
    /// The ranges of all.
    Ranges,
}

impl Wanted {
    /// The name of the numbers that are shown.
    pub(in crate::format) fn name(&self) -> Option<&str> {
        match self {
            Self::Named(name) => Some(name),
            _ => None,
        }
    }

    /// Whether the mesh is shown in its own colours.
    pub(in crate::format) fn shows_colors(&self) -> bool {
        matches!(self, Self::Nothing | Self::Ranges)
    }
}

/// The numbers of a mesh that were asked for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scalars {
    /// A number for each triangle, if faces have the wanted ones. Those of vertices are in the mesh's colours.
    pub(crate) of_faces: Vec<f64>,
    /// All that the file has, if their ranges were asked for.
    pub(crate) listed: Vec<Scalar>,
}

/// A number of each vertex or face.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Scalar {
    pub(crate) name: String,
    pub(crate) of: Owner,
    pub(crate) range: Range,
}

/// What has a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Owner {
    Vertices,
    Faces,
}

impl Owner {
    /// As messages call it.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Vertices => "vertices",
            Self::Faces => "faces",
        }
    }
}

/// The smallest and the largest finite number; `None` if there are none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Range(pub(crate) Option<[f64; 2]>);

impl Range {
    /// Of some numbers.
    pub(crate) fn of(values: impl Iterator<Item = f64>) -> Self {
        values.fold(Self::default(), Self::with)
    }

    /// With one more number.
    pub(crate) fn with(self, value: f64) -> Self {
        if !value.is_finite() {
            return self;
        }
        let [low, high] = self.0.unwrap_or([value; 2]);
        Self(Some([low.min(value), high.max(value)]))
    }

    /// With the numbers of another range.
    pub(crate) fn and(self, other: Self) -> Self {
        other.0.into_iter().flatten().fold(self, Self::with)
    }
}

/// The number of a vertex in the place of its colour.
pub(crate) fn channels(value: f64) -> [f32; 3] {
    let bits = value.to_bits();
    [
        f32::from_bits((bits >> 32) as u32),
        f32::from_bits(bits as u32),
        0.0,
    ]
}

/// The number that [`channels`] has put there.
pub(crate) fn value_of([high, low, _]: [f32; 3]) -> f64 {
    f64::from_bits(u64::from(high.to_bits()) << 32 | u64::from(low.to_bits()))
}

/// Why there are no numbers of that name in a file that has these.
pub(in crate::format) fn absent(wanted: &str, has: &[(Owner, &str)]) -> Reason {
    const MOST_NAMES: usize = 64;
    let of = |owner: Owner| {
        let names: Vec<String> = has
            .iter()
            .filter(|(other, _)| *other == owner)
            .map(|(_, name)| quote(name.as_bytes()))
            .collect();
        let more = if names.len() > MOST_NAMES { ", ..." } else { "" };
        let listed = names.get(..MOST_NAMES).unwrap_or(&names).join(", ");
        (!names.is_empty()).then(|| format!("{listed}{more} of {}", owner.name()))
    };
    let parts: Vec<String> = [Owner::Vertices, Owner::Faces]
        .into_iter()
        .filter_map(of)
        .collect();
    let has = if parts.is_empty() {
        "none".to_owned()
    } else {
        parts.join(" and ")
    };
    let wanted = quote(wanted.as_bytes());
    refused(format!(
        "no scalar property {wanted}: the file has {has}; x, y and z are the coordinates"
    ))
}

/// An error about the numbers that were asked for.
pub(in crate::format) fn refused(message: String) -> Reason {
    Reason {
        kind: LoadErrorKind::Absent,
        message,
    }
}

#[cfg(test)]
mod tests;

//! The animations of a mesh's file, and the moment of one that is shown.

use crate::error::{clip, quote};

/// A time of an animation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Moment {
    /// The animation's name, or its number, from 1 on; the first one if `None`.
    pub animation: Option<String>,
    /// The time, in seconds. Before its first keyframe and after its last one nothing moves.
    pub seconds: f64,
}

/// An animation of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshAnimation {
    /// Its name in the file, perhaps empty.
    pub name: String,
    /// The time of its last keyframe, in seconds; `None` if the file does not say.
    pub seconds: Option<f64>,
}

impl MeshAnimation {
    /// Returns the index of the animation with this name or number; the first one without either.
    ///
    /// # Errors
    /// A sentence that names those of the file.
    pub fn find(animations: &[Self], wanted: Option<&str>) -> Result<usize, String> {
        if animations.is_empty() {
            return Err("there is no animation in the file".to_owned());
        }
        let Some(wanted) = wanted else { return Ok(0) };
        let names: Vec<&str> = animations.iter().map(|one| one.name.as_str()).collect();
        index_of(&names, wanted).ok_or_else(|| {
            let wanted = quote(wanted.as_bytes());
            format!("there is no animation {wanted}, expected {}", listed(&names))
        })
    }
}

/// The index of that name, or of that number from 1 on.
pub(crate) fn index_of(names: &[&str], wanted: &str) -> Option<usize> {
    let by_number = || {
        let number: usize = wanted.parse().ok()?;
        number.checked_sub(1).filter(|&i| i < names.len())
    };
    let by_name = names.iter().position(|&name| name == wanted && !name.is_empty());
    by_name.or_else(by_number)
}

/// The first names, as messages show them.
pub(crate) fn listed(names: &[&str]) -> String {
    const MOST_NAMES: usize = 8;
    let mut list: Vec<String> = (1..)
        .zip(names)
        .take(MOST_NAMES)
        .map(|(number, &name)| match name {
            "" => format!("{number} (unnamed)"),
            name => format!("`{}`", clip(name)),
        })
        .collect();
    if names.len() > MOST_NAMES {
        list.push("...".to_owned());
    }
    list.join(", ")
}

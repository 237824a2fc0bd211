//! Replacements for a missing file, and suggestions: files in its folder with similar names, and `/` for `\`.

use std::{
    fs,
    path::{Path, PathBuf},
};

/// How many entries of a folder are compared.
const MOST_ENTRIES: usize = 10_000;
/// The longest name that is compared, in bytes.
const MOST_NAME: usize = 80;
/// How many pairs of bytes are compared: the product of two names' lengths each.
const MOST_PAIRS: usize = 1 << 21;
/// How many names are suggested.
const MOST_NAMES: usize = 3;

/// The end of the error about a missing file at `path`; `None` if there is nothing to add.
pub(super) fn instead_of(path: &Path) -> Option<String> {
    if let Ok(target) = fs::read_link(path) {
        return Some(format!("it is a broken link to `{}`", target.display()));
    }
    let typed = path.to_string_lossy();
    if !cfg!(windows) && typed.contains('\\') && Path::new(&typed.replace('\\', "/")).exists() {
        return Some("write `/` instead of `\\`".to_owned());
    }
    let folder = match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    if !folder.exists() {
        return Some(format!("directory `{}` does not exist", folder.display()));
    }
    let names = names_in(folder)?;
    let wanted = path.file_name()?.to_string_lossy().into_owned();
    let alike = most_alike(&wanted, names);
    let quoted: Vec<String> = alike.iter().map(|name| format!("`{name}`")).collect();
    (!quoted.is_empty()).then(|| format!("did you mean {}?", quoted.join(" or ")))
}

/// The only file in the folder of a missing one whose name differs from its name in upper and lower case alone: files made on
/// Windows name each other in any case.
pub(super) fn in_other_case(path: &Path) -> Option<PathBuf> {
    let wanted = path.file_name()?.to_str()?.to_lowercase();
    let folder = path.parent()?;
    let mut alike = names_in(folder)?.filter(|name| name.to_lowercase() == wanted);
    let only = alike.next()?;
    alike.next().is_none().then(|| folder.join(only))
}

fn names_in(folder: &Path) -> Option<impl Iterator<Item = String>> {
    let folder = if folder == Path::new("") {
        Path::new(".")
    } else {
        folder
    };
    let entries = fs::read_dir(folder).ok()?.take(MOST_ENTRIES);
    Some(entries.filter_map(|entry| Some(entry.ok()?.file_name().to_string_lossy().into_owned())))
}

/// The names most similar to `wanted`, the most similar first.
fn most_alike(wanted: &str, names: impl Iterator<Item = String>) -> Vec<String> {
    if wanted.len() > MOST_NAME {
        return Vec::new();
    }
    let wanted = wanted.to_lowercase();
    // Suggest other formats of the same name, but not a mesh's material file.
    let stem = |name: &str| match name.rsplit_once('.') {
        Some((
            stem,
            "ply" | "obj" | "off" | "stl" | "gltf" | "glb" | "3mf" | "vtk" | "vtp" | "vtu" | "scn",
        )) => Some(stem.to_owned()),
        _ => None,
    };
    // What a material library or a picture is missed for is another one.
    let kind = |name: &str| {
        let extension = name.rsplit_once('.').map(|(_, extension)| extension);
        match extension {
            Some("mtl" | "mat") => 1,
            Some(
                "png" | "jpg" | "jpeg" | "webp" | "bmp" | "tga" | "gif" | "hdr" | "exr" | "tif" | "tiff",
            ) => 2,
            _ => 0,
        }
    };
    // The extension may have been left out.
    let wanted_stem = stem(&wanted).unwrap_or_else(|| wanted.clone());
    let mut pairs = 0;
    let mut alike: Vec<(usize, String)> = names
        .filter(|name| name.len() <= MOST_NAME)
        .take_while(|name| {
            pairs += wanted.len() * name.len();
            pairs <= MOST_PAIRS
        })
        .filter_map(|name| {
            let lower = name.to_lowercase();
            if kind(&wanted) != 0 && kind(&lower) != kind(&wanted) {
                return None;
            }
            let distance = strsim::damerau_levenshtein(&wanted, &lower);
            let length = wanted.chars().count();
            let close = distance < length && distance <= (length / 4).max(1);
            let namesake = stem(&lower).is_some_and(|stem| stem == wanted_stem);
            (close || namesake).then_some((distance, name))
        })
        .collect();
    alike.sort();
    alike.truncate(MOST_NAMES);
    alike.into_iter().map(|(_, name)| name).collect()
}

#[cfg(test)]
mod tests;

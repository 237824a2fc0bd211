//! Names of pictures, made from patterns: `{stem}` is the scene's name, `{folder}` that of its folder, `{pose}` that of the
//! frame's pose, a run of `#` the frame's number.

use super::{Turn, is_standard_stream};
use crate::error::clip;
use std::{
    ffi::{OsStr, OsString},
    path::{Path, PathBuf, is_separator},
};

/// The path of a picture, and who chose it.
#[derive(Clone, Debug)]
pub struct PicturePath {
    pub path: PathBuf,
    pub origin: Origin,
}

impl PicturePath {
    /// The same, as a derived name unless `is_typed`.
    pub fn typed_if(self, is_typed: bool) -> Self {
        let origin = if is_typed { self.origin } else { Origin::Derived };
        Self { origin, ..self }
    }
}

/// Who chose the name of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// The user typed the whole path on the command line.
    Typed,
    /// It comes from a config file, or octray made it from a pattern or another name.
    Derived,
}

/// The name of a frame if the user gives none.
const DEFAULT_OF_FRAMES: &str = "{stem}-####.png";

/// The path of a scene's picture: `pattern`, else a name after the scene in the current folder. `pose` is the name of the
/// frame's pose.
pub fn picture(pattern: Option<&Path>, scene: &Path, turn: Option<Turn>, pose: Option<&str>) -> PicturePath {
    let default = if turn.is_some() {
        DEFAULT_OF_FRAMES
    } else {
        "{stem}.png"
    };
    let path = expand(
        pattern.unwrap_or(Path::new(default)),
        scene,
        turn.map(|turn| turn.number),
        pose,
    );
    PicturePath {
        origin: if pattern == Some(&path) {
            Origin::Typed
        } else {
            Origin::Derived
        },
        path,
    }
}

/// The path of the difference picture: `pattern`, else next to the picture, else in the current folder.
pub fn difference(
    pattern: Option<&Path>,
    beside_picture: Option<&PicturePath>,
    scene: &Path,
    turn: Option<Turn>,
    pose: Option<&str>,
) -> PicturePath {
    match (pattern, beside_picture) {
        (Some(_), _) => picture(pattern, scene, turn, pose),
        (None, Some(PicturePath { path, .. })) => beside(path, "-difference", "png"),
        (None, None) => beside(&picture(None, scene, turn, pose).path, "-difference", "png"),
    }
}

/// The file of an AOV next to a picture: `a.depth.png` for `a.png`. `None` if the picture's name has no extension.
pub fn aov(picture: &Path, aov: &str) -> Option<PicturePath> {
    let extension = picture.extension()?.to_str()?;
    Some(beside(picture, &format!(".{aov}"), extension))
}

/// Stands for the scene's name without folder and extension.
const STEM: &str = "{stem}";

/// Stands for the name of the scene's folder.
const FOLDER: &str = "{folder}";

/// Stands for the name of a pose.
const POSE: &str = "{pose}";

/// Refuses placeholders in a picture's name that octray does not replace, and says what it has instead.
///
/// # Errors
/// The message.
pub fn check_pattern(pattern: &Path, has_poses: bool) -> Result<(), String> {
    if let Some(word) = unknown_placeholder(pattern) {
        return Err(format!(
            "unknown placeholder {word}; {{stem}} is the scene's name, {{folder}} its folder's, {{pose}} a pose's"
        ));
    }
    if let Some(number) = printf_number(pattern) {
        let digits = number[1..number.len() - 1].parse().unwrap_or(4);
        let run = if has_number(pattern) {
            String::new()
        } else {
            "#".repeat(digits.clamp(1, 9))
        };
        let file = pattern.file_name().unwrap_or_default().to_string_lossy();
        let file = file.replacen(number, &run, 1);
        let name = pattern.with_file_name(file);
        let name = name.to_string_lossy();
        return Err(format!(
            "{number} stands for nothing: octray numbers frames with #, such as {}",
            clip(&name)
        ));
    }
    if !has_poses && pattern.to_str().is_some_and(|text| text.contains(POSE)) {
        return Err(format!("{POSE} in the name needs --poses"));
    }
    Ok(())
}

/// A number as in C's `printf`, such as `%04d`, in the name of a file; not `%20d`, which may be a space and a letter.
fn printf_number(pattern: &Path) -> Option<&str> {
    let name = pattern.file_name()?.to_str()?;
    name.match_indices('%').find_map(|(start, _)| {
        let rest = &name[start + 1..];
        let digits = rest.find(|c: char| !c.is_ascii_digit())?;
        let after = rest[digits..].strip_prefix('d')?;
        let is_word = after.starts_with(|c: char| c.is_ascii_alphabetic());
        let is_number = digits < 2 || digits == 2 && rest.starts_with('0');
        let is_escaped = name[..start].ends_with('%');
        (is_number && !is_word && !is_escaped).then(|| &name[start..start + digits + 2])
    })
}

/// The first word in braces in a pattern that octray does not replace.
fn unknown_placeholder(pattern: &Path) -> Option<&str> {
    let mut rest = pattern.to_str()?;
    while let Some((_, after)) = rest.split_once('{') {
        let length = after
            .find(|c: char| !c.is_ascii_lowercase())
            .unwrap_or(after.len());
        if length > 0 && after[length..].starts_with('}') {
            let word = &rest[rest.len() - after.len() - 1..][..length + 2];
            if ![STEM, FOLDER, POSE].contains(&word) {
                return Some(word);
            }
        }
        rest = after;
    }
    None
}

/// The name that `{folder}` stands for: of the current folder if the scene's path has none.
pub fn folder(scene: &Path) -> OsString {
    if is_standard_stream(scene) {
        return "stdin".into();
    }
    let whole = std::path::absolute(scene).unwrap_or_else(|_| scene.to_owned());
    let name = whole.parent().and_then(Path::file_name);
    name.unwrap_or("octray".as_ref()).to_owned()
}

/// The name that `{stem}` stands for.
pub fn stem(scene: &Path) -> &OsStr {
    if is_standard_stream(scene) {
        return "stdin".as_ref();
    }
    scene.file_stem().unwrap_or("octray".as_ref())
}

/// The name that a pattern gives. The last run of `#` in the file's name (not in its folder's) becomes `number`, padded
/// with zeros to the run's length; without a number it stays, and so does `{pose}` without a pose. A pattern that is not
/// UTF-8 is a name.
pub fn expand(pattern: &Path, scene: &Path, number: Option<u32>, pose: Option<&str>) -> PathBuf {
    let Some(text) = pattern.to_str() else {
        return pattern.to_owned();
    };
    let numbered = number.and_then(|number| with_number(text, number));
    // Names come last, so that a `#` in them stays as it is. Those of the scene need not be UTF-8.
    let mut name = OsString::new();
    let mut rest = numbered.as_deref().unwrap_or(text);
    while let Some(start) = rest.find('{') {
        let (before, after) = rest.split_at(start);
        name.push(before);
        rest = if let Some(after) = after.strip_prefix(STEM) {
            name.push(stem(scene));
            after
        } else if let Some(after) = after.strip_prefix(FOLDER) {
            name.push(folder(scene));
            after
        } else if let Some((after, pose)) = after.strip_prefix(POSE).zip(pose) {
            name.push(pose);
            after
        } else {
            name.push("{");
            &after[1..]
        };
    }
    name.push(rest);
    name.into()
}

/// Whether a pattern has a place for the frame's number.
pub fn has_number(pattern: &Path) -> bool {
    pattern
        .to_str()
        .is_some_and(|text| with_number(text, 1).is_some())
}

/// The pattern of a scene's frames, that of `--output` or the default, as it is for one frame alone.
pub fn of_frame(pattern: Option<&str>, number: u32) -> String {
    let pattern = pattern.unwrap_or(DEFAULT_OF_FRAMES);
    with_number(pattern, number).unwrap_or_else(|| pattern.to_owned())
}

/// A pattern like this one, with `{pose}`, that gives each frame a name of its own. `None` without `{pose}`.
pub fn pattern_per_pose(pattern: &Path) -> Option<String> {
    let pattern = pattern.to_str().filter(|pattern| pattern.contains(POSE))?;
    let file = pattern.rfind(is_separator).map_or(0, |separator| separator + 1);
    let (folder, file) = pattern.split_at(file);
    let (stem, extension) = file.split_at(file.rfind('.').unwrap_or(file.len()));
    let file = if !file.contains('#') {
        format!("{stem}_#{extension}")
    } else if file.contains("{pose}#") {
        file.replace("{pose}#", "{pose}_#")
    } else if file.contains("#{pose}") {
        file.replace("#{pose}", "#_{pose}")
    } else {
        format!("{POSE}_#{extension}")
    };
    Some(folder.to_owned() + &file)
}

fn with_number(pattern: &str, number: u32) -> Option<String> {
    let file = pattern.rfind(is_separator).map_or(0, |separator| separator + 1);
    let end = file + pattern[file..].rfind('#')? + 1;
    let start = file + pattern[file..end].trim_end_matches('#').len();
    let (before, after, digits) = (&pattern[..start], &pattern[end..], end - start);
    Some(format!("{before}{number:0digits$}{after}"))
}

/// A pattern with a run of # before its extension.
pub fn numbered(pattern: &Path) -> PathBuf {
    let extension = pattern.extension().and_then(OsStr::to_str).unwrap_or("png");
    beside(pattern, "-####", extension).path
}

/// The same place with something added to the file's name, and another extension.
fn beside(path: &Path, addition: &str, extension: &str) -> PicturePath {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(addition);
    name.push(".");
    name.push(extension);
    PicturePath {
        path: path.with_file_name(name),
        origin: Origin::Derived,
    }
}

#[cfg(test)]
mod tests;

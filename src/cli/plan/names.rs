//! Names of pictures, made from patterns: `{stem}` is the scene's name, `{folder}` that of its folder, a run of `#` the
//! frame's number.

use super::{Turn, is_standard_input};
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

/// The path of a scene's picture: `pattern`, else a name after the scene in the current folder.
pub fn picture(pattern: Option<&Path>, scene: &Path, turn: Option<Turn>) -> PicturePath {
    let default = if turn.is_some() {
        "{stem}-####.png"
    } else {
        "{stem}.png"
    };
    let path = expand(
        pattern.unwrap_or(Path::new(default)),
        scene,
        turn.map(|turn| turn.number),
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
) -> PicturePath {
    match (pattern, beside_picture) {
        (Some(_), _) => picture(pattern, scene, turn),
        (None, Some(PicturePath { path, .. })) => beside(path, "-difference", "png"),
        (None, None) => beside(&picture(None, scene, turn).path, "-difference", "png"),
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
pub const POSE: &str = "{pose}";

/// The first word in braces in a pattern that octray does not replace.
pub fn unknown_placeholder(pattern: &Path) -> Option<&str> {
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
    if is_standard_input(scene) {
        return "stdin".into();
    }
    let whole = std::path::absolute(scene).unwrap_or_else(|_| scene.to_owned());
    let name = whole.parent().and_then(Path::file_name);
    name.unwrap_or("octray".as_ref()).to_owned()
}

/// The name that `{stem}` stands for.
pub fn stem(scene: &Path) -> &OsStr {
    if is_standard_input(scene) {
        return "stdin".as_ref();
    }
    scene.file_stem().unwrap_or("octray".as_ref())
}

/// The name that a pattern gives. The last run of `#` in the file's name (not in its folder's) becomes `number`, padded
/// with zeros to the run's length; without a number it stays. A pattern that is not UTF-8 is a name.
pub fn expand(pattern: &Path, scene: &Path, number: Option<u32>) -> PathBuf {
    let Some(text) = pattern.to_str() else {
        return pattern.to_owned();
    };
    let numbered = number.and_then(|number| with_number(text, number));
    // The scene's names come last, so that a `#` in them stays as it is. They need not be UTF-8.
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

fn with_number(pattern: &str, number: u32) -> Option<String> {
    let file = pattern.rfind(is_separator).map_or(0, |separator| separator + 1);
    let end = file + pattern[file..].rfind('#')? + 1;
    let start = file + pattern[file..end].trim_end_matches('#').len();
    let (before, after, digits) = (&pattern[..start], &pattern[end..], end - start);
    Some(format!("{before}{number:0digits$}{after}"))
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
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn name(pattern: &str, number: Option<u32>) -> String {
        let name = expand(Path::new(pattern), Path::new("herd/cow.scn"), number);
        name.into_os_string().into_string().unwrap()
    }

    #[test]
    fn stems() {
        for (scene, expected) in [
            ("a/b.c.scn", "b.c"),
            ("b", "b"),
            (".scn", ".scn"),
            ("-", "stdin"),
            ("..", "octray"),
            ("", "octray"),
        ] {
            assert_eq!(stem(Path::new(scene)), expected, "{scene}");
        }
    }

    #[test]
    fn patterns() {
        for (pattern, number, expected) in [
            ("a.png", None, "a.png"),
            ("out/{stem}.png", None, "out/cow.png"),
            ("{stem}/{stem}{stem}.png", None, "cow/cowcow.png"),
            ("a-####.png", Some(7), "a-0007.png"),
            ("a-#.png", Some(12345), "a-12345.png"),
            ("####", Some(0), "0000"),
            ("a#b##.png", Some(3), "a#b03.png"),
            ("a##{stem}.png", Some(3), "a03cow.png"),
            ("f##/a.png", Some(3), "f##/a.png"),
            ("f##/a#.png", Some(u32::MAX), "f##/a4294967295.png"),
            ("a####.png", None, "a####.png"),
            ("a.png", Some(3), "a.png"),
            ("{ste#m}", Some(3), "{ste3m}"),
            ("{{stem}}", None, "{cow}"),
            ("{stem", None, "{stem"),
            ("{folder}/{stem}.png", None, "herd/cow.png"),
            ("{folder}{", None, "herd{"),
            ("", Some(1), ""),
            ("ä#ö", Some(1), "ä1ö"),
        ] {
            assert_eq!(name(pattern, number), expected, "{pattern}");
        }
        let odd = expand(Path::new("{stem}-##.png"), Path::new("a#{folder}.scn"), Some(1));
        assert_eq!(odd, Path::new("a#{folder}-01.png"));
    }

    #[test]
    fn unknown_placeholders() {
        for (pattern, unknown) in [
            ("{stem}-{folder}-{pose}.png", None),
            ("{dir}/{stem}.png", Some("{dir}")),
            ("{{name}}", Some("{name}")),
            ("{A}{}{a b}{stem{x", None),
        ] {
            assert_eq!(unknown_placeholder(Path::new(pattern)), unknown, "{pattern}");
        }
    }

    #[test]
    fn a_scene_without_a_folder_is_in_the_current_one() {
        let current = std::env::current_dir().unwrap();
        assert_eq!(Some(&*folder(Path::new("a.scn"))), current.file_name());
        assert_eq!(folder(Path::new("-")), "stdin");
    }

    #[test]
    fn a_name_is_typed_only_as_a_whole() {
        let scene = Path::new("s/cow.scn");
        let turn = Some(Turn { number: 2, count: 9 });
        for (pattern, turn, expected, origin) in [
            (None, None, "cow.png", Origin::Derived),
            (None, turn, "cow-0002.png", Origin::Derived),
            (Some("a.png"), None, "a.png", Origin::Typed),
            (Some("a/{stem}.png"), None, "a/cow.png", Origin::Derived),
            (Some("a-#.png"), turn, "a-2.png", Origin::Derived),
            (Some("a-#.png"), None, "a-#.png", Origin::Typed),
        ] {
            let named = picture(pattern.map(Path::new), scene, turn);
            assert_eq!(
                (named.path.as_path(), named.origin),
                (Path::new(expected), origin)
            );
        }
    }

    #[test]
    fn other_files_are_named_after_the_picture() {
        for (path, expected) in [
            ("b/a.png", Some("b/a.heat.png")),
            ("a.b.tiff", Some("a.b.heat.tiff")),
            ("-", None),
            ("/dev/null", None),
        ] {
            let named = aov(Path::new(path), "heat").map(|named| named.path);
            assert_eq!(named, expected.map(PathBuf::from), "{path}");
        }
        let typed = picture(Some(Path::new("b/c.d.jpg")), Path::new("cow.scn"), None);
        let named = difference(None, Some(&typed), Path::new("cow.scn"), None);
        assert_eq!(
            (named.path, named.origin),
            ("b/c.d-difference.png".into(), Origin::Derived)
        );
    }

    proptest! {
        #[test]
        fn any_pattern_gives_a_name(pattern in "[#/{}a-z\u{e4}.]{0,20}(\\{stem\\})?#{0,9}", number: Option<u32>) {
            let name = name(&pattern, number);
            if number.is_none() {
                prop_assert_eq!(name, pattern.replace(STEM, "cow").replace(FOLDER, "herd"));
            }
        }

        #[test]
        fn numbers_sort_as_their_names_do(a in 0u32..10_000, b in 0u32..10_000) {
            prop_assert_eq!(a.cmp(&b), name("x-####.png", Some(a)).cmp(&name("x-####.png", Some(b))));
        }
    }
}

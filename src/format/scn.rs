//! `.scn` text: lines to words, words to statements, statements to the [`SceneBuilder`].

mod words;

use super::{OpenMesh, files, ply};
use crate::{
    error::{LoadError, SceneError, SourcePos, quote},
    scene::{MaterialId, Scene, SceneBuilder},
};
use glam::Vec3;
use std::{
    collections::HashSet,
    path::{Path, PathBuf},
    sync::Arc,
};
use words::{Word, split};

/// The longest line, bytes. A file of one endless line is no scene.
const MAX_LINE: usize = 1 << 16;

/// The longest path of a mesh, bytes; no system takes longer ones, and an error repeats it.
const MAX_PATH: usize = 4096;

/// The statements and the names of their arguments.
const STATEMENTS: [(&str, &[&str]); 4] = [
    ("light", &["x", "y", "z", "intensity"]),
    ("sphere", &["x", "y", "z", "radius"]),
    ("material", &["number"]),
    ("ply_file", &["path"]),
];

/// Text to scene. `identify` gives paths of the same mesh the same name.
pub(super) fn parse(
    text: &[u8],
    name: &Path,
    open_mesh: OpenMesh<'_>,
    identify: fn(&Path) -> PathBuf,
) -> Result<Scene, LoadError> {
    // Some editors put a byte order mark first.
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    let file = Arc::new(name.to_path_buf());
    refuse_binary(text, &file)?;
    let builder = SceneBuilder::new();
    // Material 0 is current before the first `material` line.
    let material = MaterialId::default();
    let mut reader = Reader {
        folder: name.parent().unwrap_or(Path::new("")),
        builder,
        material,
        open_mesh,
        identify,
        meshes: HashSet::new(),
    };
    for (i, bytes) in text.split(|&byte| byte == b'\n').enumerate() {
        let line = Line {
            file: &file,
            number: u32::try_from(i + 1).unwrap_or(u32::MAX),
            bytes,
        };
        if bytes.len() > MAX_LINE {
            let message = format!(
                "a line of {} bytes, expected at most {MAX_LINE}: is this a scene?",
                bytes.len()
            );
            return Err(line.error(0, 1, message));
        }
        let words = split(bytes).map_err(|fault| line.error(fault.start, 1, fault.message))?;
        if let [keyword, arguments @ ..] = &words[..] {
            reader.statement(&line, keyword, arguments)?;
        }
    }
    Ok(reader.builder.finish())
}

/// A picture or a binary mesh is refused as a whole, and not by its first odd word.
fn refuse_binary(text: &[u8], file: &Arc<PathBuf>) -> Result<(), LoadError> {
    let Some(nul) = text.iter().position(|&byte| byte == 0) else {
        return Ok(());
    };
    let before = text.get(..nul).unwrap_or_default();
    let line_start = before
        .iter()
        .rposition(|&byte| byte == b'\n')
        .map_or(0, |i| i + 1);
    let at = SourcePos {
        file: Arc::clone(file),
        line: u32::try_from(1 + before.iter().filter(|&&byte| byte == b'\n').count()).unwrap_or(u32::MAX),
        column: u32::try_from(nul - line_start + 1).unwrap_or(u32::MAX),
    };
    Err(LoadError::new(
        at,
        "found a NUL byte: this is binary data, expected the text of a scene",
    ))
}

/// A line and where it stands.
struct Line<'a> {
    file: &'a Arc<PathBuf>,
    number: u32,
    bytes: &'a [u8],
}

impl Line<'_> {
    /// An error about `width` bytes from `start` on.
    fn error(&self, start: usize, width: usize, message: impl AsRef<str>) -> LoadError {
        let at = SourcePos {
            file: Arc::clone(self.file),
            line: self.number,
            column: u32::try_from(start + 1).unwrap_or(u32::MAX),
        };
        LoadError::new(at, message).with_line(self.bytes, start..start.saturating_add(width))
    }

    fn error_at(&self, word: &Word<'_>, message: impl AsRef<str>) -> LoadError {
        self.error(word.start, word.width(), message)
    }
}

/// What has been read so far.
struct Reader<'a> {
    folder: &'a Path,
    builder: SceneBuilder,
    material: MaterialId,
    open_mesh: OpenMesh<'a>,
    identify: fn(&Path) -> PathBuf,
    /// The meshes that are in the scene already.
    meshes: HashSet<PathBuf>,
}

impl Reader<'_> {
    fn statement(
        &mut self,
        line: &Line<'_>,
        keyword: &Word<'_>,
        arguments: &[Word<'_>],
    ) -> Result<(), LoadError> {
        let Some(&(statement, names)) = STATEMENTS
            .iter()
            .find(|(name, _)| name.as_bytes() == keyword.text)
        else {
            return Err(line.error_at(keyword, unknown_statement(keyword.text)));
        };
        expect_count(line, keyword, arguments, statement, names)?;
        match (statement, arguments) {
            ("light" | "sphere", [x, y, z, last]) => {
                let position = Vec3::new(
                    number(line, x, "x")?,
                    number(line, y, "y")?,
                    number(line, z, "z")?,
                );
                let added = if statement == "light" {
                    self.builder.add_light(position, number(line, last, "intensity")?)
                } else {
                    self.builder
                        .add_sphere(position, number(line, last, "radius")?, self.material)
                };
                added.map_err(|error| {
                    let word = match error {
                        SceneError::NotUsable { what: "x", .. } => x,
                        SceneError::NotUsable { what: "y", .. } => y,
                        SceneError::NotUsable { what: "z", .. } => z,
                        SceneError::TooMany { .. } => keyword,
                        _ => last,
                    };
                    line.error_at(word, error.to_string())
                })
            }
            ("material", [word]) => {
                self.material = self.material_of(line, word)?;
                Ok(())
            }
            ("ply_file", [word]) => self.mesh(line, word),
            _ => Ok(()),
        }
    }

    fn material_of(&self, line: &Line<'_>, word: &Word<'_>) -> Result<MaterialId, LoadError> {
        word.as_str()
            .and_then(|text| text.parse().ok())
            .and_then(|number| self.builder.classic_material(number).ok())
            .ok_or_else(|| {
                let message = format!(
                    "material {}, expected 0 (silhouette), 1 (matte), 2 (Blinn-Phong) or 3 (reflection)",
                    quote(word.text)
                );
                line.error_at(word, message)
            })
    }

    /// Adds a mesh, once: a second copy would lie exactly in the first, and of equal t the lowest id wins, so
    /// nothing of it could be seen. Ten thousand lines that name one mesh cost no more than one.
    fn mesh(&mut self, line: &Line<'_>, word: &Word<'_>) -> Result<(), LoadError> {
        let path = match word.as_str() {
            Some("") => return Err(line.error_at(word, "an empty path, expected the path of a .ply file")),
            Some(path) if path.len() > MAX_PATH => {
                let message = format!("a path of {} bytes, expected at most {MAX_PATH}", path.len());
                return Err(line.error_at(word, message));
            }
            Some(path) => self.folder.join(path),
            None => {
                let message = format!("path {} is not valid UTF-8", quote(word.text));
                return Err(line.error_at(word, message));
            }
        };
        let cannot_load = |cause: LoadError| {
            line.error_at(word, format!("cannot load {}", path.display()))
                .caused_by(cause)
        };
        let identity = (self.identify)(&path);
        if self.meshes.contains(&identity) {
            return Ok(());
        }
        let bytes = (self.open_mesh)(&path).map_err(|error| cannot_load(files::load_error(&path, &error)))?;
        let mesh = ply::parse(&bytes, &path).map_err(cannot_load)?;
        drop(bytes);
        self.builder
            .add_mesh(mesh, self.material)
            .map_err(|error| cannot_load(LoadError::whole_file(&path, error.to_string())))?;
        self.meshes.insert(identity);
        Ok(())
    }
}

fn unknown_statement(keyword: &[u8]) -> String {
    let found = quote(keyword);
    if keyword == b"ply" {
        return format!(
            "found {found}: this looks like a mesh, expected a scene (which can name the mesh with `ply_file`)"
        );
    }
    match std::str::from_utf8(keyword).ok().and_then(nearest_statement) {
        Some(near) => format!("unknown statement {found}, did you mean `{near}`?"),
        None => format!("unknown statement {found}, expected `light`, `sphere`, `material` or `ply_file`"),
    }
}

/// The statement that was probably meant.
fn nearest_statement(keyword: &str) -> Option<&'static str> {
    // Longer than any statement with a few letters too many; and the distance takes quadratic time.
    if keyword.len() > 16 {
        return None;
    }
    let keyword = keyword.to_lowercase();
    STATEMENTS
        .iter()
        .map(|&(name, _)| (strsim::damerau_levenshtein(&keyword, name), name))
        .min()
        .filter(|&(distance, name)| distance <= name.len() / 3)
        .map(|(_, name)| name)
}

fn expect_count(
    line: &Line<'_>,
    keyword: &Word<'_>,
    arguments: &[Word<'_>],
    statement: &str,
    names: &[&str],
) -> Result<(), LoadError> {
    let expected = names.join(" ");
    if let Some(extra) = arguments.get(names.len()) {
        let hint = if statement == "ply_file" {
            " (a path with spaces stands in double quotes)"
        } else {
            ""
        };
        let message = format!(
            "found {} after `{statement} {expected}`, expected the end of the line{hint}",
            quote(extra.text)
        );
        return Err(line.error_at(extra, message));
    }
    if arguments.len() < names.len() {
        let end = arguments.last().unwrap_or(keyword).end();
        let message = match arguments.len() {
            0 => format!("`{statement}` stands alone, expected `{statement} {expected}`"),
            found => format!(
                "`{statement}` with {found} of {} numbers, expected `{statement} {expected}`",
                names.len()
            ),
        };
        return Err(line.error(end, 1, message));
    }
    Ok(())
}

fn number(line: &Line<'_>, word: &Word<'_>, what: &str) -> Result<f32, LoadError> {
    let value = word.as_str().and_then(|text| text.parse::<f32>().ok());
    match value {
        Some(value) if value.is_finite() => Ok(value),
        Some(_) => {
            let message = format!("{what} is {}, expected a finite number", quote(word.text));
            Err(line.error_at(word, message))
        }
        None => {
            let message = format!("{what} is {}, expected a number", quote(word.text));
            Err(line.error_at(word, message))
        }
    }
}

#[cfg(test)]
mod tests;

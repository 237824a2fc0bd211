//! `.scn` text: lines to words, words to statements, statements to the [`SceneBuilder`].

mod arguments;
mod include;
mod line;
mod mesh;
mod nearest;
mod statements;
mod words;

use super::files::Files;
use crate::{
    error::{LoadError, SourcePos, quote},
    scene::{MaterialId, Scene, SceneBuilder},
};
use arguments::Arguments;
use include::Includes;
use line::Line;
use mesh::Placed;
use nearest::{list, nearest};
use statements::{STATEMENTS, again};
use std::{
    collections::{HashMap, HashSet},
    path::{Path, PathBuf},
    sync::Arc,
};
use words::{Word, split};

/// The longest line, bytes. A file of one endless line is no scene.
const MAX_LINE: usize = 1 << 16;

/// The longest path of a file, bytes; no system takes longer ones, and an error repeats it.
const MAX_PATH: usize = 4096;

/// What may help where a word follows a path.
const QUOTES_HINT: &str = " (a path with spaces stands in double quotes)";

/// Text to scene. `name` stands for the file in errors, and paths are relative to its folder; `memory` is as of
/// [`super::load_within`].
pub(super) fn parse(
    text: &[u8],
    name: &Path,
    files: &mut dyn Files,
    memory: u64,
) -> Result<Scene, LoadError> {
    let identity = files.identity(name);
    let mut reader = Reader {
        files,
        folder: PathBuf::new(),
        builder: SceneBuilder::within(memory),
        material: None,
        meshes: HashSet::new(),
        mesh_files: HashSet::new(),
        copied_bytes: 0,
        mesh_cameras: 0,
        includes: Includes::default(),
        said: Said::default(),
    };
    reader.file(text, name, identity)?;
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

/// What has been read so far.
struct Reader<'a> {
    files: &'a mut dyn Files,
    /// The folder of the file that is being read.
    folder: PathBuf,
    builder: SceneBuilder,
    /// The current material. None before the first `material`: meshes look as their files say, and all else has
    /// material 0.
    material: Option<MaterialId>,
    /// The meshes that are in the scene already, where they are.
    meshes: HashSet<Placed>,
    /// Their files.
    mesh_files: HashSet<PathBuf>,
    /// How many bytes of mesh files were read again.
    copied_bytes: u64,
    /// How many cameras the meshes brought along.
    mesh_cameras: usize,
    includes: Includes,
    said: Said,
}

/// Where statements stand of which a scene has one.
#[derive(Default)]
struct Said {
    background: Option<SourcePos>,
    ambient: Option<SourcePos>,
    /// By name.
    cameras: HashMap<Option<String>, SourcePos>,
}

impl Said {
    /// Notes that a statement was said; refuses the second one.
    fn once(
        said: &mut Option<SourcePos>,
        arguments: &Arguments<'_, '_>,
        what: &str,
    ) -> Result<(), LoadError> {
        if let Some(first) = said {
            return Err(again(arguments, what, first));
        }
        *said = Some(arguments.line.at(arguments.keyword.start));
        Ok(())
    }
}

impl Reader<'_> {
    /// Reads a file's text, line by line.
    fn file(&mut self, text: &[u8], name: &Path, identity: PathBuf) -> Result<(), LoadError> {
        // Some editors put a byte order mark first.
        let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
        let file = Arc::new(name.to_path_buf());
        refuse_binary(text, &file)?;
        let folder = name.parent().unwrap_or(Path::new("")).to_path_buf();
        let outer = std::mem::replace(&mut self.folder, folder);
        self.includes.enter(identity, name.to_path_buf());
        for (i, bytes) in text.split(|&byte| byte == b'\n').enumerate() {
            let number = u32::try_from(i + 1).unwrap_or(u32::MAX);
            self.line(&Line {
                file: &file,
                number,
                bytes,
            })?;
        }
        self.includes.leave();
        self.folder = outer;
        Ok(())
    }

    fn line(&mut self, line: &Line<'_>) -> Result<(), LoadError> {
        if line.bytes.len() > MAX_LINE {
            let message = format!(
                "a line of {} bytes, expected at most {MAX_LINE}: is this a scene?",
                line.bytes.len()
            );
            return Err(line.error(0, 1, message));
        }
        let words = split(line.bytes).map_err(|fault| line.error(fault.start, 1, fault.message))?;
        let [keyword, arguments @ ..] = &words[..] else {
            return Ok(());
        };
        let known = STATEMENTS
            .iter()
            .find(|(name, _)| name.as_bytes() == keyword.text);
        let Some(&statement) = known else {
            return Err(line.error_at(keyword, unknown_statement(keyword)));
        };
        self.statement(Arguments::new(line, *keyword, arguments, statement))
    }
}

fn unknown_statement(keyword: &Word<'_>) -> String {
    let found = quote(keyword.text);
    if keyword.text == b"ply" {
        return format!(
            "found {found}: this looks like a mesh, expected a scene (which can name the mesh with `mesh`)"
        );
    }
    let names = STATEMENTS.map(|(name, _)| name);
    match nearest(keyword.text, names) {
        Some(near) => format!("unknown statement {found}, did you mean `{near}`?"),
        None => format!("unknown statement {found}, expected {}", list(&names)),
    }
}

#[cfg(test)]
mod tests;

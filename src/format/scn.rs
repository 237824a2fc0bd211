//! `.scn` text: lines become words, words statements, and statements go to the [`SceneBuilder`].

mod arguments;
mod at;
mod camera;
mod environment;
#[cfg(feature = "cli")]
mod frames;
mod include;
mod instances;
mod lights;
mod line;
mod mesh;
mod meshes;
mod nearest;
mod placements;
mod statements;
mod words;

use super::{
    budget::Budget,
    files::Files,
    foreign,
    mesh::MeshFormat,
    place::{BYTE_ORDER_MARK, LONE_RETURNS, has_lone_returns, refuse_binary},
};
use crate::{
    error::{LoadError, SourcePos, quote},
    scene::{MaterialId, PrototypeId, Scene, SceneBuilder},
};
#[cfg(feature = "cli")]
pub(super) use frames::frames;

use arguments::Arguments;
use at::Moved;
use include::Includes;
use instances::PrototypeKey;
use line::Line;
use mesh::PlacementKey;
use meshes::Meshes;
use nearest::{list, nearest};
use statements::{STATEMENTS, again};
use std::{
    collections::{HashMap, HashSet},
    path::{Path, PathBuf},
    sync::Arc,
};
use words::{Word, split};

/// The longest line, in bytes. A file of one endless line is not a scene.
const MAX_LINE: usize = 1 << 16;

/// The longest path, in bytes. No system takes longer ones, and errors repeat it.
const MAX_PATH: usize = 4096;

/// A hint for a word that follows a path.
const QUOTES_HINT: &str = " (put double quotes around a path with spaces)";

/// Makes a scene of text. `name` stands for the file in errors, and paths are relative to its folder. The text is taken
/// from the budget already; the scene may take the budget's limit.
pub(super) fn parse(
    text: &[u8],
    name: &Path,
    files: &mut dyn Files,
    budget: &Budget,
) -> Result<Scene, LoadError> {
    let identity = files.identity(name);
    let mut reader = Reader {
        files,
        budget,
        folder: PathBuf::new(),
        builder: SceneBuilder::within(budget.limit()),
        material: None,
        own_is_srgb: false,
        meshes: Meshes::default(),
        placements: HashSet::new(),
        placing: 0,
        prototypes: HashMap::new(),
        mesh_cameras: 0,
        mesh_notes: 0,
        includes: Includes::default(),
        seen: Seen::default(),
        has_lights: false,
        has_environment: false,
        is_silhouette: true,
        needs_light: false,
        moved: None,
        keyframes: 0,
        last_statement: "",
    };
    reader.file(text, name, identity)?;
    if reader.needs_light && !reader.has_lights {
        let is_dark = reader.seen.ambient.is_some();
        let consequence = if is_dark {
            "nothing lights its surfaces"
        } else {
            "only ambient light reaches its surfaces"
        };
        reader.builder.add_note(format!(
            "{}: the scene has no light, so {consequence}; add a line such as `light 9 -4 10 0.7`",
            name.display()
        ));
    }
    if reader.has_environment && reader.seen.ambient.is_none() {
        // The environment replaces ambient light.
        let set = reader.builder.set_ambient(0.0);
        debug_assert!(set.is_ok(), "0 is a share");
    }
    Ok(reader.builder.finish())
}

/// Words with which lines of OBJ files begin, without comments.
const OBJ_WORDS: [&[u8]; 11] = [
    b"v", b"vn", b"vt", b"vp", b"f", b"l", b"p", b"o", b"g", b"mtllib", b"usemtl",
];

/// Whether a text is OBJ: its first line that is no comment is one of OBJ.
pub(super) fn is_obj(text: &[u8]) -> bool {
    let words = text
        .split(|&byte| byte == b'\n')
        .filter_map(|line| line.split(u8::is_ascii_whitespace).find(|word| !word.is_empty()));
    let first = words.into_iter().find(|word| !word.starts_with(b"#"));
    first.is_some_and(|word| OBJ_WORDS.contains(&word))
}

/// Whether a text is a scene: it has a statement, perhaps misspelt, before any word of OBJ, or only comments.
pub(super) fn is_scene(text: &[u8]) -> bool {
    has_statement(text, |word| {
        is_statement(word) || nearest(word, names()).is_some()
    })
}

/// As [`is_scene`], but a misspelt statement does not count: for files with another extension, which hardly are scenes.
#[cfg(feature = "cli")]
pub(super) fn is_well_spelt(text: &[u8]) -> bool {
    has_statement(text, is_statement)
}

/// Whether the first word of a text, after comments, is a statement: foreign files may have such words further down.
#[cfg(feature = "cli")]
pub(super) fn begins_with_statement(text: &[u8]) -> bool {
    let text = text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(text);
    let words = text
        .split(|&byte| byte == b'\n')
        .filter_map(|line| line.split(u8::is_ascii_whitespace).find(|word| !word.is_empty()));
    let first = words.into_iter().find(|word| !word.starts_with(b"//"));
    first.is_some_and(is_statement)
}

/// The names of the statements.
fn names() -> impl Iterator<Item = &'static str> {
    STATEMENTS.iter().map(|(name, _)| *name)
}

fn is_statement(word: &[u8]) -> bool {
    names().any(|name| name.as_bytes() == word)
}

/// Whether a text has a statement before any word of OBJ, or only comments.
fn has_statement(text: &[u8], is_statement: impl Fn(&[u8]) -> bool) -> bool {
    let mut only_comments = true;
    for line in text.split(|&byte| byte == b'\n') {
        let line = line.trim_ascii();
        let word = line.split(u8::is_ascii_whitespace).next().unwrap_or_default();
        if word.is_empty() || word.starts_with(b"//") {
            continue;
        }
        if OBJ_WORDS.contains(&word) {
            return false;
        }
        if is_statement(word) {
            return true;
        }
        only_comments = false;
    }
    only_comments
}

/// The scene so far.
struct Reader<'a> {
    files: &'a mut dyn Files,
    budget: &'a Budget,
    /// The folder of the file that is being read.
    folder: PathBuf,
    builder: SceneBuilder,
    /// The current material. None before the first `material`: meshes have the materials of their files, other shapes have
    /// material 0.
    material: Option<MaterialId>,
    /// Whether colours and textures of meshes with their own materials are decoded.
    own_is_srgb: bool,
    meshes: Meshes,
    /// The meshes that are placed, which repetitions do not place again.
    placements: HashSet<PlacementKey>,
    /// How many statements place meshes, repetitions included.
    placing: usize,
    /// The prototypes of instances.
    prototypes: HashMap<PrototypeKey, PrototypeId>,
    /// How many cameras the meshes have.
    mesh_cameras: usize,
    /// How many notes there are about meshes.
    mesh_notes: usize,
    includes: Includes,
    seen: Seen,
    has_lights: bool,
    has_environment: bool,
    /// Whether the current material ignores light.
    is_silhouette: bool,
    /// Whether a shape is not a silhouette.
    needs_light: bool,
    /// The last statement, if it moves.
    moved: Option<Moved>,
    /// How many keyframes there are.
    keyframes: usize,
    /// The name of the last statement of this file.
    last_statement: &'static str,
}

/// The places of statements that a scene has at most once.
#[derive(Default)]
struct Seen {
    background: Option<Place>,
    ambient: Option<Place>,
    smooth_shadows: Option<Place>,
    ambient_specular: Option<Place>,
    /// By name.
    cameras: HashMap<Option<String>, Place>,
}

/// The place of a statement, and of the `include` statements that lead there. A file may be included twice.
struct Place {
    at: SourcePos,
    includes: Vec<SourcePos>,
}

impl Place {
    fn of(arguments: &Arguments<'_, '_>) -> Self {
        Self {
            at: arguments.line.at(arguments.keyword.start),
            includes: arguments.line.includes.to_vec(),
        }
    }
}

impl Seen {
    /// Remembers the place of a statement, and rejects a second one.
    fn once(seen: &mut Option<Place>, arguments: &Arguments<'_, '_>, what: &str) -> Result<(), LoadError> {
        if let Some(first) = seen {
            return Err(again(arguments, what, first));
        }
        *seen = Some(Place::of(arguments));
        Ok(())
    }
}

impl Reader<'_> {
    /// Reads the text of a file line by line.
    fn file(&mut self, text: &[u8], name: &Path, identity: PathBuf) -> Result<(), LoadError> {
        // Some editors put a byte order mark first.
        let text = text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(text);
        // An image or a binary mesh is refused as a whole, instead of by its first unknown word.
        foreign::refuse(text, name, "expected the text of a scene")?;
        refuse_binary(text, "the text of a scene").map_err(|fault| fault.into_error(text, name))?;
        if has_lone_returns(text) {
            return Err(LoadError::whole_file(name, LONE_RETURNS));
        }
        let file = Arc::new(name.to_path_buf());
        let folder = name.parent().unwrap_or(Path::new("")).to_path_buf();
        let outer_folder = std::mem::replace(&mut self.folder, folder);
        self.includes.enter(identity, name.to_path_buf());
        self.last_statement = "";
        let mut rest = text;
        let includes = self.includes.places();
        let mut progress = self.budget.parsing(text.len());
        for (i, bytes) in text.split(|&byte| byte == b'\n').enumerate() {
            let number = u32::try_from(i + 1).unwrap_or(u32::MAX);
            progress.at(text.len() - rest.len());
            rest = rest.get(bytes.len() + 1..).unwrap_or_default();
            self.line(&Line {
                file: &file,
                number,
                bytes,
                rest,
                includes: &includes,
            })?;
        }
        self.end_motion()?;
        self.last_statement = "include";
        self.includes.leave();
        self.folder = outer_folder;
        Ok(())
    }

    fn line(&mut self, line: &Line<'_>) -> Result<(), LoadError> {
        if line.bytes.len() > MAX_LINE {
            let message = format!(
                "line of {} bytes, expected at most {MAX_LINE}; is this a scene?",
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
            return Err(line.error_at(keyword, unknown_statement(keyword, line)));
        };
        if statement.0 != "at" {
            self.end_motion()?;
        }
        self.statement(Arguments::new(line, *keyword, arguments, statement))?;
        self.last_statement = statement.0;
        Ok(())
    }
}

/// The hint about comments of other languages.
const COMMENT_HINT: &str = "`#` does not start a comment, expected `//`";

/// Hints about words of other formats and languages.
fn hint(keyword: &[u8]) -> Option<&'static str> {
    match keyword {
        [b'#', ..] => Some(COMMENT_HINT),
        b"ply" => Some("this looks like a PLY mesh, expected a scene; `mesh PATH` places a mesh in a scene"),
        b"solid" => {
            Some("this looks like an STL mesh, expected a scene; `mesh PATH` places a mesh in a scene")
        }
        [b'{', ..] => {
            Some("this looks like a glTF mesh, expected a scene; `mesh PATH` places a mesh in a scene")
        }
        b"size" | b"samples" => {
            Some("this is an option of `octray render`, such as --size 800x600 or --samples 16")
        }
        word if OBJ_WORDS.contains(&word) => {
            Some("this looks like an OBJ mesh, expected a scene; `mesh PATH` places a mesh in a scene")
        }
        _ => None,
    }
}

fn unknown_statement(keyword: &Word<'_>, line: &Line<'_>) -> String {
    let found = quote(keyword.text);
    // Comments of OBJ begin with `#`, too.
    let is_obj = MeshFormat::of_path(line.file) == Some(MeshFormat::Obj)
        || keyword.text.starts_with(b"#") && is_obj(line.rest);
    let word: &[u8] = if is_obj { b"v" } else { keyword.text };
    if let Some(hint) = hint(word) {
        return format!("found {found}: {hint}");
    }
    let names = STATEMENTS.map(|(name, _)| name);
    match nearest(keyword.text, names) {
        Some(near) => format!("unknown statement {found}, did you mean `{near}`?"),
        None => format!("unknown statement {found}, expected {}", list(&names)),
    }
}

#[cfg(test)]
mod tests;

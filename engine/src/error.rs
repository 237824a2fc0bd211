//! Errors: place, what was found, what was expected.

mod kind;
mod text;

pub use kind::LoadErrorKind;
pub use text::{Excerpt, clip, clip_path, escape, in_bytes, quote};

#[doc(hidden)]
pub use text::decoder_reason;
#[doc(hidden)]
pub use text::io_reason;
#[doc(hidden)]
pub use text::is_unprintable;
#[doc(hidden)]
pub use text::short_number;

use std::{
    fmt,
    ops::Range,
    path::{Path, PathBuf},
    sync::Arc,
};

/// A place in a file: line and column, both 1-based; columns count bytes. Errors about binary data have neither.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourcePos {
    /// The file as it was named, relative to the current folder.
    pub file: Arc<PathBuf>,
    /// 1-based line; 0 if the error concerns the whole file.
    pub line: u32,
    /// 1-based column in bytes; 0 if the error concerns the whole line.
    pub column: u32,
}

impl SourcePos {
    /// The file as a whole.
    #[must_use]
    pub fn whole_file(file: &Path) -> Self {
        Self {
            file: Arc::new(file.to_path_buf()),
            line: 0,
            column: 0,
        }
    }

    /// Byte `offset` of `text`, which is the text of `file`.
    #[must_use]
    pub fn in_text(file: &Path, text: &[u8], offset: usize) -> Self {
        let line_start = line_around(text, offset).start;
        let before = text.get(..line_start).unwrap_or_default();
        let lines_before = before.iter().filter(|&&byte| byte == b'\n').count();
        let number = |zero_based: usize| u32::try_from(zero_based + 1).unwrap_or(u32::MAX);
        Self {
            file: Arc::new(file.to_path_buf()),
            line: number(lines_before),
            column: number(offset.min(text.len()) - line_start),
        }
    }
}

/// The line of `text` that holds byte `offset`, without its newline.
fn line_around(text: &[u8], offset: usize) -> Range<usize> {
    let (before, rest) = text.split_at(offset.min(text.len()));
    let is_newline = |&byte: &u8| byte == b'\n';
    let start = before.iter().rposition(is_newline).map_or(0, |i| i + 1);
    let end = before.len() + rest.iter().position(is_newline).unwrap_or(rest.len());
    start..end
}

impl fmt::Display for SourcePos {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&clip_path(&self.file))?;
        if self.line > 0 {
            write!(f, ":{}", self.line)?;
            if self.column > 0 {
                write!(f, ":{}", self.column)?;
            }
        }
        Ok(())
    }
}

/// Why [`SceneBuilder`](crate::scene::SceneBuilder) refused a part of a scene.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum SceneError {
    /// A number is NaN, infinite, or above [`MAX_COORDINATE`](crate::scene::MAX_COORDINATE), so that products of it could
    /// overflow.
    NotUsable {
        /// Which number: "x", "radius", ...
        what: &'static str,
        /// Its value.
        value: f32,
    },
    /// A length is zero or negative.
    NotPositive {
        /// Which length.
        what: &'static str,
        /// The value found.
        value: f32,
    },
    /// An intensity or a light's radius is negative.
    Negative {
        /// Which number.
        what: &'static str,
        /// The value found.
        value: f32,
    },
    /// A number is NaN or outside its range.
    OutOfRange {
        /// Which number: "red", "alpha", ...
        what: &'static str,
        /// Its value.
        value: f32,
        /// The smallest and the largest allowed number.
        range: (f32, f32),
    },
    /// The inner angle of a spot is NaN, negative, or above the outer one.
    InnerAngle {
        /// Degrees.
        inner: f32,
        /// Degrees.
        outer: f32,
    },
    /// A triangle has a vertex index beyond its mesh's vertices.
    VertexIndex {
        /// The triangle's index in the mesh, 0-based.
        triangle: usize,
        /// The vertex index found.
        index: u32,
        /// How many vertices the mesh has.
        vertices: usize,
    },
    /// A line has a vertex index beyond its mesh's vertices.
    LineIndex {
        /// The vertex index found.
        index: u32,
        /// How many vertices the mesh has.
        vertices: usize,
    },
    /// A mesh's arrays differ in length.
    ArrayLength {
        /// Which array.
        what: &'static str,
        /// Its length.
        found: usize,
        /// The length expected.
        expected: usize,
    },
    /// The scene has no such material.
    UnknownMaterial {
        /// The index found.
        index: u32,
        /// How many materials the scene has.
        materials: usize,
    },
    /// More of something than octray supports.
    TooMany {
        /// The plural of what it is, such as "vertices" or "keyframes".
        what: &'static str,
        /// The largest number allowed.
        limit: usize,
    },
    /// The scene needs more memory than its limit.
    OverLimit {
        /// A lower estimate of what it needs, in bytes.
        needed: u64,
        /// Its limit, in bytes.
        limit: u64,
    },
    /// The system refuses memory.
    NoMemory {
        /// What it is for, such as "triangles" or "environment".
        what: &'static str,
    },
    /// A transform makes a body flat, or nearly so.
    Flat,
    /// A prototype would hold an instance or another prototype.
    Nested,
    /// A keyframe is invalid, by itself or after the one before.
    Keyframe(String),
    /// An animated instance or camera has no valid transform at a time.
    AtTime {
        /// The time, in frames.
        time: f64,
        /// Where the file has its statement.
        place: Option<SourcePos>,
        /// Why it is invalid.
        why: String,
    },
    /// An image has no pixels, or a side longer than [`MAX_IMAGE_SIDE`](crate::scene::MAX_IMAGE_SIDE).
    ImageSize {
        /// Pixels.
        width: u32,
        /// Pixels.
        height: u32,
        /// The longest side allowed, pixels.
        most: u32,
    },
    /// A texture names an image that the scene does not have.
    UnknownImage {
        /// The index found.
        index: u32,
        /// How many images the scene has.
        images: usize,
    },
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotUsable { what, value } if value.is_finite() => {
                write!(f, "{what} is {value:e}, but numbers above 1e9 are not supported")
            }
            Self::NotUsable { what, value } => write!(f, "{what} is {value}, expected a finite number"),
            Self::NotPositive { what, value } => write!(f, "{what} is {value}, expected a number above 0"),
            Self::Negative { what, value } => write!(f, "{what} is {value}, expected 0 or more"),
            Self::InnerAngle { inner, outer } => write!(
                f,
                "inner is {inner}, expected a number from 0 to the outer angle, {outer}"
            ),
            Self::OutOfRange { what, value, range } => {
                write!(
                    f,
                    "{what} is {value}, expected a number from {} to {}",
                    range.0, range.1
                )
            }
            Self::VertexIndex { index, vertices, .. } | Self::LineIndex { index, vertices } => {
                write!(
                    f,
                    "vertex index {index}, but the mesh has only {vertices} vertices"
                )
            }
            Self::ArrayLength {
                what,
                found,
                expected,
            } => {
                write!(f, "{found} {what}, expected {expected}")
            }
            Self::UnknownMaterial { index, materials } => {
                write!(
                    f,
                    "material {index}, expected 0 to {}",
                    materials.saturating_sub(1)
                )
            }
            Self::OverLimit { needed, limit } => write!(
                f,
                "the scene takes about {} of memory or more, BVH included, above the memory limit of {}",
                in_bytes(*needed),
                in_bytes(*limit)
            ),
            Self::Nested => f.write_str("a prototype cannot hold instances or other prototypes"),
            Self::Flat => f.write_str("the transform flattens it, expected an invertible one"),
            Self::Keyframe(why) => f.write_str(why),
            Self::AtTime { time, place, why } => {
                if let Some(place) = place {
                    write!(f, "{place}: ")?;
                }
                write!(f, "at {time}: {why}")
            }
            Self::NoMemory { what } => write!(f, "not enough memory for the {what}"),
            Self::ImageSize { width, height, most } => write!(
                f,
                "an image of {width}x{height} pixels, expected sides from 1 to {most}"
            ),
            Self::UnknownImage { index, images } => {
                write!(f, "image {index}, expected less than {images}")
            }
            Self::TooMany { what, limit } => write!(f, "more than {limit} {what}"),
        }
    }
}

impl std::error::Error for SceneError {}

/// Why a file could not be loaded, and where.
///
/// `Display` gives the place, what was found and what was expected, then the causes, one line each. It contains no
/// characters that a terminal would obey. [`LoadError::report`] adds the faulty lines with carets below.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoadError {
    /// Where the fault is.
    pub at: SourcePos,
    /// What is wrong; safe to print.
    pub message: String,
    /// The line of the fault, if there is one to show.
    pub excerpt: Option<Excerpt>,
    /// What caused it, perhaps in another file.
    pub cause: Option<Box<LoadError>>,
    kind: LoadErrorKind,
}

/// Words of serde_json, and those of JSON.
const JSON_WORDS: [(&str, &str); 7] = [
    ("type: map", "type: object"),
    ("type: sequence", "type: array"),
    ("expected a sequence", "expected an array"),
    ("expected a map", "expected an object"),
    ("expected f64", "expected a number"),
    ("expected f32", "expected a number"),
    ("expected u32", "expected a whole number"),
];

impl LoadError {
    /// A fault at a place, without a line to show. `message` is escaped for terminals, and cut if it is long.
    #[must_use]
    pub fn new(at: SourcePos, message: impl AsRef<str>) -> Self {
        Self {
            at,
            message: message_text(message.as_ref()),
            excerpt: None,
            cause: None,
            kind: LoadErrorKind::Invalid,
        }
    }

    /// A fault of the bytes `range` of `text`, which is the text of `file`. Shows their line.
    #[must_use]
    pub fn in_text(file: &Path, text: &[u8], range: Range<usize>, message: impl AsRef<str>) -> Self {
        let line = line_around(text, range.start);
        let start = range.start.min(text.len()) - line.start;
        let width = range.end.min(line.end).saturating_sub(range.start).max(1);
        let at = SourcePos::in_text(file, text, range.start);
        Self::new(at, message).with_line(text.get(line).unwrap_or_default(), start..start + width)
    }

    /// A fault of a file as a whole.
    #[must_use]
    pub fn whole_file(file: &Path, message: impl AsRef<str>) -> Self {
        Self::new(SourcePos::whole_file(file), message)
    }

    /// A fault that serde_json found at this line and column. Its message repeats the place, and may quote much of the file.
    #[doc(hidden)]
    pub fn in_json(file: &Path, [line, column]: [usize; 2], what: &str, message: &str) -> Self {
        let at = SourcePos {
            file: Arc::new(file.to_path_buf()),
            line: line as u32,
            column: column as u32,
        };
        let message = message.split(" at line ").next().unwrap_or_default();
        let message: String = if message.starts_with("EOF while parsing") {
            "the file is cut short".to_owned()
        } else if let Some((found, _)) = message.split_once("expected struct ") {
            format!(
                "{}expected an object",
                found.chars().take(120).collect::<String>()
            )
        } else {
            let message: String = message.chars().take(120).collect();
            JSON_WORDS
                .iter()
                .fold(message, |message, (theirs, ours)| message.replace(theirs, ours))
        };
        Self::new(at, format!("{what}: {message}"))
    }

    /// Adds the line of the fault; `word` is the faulty part of it, in bytes.
    #[must_use]
    pub fn with_line(self, line: &[u8], word: Range<usize>) -> Self {
        Self {
            excerpt: Some(Excerpt::new(line, word)),
            ..self
        }
    }

    /// Sets the kind, which is [`LoadErrorKind::Invalid`] otherwise.
    #[must_use]
    pub fn with_kind(self, kind: LoadErrorKind) -> Self {
        Self { kind, ..self }
    }

    /// Returns the kind of the fault: that of the last cause, if there are any.
    #[must_use]
    pub fn kind(&self) -> LoadErrorKind {
        self.chain().last().map_or(self.kind, |last| last.kind)
    }

    /// Adds the cause.
    #[must_use]
    pub fn caused_by(self, cause: Self) -> Self {
        Self {
            cause: Some(Box::new(cause)),
            ..self
        }
    }

    /// This error and all its causes.
    pub fn chain(&self) -> impl Iterator<Item = &Self> {
        std::iter::successors(Some(self), |error| error.cause.as_deref())
    }

    /// The error as compilers print it: each place, and its line with carets below; no newline at the end.
    #[must_use]
    pub fn report(&self) -> String {
        let mut report = String::new();
        for (depth, error) in self.chain().enumerate() {
            let prefix = if depth == 0 { "" } else { "\n  caused by: " };
            report.push_str(&format!("{prefix}{}: {}", error.at, error.message));
            if let Some(excerpt) = &error.excerpt {
                let number = error.at.line.to_string();
                let indent = " ".repeat(number.len() + if depth == 0 { 0 } else { 2 });
                let number = format!("{number:>width$}", width = indent.len());
                report.push_str(&format!("\n{indent} |\n{number} | {}", excerpt.text()));
                report.push_str(&format!("\n{indent} | {}", excerpt.carets()));
            }
        }
        report
    }
}

/// A message that is safe to print, although it may quote a file.
fn message_text(message: &str) -> String {
    const MOST: usize = 1000;
    match message.char_indices().nth(MOST) {
        Some((end, _)) => format!("{}...", escape(message.get(..end).unwrap_or_default())),
        None => escape(message).into_owned(),
    }
}

impl fmt::Display for LoadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (depth, error) in self.chain().enumerate() {
            let prefix = if depth == 0 { "" } else { "\n  caused by: " };
            write!(f, "{prefix}{}: {}", error.at, error.message)?;
        }
        Ok(())
    }
}

/// [`Display`](fmt::Display) shows the causes, so there is no [`source`](std::error::Error::source): programs that print both
/// would show them twice.
impl std::error::Error for LoadError {}

#[cfg(test)]
mod tests;

//! Makes text of files safe to print.

use std::{borrow::Cow, io, ops::Range, path::Path};

/// How much of a name or a value a message repeats, in characters.
const VALUE_LIMIT: usize = 200;
/// How much of a word a message repeats, in characters.
const WORD_LIMIT: usize = 40;
/// How much of a line is shown, in characters.
const LINE_LIMIT: usize = 76;
/// How much of a long line is shown before the fault, in characters.
const LEAD: usize = 30;
/// Marks where a line or word was cut.
const CUT: &str = "...";

/// Whether a terminal would obey this character, hide it, or print the text after it in another order: controls,
/// separators of lines and paragraphs, and Unicode's format characters and invisible letters. Also the spaces that do not
/// break lines: they look like others, but separate no words.
#[must_use]
pub fn is_unprintable(c: char) -> bool {
    c.is_control()
        || matches!(
            c,
            '\u{a0}' | '\u{ad}' | '\u{34f}' | '\u{600}'..='\u{605}' | '\u{61c}' | '\u{6dd}' | '\u{70f}' | '\u{890}'..='\u{891}'
            | '\u{8e2}' | '\u{115f}'..='\u{1160}' | '\u{17b4}'..='\u{17b5}' | '\u{180b}'..='\u{180f}'
            | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202f}' | '\u{2060}'..='\u{206f}' | '\u{3164}' | '\u{feff}'
            | '\u{ffa0}' | '\u{fff0}'..='\u{fffb}' | '\u{110bd}' | '\u{110cd}' | '\u{13430}'..='\u{1343f}'
            | '\u{1bca0}'..='\u{1bca3}' | '\u{1d173}'..='\u{1d17a}' | '\u{e0000}'..='\u{e0fff}'
        )
}

/// Escapes all characters of `text` that a terminal would obey.
#[must_use]
pub fn escape(text: &str) -> Cow<'_, str> {
    if !text.contains(is_unprintable) {
        return Cow::Borrowed(text);
    }
    let mut escaped = String::with_capacity(text.len() + 8);
    text.chars().for_each(|c| push_escaped(&mut escaped, c));
    Cow::Owned(escaped)
}

fn push_escaped(to: &mut String, c: char) {
    if is_unprintable(c) {
        to.extend(c.escape_default());
    } else {
        to.push(c);
    }
}

/// Escapes `text`, and cuts its middle out if it is long: paths differ at their ends.
#[must_use]
pub fn clip(text: &str) -> String {
    let (head, whole) = clipped(text.chars(), VALUE_LIMIT);
    if whole {
        return head.concat();
    }
    let (head, _) = clipped(text.chars(), VALUE_LIMIT / 2);
    let (mut tail, _) = clipped(text.chars().rev(), VALUE_LIMIT / 2 - CUT.len());
    tail.reverse();
    format!("{}{CUT}{}", head.concat(), tail.concat())
}

/// A path as messages show it: as [`clip`].
#[must_use]
pub fn clip_path(path: &Path) -> String {
    clip(&path.to_string_lossy())
}

/// The first characters, escaped, at most `most` letters of them; whether these are all.
fn clipped(characters: impl Iterator<Item = char>, most: usize) -> (Vec<String>, bool) {
    let (mut pieces, mut length) = (Vec::new(), 0);
    for c in characters {
        let mut piece = String::new();
        push_escaped(&mut piece, c);
        length += piece.chars().count();
        if length > most {
            return (pieces, false);
        }
        pieces.push(piece);
    }
    (pieces, true)
}

/// Why a file could not be used, in words without an error number.
#[doc(hidden)]
pub fn io_reason(error: &io::Error) -> String {
    use io::ErrorKind as Kind;
    let words = match error.kind() {
        // Somebody has given it words.
        _ if error.get_ref().is_some() => return error.to_string(),
        Kind::NotFound => "file not found",
        Kind::PermissionDenied => "permission denied",
        Kind::ReadOnlyFilesystem => "the file system is read-only",
        Kind::StorageFull => "no space left on the device",
        Kind::QuotaExceeded => "the disk quota is used up",
        Kind::FileTooLarge => "the file would be too large",
        Kind::InvalidFilename => "the name is too long or not allowed",
        Kind::IsADirectory => "it is a directory",
        Kind::NotADirectory => "a part of the path is not a directory",
        Kind::AlreadyExists => "it exists already",
        Kind::OutOfMemory => "the file does not fit into memory",
        Kind::UnexpectedEof => CUT_SHORT,
        _ => {
            let system = error.to_string();
            let system = system.split(" (os error").next().unwrap_or_default();
            return system.to_lowercase();
        }
    };
    words.to_owned()
}

/// The error about a file that ends early.
const CUT_SHORT: &str = "the file is cut short";

/// The message of a decoder of images. Each has its own words for a file that ends early.
#[doc(hidden)]
pub fn decoder_reason(message: &str) -> String {
    const ENDS: [&str; 4] = [
        "failed to fill whole buffer",
        "unexpected eof",
        "unexpected end of file",
        "no more bytes",
    ];
    let message = message.to_lowercase();
    if ENDS.iter().any(|end| message.contains(end)) {
        return CUT_SHORT.to_owned();
    }
    message
}

/// A number without long rows of zeros: very large and very small ones have an exponent.
#[must_use]
pub fn short_number(value: f64) -> String {
    if value == 0.0 || (1e-5..1e16).contains(&value.abs()) {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}

/// A word of a file in backquotes, escaped, and cut if it is long.
#[must_use]
pub fn quote(word: &[u8]) -> String {
    // A character has at most four bytes.
    let head = word.get(..WORD_LIMIT * 4).unwrap_or(word);
    let mut quoted = String::from("`");
    let mut rest = WORD_LIMIT;
    let mut cut = head.len() < word.len();
    for piece in pieces(head) {
        if rest == 0 {
            cut = true;
            break;
        }
        quoted.push_str(&piece.text);
        rest -= 1;
    }
    if cut {
        quoted.push_str(CUT);
    }
    quoted.push('`');
    quoted
}

/// A character of a file, or a byte that is not UTF-8.
struct Piece {
    text: String,
    bytes: usize,
}

fn pieces(bytes: &[u8]) -> impl Iterator<Item = Piece> {
    bytes.utf8_chunks().flat_map(|chunk| {
        let valid = chunk.valid().chars().map(|c| {
            let mut text = String::new();
            push_escaped(&mut text, c);
            Piece {
                text,
                bytes: c.len_utf8(),
            }
        });
        let invalid = chunk.invalid().iter().map(|byte| Piece {
            text: format!("\\x{byte:02x}"),
            bytes: 1,
        });
        valid.chain(invalid)
    })
}

/// A line of a file, escaped and cut, with the faulty part of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Excerpt {
    text: String,
    caret: usize,
    width: usize,
}

impl Excerpt {
    /// The part of `line` around its bytes `at`.
    #[must_use]
    pub fn new(line: &[u8], at: Range<usize>) -> Self {
        // A line may be as long as the file: convert only what can be shown, at four bytes a character.
        let from = at.start.min(line.len()).saturating_sub(4 * LINE_LIMIT);
        let to = line.len().min(at.start.saturating_add(4 * LINE_LIMIT));
        let window = line.get(from..to).unwrap_or_default();
        let window = window.trim_ascii_end();

        let (mut characters, mut caret, mut end) = (Vec::new(), None, None);
        let mut byte = from;
        for piece in pieces(window) {
            if byte >= at.start && caret.is_none() {
                caret = Some(characters.len());
            }
            if byte >= at.end && end.is_none() {
                end = Some(characters.len());
            }
            // A tab takes one column, so that the caret lines up.
            match piece.text.as_str() {
                "\\t" => characters.push(' '),
                text => characters.extend(text.chars()),
            }
            byte += piece.bytes;
        }
        // Beyond the end of the line, the caret stands right after it.
        let caret = caret.unwrap_or(characters.len());
        let end = end.unwrap_or(characters.len());

        let mut skipped = 0;
        if from > 0 || characters.len() > LINE_LIMIT {
            skipped = caret.saturating_sub(LEAD);
        }
        let shown = &characters[skipped..];
        let cut_left = from > 0 || skipped > 0;
        let cut_right = to < line.trim_ascii_end().len() || shown.len() > LINE_LIMIT;
        let shown = &shown[..shown.len().min(LINE_LIMIT)];

        let mut text = String::new();
        if cut_left {
            text.push_str(CUT);
        }
        let caret_in_text = text.len() + caret - skipped;
        text.extend(shown);
        let width = end.min(skipped + shown.len()).saturating_sub(caret).max(1);
        if cut_right {
            text.push_str(CUT);
        }
        Self {
            text,
            caret: caret_in_text,
            width,
        }
    }

    /// The line, ready to print.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The line of carets to print below it.
    #[must_use]
    pub fn carets(&self) -> String {
        format!("{}{}", " ".repeat(self.caret), "^".repeat(self.width))
    }
}

/// A number of bytes with a fitting unit.
#[must_use]
pub fn in_bytes(number: u64) -> String {
    let mut value = number as f64;
    if number < 1024 {
        return format!("{number} B");
    }
    let mut unit = "B";
    for larger in ["KiB", "MiB", "GiB", "TiB"] {
        if value < 1024.0 {
            break;
        }
        value /= 1024.0;
        unit = larger;
    }
    format!("{value:.1} {unit}")
}

#[cfg(test)]
mod tests;

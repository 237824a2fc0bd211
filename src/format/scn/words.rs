//! Splits a line into words and remembers where they are.

use crate::error::quote;

/// A word of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Word<'a> {
    /// The word, without quotes.
    pub(super) text: &'a [u8],
    /// Where it starts in the line, including its quote, in bytes.
    pub(super) start: usize,
    /// Whether it has quotes.
    pub(super) quoted: bool,
}

impl<'a> Word<'a> {
    /// The word's length in the line, in bytes.
    pub(super) fn width(&self) -> usize {
        self.text.len() + if self.quoted { 2 } else { 0 }
    }

    /// Where the word ends in the line, in bytes.
    pub(super) fn end(&self) -> usize {
        self.start + self.width()
    }

    /// The word for messages that expected another number: numbers are not quoted.
    pub(super) fn number(&self) -> String {
        let quoted = quote(self.text);
        match self.as_str().and_then(|text| text.parse::<f64>().ok()) {
            Some(_) => quoted.trim_matches('`').to_owned(),
            None => quoted,
        }
    }

    /// The word as text; `None` if it is not UTF-8.
    pub(super) fn as_str(&self) -> Option<&'a str> {
        std::str::from_utf8(self.text).ok()
    }
}

/// Why a line cannot be split.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Fault {
    /// Where, in bytes.
    pub(super) start: usize,
    /// What is wrong.
    pub(super) message: &'static str,
}

/// What a word of a line may be.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// A word, in which quotes have no meaning.
    Plain,
    /// A name, which may be in double quotes.
    Name,
    /// A path, which may be in double quotes and contain `//`.
    Path,
}

impl Kind {
    /// The kind of the word after `words`.
    fn next(words: &[Word<'_>]) -> Self {
        match words.first().map(|statement| statement.text) {
            Some(b"ply_file" | b"mesh" | b"instance" | b"environment" | b"include") if words.len() == 1 => {
                Self::Path
            }
            Some(b"camera") if words.len() == 1 => Self::Name,
            Some(b"instance") if words.len() > 2 => match words.last() {
                Some(key) if key.text == b"placements" => Self::Path,
                _ => Self::Plain,
            },
            _ => Self::Plain,
        }
    }
}

/// Splits a line at spaces and tabs, up to a `//` comment.
///
/// The paths of statements and of `placements` and the name of a `camera` may be in double quotes and then contain spaces
/// and `//`. A path without quotes may contain `//` after its first character (`..//mesh.ply`).
pub(super) fn split(line: &[u8]) -> Result<Vec<Word<'_>>, Fault> {
    let mut words: Vec<Word<'_>> = Vec::new();
    let mut at = 0;
    loop {
        at += line.get(at..).map_or(0, blanks);
        let rest = line.get(at..).unwrap_or_default();
        if rest.is_empty() || rest.starts_with(b"//") {
            return Ok(words);
        }
        let kind = Kind::next(&words);
        let word = match rest {
            [b'"', inside @ ..] if kind != Kind::Plain => quoted(inside, at, kind)?,
            _ => Word {
                text: rest.get(..plain_length(rest, kind == Kind::Path)).unwrap_or(rest),
                start: at,
                quoted: false,
            },
        };
        at = word.end();
        words.push(word);
    }
}

fn blanks(rest: &[u8]) -> usize {
    rest.iter().take_while(|byte| byte.is_ascii_whitespace()).count()
}

fn plain_length(rest: &[u8], is_path: bool) -> usize {
    rest.iter()
        .enumerate()
        .position(|(i, byte)| {
            byte.is_ascii_whitespace() || (!is_path && rest.get(i..).is_some_and(|r| r.starts_with(b"//")))
        })
        .unwrap_or(rest.len())
}

fn quoted(inside: &[u8], start: usize, kind: Kind) -> Result<Word<'_>, Fault> {
    let length = inside.iter().position(|&byte| byte == b'"').ok_or(Fault {
        start,
        message: if kind == Kind::Name {
            "the name has no closing quote, expected `\"` before the end of the line"
        } else {
            "the path has no closing quote, expected `\"` before the end of the line"
        },
    })?;
    let (text, behind) = inside.split_at(length);
    let next = behind.get(1).copied();
    if next.is_some_and(|byte| !byte.is_ascii_whitespace() && byte != b'/') {
        return Err(Fault {
            start: start + length + 2,
            message: "text directly after the closing quote, expected a space or the end of the line",
        });
    }
    Ok(Word {
        text,
        start,
        quoted: true,
    })
}

#[cfg(test)]
mod tests;

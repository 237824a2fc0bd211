//! OFF files in free format: several vertices or faces in a line, or one over several lines. Only the colour of a face ends with
//! its line.
//!
//! They are rare, so they are rewritten for the reader of lines: all words stay where they are, as do the places of faults, but
//! line ends move.

use super::{Header, Lines, after_mark};

/// How vertices are separated.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Vertices {
    /// By line ends: they may have colours that the header does not tell of.
    Lines,
    /// By the count of their numbers.
    Numbers,
    /// By their count, too, and all numbers of the file are used: the surest division.
    All,
}

/// The text with each vertex and each face in a line; `None` if it does not have the vertices and faces that its header counts.
/// The faces must begin with a line or end with the text: otherwise a missing number would be taken from the next line
/// unnoticed.
pub(super) fn in_lines(text: &[u8], vertices: Vertices) -> Option<Vec<u8>> {
    let start = after_mark(text);
    let mut free = Free {
        text: without_comments(text),
        at: start,
    };
    let first = free.word()?;
    // Digits may follow `OFF` at once, which may be missing.
    let counts = if free.text[first].ends_with(b"OFF") { 3 } else { 2 };
    free.words(counts)?;
    let line = &free.text[..free.at];
    let header = Header::read(&mut Lines {
        text: line,
        at: start,
    })
    .ok()?;
    let more = |is_there: bool, numbers: usize| if is_there { numbers } else { 0 };
    let numbers = 3 + more(header.has_normals, 3) + more(header.has_colors, 4) + more(header.has_uvs, 2);
    for _ in 0..header.vertices {
        match vertices {
            Vertices::Lines => {
                free.line_of(|free| free.word().map(drop))?;
                free.end_line();
            }
            Vertices::Numbers | Vertices::All => free.line_of(|free| free.words(numbers))?,
        }
    }
    let is_whole = free.ends_with_faces(header.faces);
    if vertices == Vertices::All && !is_whole {
        return None;
    }
    let have_lines = !is_whole && free.have_lines(header.faces);
    for _ in 0..header.faces {
        free.line_of(|free| {
            let corners = free.word()?;
            let corners = std::str::from_utf8(&free.text[corners]).ok()?;
            free.words(corners.parse().ok()?)
        })?;
        if have_lines {
            free.end_line();
        }
    }
    (have_lines || free.word().is_none()).then_some(free.text)
}

fn without_comments(text: &[u8]) -> Vec<u8> {
    let mut text = text.to_vec();
    for line in text.split_mut(is_line_end) {
        if let Some(at) = line.iter().position(|&byte| byte == b'#') {
            line[at..].fill(b' ');
        }
    }
    text
}

fn is_line_end(byte: &u8) -> bool {
    matches!(byte, b'\n' | b'\r')
}

/// A text whose line ends move.
struct Free {
    text: Vec<u8>,
    /// The end of what was read.
    at: usize,
}

impl Free {
    /// The place of the next word. Line ends before it become spaces.
    fn word(&mut self) -> Option<std::ops::Range<usize>> {
        let rest = self.text.get_mut(self.at..)?;
        let start = rest.iter().position(|byte| !byte.is_ascii_whitespace())?;
        rest[..start].fill(b' ');
        let length = rest[start..].iter().position(u8::is_ascii_whitespace);
        let start = self.at + start;
        self.at = length.map_or(self.text.len(), |length| start + length);
        Some(start..self.at)
    }

    fn words(&mut self, count: usize) -> Option<()> {
        (0..count).try_for_each(|_| self.word().map(drop))
    }

    /// Puts what is read into a line of its own.
    fn line_of(&mut self, read: impl FnOnce(&mut Self) -> Option<()>) -> Option<()> {
        let start = self.at;
        read(self)?;
        // A space: words were read before and after it.
        self.text[start] = b'\n';
        Some(())
    }

    /// Reads up to the line's end.
    fn end_line(&mut self) {
        let rest = &self.text[self.at..];
        self.at += rest.iter().position(is_line_end).unwrap_or(rest.len());
    }

    /// Whether as many faces follow, and nothing else: then no word is part of a colour.
    fn ends_with_faces(&self, count: usize) -> bool {
        let rest = &self.text[self.at..];
        let mut words = rest
            .split(u8::is_ascii_whitespace)
            .filter(|word| !word.is_empty());
        for _ in 0..count {
            let corners = words
                .next()
                .and_then(|word| std::str::from_utf8(word).ok()?.parse().ok());
            let is_whole = match corners {
                None => false,
                Some(0) => true,
                Some(corners) => words.by_ref().nth(corners - 1_usize).is_some(),
            };
            if !is_whole {
                return false;
            }
        }
        words.next().is_none()
    }

    /// Whether the line is at its end, and as many lines with words follow.
    fn have_lines(&self, count: usize) -> bool {
        let has_words = |line: &[u8]| !line.trim_ascii().is_empty();
        let mut lines = self.text[self.at..].split(is_line_end);
        !lines.next().is_some_and(has_words) && lines.filter(|line| has_words(line)).count() >= count
    }
}

//! Makes text of files safe to print.

use std::{borrow::Cow, ops::Range};

/// How much of a word a message repeats, in characters.
const WORD_LIMIT: usize = 40;
/// How much of a line is shown, in characters.
const LINE_LIMIT: usize = 76;
/// How much of a long line is shown before the fault, in characters.
const LEAD: usize = 30;
/// Marks where a line or word was cut.
const CUT: &str = "...";

/// Whether a terminal would obey this character, or print the text after it in another order.
fn is_unprintable(c: char) -> bool {
    c.is_control() || matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
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
mod tests {
    use super::*;

    #[test]
    fn words_are_escaped_and_cut() {
        assert_eq!(quote(b"sphere"), "`sphere`");
        assert_eq!(quote(b"\x1b[31mred\xff\x00"), "`\\u{1b}[31mred\\xff\\u{0}`");
        assert_eq!(quote("caf\u{e9}\u{202e}".as_bytes()), "`caf\u{e9}\\u{202e}`");
        assert_eq!(quote(&[b'a'; 100]), format!("`{}...`", "a".repeat(40)));
        assert_eq!(quote(&[b'a'; 1000]), format!("`{}...`", "a".repeat(40)));
        assert_eq!(
            quote("\u{20ac}".repeat(40).as_bytes()),
            format!("`{}`", "\u{20ac}".repeat(40))
        );
    }

    #[test]
    fn the_caret_stands_below_the_word() {
        let excerpt = Excerpt::new(b"\tsphere  0 x 1 1  ", 11..12);
        assert_eq!(excerpt.text(), " sphere  0 x 1 1");
        assert_eq!(excerpt.carets(), "           ^");
        let behind = Excerpt::new(b"light 1 2\r", 9..9);
        assert_eq!(
            (behind.text(), behind.carets().as_str()),
            ("light 1 2", "         ^")
        );
        let escaped = Excerpt::new(b"\x07\xff bad", 3..6);
        assert_eq!(escaped.text(), "\\u{7}\\xff bad");
        assert_eq!(escaped.carets(), "          ^^^");
        assert_eq!(Excerpt::new(b"", 0..0).carets(), "^");
        assert_eq!(Excerpt::new(b"ab", 90..95).carets(), "  ^");
    }

    #[test]
    fn a_long_line_is_cut_around_the_word() {
        let mut line = vec![b'a'; 5000];
        line[3000..3004].copy_from_slice(b"WORD");
        let excerpt = Excerpt::new(&line, 3000..3004);
        assert!(excerpt.text().len() <= LINE_LIMIT + 2 * CUT.len());
        assert!(excerpt.text().starts_with("...aaa") && excerpt.text().ends_with("aaa..."));
        assert_eq!(excerpt.text().find("WORD"), excerpt.carets().find('^'));
        assert_eq!(excerpt.carets().trim_start(), "^^^^");
        let whole = Excerpt::new(&line, 0..5000);
        assert!(whole.carets().len() <= LINE_LIMIT);
        assert!(whole.text().ends_with("aaa..."));
    }
}

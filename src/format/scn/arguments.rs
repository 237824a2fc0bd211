//! Takes the words of a statement in order: numbers, keys and the numbers of keys.

use super::{
    COMMENT_HINT,
    line::Line,
    nearest::{list, list_or_end, nearest},
    words::Word,
};
use crate::{
    error::{LoadError, SceneError, quote},
    scene::{Background, MAX_COORDINATE},
};
use glam::DVec3;
use std::str::FromStr;

/// Words of other programs for keys.
const SYNONYMS: [(&[&[u8]], &str); 6] = [
    (&[b"color", b"colour", b"rgb", b"diffuse", b"albedo"], "cd"),
    (&[b"specular"], "cs"),
    (&[b"shininess", b"exponent"], "alpha"),
    (&[b"position", b"from"], "eye"),
    (&[b"lookat", b"look_at", b"to"], "target"),
    (&[b"move", b"position"], "translate"),
];

/// The words of a statement after the first.
pub(super) struct Arguments<'l, 'a> {
    pub(super) line: &'l Line<'l>,
    /// The statement's first word.
    pub(super) keyword: Word<'a>,
    /// How to write the statement.
    usage: &'static str,
    /// The statement's name in errors about keys.
    pub(super) name: &'static str,
    /// A hint for errors about an unexpected word.
    pub(super) hint: &'static str,
    /// Keys that the statement must have.
    pub(super) needs: &'static [&'static str],
    words: &'l [Word<'a>],
    /// Keys taken so far.
    seen: Vec<&'static str>,
}

/// What errors say about a number that is not 0 as it is written.
pub(super) const IN_SINGLE_PRECISION: &str = ", which is 0 in single precision";

/// Whether a word is another number than 0. As `f32` it may be 0.
pub(super) fn is_not_0(word: Word<'_>) -> bool {
    let number = word.as_str().and_then(|text| text.parse::<f64>().ok());
    number.is_some_and(|number| number != 0.0)
}

impl<'l, 'a> Arguments<'l, 'a> {
    pub(super) fn new(
        line: &'l Line<'l>,
        keyword: Word<'a>,
        words: &'l [Word<'a>],
        (name, usage): (&'static str, &'static str),
    ) -> Self {
        Self {
            line,
            keyword,
            usage,
            name,
            hint: "",
            needs: &[],
            words,
            seen: Vec::new(),
        }
    }

    /// The next word, without taking it.
    pub(super) fn peek(&self) -> Option<Word<'a>> {
        self.words.first().copied()
    }

    /// The word after the next one, without taking it.
    pub(super) fn peek_second(&self) -> Option<Word<'a>> {
        self.words.get(1).copied()
    }

    /// Takes the next word.
    pub(super) fn next(&mut self) -> Option<Word<'a>> {
        let (first, rest) = self.words.split_first()?;
        self.words = rest;
        Some(*first)
    }

    /// Takes the words that every such statement begins with.
    pub(super) fn leading<const N: usize>(&mut self) -> Result<[Word<'a>; N], LoadError> {
        self.take(self.keyword, self.usage)
    }

    /// Takes the `N` words after `owner`; `usage` shows how to write them.
    pub(super) fn take<const N: usize>(
        &mut self,
        owner: Word<'_>,
        usage: &str,
    ) -> Result<[Word<'a>; N], LoadError> {
        if let Some((taken, rest)) = self.words.split_first_chunk() {
            self.words = rest;
            return Ok(*taken);
        }
        let end = self.words.last().unwrap_or(&owner).end();
        let name = quote(owner.text);
        let message = match self.words.len() {
            0 => format!("nothing follows {name}, expected `{usage}`"),
            found => {
                let comma = self.words.iter().any(|word| word.text.contains(&b','));
                let is_named = !matches!(self.words[0].text, [b'-' | b'+' | b'.' | b'0'..=b'9', ..]);
                let hint = if comma {
                    ", with spaces instead of commas"
                } else if is_named && usage.ends_with("r g b") {
                    ", a colour as three numbers such as `1 0.5 0`"
                } else {
                    ""
                };
                format!("{name} with {found} of {N} values, expected `{usage}`{hint}")
            }
        };
        Err(self.line.error(end, 1, message))
    }

    /// Refuses further words.
    pub(super) fn end(&self) -> Result<(), LoadError> {
        let Some(extra) = self.peek() else {
            return Ok(());
        };
        let message = format!(
            "found {} after `{}`, expected the end of the line{}",
            quote(extra.text),
            self.usage,
            self.hint
        );
        Err(self.unexpected(&extra, message))
    }

    /// The error about a word that does not belong here.
    pub(super) fn unexpected(&self, word: &Word<'_>, message: String) -> LoadError {
        let message = if word.text.starts_with(b"#") {
            format!("found {}: {COMMENT_HINT}", quote(word.text))
        } else {
            message
        };
        self.line.error_at(word, message)
    }

    /// Takes the next key, one of `keys`; `None` at the end of the line.
    pub(super) fn key(
        &mut self,
        keys: &[&'static str],
    ) -> Result<Option<(Word<'a>, &'static str)>, LoadError> {
        let Some(word) = self.next() else {
            return Ok(None);
        };
        if let Some(key) = keys.iter().find(|key| key.as_bytes() == word.text) {
            return Ok(Some((word, key)));
        }
        let found = quote(word.text);
        let is_meant = |key: &&str| {
            let same = |(words, known): &(&[&[u8]], &str)| known == key && words.contains(&word.text);
            SYNONYMS.iter().any(same)
        };
        let meant = keys.iter().copied().find(is_meant);
        let message = match meant.or_else(|| nearest(word.text, keys.iter().copied())) {
            Some(near) => format!("unknown key {found} of `{}`, did you mean `{near}`?", self.name),
            None => format!(
                "found {found} in `{}`, expected {}{}",
                self.name,
                if self.needs.iter().all(|key| self.seen.contains(key)) {
                    list_or_end(keys)
                } else {
                    list(keys)
                },
                self.hint
            ),
        };
        Err(self.unexpected(&word, message))
    }

    /// As [`Arguments::key`], for keys that a statement has at most once.
    pub(super) fn key_once(
        &mut self,
        keys: &[&'static str],
    ) -> Result<Option<(Word<'a>, &'static str)>, LoadError> {
        let taken = self.key(keys)?;
        if let Some((word, key)) = taken {
            if self.seen.contains(&key) {
                let message = format!("second `{key}` in this line, expected one");
                return Err(self.line.error_at(&word, message));
            }
            self.seen.push(key);
        }
        Ok(taken)
    }

    /// The error about a missing `key`.
    pub(super) fn missing(&self, key: &str, end: usize) -> LoadError {
        let message = format!(
            "{} without `{key}`, expected `{}`",
            quote(self.keyword.text),
            self.usage
        );
        self.line.error(end, 1, message)
    }

    /// A number, at most as large as coordinates.
    pub(super) fn number(&self, word: Word<'_>, what: &str) -> Result<f32, LoadError> {
        self.limited(word, what)
    }

    fn limited<T: FromStr + Copy + Into<f64>>(&self, word: Word<'_>, what: &str) -> Result<T, LoadError> {
        let value = word.as_str().and_then(|text| text.parse::<T>().ok());
        let is_large = || word.text.iter().any(u8::is_ascii_digit);
        match value {
            Some(value) if value.into().abs() <= f64::from(MAX_COORDINATE) => Ok(value),
            // Digits tell `1e999` from `inf`.
            Some(_) if is_large() => {
                let found = word.number();
                let message = format!("{what} is {found}, but numbers above 1e9 are not supported");
                Err(self.line.error_at(&word, message))
            }
            value => Err(self.not_a_number(word, what, value.is_some())),
        }
    }

    fn not_a_number(&self, word: Word<'_>, what: &str, is_number: bool) -> LoadError {
        let expected = if is_number { "a finite number" } else { "a number" };
        let text = word.as_str().unwrap_or_default();
        let point = text.replacen(',', ".", 1);
        let hint = match point.parse::<f64>() {
            Ok(_) if point != text => format!(" such as {point}"),
            _ => String::new(),
        };
        let message = format!("{what} is {}, expected {expected}{hint}", quote(word.text));
        self.line.error_at(&word, message)
    }

    /// Three numbers in `f32`.
    pub(super) fn numbers3(
        &self,
        [x, y, z]: [Word<'_>; 3],
        [name_x, name_y, name_z]: [&str; 3],
    ) -> Result<[f32; 3], LoadError> {
        Ok([
            self.number(x, name_x)?,
            self.number(y, name_y)?,
            self.number(z, name_z)?,
        ])
    }

    /// A colour: three numbers from 0 to 1.
    pub(super) fn color(&self, [r, g, b]: [Word<'_>; 3]) -> Result<[f32; 3], LoadError> {
        Ok([
            self.share(r, "red")?,
            self.share(g, "green")?,
            self.share(b, "blue")?,
        ])
    }

    /// Two colours, each after its key.
    pub(super) fn gradient(&mut self, usage: &str) -> Result<Background, LoadError> {
        let (mut bottom, mut top) = (None, None);
        let mut end = self.keyword.end();
        while let Some((word, key)) = self.key_once(&["bottom", "top"])? {
            let words = self.take(word, &format!("{key} r g b"))?;
            let color = self.color(words)?;
            end = words[2].end();
            *(if key == "top" { &mut top } else { &mut bottom }) = Some(color);
        }
        let missing = |key: &str| {
            let message = format!("`{}` without `{key}`, expected `{usage}`", self.name);
            self.line.error(end, 1, message)
        };
        Ok(Background {
            bottom: bottom.ok_or_else(|| missing("bottom"))?,
            top: top.ok_or_else(|| missing("top"))?,
        })
    }

    /// A number from 0 to 1.
    pub(super) fn share(&self, word: Word<'_>, what: &str) -> Result<f32, LoadError> {
        let value = self.number(word, what)?;
        if (0.0..=1.0).contains(&value) {
            return Ok(value);
        }
        let message = format!("{what} is {}, expected a number from 0 to 1", word.number());
        Err(self.line.error_at(&word, message))
    }

    /// A whole number in a range.
    pub(super) fn whole(&self, word: Word<'_>, what: &str, range: (u32, u32)) -> Result<u32, LoadError> {
        let value = word.as_str().and_then(|text| text.parse().ok());
        value
            .filter(|value| (range.0..=range.1).contains(value))
            .ok_or_else(|| {
                let message = format!(
                    "{what} is {}, expected a whole number from {} to {}",
                    word.number(),
                    range.0,
                    range.1
                );
                self.line.error_at(&word, message)
            })
    }

    /// A number in `f64`, for computations before rounding. At most as large as coordinates.
    pub(super) fn precise(&self, word: Word<'_>, what: &str) -> Result<f64, LoadError> {
        self.limited(word, what)
    }

    /// A point or direction in `f64`.
    pub(super) fn vector(&self, [x, y, z]: [Word<'_>; 3]) -> Result<DVec3, LoadError> {
        Ok(DVec3::new(
            self.precise(x, "x")?,
            self.precise(y, "y")?,
            self.precise(z, "z")?,
        ))
    }

    /// The builder's error, placed at the word with the name and value of the fault, else at the last word.
    pub(super) fn refused(&self, error: &SceneError, words: &[(&str, Word<'_>)]) -> LoadError {
        let last = words.last().map_or(self.keyword, |&(_, word)| word);
        let found = |what: &str, value: f32| {
            let mut words = words.iter();
            let word = words
                .find(|(name, word)| *name == what && self.number(*word, what).is_ok_and(|v| v == value));
            word.map_or(last, |&(_, word)| word)
        };
        let word = match *error {
            SceneError::NotUsable { what, value }
            | SceneError::NotPositive { what, value }
            | SceneError::Negative { what, value }
            | SceneError::OutOfRange { what, value, .. } => found(what, value),
            SceneError::InnerAngle { inner, .. } => found("inner", inner),
            SceneError::TooMany { .. } => self.keyword,
            _ => last,
        };
        let message = match error {
            SceneError::NotPositive { what, value: 0.0 } if words.iter().any(|(name, _)| name == what) => {
                let is_negative = word.text.starts_with(b"-");
                let rounded = if is_not_0(word) && !is_negative {
                    IN_SINGLE_PRECISION
                } else {
                    ""
                };
                format!("{what} is {}{rounded}, expected a number above 0", word.number())
            }
            error => error.to_string(),
        };
        self.line.error_at(&word, message).with_kind(error.into())
    }
}

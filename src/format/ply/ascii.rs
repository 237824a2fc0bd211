//! Reads the values of a text file.

use super::{
    faces::Faces,
    fault::{Fault, Place},
    header::Element,
    lines,
    rows::{Values, Wrong},
};
use crate::scene::TriangleMesh;
use serde_ply::ScalarType;
use std::ops::Range;

/// Reads words. A record starts on a new line, may take several lines, and ends at the end of a line, so that a missing
/// or extra number is found on its line or the next.
pub(super) struct Text<'a> {
    bytes: &'a [u8],
    at: usize,
    word: Range<usize>,
}

impl<'a> Text<'a> {
    /// Reads `bytes` from `at` on.
    pub(super) fn new(bytes: &'a [u8], at: usize) -> Self {
        Self {
            bytes,
            at,
            word: at..at,
        }
    }

    /// What has not been read.
    pub(super) fn rest(&self) -> &'a [u8] {
        self.bytes.get(self.at..).unwrap_or_default()
    }

    /// Skips `length` bytes.
    pub(super) fn pass(&mut self, length: usize) {
        self.at += length;
    }

    fn pass_blanks(&mut self, is_blank: impl Fn(u8) -> bool) {
        let rest = self.rest();
        self.at += rest
            .iter()
            .position(|&byte| !is_blank(byte))
            .unwrap_or(rest.len());
    }

    fn next_word(&mut self) -> Result<&'a [u8], Wrong> {
        self.pass_blanks(|byte| byte.is_ascii_whitespace());
        let rest = self.rest();
        let length = rest
            .iter()
            .position(u8::is_ascii_whitespace)
            .unwrap_or(rest.len());
        self.word = self.at..self.at + length;
        self.at += length;
        match rest.get(..length) {
            Some(word) if length > 0 => Ok(word),
            _ => {
                // The place is right after the last number, not after blank lines.
                let end = self.bytes.trim_ascii_end().len();
                self.word = end..end;
                Err(Wrong::End)
            }
        }
    }

    fn next_text(&mut self) -> Result<&'a str, Wrong> {
        std::str::from_utf8(self.next_word()?).map_err(|_| Wrong::NotANumber)
    }

    fn line_end(&self, from: usize) -> usize {
        let rest = self.bytes.get(from..).unwrap_or_default();
        from + rest.iter().position(|&byte| byte == b'\n').unwrap_or(rest.len())
    }
}

impl Values for Text<'_> {
    /// No space needs to follow the last number.
    const SPARE: usize = 1;

    fn real(&mut self, _scalar: ScalarType) -> Result<f32, Wrong> {
        // Parsed as `f32` for all types, so that a double is rounded once.
        self.next_text()?.parse().map_err(|_| Wrong::NotANumber)
    }

    fn double(&mut self, _scalar: ScalarType) -> Result<f64, Wrong> {
        self.next_text()?.parse().map_err(|_| Wrong::NotANumber)
    }

    fn whole(&mut self, scalar: ScalarType) -> Result<i64, Wrong> {
        let text = self.next_text()?;
        if let Ok(whole) = text.parse() {
            return Ok(whole);
        }
        let real: f64 = text.parse().map_err(|_| Wrong::NotANumber)?;
        match scalar {
            ScalarType::F32 | ScalarType::F64 => whole_of(real),
            _ => Err(Wrong::NotWhole),
        }
    }

    fn skip(&mut self, _scalar: ScalarType, count: usize) -> Result<(), Wrong> {
        (0..count).try_for_each(|_| self.next_word().map(|_| ()))
    }

    fn begin_record(&mut self) -> usize {
        self.pass_blanks(|byte| byte.is_ascii_whitespace());
        self.at
    }

    fn end_record(&mut self) -> bool {
        self.pass_blanks(|byte| byte.is_ascii_whitespace() && byte != b'\n');
        matches!(self.rest().first(), None | Some(b'\n'))
    }

    fn leftover(&self, start: usize, record: &str) -> Fault {
        let first_line_end = self.line_end(start);
        if first_line_end < self.at {
            let message = format!("the line ends inside {record}, expected more numbers");
            return Fault::text(first_line_end..first_line_end, message);
        }
        let rest = self.rest();
        let length = rest
            .iter()
            .position(u8::is_ascii_whitespace)
            .unwrap_or(rest.len());
        let found = crate::error::quote(rest.get(..length).unwrap_or_default());
        let message = format!("found {found} after {record}, expected the end of the line");
        Fault::text(self.at..self.at + length, message)
    }

    fn bytes_left(&self) -> usize {
        self.rest().len()
    }

    fn least_bytes(_scalar: ScalarType) -> usize {
        // A digit and a space.
        2
    }

    fn last_word(&self) -> Option<&[u8]> {
        self.bytes.get(self.word.clone())
    }

    fn place(&self, start: usize, whole_record: bool) -> Place {
        if whole_record {
            let end = self.line_end(start);
            let blanks = self.bytes.get(start..end).unwrap_or_default();
            Place::Text(start..start + blanks.trim_ascii_end().len())
        } else {
            Place::Text(self.word.clone())
        }
    }

    fn where_in_file(&self, _record: &str, _start: usize) -> String {
        String::new()
    }

    fn fast_vertices(
        &mut self,
        element: &Element,
        mesh: &mut TriangleMesh,
        faces: &mut Faces<'_>,
    ) -> Result<bool, Fault> {
        lines::vertices(self, element, mesh, faces)
    }

    fn fast_faces(
        &mut self,
        element: &Element,
        vertices: usize,
        faces: &mut Faces<'_>,
    ) -> Result<bool, Fault> {
        lines::faces(self, element, vertices, faces)
    }
}

/// A float as an integer.
pub(super) fn whole_of(real: f64) -> Result<i64, Wrong> {
    // Far above any index, and still exact.
    const LARGEST: f64 = 9_007_199_254_740_992.0;
    if real.fract() == 0.0 && real.abs() <= LARGEST {
        Ok(real as i64)
    } else {
        Err(Wrong::NotWhole)
    }
}

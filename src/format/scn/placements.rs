//! Files of placements: text, or an array as numpy saves it.
//!
//! The header of an array is one line of Python in a fixed form; crates that read it include a Python parser.

use crate::{
    error::{LoadError, quote},
    format::{
        budget::{Budget, Parsing},
        place::{LFS_POINTER, LONE_RETURNS, after_mark, has_lone_returns, is_lfs_pointer, is_utf16},
        reason::Reason,
    },
    scene::MAX_COORDINATE,
};
use std::path::Path;

/// A 3x4 matrix by rows.
pub(super) type Rows = [[f64; 4]; 3];

/// How many numbers a placement may have: a position, a matrix of three rows and four columns, or one of four rows.
const COUNTS: [usize; 3] = [3, 12, 16];

const EXPECTED: &str =
    "expected 3 (a position), 12 or 16 (a matrix by rows, whose last column is the position)";

/// The first bytes of a numpy array (NEP 1, *A Simple File Format for NumPy Arrays*).
const NUMPY: &[u8] = b"\x93NUMPY";

/// The error about a file that is neither text nor an array.
const BINARY: &str = "this is binary data, expected text or a numpy array (.npy, written by numpy.save)";

/// Passes all placements of a file to `take`, whose error is a sentence. Returns their number.
pub(super) fn read(
    bytes: &[u8],
    path: &Path,
    budget: &Budget,
    mut take: impl FnMut(Rows) -> Result<(), Reason>,
) -> Result<usize, LoadError> {
    let mut progress = budget.parsing(bytes.len());
    let whole = |message: &str| LoadError::whole_file(path, message);
    if bytes.starts_with(NUMPY) {
        return array(bytes, &mut progress, &mut take).map_err(|reason| reason.of_file(path));
    }
    if let Some(what) = other_content(bytes, path) {
        return Err(whole(what));
    }
    let bytes = bytes.get(after_mark(bytes)..).unwrap_or_default();
    let (mut start, mut placements) = (0, 0);
    for line in bytes.split_inclusive(|&byte| byte == b'\n') {
        let own = start..start + line.trim_ascii_end().len();
        start += line.len();
        progress.at(start);
        let refused = |reason: Reason| {
            LoadError::in_text(path, bytes, own.clone(), reason.message).with_kind(reason.kind)
        };
        let words = line
            .split(u8::is_ascii_whitespace)
            .filter(|word| !word.is_empty());
        let is_comment = |word: &&[u8]| word.starts_with(b"//") || word.starts_with(b"#");
        let (mut numbers, mut count) = ([0.0; 16], 0);
        for word in words.take_while(|word| !is_comment(word)) {
            let text = String::from_utf8_lossy(word);
            let number = text.parse::<f64>().map_err(|_| {
                if str::from_utf8(word).map_or(true, |word| word.contains(char::is_control)) {
                    return whole(BINARY);
                }
                let at = own.start + (word.as_ptr() as usize - line.as_ptr() as usize);
                LoadError::in_text(path, bytes, at..at + word.len(), no_number(word, &text))
            })?;
            if let Some(to) = numbers.get_mut(count) {
                *to = number;
            }
            count += 1;
        }
        if count > 0 {
            let rows = rows(numbers.get(..count).unwrap_or_default(), count);
            let rows = rows.map_err(|message| refused(message.into()))?;
            take(rows).map_err(refused)?;
            placements += 1;
        }
    }
    Ok(placements)
}

/// What a file is that has no text of placements, as a sentence.
fn other_content(bytes: &[u8], path: &Path) -> Option<&'static str> {
    let is_npy = path
        .extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("npy"));
    // A text without placements is an empty list; numpy writes no empty file.
    if bytes.is_empty() && is_npy {
        Some("the file is empty, expected a numpy array")
    } else if bytes.starts_with(b"PK\x03\x04") {
        Some(
            "this is a ZIP archive, such as numpy's .npz, expected text or one array (.npy, written by numpy.save)",
        )
    } else if is_utf16(bytes) {
        Some("this is UTF-16, expected placements in UTF-8 or ASCII")
    } else if is_lfs_pointer(bytes) {
        Some(LFS_POINTER)
    } else if bytes.contains(&0) {
        Some(BINARY)
    } else if has_lone_returns(bytes) {
        Some(LONE_RETURNS)
    } else {
        None
    }
}

/// The error for a word that is not a number.
fn no_number(word: &[u8], text: &str) -> String {
    let is_list = |text: &str| {
        text.contains(',')
            && text
                .split(',')
                .all(|part| part.is_empty() || part.parse::<f64>().is_ok())
    };
    let hint = if has_decimal_comma(text) {
        " with a decimal point instead of the comma"
    } else if is_list(text) {
        ", with spaces instead of commas"
    } else {
        ""
    };
    format!("found {}, expected a number{hint}", quote(word))
}

/// Whether a word is a number with a decimal comma, such as `-1,5`. Two numbers with a comma between them look the same, but
/// there are no placements of two.
fn has_decimal_comma(text: &str) -> bool {
    let is_number = |text: String| text.parse::<f64>().is_ok();
    match text.split_once(',') {
        Some((whole, part)) => {
            let starts_with_digit = part.starts_with(|next: char| next.is_ascii_digit());
            starts_with_digit
                && !whole.contains('.')
                && !part.contains('.')
                && is_number(format!("{whole}.{part}"))
        }
        None => false,
    }
}

/// The matrix of a placement. The error is a sentence.
fn rows(numbers: &[f64], count: usize) -> Result<Rows, String> {
    if !COUNTS.contains(&numbers.len()) {
        return Err(format!("a placement of {count} numbers, {EXPECTED}"));
    }
    let is_usable = |number: &f64| number.abs() <= f64::from(MAX_COORDINATE);
    if let Some(number) = numbers.iter().find(|number| !is_usable(number)) {
        return Err(format!("a placement with {number:e}, expected numbers up to 1e9"));
    }
    if let [x, y, z] = *numbers {
        return Ok([[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, y], [0.0, 0.0, 1.0, z]]);
    }
    if numbers
        .get(12..)
        .is_some_and(|last| !last.is_empty() && last != [0.0, 0.0, 0.0, 1.0])
    {
        return Err("the last row of a matrix is not 0 0 0 1".into());
    }
    let mut rows = [[0.0; 4]; 3];
    rows.as_flattened_mut().copy_from_slice(&numbers[..12]);
    Ok(rows)
}

/// How many placements a file has, if it is a numpy array, which says so at its head.
pub(super) fn announced(bytes: &[u8]) -> Option<usize> {
    let array = bytes.starts_with(NUMPY).then(|| Array::new(bytes))?;
    array.ok().map(|array| array.count)
}

/// A numpy array of placements.
struct Array<'a> {
    count: usize,
    /// Numbers of a placement.
    each: usize,
    /// Bytes of a number.
    size: usize,
    data: &'a [u8],
}

/// The placements of a numpy array of `f4` or `f8`, little-endian, row after row. Returns their number.
fn array(
    bytes: &[u8],
    progress: &mut Parsing<'_>,
    take: &mut impl FnMut(Rows) -> Result<(), Reason>,
) -> Result<usize, Reason> {
    let Array {
        count,
        each,
        size,
        data,
    } = Array::new(bytes)?;
    for (i, placement) in data.chunks_exact(each * size).enumerate() {
        progress.at(i * each * size);
        let mut numbers = [0.0; 16];
        for (number, bytes) in numbers.iter_mut().zip(placement.chunks_exact(size)) {
            *number = match *bytes {
                [a, b, c, d] => f64::from(f32::from_le_bytes([a, b, c, d])),
                [a, b, c, d, e, f, g, h] => f64::from_le_bytes([a, b, c, d, e, f, g, h]),
                _ => 0.0,
            };
        }
        let rows = rows(&numbers[..each], each).map_err(Reason::from);
        rows.and_then(&mut *take).map_err(|reason| Reason {
            message: format!("array[{i}]: {reason}"),
            ..reason
        })?;
    }
    Ok(count)
}

impl<'a> Array<'a> {
    fn new(bytes: &'a [u8]) -> Result<Self, Reason> {
        let cut = || Reason::from("the array ends within its header");
        let field = |range: std::ops::Range<usize>| bytes.get(range).ok_or_else(cut);
        let major = field(6..7)?[0];
        let (start, length) = if major == 1 {
            let length = field(8..10)?;
            (10, usize::from(u16::from_le_bytes([length[0], length[1]])))
        } else {
            let length = field(8..12)?;
            (
                12,
                u32::from_le_bytes([length[0], length[1], length[2], length[3]]) as usize,
            )
        };
        let header = field(start..start.saturating_add(length))?;
        let header: String = header
            .iter()
            .map(|&byte| char::from(byte))
            .filter(|c| *c != ' ')
            .collect();
        let size = match value(&header, "descr") {
            Some("'<f4'" | "\"<f4\"") => 4,
            Some("'<f8'" | "\"<f8\"") => 8,
            _ => return Err("an array of another type, expected float32 or float64, little-endian".into()),
        };
        if value(&header, "fortran_order") != Some("False") {
            return Err("an array in Fortran order, expected C order (numpy.ascontiguousarray)".into());
        }
        let shape = header
            .split_once("'shape':(")
            .and_then(|(_, rest)| rest.split_once(')'));
        let shape: Option<Vec<usize>> = shape.and_then(|(shape, _)| {
            let sides = shape.split(',').filter(|side| !side.is_empty());
            sides.map(|side| side.parse().ok()).collect()
        });
        let (count, each) = match shape.as_deref() {
            Some(&[count, each]) if COUNTS.contains(&each) => (count, each),
            Some(&[count, rows @ (3 | 4), 4]) => (count, rows * 4),
            _ => {
                return Err(
                    "an array of another shape, expected (n, 3), (n, 12), (n, 16), (n, 3, 4) or (n, 4, 4)"
                        .into(),
                );
            }
        };
        let data = &bytes[start + length..];
        if count.checked_mul(each * size) != Some(data.len()) {
            let (found, each) = (data.len(), each * size);
            let message = format!("{found} bytes of numbers, expected {count} placements of {each} bytes");
            return Err(message.into());
        }
        Ok(Self {
            count,
            each,
            size,
            data,
        })
    }
}

/// The value of a key of the header, without spaces.
fn value<'a>(header: &'a str, key: &str) -> Option<&'a str> {
    let (_, rest) = header.split_once(&format!("'{key}':"))?;
    rest.split([',', '}']).next()
}

#[cfg(test)]
mod tests;

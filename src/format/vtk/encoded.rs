//! Binary data of XML files: raw or base64, perhaps in blocks that zlib compresses.
//!
//! Data begin with a header of whole numbers: the number of bytes, or of compressed data the number of blocks, the size of
//! each, that of the last one if it is smaller, and the compressed size of each.

use super::array::{Bytes, File, Wrong};
use crate::{
    error::{LoadErrorKind, in_bytes},
    format::budget::BudgetError,
};
use flate2::bufread::ZlibDecoder;
use std::{borrow::Cow, io::Read};

/// The most bytes that DEFLATE expands one byte to.
const MAX_RATIO: u64 = 1032;

/// How a file stores binary data.
#[derive(Default)]
pub(super) struct Encoding<'a> {
    pub(super) is_big: bool,
    /// Whether headers have numbers of 64 bits.
    pub(super) has_wide_headers: bool,
    pub(super) is_compressed: bool,
    /// What follows the `_` of the appended data.
    pub(super) appended: Option<&'a [u8]>,
    /// Whether that is base64.
    pub(super) is_base64: bool,
}

impl<'a> Encoding<'a> {
    /// The appended data from an offset on; `None` if it is beyond their end.
    pub(super) fn appended(&self, offset: u64) -> Option<Data<'a>> {
        let bytes = self.appended?.get(usize::try_from(offset).ok()?..)?;
        Some(if self.is_base64 {
            Data::base64(bytes)
        } else {
            Data::Raw(bytes)
        })
    }
}

/// Bytes that are left to read.
pub(super) enum Data<'a> {
    Raw(&'a [u8]),
    Base64 {
        text: &'a [u8],
        /// Decoded bytes that were not asked for yet, the last one first.
        decoded: Vec<u8>,
    },
}

impl<'a> Data<'a> {
    pub(super) fn base64(text: &'a [u8]) -> Self {
        Self::Base64 {
            text,
            decoded: Vec::new(),
        }
    }

    /// The most bytes that there may be.
    fn most(&self) -> u64 {
        match self {
            Self::Raw(bytes) => bytes.len() as u64,
            Self::Base64 { text, decoded } => (text.len() / 4 * 3 + decoded.len()) as u64,
        }
    }

    /// The next `count` bytes, which are taken from the budget if they are decoded.
    fn take(&mut self, count: u64, file: &File<'_>) -> Result<Cow<'a, [u8]>, Wrong> {
        let ended = || Wrong::new("they end too early");
        if count > self.most() {
            return Err(ended());
        }
        let count = count as usize;
        match self {
            Self::Raw(bytes) => {
                let (taken, rest) = bytes.split_at_checked(count).ok_or_else(ended)?;
                *bytes = rest;
                Ok(Cow::Borrowed(taken))
            }
            Self::Base64 { text, decoded } => {
                let mut taken = Vec::new();
                file.budget.reserve(&mut taken, count)?;
                while taken.len() < count {
                    if let Some(byte) = decoded.pop() {
                        taken.push(byte);
                        continue;
                    }
                    let Some((bytes, length)) = group(text)? else {
                        return Err(ended());
                    };
                    let fit = length.min(count - taken.len());
                    taken.extend_from_slice(&bytes[..fit]);
                    decoded.extend(bytes[fit..length].iter().rev());
                }
                Ok(Cow::Owned(taken))
            }
        }
    }

    /// The next number of a header.
    fn header(&mut self, file: &File<'_>) -> Result<u64, Wrong> {
        let Encoding {
            is_big,
            has_wide_headers,
            ..
        } = file.encoding;
        let size = if has_wide_headers { 8 } else { 4 };
        let bytes = self.take(size, file)?;
        let mut number = 0;
        for (i, &byte) in bytes.iter().enumerate() {
            let place = if is_big { size as usize - 1 - i } else { i };
            number |= u64::from(byte) << (8 * place);
        }
        give_back(&bytes, file);
        Ok(number)
    }
}

/// Frees decoded bytes.
#[expect(clippy::ptr_arg, reason = "only owned bytes are counted")]
fn give_back(bytes: &Cow<'_, [u8]>, file: &File<'_>) {
    if let Cow::Owned(bytes) = bytes {
        file.budget.give_back(bytes.capacity());
    }
}

/// The next group of four digits: up to three bytes, and how many they are. Padding may be inside, since headers are encoded
/// separately. `None` at the end.
fn group(text: &mut &[u8]) -> Result<Option<([u8; 3], usize)>, Wrong> {
    let (mut bits, mut digits, mut padding) = (0_u32, 0, 0);
    while digits + padding < 4 {
        let Some((&first, rest)) = text.split_first() else {
            break;
        };
        *text = rest;
        let digit = match first {
            b'A'..=b'Z' => first - b'A',
            b'a'..=b'z' => first - b'a' + 26,
            b'0'..=b'9' => first - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            b'=' if digits >= 2 => {
                padding += 1;
                continue;
            }
            _ if first.is_ascii_whitespace() => continue,
            // The end tag.
            b'<' => {
                *text = &[];
                break;
            }
            _ => return Err(Wrong::new("they are not base64")),
        };
        if padding > 0 {
            return Err(Wrong::new("they are not base64"));
        }
        bits |= u32::from(digit) << (18 - 6 * digits);
        digits += 1;
    }
    let [_, bytes @ ..] = bits.to_be_bytes();
    match digits {
        0 => Ok(None),
        1 => Err(Wrong::new("they end within a byte")),
        _ => Ok(Some((bytes, digits - 1))),
    }
}

/// Decodes the data of an array.
pub(super) fn read<'a>(mut data: Data<'a>, file: &File<'a>) -> Result<Bytes<'a>, Wrong> {
    if file.encoding.is_compressed {
        return inflate(data, file);
    }
    let size = data.header(file)?;
    if size > data.most() {
        let most = in_bytes(data.most());
        let message = format!("their header promises {}, but {most} follow", in_bytes(size));
        return Err(Wrong::new(message));
    }
    spend(size, file)?;
    Ok(match data.take(size, file)? {
        Cow::Borrowed(bytes) => Bytes::borrowed(bytes, file.budget),
        Cow::Owned(bytes) => Bytes::owned(bytes, file.budget),
    })
}

/// Counts the bytes of an array.
fn spend(size: u64, file: &File<'_>) -> Result<(), Wrong> {
    let left = file.work.get().checked_sub(size).ok_or_else(|| Wrong {
        message: "together with all others they are too large for the file".into(),
        kind: LoadErrorKind::Limit,
    })?;
    file.work.set(left);
    Ok(())
}

/// Inflates the blocks of an array.
fn inflate<'a>(mut data: Data<'a>, file: &File<'a>) -> Result<Bytes<'a>, Wrong> {
    let blocks = data.header(file)?;
    let [size, last] = [data.header(file)?, data.header(file)?];
    if blocks == 0 {
        return Ok(Bytes::borrowed(&[], file.budget));
    }
    let too_many = || Wrong::new(format!("their header promises {blocks} blocks, more than follow"));
    // Each has its size in the header.
    if blocks > data.most() / 4 {
        return Err(too_many());
    }
    let mut sizes: Vec<u64> = Vec::new();
    file.budget.reserve(&mut sizes, blocks as usize)?;
    for _ in 0..blocks {
        sizes.push(data.header(file)?);
    }
    let stored = sizes.iter().fold(0_u64, |sum, &size| sum.saturating_add(size));
    if stored > data.most() {
        return Err(too_many());
    }
    let smaller = if last == 0 { size } else { last };
    let total = size
        .checked_mul(blocks - 1)
        .and_then(|sum| sum.checked_add(smaller));
    let total = total.filter(|&total| total <= stored.saturating_mul(MAX_RATIO));
    let total = total.ok_or_else(|| {
        let stored = in_bytes(stored);
        Wrong::new(format!(
            "{blocks} blocks of {size} bytes are more than {stored} can inflate to"
        ))
    })?;
    spend(total, file)?;
    let mut bytes = Vec::new();
    file.budget.reserve(&mut bytes, total as usize)?;
    for (i, &stored) in sizes.iter().enumerate() {
        let size = if i + 1 == sizes.len() { smaller } else { size };
        let block = data.take(stored, file)?;
        let before = bytes.len();
        let inflated = ZlibDecoder::new(&block[..]).take(size).read_to_end(&mut bytes);
        give_back(&block, file);
        if let Err(error) = inflated {
            let error = error.to_string().to_lowercase();
            return Err(Wrong::new(format!("block {} is broken: {error}", i + 1)));
        }
        let found = bytes.len() - before;
        if (found as u64) < size {
            let message = format!("block {} has {found} bytes, expected {size}", i + 1);
            return Err(Wrong::new(message));
        }
    }
    file.budget.give_back(sizes.capacity() * size_of::<u64>());
    Ok(Bytes::owned(bytes, file.budget))
}

impl From<BudgetError> for Wrong {
    fn from(error: BudgetError) -> Self {
        Self {
            message: error.to_string(),
            kind: LoadErrorKind::Limit,
        }
    }
}

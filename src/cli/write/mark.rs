//! The mark in octray's own files: a name that the user did not type replaces only files that have it.
//!
//! PNG, EXR and TIFF have a field for the program's name; JPEG, GIF, PPM and Y4M take a comment. BMP has neither, so the mark
//! follows the picture. QOI has no mark: FFmpeg takes what follows its picture for a second one, a broken one.

use super::encode::Format;
use crate::{format, generate::is_generated, render::SOFTWARE};
use std::{
    io::{self, Read, Seek, SeekFrom},
    path::Path,
};

/// Marks, and the places of crops, are in the first or the last bytes of a file.
const HEAD_BYTES: u64 = 4096;
const TAIL_BYTES: u64 = 128;

/// How octray's JSON begins: with the number of its schema.
const JSON_START: &[u8] = b"{\"schema\":1,\"";
/// A comment, after the JFIF header of this size: readers expect that first.
const JPEG_COMMENT: &[u8] = b"\xff\xfe\0\x08octray";
const JPEG_HEADER: usize = 20;
/// The value of the tag `Software` and where the encoder puts it: after the header and two resolutions.
const TIFF_SOFTWARE: &[u8] = b"octray\0";
const TIFF_OFFSET: usize = 24;
const PPM_START: &[u8] = b"P6\n";
const PPM_COMMENT: &[u8] = b"# octray\n";
/// A comment and the end of the file.
pub const GIF_END: &[u8] = b"\x21\xfe\x06octray\0;";
/// The last parameter of the header; readers skip X.
pub const Y4M_COMMENT: &str = " Xoctray\n";
/// After the picture.
const LAST_LINE: &[u8] = b"\noctray\n";

/// Adds the mark to the file of a picture, if the encoder has not written it.
pub fn add_mark(format: Format, bytes: &mut Vec<u8>) {
    match format {
        Format::Jpeg => insert(bytes, JPEG_HEADER, JPEG_COMMENT),
        Format::Ppm => insert(bytes, PPM_START.len(), PPM_COMMENT),
        Format::Bmp => bytes.extend(LAST_LINE),
        Format::Png | Format::Qoi | Format::Tiff | Format::Exr | Format::Gif | Format::Apng | Format::Y4m => {
        }
    }
    // The header has the size of the whole file.
    if format == Format::Bmp
        && let Ok(size) = u32::try_from(bytes.len())
        && let Some(field) = bytes.get_mut(2..6)
    {
        field.copy_from_slice(&size.to_le_bytes());
    }
}

fn insert(bytes: &mut Vec<u8>, at: usize, text: &[u8]) {
    let at = at.min(bytes.len());
    bytes.splice(at..at, text.iter().copied());
}

/// Whether octray wrote this file, judging by its first and last bytes.
pub fn is_own(path: &Path) -> bool {
    read_ends(path).is_ok_and(|(head, tail)| has_mark(&head, &tail))
}

/// The first and the last bytes of a file.
///
/// # Errors
/// [`io::Error`].
pub fn read_ends(path: &Path) -> io::Result<(Vec<u8>, Vec<u8>)> {
    let mut file = format::open_file(path)?;
    let (mut head, mut tail) = (Vec::new(), Vec::new());
    (&mut file).take(HEAD_BYTES).read_to_end(&mut head)?;
    let length = file.metadata()?.len();
    file.seek(SeekFrom::Start(length.saturating_sub(TAIL_BYTES)))?;
    file.take(TAIL_BYTES).read_to_end(&mut tail)?;
    Ok((head, tail))
}

fn has_mark(head: &[u8], tail: &[u8]) -> bool {
    let has = |at, text: &[u8]| head.get(at..).is_some_and(|bytes| bytes.starts_with(text));
    match head {
        [0x89, b'P', b'N', b'G', ..] => is_own_png(head),
        [0x76, 0x2f, 0x31, 1, ..] => is_own_exr(head),
        [0xff, 0xd8, ..] => has(JPEG_HEADER, JPEG_COMMENT),
        [b'P', b'6', ..] => has(PPM_START.len(), PPM_COMMENT),
        [b'I', b'I', ..] | [b'M', b'M', ..] => has(TIFF_OFFSET, TIFF_SOFTWARE),
        [b'G', b'I', b'F', ..] => tail.ends_with(GIF_END),
        [b'B', b'M', ..] => tail.ends_with(LAST_LINE),
        [b'Y', b'U', b'V', ..] => head
            .split_inclusive(|&byte| byte == b'\n')
            .next()
            .is_some_and(|line| line.ends_with(Y4M_COMMENT.as_bytes())),
        _ => is_generated(head) || head.starts_with(JSON_START),
    }
}

/// Looks for the text `Software` in the chunks before the pixels.
fn is_own_png(head: &[u8]) -> bool {
    let Some(mut rest) = head.strip_prefix(b"\x89PNG\r\n\x1a\n") else {
        return false;
    };
    // Each chunk: length, kind, data, checksum.
    while let Some((&length, after)) = rest.split_first_chunk()
        && let Some((kind, after)) = after.split_first_chunk::<4>()
        && let Some((data, after)) = after.split_at_checked(u32::from_be_bytes(length) as usize)
        && kind != b"IDAT"
    {
        if kind == b"tEXt" && data.strip_prefix(b"Software\0") == Some(SOFTWARE.as_bytes()) {
            return true;
        }
        rest = after.get(4..).unwrap_or_default();
    }
    false
}

/// Looks for the attribute `software`: name, type, length, value.
fn is_own_exr(head: &[u8]) -> bool {
    let length = (SOFTWARE.len() as u32).to_le_bytes();
    let attribute = [b"software\0string\0", &length[..], SOFTWARE.as_bytes()].concat();
    head.starts_with(b"\x76\x2f\x31\x01") && head.windows(attribute.len()).any(|bytes| bytes == attribute)
}

#[cfg(test)]
mod tests;

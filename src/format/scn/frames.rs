//! Finds the number of frames of a scene without loading it, because pictures are named and checked before.

use super::words::split;
use crate::{
    error::LoadError,
    format::{
        budget::Budget,
        files::{MAX_TEXT_BYTES, load_error, read_text},
        place::BYTE_ORDER_MARK,
    },
    scene::MAX_TIME,
};
use std::path::Path;

/// How deep includes are followed. Deeper ones are refused when the scene is loaded.
const MAX_DEPTH: usize = 16;

/// How many files are read. More are refused when the scene is loaded.
const MAX_FILES: usize = 1024;

/// The state of the scan.
struct Scan {
    files: usize,
    bytes: u64,
    /// The last time of a keyframe.
    last: Option<f64>,
}

/// The number of frames of a scene file, `None` if it has no keyframe. Faults of its text are reported when it is loaded.
///
/// # Errors
/// [`LoadError`] if the file cannot be read.
pub(in crate::format) fn frames(path: &Path) -> Result<Option<u32>, LoadError> {
    let mut scan = Scan {
        files: MAX_FILES,
        bytes: 2 * MAX_TEXT_BYTES,
        last: None,
    };
    scan.file(path, MAX_DEPTH)?;
    Ok(scan.last.map(|last| (last.ceil() as u32).max(1)))
}

impl Scan {
    fn file(&mut self, path: &Path, depth: usize) -> Result<(), LoadError> {
        let text = read_text(path, &Budget::unlimited()).map_err(|error| load_error(path, &error))?;
        self.bytes = self.bytes.saturating_sub(text.len() as u64);
        let text = text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(&text);
        let folder = path.parent().unwrap_or(Path::new(""));
        for line in text.split(|&byte| byte == b'\n') {
            let start = line.trim_ascii_start();
            if !start.starts_with(b"at") && !start.starts_with(b"include") {
                continue;
            }
            let words = split(line).unwrap_or_default();
            let [keyword, word, ..] = &words[..] else { continue };
            let Some(word) = word.as_str() else { continue };
            match keyword.text {
                b"at" => {
                    let time = word.parse::<f64>().ok();
                    let time = time.filter(|time| (0.0..=MAX_TIME).contains(time));
                    self.last = time.map(|time| time.max(self.last.unwrap_or(0.0))).or(self.last);
                }
                b"include" if depth > 0 && self.files > 0 && self.bytes > 0 => {
                    self.files -= 1;
                    // A file that is missing is found when the scene is loaded.
                    let _ = self.file(&folder.join(word), depth - 1);
                }
                _ => {}
            }
        }
        Ok(())
    }
}

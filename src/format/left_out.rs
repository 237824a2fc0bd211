//! Contents of a file that octray does not read, listed in one note per file.

use crate::error::clip_path;
use std::path::Path;

/// How many names of one kind a note lists.
pub(super) const MOST_NAMES: usize = 4;

/// How many things a note lists. A hostile header may have thousands of elements.
const MOST_THINGS: usize = 20;

/// The contents of a file that octray does not read.
#[derive(Debug, Default)]
pub(super) struct LeftOut(Vec<String>);

impl LeftOut {
    /// Adds something without a count, such as "vertex colours", unless it is listed.
    pub(super) fn add(&mut self, what: &str) {
        if !self.0.iter().any(|known| known == what) {
            self.push(what.to_owned());
        }
    }

    /// Keeps one more than is listed, to know that there are more.
    fn push(&mut self, what: String) {
        if self.0.len() <= MOST_THINGS {
            self.0.push(what);
        }
    }

    /// Adds `count` things, if there are any: "1 light", "2 lights".
    pub(super) fn count(&mut self, count: usize, one: &str, many: &str) {
        if count > 0 {
            self.push(counted(count, one, many));
        }
    }

    /// Adds this many faces that are no polygons, if there are any.
    pub(super) fn small_faces(&mut self, count: usize) {
        self.count(
            count,
            "face with fewer than 3 corners",
            "faces with fewer than 3 corners",
        );
    }

    /// Adds this many normals that are NaN or too large, if there are any.
    pub(super) fn odd_normals(&mut self, count: usize) {
        self.count(
            count,
            "normal that is NaN or too large",
            "normals that are NaN or too large",
        );
    }

    /// Adds things by name, if there are any: "vertex properties `a`, `b`".
    pub(super) fn names<'a>(&mut self, what: &str, names: impl IntoIterator<Item = &'a str>) {
        let list = name_list(names.into_iter().map(str::as_bytes));
        if !list.is_empty() {
            self.push(format!("{what} {list}"));
        }
    }

    /// The note about the file at `path`; `None` if nothing was left out.
    pub(super) fn note(&self, path: &Path) -> Option<String> {
        let listed = self.0.get(..MOST_THINGS).unwrap_or(&self.0).join(", ");
        let more = if self.0.len() > MOST_THINGS { ", ..." } else { "" };
        (!self.0.is_empty()).then(|| format!("{}: left out: {listed}{more}", clip_path(path)))
    }
}

/// Adds something to the note about the file at `path`, or such a note.
pub(super) fn add_to_note(notes: &mut Vec<String>, path: &Path, what: &str) {
    let start = format!("{}: left out: ", clip_path(path));
    match notes.iter_mut().find(|note| note.starts_with(&start)) {
        Some(note) => *note += &format!(", {what}"),
        None => notes.push(start + what),
    }
}

/// Quoted names as a list, at most [`MOST_NAMES`] of them.
pub(super) fn name_list<'a>(names: impl IntoIterator<Item = &'a [u8]>) -> String {
    let mut quoted: Vec<String> = Vec::new();
    for name in names {
        let name = crate::error::quote(name);
        if quoted.contains(&name) {
            continue;
        }
        if quoted.len() == MOST_NAMES {
            quoted.push("...".to_owned());
            break;
        }
        quoted.push(name);
    }
    quoted.join(", ")
}

/// A count with its noun: "1 light", "2 lights".
pub(super) fn counted(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

#[cfg(test)]
mod tests;

//! `include`: reads the lines of another file in its place.

use super::{QUOTES_HINT, Reader, arguments::Arguments};
use crate::{
    error::{LoadError, SourcePos},
    format::{
        files::{self, MAX_TEXT_BYTES},
        reason::Reason,
    },
};
use std::path::PathBuf;

/// How deep includes may nest.
const MAX_DEPTH: usize = 16;

/// How many includes a scene may have. Without a limit, files that include others twice would grow exponentially.
const MAX_INCLUDES: usize = 1024;

/// The open files, and how much has been read.
#[derive(Default)]
pub(super) struct Includes {
    /// Identity and name of the open files, from the scene inwards.
    stack: Vec<(PathBuf, PathBuf)>,
    /// The places of the statements that opened all but the first.
    places: Vec<SourcePos>,
    count: usize,
    bytes: u64,
}

impl Includes {
    pub(super) fn enter(&mut self, identity: PathBuf, name: PathBuf) {
        self.stack.push((identity, name));
    }

    pub(super) fn leave(&mut self) {
        self.stack.pop();
    }

    /// The places of the `include` statements of the open files, from the scene inwards.
    pub(super) fn places(&self) -> Vec<SourcePos> {
        self.places.clone()
    }

    /// Why the file may not be included; `None` if it may.
    fn objection(&self, identity: &PathBuf) -> Option<Reason> {
        let start = self.stack.iter().position(|(open, _)| open == identity);
        if let Some(circle) = start.and_then(|start| self.stack.get(start..)) {
            let names: Vec<String> = circle
                .iter()
                .chain(circle.first())
                .map(|(_, name)| name.display().to_string())
                .collect();
            return Some(format!("the file includes itself: {}", names.join(" > ")).into());
        }
        if self.stack.len() > MAX_DEPTH {
            return Some(Reason::limit(format!("includes nest more than {MAX_DEPTH} deep")));
        }
        let too_many = || Reason::limit(format!("more than {MAX_INCLUDES} includes in one scene"));
        (self.count >= MAX_INCLUDES).then(too_many)
    }
}

impl Reader<'_> {
    /// `include PATH`
    pub(super) fn include(&mut self, mut arguments: Arguments<'_, '_>) -> Result<(), LoadError> {
        let [word] = arguments.leading()?;
        arguments.hint = QUOTES_HINT;
        arguments.end()?;
        let line = arguments.line;
        let path = self.path(&arguments, word, "scene")?;
        let identity = self.files.identity(&path);
        if let Some(reason) = self.includes.objection(&identity) {
            return Err(line.error_at(&word, reason.message).with_kind(reason.kind));
        }
        let cannot_include = |cause: LoadError| {
            line.error_at(&word, format!("cannot include {}", path.display()))
                .caused_by(cause)
        };
        let text = self
            .files
            .text(&path, self.budget)
            .map_err(|error| cannot_include(files::load_error(&path, &error)))?;
        self.includes.count += 1;
        self.includes.bytes += text.len() as u64;
        if self.includes.bytes > MAX_TEXT_BYTES {
            let message = format!("included files add up to more than {MAX_TEXT_BYTES} bytes");
            return Err(line.too_many(&word, message));
        }
        self.builder.add_include(path.clone());
        self.includes.places.push(line.at(arguments.keyword.start));
        self.file(&text, &path, identity).map_err(cannot_include)?;
        self.includes.places.pop();
        self.budget.give_back(text.capacity());
        Ok(())
    }
}

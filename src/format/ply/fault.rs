//! Faults of PLY files.

use crate::{error::LoadErrorKind, format::budget::BudgetError};
use std::ops::Range;

/// Where a fault is.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// The whole file.
    File,
    /// Bytes of a text.
    Text(Range<usize>),
}

/// What is wrong with a mesh, and its place.
#[derive(Debug)]
pub(super) struct Fault {
    pub(super) place: Place,
    pub(super) message: String,
    pub(super) kind: LoadErrorKind,
}

impl Fault {
    pub(super) fn text(place: Range<usize>, message: impl Into<String>) -> Self {
        Self::at(Place::Text(place), message.into())
    }

    /// A fault of the whole file.
    pub(super) fn file(message: impl Into<String>) -> Self {
        Self::at(Place::File, message.into())
    }

    pub(super) fn at(place: Place, message: String) -> Self {
        Self {
            place,
            message,
            kind: LoadErrorKind::Invalid,
        }
    }
}

impl From<BudgetError> for Fault {
    fn from(error: BudgetError) -> Self {
        Self {
            place: Place::File,
            message: error.to_string(),
            kind: LoadErrorKind::Limit,
        }
    }
}

//! Errors about values, with their places.

use super::{
    fault::Fault,
    header::{Element, Role},
    rows::{Values, Wrong},
    slots::UV_SLOT,
};
use crate::error::{SceneError, quote};

/// The value that is being read. Its methods make the errors, outside of the hot loops.
pub(super) struct At<'a> {
    pub(super) element: &'a Element,
    pub(super) step_i: usize,
    pub(super) start: usize,
    pub(super) record: usize,
}

impl At<'_> {
    fn property(&self) -> String {
        let name = self.element.property_names.get(self.step_i);
        name.map_or_else(String::new, |name| quote(name.as_bytes()))
    }

    /// "vertex 12 of 34".
    pub(super) fn record(&self) -> String {
        let Self { element, record, .. } = self;
        match element.role {
            Role::Vertex => format!("vertex {record} of {}", element.count),
            Role::Face => format!("face {record} of {}", element.count),
            Role::Strips => format!("strip record {record} of {}", element.count),
            Role::Edge => format!("edge {record} of {}", element.count),
            Role::Other => format!(
                "{} record {record} of {}",
                quote(element.name.as_bytes()),
                element.count
            ),
        }
    }

    fn fault<V: Values>(&self, values: &V, message: String) -> Fault {
        let message = message + &values.where_in_file("the record", self.start);
        Fault::at(values.place(self.start, false), message)
    }

    #[cold]
    pub(super) fn wrong<V: Values>(&self, values: &V, wrong: Wrong) -> Fault {
        let (record, property) = (self.record(), self.property());
        let found = || {
            values
                .last_word()
                .map_or_else(String::new, |word| format!(" is {}", quote(word)))
        };
        let message = match wrong {
            Wrong::End => format!("the file ends inside {record}, expected {property}"),
            Wrong::NotANumber => format!("{property} of {record}{}, expected a number", found()),
            Wrong::NotWhole => format!("{property} of {record}{}, expected a whole number", found()),
        };
        self.fault(values, message)
    }

    #[cold]
    pub(super) fn unusable<V: Values>(&self, values: &V, slot: usize, value: f32) -> Fault {
        const NAMES: [&str; UV_SLOT] = ["x", "y", "z", "nx", "ny", "nz", "red", "green", "blue"];
        let what = NAMES.get(slot).copied().unwrap_or_default();
        let reason = SceneError::NotUsable { what, value };
        self.fault(values, format!("{}: {reason}", self.record()))
    }

    #[cold]
    pub(super) fn bad_index<V: Values>(&self, values: &V, index: i64, vertices: usize) -> Fault {
        let noun = if vertices == 1 { "vertex" } else { "vertices" };
        let place = values.where_in_file(&self.record(), self.start);
        let message = format!("vertex index {index}, but the file has only {vertices} {noun}{place}");
        Fault::at(values.place(self.start, true), message)
    }

    #[cold]
    pub(super) fn bad_length<V: Values>(&self, values: &V, length: i64) -> Fault {
        let (property, record, left) = (self.property(), self.record(), values.bytes_left());
        let message = if length < 0 {
            format!("{property} of {record} is a list of {length} values, expected 0 or more")
        } else {
            format!("{property} of {record} is a list of {length} values, but only {left} bytes follow")
        };
        self.fault(values, message)
    }
}

//! Numbers of vertices and faces that are shown as colours, and the ranges of all of them.

use super::{
    ascii::Text,
    binary::Binary,
    choice::is_color_or_coordinate,
    fault::{Fault, Place},
    header::{Element, Header, Role, Step},
    rows::{Values, for_each_property},
    slots::VALUE_SLOT,
};
use crate::{
    error::quote,
    format::{
        mesh::{Owner, Range, Scalar, scalars},
        reason::Reason,
    },
};
use serde_ply::PlyFormat;

/// What has numbers, and the element.
const OWNERS: [(Owner, Role); 2] = [(Owner::Vertices, Role::Vertex), (Owner::Faces, Role::Face)];

impl Header {
    /// Keeps the numbers of this name, of vertices or else of faces. Colours are skipped already, so they have names, too.
    pub(super) fn keep_value(&mut self, wanted: &str) -> Result<(), Fault> {
        let mut list = None;
        for (owner, role) in OWNERS {
            let elements = self.elements.iter_mut();
            let Some(element) = elements
                .filter(|element| element.count > 0)
                .find(|e| e.role == role)
            else {
                continue;
            };
            let names = element.property_names.iter();
            let Some(i) = names.zip(&element.steps).position(|(name, _)| name == wanted) else {
                continue;
            };
            match element.steps[i] {
                Step::Skip(scalar) => {
                    element.steps[i] = Step::Keep {
                        slot: VALUE_SLOT,
                        scalar,
                    };
                    self.valued = Some(owner);
                    return Ok(());
                }
                Step::SkipList { .. } => list = list.or(Some(owner)),
                _ => {}
            }
        }
        let reason = match list {
            Some(owner) => scalars::refused(format!(
                "{} of {} is a list, expected one number for each",
                quote(wanted.as_bytes()),
                owner.name()
            )),
            None => scalars::absent(wanted, &self.scalar_names()),
        };
        let Reason { kind, message } = reason;
        Err(Fault {
            place: Place::File,
            message,
            kind,
        })
    }

    /// Whether there are numbers beside those that are shown anyway.
    pub(super) fn has_scalars(&self) -> bool {
        !self.scalar_names().is_empty()
    }

    fn scalar_names(&self) -> Vec<(Owner, &str)> {
        let of = |(owner, role): (Owner, Role)| {
            let elements = self.elements.iter().filter(move |element| element.role == role);
            let of_element = move |element| scalars_of(element).map(move |i| (owner, i, element));
            elements.flat_map(of_element)
        };
        let all = OWNERS.into_iter().flat_map(of);
        all.filter_map(|(owner, i, element)| Some((owner, element.property_names.get(i)?.as_str())))
            .collect()
    }

    /// The ranges of all such numbers of a file that has been read without faults.
    pub(super) fn ranges(&self, bytes: &[u8]) -> Vec<Scalar> {
        if !self.has_scalars() {
            return Vec::new();
        }
        match self.format {
            PlyFormat::Ascii => self.ranges_of(&mut Text::new(bytes, self.body)),
            PlyFormat::BinaryLittleEndian => self.ranges_of(&mut Binary::<false>::new(bytes, self.body)),
            PlyFormat::BinaryBigEndian => self.ranges_of(&mut Binary::<true>::new(bytes, self.body)),
        }
    }

    fn ranges_of<V: Values>(&self, values: &mut V) -> Vec<Scalar> {
        let mut found = [Vec::new(), Vec::new()];
        for element in self.needed() {
            let mut ranges = vec![Range::default(); element.steps.len()];
            let read = for_each_property(element, values, |values, step, at| match *step {
                Step::Skip(scalar) => {
                    let value = values.double(scalar).unwrap_or(f64::NAN);
                    if let Some(range) = ranges.get_mut(at.step_i) {
                        *range = range.with(value);
                    }
                    Ok(())
                }
                _ => super::rows::skip(step, values, at),
            });
            let owner = OWNERS.iter().position(|(_, role)| *role == element.role);
            if let (Ok(()), Some(owner)) = (read, owner) {
                found[owner].extend(scalars_of(element).map(|i| Scalar {
                    name: element.property_names[i].clone(),
                    of: OWNERS[owner].0,
                    range: ranges[i],
                }));
            }
        }
        found.into_iter().flatten().collect()
    }
}

/// Which properties of an element are such numbers.
fn scalars_of(element: &Element) -> impl Iterator<Item = usize> {
    let properties = element.steps.iter().zip(&element.property_names).enumerate();
    let is_scalar = |step: &Step, name: &str| {
        element.count > 0
            && matches!(step, Step::Skip(_))
            && !is_color_or_coordinate(name, &element.property_names)
    };
    properties.filter_map(move |(i, (step, name))| is_scalar(step, name).then_some(i))
}

//! Numbers of vertices under names that begin with `_`, such as `_TEMPERATURE`: they are shown as colours.
//!
//! The gltf crate does not read them, so their part of the JSON is parsed separately.

use super::{buffers::Buffers, elements::Elements};
use crate::{
    error::{LoadError, quote},
    format::mesh::{Owner, Range, Scalar, Wanted, scalars},
};
use gltf::{Accessor, Document, accessor::Dimensions, json};
use serde::Deserialize;
use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
    rc::Rc,
};

/// The numbers of a file that are wanted.
#[derive(Default)]
pub(super) struct Scalars<'d> {
    wanted: Wanted,
    document: Option<&'d Document>,
    meshes: Vec<Mesh>,
    ranges: BTreeMap<String, Range>,
    /// The ranges of accessors, which many primitives and names may share.
    counted: BTreeMap<usize, Range>,
    /// How many numbers were counted. Accessors may overlap, so that a small file has more than anyone waits for.
    work: usize,
}

/// The parts of the JSON that matter here.
#[derive(Deserialize)]
struct File {
    #[serde(default)]
    meshes: Vec<Mesh>,
}

#[derive(Deserialize)]
struct Mesh {
    #[serde(default)]
    primitives: Vec<Primitive>,
}

#[derive(Deserialize)]
struct Primitive {
    /// Indices of accessors by name.
    #[serde(default)]
    attributes: BTreeMap<String, usize>,
}

/// Whether JSON may have names that begin with `_`, perhaps escaped.
fn has_own(text: &[u8]) -> bool {
    super::has(text, "\"_") || super::has(text, "\"\\u005")
}

/// How many numbers are counted for each byte of the files. More of them overlap, unless they are compressed that well.
const MOST_COUNTED: usize = 16;

impl<'d> Scalars<'d> {
    /// Reads the JSON once more, but only if numbers are wanted and there are some.
    ///
    /// # Errors
    /// [`LoadError`] if there are none of the wanted name.
    pub(super) fn of(
        text: &[u8],
        path: &Path,
        document: &'d Document,
        wanted: &Wanted,
    ) -> Result<Self, LoadError> {
        let mut meshes = Vec::new();
        if matches!(wanted, Wanted::Named(_) | Wanted::Ranges) && has_own(text) {
            let file: File = json::deserialize::from_slice(text).map_err(|error| {
                let place = [error.line(), error.column()];
                LoadError::in_json(path, place, "not valid attributes", &error.to_string())
            })?;
            meshes = file.meshes;
        }
        let this = Self {
            wanted: wanted.clone(),
            document: Some(document),
            meshes,
            ..Self::default()
        };
        if let Some(name) = wanted.name() {
            this.check(name).map_err(|reason| reason.of_file(path))?;
        }
        Ok(this)
    }

    /// Refuses a name that no primitive has.
    fn check(&self, name: &str) -> Result<(), crate::format::reason::Reason> {
        let primitives = self.meshes.iter().flat_map(|mesh| &mesh.primitives);
        let own = primitives.flat_map(|primitive| self.own(primitive));
        let (mut names, mut has_vectors) = (BTreeSet::new(), false);
        for (other, accessor) in own {
            if accessor.dimensions() == Dimensions::Scalar {
                names.insert(other);
            } else {
                has_vectors |= other == name;
            }
        }
        if names.contains(name) {
            return Ok(());
        }
        let names: Vec<_> = names.into_iter().map(|name| (Owner::Vertices, name)).collect();
        Err(if has_vectors {
            let name = quote(name.as_bytes());
            scalars::refused(format!(
                "{name} of vertices is a vector, expected one number for each"
            ))
        } else {
            scalars::absent(name, &names)
        })
    }

    /// The attributes of a primitive under the file's own names.
    fn own<'s>(&'s self, primitive: &'s Primitive) -> impl Iterator<Item = (&'s str, Accessor<'d>)> {
        let own = primitive
            .attributes
            .iter()
            .filter(|(name, _)| name.starts_with('_'));
        own.filter_map(|(name, &index)| Some((name.as_str(), self.document?.accessors().nth(index)?)))
    }

    /// The wanted numbers of a primitive of a mesh.
    pub(super) fn of_primitive(&self, [mesh, primitive]: [usize; 2]) -> Vec<(String, Accessor<'d>)> {
        let primitives = self.meshes.get(mesh).map(|mesh| &mesh.primitives);
        let primitive = primitives.and_then(|primitives| primitives.get(primitive));
        let own = primitive.into_iter().flat_map(|primitive| self.own(primitive));
        let is_wanted = |name: &str| self.wanted.name().is_none_or(|wanted| wanted == name);
        own.filter(|(name, accessor)| is_wanted(name) && accessor.dimensions() == Dimensions::Scalar)
            .map(|(name, accessor)| (name.to_owned(), accessor))
            .collect()
    }

    /// Whether vertices have their own colours.
    pub(super) fn shows_colors(&self) -> bool {
        self.wanted.shows_colors()
    }

    /// Whether vertices have numbers instead.
    pub(super) fn is_named(&self) -> bool {
        self.wanted.name().is_some()
    }

    /// The ranges that were counted.
    pub(super) fn listed(&self) -> Vec<Scalar> {
        let listed = self.ranges.iter().map(|(name, &range)| Scalar {
            name: name.clone(),
            of: Owner::Vertices,
            range,
        });
        listed.collect()
    }

    /// Counts numbers. If the file has more than `most`, no range is known: a part of the numbers would give a wrong one.
    fn count(&mut self, name: String, elements: &Elements<'_>, most: usize) {
        if self.work > most {
            return;
        }
        let counted = if let Some(&range) = self.counted.get(&elements.accessor) {
            range
        } else {
            self.work = self.work.saturating_add(elements.stored());
            if self.work > most {
                self.ranges.clear();
                return;
            }
            let range = elements.range();
            self.counted.insert(elements.accessor, range);
            range
        };
        let range = self.ranges.entry(name).or_default();
        *range = range.and(counted);
    }
}

impl<'a> Buffers<'a> {
    /// The numbers of a primitive that are shown. If ranges are wanted instead, those of its `vertices` are counted.
    pub(super) fn values(
        &mut self,
        primitive: [usize; 2],
        vertices: usize,
    ) -> Result<Option<Rc<Elements<'a>>>, LoadError> {
        let most = self.size().saturating_mul(MOST_COUNTED);
        for (name, accessor) in self.scalars().of_primitive(primitive) {
            if self.scalars().is_named() {
                return self.numbers(&accessor).map(Some);
            }
            // What is not shown may be faulty.
            if let Ok(elements) = self.numbers(&accessor)
                && elements.count == vertices
            {
                self.scalars_mut().count(name, &elements, most);
            }
        }
        Ok(None)
    }
}

//! Morph targets: differences that are added to a mesh, by its weights.
//!
//! The gltf crate reads only some of their attributes, so their part of the JSON is parsed separately.

use super::{buffers::Buffers, elements::Elements};
use crate::error::LoadError;
use glam::DVec3;
use gltf::{Document, json};
use serde::Deserialize;
use std::{collections::BTreeMap, path::Path, rc::Rc};

/// The morph targets of a file.
pub(super) struct MorphTargets<'d> {
    document: &'d Document,
    meshes: Vec<Mesh>,
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
    primitives: Vec<Targets>,
}

#[derive(Deserialize)]
struct Targets {
    /// Indices of accessors, by attribute.
    targets: Option<Vec<BTreeMap<String, usize>>>,
}

impl<'d> MorphTargets<'d> {
    /// Reads the JSON once more, but only if the file has targets.
    pub(super) fn of(text: &[u8], path: &Path, document: &'d Document) -> Result<Self, LoadError> {
        let mut meshes = Vec::new();
        if super::has(text, "\"targets\"") {
            let file: File = json::deserialize::from_slice(text).map_err(|error| {
                let place = [error.line(), error.column()];
                LoadError::in_json(path, place, "not valid morph targets", &error.to_string())
            })?;
            meshes = file.meshes;
        }
        Ok(Self { document, meshes })
    }

    /// How many targets a mesh has.
    pub(super) fn count(&self, mesh: usize) -> usize {
        let primitives = self.meshes.get(mesh).map_or(&[][..], |mesh| &mesh.primitives);
        let counts = primitives
            .iter()
            .map(|primitive| primitive.targets.as_ref().map_or(0, Vec::len));
        counts.max().unwrap_or(0)
    }

    /// Whether a mesh has targets.
    pub(super) fn has(&self, mesh: usize) -> bool {
        self.count(mesh) > 0
    }

    /// The differences that change a primitive of a mesh with this index. `uv_set` is the set of texture coordinates that
    /// it shows. Tangents are only read if it `has_tangents`. Targets without weight change nothing.
    pub(super) fn of_primitive<'a>(
        &self,
        [mesh, primitive]: [usize; 2],
        weights: &[f32],
        (uv_set, has_tangents): (Option<u32>, bool),
        buffers: &mut Buffers<'a>,
    ) -> Result<Vec<Difference<'a>>, LoadError> {
        let mut differences = Vec::new();
        let targets = self
            .meshes
            .get(mesh)
            .and_then(|mesh| mesh.primitives.get(primitive));
        let targets = targets.and_then(|primitive| primitive.targets.as_deref());
        let weighted = targets.unwrap_or_default().iter().zip(weights).enumerate();
        for (i, (target, &weight)) in weighted.filter(|(_, (_, weight))| **weight != 0.0) {
            for (name, &index) in target {
                let attribute = match name.as_str() {
                    "POSITION" => Attribute::Position,
                    "NORMAL" => Attribute::Normal,
                    "COLOR_0" => Attribute::Color,
                    "TANGENT" if has_tangents => Attribute::Tangent,
                    name if uv_set.is_some_and(|set| name == format!("TEXCOORD_{set}")) => {
                        Attribute::TexCoord
                    }
                    _ => continue,
                };
                let Some(accessor) = self.document.accessors().nth(index) else {
                    let count = self.document.accessors().len();
                    return Err(buffers.refused(format!(
                        "meshes[{mesh}].primitives[{primitive}].targets[{i}]: accessor {index}, but the file has only \
                         {count}"
                    )));
                };
                let elements = match attribute {
                    Attribute::Position | Attribute::Normal | Attribute::Tangent => {
                        buffers.vectors(&accessor)?
                    }
                    Attribute::Color => buffers.color_differences(&accessor)?,
                    Attribute::TexCoord => buffers.pairs(&accessor)?,
                };
                let room = buffers.budget().reserve(&mut differences, 1);
                room.map_err(|error| buffers.no_room(error))?;
                differences.push(Difference {
                    attribute,
                    weight: f64::from(weight),
                    elements,
                });
            }
        }
        Ok(differences)
    }
}

/// What a difference changes.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Attribute {
    Position,
    Normal,
    Color,
    TexCoord,
    /// Without its sign.
    Tangent,
}

/// What one target adds to one attribute of the vertices.
pub(super) struct Difference<'a> {
    attribute: Attribute,
    weight: f64,
    pub(super) elements: Rc<Elements<'a>>,
}

/// What the differences add to an attribute of vertex `i`.
pub(super) fn sum(differences: &[Difference<'_>], attribute: Attribute, i: usize) -> DVec3 {
    let mut sum = DVec3::ZERO;
    for difference in differences
        .iter()
        .filter(|difference| difference.attribute == attribute)
    {
        let numbers = match attribute {
            Attribute::Color => difference.elements.color(i),
            _ => difference.elements.vector(i),
        };
        sum += difference.weight * DVec3::from_array(numbers.map(f64::from));
    }
    sum
}

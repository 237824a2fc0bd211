//! Instances of nodes: the extension `EXT_mesh_gpu_instancing`, 2019.
//!
//! The gltf crate does not read it, so its part of the JSON is parsed separately, like that of lights.

use super::{buffers::Buffers, elements::Elements};
use crate::error::LoadError;
use glam::{DMat4, DQuat, DVec3};
use gltf::{Document, json};
use serde::Deserialize;
use std::{path::Path, rc::Rc};

const EXTENSION: &str = "EXT_mesh_gpu_instancing";

/// Which accessors have the instances of each node.
#[derive(Default)]
pub(super) struct Instancing(Vec<Option<Attributes>>);

/// Indices of accessors.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
struct Attributes {
    translation: Option<usize>,
    rotation: Option<usize>,
    scale: Option<usize>,
}

/// The parts of the JSON that matter here.
#[derive(Deserialize)]
struct Scene {
    #[serde(default)]
    nodes: Vec<Node>,
}

#[derive(Deserialize)]
struct Node {
    #[serde(default)]
    extensions: Option<Extensions>,
}

#[derive(Deserialize)]
struct Extensions {
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    instancing: Option<Instanced>,
}

#[derive(Deserialize)]
struct Instanced {
    attributes: Attributes,
}

impl Instancing {
    /// Reads the JSON once more, but only if the file uses the extension.
    pub(super) fn of(text: &[u8], path: &Path) -> Result<Self, LoadError> {
        if !super::has(text, EXTENSION) {
            return Ok(Self::default());
        }
        let Scene { nodes } = json::deserialize::from_slice(text).map_err(|error| {
            let place = [error.line(), error.column()];
            LoadError::in_json(path, place, &format!("not valid {EXTENSION}"), &error.to_string())
        })?;
        let attributes = nodes
            .into_iter()
            .map(|node| Some(node.extensions?.instancing?.attributes));
        Ok(Self(attributes.collect()))
    }

    /// The instances of a node; `None` if it places its mesh once.
    pub(super) fn at<'a>(
        &self,
        node: usize,
        document: &Document,
        buffers: &mut Buffers<'a>,
    ) -> Result<Option<Instances<'a>>, LoadError> {
        let Some(&Some(attributes)) = self.0.get(node) else {
            return Ok(None);
        };
        let refused = |message: String, buffers: &Buffers<'_>| {
            buffers.refused(format!("nodes[{node}].extensions.{EXTENSION}: {message}"))
        };
        let accessor = |index: usize, buffers: &Buffers<'_>| {
            let count = document.accessors().len();
            let message = || format!("accessor {index}, but the file has only {count}");
            document
                .accessors()
                .nth(index)
                .ok_or_else(|| refused(message(), buffers))
        };
        let vectors = |index: Option<usize>, buffers: &mut Buffers<'a>| match index {
            Some(index) => buffers.vectors(&accessor(index, buffers)?).map(Some),
            None => Ok(None),
        };
        let translation = vectors(attributes.translation, buffers)?;
        let scale = vectors(attributes.scale, buffers)?;
        let rotation = match attributes.rotation {
            Some(index) => Some(buffers.quaternions(&accessor(index, buffers)?)?),
            None => None,
        };
        let counts = [&translation, &rotation, &scale].map(|elements| Some(elements.as_ref()?.count));
        let mut counts = counts.into_iter().flatten();
        let Some(count) = counts.next() else {
            return Ok(None);
        };
        if let Some(other) = counts.find(|&other| other != count) {
            let message = format!("its accessors have {count} and {other} elements, expected equal numbers");
            return Err(refused(message, buffers));
        }
        Ok(Some(Instances {
            count,
            translation,
            rotation,
            scale,
        }))
    }
}

/// The instances of a node.
pub(super) struct Instances<'a> {
    /// How many there are.
    pub(super) count: usize,
    translation: Option<Rc<Elements<'a>>>,
    rotation: Option<Rc<Elements<'a>>>,
    scale: Option<Rc<Elements<'a>>>,
}

impl Instances<'_> {
    /// How instance `i` is placed in the space of its node.
    pub(super) fn transform(&self, i: usize, buffers: &Buffers<'_>) -> Result<DMat4, LoadError> {
        let faulty = |elements: &Elements<'_>, what: &str, expected: &str| {
            let (accessor, count) = (elements.accessor, elements.count);
            buffers.refused(format!(
                "accessors[{accessor}]: {what} {} of {count} {expected}",
                i + 1
            ))
        };
        let vector = |elements: &Option<Rc<Elements<'_>>>, what: &str, missing: DVec3| {
            let Some(elements) = elements else {
                return Ok(missing);
            };
            let vector = DVec3::from_array(elements.vector(i).map(f64::from));
            if vector.is_finite() {
                Ok(vector)
            } else {
                Err(faulty(elements, what, "has a number that is not finite"))
            }
        };
        let translation = vector(&self.translation, "translation", DVec3::ZERO)?;
        let scale = vector(&self.scale, "scale", DVec3::ONE)?;
        let mut rotation = DQuat::IDENTITY;
        if let Some(elements) = &self.rotation {
            let quaternion = DQuat::from_array(elements.numbers(i).map(f64::from));
            let length = quaternion.length();
            if !(length > 0.0 && length.is_finite()) {
                return Err(faulty(
                    elements,
                    "rotation",
                    "is no quaternion of a length above 0",
                ));
            }
            rotation = quaternion / length;
        }
        Ok(DMat4::from_scale_rotation_translation(
            scale,
            rotation,
            translation,
        ))
    }
}

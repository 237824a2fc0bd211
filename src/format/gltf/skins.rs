//! Skins: joints that bend a mesh, in the pose that the file stores.
//!
//! Each vertex is transformed by the weighted mean of its joints' matrices (glTF 2.0, section 3.7.3). The transform of the
//! node with the mesh is ignored.

use super::{buffers::Buffers, elements::Elements, tree::contains_itself};
use crate::{
    error::{LoadError, SceneError},
    format::left_out::counted,
};
use glam::DMat4;
use gltf::{Primitive, Semantic, Skin};
use std::{collections::HashMap, rc::Rc};

/// The matrices of a skin's joints.
pub(super) type Joints = Rc<Vec<DMat4>>;

/// The skins of a file; each is read once.
pub(super) struct Skins<'d> {
    /// The global transforms of all nodes.
    globals: &'d [Option<DMat4>],
    /// By index.
    read: HashMap<usize, Joints>,
}

impl<'d> Skins<'d> {
    pub(super) fn new(globals: &'d [Option<DMat4>]) -> Self {
        Self {
            globals,
            read: HashMap::new(),
        }
    }

    /// The matrices of the joints: they take vertices of the mesh to world space.
    pub(super) fn joints(&mut self, skin: &Skin<'_>, buffers: &mut Buffers<'_>) -> Result<Joints, LoadError> {
        let index = skin.index();
        if let Some(joints) = self.read.get(&index) {
            return Ok(Rc::clone(joints));
        }
        let count = skin.joints().len();
        if count == 0 {
            return Err(buffers.refused(format!("skins[{index}] has no joints")));
        }
        let inverses = match skin.inverse_bind_matrices() {
            Some(accessor) => Some(buffers.matrices(&accessor)?),
            None => None,
        };
        if let Some(inverses) = inverses.as_ref().filter(|inverses| inverses.count < count) {
            return Err(buffers.refused(format!(
                "accessors[{}] has {}, but skins[{index}] has {}",
                inverses.accessor,
                counted(inverses.count, "matrix", "matrices"),
                counted(count, "joint", "joints")
            )));
        }
        let mut joints = Vec::new();
        let room = buffers.budget().reserve(&mut joints, count);
        room.map_err(|error| buffers.no_room(error))?;
        for (i, joint) in skin.joints().enumerate() {
            let global = self.globals.get(joint.index()).copied().flatten();
            let global = global.ok_or_else(|| contains_itself(joint.index(), buffers))?;
            let inverse = match &inverses {
                Some(inverses) => matrix(inverses, i, buffers)?,
                None => DMat4::IDENTITY,
            };
            joints.push(global * inverse);
        }
        let joints = Rc::new(joints);
        self.read.insert(index, Rc::clone(&joints));
        Ok(joints)
    }
}

/// Matrix `i` of an accessor.
fn matrix(elements: &Elements<'_>, i: usize, buffers: &Buffers<'_>) -> Result<DMat4, LoadError> {
    let matrix = DMat4::from_cols_array(&elements.numbers(i).map(f64::from));
    if !matrix.is_finite() {
        let (accessor, count) = (elements.accessor, elements.count);
        return Err(buffers.refused(format!(
            "accessors[{accessor}]: matrix {} of {count} has a number that is not finite",
            i + 1
        )));
    }
    Ok(matrix)
}

/// The joints that move the vertices of a primitive.
pub(super) struct Skinning<'a> {
    joints: Joints,
    /// Numbers of joints, and weights: four of both for each vertex.
    sets: Vec<[Rc<Elements<'a>>; 2]>,
}

impl<'a> Skinning<'a> {
    /// `None` if the primitive, whose mesh has the index `mesh`, does not name joints.
    pub(super) fn of(
        mesh: usize,
        primitive: &Primitive<'_>,
        joints: &Joints,
        buffers: &mut Buffers<'a>,
    ) -> Result<Option<Self>, LoadError> {
        let mut sets = Vec::new();
        for set in 0.. {
            let accessors =
                [Semantic::Joints(set), Semantic::Weights(set)].map(|semantic| primitive.get(&semantic));
            let elements = match accessors {
                [Some(joints), Some(weights)] => [buffers.joints(&joints)?, buffers.weights(&weights)?],
                [None, None] => break,
                [joints, _] => {
                    let (has, misses) = if joints.is_some() {
                        ("JOINTS", "WEIGHTS")
                    } else {
                        ("WEIGHTS", "JOINTS")
                    };
                    return Err(buffers.refused(format!(
                        "meshes[{mesh}].primitives[{}] has {has}_{set} but no {misses}_{set}",
                        primitive.index()
                    )));
                }
            };
            let room = buffers.budget().reserve(&mut sets, 1);
            room.map_err(|error| buffers.no_room(error))?;
            sets.push(elements);
        }
        Ok((!sets.is_empty()).then(|| Self {
            joints: Rc::clone(joints),
            sets,
        }))
    }

    /// How many sets of joints and weights each vertex has.
    pub(super) fn set_count(&self) -> usize {
        self.sets.len()
    }

    /// All accessors, for checks of their counts.
    pub(super) fn elements(&self) -> impl Iterator<Item = &Elements<'a>> {
        self.sets.iter().flatten().map(|elements| &**elements)
    }

    /// The matrix that takes vertex `i` to world space.
    pub(super) fn matrix(&self, i: usize, buffers: &Buffers<'_>) -> Result<DMat4, LoadError> {
        let refused = |elements: &Elements<'_>, message: String| {
            let (accessor, count) = (elements.accessor, elements.count);
            buffers.refused(format!(
                "accessors[{accessor}]: vertex {} of {count}: {message}",
                i + 1
            ))
        };
        let joint = |elements: &Elements<'_>, joint: usize| {
            let count = self.joints.len();
            let message = || {
                format!(
                    "joint {joint}, but the skin has only {}",
                    counted(count, "joint", "joints")
                )
            };
            self.joints.get(joint).ok_or_else(|| refused(elements, message()))
        };
        let (mut sum, mut total) = (DMat4::ZERO, 0.0);
        for [joints, weights] in &self.sets {
            for (number, value) in joints.joints(i).into_iter().zip(weights.numbers::<4>(i)) {
                if !value.is_finite() {
                    let error = SceneError::NotUsable {
                        what: "weight",
                        value,
                    };
                    return Err(refused(weights, error.to_string()));
                }
                // Joints without weight may have any number.
                if value != 0.0 {
                    let weight = f64::from(value);
                    sum += *joint(joints, number)? * weight;
                    total += weight;
                }
            }
        }
        match self.sets.first() {
            // Other programs do the same.
            Some([joints, _]) if total <= 0.0 => Ok(*joint(joints, joints.joints(i)[0])?),
            _ => Ok(sum * total.recip()),
        }
    }
}

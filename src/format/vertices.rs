//! Vertices of meshes that index positions and attributes separately, such as OBJ's normals and texture coordinates: a
//! position with several attributes becomes several vertices.

use super::budget::{Budget, BudgetError};
#[cfg(any(feature = "gltf", feature = "threemf"))]
use crate::{
    error::SceneError,
    scene::{TriangleMesh, is_usable},
};
use std::collections::HashMap;

/// Adds a position. The error is about its first coordinate that is not usable; the position is added all the same.
#[cfg(any(feature = "gltf", feature = "threemf"))]
pub(super) fn add_position(mesh: &mut TriangleMesh, [x, y, z]: [f32; 3]) -> Result<(), SceneError> {
    mesh.x.push(x);
    mesh.y.push(y);
    mesh.z.push(z);
    let all = [("x", x), ("y", y), ("z", z)];
    match all.into_iter().find(|(_, value)| !is_usable(*value)) {
        Some((what, value)) => Err(SceneError::NotUsable { what, value }),
        None => Ok(()),
    }
}

/// A corner without an attribute.
pub(super) const NONE: u32 = u32::MAX;

/// How many vertices at one position are searched in turn.
const MOST_STEPS: usize = 16;

/// The vertices: one for each position, and more for its further attributes.
pub(super) struct Vertices<'a> {
    budget: &'a Budget,
    /// Each vertex's attributes, once a corner sets them.
    attributes: Vec<Option<[u32; 2]>>,
    /// The next vertex at the same position.
    next: Vec<u32>,
    /// The vertex by position and attributes, beyond [`MOST_STEPS`] at a position.
    others: HashMap<[u32; 3], u32>,
}

/// Memory of an entry of [`Vertices::others`], bytes: it may be half empty, and moves as it grows.
const ENTRY_BYTES: usize = 64;

impl<'a> Vertices<'a> {
    pub(super) fn new(positions: usize, budget: &'a Budget) -> Result<Self, BudgetError> {
        let (mut attributes, mut next) = (Vec::new(), Vec::new());
        budget.reserve(&mut attributes, positions)?;
        budget.reserve(&mut next, positions)?;
        attributes.resize(positions, None);
        next.resize(positions, NONE);
        Ok(Self {
            budget,
            attributes,
            next,
            others: HashMap::new(),
        })
    }

    /// The vertex with this position and these attributes.
    pub(super) fn vertex(&mut self, position: u32, own: [u32; 2]) -> Result<u32, BudgetError> {
        let (mut vertex, mut steps) = (position, 0);
        loop {
            let at = vertex as usize;
            match self.attributes[at] {
                None => {
                    self.attributes[at] = Some(own);
                    return Ok(vertex);
                }
                Some(other) if other == own => return Ok(vertex),
                Some(_) if steps == MOST_STEPS => break,
                Some(_) if self.next[at] == NONE => {
                    self.next[at] = self.add(own)?;
                    return Ok(self.next[at]);
                }
                Some(_) => vertex = self.next[at],
            }
            steps += 1;
        }
        let key = [position, own[0], own[1]];
        if let Some(&vertex) = self.others.get(&key) {
            return Ok(vertex);
        }
        self.budget.take(ENTRY_BYTES)?;
        let reserved = self.others.try_reserve(1);
        reserved.map_err(|_| BudgetError::NoMemory)?;
        let copy = self.add(own)?;
        self.others.insert(key, copy);
        Ok(copy)
    }

    /// The attributes of all vertices; `None` if no corner has the vertex.
    pub(super) fn into_attributes(self) -> Vec<Option<[u32; 2]>> {
        let others = self.others.len() * ENTRY_BYTES;
        self.budget
            .give_back(self.next.capacity() * size_of::<u32>() + others);
        self.attributes
    }

    /// Adds a vertex.
    fn add(&mut self, own: [u32; 2]) -> Result<u32, BudgetError> {
        self.budget.reserve(&mut self.attributes, 1)?;
        self.budget.reserve(&mut self.next, 1)?;
        self.attributes.push(Some(own));
        self.next.push(NONE);
        Ok(self.attributes.len() as u32 - 1)
    }
}

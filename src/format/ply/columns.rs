//! The arrays of vertices, which the fast paths fill in pieces.

use super::{
    fault::Fault,
    header::Element,
    rows::{reserve, zeroed},
};
use crate::{format::budget::Budget, scene::TriangleMesh};
use glam::Vec3;
use rayon::{iter::repeat_n, prelude::*};

/// What a file says about vertices beside their positions.
#[derive(Clone, Copy)]
pub(super) struct Attributes {
    pub(super) normals: bool,
    pub(super) colors: bool,
    pub(super) uvs: bool,
}

/// One array per attribute: of all vertices, or empty if the file lacks it.
pub(super) struct VertexColumns {
    positions: [Vec<f32>; 3],
    normals: Vec<Vec3>,
    colors: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
}

/// Consecutive vertices of [`VertexColumns`].
pub(super) struct Piece<'a> {
    pub(super) x: &'a mut [f32],
    pub(super) y: &'a mut [f32],
    pub(super) z: &'a mut [f32],
    pub(super) normals: &'a mut [Vec3],
    pub(super) colors: &'a mut [[f32; 3]],
    pub(super) uvs: &'a mut [[f32; 2]],
}

impl VertexColumns {
    /// Arrays of zeros for all vertices.
    ///
    /// # Errors
    /// They do not fit into memory.
    pub(super) fn zeroed(element: &Element, has: Attributes, budget: &Budget) -> Result<Self, Fault> {
        let count = element.count;
        let if_any = |has| if has { count } else { 0 };
        let column = || zeroed(count, element, budget);
        let positions = [column()?, column()?, column()?];
        let mut normals = Vec::new();
        if has.normals {
            // `vec!` takes zeroed pages only for numbers; vectors are written, so all threads take part.
            reserve(&mut normals, count, element, budget)?;
            normals.par_extend(repeat_n(Vec3::ZERO, count));
        }
        Ok(Self {
            positions,
            normals,
            colors: zeroed(if_any(has.colors), element, budget)?,
            uvs: zeroed(if_any(has.uvs), element, budget)?,
        })
    }

    /// Pieces of these lengths from the first vertex on, the last ones shorter if the vertices end.
    pub(super) fn pieces(&mut self, lengths: impl Iterator<Item = usize>) -> Vec<Piece<'_>> {
        let [mut x, mut y, mut z] = self.positions.each_mut().map(Vec::as_mut_slice);
        let (mut normals, mut colors) = (&mut self.normals[..], &mut self.colors[..]);
        let mut uvs = &mut self.uvs[..];
        lengths
            .map(|length| Piece {
                x: split_off(&mut x, length),
                y: split_off(&mut y, length),
                z: split_off(&mut z, length),
                normals: split_off(&mut normals, length),
                colors: split_off(&mut colors, length),
                uvs: split_off(&mut uvs, length),
            })
            .collect()
    }

    /// Moves the arrays into the mesh.
    pub(super) fn move_into(self, mesh: &mut TriangleMesh) {
        [mesh.x, mesh.y, mesh.z] = self.positions;
        (mesh.normals, mesh.colors, mesh.uvs) = (self.normals, self.colors, self.uvs);
    }
}

/// Takes the first `length` elements, or all if there are fewer.
#[expect(clippy::mut_mut, reason = "the slice itself is shortened")]
fn split_off<'a, T>(rest: &mut &'a mut [T], length: usize) -> &'a mut [T] {
    rest.split_off_mut(..length.min(rest.len())).unwrap_or_default()
}

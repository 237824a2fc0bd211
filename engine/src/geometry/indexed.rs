//! Leaf blocks of triangles that share their vertices.
//!
//!   one cache line per axis:  12 coordinates | 3 ids | 8 x 4 bits: first (second, third) corners

use super::TriangleBlock;
use crate::{
    lanes::{LANES, Vec3x8},
    ray::PrimitiveId,
    simd::{Column, EightLanes, Simd, TriangleLanes, Vec3Lanes},
};
use glam::Vec3;

/// Up to eight triangles whose corners are at most twelve vertices: three cache lines, where a [`TriangleBlock`]
/// takes five.
///
/// A line per axis: the vertices' coordinates, three ids, and a word with the vertex indices of the eight first, second
/// or third corners, four bits each.
#[derive(Clone, Copy, Debug)]
pub struct IndexedBlock {
    lines: [Line; 3],
}

/// See [`IndexedBlock`].
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(64))]
struct Line {
    /// Coordinates along one axis.
    at: [f32; IndexedBlock::MOST_VERTICES],
    /// Three of the ids.
    ids: [u32; 3],
    /// One corner of each triangle, four bits each.
    corners: u32,
}

impl Line {
    const EMPTY: Self = Self {
        at: [0.0; IndexedBlock::MOST_VERTICES],
        ids: [PrimitiveId::NONE.0; 3],
        corners: 0,
    };
}

impl IndexedBlock {
    /// The most vertices of a block.
    pub const MOST_VERTICES: usize = 12;

    /// Creates a block of at most eight triangles from their ids, the vertex ids of their corners, and the corners; `None` if
    /// there are too many vertices. Lanes past the last triangle repeat a point.
    #[must_use]
    pub fn new(triangles: &[(PrimitiveId, [u32; 3], [Vec3; 3])]) -> Option<Self> {
        debug_assert!(triangles.len() <= LANES, "{} triangles", triangles.len());
        let mut names = Names::default();
        let mut lines = [Line::EMPTY; 3];
        for (lane, &(id, corners, at)) in triangles.iter().enumerate().take(LANES) {
            lines[lane / 3].ids[lane % 3] = id.0;
            for (corner, &name) in corners.iter().enumerate() {
                let vertex = names.place_of(name)?;
                lines[corner].corners |= (vertex as u32) << (4 * lane);
                for (line, coordinate) in lines.iter_mut().zip(at[corner].to_array()) {
                    line.at[vertex] = coordinate;
                }
            }
        }
        Some(Self { lines })
    }

    /// Returns whether at most eight triangles with these vertex ids have few enough vertices for a block.
    #[inline]
    #[must_use]
    pub fn fits(triangles: impl ExactSizeIterator<Item = [u32; 3]>) -> bool {
        if 3 * triangles.len() <= Self::MOST_VERTICES {
            return true;
        }
        let mut names = Names::default();
        for corners in triangles {
            for name in corners {
                if names.place_of(name).is_none() {
                    return false;
                }
            }
        }
        true
    }

    /// Coordinates of the vertices, an array per axis.
    #[inline(always)]
    fn axes(&self) -> &[Column; 3] {
        bytemuck::cast_ref(&self.lines)
    }

    /// The words with the indices of the first, second and third corners.
    #[inline(always)]
    fn places(&self) -> [u32; 3] {
        let [x, y, z] = &self.lines;
        [x.corners, y.corners, z.corners]
    }

    /// The vertices with these indices.
    #[inline(always)]
    fn corner<S: Simd>(&self, simd: S, places: u32) -> Vec3x8 {
        let [x, y, z] = self.axes();
        Vec3x8::new(
            S::V8::picked8(simd, x, places).to8(),
            S::V8::picked8(simd, y, places).to8(),
            S::V8::picked8(simd, z, places).to8(),
        )
    }

    /// Returns first, second and third corners: of two blocks in vectors of sixteen lanes, else of the first.
    #[inline(always)]
    #[must_use]
    pub(crate) fn corners<V: TriangleLanes>(simd: V::Simd, [low, high]: [&Self; 2]) -> [Vec3Lanes<V>; 3] {
        let ([x0, y0, z0], [x1, y1, z1]) = (low.axes(), high.axes());
        let ([a0, b0, c0], [a1, b1, c1]) = (low.places(), high.places());
        let (a, b, c) = ([a0, a1], [b0, b1], [c0, c1]);
        [
            Vec3Lanes {
                x: V::picked(simd, [x0, x1], a),
                y: V::picked(simd, [y0, y1], a),
                z: V::picked(simd, [z0, z1], a),
            },
            Vec3Lanes {
                x: V::picked(simd, [x0, x1], b),
                y: V::picked(simd, [y0, y1], b),
                z: V::picked(simd, [z0, z1], b),
            },
            Vec3Lanes {
                x: V::picked(simd, [x0, x1], c),
                y: V::picked(simd, [y0, y1], c),
                z: V::picked(simd, [z0, z1], c),
            },
        ]
    }

    /// Returns the block with whole triangles.
    #[inline(always)]
    #[must_use]
    pub(crate) fn whole<S: Simd>(&self, simd: S) -> TriangleBlock {
        let ([a, b, c], [x, y, z]) = (self.places(), &self.lines);
        TriangleBlock {
            v0: self.corner(simd, a),
            v1: self.corner(simd, b),
            v2: self.corner(simd, c),
            id: [
                x.ids[0], x.ids[1], x.ids[2], y.ids[0], y.ids[1], y.ids[2], z.ids[0], z.ids[1],
            ],
        }
    }

    /// Returns the id of triangle `lane`, as the raw value of [`PrimitiveId`].
    #[inline(always)]
    #[must_use]
    pub fn id(&self, lane: usize) -> u32 {
        let lane = lane % LANES;
        self.lines[lane / 3].ids[lane % 3]
    }

    /// Returns the corners of triangle `lane`.
    #[must_use]
    pub fn triangle(&self, lane: usize) -> [Vec3; 3] {
        let [x, y, z] = &self.lines;
        let corner = |line: &Line| {
            let vertex = (line.corners >> (4 * lane)) as usize & 15;
            Vec3::new(x.at[vertex], y.at[vertex], z.at[vertex])
        };
        [corner(x), corner(y), corner(z)]
    }
}

/// Vertex ids in the order of their first use.
#[derive(Default)]
struct Names {
    names: [u32; IndexedBlock::MOST_VERTICES],
    count: usize,
}

impl Names {
    /// The index of a vertex, which is added if it is new; `None` if the block is full.
    #[inline(always)]
    fn place_of(&mut self, name: u32) -> Option<usize> {
        let mut place = self.count;
        for (i, &known) in self.names[..self.count].iter().enumerate() {
            if known == name {
                place = i;
                break;
            }
        }
        if place == self.count {
            *self.names.get_mut(place)? = name;
            self.count += 1;
        }
        Some(place)
    }
}

#[cfg(test)]
mod tests;

//! Smooth vertex normals for meshes that have none.

use super::{TriangleMesh, weld::weld};
use crate::error::SceneError;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::collections::HashMap;

/// The most faces around a vertex that are compared with each other, which takes quadratic time. Vertices with more have
/// no creases.
const MAX_FACES: usize = 512;

/// Peak memory, bytes per vertex and per triangle, if each corner gets its own vertex.
const BYTES: [usize; 2] = [44, 164];

impl TriangleMesh {
    /// Gives a mesh without normals smooth ones; a mesh that has normals stays as it is.
    ///
    /// The normal at a corner is the mean of the face normals around the vertex that are within `crease_degrees` of its
    /// own face's, weighted by angle (Thürmer and Wüthrich, *Computing Vertex Normals from Polygonal Facets*, 1998).
    /// Vertices at the same position are welded first, and split where normals, colours, texture coordinates or tangents differ.
    /// The result does not depend on the machine or the number of threads.
    ///
    /// # Errors
    /// [`SceneError::TooMany`] or [`SceneError::NoMemory`]; the mesh is unchanged then.
    ///
    /// # Panics
    /// If arrays differ in length, or a vertex index is out of range.
    pub fn smooth_normals(&mut self, crease_degrees: f64) -> Result<(), SceneError> {
        if !self.normals.is_empty() || self.triangles.is_empty() {
            return Ok(());
        }
        self.check_room()?;
        let welded = weld(&self.x, &self.y, &self.z);
        let adjacency = Adjacency::new(&self.triangles, &welded);
        let limit = libm::cos(crease_degrees.clamp(0.0, 180.0).to_radians()) as f32 - 1e-6;
        let normals = self.corner_normals(&welded, &adjacency, limit);
        let first = (0..normals.len() as u32).into_par_iter().map(|corner| {
            let normal = normals[corner as usize];
            let others = adjacency.corners(welded[self.corner(corner) as usize]);
            let own = |corner: u32| {
                let vertex = self.corner(corner) as usize;
                (
                    self.colors.get(vertex),
                    self.uvs.get(vertex),
                    self.tangents.get(vertex),
                )
            };
            let mut compared = others.iter().take(MAX_FACES);
            // An extra vertex costs less than a long search.
            let equal =
                compared.find(|&&other| normals[other as usize] == normal && own(other) == own(corner));
            equal.copied().unwrap_or(corner)
        });
        let first: Vec<u32> = first.collect();
        drop(adjacency);
        self.split(&normals, &first, &welded);
        Ok(())
    }

    /// Checks that the arrays can be allocated. Untouched memory costs nothing.
    fn check_room(&self) -> Result<(), SceneError> {
        const MOST: usize = u32::MAX as usize / 3;
        let [vertex, triangle] = BYTES;
        let bytes = self.x.len() * vertex + self.triangles.len() * triangle;
        let mut room: Vec<u8> = Vec::new();
        let reserved = room.try_reserve_exact(bytes);
        // Keeps the compiler from removing the allocation.
        std::hint::black_box(&room);
        if self.triangles.len() > MOST {
            let (what, limit) = ("triangles", MOST);
            return Err(SceneError::TooMany { what, limit });
        }
        reserved.map_err(|_| SceneError::NoMemory { what: "normals" })
    }

    /// The vertex at corner `i % 3` of triangle `i / 3`.
    fn corner(&self, i: u32) -> u32 {
        self.triangles.as_flattened()[i as usize]
    }

    fn position(&self, vertex: u32) -> DVec3 {
        let i = vertex as usize;
        DVec3::new(self.x[i].into(), self.y[i].into(), self.z[i].into())
    }

    /// The angle of a triangle at a corner.
    fn angle(&self, corner: u32) -> f32 {
        let first = corner / 3 * 3;
        let [p, q, r] = [0, 1, 2].map(|k| self.position(self.corner(first + (corner - first + k) % 3)));
        let (a, b) = ((q - p).normalize_or_zero(), (r - p).normalize_or_zero());
        libm::acos(a.dot(b).clamp(-1.0, 1.0)) as f32
    }

    /// The normal at each corner; `limit` is the cosine of the crease angle.
    fn corner_normals(&self, welded: &[u32], adjacency: &Adjacency, limit: f32) -> Vec<Vec3> {
        let faces = self.triangles.par_iter().map(|&[a, b, c]| {
            let [a, b, c] = [a, b, c].map(|vertex| self.position(vertex));
            (b - a).cross(c - a).normalize_or_zero().as_vec3()
        });
        let faces: Vec<Vec3> = faces.collect();
        let angles = (0..3 * faces.len() as u32).into_par_iter();
        let angles: Vec<f32> = angles.map(|corner| self.angle(corner)).collect();
        let face = |corner: u32| faces[corner as usize / 3];
        let add = |sum: Vec3, &corner: &u32| sum + face(corner) * angles[corner as usize];
        // Summed once: around a hub all corners have the same sum.
        let hubs = (0..welded.len() as u32).into_par_iter().filter_map(|vertex| {
            let corners = adjacency.corners(vertex);
            (corners.len() > MAX_FACES).then(|| (vertex, corners.iter().fold(Vec3::ZERO, add)))
        });
        let hubs: HashMap<u32, Vec3> = hubs.collect();
        let normals = (0..3 * faces.len() as u32).into_par_iter().map(|corner| {
            let own = face(corner);
            let vertex = welded[self.corner(corner) as usize];
            let corners = adjacency.corners(vertex);
            if corners.len() > MAX_FACES {
                return hubs[&vertex].normalize_or(own);
            }
            let is_near = |other: &&u32| own == Vec3::ZERO || face(**other).dot(own) >= limit;
            let sum = corners.iter().filter(is_near).fold(Vec3::ZERO, add);
            sum.normalize_or(own)
        });
        normals.collect()
    }

    /// Replaces the vertices by one for each corner that is its own `first`: the first corner at its position with its
    /// normal, colour, texture coordinates and tangent.
    fn split(&mut self, normals: &[Vec3], first: &[u32], welded: &[u32]) {
        let is_new = |corner: usize| first[corner] as usize == corner;
        let count = (0..first.len()).filter(|&corner| is_new(corner)).count();
        let [mut x, mut y, mut z] = [(); 3].map(|()| Vec::with_capacity(count));
        let mut colors = Vec::with_capacity(if self.colors.is_empty() { 0 } else { count });
        let mut uvs = Vec::with_capacity(if self.uvs.is_empty() { 0 } else { count });
        let mut tangents = Vec::with_capacity(if self.tangents.is_empty() { 0 } else { count });
        self.normals.reserve_exact(count);
        let corners = self.triangles.as_flattened_mut();
        for corner in 0..first.len() {
            let vertex = corners[corner] as usize;
            let at = welded[vertex] as usize;
            corners[corner] = if is_new(corner) {
                x.push(self.x[at]);
                y.push(self.y[at]);
                z.push(self.z[at]);
                self.normals.push(normals[corner]);
                colors.extend(self.colors.get(vertex));
                uvs.extend(self.uvs.get(vertex));
                tangents.extend(self.tangents.get(vertex));
                x.len() as u32 - 1
            } else {
                corners[first[corner] as usize]
            };
        }
        (self.x, self.y, self.z) = (x, y, z);
        (self.colors, self.uvs, self.tangents) = (colors, uvs, tangents);
    }
}

/// The corners at each welded vertex, in the order of the faces: `3 i + k` is corner `k` of triangle `i`.
struct Adjacency {
    start: Vec<u32>,
    corners: Vec<u32>,
}

impl Adjacency {
    fn new(triangles: &[[u32; 3]], welded: &[u32]) -> Self {
        let mut start = vec![0; welded.len() + 1];
        for &vertex in triangles.as_flattened() {
            start[welded[vertex as usize] as usize + 1] += 1;
        }
        for i in 1..start.len() {
            start[i] += start[i - 1];
        }
        let mut free = start.clone();
        let mut corners = vec![0; 3 * triangles.len()];
        for (corner, &vertex) in triangles.as_flattened().iter().enumerate() {
            let slot = &mut free[welded[vertex as usize] as usize];
            corners[*slot as usize] = corner as u32;
            *slot += 1;
        }
        Self { start, corners }
    }

    fn corners(&self, vertex: u32) -> &[u32] {
        let vertex = vertex as usize;
        &self.corners[self.start[vertex] as usize..self.start[vertex + 1] as usize]
    }
}

#[cfg(test)]
mod tests;

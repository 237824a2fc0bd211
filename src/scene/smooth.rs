//! Smooth vertex normals for meshes that have none.

use super::{TriangleMesh, weld::weld};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// The most faces around a vertex that are searched for creases: the search is quadratic.
const MAX_FACES: usize = 512;

impl TriangleMesh {
    /// Gives a mesh without normals smooth ones; a mesh that has normals stays as it is.
    ///
    /// The normal at a corner is the mean of the face normals around the vertex that are within `crease_degrees` of its
    /// own face's, weighted by angle (Thürmer and Wüthrich, *Computing Vertex Normals from Polygonal Facets*, 1998).
    /// Vertices at the same position are welded first, and split where the normals differ. The result does not depend
    /// on the machine or the number of threads.
    pub fn smooth_normals(&mut self, crease_degrees: f64) {
        if !self.normals.is_empty() || self.triangles.is_empty() {
            return;
        }
        let welded = weld(&self.x, &self.y, &self.z);
        let position = |i: u32| {
            let i = i as usize;
            DVec3::new(self.x[i].into(), self.y[i].into(), self.z[i].into())
        };
        let faces: Vec<Vec3> = self
            .triangles
            .par_iter()
            .map(|&[a, b, c]| {
                let normal = (position(b) - position(a)).cross(position(c) - position(a));
                normal.normalize_or_zero().as_vec3()
            })
            .collect();
        let adjacency = Adjacency::new(&self.triangles, &welded);
        let limit = libm::cos(crease_degrees.clamp(0.0, 180.0).to_radians()) as f32 - 1e-6;

        let corner = |i: u32| (self.triangles[i as usize / 3], i as usize % 3);
        let angle = |i: u32| {
            let (corners, k) = corner(i);
            let [p, q, r] = [k, (k + 1) % 3, (k + 2) % 3].map(|k| position(corners[k]));
            let (a, b) = ((q - p).normalize_or_zero(), (r - p).normalize_or_zero());
            libm::acos(a.dot(b).clamp(-1.0, 1.0)) as f32
        };
        let normals: Vec<Vec3> = (0..3 * self.triangles.len() as u32)
            .into_par_iter()
            .map(|i| {
                let (corners, k) = corner(i);
                let own = faces[i as usize / 3];
                let others = adjacency.corners(welded[corners[k] as usize]);
                let all = others.len() > MAX_FACES || own == Vec3::ZERO;
                let near = others
                    .iter()
                    .filter(|&&other| all || faces[other as usize / 3].dot(own) >= limit);
                let sum = near.fold(Vec3::ZERO, |sum, &other| {
                    sum + faces[other as usize / 3] * angle(other)
                });
                sum.normalize_or(own)
            })
            .collect();
        self.split(&normals, &welded);
    }

    /// Replaces the vertices by one for each distinct normal at each welded position.
    fn split(&mut self, normals: &[Vec3], welded: &[u32]) {
        const NONE: u32 = u32::MAX;
        // Linked lists: the first new vertex of each position, and the next one at the same position.
        let mut first = vec![NONE; welded.len()];
        let mut next: Vec<u32> = Vec::new();
        let (mut x, mut y, mut z) = (Vec::new(), Vec::new(), Vec::new());
        for (corner, vertex) in self.triangles.as_flattened_mut().iter_mut().enumerate() {
            let normal = normals[corner];
            let at = welded[*vertex as usize] as usize;
            let mut found = first[at];
            let mut steps = 0;
            while found != NONE && self.normals[found as usize] != normal {
                found = next[found as usize];
                steps += 1;
                // An extra vertex costs less than a long search.
                if steps > MAX_FACES {
                    found = NONE;
                }
            }
            if found == NONE {
                found = next.len() as u32;
                next.push(first[at]);
                first[at] = found;
                self.normals.push(normal);
                x.push(self.x[at]);
                y.push(self.y[at]);
                z.push(self.z[at]);
            }
            *vertex = found;
        }
        (self.x, self.y, self.z) = (x, y, z);
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
mod tests {
    use super::*;

    /// Two squares that meet at `degrees` and share no vertices.
    fn roof(degrees: f64) -> TriangleMesh {
        let (s, c) = (
            libm::sin(degrees.to_radians()) as f32,
            libm::cos(degrees.to_radians()) as f32,
        );
        TriangleMesh {
            x: vec![-1.0, 0.0, 0.0, -1.0, 0.0, c, c, 0.0],
            y: vec![0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0],
            z: vec![0.0, 0.0, 0.0, 0.0, 0.0, s, s, 0.0],
            normals: Vec::new(),
            triangles: vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]],
        }
    }

    #[test]
    fn a_blunt_edge_is_smoothed_and_a_sharp_one_kept() {
        let mut blunt = roof(20.0);
        blunt.smooth_normals(30.0);
        // The two vertices of the edge are shared now; their normals lie between those of the faces.
        assert_eq!(blunt.x.len(), 6);
        let edge = blunt.triangles[0][1] as usize;
        let expected = DVec3::new(
            -libm::sin(10_f64.to_radians()),
            0.0,
            libm::cos(10_f64.to_radians()),
        );
        assert!((blunt.normals[edge].as_dvec3() - expected).length() < 1e-6);

        let mut sharp = roof(40.0);
        sharp.smooth_normals(30.0);
        assert_eq!(sharp.x.len(), 8);
        assert_eq!(sharp.normals[sharp.triangles[0][1] as usize], Vec3::Z);
    }

    #[test]
    fn existing_normals_are_kept() {
        let mut mesh = roof(20.0);
        mesh.normals = vec![Vec3::X; 8];
        mesh.smooth_normals(30.0);
        assert_eq!(mesh.normals, [Vec3::X; 8]);
        TriangleMesh::default().smooth_normals(30.0);
    }
}

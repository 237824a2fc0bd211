//! Vertex normals for meshes that have none.

use super::{MeshColumns, weld::first_at_place};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Above this many faces around a vertex, creases are not looked for there: each face would be held against each.
const MOST_FACES: usize = 512;

impl MeshColumns {
    /// Gives a mesh without normals smooth ones: at each corner the mean, weighted by the angles at the vertex (Thürmer
    /// and Wüthrich, *Computing Vertex Normals from Polygonal Facets*, 1998), of the faces around it whose normals are
    /// within `crease_degrees` of its own face's. Vertices are split where the normals differ, and those at the same
    /// place count as one. A mesh that has normals is left as it is.
    ///
    /// The result depends on the mesh alone, not on the machine or the number of threads.
    pub fn smooth_normals(&mut self, crease_degrees: f64) {
        if !self.normals.is_empty() || self.triangles.is_empty() {
            return;
        }
        let place = first_at_place(&self.x, &self.y, &self.z);
        let at = |i: u32| {
            let i = i as usize;
            DVec3::new(self.x[i].into(), self.y[i].into(), self.z[i].into())
        };
        let faces: Vec<Vec3> = self
            .triangles
            .par_iter()
            .map(|&[a, b, c]| {
                let normal = (at(b) - at(a)).cross(at(c) - at(a));
                normal.normalize_or_zero().as_vec3()
            })
            .collect();
        let around = Around::new(&self.triangles, &place);
        let limit = libm::cos(crease_degrees.clamp(0.0, 180.0).to_radians()) as f32 - 1e-6;

        // The angle of each corner, then its normal.
        let corner = |i: u32| (self.triangles[i as usize / 3], i as usize % 3);
        let angle = |i: u32| {
            let (corners, k) = corner(i);
            let [p, q, r] = [k, (k + 1) % 3, (k + 2) % 3].map(|k| at(corners[k]));
            let (a, b) = ((q - p).normalize_or_zero(), (r - p).normalize_or_zero());
            libm::acos(a.dot(b).clamp(-1.0, 1.0)) as f32
        };
        let normals: Vec<Vec3> = (0..3 * self.triangles.len() as u32)
            .into_par_iter()
            .map(|i| {
                let (corners, k) = corner(i);
                let own = faces[i as usize / 3];
                let others = around.corners(place[corners[k] as usize]);
                let all = others.len() > MOST_FACES || own == Vec3::ZERO;
                let near = others
                    .iter()
                    .filter(|&&other| all || faces[other as usize / 3].dot(own) >= limit);
                let sum = near.fold(Vec3::ZERO, |sum, &other| {
                    sum + faces[other as usize / 3] * angle(other)
                });
                sum.normalize_or(own)
            })
            .collect();
        self.split(&normals, &place);
    }

    /// Makes vertices of corners: one for each normal at each place.
    fn split(&mut self, normals: &[Vec3], place: &[u32]) {
        const NONE: u32 = u32::MAX;
        // For each place its first new vertex, and for each new vertex the next one at the same place.
        let mut first = vec![NONE; place.len()];
        let mut next: Vec<u32> = Vec::new();
        let (mut x, mut y, mut z) = (Vec::new(), Vec::new(), Vec::new());
        for (corner, vertex) in self.triangles.as_flattened_mut().iter_mut().enumerate() {
            let normal = normals[corner];
            let at = place[*vertex as usize] as usize;
            let mut found = first[at];
            let mut steps = 0;
            while found != NONE && self.normals[found as usize] != normal {
                found = next[found as usize];
                steps += 1;
                // A vertex too many costs less than a long search.
                if steps > MOST_FACES {
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

/// The corners around each place, in the order of the faces: corner `3 i + k` is corner `k` of triangle `i`.
struct Around {
    start: Vec<u32>,
    corners: Vec<u32>,
}

impl Around {
    fn new(triangles: &[[u32; 3]], place: &[u32]) -> Self {
        let mut start = vec![0; place.len() + 1];
        for &vertex in triangles.as_flattened() {
            start[place[vertex as usize] as usize + 1] += 1;
        }
        for i in 1..start.len() {
            start[i] += start[i - 1];
        }
        let mut free = start.clone();
        let mut corners = vec![0; 3 * triangles.len()];
        for (corner, &vertex) in triangles.as_flattened().iter().enumerate() {
            let slot = &mut free[place[vertex as usize] as usize];
            corners[*slot as usize] = corner as u32;
            *slot += 1;
        }
        Self { start, corners }
    }

    fn corners(&self, place: u32) -> &[u32] {
        let place = place as usize;
        &self.corners[self.start[place] as usize..self.start[place + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two squares that meet at `degrees`, with vertices of their own.
    fn roof(degrees: f64) -> MeshColumns {
        let (s, c) = (
            libm::sin(degrees.to_radians()) as f32,
            libm::cos(degrees.to_radians()) as f32,
        );
        MeshColumns {
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
        // The edge's two vertices are shared, and its normals stand between the faces'.
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
    fn normals_that_are_there_stay() {
        let mut mesh = roof(20.0);
        mesh.normals = vec![Vec3::X; 8];
        mesh.smooth_normals(30.0);
        assert_eq!(mesh.normals, [Vec3::X; 8]);
        MeshColumns::default().smooth_normals(30.0);
    }
}

//! Parametric surfaces: tessellates a function of (u, v) into a grid of triangles with smooth normals.

use crate::scene::TriangleMesh;
use glam::{DVec3, Vec3};

/// Collects surfaces into one mesh.
#[derive(Default)]
pub(super) struct MeshBuilder {
    mesh: TriangleMesh,
}

impl MeshBuilder {
    pub(super) fn triangle_count(&self) -> usize {
        self.mesh.triangles.len()
    }

    fn vertex(&mut self, p: DVec3) -> u32 {
        let index = self.mesh.x.len() as u32;
        let p = p.as_vec3();
        self.mesh.x.push(p.x);
        self.mesh.y.push(p.y);
        self.mesh.z.push(p.z);
        index
    }

    /// Adds a triangle that shares no vertices.
    pub(super) fn triangle(&mut self, corners: [DVec3; 3]) {
        let corners = corners.map(|p| self.vertex(p));
        self.mesh.triangles.push(corners);
    }

    /// Adds a flat quadrilateral that shares no vertices: 2 triangles.
    pub(super) fn quad(&mut self, corners: [DVec3; 4]) {
        let [a, b, c, d] = corners.map(|p| self.vertex(p));
        self.mesh.triangles.extend([[a, b, c], [a, c, d]]);
    }

    /// Adds a box with sharp edges: 12 triangles.
    pub(super) fn cuboid(&mut self, lower: DVec3, upper: DVec3) {
        let at = |x: usize, y: usize, z: usize| {
            let pick = |axis: usize, i: usize| if i == 0 { lower[axis] } else { upper[axis] };
            DVec3::new(pick(0, x), pick(1, y), pick(2, z))
        };
        self.quad([at(0, 0, 0), at(0, 1, 0), at(1, 1, 0), at(1, 0, 0)]);
        self.quad([at(0, 0, 1), at(1, 0, 1), at(1, 1, 1), at(0, 1, 1)]);
        self.quad([at(0, 0, 0), at(1, 0, 0), at(1, 0, 1), at(0, 0, 1)]);
        self.quad([at(0, 1, 0), at(0, 1, 1), at(1, 1, 1), at(1, 1, 0)]);
        self.quad([at(0, 0, 0), at(0, 0, 1), at(0, 1, 1), at(0, 1, 0)]);
        self.quad([at(1, 0, 0), at(1, 1, 0), at(1, 1, 1), at(1, 0, 1)]);
    }

    /// Adds an open sheet of `columns` x `rows` quads over u, v in [0, 1]: 2 `columns` `rows` triangles.
    pub(super) fn sheet(&mut self, columns: usize, rows: usize, surface: impl Fn(f64, f64) -> DVec3) {
        let base = self.ring_rows(columns + 1, columns, 0..=rows, rows, &surface);
        for row in 0..rows {
            for column in 0..columns {
                let a = base + (row * (columns + 1) + column) as u32;
                let b = a + (columns + 1) as u32;
                self.mesh.triangles.extend([[a, a + 1, b + 1], [a, b + 1, b]]);
            }
        }
    }

    /// Adds a tube, closed in u and open in v: 2 `around` `rows` triangles.
    pub(super) fn tube(&mut self, around: usize, rows: usize, surface: impl Fn(f64, f64) -> DVec3) {
        let base = self.ring_rows(around, around, 0..=rows, rows, &surface);
        self.bands(base, around, rows);
    }

    /// Adds a closed surface with poles at v = 0 and v = 1: 2 `around` (`rows` - 1) triangles, watertight because they
    /// share their vertices.
    pub(super) fn closed(&mut self, around: usize, rows: usize, surface: impl Fn(f64, f64) -> DVec3) {
        let first = self.vertex(surface(0.0, 0.0));
        let base = self.ring_rows(around, around, 1..=rows - 1, rows, &surface);
        let last = self.vertex(surface(0.0, 1.0));
        self.bands(base, around, rows - 2);
        let last_ring = last - around as u32;
        for i in 0..around as u32 {
            let next = (i + 1) % around as u32;
            self.mesh.triangles.push([first, base + next, base + i]);
            self.mesh.triangles.push([last, last_ring + i, last_ring + next]);
        }
    }

    /// Adds the vertices of the rows `which`, `points` per row, with u in steps of 1/`columns`, v of 1/`rows`.
    fn ring_rows(
        &mut self,
        points: usize,
        columns: usize,
        which: std::ops::RangeInclusive<usize>,
        rows: usize,
        surface: &impl Fn(f64, f64) -> DVec3,
    ) -> u32 {
        let base = self.mesh.x.len() as u32;
        for row in which {
            for column in 0..points {
                self.vertex(surface(column as f64 / columns as f64, row as f64 / rows as f64));
            }
        }
        base
    }

    fn bands(&mut self, base: u32, around: usize, rows: usize) {
        let around = around as u32;
        for row in 0..rows as u32 {
            for i in 0..around {
                let next = (i + 1) % around;
                let [a, b] = [row, row + 1].map(|r| base + r * around);
                self.mesh
                    .triangles
                    .extend([[a + i, a + next, b + next], [a + i, b + next, b + i]]);
            }
        }
    }

    /// Returns the mesh; vertex normals are the area-weighted means of the face normals.
    pub(super) fn finish(mut self) -> TriangleMesh {
        let mesh = &mut self.mesh;
        let position = |i: u32| {
            let i = i as usize;
            DVec3::new(mesh.x[i].into(), mesh.y[i].into(), mesh.z[i].into())
        };
        let mut normals = vec![Vec3::ZERO; mesh.x.len()];
        for corners in &mesh.triangles {
            let [a, b, c] = corners.map(position);
            // Scaled so that the areas of tiny triangles do not underflow in f32.
            let normal = ((b - a).cross(c - a) * 1e6).as_vec3();
            for &corner in corners {
                normals[corner as usize] += normal;
            }
        }
        for normal in &mut normals {
            *normal = normal.as_dvec3().normalize_or_zero().as_vec3();
        }
        mesh.normals = normals;
        self.mesh
    }
}

/// Returns the point of the unit sphere at longitude 2 pi u and polar angle pi v.
pub(super) fn on_sphere(u: f64, v: f64) -> DVec3 {
    let (sin_u, cos_u) = libm::sincos(std::f64::consts::TAU * u);
    let (sin_v, cos_v) = libm::sincos(std::f64::consts::PI * v);
    DVec3::new(sin_v * cos_u, sin_v * sin_u, cos_v)
}

/// Returns the largest integer whose square is at most `x`, but at least `least`.
pub(super) fn side(x: f64, least: usize) -> usize {
    (x.max(0.0).sqrt().floor() as usize).max(least)
}

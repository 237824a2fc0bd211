//! The objects of a scene: each sphere, each instance, and triangles that share corners.
//!
//! The window frames one of them, or all of them without the ground.

use crate::{
    format::mesh::UpAxis,
    math::Aabb,
    ray::{InstanceId, SceneHit},
    scene::{Primitive, Scene, weld},
};
use glam::DVec3;

/// An object is flat if its height is at most this share of its width.
const FLAT: f32 = 0.02;
/// The ground is at least this many times as wide as everything on it.
const WIDER: f32 = 1.5;
/// A sphere is the ground if its diameter is at least this many times the diagonal of everything else.
const GROUND_SPHERE: f32 = 10.0;
/// Maximum number of ground layers, such as water below a meadow.
const MOST_GROUNDS: usize = 4;

/// The objects of one scene and their boxes.
#[derive(Debug)]
pub struct Objects {
    /// The object of each triangle.
    of_triangle: Vec<u32>,
    /// The boxes of the objects, relative to [`Scene::origin`]: those of triangles, then spheres, then instances.
    boxes: Vec<Aabb>,
    /// How many of them are made of triangles.
    meshes: usize,
    /// Where those of instances begin.
    first_instance: usize,
}

impl Objects {
    /// Finds the objects. Takes about as long as building the BVH.
    #[must_use]
    pub fn new(scene: &Scene) -> Self {
        const NONE: u32 = u32::MAX;
        let (vertices, corners) = (scene.vertices(), &scene.triangles().corners);
        // A union-find over the vertices. Welding them is its first step.
        let mut parent = weld(&vertices.x, &vertices.y, &vertices.z);
        for &[a, b, c] in corners {
            let root = find(&mut parent, a);
            for other in [b, c] {
                let other = find(&mut parent, other);
                parent[other as usize] = root;
            }
        }
        let mut object_of = vec![NONE; parent.len()];
        let mut boxes = Vec::new();
        let mut of_triangle = Vec::with_capacity(corners.len());
        for &[a, b, c] in corners {
            let root = find(&mut parent, a) as usize;
            if object_of[root] == NONE {
                object_of[root] = boxes.len() as u32;
                boxes.push(Aabb::EMPTY);
            }
            let object = object_of[root];
            of_triangle.push(object);
            let triangle = Aabb::around([a, b, c].map(|vertex| vertices.position(vertex)));
            let bounds = &mut boxes[object as usize];
            *bounds = bounds.union(triangle);
        }
        let meshes = boxes.len();
        let spheres = 0..scene.spheres().radius.len();
        boxes.extend(spheres.map(|i| scene.sphere_bounds(i)));
        let first_instance = boxes.len();
        let mut objects = Self {
            of_triangle,
            boxes,
            meshes,
            first_instance,
        };
        objects.add_instances(scene);
        objects
    }

    /// Follows instances that moved.
    pub fn follow(&mut self, scene: &Scene) {
        self.boxes.truncate(self.first_instance);
        self.add_instances(scene);
    }

    /// Adds the boxes of instances. Prototypes are not objects themselves.
    fn add_instances(&mut self, scene: &Scene) {
        for prototype in scene.prototypes() {
            for i in prototype.triangles.clone() {
                self.boxes[self.of_triangle[i as usize] as usize] = Aabb::EMPTY;
            }
            for i in prototype.spheres.clone() {
                self.boxes[self.meshes + i as usize] = Aabb::EMPTY;
            }
        }
        let ids = (0..scene.instances().len() as u32).map(InstanceId);
        self.boxes.extend(ids.map(|id| scene.instance_bounds(id)));
    }

    /// The box around the object that is hit, relative to [`Scene::offset`]. Without a hit, or if it is of the ground, the
    /// box around all objects except the ground.
    #[must_use]
    pub fn bounds(&self, scene: &Scene, under: Option<SceneHit>, up: UpAxis) -> Aabb {
        let is_ground = self.ground(up);
        let object = under.and_then(|hit| match scene.primitive(hit.primitive) {
            _ if hit.instance != InstanceId::NONE => Some(self.first_instance + hit.instance.0 as usize),
            Primitive::Triangle(i) => Some(self.of_triangle[i] as usize),
            Primitive::Sphere(i) => Some(self.meshes + i),
            // Planes have no ends.
            Primitive::Plane(_) => None,
        });
        let bounds = match object.filter(|&object| !is_ground[object]) {
            Some(object) => self.boxes[object],
            None => self.union(|i| !is_ground[i]),
        };
        if bounds.is_empty() {
            return bounds;
        }
        Aabb {
            lower: bounds.lower + scene.origin(),
            upper: bounds.upper + scene.origin(),
        }
    }

    fn union(&self, counts: impl Fn(usize) -> bool) -> Aabb {
        let objects = self.boxes.iter().enumerate().filter(|&(i, _)| counts(i));
        objects.fold(Aabb::EMPTY, |all, (_, &bounds)| all.union(bounds))
    }

    /// Which objects are the ground: flat or a huge sphere, much wider than all the others and below them.
    fn ground(&self, up: UpAxis) -> Vec<bool> {
        let mut is_ground = vec![false; self.boxes.len()];
        for _ in 0..MOST_GROUNDS {
            let rest = (0..self.boxes.len()).filter(|&i| !is_ground[i]);
            let Some(widest) = rest.max_by(|&a, &b| self.width(a, up).total_cmp(&self.width(b, up))) else {
                break;
            };
            let others = self.union(|i| i != widest && !is_ground[i]);
            if others.is_empty() || !self.carries(widest, others, up) {
                break;
            }
            is_ground[widest] = true;
        }
        is_ground
    }

    /// The narrower horizontal side of an object.
    fn width(&self, object: usize, up: UpAxis) -> f32 {
        width(self.boxes[object], up)
    }

    /// Whether an object is the ground of others.
    fn carries(&self, object: usize, others: Aabb, up: UpAxis) -> bool {
        let bounds = self.boxes[object];
        let direction = up.vector();
        // The heights of the lower and the upper side.
        let heights = |bounds: Aabb| {
            let [a, b] = [bounds.lower, bounds.upper].map(|corner| corner.as_dvec3().dot(direction));
            [a.min(b), a.max(b)]
        };
        let ([bottom, top], [low, high]) = (heights(bounds), heights(others));
        let width = self.width(object, up);
        let is_flat = top - bottom <= f64::from(FLAT * width);
        let is_huge = object >= self.meshes && width >= GROUND_SPHERE * others.diagonal();
        let horizontal = DVec3::ONE - direction.abs();
        let reach =
            |bounds: Aabb| ((bounds.upper - bounds.lower).as_dvec3() * horizontal).max_element() as f32;
        (is_flat || is_huge) && width >= WIDER * reach(others) && top <= 0.5 * (low + high)
    }
}

fn width(bounds: Aabb, up: UpAxis) -> f32 {
    let extent = bounds.upper - bounds.lower;
    let sides = [extent.x, extent.y, extent.z];
    let vertical = up.vector().abs().max_position();
    let horizontal = (0..3).filter(|&axis| axis != vertical).map(|axis| sides[axis]);
    horizontal.fold(f32::INFINITY, f32::min)
}

/// The root of a vertex. Halves the path to it.
fn find(parent: &mut [u32], mut vertex: u32) -> u32 {
    while parent[vertex as usize] != vertex {
        let next = parent[parent[vertex as usize] as usize];
        parent[vertex as usize] = next;
        vertex = next;
    }
    vertex
}

#[cfg(test)]
mod tests;

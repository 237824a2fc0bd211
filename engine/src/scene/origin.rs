//! The scene's own origin: coordinates of a scene far from 0 are stored relative to its centre, so that rounding errors
//! fit its size.

use super::{Scene, builder::MIN_PIECE, instance::gaps};
use crate::math::Aabb;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::sync::Arc;

/// Returns the centre of `bounds` on each axis on which the box is further from 0 than it is long, else 0. Subtracting it
/// is exact: no coordinate is less than half or more than twice as large (Sterbenz's lemma).
#[doc(hidden)]
pub fn origin_of(bounds: Aabb) -> Vec3 {
    if bounds.is_empty() {
        return Vec3::ZERO;
    }
    let Aabb { lower, upper } = bounds;
    let is_far = (lower.cmpgt(Vec3::ZERO) & upper.cmple(lower * 2.0))
        | (upper.cmplt(Vec3::ZERO) & lower.cmpge(upper * 2.0));
    Vec3::select(is_far, (lower + upper) * 0.5, Vec3::ZERO)
}

impl Scene {
    /// Replaces the lights by those of another scene.
    pub fn take_lights(&mut self, other: Self) {
        self.lights = other.lights;
        let between = (other.offset - self.offset).as_vec3();
        self.translate_lights(between + (other.origin - self.origin));
    }

    /// Returns the world position that all positions of the scene are relative to but those of cameras: 0, unless
    /// [`SceneBuilder::set_offset`](super::SceneBuilder::set_offset) has set another.
    #[must_use]
    pub fn offset(&self) -> DVec3 {
        self.offset
    }

    /// Returns the world position of a point that is relative to [`Scene::origin`], such as a hit.
    #[must_use]
    pub fn world_point(&self, point: Vec3) -> DVec3 {
        (self.origin + point).as_dvec3() + self.offset
    }

    /// Returns the position, less [`Scene::offset`], that the scene's arrays, rays and hits are relative to.
    ///
    /// 0 on an axis unless the scene is further from 0 than it is long there; then the scene's centre, so that
    /// coordinates, above all the origins of rays, are not rounded in large steps.
    #[must_use]
    pub fn origin(&self) -> Vec3 {
        self.origin
    }

    /// Returns a point of world space relative to the [`origin`](Self::origin), as rays are traced.
    #[doc(hidden)]
    #[must_use]
    pub fn relative(&self, point: DVec3) -> Vec3 {
        (point - self.offset() - self.origin().as_dvec3()).as_vec3()
    }

    /// Chooses the origin and makes all positions relative to it.
    pub(super) fn move_to_origin(&mut self) {
        let origin = origin_of(self.bounds);
        self.origin = origin;
        let (Some(v), Some(s)) = (Arc::get_mut(&mut self.vertices), Arc::get_mut(&mut self.spheres)) else {
            unreachable!("a new scene shares nothing");
        };
        let (vertices, spheres) = (v.x.len() as u32, s.radius.len() as u32);
        for range in gaps(self.prototypes.iter().map(|p| p.vertices.clone()), vertices) {
            let range = range.start as usize..range.end as usize;
            let columns = [&mut v.x, &mut v.y, &mut v.z];
            translate(columns.map(|column| &mut column[range.clone()]), -origin);
        }
        for range in gaps(self.prototypes.iter().map(|p| p.spheres.clone()), spheres) {
            let range = range.start as usize..range.end as usize;
            let columns = [&mut s.center_x, &mut s.center_y, &mut s.center_z];
            translate(columns.map(|column| &mut column[range.clone()]), -origin);
        }
        self.translate_lights(-origin);
        self.move_planes();
    }

    pub(super) fn translate_lights(&mut self, by: Vec3) {
        for light in &mut self.lights {
            light.shape.translate(by);
        }
    }
}

fn translate(coordinates: [&mut [f32]; 3], by: Vec3) {
    for (axis, by) in coordinates.into_iter().zip(by.to_array()) {
        if by != 0.0 {
            axis.par_iter_mut().with_min_len(MIN_PIECE).for_each(|x| *x += by);
        }
    }
}

#[cfg(test)]
mod tests;

//! Instances: the scalar version of `trace::instances`.

use super::RaySlabs;
use crate::{
    math::{Aabb, max, min},
    ray::{Hit, InstanceId, Ray, SceneHit, T_MAX},
    scene::{ImageRay, Instance, PrototypeId},
};

/// An instance whose box a ray meets.
pub(super) struct Met {
    pub prototype: PrototypeId,
    id: InstanceId,
    image: ImageRay,
    near: f32,
    far: f32,
}

impl Met {
    /// Returns whether and how a ray meets an instance, `bounds` its box.
    #[inline(always)]
    pub fn new(
        instance: &Instance,
        id: InstanceId,
        bounds: Aabb,
        ray: &Ray,
        slabs: &RaySlabs,
    ) -> Option<Self> {
        let (near, far) = slabs.primitive_interval(bounds);
        if near > far {
            return None;
        }
        Some(Self {
            prototype: instance.prototype(),
            id,
            image: instance.image(ray)?,
            near,
            far,
        })
    }

    /// The ray in the prototype's space, up to about `t_max` in the scene.
    #[inline(always)]
    pub fn up_to(&self, t_max: f32) -> Ray {
        Ray {
            t_max: if self.far <= t_max {
                T_MAX
            } else {
                self.image.beyond(t_max)
            },
            ..self.image.ray
        }
    }

    /// Replaces `best` by the hit of [`up_to`](Self::up_to) in the prototype, if that is nearer.
    #[inline(always)]
    pub fn offer(&self, hit: &Hit, best: &mut SceneHit) {
        let t = min(max(self.image.in_scene(hit.t), self.near), self.far);
        let wins_tie = best.instance != InstanceId::NONE && self.id < best.instance;
        if hit.is_hit() && t > 0.0 && (t < best.t || t == best.t && wins_tie) {
            *best = SceneHit {
                hit: Hit { t, ..*hit },
                instance: self.id,
            };
        }
    }
}

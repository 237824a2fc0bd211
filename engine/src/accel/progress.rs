//! Progress of a build.

use super::tree::subtree_size;
use crate::scene::Scene;
use std::sync::atomic::{AtomicU64, Ordering};

/// The progress of a build.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuildProgress {
    /// Steps done, of about equal time.
    pub done: u64,
    /// Total number of steps, an estimate.
    pub total: u64,
}

/// Called by the threads that build, every few thousand primitives.
pub type OnBuild<'a> = &'a (dyn Fn(BuildProgress) + Sync);

/// Finding the boxes of primitives, building a subtree and writing it each take about as long as this many divisions.
const DIVISIONS: usize = 6;

/// Counts the steps of a build: a primitive in a division.
pub(super) struct Steps<'a> {
    on_build: OnBuild<'a>,
    done: AtomicU64,
    total: u64,
}

impl<'a> Steps<'a> {
    pub(super) fn of(scene: &Scene, on_build: OnBuild<'a>) -> Self {
        let (primitives, instances) = (scene.primitive_count(), scene.instances().len());
        let divisions = |count: usize| (count / subtree_size(count)).max(1).ilog2() as usize;
        let total = primitives * (divisions(primitives) + 3 * DIVISIONS)
            + instances * (divisions(instances) + DIVISIONS);
        Self {
            on_build,
            done: AtomicU64::new(0),
            total: total as u64,
        }
    }

    /// A set of `count` primitives is divided.
    pub(super) fn divided(&self, count: usize) {
        let count = count as u64;
        let done = self.done.fetch_add(count, Ordering::Relaxed) + count;
        let total = self.total;
        let done = done.min(total);
        (self.on_build)(BuildProgress { done, total });
    }

    /// Boxes of `count` primitives are found, or a subtree of them is built or written.
    pub(super) fn finished(&self, count: usize) {
        self.divided(DIVISIONS * count);
    }
}

#[cfg(test)]
mod tests {
    use crate::{
        accel::{BuildQuality, Bvh},
        scene::{SceneBuilder, Transform},
    };
    use glam::{DVec3, Vec3};
    use std::sync::Mutex;

    #[test]
    fn a_build_ends_when_about_all_steps_are_done() {
        let mut builder = SceneBuilder::new();
        let material = builder.classic_material(1).unwrap();
        let of_spheres = |builder: &mut SceneBuilder, count: u16| {
            (0..count).try_for_each(|i| builder.add_sphere(Vec3::splat(f32::from(i)), 0.5, material))
        };
        of_spheres(&mut builder, 5000).unwrap();
        let prototype = builder
            .add_prototype(|builder| of_spheres(builder, 3000))
            .unwrap();
        for i in 0..2000 {
            let transform = Transform::IDENTITY.then_translate(DVec3::X * f64::from(i));
            builder.add_instance(prototype, &transform).unwrap();
        }
        let steps = Mutex::new(Vec::new());
        let _ = Bvh::build_watched(&builder.finish(), BuildQuality::Fast, &|progress| {
            steps.lock().unwrap().push((progress.done, progress.total));
        });
        let steps = steps.into_inner().unwrap();
        assert!(steps.len() > 8, "{steps:?}");
        let last = steps.iter().max().unwrap();
        assert!(last.0 > last.1 / 10 * 9, "{steps:?}");
    }
}

//! How far a build is.

use crate::scene::Scene;
use std::sync::atomic::{AtomicU64, Ordering};

/// The progress of a build.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuildProgress {
    /// Steps done: each primitive and each instance is put into the tree, and each primitive is written.
    pub done: u64,
    /// Steps in all. Primitives without area, or that equal another one, are among them.
    pub total: u64,
}

/// Told from the threads that build, after every few thousand primitives.
pub type OnBuild<'a> = &'a (dyn Fn(BuildProgress) + Sync);

/// Counts the steps of a build.
pub(super) struct Steps<'a> {
    on_build: OnBuild<'a>,
    done: AtomicU64,
    total: u64,
}

impl<'a> Steps<'a> {
    pub(super) fn of(scene: &Scene, on_build: OnBuild<'a>) -> Self {
        Self {
            on_build,
            done: AtomicU64::new(0),
            total: 2 * scene.primitive_count() as u64 + scene.instances().len() as u64,
        }
    }

    pub(super) fn add(&self, count: usize) {
        let count = count as u64;
        let done = self.done.fetch_add(count, Ordering::Relaxed) + count;
        let total = self.total;
        (self.on_build)(BuildProgress { done, total });
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
    fn a_build_ends_when_all_steps_are_done() {
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
            assert_eq!(progress.total, 2 * 8000 + 2000);
            steps.lock().unwrap().push(progress.done);
        });
        let mut steps = steps.into_inner().unwrap();
        steps.sort_unstable();
        assert!(steps.len() > 8, "{steps:?}");
        assert_eq!(steps.last(), Some(&18_000));
    }
}

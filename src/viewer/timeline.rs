//! The scene of the window, and its frames.

use super::objects::Objects;
use crate::{accel::Bvh, error::SceneError, scene::Scene};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// A scene ready for tracing.
#[derive(Debug)]
pub struct Model {
    /// The scene.
    pub scene: Scene,
    /// Its BVH.
    pub bvh: Bvh,
    objects: OnceLock<Objects>,
}

impl Model {
    /// Puts a scene and its BVH together.
    #[must_use]
    pub fn new(scene: Scene, bvh: Bvh) -> Self {
        Self {
            scene,
            bvh,
            objects: OnceLock::new(),
        }
    }

    /// Returns the objects of the scene; finds them on the first call.
    pub fn objects(&self) -> &Objects {
        self.objects.get_or_init(|| Objects::new(&self.scene))
    }

    /// Whether [`Self::objects`] returns at once: they are known, or the scene is small.
    #[must_use]
    pub fn has_objects(&self) -> bool {
        const SMALL: usize = 200_000;
        self.objects.get().is_some() || self.scene.primitive_count() <= SMALL
    }

    /// Returns the scene's current frame.
    #[must_use]
    pub fn frame(&self) -> u32 {
        // The cast saturates.
        self.scene.time() as u32
    }

    /// Moves instances and cameras, and keeps the rest.
    fn move_to(&mut self, frame: u32) -> Result<(), SceneError> {
        self.scene.set_time(frame.into())?;
        self.bvh.follow(&self.scene);
        if let Some(objects) = self.objects.get_mut() {
            objects.follow(&self.scene);
        }
        Ok(())
    }
}

/// A scene that may move. It is in memory once, so it has one current frame, which does not change while the scene is in use.
#[derive(Debug)]
pub struct Timeline {
    count: u32,
    now: Mutex<Arc<Model>>,
}

impl Timeline {
    /// Begins with the scene at its current frame.
    #[must_use]
    pub fn new(model: Model) -> Self {
        Self {
            count: model.scene.frame_count(),
            now: Mutex::new(Arc::new(model)),
        }
    }

    /// Returns the number of frames; 1 if nothing moves.
    #[must_use]
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Returns the scene at its current frame.
    #[must_use]
    pub fn now(&self) -> Arc<Model> {
        Arc::clone(&self.now.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Moves the scene to a frame. `None` if it is in use at another one.
    ///
    /// # Errors
    /// [`SceneError::AtTime`] if something cannot be placed there: the scene stays as it was.
    pub fn at(&self, frame: u32) -> Result<Option<Arc<Model>>, SceneError> {
        let mut now = self.now.lock().unwrap_or_else(PoisonError::into_inner);
        if now.frame() != frame {
            let Some(model) = Arc::get_mut(&mut now) else {
                return Ok(None);
            };
            model.move_to(frame)?;
        }
        Ok(Some(Arc::clone(&now)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        math::Aabb,
        scene::{Motion, SceneBuilder, Step, Transform},
        viewer::axis::Axis,
    };
    use glam::{DVec3, Vec3};

    /// A ball that moves 8 units along x in 8 frames, beside one that stays.
    fn rolling() -> Timeline {
        let mut builder = SceneBuilder::new();
        let matte = builder.classic_material(1).unwrap();
        builder.add_sphere(Vec3::ZERO, 1.0, matte).unwrap();
        let ball = builder
            .add_prototype(|builder| builder.add_sphere(Vec3::ZERO, 1.0, matte))
            .unwrap();
        let mut motion = Motion::default();
        for time in [1.0, 9.0] {
            let step = Step::Translate(DVec3::X * (time + 9.0));
            motion.add(time, vec![step]).unwrap();
        }
        builder
            .add_moving_instance(ball, &Transform::IDENTITY, motion)
            .unwrap();
        let scene = builder.finish();
        let bvh = Bvh::build(&scene);
        Timeline::new(Model::new(scene, bvh))
    }

    #[test]
    fn a_scene_moves_when_nobody_uses_it() {
        let timeline = rolling();
        assert_eq!((timeline.count(), timeline.now().frame()), (9, 1));
        let all = |model: &Model| {
            let up = Axis::nearest(DVec3::Z);
            model.objects().bounds(&model.scene, None, up)
        };
        let reach = |bounds: Aabb| bounds.upper.x;
        let first = timeline.now();
        assert_eq!(reach(all(&first)), 11.0);
        assert!(timeline.at(5).unwrap().is_none());
        assert!(timeline.at(1).unwrap().is_some());
        drop(first);
        let fifth = timeline.at(5).unwrap().unwrap();
        assert_eq!((fifth.frame(), reach(all(&fifth))), (5, 15.0));
        assert!(fifth.bvh.is_of(&fifth.scene));
    }
}

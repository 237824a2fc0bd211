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
mod tests;

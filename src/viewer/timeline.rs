//! The scene of the window, and its frames.

use super::objects::Objects;
use crate::{
    accel::{BuildQuality, Bvh},
    error::SceneError,
    scene::Scene,
};
use std::{
    fmt,
    sync::{Arc, Mutex, OnceLock, PoisonError},
};

/// A scene ready for tracing.
#[derive(Debug)]
pub struct Model {
    /// The scene.
    pub scene: Scene,
    /// Its BVH.
    pub bvh: Bvh,
    /// Its frame, from 1 on.
    frame: u32,
    objects: OnceLock<Objects>,
}

impl Model {
    /// Puts a scene and its BVH together.
    #[must_use]
    pub fn new(scene: Scene, bvh: Bvh) -> Self {
        Self {
            // The cast saturates.
            frame: scene.time() as u32,
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

    /// Returns the current frame.
    #[must_use]
    pub fn frame(&self) -> u32 {
        self.frame
    }

    /// Moves instances and cameras, and keeps the rest.
    fn move_to(&mut self, frame: u32) -> Result<(), SceneError> {
        self.scene.set_time(frame.into())?;
        self.bvh.follow(&self.scene);
        self.frame = frame;
        if let Some(objects) = self.objects.get_mut() {
            objects.follow(&self.scene);
        }
        Ok(())
    }
}

/// The frames of a mesh that is played. Each is a scene of its own.
pub struct Frames {
    /// How many there are.
    pub count: u32,
    /// Loads one, from 1 on.
    pub load: Box<dyn Fn(u32) -> Result<Scene, String> + Send + Sync>,
}

impl fmt::Debug for Frames {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Frames")
            .field("count", &self.count)
            .finish_non_exhaustive()
    }
}

/// A scene that may move. It is in memory once, so it has one current frame, which does not change while the scene is in use.
/// A mesh that is played is loaded for each frame.
#[derive(Debug)]
pub struct Timeline {
    count: u32,
    frames: Option<Frames>,
    now: Mutex<Arc<Model>>,
}

impl Timeline {
    /// Begins with the scene at its current frame.
    #[must_use]
    pub fn new(model: Model) -> Self {
        Self {
            count: model.scene.frame_count(),
            frames: None,
            now: Mutex::new(Arc::new(model)),
        }
    }

    /// Begins with a mesh at its first frame; with `None` as [`Self::new`].
    #[must_use]
    pub fn with_frames(model: Model, frames: Option<Frames>) -> Self {
        let still = Self::new(model);
        Self {
            count: frames.as_ref().map_or(still.count, |frames| frames.count),
            frames,
            ..still
        }
    }

    /// Returns the number of frames; 1 if nothing moves.
    #[must_use]
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Whether it is a mesh that is played.
    #[must_use]
    pub fn is_played(&self) -> bool {
        self.frames.is_some()
    }

    /// Returns the scene at its current frame.
    #[must_use]
    pub fn now(&self) -> Arc<Model> {
        Arc::clone(&self.now.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Moves the scene to a frame. `None` if it is in use at another one.
    ///
    /// # Errors
    /// Why something cannot be placed there, or the frame cannot be loaded: the scene stays as it was.
    pub fn at(&self, frame: u32) -> Result<Option<Arc<Model>>, String> {
        if let Some(frames) = &self.frames {
            return self.load(frames, frame).map(Some);
        }
        let mut now = self.now.lock().unwrap_or_else(PoisonError::into_inner);
        if now.frame() != frame {
            let Some(model) = Arc::get_mut(&mut now) else {
                return Ok(None);
            };
            model.move_to(frame).map_err(|error| error.to_string())?;
        }
        Ok(Some(Arc::clone(&now)))
    }

    /// Loads a frame, unless it is the current one. [`Self::now`] does not wait for it.
    fn load(&self, frames: &Frames, frame: u32) -> Result<Arc<Model>, String> {
        let now = self.now();
        if now.frame == frame {
            return Ok(now);
        }
        let scene = (frames.load)(frame)?;
        let bvh = Bvh::build_with(&scene, BuildQuality::Fast);
        let model = Arc::new(Model {
            frame,
            ..Model::new(scene, bvh)
        });
        *self.now.lock().unwrap_or_else(PoisonError::into_inner) = Arc::clone(&model);
        Ok(model)
    }
}

#[cfg(test)]
mod tests;

//! Moving instances and cameras, and the scene at a time. Meshes never change; only instances are placed again.

use super::{
    CameraMotion, Instance, Motion, NamedCamera, Prototype, PrototypeId, Scene, SceneBuilder, SceneId,
    Transform, builder::placed_bounds, instance::Unplaced,
};
use crate::{
    error::{SceneError, SourcePos},
    math::Aabb,
};
use rayon::prelude::*;
use std::ops::Range;

/// The time of a new scene: its first frame.
const START: f64 = 1.0;

/// Instances of a prototype that move together, by one statement of a scene.
#[derive(Debug)]
struct MovingInstances {
    /// Their indices, which follow each other.
    ids: Range<usize>,
    prototype: PrototypeId,
    /// Their placements, before the motion.
    transforms: Vec<Transform>,
    motion: Motion,
    /// The place of their statement in a file.
    place: Option<SourcePos>,
}

#[derive(Debug)]
struct MovingCamera {
    /// Its index among the scene's own cameras.
    id: usize,
    motion: CameraMotion,
    place: Option<SourcePos>,
}

/// All that moves.
#[derive(Debug)]
pub(super) struct Moving {
    instances: Vec<MovingInstances>,
    cameras: Vec<MovingCamera>,
    keyframes: usize,
    /// The time of the last keyframe, though nothing may be there to move.
    end: f64,
    time: f64,
    /// The box around what never moves, in world space.
    pub(super) still_bounds: Aabb,
    /// Unlike the scene's id, it stays the same when time changes.
    pub(super) meshes: SceneId,
}

impl Default for Moving {
    fn default() -> Self {
        Self {
            instances: Vec::new(),
            cameras: Vec::new(),
            keyframes: 0,
            end: START,
            time: START,
            still_bounds: Aabb::EMPTY,
            meshes: SceneId::next(),
        }
    }
}

impl Moving {
    pub(super) fn is_empty(&self) -> bool {
        self.instances.is_empty() && self.cameras.is_empty()
    }

    /// Finds the box around everything that never moves: `others` outside of instances, and static instances.
    pub(super) fn find_still(&mut self, others: Aabb, prototypes: &[Prototype], instances: &[Unplaced]) {
        if self.instances.is_empty() {
            return;
        }
        let mut start = 0;
        self.still_bounds = others;
        for end in (self.instances.iter().map(|moving| &moving.ids)).chain([&(instances.len()..0)]) {
            let still = placed_bounds(prototypes, &instances[start..end.start]);
            self.still_bounds = self.still_bounds.union(still);
            start = end.end;
        }
    }

    /// Memory of the placements, bytes.
    pub(super) fn bytes(&self) -> usize {
        let of_one = |moving: &MovingInstances| size_of_val(&moving.transforms[..]);
        self.instances.iter().map(of_one).sum()
    }

    /// Checks that there is room for as many more keyframes.
    fn check_room(&self, more: usize) -> Result<(), SceneError> {
        if self.keyframes + more > super::MAX_KEYFRAMES {
            return Err(SceneError::TooMany {
                what: "keyframes",
                limit: super::MAX_KEYFRAMES,
            });
        }
        Ok(())
    }

    /// Counts the keyframes at these times.
    fn count(&mut self, times: impl ExactSizeIterator<Item = f64>) {
        self.keyframes += times.len();
        self.end = times.fold(self.end, f64::max);
    }
}

impl MovingInstances {
    /// The first `most` of them at a time.
    fn at(&self, time: f64, prototypes: &[Prototype], most: usize) -> Result<Vec<Unplaced>, SceneError> {
        let (of, pose) = (&prototypes[self.prototype.0 as usize], self.motion.at(time));
        let place = |transform: &Transform| {
            let unplaced = Unplaced::new(of, self.prototype, &transform.then_transform(&pose));
            unplaced.map_err(|error| at_time(time, self.place.as_ref(), &error.to_string()))
        };
        let transforms = self.transforms.par_iter().with_min_len(1 << 10);
        transforms.take(most).map(place).collect()
    }
}

fn at_time(time: f64, place: Option<&SourcePos>, why: &str) -> SceneError {
    SceneError::AtTime {
        time,
        place: place.cloned(),
        why: why.to_owned(),
    }
}

impl SceneBuilder {
    /// Adds an instance of a prototype that moves: `transform` places it, and then the motion.
    ///
    /// # Errors
    /// Those of [`SceneBuilder::add_instance`], if it cannot be placed in the first frame; [`SceneError::AtTime`], if not at a
    /// keyframe; [`SceneError::TooMany`] keyframes. Then the builder stays as it was.
    ///
    /// # Panics
    /// If the scene has no such prototype.
    pub fn add_moving_instance(
        &mut self,
        prototype: PrototypeId,
        transform: &Transform,
        motion: Motion,
    ) -> Result<(), SceneError> {
        self.add_moving_instances(prototype, vec![*transform], motion, None)
    }

    /// Adds instances that move together; `place` is for errors.
    #[doc(hidden)]
    pub fn add_moving_instances(
        &mut self,
        prototype: PrototypeId,
        transforms: Vec<Transform>,
        motion: Motion,
        place: Option<SourcePos>,
    ) -> Result<(), SceneError> {
        let first = self.instances.len();
        let added = self.try_moving_instances(prototype, transforms, motion, place);
        if added.is_err() {
            self.instances.truncate(first);
        }
        added
    }

    fn try_moving_instances(
        &mut self,
        prototype: PrototypeId,
        transforms: Vec<Transform>,
        motion: Motion,
        place: Option<SourcePos>,
    ) -> Result<(), SceneError> {
        let pose = motion.at(START);
        let first = self.instances.len();
        for transform in &transforms {
            self.add_instance(prototype, &transform.then_transform(&pose))?;
        }
        let moving = MovingInstances {
            ids: first..self.instances.len(),
            prototype,
            transforms,
            motion,
            place,
        };
        self.moving.check_room(moving.motion.times().len())?;
        let is_empty = moving.ids.is_empty();
        // Of many placements the first: each frame checks all of them.
        let most = usize::from(!is_empty);
        for time in moving.motion.times() {
            moving.at(time, &self.prototypes, most)?;
        }
        self.moving.count(moving.motion.times());
        if !is_empty {
            self.moving.instances.push(moving);
        }
        Ok(())
    }

    /// Adds a camera; the first one is the default view.
    pub fn add_camera(&mut self, camera: NamedCamera) {
        self.cameras.push(camera);
    }

    /// Adds a camera that moves.
    ///
    /// # Errors
    /// [`SceneError::AtTime`] if it makes no picture in the first frame, [`SceneError::TooMany`].
    pub fn add_moving_camera(
        &mut self,
        name: Option<String>,
        motion: CameraMotion,
    ) -> Result<(), SceneError> {
        self.add_moving_camera_of(name, motion, None)
    }

    /// Adds a moving camera; `place` is for errors.
    #[doc(hidden)]
    pub fn add_moving_camera_of(
        &mut self,
        name: Option<String>,
        motion: CameraMotion,
        place: Option<SourcePos>,
    ) -> Result<(), SceneError> {
        let camera = motion.at(START);
        let camera = camera.map_err(|error| at_time(START, place.as_ref(), &error.to_string()))?;
        self.moving.check_room(motion.times().len())?;
        self.moving.count(motion.times());
        self.moving.cameras.push(MovingCamera {
            id: self.cameras.len(),
            motion,
            place,
        });
        self.add_camera(NamedCamera { name, camera });
        Ok(())
    }
}

impl Scene {
    /// Moves instances and cameras to a time, in frames. A new scene is at 1, its first frame.
    ///
    /// Meshes do not change, and a BVH can be kept: [`Bvh::follow`](crate::accel::Bvh::follow) rebuilds only the level over the
    /// instances.
    ///
    /// # Errors
    /// [`SceneError::AtTime`] if something cannot be placed at that time; then the scene stays as it was.
    ///
    /// ```
    /// # use octray_engine as octray;
    /// use octray::{
    ///     accel::Bvh, glam::DVec3, render::{Settings, render}, scene::{Camera, CameraMotion, SceneBuilder},
    /// };
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let mut motion = CameraMotion::default();
    /// for (time, eye) in [(1.0, DVec3::new(6.0, 0.0, 2.0)), (25.0, DVec3::new(0.0, 6.0, 2.0))] {
    ///     motion.add(time, Camera::look_at(eye, DVec3::ZERO, DVec3::Z, 40.0)?.view())?;
    /// }
    /// let mut builder = SceneBuilder::new();
    /// builder.add_light(DVec3::new(9.0, -4.0, 10.0).as_vec3(), 0.7)?;
    /// builder.add_moving_camera(None, motion)?;
    /// let mut scene = builder.finish();
    /// let mut bvh = Bvh::build(&scene);
    /// let settings = Settings { width: 16, height: 16, ..Settings::default() };
    /// for frame in 1..=scene.frame_count() {
    ///     scene.set_time(frame.into())?;
    ///     bvh.follow(&scene);
    ///     let camera = scene.cameras()[0].camera;
    ///     render(&scene, &bvh, &camera, &settings, &|_| std::ops::ControlFlow::Continue(()))?;
    /// }
    /// assert_eq!(scene.cameras()[0].camera.view().eye.to_array(), [0.0, 6.0, 2.0]);
    /// # Ok(())
    /// # }
    /// ```
    pub fn set_time(&mut self, time: f64) -> Result<(), SceneError> {
        if time.is_nan() {
            return Err(at_time(time, None, "expected a number"));
        }
        let moving = &self.moving;
        let instances: Vec<Vec<Unplaced>> = (moving.instances.iter())
            .map(|moving| moving.at(time, &self.prototypes, usize::MAX))
            .collect::<Result<_, _>>()?;
        self.cameras = self.cameras_at(time)?;
        self.moving.time = time;
        if instances.is_empty() {
            return Ok(());
        }
        self.bounds = self.moving.still_bounds;
        for (moving, unplaced) in self.moving.instances.iter().zip(&instances) {
            self.bounds = self.bounds.union(placed_bounds(&self.prototypes, unplaced));
            let placed: Vec<Instance> = unplaced.iter().map(|one| one.at(self.origin)).collect();
            self.instances[moving.ids.clone()].copy_from_slice(&placed);
        }
        self.id = SceneId::next();
        Ok(())
    }

    /// Returns the scene's own cameras at a time, whatever the scene's current time.
    ///
    /// # Errors
    /// [`SceneError::AtTime`] if one makes no picture then.
    pub fn cameras_at(&self, time: f64) -> Result<Vec<NamedCamera>, SceneError> {
        let mut cameras = self.cameras.clone();
        for moving in &self.moving.cameras {
            let camera = moving.motion.at(time);
            let camera = camera.map_err(|error| at_time(time, moving.place.as_ref(), &error.to_string()));
            cameras[moving.id].camera = camera?;
        }
        Ok(cameras)
    }

    /// Returns whether one of the scene's own cameras has a lens; a moving one, at any keyframe.
    #[doc(hidden)]
    #[must_use]
    pub fn has_lens(&self, camera: usize) -> bool {
        match self.moving.cameras.iter().find(|moving| moving.id == camera) {
            Some(moving) => moving.motion.has_lens(),
            None => self.cameras.get(camera).is_some_and(|own| own.camera.has_lens()),
        }
    }

    /// Returns whether an instance or a camera has a motion, even one without keyframes.
    #[must_use]
    pub fn moves(&self) -> bool {
        !self.moving.is_empty()
    }

    /// Returns the scene's current time, in frames.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.moving.time
    }

    /// Returns the number of frames, 1, 2, 3 ...: up to the last keyframe, rounded up; 1 without keyframes.
    ///
    /// Keyframes count even if [nothing moves](Self::moves), because their instances have no placements or an empty mesh.
    #[must_use]
    pub fn frame_count(&self) -> u32 {
        self.moving.end.ceil() as u32
    }

    /// Returns the number of keyframes.
    #[must_use]
    pub fn keyframe_count(&self) -> usize {
        self.moving.keyframes
    }

    /// Returns how many instances and how many cameras move.
    #[must_use]
    pub fn moving_counts(&self) -> [usize; 2] {
        let of_one = |moving: &MovingInstances| moving.ids.len();
        [
            self.moving.instances.iter().map(of_one).sum(),
            self.moving.cameras.len(),
        ]
    }
}

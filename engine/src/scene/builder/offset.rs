//! The offset of a scene far from 0.

use super::{SceneBuilder, usable_point};
use crate::error::SceneError;
use glam::DVec3;

impl SceneBuilder {
    /// Sets the world position to which all positions added from now on are relative, except those of cameras. It keeps a scene
    /// far from 0 from being rounded to coarse steps of `f32`.
    ///
    /// # Errors
    /// [`SceneError::NotUsable`] if a coordinate is NaN or too large.
    pub fn set_offset(&mut self, offset: DVec3) -> Result<(), SceneError> {
        usable_point(offset.as_vec3())?;
        self.offset = offset;
        Ok(())
    }

    /// Returns what [`SceneBuilder::set_offset`] has set, or 0.
    #[must_use]
    pub fn offset(&self) -> DVec3 {
        self.offset
    }
}

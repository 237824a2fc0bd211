//! What positions are relative to.

use super::{SceneBuilder, usable_point};
use crate::error::SceneError;
use glam::DVec3;

impl SceneBuilder {
    /// Sets the world position that all positions are relative to but those of cameras, so that a scene far from 0 is not
    /// rounded to coarse steps of `f32`. What was added before is not moved.
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

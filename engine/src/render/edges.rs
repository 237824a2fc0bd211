//! The edges of triangles in pictures.

use super::RenderError;

/// The widest edges, pixels.
pub const MAX_EDGE_WIDTH: f32 = 100.0;

/// How the edges of triangles are drawn: over the surfaces that are seen directly, glass and mirrors included, but not over what
/// those show. Each triangle has half of a line along each of its edges; spheres and planes have none. Triangles that are less
/// than six times as high in the picture as a line is wide have fainter edges, else dense meshes would turn black.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edges {
    /// Width of the lines in pixels, above 0 and at most [`MAX_EDGE_WIDTH`].
    pub width: f32,
    /// Linear RGB, 0 to 1.
    pub color: [f32; 3],
}

impl Default for Edges {
    /// Returns nearly black edges, one pixel wide.
    fn default() -> Self {
        Self {
            width: 1.0,
            color: [0.005; 3],
        }
    }
}

impl Edges {
    /// # Errors
    /// [`RenderError::Limit`]
    pub(super) fn check(self) -> Result<(), RenderError> {
        let Self { width, color } = self;
        // The comparisons are false for NaN.
        if !(width > 0.0 && width <= MAX_EDGE_WIDTH) {
            return Err(RenderError::Limit(format!(
                "edges {width} pixels wide: expected above 0, and at most {MAX_EDGE_WIDTH}"
            )));
        }
        if !color.iter().all(|channel| (0.0..=1.0).contains(channel)) {
            return Err(RenderError::Limit(format!(
                "edges of the colour {color:?}: expected channels from 0 to 1"
            )));
        }
        Ok(())
    }
}

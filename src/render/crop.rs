//! A part of a picture.

use std::fmt;

/// A rectangle of a picture's pixels, row 0 on top.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crop {
    /// The leftmost column.
    pub x0: u32,
    /// The topmost row.
    pub y0: u32,
    /// The column after the rightmost one.
    pub x1: u32,
    /// The row after the lowest one.
    pub y1: u32,
}

impl Crop {
    /// Pixels across.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.x1.saturating_sub(self.x0)
    }

    /// Pixels down.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.y1.saturating_sub(self.y0)
    }
}

/// As the command line takes it: `x0,y0,x1,y1`.
impl fmt::Display for Crop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { x0, y0, x1, y1 } = self;
        write!(f, "{x0},{y0},{x1},{y1}")
    }
}

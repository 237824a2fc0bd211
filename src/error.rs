//! Errors: what was found, what was expected, and where.

use std::{fmt, path::PathBuf, sync::Arc};

/// A place in a text or mesh file: 1-based line and column (in bytes). For binary data the line is the
/// record's number and the column is 1.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourcePos {
    /// The file as it was named, relative to where the program runs.
    pub file: Arc<PathBuf>,
    /// 1-based line; 0 when the error concerns the file as a whole.
    pub line: u32,
    /// 1-based column in bytes; 0 when the error concerns the line as a whole.
    pub column: u32,
}

impl fmt::Display for SourcePos {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if self.line > 0 {
            write!(f, ":{}", self.line)?;
            if self.column > 0 {
                write!(f, ":{}", self.column)?;
            }
        }
        Ok(())
    }
}

/// Why [`SceneBuilder`](crate::scene::SceneBuilder) refused a piece of a scene.
#[derive(Clone, Debug, PartialEq)]
pub enum SceneError {
    /// A number is NaN or infinite, or so large (above [`MAX_COORDINATE`](crate::scene::MAX_COORDINATE))
    /// that squares of it overflow.
    NotUsable {
        /// Which number: "x", "radius", ...
        what: &'static str,
        /// Its value.
        value: f32,
    },
    /// A radius is zero or negative.
    RadiusNotPositive {
        /// The radius found.
        radius: f32,
    },
    /// A light's intensity is negative.
    IntensityNegative {
        /// The intensity found.
        intensity: f32,
    },
    /// A triangle names a vertex that its mesh does not have.
    VertexIndex {
        /// Which triangle of the mesh, 0-based.
        triangle: usize,
        /// The index found.
        index: u32,
        /// How many vertices the mesh has.
        vertices: usize,
    },
    /// A mesh's columns disagree in length.
    ColumnLength {
        /// Which column.
        what: &'static str,
        /// Its length.
        found: usize,
        /// The length expected.
        expected: usize,
    },
    /// A material that the scene does not have.
    UnknownMaterial {
        /// The index found.
        index: u32,
        /// How many materials the scene has.
        materials: usize,
    },
    /// More primitives, vertices or lights than 32-bit ids can count.
    TooMany {
        /// "primitives", "vertices", "lights" or "materials".
        what: &'static str,
        /// The largest number allowed.
        limit: usize,
    },
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotUsable { what, value } if value.is_finite() => {
                write!(f, "{what} is {value:e}, but numbers above 1e9 are not supported")
            }
            Self::NotUsable { what, value } => write!(f, "{what} is {value}, expected a finite number"),
            Self::RadiusNotPositive { radius } => {
                write!(f, "radius is {radius}, expected a number above 0")
            }
            Self::IntensityNegative { intensity } => {
                write!(f, "intensity is {intensity}, expected 0 or more")
            }
            Self::VertexIndex { index, vertices, .. } => {
                write!(
                    f,
                    "vertex index {index}, but the mesh has only {vertices} vertices"
                )
            }
            Self::ColumnLength {
                what,
                found,
                expected,
            } => {
                write!(f, "{found} {what}, expected {expected}")
            }
            Self::UnknownMaterial { index, materials } => {
                write!(
                    f,
                    "material {index}, expected 0 to {}",
                    materials.saturating_sub(1)
                )
            }
            Self::TooMany { what, limit } => write!(f, "more than {limit} {what}"),
        }
    }
}

impl std::error::Error for SceneError {}

/// Why a file could not be loaded, and where.
#[derive(Debug)]
pub struct LoadError {
    /// Where the fault is.
    pub at: SourcePos,
    /// What is wrong.
    pub message: String,
    /// The line of the fault, where there is one to show.
    pub line_text: Option<String>,
    /// What led to it, in another file perhaps.
    pub cause: Option<Box<LoadError>>,
}

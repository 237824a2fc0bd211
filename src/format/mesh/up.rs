//! The up axis of a mesh, its source, and a check for meshes that lie on their side.

use super::MeshFormat;
use crate::scene::TriangleMesh;
use glam::DVec3;
use std::{fmt, str::FromStr};

/// The axis that points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UpAxis {
    /// x points up.
    X,
    /// y points up: glTF by its specification; OBJ and PLY by convention.
    Y,
    /// z points up: `.scn` scenes, and STL by convention.
    #[default]
    Z,
    /// x points down.
    MinusX,
    /// y points down.
    MinusY,
    /// z points down.
    MinusZ,
}

impl UpAxis {
    /// All axes.
    pub const ALL: [Self; 6] = [
        Self::X,
        Self::Y,
        Self::Z,
        Self::MinusX,
        Self::MinusY,
        Self::MinusZ,
    ];

    /// The axis as it is written: `x`, `-x`, ...
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
            Self::MinusX => "-x",
            Self::MinusY => "-y",
            Self::MinusZ => "-z",
        }
    }

    /// The axis as a unit vector.
    #[must_use]
    pub fn vector(self) -> DVec3 {
        match self {
            Self::X => DVec3::X,
            Self::Y => DVec3::Y,
            Self::Z => DVec3::Z,
            Self::MinusX => DVec3::NEG_X,
            Self::MinusY => DVec3::NEG_Y,
            Self::MinusZ => DVec3::NEG_Z,
        }
    }

    /// The direction that the mesh's front faces, a unit vector: +z if y is up, as in glTF; -y if z is up, as in Blender.
    #[must_use]
    pub fn front(self) -> DVec3 {
        match self {
            Self::X | Self::MinusX | Self::MinusY => DVec3::NEG_Z,
            Self::Y => DVec3::Z,
            Self::Z => DVec3::NEG_Y,
            Self::MinusZ => DVec3::Y,
        }
    }

    /// The direction to the right for a viewer who faces the front.
    #[must_use]
    pub fn right(self) -> DVec3 {
        self.vector().cross(self.front())
    }

    pub(crate) fn opposite(self) -> Self {
        match self {
            Self::X => Self::MinusX,
            Self::Y => Self::MinusY,
            Self::Z => Self::MinusZ,
            Self::MinusX => Self::X,
            Self::MinusY => Self::Y,
            Self::MinusZ => Self::Z,
        }
    }

    /// 0 for x, 1 for y, 2 for z, whatever the sign.
    fn index(self) -> usize {
        self as usize % 3
    }
}

impl fmt::Display for UpAxis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for UpAxis {
    type Err = String;

    /// Parses `x`, `y`, `z`, `-x`, `-y` or `-z`, in either case and with an optional `+`.
    fn from_str(text: &str) -> Result<Self, String> {
        let name = text.strip_prefix('+').unwrap_or(text);
        let found = Self::ALL
            .into_iter()
            .find(|axis| axis.name().eq_ignore_ascii_case(name));
        found.ok_or_else(|| "expected x, y, z, -x, -y or -z".to_owned())
    }
}

/// The source of a mesh's up axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UpSource {
    /// The file or the specification of its format says so.
    #[default]
    Stated,
    /// A convention of most programs that write this format, which has no field for it.
    Assumed(MeshFormat),
}

/// At most this many triangles are sampled.
const MOST_SAMPLES: usize = 1 << 14;
/// The share of the mesh's height that counts as its base.
const BASE_SLAB: f64 = 0.01;
/// A base covers at least this share of the box's side ...
const BASE: f64 = 0.25;
/// ... and less than this is no base at all: not even four feet.
const NO_BASE: f64 = 0.005;
/// A long mesh is this many times longer than it is wide and deep.
const LONG: f64 = 4.0;
/// A flat mesh, such as a terrain, is this many times wider and deeper than it is high.
const FLAT: f64 = 8.0;

/// Another axis that is more likely up than `assumed`, and why.
///
/// A mesh is doubted if it has no base where it should stand, but has one elsewhere, or is much thinner along another axis; or
/// if it is much longer along another axis. A sample of the triangles decides.
pub(super) fn doubt(mesh: &TriangleMesh, assumed: UpAxis) -> Option<(UpAxis, String)> {
    let sample = Sample::of(mesh)?;
    let size = sample.size;
    if size.min_element() <= 0.0 {
        // A wall is as likely as a ground.
        return None;
    }
    let up = assumed.index();
    let axis = if up == UpAxis::Y.index() {
        UpAxis::Z
    } else {
        UpAxis::Y
    };
    let i = axis.index();
    let longest = || {
        let is_long = |i: usize| size[i] > LONG * size[(i + 1) % 3].max(size[(i + 2) % 3]);
        let mut others = UpAxis::ALL.into_iter().filter(|axis| axis.index() != up);
        let axis = others.find(|axis| is_long(axis.index()))?;
        Some((axis, format!("it is longest along {axis}")))
    };
    if sample.base(assumed) >= NO_BASE {
        return longest();
    }
    let others = UpAxis::ALL.into_iter().filter(|axis| axis.index() != up);
    let with_base: Vec<UpAxis> = others.filter(|&axis| sample.base(axis) >= BASE).collect();
    match with_base[..] {
        [] if FLAT * size[i] < size[(i + 1) % 3].min(size[(i + 2) % 3]) => {
            Some((axis, format!("it is thinnest along {axis}")))
        }
        [axis] if axis.index() != UpAxis::X.index() => {
            Some((axis, format!("its flat side faces {}", axis.opposite())))
        }
        // Walls, or an axis that hardly any program takes for up.
        _ => longest(),
    }
}

/// Triangles of a mesh, with the box around them.
struct Sample {
    triangles: Vec<[DVec3; 3]>,
    low: DVec3,
    high: DVec3,
    size: DVec3,
    /// How many triangles of the mesh each one stands for.
    weight: f64,
}

impl Sample {
    fn of(mesh: &TriangleMesh) -> Option<Self> {
        let count = mesh.triangles.len();
        let samples = count.min(MOST_SAMPLES);
        let point = |&i: &u32| {
            let at = |column: &[f32]| column.get(i as usize).copied().map_or(0.0, f64::from);
            DVec3::new(at(&mesh.x), at(&mesh.y), at(&mesh.z))
        };
        let chosen = (0..samples).filter_map(|i| mesh.triangles.get(i * count / samples));
        let triangles: Vec<[DVec3; 3]> = chosen.map(|[a, b, c]| [a, b, c].map(point)).collect();
        let mut points = triangles.as_flattened().iter().copied();
        let first = points.next()?;
        let (low, high) = points.fold((first, first), |(low, high), p| (low.min(p), high.max(p)));
        Some(Self {
            triangles,
            low,
            high,
            size: high - low,
            weight: count as f64 / samples as f64,
        })
    }

    /// The area of the triangles in the slab on which the mesh stands if `up` points up, as a share of the box's side.
    fn base(&self, up: UpAxis) -> f64 {
        let direction = up.vector();
        let i = up.index();
        let side = self.size[(i + 1) % 3] * self.size[(i + 2) % 3];
        let ground = direction.dot(self.low).min(direction.dot(self.high));
        let top = ground + BASE_SLAB * self.size[i];
        let in_slab = self
            .triangles
            .iter()
            .filter(|corners| corners.iter().all(|&corner| direction.dot(corner) <= top));
        let area: f64 = in_slab
            .map(|&[a, b, c]| 0.5 * (b - a).cross(c - a)[i].abs())
            .sum();
        if side > 0.0 {
            area * self.weight / side
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests;

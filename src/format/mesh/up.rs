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

    fn opposite(self) -> Self {
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
/// An upright mesh is this many times higher than it is wide and deep.
const UPRIGHT: f64 = 4.0;
/// A flat mesh, such as a terrain, is this many times wider and deeper than it is high.
const FLAT: f64 = 8.0;

/// Another axis that is more likely up than `assumed`, and why.
///
/// A mesh is doubted if it has no base where it should stand, but has one elsewhere, or flat ends of a long shape, or is much
/// thinner along another axis. Its length alone says nothing: cars and ships are as long as towers are high. A sample of the
/// triangles decides.
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
    let (along, a, b) = (size[i], size[(i + 1) % 3], size[(i + 2) % 3]);
    if sample.base(assumed) >= NO_BASE {
        return None;
    }
    let others = UpAxis::ALL.into_iter().filter(|axis| axis.index() != up);
    let with_base: Vec<UpAxis> = others.filter(|&axis| sample.base(axis) >= BASE).collect();
    match with_base[..] {
        [] if FLAT * along < a.min(b) => Some((axis, format!("it is thinnest along {axis}"))),
        [end, other] if end.index() == i && other.index() == i && along > UPRIGHT * a.max(b) => {
            Some((axis, format!("it is longest along {axis}")))
        }
        [axis] if axis.index() != UpAxis::X.index() => {
            Some((axis, format!("its flat side faces {}", axis.opposite())))
        }
        // Walls, or an axis that hardly any program takes for up.
        _ => None,
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
mod tests {
    use super::*;

    /// A face of [`open_box`].
    #[derive(PartialEq)]
    enum Face {
        Bottom,
        Top,
    }

    /// A box without its sides, with these faces.
    fn open_box(size: [f32; 3], faces: &[Face]) -> TriangleMesh {
        let mut mesh = TriangleMesh::default();
        for corner in 0..8 {
            let at = |axis: usize| if corner >> axis & 1 == 1 { size[axis] } else { 0.0 };
            mesh.x.push(at(0));
            mesh.y.push(at(1));
            mesh.z.push(at(2));
        }
        if faces.contains(&Face::Bottom) {
            mesh.triangles.extend([[0, 2, 1], [1, 2, 3]]);
        }
        if faces.contains(&Face::Top) {
            mesh.triangles.extend([[4, 5, 6], [5, 7, 6]]);
        }
        // A ridge from edge to edge: no side is flat.
        mesh.triangles.extend([[0, 1, 7], [2, 6, 5]]);
        mesh
    }

    #[test]
    fn axes_are_parsed_as_they_are_written() {
        for axis in UpAxis::ALL {
            assert_eq!(axis.name().parse(), Ok(axis));
            assert_eq!(axis.name().to_uppercase().parse(), Ok(axis));
            assert_eq!(axis.right().cross(axis.vector()), axis.front());
        }
        assert_eq!("+z".parse(), Ok(UpAxis::Z));
        assert!("up".parse::<UpAxis>().is_err() && "--x".parse::<UpAxis>().is_err());
    }

    #[test]
    fn the_front_is_gltfs_and_blenders() {
        assert_eq!((UpAxis::Y.front(), UpAxis::Y.right()), (DVec3::Z, DVec3::X));
        assert_eq!((UpAxis::Z.front(), UpAxis::Z.right()), (DVec3::NEG_Y, DVec3::X));
    }

    #[test]
    fn a_mesh_that_lies_on_its_side_is_doubted() {
        let reason =
            |mesh: &TriangleMesh, assumed| doubt(mesh, assumed).map_or(String::new(), |doubt| doubt.1);
        let statue = open_box([1.0, 1.0, 2.0], &[Face::Bottom]);
        assert_eq!(reason(&statue, UpAxis::Y), "its flat side faces -z");
        assert_eq!(doubt(&statue, UpAxis::Z), None);
        let hanging = open_box([1.0, 1.0, 2.0], &[Face::Top]);
        assert_eq!(
            doubt(&hanging, UpAxis::Y).map(|(axis, _)| axis),
            Some(UpAxis::MinusZ)
        );
        // A rocket or a ship.
        let tower = open_box([1.0, 1.0, 5.0], &[]);
        assert_eq!(doubt(&tower, UpAxis::Y), None);
        let lying = open_box([5.0, 1.0, 1.0], &[Face::Bottom, Face::Top]);
        assert_eq!(doubt(&lying, UpAxis::Z), None);
        let column = open_box([1.0, 1.0, 5.0], &[Face::Bottom, Face::Top]);
        assert_eq!(reason(&column, UpAxis::Y), "it is longest along z");
        let mut train = open_box([3.0, 4.0, 20.0], &[Face::Bottom, Face::Top]);
        train
            .triangles
            .extend([[0, 1, 5], [0, 5, 4], [2, 7, 3], [2, 6, 7]]);
        assert_eq!(doubt(&train, UpAxis::Y), None);
        let terrain = open_box([10.0, 10.0, 1.0], &[]);
        assert_eq!(reason(&terrain, UpAxis::Y), "it is thinnest along z");
        let car = open_box([1.8, 1.4, 4.5], &[]);
        assert_eq!(doubt(&car, UpAxis::Y), None);
        assert_eq!(doubt(&TriangleMesh::default(), UpAxis::Y), None);
    }
}

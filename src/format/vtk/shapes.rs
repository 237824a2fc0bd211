//! Types of cells: how each is shown.
//!
//! Cells of higher order begin with their corners. Points in the middle of their sides are shown, too, further ones are not.

/// How a cell is shown.
#[derive(Clone, Copy)]
pub(super) enum Shape {
    /// It has no points, or only says so.
    Nothing,
    /// Each point.
    Points,
    /// Lines from point to point.
    Lines,
    /// Lines from point to point; the second is the last one's end.
    Curve,
    Strip,
    /// All points are its corners.
    Polygon,
    /// A rectangle whose last two corners are swapped.
    Pixel,
    /// A polygon with this many corners; further points are left out.
    Corners(usize),
    /// A polygon with this many corners, then as many points in the middle of its sides.
    Curved(usize),
    /// As [`Shape::Curved`]; half of its points are corners.
    CurvedPolygon,
    /// A body.
    Solid {
        body: &'static Body,
        /// Points in the middle of its edges follow.
        is_curved: bool,
    },
    /// A rectangular body, whose corners are in the order of their coordinates.
    Voxel,
    /// A body of any polygons.
    Polyhedron,
}

/// The corners, faces and edges of a body.
pub(super) struct Body {
    pub(super) corners: usize,
    pub(super) faces: &'static [&'static [u8]],
    /// In the order of the points in their middle.
    pub(super) edges: &'static [[u8; 2]],
}

static TETRAHEDRON: Body = Body {
    corners: 4,
    faces: &[&[0, 1, 3], &[1, 2, 3], &[2, 0, 3], &[0, 2, 1]],
    edges: &[[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]],
};

pub(super) static HEXAHEDRON: Body = Body {
    corners: 8,
    faces: &[
        &[0, 4, 7, 3],
        &[1, 2, 6, 5],
        &[0, 1, 5, 4],
        &[3, 7, 6, 2],
        &[0, 3, 2, 1],
        &[4, 5, 6, 7],
    ],
    edges: &[
        [0, 1],
        [1, 2],
        [2, 3],
        [3, 0],
        [4, 5],
        [5, 6],
        [6, 7],
        [7, 4],
        [0, 4],
        [1, 5],
        [2, 6],
        [3, 7],
    ],
};

static WEDGE: Body = Body {
    corners: 6,
    faces: &[
        &[0, 1, 2],
        &[3, 5, 4],
        &[0, 3, 4, 1],
        &[1, 4, 5, 2],
        &[2, 5, 3, 0],
    ],
    edges: &[
        [0, 1],
        [1, 2],
        [2, 0],
        [3, 4],
        [4, 5],
        [5, 3],
        [0, 3],
        [1, 4],
        [2, 5],
    ],
};

static PYRAMID: Body = Body {
    corners: 5,
    faces: &[&[0, 3, 2, 1], &[0, 1, 4], &[1, 2, 4], &[2, 3, 4], &[3, 0, 4]],
    edges: &[[0, 1], [1, 2], [2, 3], [3, 0], [0, 4], [1, 4], [2, 4], [3, 4]],
};

static PENTAGONAL_PRISM: Body = Body {
    corners: 10,
    faces: &[
        &[0, 4, 3, 2, 1],
        &[5, 6, 7, 8, 9],
        &[0, 1, 6, 5],
        &[1, 2, 7, 6],
        &[2, 3, 8, 7],
        &[3, 4, 9, 8],
        &[4, 0, 5, 9],
    ],
    edges: &[],
};

static HEXAGONAL_PRISM: Body = Body {
    corners: 12,
    faces: &[
        &[0, 5, 4, 3, 2, 1],
        &[6, 7, 8, 9, 10, 11],
        &[0, 1, 7, 6],
        &[1, 2, 8, 7],
        &[2, 3, 9, 8],
        &[3, 4, 10, 9],
        &[4, 5, 11, 10],
        &[5, 0, 6, 11],
    ],
    edges: &[],
};

/// The order of a voxel's corners in a hexahedron.
pub(super) const VOXEL: [usize; 8] = [0, 1, 3, 2, 4, 5, 7, 6];

/// Types of cells in files.
pub(super) const POLY_VERTEX: u8 = 2;
pub(super) const POLY_LINE: u8 = 4;
pub(super) const TRIANGLE_STRIP: u8 = 6;
pub(super) const POLYGON: u8 = 7;
pub(super) const POLYHEDRON: u8 = 42;

impl Shape {
    /// How cells of a type are shown; `None` if they are not.
    pub(super) fn of(cell: u8) -> Option<Self> {
        let straight = |body| Self::Solid {
            body,
            is_curved: false,
        };
        let curved = |body| Self::Solid {
            body,
            is_curved: true,
        };
        Some(match cell {
            0 => Self::Nothing,
            1 | POLY_VERTEX => Self::Points,
            3 | POLY_LINE => Self::Lines,
            // Quadratic and cubic edges, Lagrange and Bezier curves.
            21 | 35 | 68 | 75 => Self::Curve,
            TRIANGLE_STRIP => Self::Strip,
            // Triangles, quads.
            5 | POLYGON | 9 => Self::Polygon,
            8 => Self::Pixel,
            // Lagrange and Bezier triangles; quads, also linear in one direction.
            69 | 76 => Self::Corners(3),
            30 | 70 | 77 => Self::Corners(4),
            22 | 34 => Self::Curved(3),
            23 | 28 => Self::Curved(4),
            36 => Self::CurvedPolygon,
            10 | 71 | 78 => straight(&TETRAHEDRON),
            11 => Self::Voxel,
            12 | 72 | 79 => straight(&HEXAHEDRON),
            13 | 31 | 73 | 80 => straight(&WEDGE),
            14 | 74 | 81 => straight(&PYRAMID),
            15 => straight(&PENTAGONAL_PRISM),
            16 => straight(&HEXAGONAL_PRISM),
            24 => curved(&TETRAHEDRON),
            25 | 29 | 33 => curved(&HEXAHEDRON),
            26 | 32 => curved(&WEDGE),
            27 | 37 => curved(&PYRAMID),
            POLYHEDRON => Self::Polyhedron,
            _ => return None,
        })
    }

    /// Whether it is a body, of which outer faces are shown.
    pub(super) fn is_body(self) -> bool {
        matches!(self, Self::Solid { .. } | Self::Voxel | Self::Polyhedron)
    }

    /// The fewest points that it has.
    pub(super) fn least(self) -> usize {
        match self {
            Self::Nothing | Self::Points | Self::Polyhedron => 0,
            Self::Lines | Self::Curve => 2,
            Self::Strip | Self::Polygon => 3,
            Self::Pixel => 4,
            Self::Corners(corners) => corners,
            Self::Curved(corners) => 2 * corners,
            Self::CurvedPolygon => 6,
            Self::Solid { body, is_curved } => body.corners + if is_curved { body.edges.len() } else { 0 },
            Self::Voxel => 8,
        }
    }
}

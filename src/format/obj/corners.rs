//! The corners of faces. OBJ indexes positions and normals separately; here they become vertices that have both.

use super::{
    super::{
        budget::{Budget, BudgetError},
        left_out::counted,
        place::{TextFault, Words},
        polygon::{Cutter, Fans},
    },
    corner,
};
use crate::{error::quote, scene::TriangleMesh};
use glam::{DVec3, Vec3};
use std::{collections::HashMap, ops::Range};

/// A corner as written: 1-based, or negative and counted from the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Corner {
    pub(super) position: i64,
    pub(super) normal: Option<i64>,
}

/// A corner without a normal.
const NONE: u32 = u32::MAX;

/// How many vertices at one position are searched in turn.
const MOST_STEPS: usize = 16;

/// The corners of all triangles.
#[derive(Default)]
pub(super) struct Corners {
    positions: Vec<[u32; 3]>,
    /// Empty until a corner has a normal, then as long as `positions`.
    normals: Vec<[u32; 3]>,
    polygons: Fans,
    /// The largest indices.
    largest: [u32; 2],
    /// The current face.
    face: Vec<[u32; 2]>,
}

impl Corners {
    pub(super) fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Whether an index reaches its limit; `limits` are the numbers of positions and normals.
    pub(super) fn are_beyond(&self, limits: [usize; 2]) -> bool {
        let any = !self.positions.is_empty();
        let [position, normal] = self.largest.map(|index| index as usize);
        any && (position >= limits[0] || (!self.normals.is_empty() && normal >= limits[1]))
    }

    /// Adds a face and returns its number of triangles. `sizes` are the numbers of positions and normals so far.
    pub(super) fn face(
        &mut self,
        words: Words<'_>,
        keyword: &Range<usize>,
        sizes: [usize; 2],
        limits: Option<[usize; 2]>,
        budget: &Budget,
    ) -> Result<usize, TextFault> {
        self.face.clear();
        let whole_line = keyword.start..words.end_of_words();
        for (word, place) in words {
            if word.starts_with(b"#") {
                break;
            }
            let fault = |message: String| TextFault::new(place.clone(), message);
            let Some(corner) = corner(word) else {
                let message = format!(
                    "corner {}, expected indices such as `1`, `1/2`, `1//3` or `1/2/3`",
                    quote(word)
                );
                return Err(fault(message));
            };
            let resolve = |index: i64, size: usize, what: [&str; 2], limit: Option<usize>| {
                let resolved = if index < 0 { index + size as i64 } else { index - 1 };
                let index_fault = |count: usize| {
                    let [one, many] = what;
                    let (are, noun) = if count == 1 { ("is", one) } else { ("are", many) };
                    fault(format!(
                        "{one} index {index}, but there {are} only {count} {noun}"
                    ))
                };
                if index == 0 {
                    return Err(fault(format!(
                        "{} index 0, expected a positive or negative index",
                        what[0]
                    )));
                }
                match u32::try_from(resolved) {
                    Ok(resolved)
                        if resolved < NONE && limit.is_none_or(|limit| (resolved as usize) < limit) =>
                    {
                        Ok(resolved)
                    }
                    _ => Err(index_fault(limit.unwrap_or(size))),
                }
            };
            let position = resolve(
                corner.position,
                sizes[0],
                ["vertex", "vertices"],
                limits.map(|l| l[0]),
            )?;
            let normal = match corner.normal {
                Some(normal) => resolve(normal, sizes[1], ["normal", "normals"], limits.map(|l| l[1]))?,
                None => NONE,
            };
            self.largest[0] = self.largest[0].max(position);
            if normal != NONE {
                self.largest[1] = self.largest[1].max(normal);
            }
            budget.reserve(&mut self.face, 1)?;
            self.face.push([position, normal]);
        }
        if self.face.len() < 3 {
            let message = format!(
                "face with {}, expected 3 or more",
                counted(self.face.len(), "corner", "corners")
            );
            return Err(TextFault::new(whole_line, message));
        }
        Ok(self.add_fan(budget)?)
    }

    /// Adds the current face as a fan and returns its number of triangles.
    fn add_fan(&mut self, budget: &Budget) -> Result<usize, BudgetError> {
        let (first, others) = (self.face[0], &self.face[1..]);
        let (start, count) = (self.positions.len(), others.len() - 1);
        let has_normals = self.face.iter().any(|corner| corner[1] != NONE);
        if has_normals {
            let missing = start + count - self.normals.len();
            budget.reserve(&mut self.normals, missing)?;
            self.normals.resize(start, [NONE; 3]);
        }
        budget.reserve(&mut self.positions, count)?;
        self.polygons.add(start, count, 1, budget)?;
        for pair in others.windows(2) {
            self.positions.push([first[0], pair[0][0], pair[1][0]]);
            if has_normals {
                self.normals.push([first[1], pair[0][1], pair[1][1]]);
            }
        }
        Ok(count)
    }

    /// Triangulates concave faces; `mesh` holds the positions.
    pub(super) fn cut_concave(&mut self, mesh: &TriangleMesh) {
        let mut cutter = Cutter::default();
        let (mut ring, mut points) = (Vec::new(), Vec::new());
        for triangles in self.polygons.polygons() {
            let has_normals = self.normals.len() >= triangles.end;
            ring.clear();
            for i in triangles.clone() {
                let positions = self.positions[i];
                let normals = if has_normals { self.normals[i] } else { [NONE; 3] };
                let new = if ring.is_empty() { 0 } else { 2 };
                ring.extend((new..3).map(|corner| [positions[corner], normals[corner]]));
            }
            let point = |&[position, _]: &[u32; 2]| {
                let column = |column: &[f32]| column.get(position as usize).map_or(0.0, |&x| x.into());
                DVec3::new(column(&mesh.x), column(&mesh.y), column(&mesh.z))
            };
            points.clear();
            points.extend(ring.iter().map(point));
            let Some(cut) = cutter.cut(&points) else {
                continue;
            };
            for (i, corners) in triangles.zip(cut) {
                self.positions[i] = corners.map(|corner| ring[corner as usize][0]);
                if has_normals {
                    self.normals[i] = corners.map(|corner| ring[corner as usize][1]);
                }
            }
        }
    }

    /// Moves the corners into a mesh that holds the positions. A position with several normals becomes several vertices.
    pub(super) fn into_columns(
        self,
        normals: &[[f32; 3]],
        mesh: &mut TriangleMesh,
        budget: &Budget,
    ) -> Result<(), BudgetError> {
        let Self {
            mut positions,
            normals: mut normal_corners,
            ..
        } = self;
        if normal_corners.is_empty() {
            mesh.triangles = positions;
            return Ok(());
        }
        let missing = positions.len() - normal_corners.len();
        budget.reserve(&mut normal_corners, missing)?;
        normal_corners.resize(positions.len(), [NONE; 3]);
        let mut vertices = Vertices::new(mesh.x.len(), budget)?;
        for (corners, normals) in positions.iter_mut().zip(&normal_corners) {
            for (corner, &normal) in corners.iter_mut().zip(normals) {
                let position = *corner;
                let vertex = vertices.vertex(position, normal)?;
                if vertex as usize == mesh.x.len() {
                    for column in [&mut mesh.x, &mut mesh.y, &mut mesh.z] {
                        budget.reserve(column, 1)?;
                        column.push(column[position as usize]);
                    }
                    if !mesh.colors.is_empty() {
                        budget.reserve(&mut mesh.colors, 1)?;
                        mesh.colors.push(mesh.colors[position as usize]);
                    }
                }
                *corner = vertex;
            }
        }
        drop(normal_corners);
        let normal = |index: &Option<u32>| {
            let normal = index.and_then(|index| normals.get(index as usize));
            normal.map_or(Vec3::ZERO, |&normal| Vec3::from_array(normal))
        };
        let count = vertices.normals.len();
        budget.reserve(&mut mesh.normals, count)?;
        mesh.normals.extend(vertices.normals.iter().map(normal));
        mesh.triangles = positions;
        Ok(())
    }
}

/// The vertices: one for each position, and more for its further normals.
struct Vertices<'a> {
    budget: &'a Budget,
    /// Each vertex's normal, once a corner sets it.
    normals: Vec<Option<u32>>,
    /// The next vertex at the same position.
    next: Vec<u32>,
    /// The vertex by position and normal, beyond [`MOST_STEPS`] at a position.
    others: HashMap<[u32; 2], u32>,
}

/// Memory of an entry of [`Vertices::others`], bytes: it may be half empty, and moves as it grows.
const ENTRY_BYTES: usize = 48;

impl<'a> Vertices<'a> {
    fn new(positions: usize, budget: &'a Budget) -> Result<Self, BudgetError> {
        let (mut normals, mut next) = (Vec::new(), Vec::new());
        budget.reserve(&mut normals, positions)?;
        budget.reserve(&mut next, positions)?;
        normals.resize(positions, None);
        next.resize(positions, NONE);
        Ok(Self {
            budget,
            normals,
            next,
            others: HashMap::new(),
        })
    }

    /// The vertex with this position and normal.
    fn vertex(&mut self, position: u32, normal: u32) -> Result<u32, BudgetError> {
        let (mut vertex, mut steps) = (position, 0);
        loop {
            let at = vertex as usize;
            match self.normals[at] {
                None => {
                    self.normals[at] = Some(normal);
                    return Ok(vertex);
                }
                Some(other) if other == normal => return Ok(vertex),
                Some(_) if steps == MOST_STEPS => break,
                Some(_) if self.next[at] == NONE => {
                    self.next[at] = self.add(normal)?;
                    return Ok(self.next[at]);
                }
                Some(_) => vertex = self.next[at],
            }
            steps += 1;
        }
        if let Some(&vertex) = self.others.get(&[position, normal]) {
            return Ok(vertex);
        }
        self.budget.take(ENTRY_BYTES)?;
        let reserved = self.others.try_reserve(1);
        reserved.map_err(|_| BudgetError::NoMemory)?;
        let copy = self.add(normal)?;
        self.others.insert([position, normal], copy);
        Ok(copy)
    }

    /// Adds a vertex.
    fn add(&mut self, normal: u32) -> Result<u32, BudgetError> {
        self.budget.reserve(&mut self.normals, 1)?;
        self.budget.reserve(&mut self.next, 1)?;
        self.normals.push(Some(normal));
        self.next.push(NONE);
        Ok(self.normals.len() as u32 - 1)
    }
}

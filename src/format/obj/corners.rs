//! The corners of faces. OBJ indexes positions, normals and texture coordinates separately; here they become vertices
//! that have all.

use super::super::{
    budget::{Budget, BudgetError},
    place::{TextFault, Words},
    polygon::{self, Cutter, Fans},
    vertices::{NONE, Vertices},
};
use super::{super::mesh::Surface, colors::count_once, textures::Shift};
use crate::{error::quote, scene::TriangleMesh};
use glam::{DVec3, Vec3};
use std::collections::HashMap;

/// A corner as written: 1-based, or negative and counted from the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Corner {
    pub(super) position: i64,
    pub(super) texture: Option<i64>,
    pub(super) normal: Option<i64>,
}

/// The 0-based index that an index in a file means, where there are `size` elements so far and `limit`, if that is known,
/// in all. `what` names one and many of them. The error is a sentence.
pub(super) fn resolve(index: i64, size: usize, what: [&str; 2], limit: Option<usize>) -> Result<u32, String> {
    let [one, many] = what;
    if index == 0 {
        return Err(format!(
            "{one} index 0, expected 1 for the first, or a negative index"
        ));
    }
    let resolved = if index < 0 { index + size as i64 } else { index - 1 };
    match u32::try_from(resolved) {
        Ok(resolved) if resolved < NONE && limit.is_none_or(|limit| (resolved as usize) < limit) => {
            Ok(resolved)
        }
        _ => {
            let count = limit.filter(|_| index > 0).unwrap_or(size);
            let there_are = match count {
                0 => format!("are no {many}"),
                1 => format!("is only 1 {one}"),
                count => format!("are only {count} {many}"),
            };
            Err(format!("{one} index {index}, but there {there_are}"))
        }
    }
}

/// The corners of all triangles.
#[derive(Default)]
pub(super) struct Corners {
    positions: Vec<[u32; 3]>,
    /// Empty until a corner has a normal, then as long as `positions`.
    normals: Vec<[u32; 3]>,
    /// Texture coordinates, likewise; empty unless they are wanted.
    uvs: Vec<[u32; 3]>,
    polygons: Fans,
    /// How many faces have fewer than three corners; they are left out.
    pub(super) small: usize,
    /// The largest indices.
    largest: [u32; 2],
    /// The current face.
    face: Vec<[u32; 3]>,
}

impl Corners {
    pub(super) fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Whether the file has faces, also if all are left out.
    pub(super) fn has_faces(&self) -> bool {
        !self.is_empty() || self.small > 0
    }

    /// Whether a corner of triangle `i` has none of `count` texture coordinates.
    pub(super) fn lacks_uvs(&self, i: usize, count: usize) -> bool {
        let of = self.uvs.get(i).copied().unwrap_or([NONE; 3]);
        of.iter().any(|&index| index as usize >= count)
    }

    /// Makes base colours white that their triangles have as vertex colours, too.
    pub(super) fn count_colors_once(
        &self,
        surfaces: &mut [Surface],
        surface_of: &[u32],
        colors: &[[f32; 3]],
        budget: &Budget,
    ) -> Result<(), BudgetError> {
        count_once(surfaces, (surface_of, &self.positions), colors, budget)
    }

    /// Forgets texture coordinates.
    pub(super) fn drop_uvs(&mut self) {
        self.uvs = Vec::new();
    }

    /// Forgets normals.
    pub(super) fn drop_normals(&mut self) {
        self.normals = Vec::new();
    }

    /// Whether corners have normals.
    pub(super) fn have_normals(&self) -> bool {
        !self.normals.is_empty()
    }

    /// Whether an index reaches its limit; `limits` are the numbers of positions and normals.
    pub(super) fn are_beyond(&self, limits: [usize; 2]) -> bool {
        let any = !self.positions.is_empty();
        let [position, normal] = self.largest.map(|index| index as usize);
        any && (position >= limits[0] || (!self.normals.is_empty() && normal >= limits[1]))
    }

    /// Adds a face and returns its number of triangles. `sizes` are the numbers of positions and normals so far; `uvs` is
    /// that of texture coordinates if they are wanted.
    pub(super) fn face(
        &mut self,
        words: Words<'_>,
        sizes: [usize; 2],
        uvs: Option<usize>,
        limits: Option<[usize; 2]>,
        budget: &Budget,
    ) -> Result<usize, TextFault> {
        self.face.clear();
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
            let [most_positions, most_normals] = [0, 1].map(|kind| limits.map(|limits| limits[kind]));
            // Some programs write indices of normals that they do not write.
            let most_normals = most_normals.filter(|&most| most > 0);
            let position =
                resolve(corner.position, sizes[0], ["vertex", "vertices"], most_positions).map_err(fault)?;
            let normal = match corner.normal {
                Some(normal) => {
                    resolve(normal, sizes[1], ["normal", "normals"], most_normals).map_err(fault)?
                }
                None => NONE,
            };
            self.largest[0] = self.largest[0].max(position);
            if normal != NONE {
                self.largest[1] = self.largest[1].max(normal);
            }
            budget.reserve(&mut self.face, 1)?;
            // Many files have indices without coordinates.
            let texture = uvs.zip(corner.texture).map_or(NONE, |(size, index)| {
                let resolved = if index < 0 { index + size as i64 } else { index - 1 };
                u32::try_from(resolved).unwrap_or(NONE)
            });
            self.face.push([position, normal, texture]);
        }
        if self.face.len() < 3 {
            self.small += 1;
            return Ok(0);
        }
        Ok(self.add_fan(budget)?)
    }

    /// Adds the current face as a fan and returns its number of triangles.
    fn add_fan(&mut self, budget: &Budget) -> Result<usize, BudgetError> {
        let (first, others) = (self.face[0], &self.face[1..]);
        let (start, count) = (self.positions.len(), others.len() - 1);
        budget.reserve(&mut self.positions, count)?;
        self.polygons.add(start, count, 1, budget)?;
        let fan = |kind: usize| {
            others
                .windows(2)
                .map(move |pair| [first[kind], pair[0][kind], pair[1][kind]])
        };
        self.positions.extend(fan(0));
        for (kind, all) in [(1, &mut self.normals), (2, &mut self.uvs)] {
            if self.face.iter().any(|corner| corner[kind] != NONE) {
                let missing = start + count - all.len();
                budget.reserve(all, missing)?;
                all.resize(start, [NONE; 3]);
                all.extend(fan(kind));
            }
        }
        Ok(count)
    }

    /// Triangulates concave faces; `mesh` holds the positions. Returns how many too complex ones stay fans.
    pub(super) fn cut_concave(&mut self, mesh: &TriangleMesh, budget: &Budget) -> Result<usize, BudgetError> {
        let mut cutter = Cutter::default();
        let (mut ring, mut points) = (Vec::new(), Vec::new());
        for triangles in self.polygons.polygons() {
            let room = polygon::cutting_bytes(triangles.len());
            budget.take(room)?;
            ring.clear();
            for i in triangles.clone() {
                let new = if ring.is_empty() { 0 } else { 2 };
                ring.extend((new..3).map(|corner| {
                    let of = |all: &[[u32; 3]]| all.get(i).map_or(NONE, |corners| corners[corner]);
                    [of(&self.positions), of(&self.normals), of(&self.uvs)]
                }));
            }
            let columns = [&mesh.x[..], &mesh.y, &mesh.z];
            points.clear();
            points.extend(ring.iter().map(|corner| polygon::position(columns, corner[0])));
            if let Some(unusable) = points.iter().position(|point: &DVec3| point.is_nan()) {
                // All of the polygon is left out.
                self.positions[triangles].fill([ring[unusable][0]; 3]);
                budget.give_back(room);
                continue;
            }
            let cut = cutter.cut(&points).unwrap_or_default();
            for (i, corners) in triangles.zip(cut) {
                for (kind, all) in [&mut self.positions, &mut self.normals, &mut self.uvs]
                    .into_iter()
                    .enumerate()
                {
                    if let Some(of) = all.get_mut(i) {
                        *of = corners.map(|corner| ring[corner as usize][kind]);
                    }
                }
            }
            budget.give_back(room);
        }
        Ok(cutter.given_up)
    }

    /// Moves texture coordinates as the surfaces of triangles say. Moved ones are added to `uvs`, since other surfaces may
    /// use the same ones.
    pub(super) fn move_uvs(
        &mut self,
        (uvs, surface_of, shifts): (&mut Vec<[f32; 2]>, &[u32], &HashMap<u32, Shift>),
        budget: &Budget,
    ) -> Result<(), BudgetError> {
        // An entry of a map that is half empty.
        const ENTRY_BYTES: usize = 48;
        if shifts.is_empty() {
            return Ok(());
        }
        let (count, mut moved) = (uvs.len(), HashMap::new());
        for (corners, surface) in self.uvs.iter_mut().zip(surface_of) {
            for corner in corners {
                let uv = uvs.get(*corner as usize).filter(|_| (*corner as usize) < count);
                let (uv, shift) = match (uv, shifts.get(surface)) {
                    (Some(&uv), Some(shift)) => (uv, shift),
                    (Some(_), None) => continue,
                    (None, _) => {
                        *corner = NONE;
                        continue;
                    }
                };
                let next = uvs.len() as u32;
                let number = *moved.entry((*corner, *surface)).or_insert(next);
                if number == next {
                    budget.take(ENTRY_BYTES)?;
                    budget.reserve(uvs, 1)?;
                    uvs.push(shift.apply(uv));
                }
                *corner = number;
            }
        }
        budget.give_back(moved.len() * ENTRY_BYTES);
        Ok(())
    }

    /// Moves the corners into a mesh that holds the positions. A position with several normals or texture coordinates
    /// becomes several vertices.
    pub(super) fn into_columns(
        self,
        normals: &[Vec3],
        uvs: &[[f32; 2]],
        mesh: &mut TriangleMesh,
        budget: &Budget,
    ) -> Result<(), BudgetError> {
        let mut positions = self.positions;
        let (normal_corners, uv_corners) = (self.normals, self.uvs);
        let (has_normals, has_uvs) = (!normal_corners.is_empty(), !uv_corners.is_empty());
        if !has_normals && !has_uvs {
            mesh.triangles = positions;
            return Ok(());
        }
        let mut vertices = Vertices::new(mesh.x.len(), budget)?;
        for (i, corners) in positions.iter_mut().enumerate() {
            let of = |all: &[[u32; 3]]| all.get(i).copied().unwrap_or([NONE; 3]);
            let (normals, textures) = (of(&normal_corners), of(&uv_corners));
            for (k, corner) in corners.iter_mut().enumerate() {
                let position = *corner;
                let vertex = vertices.vertex(position, [normals[k], textures[k]])?;
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
        drop((normal_corners, uv_corners));
        mesh.triangles = positions;
        let all = vertices.into_attributes();
        if has_normals {
            let normal = |of: &Option<[u32; 2]>| of.and_then(|[normal, _]| normals.get(normal as usize));
            budget.reserve(&mut mesh.normals, all.len())?;
            let normals = all.iter().map(|of| normal(of).copied().unwrap_or_default());
            mesh.normals.extend(normals);
        }
        if has_uvs {
            let uv = |of: &Option<[u32; 2]>| of.and_then(|[_, texture]| uvs.get(texture as usize)).copied();
            budget.reserve(&mut mesh.uvs, all.len())?;
            mesh.uvs.extend(all.iter().map(|of| uv(of).unwrap_or_default()));
        }
        Ok(())
    }
}

/// A corner's word: `v`, `v/vt`, `v//vn` or `v/vt/vn`.
pub(super) fn corner(word: &[u8]) -> Option<Corner> {
    let mut parts = word.split(|&byte| byte == b'/');
    let position = whole(parts.next()?)?;
    let texture = parts.next();
    let normal = parts.next();
    if parts.next().is_some() || texture.is_some_and(|word| !word.is_empty() && whole(word).is_none()) {
        return None;
    }
    let normal = match normal {
        None | Some([]) => None,
        Some(word) => Some(whole(word)?),
    };
    let texture = texture.and_then(whole);
    Some(Corner {
        position,
        texture,
        normal,
    })
}

#[inline]
fn whole(word: &[u8]) -> Option<i64> {
    let (sign, digits) = match word {
        [b'-', digits @ ..] => (-1, digits),
        [b'+', digits @ ..] | digits => (1, digits),
    };
    // Longer ones are out of range and would overflow.
    if digits.is_empty() || digits.len() > 18 {
        return None;
    }
    let mut value = 0;
    for digit in digits {
        if !digit.is_ascii_digit() {
            return None;
        }
        value = value * 10 + i64::from(digit - b'0');
    }
    Some(sign * value)
}

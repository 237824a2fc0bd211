//! Reads records value by value, for any encoding and layout, and locates every error.

use super::{
    at::At,
    faces::{Faces, UNKNOWN_UV, upper_left},
    fault::{Fault, Place},
    header::{Element, Header, Role, Step, color_scale},
    painted,
    slots::{COLOR_SLOT, NORMAL_SLOT, SLOTS, UV_SLOT, VALUE_SLOT},
};
use crate::{
    error::{LoadErrorKind, quote},
    format::{
        budget::{Budget, BudgetError},
        mesh::{Owner, Unusable, channels, usable_normal},
        offset::Offset,
    },
    scene::{TriangleMesh, is_usable},
};
use serde_ply::ScalarType;

/// Why a value could not be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wrong {
    /// The end of the file.
    End,
    /// A word that is not a number.
    NotANumber,
    /// A number that is not an integer.
    NotWhole,
}

/// Reads the values of records in turn, in text or binary.
pub(super) trait Values {
    /// How many bytes shorter than `least_bytes` the file's last number may be.
    const SPARE: usize;

    /// The next number.
    fn real(&mut self, scalar: ScalarType) -> Result<f32, Wrong>;
    /// The next number, not rounded to `f32`.
    fn double(&mut self, scalar: ScalarType) -> Result<f64, Wrong>;
    /// The next number, which must be an integer.
    fn whole(&mut self, scalar: ScalarType) -> Result<i64, Wrong>;
    /// Skips numbers.
    fn skip(&mut self, scalar: ScalarType, count: usize) -> Result<(), Wrong>;
    /// Moves to the start of the next record and returns it.
    fn begin_record(&mut self) -> usize;
    /// Whether the record ends here.
    fn end_record(&mut self) -> bool;
    /// The fault if it does not. The record starts at `start` and is called `record`.
    fn leftover(&self, start: usize, record: &str) -> Fault;
    /// How many bytes are left.
    fn bytes_left(&self) -> usize;
    /// The least bytes of a number.
    fn least_bytes(scalar: ScalarType) -> usize;
    /// The last value as written, in a text.
    fn last_word(&self) -> Option<&[u8]>;
    /// The place of the last value, or of the whole record, which starts at `start`.
    fn place(&self, start: usize, whole_record: bool) -> Place;
    /// The end of a message that says where `record` starts, if the place does not.
    fn where_in_file(&self, record: &str, start: usize) -> String;
    /// Reads the vertices with a fast path. Returns `false`, with nothing read, if their layout has no fast path or a
    /// value is faulty: the slow path then finds the place.
    fn fast_vertices(
        &mut self,
        _element: &Element,
        _mesh: &mut TriangleMesh,
        _faces: &mut Faces<'_>,
    ) -> Result<bool, Fault> {
        Ok(false)
    }
    /// As [`Values::fast_vertices`], for faces.
    fn fast_faces(
        &mut self,
        _element: &Element,
        _vertices: usize,
        _faces: &mut Faces<'_>,
    ) -> Result<bool, Fault> {
        Ok(false)
    }
    /// Skips all records at once, if their layout allows it.
    fn fast_skip(&mut self, _element: &Element) -> bool {
        false
    }
}

/// Reads all elements up to the last one needed for a mesh.
pub(super) fn read_all<'b, V: Values>(
    header: &Header,
    values: &mut V,
    budget: &'b Budget,
) -> Result<(TriangleMesh, Faces<'b>), Fault> {
    let (mut mesh, mut faces) = (TriangleMesh::default(), Faces::new(budget));
    for element in header.needed() {
        match element.role {
            Role::Vertex => read_vertices(element, header, values, &mut mesh, &mut faces)?,
            Role::Face if element.is_painted() => {
                reserve_faces(element, values, &mut faces)?;
                painted::read_faces(element, header, values, &mut faces)?;
            }
            Role::Face => read_faces(element, header, values, &mut faces)?,
            Role::Strips => read_strips(element, header.vertices, values, &mut faces)?,
            Role::Edge => read_edges(element, header.vertices, values, &mut faces)?,
            Role::Other if values.fast_skip(element) => {}
            Role::Other => read_others(element, values)?,
        }
    }
    Ok((mesh, faces))
}

fn read_vertices<V: Values>(
    element: &Element,
    header: &Header,
    values: &mut V,
    mesh: &mut TriangleMesh,
    faces: &mut Faces<'_>,
) -> Result<(), Fault> {
    let budget = faces.budget;
    let before = budget.taken();
    if values.fast_vertices(element, mesh, faces)? {
        return Ok(());
    }
    budget.give_back_to(before);
    reserve_vertices(element, header, mesh, budget)?;
    let (alpha, offset) = (element.alpha(), budget.offset());
    for record in 1..=element.count {
        let start = values.begin_record();
        let (mut kept, mut value) = ([0.0; SLOTS], f64::NAN);
        for (step_i, step) in element.steps.iter().enumerate() {
            let at = At {
                element,
                step_i,
                start,
                record,
            };
            match *step {
                Step::Keep {
                    slot: VALUE_SLOT,
                    scalar,
                } => value = values.double(scalar).map_err(|wrong| at.wrong(values, wrong))?,
                Step::Keep { slot, scalar } => {
                    if let Some(kept) = kept.get_mut(slot) {
                        *kept = vertex_number((slot, offset), scalar, values, &at, &mut faces.unusable)?;
                    }
                }
                Step::Skip(scalar) if alpha == Some(step_i) => {
                    faces.translucent.vertex |= painted::is_translucent(scalar, values, &at)?;
                }
                _ => skip(step, values, &at)?,
            }
        }
        end_record(
            &At {
                element,
                step_i: 0,
                start,
                record,
            },
            values,
        )?;
        let [x, y, z, nx, ny, nz, red, green, blue, u, v] = kept;
        faces.unusable.count += usize::from(![x, y, z].into_iter().all(is_usable));
        mesh.x.push(x);
        mesh.y.push(y);
        mesh.z.push(z);
        if header.has_normals {
            let normal = usable_normal([nx, ny, nz], &mut faces.odd_normals);
            mesh.normals.push(normal);
        }
        if header.has_colors {
            mesh.colors.push([red, green, blue]);
        } else if header.valued == Some(Owner::Vertices) {
            mesh.colors.push(channels(value));
        }
        if header.has_uvs {
            let uv = upper_left([u, v]);
            faces.odd_uvs += usize::from(uv.is_none());
            mesh.uvs.push(uv.unwrap_or(UNKNOWN_UV));
        }
    }
    Ok(())
}

/// The number of a vertex for this slot. Positions and normals may be NaN or too large.
#[inline]
fn vertex_number<V: Values>(
    (slot, offset): (usize, Offset),
    scalar: ScalarType,
    values: &mut V,
    at: &At<'_>,
    unusable: &mut Unusable<Fault>,
) -> Result<f32, Fault> {
    if slot >= UV_SLOT {
        return uv_number(scalar, values, at);
    }
    let value = if slot < NORMAL_SLOT && !offset.is_none() {
        values.double(scalar).map(|value| offset.relative(slot, value))
    } else {
        values.real(scalar)
    };
    let value = value.map_err(|wrong| at.wrong(values, wrong))?;
    let is_color = slot >= COLOR_SLOT;
    if is_color && !value.is_finite() {
        return Err(at.unusable(values, slot, value));
    }
    if slot < NORMAL_SLOT && !is_usable(value) {
        unusable.keep_first(|| at.unusable(values, slot, value));
    }
    Ok(if is_color {
        value / color_scale(scalar)
    } else {
        value
    })
}

/// Reserves arrays for all vertices. The header check ensures that the file is long enough for them.
fn reserve_vertices(
    element: &Element,
    header: &Header,
    mesh: &mut TriangleMesh,
    budget: &Budget,
) -> Result<(), Fault> {
    for column in [&mut mesh.x, &mut mesh.y, &mut mesh.z] {
        reserve(column, element.count, element, budget)?;
    }
    if header.has_normals {
        reserve(&mut mesh.normals, element.count, element, budget)?;
    }
    if header.has_colors || header.valued == Some(Owner::Vertices) {
        reserve(&mut mesh.colors, element.count, element, budget)?;
    }
    if header.has_uvs {
        reserve(&mut mesh.uvs, element.count, element, budget)?;
    }
    Ok(())
}

/// A number of a texture coordinate; NaN for any other word.
pub(super) fn uv_number<V: Values>(scalar: ScalarType, values: &mut V, at: &At<'_>) -> Result<f32, Fault> {
    match values.real(scalar) {
        Ok(value) => Ok(value),
        Err(Wrong::End) => Err(at.wrong(values, Wrong::End)),
        Err(_) => Ok(f32::NAN),
    }
}

fn read_faces<V: Values>(
    element: &Element,
    header: &Header,
    values: &mut V,
    faces: &mut Faces<'_>,
) -> Result<(), Fault> {
    let before = faces.budget.taken();
    if values.fast_faces(element, header.vertices, faces)? {
        return Ok(());
    }
    faces.budget.give_back_to(before);
    reserve_faces(element, values, faces)?;
    for_each_property(element, values, |values, step, at| match *step {
        Step::Indices { count, item } => {
            let corners = list_length(count, item, values, at)?;
            read_corners(corners, item, header.vertices, values, faces, at)
        }
        _ => skip(step, values, at),
    })
}

/// Reserves no more than the file can hold: the count may be wrong.
fn reserve_faces<V: Values>(element: &Element, values: &V, faces: &mut Faces<'_>) -> Result<(), Fault> {
    let least = element.steps.iter().map(|step| match *step {
        Step::Indices { count, item } => V::least_bytes(count) + 3 * V::least_bytes(item),
        Step::SkipList { count: scalar, .. }
        | Step::CornerUvs { count: scalar, .. }
        | Step::Skip(scalar)
        | Step::TextureNumber(scalar)
        | Step::Keep { scalar, .. } => V::least_bytes(scalar),
    });
    let possible = values.bytes_left() / least.sum::<usize>().max(1);
    let possible = element.count.min(possible + 1);
    reserve(&mut faces.triangles, possible, element, faces.budget)
}

/// Visits every property of every record of an element.
pub(super) fn for_each_property<V: Values>(
    element: &Element,
    values: &mut V,
    mut read: impl FnMut(&mut V, &Step, &At<'_>) -> Result<(), Fault>,
) -> Result<(), Fault> {
    for record in 1..=element.count {
        let mut at = At {
            element,
            step_i: 0,
            start: values.begin_record(),
            record,
        };
        for (step_i, step) in element.steps.iter().enumerate() {
            at.step_i = step_i;
            read(values, step, &at)?;
        }
        at.step_i = 0;
        end_record(&at, values)?;
    }
    Ok(())
}

/// One polygon as a fan around its first corner.
pub(super) fn read_corners<V: Values>(
    corners: usize,
    item: ScalarType,
    vertices: usize,
    values: &mut V,
    faces: &mut Faces<'_>,
    at: &At<'_>,
) -> Result<(), Fault> {
    faces.add_fan(corners)?;
    let (mut first, mut previous) = (0, 0);
    for corner in 0..corners {
        let index = values.whole(item).map_err(|wrong| at.wrong(values, wrong))?;
        let vertex = checked_index(index, vertices, values, at)?;
        match corner {
            0 => first = vertex,
            1 => {}
            _ => faces.triangles.push([first, previous, vertex]),
        }
        previous = vertex;
    }
    Ok(())
}

fn read_strips<V: Values>(
    element: &Element,
    vertices: usize,
    values: &mut V,
    faces: &mut Faces<'_>,
) -> Result<(), Fault> {
    let Faces {
        triangles, budget, ..
    } = faces;
    for_each_property(element, values, |values, step, at| {
        let &Step::Indices { count, item } = step else {
            return skip(step, values, at);
        };
        let (mut strip_length, mut last) = (0, [0; 2]);
        let length = list_length(count, item, values, at)?;
        budget.reserve(triangles, length.saturating_sub(2))?;
        for _ in 0..length {
            let index = values.whole(item).map_err(|wrong| at.wrong(values, wrong))?;
            if index == -1 {
                strip_length = 0;
                continue;
            }
            let vertex = checked_index(index, vertices, values, at)?;
            // Every other triangle of a strip has the opposite winding.
            match strip_length {
                0 | 1 => {}
                length if length % 2 == 0 => triangles.push([last[0], last[1], vertex]),
                _ => triangles.push([last[1], last[0], vertex]),
            }
            last = [last[1], vertex];
            strip_length += 1;
        }
        Ok(())
    })
}

fn read_edges<V: Values>(
    element: &Element,
    vertices: usize,
    values: &mut V,
    faces: &mut Faces<'_>,
) -> Result<(), Fault> {
    let (lines, mut ends, mut is_second) = (&mut faces.lines, [0; 2], false);
    reserve(lines, element.count, element, faces.budget)?;
    for_each_property(element, values, |values, step, at| {
        let &Step::Keep { slot, scalar } = step else {
            return skip(step, values, at);
        };
        let index = values.whole(scalar).map_err(|wrong| at.wrong(values, wrong))?;
        let vertex = checked_index(index, vertices, values, at)?;
        if let Some(end) = ends.get_mut(slot) {
            *end = vertex;
        }
        // The two may stand in any order.
        if is_second {
            lines.push(ends);
        }
        is_second = !is_second;
        Ok(())
    })
}

fn checked_index<V: Values>(index: i64, vertices: usize, values: &V, at: &At<'_>) -> Result<u32, Fault> {
    match u32::try_from(index) {
        Ok(vertex) if (vertex as usize) < vertices => Ok(vertex),
        _ => Err(at.bad_index(values, index, vertices)),
    }
}

fn read_others<V: Values>(element: &Element, values: &mut V) -> Result<(), Fault> {
    for_each_property(element, values, |values, step, at| skip(step, values, at))
}

pub(super) fn skip<V: Values>(step: &Step, values: &mut V, at: &At<'_>) -> Result<(), Fault> {
    let (scalar, count) = match *step {
        Step::Keep { scalar, .. } | Step::TextureNumber(scalar) | Step::Skip(scalar) => (scalar, 1),
        Step::Indices { count, item } | Step::CornerUvs { count, item } | Step::SkipList { count, item } => {
            (item, list_length(count, item, values, at)?)
        }
    };
    values
        .skip(scalar, count)
        .map_err(|wrong| at.wrong(values, wrong))
}

/// Reads the length of a list and checks that it fits into the rest of the file.
pub(super) fn list_length<V: Values>(
    count: ScalarType,
    item: ScalarType,
    values: &mut V,
    at: &At<'_>,
) -> Result<usize, Fault> {
    let length = values.whole(count).map_err(|wrong| at.wrong(values, wrong))?;
    let possible = (values.bytes_left() + V::SPARE) / V::least_bytes(item);
    match usize::try_from(length) {
        Ok(length) if length <= possible => Ok(length),
        _ => Err(at.bad_length(values, length)),
    }
}

pub(super) fn end_record<V: Values>(at: &At<'_>, values: &mut V) -> Result<(), Fault> {
    if values.end_record() {
        Ok(())
    } else {
        Err(values.leftover(at.start, &at.record()))
    }
}

/// Reserves memory, or fails.
pub(super) fn reserve<T>(
    column: &mut Vec<T>,
    count: usize,
    element: &Element,
    budget: &Budget,
) -> Result<(), Fault> {
    budget.reserve(column, count).map_err(|error| match error {
        BudgetError::OverLimit { .. } => error.into(),
        BudgetError::NoMemory => Fault {
            place: Place::File,
            message: format!(
                "{} {} records do not fit into memory",
                element.count,
                quote(element.name.as_bytes())
            ),
            kind: LoadErrorKind::Limit,
        },
    })
}

/// An array of zeros, or an error if memory runs out.
pub(super) fn zeroed<T: Clone + Default>(
    count: usize,
    element: &Element,
    budget: &Budget,
) -> Result<Vec<T>, Fault> {
    // Try first: `vec!` would abort the program. It takes zeroed pages from the system without touching them.
    reserve(&mut Vec::<T>::new(), count, element, budget)?;
    Ok(vec![T::default(); count])
}

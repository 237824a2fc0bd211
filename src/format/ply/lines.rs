//! The fast path for text with one record per line, as most programs write it: blocks of lines are read in parallel. Other
//! layouts and faults are left to the slow path (`rows.rs`).

use super::{
    ascii::Text,
    columns::{Attributes, VertexColumns},
    faces::{Faces, upper_left},
    fault::Fault,
    header::{Element, Step, color_scale},
    rows::{reserve, zeroed},
    slots::{COLOR_SLOT, NORMAL_SLOT, SLOTS, UV_SLOT, VALUE_SLOT},
};
use crate::{
    format::{budget::Budget, mesh::channels, offset::Offset},
    scene::{TriangleMesh, is_usable},
};
use glam::Vec3;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// About how many bytes of text a task reads.
const BLOCK: usize = 1 << 17;

/// Reads all vertices. `false`, with `mesh` unchanged, if the slow path has to.
pub(super) fn vertices(
    text: &mut Text<'_>,
    element: &Element,
    mesh: &mut TriangleMesh,
    faces: &mut Faces<'_>,
) -> Result<bool, Fault> {
    let (count, offset) = (element.count, faces.budget.offset());
    let alpha = element.alpha();
    let slot = |(i, step): (usize, &Step)| match *step {
        Step::Keep { slot, .. } => slot,
        _ if alpha == Some(i) => ALPHA,
        _ => SKIPPED,
    };
    let slots: Vec<usize> = element.steps.iter().enumerate().map(slot).collect();
    let opaque = alpha.and_then(|alpha| match element.steps.get(alpha) {
        Some(&Step::Skip(scalar)) => Some(color_scale(scalar)),
        _ => None,
    });
    let is_translucent = AtomicBool::new(false);
    let is_valued = slots.contains(&VALUE_SLOT);
    let scales = color_scales(element);
    let (Some(blocks), Some(_)) = (first_lines(text.rest(), count), element.stride()) else {
        return Ok(false);
    };
    let has = Attributes {
        normals: slots.contains(&3),
        colors: slots.contains(&COLOR_SLOT) || is_valued,
        uvs: slots.contains(&UV_SLOT),
    };
    let mut columns = VertexColumns::zeroed(element, has, faces.budget)?;
    let pieces = columns.pieces(blocks.iter().map(|block| block.lines));
    let parts: Vec<_> = blocks.iter().map(|block| block.text).zip(pieces).collect();
    let read = parts.into_par_iter().try_for_each(|(mut rest, piece)| {
        for (i, ((x, y), z)) in piece.x.iter_mut().zip(piece.y).zip(piece.z).enumerate() {
            let mut value = f64::NAN;
            let [px, py, pz, nx, ny, nz, red, green, blue, u, v, _, alpha] =
                vertex(&mut rest, &slots, offset, &mut value)?;
            if opaque.is_some_and(|opaque| alpha != opaque) {
                is_translucent.store(true, Ordering::Relaxed);
            }
            (*x, *y, *z) = (px, py, pz);
            if let Some(normal) = piece.normals.get_mut(i) {
                *normal = Vec3::new(nx, ny, nz);
            }
            if let Some(color) = piece.colors.get_mut(i) {
                let [of_red, of_green, of_blue] = scales;
                *color = if is_valued {
                    channels(value)
                } else {
                    [red / of_red, green / of_green, blue / of_blue]
                };
            }
            if let Some(uv) = piece.uvs.get_mut(i) {
                *uv = upper_left([u, v])?;
            }
        }
        Some(())
    });
    if read.is_none() {
        return Ok(false);
    }
    columns.move_into(mesh);
    faces.translucent.vertex |= is_translucent.into_inner();
    text.pass(length(&blocks));
    Ok(true)
}

/// What the channels of colours are divided by.
fn color_scales(element: &Element) -> [f32; 3] {
    let mut scales = [1.0; 3];
    for step in &element.steps {
        if let Step::Keep { slot, scalar } = *step
            && let Some(scale) = slot
                .checked_sub(COLOR_SLOT)
                .and_then(|channel| scales.get_mut(channel))
        {
            *scale = color_scale(scalar);
        }
    }
    scales
}

/// Reads all faces. `false`, with `faces` unchanged, if the slow path has to.
pub(super) fn faces(
    text: &mut Text<'_>,
    element: &Element,
    vertices: usize,
    faces: &mut Faces<'_>,
) -> Result<bool, Fault> {
    let lists = element.steps.iter().filter(|step| step.size().is_none()).count();
    let indices = element
        .steps
        .iter()
        .position(|step| matches!(step, Step::Indices { .. }));
    let (1, Some(before)) = (lists, indices) else {
        return Ok(false);
    };
    let Some(blocks) = first_lines(text.rest(), element.count) else {
        return Ok(false);
    };
    let layout = FaceLine {
        before,
        after: element.steps.len() - before - 1,
        vertices,
    };
    let budget = faces.budget;
    let before = budget.taken();
    let part = if let Some(triangles) = triangles(&blocks, &layout, element, budget)? {
        Some(Faces {
            triangles,
            ..Faces::new(budget)
        })
    } else {
        budget.give_back_to(before);
        polygons(&blocks, &layout, element, budget)?
    };
    let Some(part) = part else { return Ok(false) };
    faces.append(part)?;
    text.pass(length(&blocks));
    Ok(true)
}

/// The layout of a face's line.
struct FaceLine {
    /// How many numbers precede the list of indices.
    before: usize,
    /// How many follow it.
    after: usize,
    /// How many vertices there are.
    vertices: usize,
}

/// Reads triangles directly into the array; `None` if a face is not a triangle.
fn triangles(
    blocks: &[Block<'_>],
    layout: &FaceLine,
    element: &Element,
    budget: &Budget,
) -> Result<Option<Vec<[u32; 3]>>, Fault> {
    let mut triangles = zeroed(element.count, element, budget)?;
    let mut left = triangles.as_mut_slice();
    let parts: Vec<_> = blocks
        .iter()
        .map(|block| {
            let triangles = ..block.lines.min(left.len());
            (block.text, left.split_off_mut(triangles).unwrap_or_default())
        })
        .collect();
    let read = parts
        .into_par_iter()
        .try_for_each(|(mut rest, triangles): (_, &mut [[u32; 3]])| {
            for triangle in triangles.iter_mut() {
                pass_numbers(&mut rest, layout.before)?;
                if whole(&mut rest)? != 3 {
                    return None;
                }
                for index in triangle.iter_mut() {
                    *index = whole(&mut rest)?;
                }
                let [a, b, c] = *triangle;
                if a.max(b).max(c) as usize >= layout.vertices {
                    return None;
                }
                pass_numbers(&mut rest, layout.after)?;
                end_line(&mut rest)?;
            }
            Some(())
        });
    Ok(read.map(|()| triangles))
}

/// Reads faces of any number of corners; `None` if the slow path has to.
fn polygons<'a>(
    blocks: &[Block<'_>],
    layout: &FaceLine,
    element: &Element,
    budget: &'a Budget,
) -> Result<Option<Faces<'a>>, Fault> {
    let parts: Option<Vec<Faces<'_>>> = blocks
        .par_iter()
        .map(|block| {
            let mut faces = Faces::new(budget);
            let mut rest = block.text;
            while !rest.is_empty() {
                face(&mut rest, layout, &mut faces)?;
            }
            Some(faces)
        })
        .collect();
    let Some(parts) = parts else { return Ok(None) };
    let mut faces = Faces::new(budget);
    let count = parts.iter().map(|part| part.triangles.len()).sum();
    reserve(&mut faces.triangles, count, element, budget)?;
    for part in parts {
        let bytes = size_of_val(&part.triangles[..]);
        faces.append(part)?;
        budget.give_back(bytes);
    }
    Ok(Some(faces))
}

/// The slot of numbers that are not kept.
const SKIPPED: usize = SLOTS;
/// That of alpha.
const ALPHA: usize = SLOTS + 1;

/// Reads a line that holds one vertex and nothing else; returns its numbers by slot. That of [`VALUE_SLOT`] goes to `shown`.
#[inline]
fn vertex(rest: &mut &[u8], slots: &[usize], offset: Offset, shown: &mut f64) -> Option<[f32; ALPHA + 1]> {
    let mut kept = [0.0; ALPHA + 1];
    for &slot in slots {
        let value = if slot < NORMAL_SLOT && !offset.is_none() {
            offset.relative(slot, number(rest)?)
        } else if slot == VALUE_SLOT {
            *shown = number(rest)?;
            continue;
        } else {
            number(rest)?
        };
        if slot < COLOR_SLOT && !is_usable(value) || slot < SLOTS && !value.is_finite() {
            return None;
        }
        *kept.get_mut(slot)? = value;
    }
    end_line(rest)?;
    Some(kept)
}

/// Reads a line that holds one face and nothing else.
fn face(rest: &mut &[u8], layout: &FaceLine, faces: &mut Faces<'_>) -> Option<()> {
    pass_numbers(rest, layout.before)?;
    let corners = whole(rest)?;
    // Each corner needs at least two bytes; otherwise the slow path rejects the count.
    if corners as usize > rest.len() / 2 {
        return None;
    }
    faces.add_fan(corners as usize).ok()?;
    let (mut first, mut previous) = (0, 0);
    for corner in 0..corners {
        let index = whole(rest).filter(|&index| (index as usize) < layout.vertices)?;
        match corner {
            0 => first = index,
            1 => {}
            _ => faces.triangles.push([first, previous, index]),
        }
        previous = index;
    }
    pass_numbers(rest, layout.after)?;
    end_line(rest)
}

/// Whole lines and their number.
struct Block<'a> {
    text: &'a [u8],
    lines: usize,
}

/// The first `count` lines in blocks of about [`BLOCK`] bytes; `None` if there are fewer.
fn first_lines(text: &[u8], count: usize) -> Option<Vec<Block<'_>>> {
    let is_newline = |byte: &&u8| **byte == b'\n';
    let counted = blocks(text).into_par_iter().map(|text| Block {
        text,
        // The last line needs no newline.
        lines: text.iter().filter(is_newline).count() + usize::from(!text.ends_with(b"\n")),
    });
    let mut counted: Vec<Block<'_>> = counted.collect();
    let mut left = count;
    let last = counted.iter().position(|block| {
        let is_last = left <= block.lines;
        left -= left.min(block.lines);
        is_last
    });
    if count == 0 {
        return Some(Vec::new());
    }
    counted.truncate(last? + 1);
    let before: usize = counted.iter().rev().skip(1).map(|block| block.lines).sum();
    let block = counted.last_mut()?;
    let newlines = block.text.iter().enumerate().filter(|&(_, &byte)| byte == b'\n');
    let lines = count - before;
    let end = newlines.map(|(i, _)| i + 1).nth(lines - 1);
    block.text = block.text.get(..end.unwrap_or(block.text.len()))?;
    block.lines = lines;
    Some(counted)
}

/// Cuts text into blocks of whole lines, of about [`BLOCK`] bytes.
fn blocks(mut lines: &[u8]) -> Vec<&[u8]> {
    let mut blocks = Vec::with_capacity(lines.len() / BLOCK + 1);
    while !lines.is_empty() {
        let tail = lines.get(BLOCK..).unwrap_or_default();
        let newline = tail.iter().position(|&byte| byte == b'\n');
        let (block, rest) = lines.split_at(newline.map_or(lines.len(), |i| BLOCK + i + 1));
        blocks.push(block);
        lines = rest;
    }
    blocks
}

/// The length of all blocks, in bytes.
fn length(blocks: &[Block<'_>]) -> usize {
    blocks.iter().map(|block| block.text.len()).sum()
}

fn pass_numbers(rest: &mut &[u8], count: usize) -> Option<()> {
    (0..count).try_for_each(|_| number::<f32>(rest).map(|_| ()))
}

fn pass_blanks(line: &mut &[u8]) {
    while let [b' ' | b'\t', rest @ ..] = line {
        *line = rest;
    }
}

/// Whether a word ends here.
fn is_word_end(rest: &[u8]) -> bool {
    matches!(rest.first(), None | Some(b' ' | b'\t' | b'\r' | b'\n'))
}

fn number<T: fast_float2::FastFloat>(line: &mut &[u8]) -> Option<T> {
    pass_blanks(line);
    let (value, length) = fast_float2::parse_partial(*line).ok()?;
    *line = line.get(length..)?;
    is_word_end(line).then_some(value)
}

fn whole(line: &mut &[u8]) -> Option<u32> {
    pass_blanks(line);
    let before = line.len();
    let mut value = 0_u64;
    while let [digit @ b'0'..=b'9', rest @ ..] = line {
        // Overflow is harmless: too many digits are refused below.
        value = value.wrapping_mul(10).wrapping_add(u64::from(digit - b'0'));
        *line = rest;
    }
    let digits = before - line.len();
    ((1..=10).contains(&digits) && is_word_end(line))
        .then_some(value)?
        .try_into()
        .ok()
}

/// Moves to the next line if nothing is left in this one.
fn end_line(rest: &mut &[u8]) -> Option<()> {
    pass_blanks(rest);
    *rest = match *rest {
        [] => &[],
        [b'\n', next @ ..] | [b'\r', b'\n', next @ ..] => next,
        _ => return None,
    };
    Some(())
}

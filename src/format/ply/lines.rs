//! Text as most programs write it, a record a line: blocks of lines in parallel. Whatever else a text may be, and
//! whatever is wrong with it, is left to the slow way.

use super::{
    ascii::Text,
    header::{Element, Step},
    rows::{Fault, reserve},
};
use crate::scene::{MeshColumns, is_usable};
use glam::Vec3;
use rayon::prelude::*;

/// About how many bytes of text one task reads.
const BLOCK: usize = 1 << 17;

/// Reads all vertices; `false`, with the mesh as it was, where the slow way has to.
pub(super) fn vertices(
    text: &mut Text<'_>,
    element: &Element,
    mesh: &mut MeshColumns,
) -> Result<bool, Fault> {
    let kept = element
        .steps
        .iter()
        .filter(|step| matches!(step, Step::Keep { .. }));
    let width = kept.count();
    let body = text.rest();
    let lines = first_lines(body, element.count);
    let (Some(lines), Some(_)) = (lines, element.stride()) else {
        return Ok(false);
    };
    let blocks: Option<Vec<Vec<f32>>> = blocks(lines)
        .into_par_iter()
        .map(|block| {
            // A number and what ends it take two bytes.
            let mut values = Vec::new();
            values.try_reserve(block.len() / 2 + 1).ok()?;
            let mut rest = block;
            while !rest.is_empty() {
                vertex(&mut rest, element, width, &mut values)?;
            }
            values.shrink_to_fit();
            Some(values)
        })
        .collect();
    let Some(blocks) = blocks else { return Ok(false) };
    for column in [&mut mesh.x, &mut mesh.y, &mut mesh.z] {
        reserve(column, element.count, element)?;
    }
    let has_normals = width == 6;
    if has_normals {
        reserve(&mut mesh.normals, element.count, element)?;
    }
    for values in blocks {
        for vertex in values.chunks_exact(width) {
            if let [x, y, z, normal @ ..] = vertex {
                mesh.x.push(*x);
                mesh.y.push(*y);
                mesh.z.push(*z);
                if has_normals {
                    mesh.normals.push(Vec3::from_slice(normal));
                }
            }
        }
    }
    text.pass(lines.len());
    Ok(true)
}

/// Reads all faces; `false`, with the mesh as it was, where the slow way has to.
pub(super) fn faces(
    text: &mut Text<'_>,
    element: &Element,
    vertices: usize,
    mesh: &mut MeshColumns,
) -> Result<bool, Fault> {
    let lists = element.steps.iter().filter(|step| step.size().is_none()).count();
    let indices = element
        .steps
        .iter()
        .position(|step| matches!(step, Step::Indices { .. }));
    let (1, Some(before), Some(lines)) = (lists, indices, first_lines(text.rest(), element.count)) else {
        return Ok(false);
    };
    let after = element.steps.len() - before - 1;
    let blocks: Option<Vec<Vec<[u32; 3]>>> = blocks(lines)
        .into_par_iter()
        .map(|block| {
            let mut triangles = Vec::new();
            let mut rest = block;
            while !rest.is_empty() {
                face(&mut rest, before, after, vertices, &mut triangles)?;
            }
            Some(triangles)
        })
        .collect();
    let Some(blocks) = blocks else { return Ok(false) };
    reserve(&mut mesh.triangles, blocks.iter().map(Vec::len).sum(), element)?;
    for mut triangles in blocks {
        mesh.triangles.append(&mut triangles);
    }
    text.pass(lines.len());
    Ok(true)
}

/// The next line, which must hold one vertex and nothing else.
fn vertex(rest: &mut &[u8], element: &Element, width: usize, values: &mut Vec<f32>) -> Option<()> {
    let mut kept = [0.0; 6];
    for step in &element.steps {
        let value = real(rest)?;
        if let Step::Keep { slot, .. } = *step {
            if !is_usable(value) {
                return None;
            }
            *kept.get_mut(slot)? = value;
        }
    }
    values.extend_from_slice(kept.get(..width)?);
    end_line(rest)
}

/// The next line, which must hold one face and nothing else.
fn face(
    rest: &mut &[u8],
    before: usize,
    after: usize,
    vertices: usize,
    triangles: &mut Vec<[u32; 3]>,
) -> Option<()> {
    for _ in 0..before {
        real(rest)?;
    }
    let (mut first, mut previous) = (0, 0);
    for corner in 0..whole(rest)? {
        let index = whole(rest).filter(|&index| (index as usize) < vertices)?;
        match corner {
            0 => first = index,
            1 => {}
            _ => triangles.push([first, previous, index]),
        }
        previous = index;
    }
    for _ in 0..after {
        real(rest)?;
    }
    end_line(rest)
}

/// The first `count` lines; `None` if there are fewer.
fn first_lines(text: &[u8], count: usize) -> Option<&[u8]> {
    let pieces: Vec<&[u8]> = text.chunks(BLOCK).collect();
    let newlines = |piece: &[u8]| piece.iter().filter(|&&byte| byte == b'\n').count();
    let counts: Vec<usize> = pieces.par_iter().map(|piece| newlines(piece)).collect();
    let (mut left, mut at) = (count, 0);
    for (piece, newlines) in pieces.iter().zip(counts) {
        if newlines >= left {
            let ends = piece.iter().enumerate().filter(|&(_, &byte)| byte == b'\n');
            let end = match left.checked_sub(1) {
                Some(before) => ends.map(|(i, _)| i + 1).nth(before)?,
                None => 0,
            };
            return text.get(..at + end);
        }
        left -= newlines;
        at += piece.len();
    }
    // The last line needs no newline.
    (left == 1 && !text.ends_with(b"\n")).then_some(text)
}

/// Whole lines, about [`BLOCK`] bytes of them together.
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

fn pass_blanks(line: &mut &[u8]) {
    while let [b' ' | b'\t', rest @ ..] = line {
        *line = rest;
    }
}

/// Whether a word ends before this.
fn is_word_end(rest: &[u8]) -> bool {
    matches!(rest.first(), None | Some(b' ' | b'\t' | b'\r' | b'\n'))
}

fn real(line: &mut &[u8]) -> Option<f32> {
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
        // Too many digits are refused below, whatever comes of them here.
        value = value.wrapping_mul(10).wrapping_add(u64::from(digit - b'0'));
        *line = rest;
    }
    let digits = before - line.len();
    ((1..=10).contains(&digits) && is_word_end(line))
        .then_some(value)?
        .try_into()
        .ok()
}

/// Goes to the next line, if there is nothing more in this one.
fn end_line(rest: &mut &[u8]) -> Option<()> {
    pass_blanks(rest);
    *rest = match *rest {
        [] => &[],
        [b'\n', next @ ..] | [b'\r', b'\n', next @ ..] => next,
        _ => return None,
    };
    Some(())
}

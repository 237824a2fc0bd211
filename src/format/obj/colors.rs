//! Colours of vertices: three numbers after the coordinates, which many programs write.

use super::super::{
    budget::{Budget, BudgetError},
    mesh::{Surface, clamp_colors, clamped_note},
    place::{TextFault, Words},
};
use crate::error::{SceneError, clip_path};
use rayon::prelude::*;
use std::path::Path;

/// A vertex without a colour, which is white; no colour of a file is NaN.
const NONE: [f32; 3] = [f32::NAN; 3];

/// The largest channel of colours that are bytes.
const BYTE: f32 = 255.0;

/// The colours so far.
#[derive(Default)]
pub(super) struct Colors {
    /// Empty until a vertex has one; [`NONE`] for vertices without.
    channels: Vec<[f32; 3]>,
}

impl Colors {
    /// Reads the rest of a vertex's line; `index` is the vertex's. One more number is a weight, and words are a comment.
    pub(super) fn read(
        &mut self,
        words: &mut Words<'_>,
        index: usize,
        budget: &Budget,
    ) -> Result<(), TextFault> {
        let (mut color, mut fault) = ([0.0; 3], None);
        for (channel, what) in color.iter_mut().zip(["red", "green", "blue"]) {
            let Some((word, place)) = words.next() else {
                return Ok(());
            };
            let Ok(value) = fast_float2::parse::<f32, _>(word) else {
                return Ok(());
            };
            if !value.is_finite() {
                fault.get_or_insert((SceneError::NotUsable { what, value }, place));
            }
            *channel = value;
        }
        // Only three numbers are a colour.
        if let Some((error, place)) = fault {
            return Err(TextFault::new(place, error.to_string()));
        }
        self.resize(index, budget)?;
        budget.reserve(&mut self.channels, 1)?;
        self.channels.push(color);
        Ok(())
    }

    fn resize(&mut self, vertices: usize, budget: &Budget) -> Result<(), BudgetError> {
        let missing = vertices.saturating_sub(self.channels.len());
        budget.reserve(&mut self.channels, missing)?;
        self.channels.resize(vertices, NONE);
        Ok(())
    }

    /// One colour from 0 to 1 for each of the vertices, or none; and a note if the file at `path` has others.
    pub(super) fn finish(
        mut self,
        vertices: usize,
        path: &Path,
        budget: &Budget,
    ) -> Result<(Vec<[f32; 3]>, Option<String>), BudgetError> {
        if self.channels.is_empty() {
            return Ok((self.channels, None));
        }
        self.resize(vertices, budget)?;
        let mut colors = self.channels;
        let are_bytes = are_bytes(&colors);
        let scale = if are_bytes { BYTE } else { 1.0 };
        colors
            .par_iter_mut()
            .with_min_len(1 << 14)
            .flatten_iter()
            .for_each(|channel| *channel = if channel.is_nan() { 1.0 } else { *channel / scale });
        let note = if are_bytes {
            let path = clip_path(path);
            Some(format!(
                "{path}: the vertex colours are from 0 to 255: divided by 255"
            ))
        } else {
            clamped_note(clamp_colors(&mut colors), path)
        };
        Ok((colors, note))
    }
}

/// Whether colours are bytes, as some programs write them: whole numbers up to 255, and one above 1.
fn are_bytes(colors: &[[f32; 3]]) -> bool {
    let channels = colors.as_flattened().par_iter().with_min_len(1 << 14);
    let is_byte =
        |channel: &f32| channel.is_nan() || (channel.fract() == 0.0 && (0.0..=BYTE).contains(channel));
    channels.clone().all(is_byte) && channels.into_par_iter().any(|channel| *channel > 1.0)
}

/// Makes the base colour of a material white if all of its triangles have it as vertex colours, too: programs write both for
/// the same purpose, and their product would be dark. `corners` are the vertices of each triangle.
pub(super) fn count_once(
    surfaces: &mut [Surface],
    (surface_of, corners): (&[u32], &[[u32; 3]]),
    colors: &[[f32; 3]],
    budget: &Budget,
) -> Result<(), BudgetError> {
    if surfaces.is_empty() || colors.is_empty() {
        return Ok(());
    }
    let mut is_same = Vec::new();
    budget.reserve(&mut is_same, surfaces.len())?;
    // `None` until a triangle has the material.
    is_same.resize(surfaces.len(), None);
    for (&surface, corners) in surface_of.iter().zip(corners) {
        let (Some(shown), Some(is_same)) =
            (surfaces.get(surface as usize), is_same.get_mut(surface as usize))
        else {
            continue;
        };
        if *is_same != Some(false) {
            let has_color = |vertex: &u32| {
                colors
                    .get(*vertex as usize)
                    .is_some_and(|color| are_close(color, &shown.diffuse))
            };
            *is_same = Some(corners.iter().all(has_color));
        }
    }
    for (surface, is_same) in surfaces.iter_mut().zip(&is_same) {
        if *is_same == Some(true) {
            surface.diffuse = [1.0; 3];
        }
    }
    budget.give_back(is_same.capacity() * size_of::<Option<bool>>());
    Ok(())
}

/// Whether colours are the same but for rounding to bytes.
fn are_close(a: &[f32; 3], b: &[f32; 3]) -> bool {
    // A little more than a step, for the rounding of its ends.
    a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1.0001 / BYTE)
}

//! Colours of vertices: three numbers after the coordinates, which many programs write.

use super::super::{
    budget::{Budget, BudgetError},
    place::{TextFault, Words},
};
use crate::error::SceneError;

const WHITE: [f32; 3] = [1.0; 3];

/// The colours so far.
#[derive(Default)]
pub(super) struct Colors {
    /// Empty until a vertex has one; vertices without are white.
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
        self.channels.resize(vertices, WHITE);
        Ok(())
    }

    /// One colour for each of the vertices, or none.
    pub(super) fn finish(mut self, vertices: usize, budget: &Budget) -> Result<Vec<[f32; 3]>, BudgetError> {
        if !self.channels.is_empty() {
            self.resize(vertices, budget)?;
        }
        Ok(self.channels)
    }
}

//! The outer faces of bodies: those that belong to one body only.

use crate::format::budget::{Budget, BudgetError};
use rayon::prelude::*;

/// The faces of all bodies, numbered in order.
#[derive(Default)]
pub(super) struct Faces {
    all: Vec<Face>,
}

/// A face by its corners, whichever comes first and whichever way round.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Face {
    /// The least corner, its neighbours, the lower one first, and what the others add up to.
    key: [u32; 4],
    number: u32,
}

/// Why there are no outer faces.
pub(super) enum Excess {
    TooMany,
    Memory(BudgetError),
}

impl Faces {
    /// Adds the next face. It has at least three corners.
    pub(super) fn add(&mut self, corners: &[u32], budget: &Budget) -> Result<(), Excess> {
        let number = u32::try_from(self.all.len()).map_err(|_| Excess::TooMany)?;
        budget.reserve(&mut self.all, 1).map_err(Excess::Memory)?;
        let key = key(corners);
        self.all.push(Face { key, number });
        Ok(())
    }

    /// The numbers of those that no other equals, ascending.
    pub(super) fn outer(mut self, budget: &Budget) -> Result<Vec<u32>, BudgetError> {
        self.all.par_sort_unstable();
        let mut outer = Vec::new();
        for same in self.all.chunk_by(|a, b| a.key == b.key) {
            if let [face] = same {
                budget.reserve(&mut outer, 1)?;
                outer.push(face.number);
            }
        }
        budget.give_back(self.all.capacity() * size_of::<Face>());
        drop(self);
        outer.par_sort_unstable();
        Ok(outer)
    }
}

fn key(corners: &[u32]) -> [u32; 4] {
    let least = corners.iter().enumerate().min_by_key(|(_, corner)| **corner);
    let (at, least) = least.map_or((0, u32::MAX), |(at, &least)| (at, least));
    let count = corners.len();
    let neighbour = |by: usize| corners.get((at + by) % count.max(1)).copied().unwrap_or(u32::MAX);
    let [a, b] = [neighbour(1), neighbour(count.max(1) - 1)];
    let sum = corners
        .iter()
        .fold(0, |sum: u32, &corner| sum.wrapping_add(corner));
    [least, a.min(b), a.max(b), sum]
}

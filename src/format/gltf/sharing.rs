//! Decides which meshes that several nodes place are stored once.
//!
//! Those that save most memory come first, until baking all others costs less than [`MOST_WASTED`]. So a small file is baked
//! whole, and a large one shares the few meshes that matter.

use crate::{format::mesh::Sharing, scene::MAX_PROTOTYPES};

/// This many triangles may be baked instead of shared: about 100 MB with their share of the BVH.
// Tuned: see docs/lab-notes.md#shared-gltf
const MOST_WASTED: u128 = 1 << 20;

/// An instance costs as much as this many triangles, which are faster to trace in place.
// Tuned: see docs/lab-notes.md#shared-gltf
const INSTANCE_TRIANGLES: u128 = 16;

/// Which meshes to share, of given numbers of triangles and placements.
pub(super) fn shared(meshes: impl Iterator<Item = [usize; 2]>, sharing: Sharing) -> Vec<bool> {
    let (each, most) = match sharing {
        Sharing::Never => (0, u128::MAX),
        Sharing::WherePays => (INSTANCE_TRIANGLES, MOST_WASTED),
        Sharing::Always => (0, 0),
    };
    // Counts of a hostile file may be of any size.
    let saving = |counts: [usize; 2]| {
        let [triangles, placements] = counts.map(|count| count as u128);
        (placements * triangles).saturating_sub(placements * each + triangles)
    };
    let savings: Vec<u128> = meshes.map(saving).collect();
    let mut order: Vec<usize> = (0..savings.len()).filter(|&i| savings[i] > 0).collect();
    // Of equal ones the first; the sort is stable.
    order.sort_by_key(|&i| std::cmp::Reverse(savings[i]));
    let mut wasted = savings.iter().copied().fold(0, u128::saturating_add);
    let mut shared = vec![false; savings.len()];
    for i in order.into_iter().take(MAX_PROTOTYPES) {
        if wasted <= most {
            break;
        }
        shared[i] = true;
        wasted = wasted.saturating_sub(savings[i]);
    }
    shared
}

#[cfg(test)]
mod tests;

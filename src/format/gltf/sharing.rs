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
mod tests {
    use super::*;

    #[test]
    fn those_that_save_most_are_shared() {
        let of = |meshes: &[[usize; 2]], sharing| shared(meshes.iter().copied(), sharing);
        // Four wheels, a forest, boxes, and what stands once.
        let all = [[20_000, 4], [20_000, 2000], [12, 1_000_000], [5_000_000, 1]];
        assert_eq!(of(&all, Sharing::Never), [false; 4]);
        assert_eq!(of(&all, Sharing::WherePays), [false, true, false, false]);
        assert_eq!(of(&all, Sharing::Always), [true, true, true, false]);
        // Many that save little are shared until little is left.
        let many = vec![[10_000, 11]; 30];
        let count = of(&many, Sharing::WherePays).iter().filter(|&&is| is).count();
        assert_eq!(count, 20);
        assert_eq!(of(&[[usize::MAX, 7]; 2], Sharing::WherePays), [true; 2]);
    }
}

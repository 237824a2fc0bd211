//! Chooses between packets of 32 and 16 rays by how many packets visit each leaf.

use super::Visits;

/// Below a tenth of this many packets per leaf, packets of 32 rays do not pay (AVX-512): many triangles are then hit
/// by so few rays that sixteen lanes hold them as well. Occlusion always takes 32.
// Tuned: see docs/lab-notes.md#packets-per-leaf
const PACKETS_A_LEAF_X10: usize = 43;

/// The choice averages over this many groups, so that the width does not change all the time.
// Tuned: see docs/lab-notes.md#packets-per-leaf
const GROUPS: usize = 8;

/// Statistics of closest-hit bundles over the last [`GROUPS`] groups.
#[derive(Debug, Default)]
pub(super) struct Density {
    /// Leaves are small: too few packets visit each for packets of 32 rays.
    pub is_high: bool,
    /// Triangle leaves that bundles of this group visited. (Spheres are culled by a packet's frustum first, and
    /// packets of 32 pay there.)
    pub visits: Visits,
    /// Those of earlier groups, decayed.
    before: Visits,
}

impl Density {
    /// Ends a group of bundles. A group that visited no triangle leaf changes nothing.
    pub fn end_group(&mut self) {
        let Visits { leaves, packets } = std::mem::take(&mut self.visits);
        if leaves > 0 {
            self.before.leaves -= self.before.leaves / GROUPS;
            self.before.packets -= self.before.packets / GROUPS;
            self.before.add(leaves, packets);
            self.is_high = self.before.packets * 10 < self.before.leaves * PACKETS_A_LEAF_X10;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn group(density: &mut Density, leaves: usize, packets: usize) -> bool {
        density.visits.add(leaves, packets);
        density.end_group();
        density.is_high
    }

    #[test]
    fn one_group_does_not_turn_what_many_have_shown() {
        let mut density = Density::default();
        for _ in 0..100 {
            assert!(!group(&mut density, 100, 600));
            assert!(!group(&mut density, 0, 0));
        }
        assert!(!group(&mut density, 200, 200));
        for _ in 0..100 {
            group(&mut density, 100, 250);
        }
        assert!(density.is_high);
        assert!(group(&mut density, 0, 0), "no leaves, nothing learnt");
        assert!(group(&mut density, 100, 600));
        for _ in 0..100 {
            group(&mut density, 100, 600);
        }
        assert!(!density.is_high);
    }
}

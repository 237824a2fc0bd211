//! How many packets of rays that share their origin come by a leaf.

use super::Visits;

/// With fewer packets a leaf than a tenth of this, packets of 32 rays do not pay (AVX-512): many of their triangles are hit
/// by so few rays that sixteen lanes have them as well. (Zen 5, camera rays, packets of 32 against sixteen, and
/// how many of either come by a leaf: terrain -12 %, 2.2 and 2.4; a million blobs -11 %, 2.1 and 2.4; two million, one
/// million and 200,000 triangles anywhere 0, +2 and +14 %, 2.9 and 3.4, 3.4 and 4.0, 5.6 and 6.6; a hundred thousand
/// blobs -1 %, 4.0 and 4.9; figure +1 %, 4.1 and 5.5; interior +1 %, 4.9 and 6.7; cow +16 %, 8.6 and 10.4; pipes of
/// thin triangles +13 %, 9.1 and 9.4. With 2.7 in place of 4.3 the interior loses 4 to 6 %, for parts of it are like the
/// terrain. Leaves for a ray do not tell these apart: pipes have the most. Where the limit lies between both widths' figures
/// they take turns, which cost nothing measurable in the figure and the blobs. Occlusion: cow +21 %, figure +8 %, interior
/// +10 %, terrain +1 %, a million and ten million blobs 0 %, so packets of 32 are always taken there.)
const PACKETS_A_LEAF_X10: usize = 43;

/// So many groups weigh on the choice at a time. (With the last one alone: camera rays -2 to +1 %, which is noise. But
/// where widths change all the time, and with them the memory that packets are in, those of the cow lose 18 %.)
const GROUPS: usize = 8;

/// Of rays whose closest hit is asked for and that go in bundles: about the last [`GROUPS`] groups of them.
#[derive(Debug, Default)]
pub(super) struct Density {
    /// Leaves are small for the packets there are: too few come by each for packets of 32 rays.
    pub is_high: bool,
    /// Leaves of triangles that bundles of this group have come by. (Spheres are held against a packet's frustum before
    /// its rays, and packets of 32 pay there where they would not with triangles.)
    pub visits: Visits,
    /// Those of groups before, less of those that were longer ago.
    before: Visits,
}

impl Density {
    /// The bundles so far were a group. (What came by no leaf of triangles says nothing, be it spheres.)
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

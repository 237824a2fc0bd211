//! How many leaves rays come by that share their origin.

/// With more leaves than one for so many rays, packets of 32 rays do not pay (AVX-512): many of their triangles are hit by
/// so few rays that sixteen lanes have them as well. (Zen 5, closest hits, packets of 32 against sixteen, and how many
/// rays there are for a leaf with packets of sixteen: cow +15 %, 75; figure +5 %, 40; interior -4 to +2 %, 20; terrain
/// -14 %, 5; blobs of ten thousand, a hundred thousand and a million triangles +12, -2 and -11 %, 46, 19 and 5. Occlusion:
/// cow +21 %, figure +8 %, interior +10 %, terrain +1 %, a million and ten million blobs 0 %, so never there.)
const RAYS_A_LEAF: usize = 22;

/// So many groups weigh on the choice at a time. (With the last one alone: camera rays -2 to +1 %, which is noise. But
/// where widths change all the time, and with them the memory that packets are in, those of the cow lose 18 %.)
const GROUPS: usize = 8;

/// Of rays whose closest hit is asked for and that go in bundles: about the last [`GROUPS`] groups of them.
#[derive(Debug, Default)]
pub(super) struct Density {
    /// There are too many leaves for packets of 32 rays.
    pub is_high: bool,
    /// Leaves of triangles that bundles of this group have come by. (Spheres are held against a packet's frustum before
    /// its rays, and packets of 32 pay there with one leaf for eight rays.)
    pub leaves: usize,
    /// The rays of these bundles.
    pub rays: usize,
    /// Leaves and rays of groups before, less of those that were longer ago.
    before: [usize; 2],
}

impl Density {
    /// The bundles so far were a group. (What has no rays says nothing.)
    pub fn end_group(&mut self) {
        if self.rays > 0 {
            let [leaves, rays] = self.before.map(|before| before - before / GROUPS);
            self.before = [leaves + self.leaves, rays + self.rays];
            let [leaves, rays] = self.before;
            self.is_high = leaves * RAYS_A_LEAF > rays;
        }
        (self.leaves, self.rays) = (0, 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn group(density: &mut Density, leaves: usize, rays: usize) -> bool {
        density.leaves += leaves;
        density.rays += rays;
        density.end_group();
        density.is_high
    }

    #[test]
    fn one_group_does_not_turn_what_many_have_shown() {
        let mut density = Density::default();
        for _ in 0..100 {
            assert!(!group(&mut density, 10, 1024));
            assert!(!group(&mut density, 0, 0));
        }
        assert!(!group(&mut density, 200, 1024));
        for _ in 0..100 {
            group(&mut density, 200, 1024);
        }
        assert!(density.is_high);
        assert!(group(&mut density, 0, 0), "no rays, nothing learnt");
        assert!(group(&mut density, 10, 1024));
        for _ in 0..100 {
            group(&mut density, 10, 1024);
        }
        assert!(!density.is_high);
    }
}

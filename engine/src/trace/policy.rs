//! The coherence policy: decides how the next rays are grouped, by how coherent the last ones were.
//!
//! ```text
//! kind of rays, cost of the last groups -> group size; unsorted or sorted; bundles or single rays
//! ```
//! Every heuristic about grouping is here, except the rule of [two rays](super::entering), which is part of a loop. They
//! change only the time, never the hits.

/// Selects a traversal method; all give the same hits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// Bundles or single rays, whichever suits the rays.
    #[default]
    Adaptive,
    /// One packet at a time, never bundles or single rays.
    Packet,
    /// One ray against eight boxes, eight primitives at a time.
    Single,
}

/// What rays have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RayKind {
    /// One origin, closest hits: camera rays.
    Camera,
    /// One origin, any hit: shadow rays, from the light.
    Shadow,
    /// Separate origins: mirror rays and the like.
    Separate,
}

impl RayKind {
    #[inline(always)]
    pub const fn of(is_shared: bool, is_any: bool) -> Self {
        match (is_shared, is_any) {
            (true, false) => Self::Camera,
            (true, true) => Self::Shadow,
            (false, _) => Self::Separate,
        }
    }
}

/// [`RayPacket`](crate::ray::RayPacket)s with a shared origin that share one [`entry`](super::entry): four bundles of
/// 256 rays, or eight of 128. More share the cost of finding it; fewer have a narrower one.
// Tuned: see docs/lab-notes.md#entry-nodes
pub(super) const ENTRY_PACKETS: usize = 128;

/// Groups that skip sorting after a useless sort. Higher wastes less time; lower notices sooner that sorting pays.
// Tuned: see docs/lab-notes.md#varied-constants
const SKIPPED_SORTS: u32 = 8;

/// Sorting rays with separate origins pays if one sampled packet in this many has rays through more than one face of a
/// cube map.
// Tuned: see docs/lab-notes.md#varied-constants
const MIXED_ONE_IN: usize = 4;

/// Sorting rays with a shared origin pays if one sampled packet in this many is [spread](SPREAD).
// Tuned: see docs/lab-notes.md#varied-constants
const SPREAD_ONE_IN: usize = 16;

/// A packet is spread if the area of the bounding square of its targets is this many times its fair share of the group's.
/// (On a smooth surface the factor is at most about 2.)
// Tuned: see docs/lab-notes.md#varied-constants
pub(super) const SPREAD: f32 = 2.5;

/// With more primitives per ray in the way than this, rays go singly through an instance: triangles are smaller than the
/// gaps between rays.
// Tuned: see docs/lab-notes.md#sparse-instances
const SPARSE: usize = 8;

/// A single ray through a subtree costs about as much as this many packets at a leaf.
// Tuned: see docs/lab-notes.md#varied-constants
const ALONE: usize = 8;

/// Sorting may pay above this many tenths of a packet at a leaf per ray.
// Tuned: see docs/lab-notes.md#sorted-shadow-rays
const HIGH_X10: usize = 5;

/// After an incoherent bundle this many are traced as single rays before another bundle is tried; the count doubles up to
/// the maximum each time that one is incoherent again.
// Tuned: see docs/lab-notes.md#varied-constants
const SKIPPED_BUNDLES: std::ops::RangeInclusive<u32> = 3..=48;

/// How rays are grouped.
#[derive(Debug)]
pub(super) struct CoherencePolicy {
    method: Method,
    /// Of each [`RayKind`].
    backoff: [Backoff; 3],
    /// How many groups still skip sorting.
    skipped_sorts: u32,
    /// The cost of the last group of shadow rays, from any light.
    shadow_cost: BundleCost,
    /// Leaves visited by the current bundle.
    leaf_statistics: LeafStatistics,
}

impl CoherencePolicy {
    pub fn new(method: Method) -> Self {
        Self {
            method,
            backoff: <[Backoff; 3]>::default(),
            skipped_sorts: 0,
            shadow_cost: BundleCost::default(),
            leaf_statistics: LeafStatistics::default(),
        }
    }

    /// From now on uses `method` for rays through an instance, or single rays if many primitives are in the way of few rays.
    pub fn suit_instance(&mut self, method: Method, rays: usize, primitives: f32) {
        let are_sparse = (rays * SPARSE) as f32 <= primitives;
        self.method = match method {
            Method::Adaptive if are_sparse => Method::Single,
            method => method,
        };
    }

    /// Returns the selected method.
    pub fn method(&self) -> Method {
        self.method
    }

    /// Returns how many packets, of at most `len`, make a group: those that share an entry or are sorted together.
    pub fn group(&self, kind: RayKind, len: usize) -> usize {
        match kind {
            _ if self.method != Method::Adaptive => len.max(1),
            RayKind::Camera => ENTRY_PACKETS,
            RayKind::Shadow | RayKind::Separate => super::order::PACKETS,
        }
    }

    /// Returns whether a group of camera rays starts at an entry node.
    #[inline(always)]
    pub fn shares_entry(&self, kind: RayKind) -> bool {
        kind == RayKind::Camera && self.method == Method::Adaptive
    }

    /// Returns whether the next group should be sorted, if its rays are mixed.
    #[inline(always)]
    pub fn wants_sorting(&mut self, kind: RayKind) -> bool {
        let pays = match kind {
            RayKind::Camera => false,
            RayKind::Shadow => std::mem::take(&mut self.shadow_cost).is_high(),
            RayKind::Separate => {
                let is_skipped = self.skipped_sorts > 0;
                self.skipped_sorts = self.skipped_sorts.saturating_sub(1);
                !is_skipped
            }
        };
        pays && self.method == Method::Adaptive
    }

    /// Returns whether sorting pays, given how many of the `sampled` packets with separate origins are `mixed`.
    #[inline(always)]
    pub fn sorts_mixed(mixed: usize, sampled: usize) -> bool {
        mixed * MIXED_ONE_IN >= sampled
    }

    /// Returns whether sorting pays, given how many of the `sampled` packets with a shared origin are [spread](SPREAD).
    #[inline(always)]
    pub fn sorts_spread(spread: usize, sampled: usize) -> bool {
        spread * SPREAD_ONE_IN >= sampled
    }

    /// Records that a sorted group was traced: if bundles were still incoherent, sorting was in vain.
    #[inline(always)]
    pub fn traced_sorted(&mut self, kind: RayKind) {
        if kind == RayKind::Separate && self.backoff[kind as usize].is_on() {
            self.skipped_sorts = SKIPPED_SORTS;
        }
    }

    /// Returns whether packets form bundles, whose last few rays continue as single-ray tasks.
    #[inline(always)]
    pub fn is_bundled(&self) -> bool {
        self.method != Method::Packet
    }

    /// Begins a bundle. Returns whether its rays are traced as single rays from the root.
    #[inline(always)]
    pub fn begin_bundle(&mut self, kind: RayKind) -> bool {
        self.leaf_statistics = LeafStatistics::default();
        self.method == Method::Single || self.is_bundled() && self.backoff[kind as usize].is_on()
    }

    /// Counts one or two leaves, visited by `packets`, with a shared origin.
    #[inline(always)]
    pub fn visited(&mut self, leaves: usize, packets: usize) {
        self.leaf_statistics.leaves += leaves;
        self.leaf_statistics.packets += packets;
    }

    /// Returns whether a bundle has less than half of its packets, as at a picture's edge. It says nothing about others.
    #[inline(always)]
    pub fn is_small(packets: usize) -> bool {
        packets < super::PACKETS / 2
    }

    /// Ends a bundle of `rays` with `alone` single-ray tasks, several for some rays. `is_small`: see [`Self::is_small`].
    #[inline(always)]
    pub fn end_bundle(&mut self, kind: RayKind, rays: usize, alone: usize, was_single: bool, is_small: bool) {
        let backoff = &mut self.backoff[kind as usize];
        if was_single {
            backoff.one_less();
        } else if kind == RayKind::Separate {
            backoff.tried(alone > rays);
        } else if !is_small {
            backoff.tried(self.leaf_statistics.are_incoherent(kind, rays));
        }
        if kind == RayKind::Shadow {
            self.shadow_cost.add(rays, self.leaf_statistics.packets, alone);
        }
    }
}

/// Counts the leaves that bundles visited.
#[derive(Clone, Copy, Debug, Default)]
struct LeafStatistics {
    leaves: usize,
    /// Packets that visited them, summed over the leaves.
    packets: usize,
}

impl LeafStatistics {
    /// Whether a bundle of `rays` from one origin was incoherent: more than two leaves per ray, and fewer than two
    /// packets per leaf (one and a half for occlusion). Triangles are then far smaller than the gaps between its rays.
    // Tuned: see docs/lab-notes.md#incoherent-bundles
    fn are_incoherent(self, kind: RayKind, rays: usize) -> bool {
        let least_x2 = if kind == RayKind::Shadow { 3 } else { 4 };
        self.leaves > 2 * rays && 2 * self.packets < least_x2 * self.leaves
    }
}

/// The cost of bundles with a shared origin.
#[derive(Clone, Copy, Debug, Default)]
struct BundleCost {
    rays: usize,
    /// Packets at leaves, summed over the leaves.
    packets: usize,
    /// Single rays, summed over the subtrees they went through.
    alone: usize,
}

impl BundleCost {
    /// Adds a bundle.
    #[inline(always)]
    fn add(&mut self, rays: usize, packets: usize, alone: usize) {
        self.rays += rays;
        self.packets += packets;
        self.alone += alone;
    }

    /// Whether the cost is so high that sorting the next rays may lower it.
    fn is_high(&self) -> bool {
        10 * (self.packets + ALONE * self.alone) > HIGH_X10 * self.rays
    }
}

/// Counts the bundles that are still to be traced as single rays.
#[derive(Debug, Default)]
struct Backoff {
    left: u32,
    /// The previous count; 0 if the last bundle was coherent.
    before: u32,
}

impl Backoff {
    fn is_on(&self) -> bool {
        self.left > 0
    }

    /// Records that a bundle was traced as single rays.
    fn one_less(&mut self) {
        self.left = self.left.saturating_sub(1);
    }

    /// Records that a bundle was tried.
    fn tried(&mut self, was_incoherent: bool) {
        if was_incoherent {
            let (least, most) = (*SKIPPED_BUNDLES.start(), *SKIPPED_BUNDLES.end());
            self.before = (2 * self.before).clamp(least, most);
            self.left = self.before;
        } else {
            self.before = 0;
        }
    }
}

#[cfg(test)]
mod tests;

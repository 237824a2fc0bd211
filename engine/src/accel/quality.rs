//! Build qualities: build time against tracing time.

use super::split::Effort;

/// Selects the hierarchy to build. All find the same hits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BuildQuality {
    /// The one that is built fastest.
    Fast,
    /// The one that is traced fastest.
    #[default]
    Best,
    /// [`Best`](Self::Best), but divided as PLOC (Meister and Bittner 2018, by obvhs, with reinsertion) would down to
    /// sets of eight primitives. For comparison: it takes longer to build, with three times the memory, and is traced no
    /// faster. With tens of millions of primitives the tree may depend on the number of threads, because obvhs then sorts
    /// unstably in parallel.
    Ploc,
}

/// Rays per primitive from which the better build pays for itself; an estimate.
// Tuned: see docs/lab-notes.md#rays-per-primitive
const RAYS_PER_PRIMITIVE: f64 = 4.0;

impl BuildQuality {
    /// Returns the quality with the least total time, build and rays together.
    #[must_use]
    pub fn for_rays(rays: f64, primitives: usize) -> Self {
        if rays < RAYS_PER_PRIMITIVE * primitives as f64 {
            Self::Fast
        } else {
            Self::Best
        }
    }

    /// Returns "fast", "best" or "ploc".
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Fast => "fast",
            Self::Best => "best",
            Self::Ploc => "ploc",
        }
    }

    pub(super) fn effort(self) -> Effort {
        match self {
            Self::Fast => Effort {
                bins: 8,
                all_axes: false,
                divides_blocks: false,
            },
            Self::Best | Self::Ploc => Effort {
                bins: 16,
                all_axes: true,
                divides_blocks: true,
            },
        }
    }
}

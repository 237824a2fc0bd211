//! How much a build may cost.

use super::split::Effort;

/// Which hierarchy is built. All find the same hits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BuildQuality {
    /// The one that is built soonest.
    Fast,
    /// The one that is traced fastest.
    #[default]
    Best,
    /// [`Best`](Self::Best), but divided as PLOC (Meister and Bittner 2018, as obvhs has it, and reinsertion) would down to
    /// sets of eight primitives: to compare with, for it takes longer to build, three times the memory meanwhile, and is
    /// traced no faster. Of tens of millions of primitives the tree may depend on the number of threads, for obvhs then
    /// sorts with all of them and leaves open what comes first of equals.
    Ploc,
}

/// How many rays a primitive must be worth until the better build has paid for itself. An estimate: on a Zen 5 core it
/// takes 7 to 45 ns a primitive longer, and what it saves on a ray is near the noise of the measurement (10 ns assumed).
const RAYS_PER_PRIMITIVE: f64 = 4.0;

impl BuildQuality {
    /// What takes the least time in all, build and rays together.
    #[must_use]
    pub fn for_rays(rays: f64, primitives: usize) -> Self {
        if rays < RAYS_PER_PRIMITIVE * primitives as f64 {
            Self::Fast
        } else {
            Self::Best
        }
    }

    /// "fast", "best" or "ploc".
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

//! How much a build may cost.

use super::split::Effort;

/// Which of two hierarchies is built. Both find the same hits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BuildQuality {
    /// The one that is built soonest.
    Fast,
    /// The one that is traced fastest.
    #[default]
    Best,
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

    /// "fast" or "best".
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Fast => "fast",
            Self::Best => "best",
        }
    }

    pub(super) fn effort(self) -> Effort {
        match self {
            Self::Fast => Effort {
                bins: 8,
                all_axes: false,
                divides_blocks: false,
            },
            Self::Best => Effort {
                bins: 16,
                all_axes: true,
                divides_blocks: true,
            },
        }
    }
}

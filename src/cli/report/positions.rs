//! Positions as text: with the digits that they have, and no noise of `f32`.

use crate::scene::Scene;
use glam::{DVec3, Vec3};

/// How many decimals positions have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Positions {
    offset: DVec3,
    /// `None`: the fewest that distinguish an `f32` from its neighbours.
    decimals: Option<usize>,
}

/// No scene needs more.
const MOST_DECIMALS: f64 = 12.0;

impl Positions {
    /// The decimals of a scene. With an offset, the precision of `f32` at the ends of the bounds decides.
    pub(super) fn of(scene: &Scene) -> Self {
        let (offset, bounds) = (scene.offset(), scene.bounds());
        let far = bounds.upper.abs().max(bounds.lower.abs()).max_element();
        let step = f64::from(far.next_up() - far);
        let decimals = (-libm::log10(step)).floor().clamp(0.0, MOST_DECIMALS);
        Self {
            offset,
            decimals: (offset != DVec3::ZERO).then_some(decimals as usize),
        }
    }

    /// A position that is relative to [`Scene::offset`].
    pub(super) fn within(self, point: Vec3) -> [f64; 3] {
        self.rounded(point.as_dvec3() + self.offset)
    }

    /// A position in world space.
    pub(super) fn rounded(self, point: DVec3) -> [f64; 3] {
        point.to_array().map(|value| {
            let text = match self.decimals {
                Some(decimals) => format!("{value:.decimals$}"),
                None => (value as f32).to_string(),
            };
            text.parse().unwrap_or(value)
        })
    }
}

#[cfg(test)]
mod tests;

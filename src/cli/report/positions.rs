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
mod tests {
    use super::*;
    use crate::scene::{MaterialId, SceneBuilder};

    #[test]
    fn positions_have_the_digits_of_their_file() {
        let scene = |offset: DVec3, radius: f32| {
            let mut builder = SceneBuilder::new();
            builder.set_offset(offset).unwrap();
            builder.add_sphere(Vec3::ZERO, radius, MaterialId(0)).unwrap();
            Positions::of(&builder.finish())
        };
        let near = scene(DVec3::ZERO, 1.0);
        assert_eq!(near.within(Vec3::new(0.1, -2.7, 1e9)), [0.1, -2.7, 1e9]);
        assert_eq!(near.rounded(DVec3::splat(f64::from(0.1_f32))), [0.1; 3]);
        let far = DVec3::new(500_000.0, 4e6, 0.0);
        let map = scene(far, 10.0);
        assert_eq!(
            map.within(Vec3::new(0.001, -0.7, 0.3)),
            [500_000.001, 3_999_999.3, 0.3]
        );
        assert_eq!(
            scene(far, 1e5).within(Vec3::splat(0.123)),
            [500_000.12, 4_000_000.12, 0.12]
        );
        assert_eq!(scene(far, 1e-9).decimals, Some(12));
    }
}

//! `--turntable`: the camera goes once around its target.

use crate::scene::View;
use std::f64::consts::TAU;

/// Numbers of pictures, both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frames {
    /// The first one; 1 is that of the camera's own place.
    pub first: u32,
    /// The last one, not below the first.
    pub last: u32,
}

/// `A-B`, or `A` alone.
pub fn frames(text: &str) -> Result<Frames, String> {
    let number = |digits: &str| {
        let plain = !digits.is_empty() && digits.bytes().all(|digit| digit.is_ascii_digit());
        digits.parse().ok().filter(|&number: &u32| plain && number > 0)
    };
    let (first, last) = text.split_once('-').unwrap_or((text, text));
    match (number(first), number(last)) {
        (Some(first), Some(last)) if first <= last => Ok(Frames { first, last }),
        (Some(first), Some(last)) => Err(format!("expected the lower number first: {last}-{first}")),
        _ => Err("expected two numbers A-B from 1 on, such as 1-24, or one".into()),
    }
}

/// The view of picture `number` of `count`, from 1 on: the first is the view itself, the others follow counterclockwise
/// as seen from above, that is against the up vector.
pub fn turned(view: &View, number: u32, count: u32) -> View {
    let Some(axis) = view.up.try_normalize().filter(|_| number > 1) else {
        return *view;
    };
    let (sin, cos) = libm::sincos(TAU * f64::from(number - 1) / f64::from(count));
    let arm = view.eye - view.target;
    // Rodrigues' formula.
    let turned = arm * cos + axis.cross(arm) * sin + axis * (axis.dot(arm) * (1.0 - cos));
    View {
        eye: view.target + turned,
        ..*view
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use proptest::prelude::*;

    #[test]
    fn ranges() {
        assert_eq!(frames("1-24"), Ok(Frames { first: 1, last: 24 }));
        assert_eq!(frames("007-7"), Ok(Frames { first: 7, last: 7 }));
        assert_eq!(frames("5"), Ok(Frames { first: 5, last: 5 }));
        assert!(frames("9-3").unwrap_err().contains("3-9"));
        for text in [
            "",
            "-",
            "1-",
            "-1",
            "0-3",
            "0",
            "1--2",
            "1-2-3",
            "+1-2",
            "1 - 2",
            "a-b",
            "1..2",
            "1,2",
            "99999999999-3",
            "１-２",
        ] {
            assert!(frames(text).is_err(), "{text}");
        }
    }

    #[test]
    fn a_quarter_turn_goes_counterclockwise() {
        let view = View {
            eye: DVec3::new(3.0, 0.0, 2.0),
            target: DVec3::new(1.0, 0.0, 0.0),
            up: DVec3::new(0.0, 0.0, 4.0),
            fov_degrees: 45.0,
        };
        assert_eq!(turned(&view, 1, 4), view);
        let second = turned(&view, 2, 4);
        assert!(
            (second.eye - DVec3::new(1.0, 2.0, 2.0)).length() < 1e-12,
            "{second:?}"
        );
        assert_eq!((second.target, second.up), (view.target, view.up));
    }

    proptest! {
        #[test]
        fn any_text_is_taken_or_refused(text in "[0-9+ a-]{0,12}") {
            if let Ok(Frames { first, last }) = frames(&text) {
                prop_assert!(0 < first && first <= last);
            }
        }

        #[test]
        fn the_distance_stays(x in -9.0..9.0, y in -9.0..9.0, z in 1.0..9.0, number in 1u32..=24) {
            let eye = DVec3::new(x, y, z);
            let view = View { eye, target: DVec3::ZERO, up: DVec3::new(0.3, -0.2, 1.0), fov_degrees: 45.0 };
            let turned = turned(&view, number, 24).eye;
            prop_assert!((turned.length() - eye.length()).abs() < 1e-9);
            prop_assert!((turned.dot(view.up) - eye.dot(view.up)).abs() < 1e-9);
        }
    }
}

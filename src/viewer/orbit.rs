//! Where the camera is, and how it is moved: around what it looks at, towards it, and in free flight.

use crate::{
    classic,
    math::Aabb,
    scene::{Camera, CameraError},
};
use glam::DVec3;

/// Degrees that the camera turns for each pixel of a drag.
pub const DEGREES_PER_PIXEL: f64 = 0.25;
/// The highest and, negated, the lowest elevation over what the camera looks at, degrees: straight above, "up" would
/// have no meaning.
pub const MAX_ELEVATION_DEGREES: f64 = 89.99;
/// The nearest and the farthest distance from what the camera looks at, in units of [`unit_of`] the scene.
pub const DISTANCES: [f64; 2] = [0.5, 100.0];

/// What is framed is looked at from so many times the distance from which it would touch the picture's edge.
const FRAME_MARGIN: f64 = 1.08;

/// Where a camera stands, what it looks at, which way is up, and how wide it sees: the options of `octray render`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Where the camera stands, scene units.
    pub eye: DVec3,
    /// What it looks at, scene units.
    pub target: DVec3,
    /// Which way is up.
    pub up: DVec3,
    /// Vertical field of view, degrees.
    pub fov_degrees: f64,
}

impl Pose {
    /// The course's viewpoint 1 to 6; `None` for another number.
    #[must_use]
    pub fn classic_view(view: u32) -> Option<Self> {
        Some(Self {
            eye: classic::viewpoint(view)?,
            target: classic::TARGET,
            up: classic::UP,
            fov_degrees: classic::FOV_DEGREES,
        })
    }

    /// The camera for rendering.
    ///
    /// # Errors
    /// [`CameraError`], where this makes no view.
    pub fn camera(&self) -> Result<Camera, CameraError> {
        Camera::look_at(self.eye, self.target, self.up, self.fov_degrees)
    }

    /// As options of `octray render`, exact to the last bit.
    #[must_use]
    pub fn options(&self) -> String {
        let vector = |v: DVec3| format!("{},{},{}", v.x, v.y, v.z);
        format!(
            "--eye={} --target={} --up={} --fov={}",
            vector(self.eye),
            vector(self.target),
            vector(self.up),
            self.fov_degrees
        )
    }

    /// Unit vectors to the right, upwards and forwards.
    #[must_use]
    pub fn frame(&self) -> [DVec3; 3] {
        let forward = (self.target - self.eye).normalize_or(DVec3::X);
        let right = forward.cross(self.up).normalize_or(DVec3::Y);
        [right, right.cross(forward), forward]
    }
}

/// The length that distances and speeds are measured in, scene units: 1 for scenes of about the size of the course's,
/// else a third of the scene's diagonal (that of the course's scenes is about 3).
#[must_use]
pub fn unit_of(bounds: Aabb) -> f64 {
    match diagonal_of(bounds) {
        Some(diagonal) if !(0.3..=30.0).contains(&diagonal) => diagonal / 3.0,
        _ => 1.0,
    }
}

/// How large a box is, scene units; `None` if nothing is in it, or a single point.
fn diagonal_of(bounds: Aabb) -> Option<f64> {
    let extent = bounds.upper.as_dvec3() - bounds.lower.as_dvec3();
    (extent.min_element() >= 0.0 && extent.max_element() > 0.0).then(|| extent.length())
}

/// A pose that is always a valid view, and the ways to change it.
#[derive(Clone, Copy, Debug)]
pub struct Orbit {
    pose: Pose,
    camera: Camera,
    unit: f64,
}

impl Orbit {
    /// Begins at `pose`, exactly; `unit` is [`unit_of`] the scene.
    ///
    /// # Errors
    /// [`CameraError`], where the pose makes no view.
    pub fn new(pose: Pose, unit: f64) -> Result<Self, CameraError> {
        let camera = pose.camera()?;
        Ok(Self { pose, camera, unit })
    }

    /// Where the camera is.
    #[must_use]
    pub fn pose(&self) -> Pose {
        self.pose
    }

    /// The camera for rendering.
    #[must_use]
    pub fn camera(&self) -> Camera {
        self.camera
    }

    /// Measures distances in another unit from now on.
    pub fn set_unit(&mut self, unit: f64) {
        self.unit = unit;
    }

    /// Moves to `pose`, if that is a view.
    pub fn go_to(&mut self, pose: Pose) {
        if let Ok(camera) = pose.camera() {
            self.pose = pose;
            self.camera = camera;
        }
    }

    /// Turns around the target as a drag of `right` and `down` pixels does: what is seen follows the mouse.
    pub fn turn(&mut self, right: f64, down: f64) {
        let Pose { eye, target, up, .. } = self.pose;
        let up = up.normalize_or(DVec3::Z);
        let from_target = eye - target;
        let distance = from_target.length();
        // Azimuth 0 is +x where z points up.
        let across = if up.x.abs() < 0.9 { DVec3::X } else { DVec3::Y };
        let e0 = (across - up * up.dot(across)).normalize_or(DVec3::X);
        let e1 = up.cross(e0);
        let step = DEGREES_PER_PIXEL.to_radians();
        let limit = MAX_ELEVATION_DEGREES.to_radians();
        let azimuth = libm::atan2(from_target.dot(e1), from_target.dot(e0)) - right * step;
        let height = (from_target.dot(up) / distance).clamp(-1.0, 1.0);
        let elevation = (libm::asin(height) + down * step).clamp(-limit, limit);
        let (sin_a, cos_a) = libm::sincos(azimuth);
        let (sin_e, cos_e) = libm::sincos(elevation);
        let direction = (e0 * cos_a + e1 * sin_a) * cos_e + up * sin_e;
        self.go_to(Pose {
            eye: target + direction * distance,
            ..self.pose
        });
    }

    /// Multiplies the distance from the target by `factor`, within [`DISTANCES`].
    pub fn approach(&mut self, factor: f64) {
        let Pose { eye, target, .. } = self.pose;
        let from_target = eye - target;
        let [nearest, farthest] = DISTANCES.map(|distance| distance * self.unit);
        let distance = from_target.length();
        let wanted = (distance * factor).clamp(nearest, farthest);
        self.go_to(Pose {
            eye: target + from_target * (wanted / distance),
            ..self.pose
        });
    }

    /// Flies `right`, `up` and `forward` (1 for a second at full speed), looking the same way.
    pub fn fly(&mut self, right: f64, up: f64, forward: f64) {
        let Pose { eye, target, .. } = self.pose;
        // Slower where the target is near, so that small things can be looked at; never at a standstill.
        let speed = (0.8 * (target - eye).length()).max(0.2 * self.unit);
        let frame = self.pose.frame();
        let way = (frame[0] * right + frame[1] * up + frame[2] * forward) * speed;
        self.go_to(Pose {
            eye: eye + way,
            target: target + way,
            ..self.pose
        });
    }

    /// Looks at the middle of `bounds`, from where all of it is seen in a picture `aspect` times as wide as it is
    /// high. The direction stays.
    pub fn frame(&mut self, bounds: Aabb, aspect: f64) {
        if diagonal_of(bounds).is_none() {
            return;
        }
        let (lower, upper) = (bounds.lower.as_dvec3(), bounds.upper.as_dvec3());
        let target = (lower + upper) / 2.0;
        let half_height = libm::tan(self.pose.fov_degrees.to_radians() / 2.0);
        let [right, up, forward] = self.pose.frame();
        // From here each corner is within the picture: its offsets across and upwards at most half of what is seen at its
        // depth.
        let mut distance = 0.0_f64;
        for corner in 0..8_u32 {
            let signs = [0, 1, 2].map(|axis| if corner >> axis & 1 == 0 { -0.5 } else { 0.5 });
            let v = (upper - lower) * DVec3::from_array(signs);
            let across = v.dot(right).abs() / (half_height * aspect);
            let upwards = v.dot(up).abs() / half_height;
            distance = distance.max(across.max(upwards) - v.dot(forward));
        }
        self.go_to(Pose {
            eye: target - forward * (distance * FRAME_MARGIN),
            target,
            ..self.pose
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn view(number: u32) -> Orbit {
        Orbit::new(Pose::classic_view(number).unwrap(), 1.0).unwrap()
    }

    fn spherical(orbit: &Orbit) -> [f64; 3] {
        let v = orbit.pose().eye - orbit.pose().target;
        let degrees = |radians: f64| radians.to_degrees();
        [
            degrees(v.y.atan2(v.x)),
            degrees((v.z / v.length()).asin()),
            v.length(),
        ]
    }

    fn assert_near(a: [f64; 3], b: [f64; 3]) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9), "{a:?} {b:?}");
    }

    #[test]
    fn it_begins_exactly_where_it_was_put() {
        for number in 1..=6 {
            assert_eq!(Some(view(number).camera()), Camera::classic_view(number));
        }
    }

    #[test]
    fn a_pixel_is_a_quarter_of_a_degree() {
        for number in 1..=5 {
            let mut orbit = view(number);
            let before = spherical(&orbit);
            orbit.turn(8.0, 0.0);
            orbit.turn(0.0, -12.0);
            assert_near(spherical(&orbit), [before[0] - 2.0, before[1] - 3.0, before[2]]);
        }
    }

    #[test]
    fn elevation_is_held() {
        let mut orbit = view(1);
        let before = spherical(&orbit);
        orbit.turn(0.0, 1e5);
        assert_near(spherical(&orbit), [before[0], 89.99, before[2]]);
        orbit.turn(0.0, -1e6);
        assert_near(spherical(&orbit), [before[0], -89.99, before[2]]);
        // And it comes back from there.
        orbit.turn(0.0, 4.0);
        assert_near(spherical(&orbit), [before[0], -88.99, before[2]]);
    }

    #[test]
    fn distance_is_held_and_scaled() {
        for unit in [1.0, 250.0] {
            let mut orbit = view(1);
            orbit.set_unit(unit);
            orbit.approach(1e-9);
            assert!((spherical(&orbit)[2] - 0.5 * unit).abs() < 1e-9 * unit);
            orbit.approach(1e9);
            assert!((spherical(&orbit)[2] - 100.0 * unit).abs() < 1e-6 * unit);
        }
    }

    #[test]
    fn units_suit_the_scene() {
        let cube = |side: f32| {
            unit_of(Aabb {
                lower: Vec3::ZERO,
                upper: Vec3::splat(side),
            })
        };
        assert_eq!(cube(1.0), 1.0);
        assert!((cube(3000.0) - 1732.05).abs() < 0.01);
        assert!((cube(0.003) - 0.001732).abs() < 1e-6);
        assert_eq!(unit_of(Aabb::EMPTY), 1.0);
    }

    #[test]
    fn flight_keeps_the_direction() {
        let mut orbit = view(2);
        let before = orbit.pose();
        orbit.fly(0.0, 0.0, 0.5);
        let after = orbit.pose();
        let way = after.eye - before.eye;
        assert!(way.normalize().dot(before.frame()[2]) > 1.0 - 1e-12);
        assert!((after.target - before.target - way).length() < 1e-12);
        orbit.fly(1.0, 0.0, 0.0);
        assert!((orbit.pose().eye - after.eye).dot(after.frame()[2]).abs() < 1e-12);
    }

    #[test]
    fn framing_sees_all() {
        let bounds = Aabb {
            lower: Vec3::new(10.0, 20.0, 30.0),
            upper: Vec3::new(14.0, 21.0, 31.0),
        };
        for aspect in [1.0, 0.3, 2.0] {
            let mut orbit = view(3);
            let forward = orbit.pose().frame()[2];
            orbit.frame(bounds, aspect);
            let [right, up, now] = orbit.pose().frame();
            assert!(now.dot(forward) > 1.0 - 1e-12);
            let half_height = 22.5_f64.to_radians().tan();
            for corner in 0..8 {
                let pick =
                    |bit: u32, lower: f32, upper: f32| if corner >> bit & 1 == 0 { lower } else { upper };
                let (l, u) = (bounds.lower, bounds.upper);
                let corner = Vec3::new(pick(0, l.x, u.x), pick(1, l.y, u.y), pick(2, l.z, u.z)).as_dvec3();
                let v = corner - orbit.pose().eye;
                let depth = v.dot(now);
                assert!(
                    v.dot(up).abs() <= depth * half_height
                        && v.dot(right).abs() <= depth * half_height * aspect
                );
            }
        }
        // Nothing to frame.
        let mut orbit = view(3);
        orbit.frame(Aabb::EMPTY, 1.0);
        assert_eq!(orbit.pose(), view(3).pose());
    }

    #[test]
    fn options_are_exact() {
        let mut orbit = view(4);
        orbit.turn(13.0, 7.0);
        let pose = orbit.pose();
        let text = pose.options();
        let numbers: Vec<f64> = text
            .split(|c: char| c == ',' || c == '=' || c.is_whitespace())
            .filter_map(|word| word.parse().ok())
            .collect();
        let (eye, target, up) = (pose.eye, pose.target, pose.up);
        let expected = [
            eye.x,
            eye.y,
            eye.z,
            target.x,
            target.y,
            target.z,
            up.x,
            up.y,
            up.z,
            pose.fov_degrees,
        ];
        assert_eq!(numbers, expected, "{text}");
    }

    #[test]
    fn another_up_is_kept() {
        let pose = Pose {
            eye: DVec3::new(0.0, 1.0, 5.0),
            target: DVec3::ZERO,
            up: DVec3::Y,
            fov_degrees: 30.0,
        };
        let mut orbit = Orbit::new(pose, 1.0).unwrap();
        orbit.turn(40.0, 0.0);
        let eye = orbit.pose().eye;
        assert!((eye.y - 1.0).abs() < 1e-12 && eye.x < -0.1);
        orbit.turn(0.0, 1e9);
        assert!(orbit.pose().eye.y > 5.0);
    }
}

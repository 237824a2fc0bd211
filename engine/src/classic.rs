//! The constants of classic `.scn` scenes: those of the ray tracing assignment that defined the format.

use glam::DVec3;

/// Ambient light I_a, the same in all channels.
pub const AMBIENT: f32 = 0.05;
/// Background colour, linear RGB.
pub const BACKGROUND: [f32; 3] = [1.0, 1.0, 1.0];
/// Colour of the silhouette material, linear RGB.
pub const SILHOUETTE: [f32; 3] = [1.0, 0.0, 0.0];
/// Blinn-Phong: diffuse colour c_d.
pub const DIFFUSE: [f32; 3] = [1.0, 0.0, 0.0];
/// Blinn-Phong: specular colour c_s.
pub const SPECULAR: [f32; 3] = [1.0, 1.0, 1.0];
/// Blinn-Phong: diffuse factor k_d.
pub const K_D: f32 = 0.8;
/// Blinn-Phong: specular factor k_s.
pub const K_S: f32 = 0.5;
/// Blinn-Phong: exponent alpha.
pub const ALPHA: u32 = 50;
/// Reflection: weight of the mirrored ray; the rest is matte.
pub const MIRROR_SHARE: f32 = 0.25;
/// Maximum ray depth: camera rays and two reflections.
pub const MAX_DEPTH: u32 = 3;
/// Vertical field of view, degrees.
pub const FOV_DEGREES: f64 = 45.0;
/// The point that the camera looks at.
pub const TARGET: DVec3 = DVec3::new(0.0, 0.0, 0.5);
/// The up vector.
pub const UP: DVec3 = DVec3::new(0.0, 0.0, 1.0);
/// Width and height of the picture, pixels.
pub const IMAGE_SIZE: u32 = 512;

/// Viewpoints 1 to 6: azimuth and rotation about z in degrees, distance.
const VIEWPOINTS: [[f64; 3]; 6] = [
    [-40.0, 25.0, 6.5],
    [-27.5, -30.5, 2.0],
    [-73.8, 37.0, 3.8],
    [46.2, 0.0, 6.2],
    [-35.0, -187.2, 2.8],
    [-80.3, 27.0, 1.1],
];

/// Returns the eye of viewpoint `view`, 1 to 6; `None` for another number.
///
/// The eye starts at (distance, 0, 0) and is rotated about y by the azimuth, then about z.
#[must_use]
pub fn viewpoint(view: u32) -> Option<DVec3> {
    let [azimuth, rot_z, distance] = *VIEWPOINTS.get(view.checked_sub(1)? as usize)?;
    let (sin_b, cos_b) = libm::sincos(azimuth.to_radians());
    let (sin_g, cos_g) = libm::sincos(rot_z.to_radians());
    let (x, z) = (distance * cos_b, -distance * sin_b);
    Some(DVec3::new(x * cos_g, x * sin_g, z))
}

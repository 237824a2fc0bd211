//! The intrinsics of a file's cameras, and what they say about the picture.

use crate::scene::ImagePlane;
use serde::Deserialize;
use serde_json::Value;

/// Models of cameras that are pinholes if no coefficient says otherwise.
const PINHOLES: [&str; 4] = ["OPENCV", "PINHOLE", "SIMPLE_PINHOLE", "PERSPECTIVE"];

/// The intrinsics of a camera: of the whole file, or of one frame.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Lens {
    /// Radians.
    camera_angle_x: Option<f64>,
    camera_angle_y: Option<f64>,
    /// Focal lengths and principal point, pixels of a picture of `w` x `h`.
    fl_x: Option<f64>,
    fl_y: Option<f64>,
    cx: Option<f64>,
    cy: Option<f64>,
    w: Option<f64>,
    h: Option<f64>,
    k1: f64,
    k2: f64,
    k3: f64,
    k4: f64,
    p1: f64,
    p2: f64,
    camera_model: Option<Value>,
    distortion_params: Option<Value>,
    /// What Instant NGP calls its models.
    is_fisheye: Option<Value>,
    equirectangular: Option<Value>,
    latlong: Option<Value>,
    ftheta_p0: Option<Value>,
}

impl Lens {
    /// Focal lengths and principal point in a picture of that size.
    pub fn of_pixels(focal: [f64; 2], middle: [f64; 2], size: [f64; 2], is_curved: bool) -> Self {
        Self {
            fl_x: Some(focal[0]),
            fl_y: Some(focal[1]),
            cx: Some(middle[0]),
            cy: Some(middle[1]),
            w: Some(size[0]),
            h: Some(size[1]),
            k1: f64::from(u8::from(is_curved)),
            ..Self::default()
        }
    }

    /// Takes missing values of the picture from `other`.
    pub fn or(self, other: &Self) -> Self {
        Self {
            camera_angle_x: self.camera_angle_x.or(other.camera_angle_x),
            camera_angle_y: self.camera_angle_y.or(other.camera_angle_y),
            fl_x: self.fl_x.or(other.fl_x),
            fl_y: self.fl_y.or(other.fl_y),
            cx: self.cx.or(other.cx),
            cy: self.cy.or(other.cy),
            w: self.w.or(other.w),
            h: self.h.or(other.h),
            ..self
        }
    }

    /// Focal length along an axis, pixels.
    fn focal(side: Option<f64>, focal: Option<f64>, angle: Option<f64>) -> Option<f64> {
        let angle = || angle.filter(|angle| (0.0..std::f64::consts::PI).contains(angle));
        focal.or_else(|| Some(0.5 * side? / libm::tan(0.5 * angle()?)))
    }

    /// Focal lengths along both axes.
    fn focals(&self) -> [Option<f64>; 2] {
        [
            Self::focal(self.w, self.fl_x, self.camera_angle_x),
            Self::focal(self.h, self.fl_y, self.camera_angle_y),
        ]
    }

    /// The vertical field of view, radians; `aspect` is that of the picture if the file does not say it.
    pub fn fov(&self, aspect: f64) -> Option<f64> {
        let [focal_x, focal_y] = self.focals();
        if let Some((h, focal)) = self.h.zip(focal_y.or(focal_x)) {
            return Some(2.0 * libm::atan(h / (2.0 * focal)));
        }
        let along_x = || {
            let angle = self
                .w
                .zip(self.fl_x)
                .map(|(w, fl)| 2.0 * libm::atan(w / (2.0 * fl)));
            let angle = angle.or(self.camera_angle_x);
            angle.filter(|angle| (0.0..std::f64::consts::PI).contains(angle))
        };
        self.camera_angle_y
            .or_else(|| Some(2.0 * libm::atan(libm::tan(along_x()? * 0.5) / aspect)))
    }

    /// How the picture lies in the image plane.
    pub fn image_plane(&self) -> ImagePlane {
        let [focal_x, focal_y] = self.focals();
        let aspect = focal_y.zip(focal_x).map_or(1.0, |(y, x)| y / x);
        let offset = |middle: Option<f64>, side: Option<f64>| {
            let all = middle.zip(side).zip(self.h);
            all.map_or(0.0, |((middle, side), h)| (middle - 0.5 * side) / h)
        };
        ImagePlane {
            principal_offset: [offset(self.cx, self.w), offset(self.cy, self.h)],
            // An angle and a focal length are not rounded alike.
            pixel_aspect: if (aspect - 1.0).abs() < 1e-9 { 1.0 } else { aspect },
        }
    }

    /// Whether a principal point cannot be placed, since the size of the picture is not known.
    pub fn is_unplaced(&self) -> bool {
        (self.cx.is_some() || self.cy.is_some()) && (self.w.is_none() || self.h.is_none())
    }

    /// The size of the picture, pixels.
    pub fn size(&self) -> Option<[u32; 2]> {
        let whole = |side: f64| Some(side as u32).filter(|&whole| whole > 0 && f64::from(whole) == side);
        Some([whole(self.w?)?, whole(self.h?)?])
    }

    /// Whether the lens has distortion, or is not of a pinhole camera at all.
    pub fn is_curved(&self) -> bool {
        let coefficients = [self.k1, self.k2, self.k3, self.k4, self.p1, self.p2];
        let model = self.camera_model.as_ref().and_then(Value::as_str);
        let others = [
            &self.distortion_params,
            &self.is_fisheye,
            &self.equirectangular,
            &self.latlong,
            &self.ftheta_p0,
        ];
        coefficients.iter().any(|&k| k != 0.0)
            || model.is_some_and(|model| !PINHOLES.contains(&model))
            || others.into_iter().flatten().any(says_yes)
    }
}

/// Whether a value is neither false, 0 nor empty.
fn says_yes(value: &Value) -> bool {
    match value {
        Value::Null => false,
        Value::Bool(is) => *is,
        Value::Number(number) => number.as_f64() != Some(0.0),
        Value::String(text) => !text.is_empty(),
        Value::Array(values) => values.iter().any(says_yes),
        Value::Object(_) => true,
    }
}

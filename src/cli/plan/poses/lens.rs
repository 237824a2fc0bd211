//! The intrinsics of a file's cameras, and what they say about the picture.

use crate::{
    error::short_number,
    scene::{Distortion, ImagePlane},
};
use serde::Deserialize;
use serde_json::Value;

/// Models of cameras that are pinholes if no coefficient says otherwise.
const PERSPECTIVES: [&str; 7] = [
    "OPENCV",
    "PINHOLE",
    "SIMPLE_PINHOLE",
    "PERSPECTIVE",
    "SIMPLE_RADIAL",
    "RADIAL",
    FULL,
];

/// The model whose `k4` to `k6` are factors in the denominator.
const FULL: &str = "FULL_OPENCV";

/// Models of fisheye lenses.
const FISHEYES: [&str; 5] = [
    "OPENCV_FISHEYE",
    "SIMPLE_RADIAL_FISHEYE",
    "RADIAL_FISHEYE",
    "SIMPLE_FISHEYE",
    "FISHEYE",
];

/// How a lens projects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Model {
    Pinhole,
    Distorted(Distortion),
    /// In a way that is not rendered.
    Unknown,
}

impl Model {
    /// A perspective one; `k4` to `k6` are factors in the denominator if it is `full`.
    fn perspective([k1, k2, k3, k4, k5, k6]: [f64; 6], tangential: [f64; 2], full: bool) -> Self {
        let (radial, divisor) = if full {
            ([k1, k2, k3, 0.0], [k4, k5, k6])
        } else if [k5, k6] == [0.0; 2] {
            ([k1, k2, k3, k4], [0.0; 3])
        } else {
            return Self::Unknown;
        };
        if radial == [0.0; 4] && divisor == [0.0; 3] && tangential == [0.0; 2] {
            return Self::Pinhole;
        }
        Self::Distorted(Distortion::Perspective {
            radial,
            divisor,
            tangential,
        })
    }

    /// One of COLMAP's, with the parameters behind the principal point.
    pub fn of_colmap(name: &str, parameters: &[f64]) -> Self {
        let fisheye = |radial| Self::Distorted(Distortion::Fisheye { radial });
        let radial = |k1, k2| [k1, k2, 0.0, 0.0, 0.0, 0.0];
        match (name, parameters) {
            ("SIMPLE_RADIAL", &[k1]) => Self::perspective(radial(k1, 0.0), [0.0; 2], false),
            ("RADIAL", &[k1, k2]) => Self::perspective(radial(k1, k2), [0.0; 2], false),
            ("OPENCV", &[k1, k2, p1, p2]) => Self::perspective(radial(k1, k2), [p1, p2], false),
            (FULL, &[k1, k2, p1, p2, k3, k4, k5, k6]) => {
                Self::perspective([k1, k2, k3, k4, k5, k6], [p1, p2], true)
            }
            ("SIMPLE_FISHEYE" | "FISHEYE", []) => fisheye([0.0; 4]),
            ("SIMPLE_RADIAL_FISHEYE", &[k1]) => fisheye([k1, 0.0, 0.0, 0.0]),
            ("RADIAL_FISHEYE", &[k1, k2]) => fisheye([k1, k2, 0.0, 0.0]),
            ("OPENCV_FISHEYE", &[k1, k2, k3, k4]) => fisheye([k1, k2, k3, k4]),
            // The last parameter has no effect if the one before it is 0.
            ("EUCM", [alpha, _]) if *alpha == 0.0 => Self::Pinhole,
            ("FOV", _) => Self::Unknown,
            _ if name.contains("FISHEYE") || parameters.iter().any(|&k| k != 0.0) => Self::Unknown,
            _ => Self::Pinhole,
        }
    }
}

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
    k1: Option<f64>,
    k2: Option<f64>,
    k3: Option<f64>,
    k4: Option<f64>,
    k5: Option<f64>,
    k6: Option<f64>,
    p1: Option<f64>,
    p2: Option<f64>,
    camera_model: Option<Value>,
    distortion_params: Option<Value>,
    /// What Instant NGP calls its models.
    is_fisheye: Option<Value>,
    equirectangular: Option<Value>,
    latlong: Option<Value>,
    ftheta_p0: Option<Value>,
    /// From a file of another format.
    #[serde(skip)]
    model: Option<Model>,
}

impl Lens {
    /// Focal lengths and principal point in a picture of that size.
    pub fn of_pixels(focal: [f64; 2], middle: [f64; 2], size: [f64; 2], model: Model) -> Self {
        Self {
            fl_x: Some(focal[0]),
            fl_y: Some(focal[1]),
            cx: Some(middle[0]),
            cy: Some(middle[1]),
            w: Some(size[0]),
            h: Some(size[1]),
            model: Some(model),
            ..Self::default()
        }
    }

    /// Takes missing values from `other`. As in Instant NGP, an angle or a focal length of its own counts for both axes.
    pub fn or(self, other: &Self) -> Self {
        let value = |own: Option<Value>, other: &Option<Value>| own.or_else(|| other.clone());
        let views = |lens: &Self| [lens.camera_angle_x, lens.camera_angle_y, lens.fl_x, lens.fl_y];
        let is_own = views(&self).iter().any(Option::is_some);
        let [camera_angle_x, camera_angle_y, fl_x, fl_y] = views(if is_own { &self } else { other });
        Self {
            camera_angle_x,
            camera_angle_y,
            fl_x,
            fl_y,
            cx: self.cx.or(other.cx),
            cy: self.cy.or(other.cy),
            w: self.w.or(other.w),
            h: self.h.or(other.h),
            k1: self.k1.or(other.k1),
            k2: self.k2.or(other.k2),
            k3: self.k3.or(other.k3),
            k4: self.k4.or(other.k4),
            k5: self.k5.or(other.k5),
            k6: self.k6.or(other.k6),
            p1: self.p1.or(other.p1),
            p2: self.p2.or(other.p2),
            camera_model: value(self.camera_model, &other.camera_model),
            distortion_params: value(self.distortion_params, &other.distortion_params),
            is_fisheye: value(self.is_fisheye, &other.is_fisheye),
            equirectangular: value(self.equirectangular, &other.equirectangular),
            latlong: value(self.latlong, &other.latlong),
            ftheta_p0: value(self.ftheta_p0, &other.ftheta_p0),
            model: self.model.or(other.model),
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
        let whole = |side: f64| {
            let whole = side.round();
            Some(whole as u32).filter(|&side| side > 0 && f64::from(side) == whole)
        };
        Some([whole(self.w?)?, whole(self.h?)?])
    }

    /// What is wrong with the size of the picture, the focal lengths or the angles, if they are there and count.
    pub fn fault(&self) -> Option<String> {
        self.wrong_length().or_else(|| self.wrong_angle())
    }

    fn wrong_angle(&self) -> Option<String> {
        let angles = [
            (
                "camera_angle_x",
                self.camera_angle_x.filter(|_| self.fl_x.is_none()),
            ),
            (
                "camera_angle_y",
                self.camera_angle_y.filter(|_| self.fl_y.is_none()),
            ),
        ];
        let is_wrong = |angle: &f64| *angle <= 0.0 || *angle >= std::f64::consts::PI;
        let mut wrong = angles
            .into_iter()
            .filter_map(|(key, angle)| Some((key, angle.filter(is_wrong)?)));
        let (key, angle) = wrong.next()?;
        let angle = short_number(angle);
        Some(format!("`{key}` is {angle}, expected radians, between 0 and pi"))
    }

    fn wrong_length(&self) -> Option<String> {
        const SIDE: &str = "pixels of its picture";
        const FOCAL: &str = "a focal length in pixels";
        let lengths = [
            ("w", self.w, SIDE),
            ("h", self.h, SIDE),
            ("fl_x", self.fl_x, FOCAL),
            ("fl_y", self.fl_y, FOCAL),
        ];
        let wrong = lengths
            .into_iter()
            .find_map(|(key, length, what)| Some((key, length.filter(|&length| length <= 0.0)?, what)));
        wrong.map(|(key, length, what)| {
            let length = short_number(length);
            format!("`{key}` is {length}, expected {what}, more than 0")
        })
    }

    /// How the lens projects.
    pub fn model(&self) -> Model {
        if let Some(model) = self.model {
            return model;
        }
        let name = self.camera_model.as_ref().and_then(Value::as_str);
        let is = |names: &[&str]| name.is_some_and(|name| names.contains(&name));
        let others = [
            &self.distortion_params,
            &self.equirectangular,
            &self.latlong,
            &self.ftheta_p0,
        ];
        let is_other = name.is_some() && !is(&PERSPECTIVES) && !is(&FISHEYES);
        if is_other || others.into_iter().flatten().any(says_yes) {
            return Model::Unknown;
        }
        let [k1, k2, k3, k4, k5, k6, p1, p2] = [
            self.k1, self.k2, self.k3, self.k4, self.k5, self.k6, self.p1, self.p2,
        ]
        .map(Option::unwrap_or_default);
        if !is(&FISHEYES) && !self.is_fisheye.as_ref().is_some_and(says_yes) {
            return Model::perspective([k1, k2, k3, k4, k5, k6], [p1, p2], is(&[FULL]));
        }
        // Programs differ in what else they read of a fisheye lens.
        if [k5, k6, p1, p2] != [0.0; 4] {
            return Model::Unknown;
        }
        let radial = [k1, k2, k3, k4];
        Model::Distorted(Distortion::Fisheye { radial })
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

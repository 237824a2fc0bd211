//! Lens distortion, and its inverse: the direction that a point of a distorted picture sees.
//!
//! ```text
//!   perspective                          fisheye
//!   (x, y): slopes of the direction      (x, y): its angle to the optical axis, along its slopes
//!                     \                 /
//!        distorted = (x, y) n(s) / d(s) + tangential       s = x² + y²
//!        pixel     = focal length * distorted + principal point
//! ```
//! These are OpenCV's models (Brown, *Close-Range Camera Calibration*, 1971; Kannala and Brandt, *A Generic Camera Model*,
//! 2006), which COLMAP and Nerfstudio share. All of it is plain `f64` arithmetic, so every machine makes the same rays.

use super::CameraError;
use glam::DVec3;
use std::f64::consts::PI;

/// The distortion of a lens: right and down are positive, as in a picture. Coefficients that are 0 have no effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Distortion {
    /// A lens that keeps straight lines nearly straight. `s` is the squared slope of a direction.
    Perspective {
        /// Factors of `s`, `s²`, `s³` and `s⁴` in the numerator: `k1`, `k2` and `k3` of OpenCV, and Nerfstudio's `k4`.
        radial: [f64; 4],
        /// Factors of `s`, `s²` and `s³` in the denominator: `k4`, `k5` and `k6` of OpenCV.
        divisor: [f64; 3],
        /// `p1` and `p2`, of a lens that is not parallel to the sensor.
        tangential: [f64; 2],
    },
    /// A fisheye lens. Without coefficients, the distance from the principal point is proportional to the angle to the optical
    /// axis, which may be up to 180 degrees. `s` is the square of this angle, in radians.
    Fisheye {
        /// Factors of `s`, `s²`, `s³` and `s⁴`: `k1` to `k4`.
        radial: [f64; 4],
    },
}

/// The largest coefficient.
const MAX_COEFFICIENT: f64 = 1e12;

/// The largest slope of a direction of a distorted picture: 89.994 degrees off the axis. Powers of it stay finite.
const MAX_SLOPE: f64 = 1e4;

/// Coefficients of a polynomial of `s`, the constant one first.
type Polynomial = [f64; TERMS];
const TERMS: usize = 8;

/// A distortion that can be inverted.
///
/// A point is found only where the distortion is still monotonic, as seen from the optical axis: beyond, a picture would show
/// directions a second time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Inverse {
    pub distortion: Distortion,
    numerator: [f64; 4],
    divisor: [f64; 3],
    tangential: [f64; 2],
    /// The radius where the radial part stops being monotonic.
    end: f64,
    /// A radius within which all of it is monotonic.
    safe: f64,
    /// A radius beyond which it is not monotonic.
    last: f64,
    /// No point is farther from the axis after distortion.
    reach: f64,
}

/// The quotient `n / d` of a squared radius, and its derivative.
struct Quotient {
    value: f64,
    slope: f64,
}

/// A distorted point, and the derivatives of its coordinates by those of the point: a symmetric matrix `[a b; b c]`.
struct Distorted {
    point: [f64; 2],
    a: f64,
    b: f64,
    c: f64,
}

impl Distorted {
    /// Whether the matrix is positive definite. All comparisons are false for NaN.
    #[inline(always)]
    fn is_monotonic(&self) -> bool {
        self.a + self.c > 0.0 && self.a * self.c - self.b * self.b > 0.0
    }
}

impl Inverse {
    /// The most steps: from the largest slope, `r⁹` comes down by a ninth in each.
    const STEPS: usize = 128;

    /// The most steps in two dimensions. Where more are needed, the start was not near, and the end is anywhere.
    const REFINING_STEPS: usize = 16;

    /// Points on the way from the axis where the distortion must be monotonic.
    const PARTS: u32 = 32;

    /// A relative step after which a point is exact: Newton's method doubles the digits.
    const LAST_STEP: f64 = 1e-12;

    /// The same if more steps follow.
    const FIRST_STEP: f64 = 1e-3;

    /// The largest difference of a point that is found, relative to the point or to 1.
    const TOLERANCE: f64 = 1e-10;

    /// Checks the coefficients.
    pub fn new(distortion: Distortion) -> Result<Self, CameraError> {
        let (numerator, divisor, tangential, most) = match distortion {
            Distortion::Perspective {
                radial,
                divisor,
                tangential,
            } => (radial, divisor, tangential, MAX_SLOPE),
            Distortion::Fisheye { radial } => (radial, [0.0; 3], [0.0; 2], PI),
        };
        let mut all = numerator.iter().chain(&divisor).chain(&tangential);
        if let Some(&wrong) = all.find(|k| k.is_nan() || k.abs() > MAX_COEFFICIENT) {
            return Err(CameraError::Distortion(wrong));
        }
        let mut inverse = Self {
            distortion,
            numerator,
            divisor,
            tangential,
            end: most,
            safe: 0.0,
            last: 0.0,
            reach: 0.0,
        };
        let last = [inverse.derivative(), inverse.denominator()].map(|of| first_root(&of, most * most));
        let last = last[0].min(last[1]);
        inverse.end = last.sqrt();
        // There may be a pole.
        while inverse.end * inverse.end > last {
            inverse.end = inverse.end.next_down();
        }
        inverse.bound(most);
        Ok(inverse)
    }

    /// Bounds of where the distortion is monotonic. The derivatives of its tangential part are at most `6 |p| r`.
    fn bound(&mut self, most: f64) {
        let [p1, p2] = self.tangential;
        let size = p1.hypot(p2);
        (self.safe, self.last) = (self.end, self.end);
        let mut rim = self.end * self.quotient(self.end * self.end).value;
        if size > 0.0 {
            (self.safe, self.last) = (0.0, most);
            let mut is_safe = true;
            let mut r = 1e-3;
            while r < most {
                let Quotient { value, slope } = self.quotient(r * r);
                let least = value.min(value + 2.0 * r * r * slope);
                let has_pole = value_of(&self.denominator(), r * r) <= 0.0;
                if has_pole || least <= -6.0 * size * r {
                    self.last = r;
                    break;
                }
                is_safe &= least > 6.0 * size * r;
                if is_safe {
                    self.safe = r;
                }
                rim = rim.max(r * value);
                r *= 1.05;
            }
        }
        // The radial part may be a little larger between two radii.
        self.reach = 1.1 * rim + 3.0 * size * self.last * self.last;
    }

    fn denominator(&self) -> Polynomial {
        let [d1, d2, d3] = self.divisor;
        [1.0, d1, d2, d3, 0.0, 0.0, 0.0, 0.0]
    }

    /// A polynomial with the sign of the derivative of `r n(r²) / d(r²)` by `r`.
    fn derivative(&self) -> Polynomial {
        let [n1, n2, n3, n4] = self.numerator;
        let mut sum = [0.0; TERMS];
        for (i, n) in [1.0, n1, n2, n3, n4].into_iter().enumerate() {
            for (j, d) in self.denominator().into_iter().take(4).enumerate() {
                sum[i + j] += n * d * (1.0 + 2.0 * i as f64 - 2.0 * j as f64);
            }
        }
        sum
    }

    #[inline(always)]
    fn quotient(&self, s: f64) -> Quotient {
        let [n1, n2, n3, n4] = self.numerator;
        let [d1, d2, d3] = self.divisor;
        let n = 1.0 + s * (n1 + s * (n2 + s * (n3 + s * n4)));
        let d = 1.0 + s * (d1 + s * (d2 + s * d3));
        let n_slope = n1 + s * (2.0 * n2 + s * (3.0 * n3 + s * (4.0 * n4)));
        let d_slope = d1 + s * (2.0 * d2 + s * (3.0 * d3));
        let value = n / d;
        Quotient {
            value,
            slope: (n_slope - value * d_slope) / d,
        }
    }

    #[inline(always)]
    fn distort(&self, [x, y]: [f64; 2]) -> Distorted {
        let [p1, p2] = self.tangential;
        let s = x * x + y * y;
        let Quotient { value, slope } = self.quotient(s);
        Distorted {
            point: [
                x * value + 2.0 * p1 * x * y + p2 * (s + 2.0 * x * x),
                y * value + 2.0 * p2 * x * y + p1 * (s + 2.0 * y * y),
            ],
            a: value + 2.0 * x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x,
            b: 2.0 * x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y,
            c: value + 2.0 * y * y * slope + 2.0 * p2 * x + 6.0 * p1 * y,
        }
    }

    /// The directions that distorted points see: right, down and forward, unit vectors; 0 for points that see nothing. Each
    /// depends only on its point.
    #[inline(always)]
    pub fn directions<const N: usize>(&self, points: &[[f64; N]; 2]) -> [DVec3; N] {
        let [x, y] = self.undistorted(points);
        std::array::from_fn(|i| {
            let point = [points[0][i], points[1][i]];
            let found = [x[i], y[i]];
            let found = if self.is_right(point, found) {
                Some(found)
            } else {
                self.followed(point)
            };
            found.map_or(DVec3::ZERO, |found| self.direction(found))
        })
    }

    /// Follows a point from the optical axis, for points that Newton's method does not find from their radius.
    #[cold]
    fn followed(&self, point: [f64; 2]) -> Option<[f64; 2]> {
        let [mut x, mut y] = [[0.0]; 2];
        if self.tangential == [0.0; 2] || point[0].hypot(point[1]) > self.reach {
            return None;
        }
        for part in 1..=Self::PARTS {
            let share = f64::from(part) / f64::from(Self::PARTS);
            let target = point.map(|at| at * share);
            self.refine(&target.map(|at| [at]), &mut [&mut x, &mut y]);
            if !self.distort([x[0], y[0]]).is_monotonic() {
                return None;
            }
        }
        let found = [x[0], y[0]];
        self.is_right(point, found).then_some(found)
    }

    /// The points whose distorted ones these are; anything for those without one. Loops have no branches, so that they
    /// vectorise.
    #[inline(always)]
    fn undistorted<const N: usize>(&self, points: &[[f64; N]; 2]) -> [[f64; N]; 2] {
        let is_radial = self.tangential == [0.0; 2];
        let mut distorted = [0.0; N];
        for i in 0..N {
            let (x, y) = (points[0][i], points[1][i]);
            distorted[i] = (x * x + y * y).sqrt();
        }
        // At the end itself the matrix has no inverse.
        let (most, last_step) = if is_radial {
            (self.end, Self::LAST_STEP)
        } else {
            (0.95 * self.end, Self::FIRST_STEP)
        };
        let radii = self.radii(&distorted, last_step);
        let mut found = *points;
        for i in 0..N {
            let scale = radii[i].min(most) / distorted[i].max(f64::MIN_POSITIVE);
            found[0][i] *= scale;
            found[1][i] *= scale;
        }
        if !is_radial {
            let [x, y] = &mut found;
            self.refine(points, &mut [x, y]);
        }
        found
    }

    /// The radii whose distorted ones these are, without the tangential part: Newton's method between bounds.
    #[inline(always)]
    fn radii<const N: usize>(&self, distorted: &[f64; N], last_step: f64) -> [f64; N] {
        let (mut lower, mut upper) = ([0.0; N], [self.end; N]);
        let mut radii = distorted.map(|radius| radius.min(0.5 * self.end));
        // 1 until the radius is exact, then 0.
        let mut open = [1.0; N];
        for _ in 0..Self::STEPS {
            for i in 0..N {
                let r = radii[i];
                let s = r * r;
                let Quotient { value, slope } = self.quotient(s);
                let excess = r * value - distorted[i];
                lower[i] = if excess < 0.0 { r } else { lower[i] };
                upper[i] = if excess < 0.0 { upper[i] } else { r };
                let newton = r - excess / (value + 2.0 * s * slope);
                let middle = 0.5 * (lower[i] + upper[i]);
                let next = if newton >= lower[i] { newton } else { middle };
                let next = if newton <= upper[i] { next } else { middle };
                radii[i] = if open[i] > 0.0 { next } else { r };
                let is_large = (next - r).abs() > last_step * next;
                open[i] = if is_large { open[i] } else { 0.0 };
            }
            if open == [0.0; N] {
                break;
            }
        }
        radii
    }

    /// Adds the tangential part, by Newton's method in two dimensions.
    #[inline(always)]
    fn refine<const N: usize>(&self, points: &[[f64; N]; 2], [x, y]: &mut [&mut [f64; N]; 2]) {
        let mut open = [1.0; N];
        for _ in 0..Self::REFINING_STEPS {
            for i in 0..N {
                let Distorted { point, a, b, c } = self.distort([x[i], y[i]]);
                let (u, v) = (points[0][i] - point[0], points[1][i] - point[1]);
                let scale = 1.0 / (a * c - b * b);
                let step = [(c * u - b * v) * scale, (a * v - b * u) * scale];
                let next = [x[i] + step[0], y[i] + step[1]];
                x[i] = if open[i] > 0.0 { next[0] } else { x[i] };
                y[i] = if open[i] > 0.0 { next[1] } else { y[i] };
                let is_large =
                    step[0].abs() + step[1].abs() > Self::LAST_STEP * (next[0].abs() + next[1].abs());
                open[i] = if is_large { open[i] } else { 0.0 };
            }
            if open == [0.0; N] {
                break;
            }
        }
    }

    /// Whether `found` is the point of a distorted one, and the distortion is monotonic from the axis to it.
    #[inline(always)]
    fn is_right(&self, point: [f64; 2], found: [f64; 2]) -> bool {
        let distorted = self.distort(found);
        let [x, y] = found;
        let again = distorted.point;
        let difference = (again[0] - point[0]).abs().max((again[1] - point[1]).abs());
        let size = point[0].abs().max(point[1].abs()).max(1.0);
        let s = x * x + y * y;
        difference <= Self::TOLERANCE * size
            && distorted.is_monotonic()
            && s <= self.last * self.last
            && (s <= self.safe * self.safe || self.is_monotonic_until(found))
    }

    /// Whether the distortion is monotonic on the way from the axis to a point.
    #[cold]
    fn is_monotonic_until(&self, [x, y]: [f64; 2]) -> bool {
        (1..Self::PARTS).all(|part| {
            let share = f64::from(part) / f64::from(Self::PARTS);
            self.distort([x * share, y * share]).is_monotonic()
        })
    }

    /// The derivatives of a direction (right, down and forward) by its distorted point, right and down: of a unit vector for a
    /// fisheye, else of a vector that is 1 forward.
    pub fn slopes(&self, direction: DVec3) -> [DVec3; 2] {
        let DVec3 { x, y, z } = direction;
        let (point, by_x, by_y) = match self.distortion {
            Distortion::Perspective { .. } => ([x / z, y / z], DVec3::X, DVec3::Y),
            Distortion::Fisheye { .. } => {
                let sin = (x * x + y * y).sqrt();
                let angle = libm::atan2(sin, z);
                let ([u, v], ratio) = if sin > 0.0 {
                    ([x / sin, y / sin], sin / angle)
                } else {
                    ([1.0, 0.0], 1.0)
                };
                let (outwards, around) = (DVec3::new(u * z, v * z, -sin), DVec3::new(-v, u, 0.0) * ratio);
                (
                    [u * angle, v * angle],
                    outwards * u - around * v,
                    outwards * v + around * u,
                )
            }
        };
        let Distorted { a, b, c, .. } = self.distort(point);
        let determinant = a * c - b * b;
        [
            (by_x * c - by_y * b) / determinant,
            (by_y * a - by_x * b) / determinant,
        ]
    }

    /// The direction of a point that is not distorted.
    #[inline(always)]
    fn direction(&self, [x, y]: [f64; 2]) -> DVec3 {
        match self.distortion {
            Distortion::Perspective { .. } => {
                let scale = 1.0 / (1.0 + x * x + y * y).sqrt();
                DVec3::new(x * scale, y * scale, scale)
            }
            Distortion::Fisheye { .. } => {
                let angle = (x * x + y * y).sqrt();
                let (sin, cos) = libm::sincos(angle);
                let scale = if angle > 0.0 { sin / angle } else { 1.0 };
                DVec3::new(x * scale, y * scale, cos)
            }
        }
    }
}

fn value_of(polynomial: &Polynomial, s: f64) -> f64 {
    polynomial.iter().rev().fold(0.0, |sum, &term| sum * s + term)
}

/// The last number before a polynomial that is positive at 0 changes its sign; `end` if it does not until there.
fn first_root(polynomial: &Polynomial, end: f64) -> f64 {
    let (roots, count) = roots(polynomial, end, TERMS);
    roots[..count].first().copied().unwrap_or(end)
}

/// The numbers between 0 and `end` before which a polynomial changes its sign, in ascending order, and their count. Terms
/// from `terms` on are 0. Between two roots of its derivative there is at most one.
fn roots(polynomial: &Polynomial, end: f64, terms: usize) -> (Polynomial, usize) {
    let (mut found, mut count) = ([0.0; TERMS], 0);
    if terms < 2 {
        return (found, count);
    }
    let mut derivative = [0.0; TERMS];
    for i in 1..terms {
        derivative[i - 1] = polynomial[i] * i as f64;
    }
    let (turns, turn_count) = roots(&derivative, end, terms - 1);
    let mut low = 0.0;
    for &high in turns[..turn_count].iter().chain([&end]) {
        let is_positive = value_of(polynomial, low) > 0.0;
        if is_positive != (value_of(polynomial, high) > 0.0) {
            let (mut before, mut after) = (low, high);
            loop {
                let middle = 0.5 * (before + after);
                if middle <= before || middle >= after {
                    break;
                }
                if (value_of(polynomial, middle) > 0.0) == is_positive {
                    before = middle;
                } else {
                    after = middle;
                }
            }
            found[count] = before;
            count += 1;
        }
        low = high;
    }
    (found, count)
}

#[cfg(test)]
mod tests;

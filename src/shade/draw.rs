//! Random directions: a point of the unit square for each lane, mapped to a disc, a cone or a hemisphere.

use crate::{
    lanes::{F32x8, LANES},
    math::{COS, SIN},
    simd::{Lanes, Simd, Vec3Eight, Vec3Lanes},
    sobol,
};

/// Selects the random points.
#[derive(Clone, Copy, Debug)]
pub(super) struct Draws<'a> {
    /// The first points of the tile's pixels, by packet; see
    /// [`SurfacePacket::pixel`](super::surface::SurfacePacket::pixel).
    pub first: &'a [[u32; LANES]],
    /// The number of the sample in its pixel.
    pub sample: u32,
    /// The number of the pair of dimensions: at each depth one for ambient light and one for each light.
    pub pair: u32,
}

impl Draws<'_> {
    /// Returns a point for each pixel.
    #[inline(always)]
    pub fn points<S: Simd>(&self, simd: S, pixel: &[u32; LANES]) -> [S::V8; 2] {
        let mut index = [0; LANES];
        for (index, &pixel) in index.iter_mut().zip(pixel) {
            let first = self.first[pixel as usize / LANES][pixel as usize % LANES];
            *index = first.wrapping_add(self.sample);
        }
        let (mut u, mut v) = ([0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            [u[lane], v[lane]] = sobol::point(self.pair, index[lane]);
        }
        [simd.load(&F32x8::new(u)), simd.load(&F32x8::new(v))]
    }
}

/// Sums a power series. Not a closure, which would not be inlined.
#[inline(always)]
fn series<S: Simd>(simd: S, x: S::V8, [a, b, c, d, e]: [f32; 5]) -> S::V8 {
    let sum = simd.splat(e) * x + simd.splat(d);
    let sum = (sum * x + simd.splat(c)) * x + simd.splat(b);
    sum * x + simd.splat(a)
}

/// Maps the unit square to the unit disc, areas to equal areas: Shirley and Chiu, *A Low Distortion Map Between Disk and
/// Square*, 1997.
#[inline(always)]
pub(crate) fn disc<S: Simd>(simd: S, [u, v]: [S::V8; 2]) -> [S::V8; 2] {
    let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
    let (a, b) = (u + u - one, v + v - one);
    let is_steep = b.abs().gt(a.abs());
    let (long, short) = (S::V8::select(is_steep, b, a), S::V8::select(is_steep, a, b));
    let slope = S::V8::select(long.eq(zero), zero, short / long);
    let square = slope * slope;
    let cosine = series(simd, square, COS);
    let sine = slope * series(simd, square, SIN);
    let (along, across) = (long * cosine, long * sine);
    [
        S::V8::select(is_steep, across, along),
        S::V8::select(is_steep, along, across),
    ]
}

/// Returns the vector with the components x, y and z in an orthonormal basis whose z axis is `axis`: Duff et al., *Building
/// an Orthonormal Basis, Revisited*, JCGT 2017.
#[inline(always)]
pub(super) fn around<S: Simd>(simd: S, axis: Vec3Eight<S>, [x, y, z]: [S::V8; 3]) -> Vec3Eight<S> {
    let one = simd.splat(1.0);
    let sign = one.turn(axis.z.sign());
    let a = -one / (sign + axis.z);
    let b = axis.x * axis.y * a;
    let across = Vec3Lanes::new(one + sign * axis.x * axis.x * a, sign * b, -(sign * axis.x));
    let other = Vec3Lanes::new(b, sign + axis.y * axis.y * a, -axis.y);
    across.mul_add(x, other.mul_add(y, axis * z))
}

/// Returns a direction, distributed by the cosine to `normal`.
#[inline(always)]
pub(super) fn by_cosine<S: Simd>(simd: S, normal: Vec3Eight<S>, point: [S::V8; 2]) -> Vec3Eight<S> {
    let [x, y] = disc(simd, point);
    let z = (simd.splat(1.0) - (x * x + y * y)).max(simd.splat(0.0)).sqrt();
    around(simd, normal, [x, y, z])
}

/// Returns a direction, distributed by the cosine to `normal`, mirrored if it is below the surface, whose geometric normal
/// is `geometric`.
#[inline(always)]
pub(super) fn scattered<S: Simd>(
    simd: S,
    normal: Vec3Eight<S>,
    geometric: Vec3Eight<S>,
    point: [S::V8; 2],
) -> Vec3Eight<S> {
    let direction = by_cosine(simd, normal, point);
    let below = geometric.dot(direction).min(simd.splat(0.0));
    geometric.mul_add(simd.splat(-2.0) * below, direction)
}

/// A spherical light as seen from points.
pub(super) struct Cone<V> {
    /// Unit directions to random points of the sphere, evenly distributed over the solid angle.
    pub direction: Vec3Lanes<V>,
    /// Distances to the sphere that way; not above 0 for points inside it.
    pub distance: V,
}

/// Draws points of the sphere of `radius` whose centre is at `to_center` from each point. Inside the sphere light comes
/// from the hemisphere around that direction.
#[inline(always)]
pub(super) fn cone<S: Simd>(simd: S, to_center: Vec3Eight<S>, radius: f32, point: [S::V8; 2]) -> Cone<S::V8> {
    let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
    let radius_squared = simd.splat(radius * radius);
    let squared = to_center.dot(to_center);
    let length = squared.sqrt();
    // The squared sine of the cone's half angle; one minus its cosine.
    let sine = (radius_squared / squared).min(one);
    let width = sine / (one + (one - sine).sqrt());
    let [x, y] = disc(simd, point);
    let from_axis = width * (x * x + y * y);
    let cosine = one - from_axis;
    let spread = (width * (one + cosine)).sqrt();
    let axis = to_center * (one / length);
    let sine = from_axis * (one + cosine);
    let inside = (radius_squared - squared * sine).max(zero).sqrt();
    Cone {
        direction: around(simd, axis, [x * spread, y * spread, cosine]),
        distance: length * cosine - inside,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{EightLanes, Portable};
    use glam::Vec3;

    /// The draws of the first points of a sequence, eight at a time.
    fn draws(count: u32) -> impl Iterator<Item = [<Portable as Simd>::V8; 2]> {
        (0..count / LANES as u32).map(|packet| {
            let points = [0, 1, 2, 3, 4, 5, 6, 7].map(|lane| sobol::point(2, packet * 8 + lane));
            [0, 1].map(|i| Portable.load(&F32x8::new(points.map(|point| point[i]))))
        })
    }

    fn lanes(v: Vec3Eight<Portable>) -> [Vec3; LANES] {
        let v = v.to8();
        std::array::from_fn(|lane| v.lane(lane))
    }

    #[test]
    fn discs_are_filled_evenly() {
        let mut rings = [0; 8];
        let mut sectors = [0; 8];
        for point in draws(1 << 14) {
            let [x, y] = disc(Portable, point).map(|c| c.to8().to_array());
            for lane in 0..LANES {
                let [x, y] = [f64::from(x[lane]), f64::from(y[lane])];
                let squared = x * x + y * y;
                assert!(squared < 1.000_001, "{x} {y}");
                rings[((squared * 8.0) as usize).min(7)] += 1;
                let turn = y.atan2(x) / std::f64::consts::TAU + 0.5;
                sectors[((turn * 8.0) as usize).min(7)] += 1;
            }
        }
        for count in rings.into_iter().chain(sectors) {
            assert!((2030..=2066).contains(&count), "{rings:?} {sectors:?}");
        }
        let middle = disc(Portable, [Portable.splat(0.5); 2]);
        assert_eq!(middle.map(|c| c.to8().to_array()), [[0.0; 8]; 2]);
    }

    #[test]
    fn scattered_directions_go_by_the_cosine() {
        for normal in [
            Vec3::Z,
            Vec3::NEG_Z,
            Vec3::new(0.6, -0.8, 0.0),
            Vec3::new(0.0, 1e-9, -1.0),
        ] {
            let n = Portable.splat3(normal);
            let (mut sum, mut along) = (Vec3::ZERO, 0.0);
            for direction in draws(1 << 12).flat_map(|point| lanes(scattered(Portable, n, n, point))) {
                assert!((direction.length() - 1.0).abs() < 1e-6 && direction.dot(normal) >= 0.0);
                sum += direction;
                along += direction.dot(normal).powi(2);
            }
            // The mean cosine is 2/3, the mean of its square 1/2.
            let mean = sum / 4096.0;
            assert!(mean.distance(normal * (2.0 / 3.0)) < 1e-3, "{normal}: {mean}");
            assert!((along / 4096.0 - 0.5).abs() < 1e-3, "{normal}: {along}");
        }
    }

    #[test]
    fn scattered_directions_stay_above_the_surface() {
        let (normal, geometric) = (Vec3::new(0.8, 0.0, 0.6), Vec3::Z);
        let (n, g) = (Portable.splat3(normal), Portable.splat3(geometric));
        for direction in draws(1 << 10).flat_map(|point| lanes(scattered(Portable, n, g, point))) {
            assert!(direction.z >= 0.0 && (direction.length() - 1.0).abs() < 1e-6);
        }
    }

    /// The mean over the solid angle of a sphere is half of one plus the cosine of the half angle, along the axis.
    #[test]
    fn cones_hold_the_sphere() {
        for (to_center, radius) in [
            (Vec3::new(3.0, -4.0, 12.0), 5.0_f32),
            (Vec3::new(0.0, 0.0, -1e6), 1.0),
            (Vec3::new(-2e-4, 1e-4, 2e-4), 1e-4),
        ] {
            let half_angle = (radius / to_center.length()).asin();
            let mut sum = Vec3::ZERO;
            for point in draws(1 << 12) {
                let cone = cone(Portable, Portable.splat3(to_center), radius, point);
                let distance = cone.distance.to8().to_array();
                for (direction, distance) in lanes(cone.direction).into_iter().zip(distance) {
                    assert!((direction.length() - 1.0).abs() < 1e-6);
                    assert!(direction.angle_between(to_center) < half_angle * 1.001 + 1e-3);
                    let off = (direction * distance).distance(to_center) / radius - 1.0;
                    assert!(
                        off.abs() < 2e-2 * to_center.length() / radius * 1e-3 + 2e-3,
                        "{off}"
                    );
                    sum += direction;
                }
            }
            let expected = to_center.normalize() * (0.5 + 0.5 * half_angle.cos());
            assert!((sum / 4096.0).distance(expected) < 2e-3, "{to_center}");
        }
    }

    #[test]
    fn inside_a_light_nothing_is_between() {
        for point in draws(64) {
            let cone = cone(Portable, Portable.splat3(Vec3::new(0.1, 0.2, 0.0)), 1.0, point);
            assert!(cone.distance.to8().to_array().iter().all(|&t| t <= 0.0));
        }
    }
}

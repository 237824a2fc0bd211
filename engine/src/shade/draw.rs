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
    let sign = one.flip_signs(axis.z.sign());
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
mod tests;

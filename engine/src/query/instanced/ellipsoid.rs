//! The closest point of an ellipsoid: the image of a sphere.

use glam::DVec3;

/// Rotations until the axes are at right angles to rounding, at most: a few are enough.
const MOST_SWEEPS: usize = 32;

/// Returns the point nearest to `point` of the ellipsoid around `center` with any three conjugate half-axes: images of three
/// half-axes of a sphere at right angles.
pub(super) fn on_ellipsoid(point: DVec3, center: DVec3, axes: [DVec3; 3]) -> DVec3 {
    let mut axes = principal(axes);
    axes.sort_by(|a, b| b.length_squared().total_cmp(&a.length_squared()));
    let lengths = axes.map(DVec3::length);
    let least = lengths[2];
    let from = point - center;
    // In the octant of the point, in units of the least half-axis; never in a plane of symmetry, where the nearest point may
    // be beside it, and there are two.
    let p = [0, 1, 2].map(|i| {
        (axes[i].dot(from) / lengths[i] / least)
            .abs()
            .max(f64::MIN_POSITIVE)
    });
    let ratio = lengths.map(|length| length / least);
    // The squares of the ratios less 1.
    let more = [0, 1, 2].map(|i| (lengths[i] - least) / least * (ratio[i] + 1.0));
    // The nearest point is ratio^2 * p / (more + s), for the s > 0 that puts it on the ellipsoid.
    let part = |i: usize, s: f64| ratio[i] * p[i] / (more[i] + s);
    let is_outside = |s: f64| {
        let [x, y, z] = [part(0, s), part(1, s), part(2, s)];
        x * x + y * y + z * z > 1.0
    };
    let (mut low, mut high) = (0, f64::MAX.to_bits());
    while high - low > 1 {
        // Of the bits, so that exponents are halved, too.
        let middle = low + (high - low) / 2;
        if is_outside(f64::from_bits(middle)) {
            low = middle;
        } else {
            high = middle;
        }
    }
    let s = f64::from_bits(high);
    let mut at = center;
    for i in 0..3 {
        at += axes[i] * part(i, s).min(1.0).copysign(axes[i].dot(from));
    }
    at
}

/// Turns conjugate half-axes into those at right angles, by rotations of two at a time (Hestenes, *Inversion of Matrices by
/// Biorthogonalization and Related Results*, 1958).
fn principal(mut axes: [DVec3; 3]) -> [DVec3; 3] {
    for _ in 0..MOST_SWEEPS {
        let mut is_done = true;
        for [i, j] in [[0, 1], [0, 2], [1, 2]] {
            let (a, b) = (axes[i], axes[j]);
            let (aa, bb, ab) = (a.length_squared(), b.length_squared(), a.dot(b));
            if ab.abs() <= f64::EPSILON * (aa * bb).sqrt() {
                continue;
            }
            is_done = false;
            let ratio = (bb - aa) / (2.0 * ab);
            let tangent = 1.0_f64.copysign(ratio) / (ratio.abs() + (ratio * ratio + 1.0).sqrt());
            let cosine = 1.0 / (tangent * tangent + 1.0).sqrt();
            let sine = cosine * tangent;
            (axes[i], axes[j]) = (a * cosine - b * sine, a * sine + b * cosine);
        }
        if is_done {
            break;
        }
    }
    axes
}

#[cfg(test)]
mod tests;

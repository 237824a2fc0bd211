//! Triangulates concave polygons.
//!
//! Readers make a fan of every polygon and record it in [`Fans`]. Once all positions are known, polygons that a fan would
//! not fill are triangulated again, into the same number of triangles.

mod ears;

use super::{
    budget::{Budget, BudgetError},
    left_out::counted,
};
use crate::{
    error::clip_path,
    scene::{TriangleMesh, is_usable},
};
use earcut::Earcut;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::{ops::Range, path::Path};

/// Polygons with more corners stay fans.
const MOST_CORNERS: usize = 1 << 20;
/// Memory of a corner while its polygon is cut, bytes.
const CORNER_BYTES: usize = 128;
/// The memory of polygons with fewer corners is not counted.
const LEAST_COUNTED: usize = 1 << 10;
/// Polygons with more corners are left to [`ears`]: `earcut` gives better triangles, but can take cubic time and more.
// Tuned: see docs/lab-notes.md#polygon-corners
const MOST_FOR_EARCUT: usize = 64;
/// How many triangles of polygons a thread checks at a time.
const PIECE: usize = 1 << 14;
/// How many of such pieces are listed at a time.
const LISTED: usize = 1 << 12;

/// Which triangles of a mesh are polygons of four corners and more.
#[derive(Default)]
pub(super) struct Fans(Vec<Run>);

/// Consecutive polygons with the same number of triangles.
struct Run {
    first: usize,
    each: usize,
    count: usize,
}

impl Run {
    /// The range of triangles of each polygon.
    fn polygons(&self) -> impl Iterator<Item = Range<usize>> {
        let polygon = |i| self.first + i * self.each..self.first + (i + 1) * self.each;
        (0..self.count).map(polygon)
    }
}

impl Fans {
    /// Records `count` polygons of `each` triangles, starting at triangle `first`. Single triangles are not recorded.
    #[inline]
    pub(super) fn add(
        &mut self,
        first: usize,
        each: usize,
        count: usize,
        budget: &Budget,
    ) -> Result<(), BudgetError> {
        if each > 1 {
            self.add_run(Run { first, each, count }, budget)?;
        }
        Ok(())
    }

    fn add_run(&mut self, mut run: Run, budget: &Budget) -> Result<(), BudgetError> {
        let most = (PIECE / run.each).max(1);
        if let Some(last) = self.0.last_mut()
            && last.each == run.each
            && last.first + last.count * last.each == run.first
        {
            let more = run.count.min(most - last.count);
            last.count += more;
            run.count -= more;
            run.first += more * run.each;
        }
        while run.count > 0 {
            let count = run.count.min(most);
            budget.reserve(&mut self.0, 1)?;
            self.0.push(Run { count, ..run });
            run.count -= count;
            run.first += count * run.each;
        }
        Ok(())
    }

    /// Adds the polygons of a part of the mesh, whose first triangle is `first` in the whole.
    pub(super) fn append(&mut self, part: Self, first: usize, budget: &Budget) -> Result<(), BudgetError> {
        let mut runs = part.0.into_iter();
        runs.try_for_each(|run| self.add(first + run.first, run.each, run.count, budget))
    }

    /// The range of triangles of each polygon.
    pub(super) fn polygons(&self) -> impl Iterator<Item = Range<usize>> {
        self.0.iter().flat_map(Run::polygons)
    }

    /// Triangulates concave polygons. Returns how many too complex ones stay fans.
    pub(super) fn cut_concave(&self, mesh: &mut TriangleMesh, budget: &Budget) -> Result<usize, BudgetError> {
        let TriangleMesh {
            x, y, z, triangles, ..
        } = mesh;
        let columns = [&x[..], &y[..], &z[..]];
        let (mut rest, mut at, mut fans) = (&mut triangles[..], 0, 0);
        for runs in self.0.chunks(LISTED) {
            let parts = runs.iter().map(|run| {
                // Runs are in the order of their triangles.
                _ = rest.split_off_mut(..run.first - at);
                let length = run.each * run.count;
                at = run.first + length;
                (run.each, rest.split_off_mut(..length).unwrap_or_default())
            });
            let parts: Vec<(usize, &mut [[u32; 3]])> = parts.collect();
            let parts = parts
                .into_par_iter()
                .map_init(Cutter::default, |cutter, (each, part)| {
                    for fan in part.chunks_exact_mut(each) {
                        cutter.cut_fan(columns, fan, budget)?;
                    }
                    Ok(std::mem::take(&mut cutter.given_up))
                });
            fans += parts.try_reduce(|| 0, |a, b| Ok(a + b))?;
        }
        Ok(fans)
    }
}

/// The note about polygons that stay fans, if there are any.
pub(super) fn fans_note(count: usize, path: &Path) -> Option<String> {
    let polygons = counted(count, "concave polygon is", "concave polygons are");
    let path = clip_path(path);
    (count > 0)
        .then(|| format!("{path}: {polygons} too complex to be filled exactly: shown as fans of triangles"))
}

/// The position of a vertex; NaN where it is not usable.
#[inline]
pub(super) fn position(columns: [&[f32]; 3], i: u32) -> DVec3 {
    let coordinate = |column: &[f32]| match column.get(i as usize) {
        Some(&value) if is_usable(value) => f64::from(value),
        Some(_) => f64::NAN,
        None => 0.0,
    };
    let [x, y, z] = columns;
    DVec3::new(coordinate(x), coordinate(y), coordinate(z))
}

/// The corners of a fan's polygon.
fn ring(fan: &[[u32; 3]]) -> impl Iterator<Item = u32> {
    let first = fan.first().into_iter().flat_map(|&[a, b, _]| [a, b]);
    first.chain(fan.iter().map(|&[_, _, c]| c))
}

/// Whether all triangles of a fan around the first corner face the same way, so that they fill the polygon. Cheap, and
/// true for nearly all polygons.
#[inline]
fn fan_fills(mut corners: impl Iterator<Item = DVec3>) -> bool {
    let (Some(first), Some(second)) = (corners.next(), corners.next()) else {
        return true;
    };
    let (mut side, mut sum) = (second - first, DVec3::ZERO);
    corners.all(|corner| {
        let next = corner - first;
        let normal = side.cross(next);
        side = next;
        sum += normal;
        normal.dot(sum - normal) >= 0.0
    })
}

/// Triangulates polygons; reuses its memory.
#[derive(Default)]
pub(super) struct Cutter {
    earcut: Earcut<f64>,
    triangles: Vec<u32>,
    /// How many polygons are too complex.
    pub(super) given_up: usize,
}

impl Cutter {
    /// The triangles of a polygon as indices of its corners, in the polygon's winding; two fewer than corners. `None` if a
    /// fan around the first corner fills it, or nothing does (its sides cross, it has no area, or it is too complex).
    pub(super) fn cut(&mut self, corners: &[DVec3]) -> Option<&[[u32; 3]]> {
        if corners.len() < 4 || fan_fills(corners.iter().copied()) {
            return None;
        }
        let flat = flattened(corners);
        if is_convex(&flat) {
            return None;
        }
        let winding = area(&flat).signum();
        if corners.len() > MOST_FOR_EARCUT {
            if corners.len() > MOST_CORNERS || !ears::cut(&flat, winding, &mut self.triangles) {
                self.given_up += 1;
                return None;
            }
        } else {
            let flat = flat.iter().map(DVec2::to_array);
            self.earcut.earcut(flat, &[], &mut self.triangles);
        }
        let (triangles, _) = self.triangles.as_chunks_mut::<3>();
        for triangle in &mut *triangles {
            if area(&triangle.map(|i| flat[i as usize])).signum() == -winding {
                triangle.swap(1, 2);
            }
        }
        (triangles.len() == corners.len() - 2).then_some(triangles)
    }

    /// Replaces a fan that does not fill its polygon. One with an unusable corner has that corner everywhere afterwards, so
    /// that all of it is left out.
    fn cut_fan(
        &mut self,
        columns: [&[f32]; 3],
        fan: &mut [[u32; 3]],
        budget: &Budget,
    ) -> Result<(), BudgetError> {
        let point = |i: u32| position(columns, i);
        // A NaN makes this false.
        if fan_fills(ring(fan).map(point)) {
            return Ok(());
        }
        let unusable = ring(fan).find(|&i| point(i).is_nan());
        if let Some(unusable) = unusable {
            fan.fill([unusable; 3]);
            return Ok(());
        }
        let room = cutting_bytes(fan.len());
        budget.take(room)?;
        let ring: Vec<u32> = ring(fan).collect();
        let corners: Vec<DVec3> = ring.iter().map(|&i| point(i)).collect();
        let cut = self.cut(&corners).unwrap_or_default();
        for (triangle, cut) in fan.iter_mut().zip(cut) {
            *triangle = cut.map(|i| ring[i as usize]);
        }
        budget.give_back(room);
        Ok(())
    }
}

/// The memory that cutting a polygon takes, bytes.
pub(super) fn cutting_bytes(triangles: usize) -> usize {
    if triangles < LEAST_COUNTED {
        0
    } else {
        triangles.saturating_mul(CORNER_BYTES)
    }
}

/// The corners without the coordinate of the polygon's dominant axis.
fn flattened(corners: &[DVec3]) -> Vec<DVec2> {
    // Newell's normal, relative to a corner, for precision far from the origin.
    let middle = corners[0];
    let sides = corners.iter().zip(corners.iter().cycle().skip(1));
    let normal: DVec3 = sides.map(|(&a, &b)| (a - middle).cross(b - middle)).sum();
    let size = normal.abs();
    let drop = |p: DVec3| {
        let p = p - middle;
        if size.x >= size.y && size.x >= size.z {
            DVec2::new(p.y, p.z)
        } else if size.y >= size.z {
            DVec2::new(p.z, p.x)
        } else {
            DVec2::new(p.x, p.y)
        }
    };
    corners.iter().map(|&corner| drop(corner)).collect()
}

/// Twice the signed area.
fn area(corners: &[DVec2]) -> f64 {
    let first = corners[0];
    let pairs = corners.windows(2);
    pairs
        .map(|pair| (pair[0] - first).perp_dot(pair[1] - first))
        .sum()
}

/// Whether all corners turn the same way, up to rounding.
fn is_convex(corners: &[DVec2]) -> bool {
    let area = area(corners);
    let next = |i: usize| corners[(i + 1) % corners.len()];
    (0..corners.len()).all(|i| {
        let (a, b, c) = (corners[i], next(i), next(i + 1));
        let turn = (b - a).perp_dot(c - b) * area.signum();
        turn >= -1e-6 * (b - a).length() * (c - b).length()
    })
}

#[cfg(test)]
mod tests;

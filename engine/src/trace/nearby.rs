//! Whether anything opaque may be near some points: most surfaces that are not opaque have nothing opaque in the same
//! place, so that no rays need to be traced there.

use super::{Tracer, bits::bits};
use crate::{
    accel::Child,
    geometry::padded,
    math::{Aabb, max_abs},
    ray::PrimitiveId,
    scene::{Plane, Primitive, Scene},
    simd::{LaneMask, Lanes, Simd},
};

/// Subtrees still to visit. A small box meets few; if there are more, something opaque may be among them.
const STACK: usize = 64;

/// Blocks of primitives that are looked at: more cost more than the short rays that they may save.
const BLOCKS: usize = 16;

/// Rounding of a point's distance to a plane, as a share of coordinates.
const PLANE_ERROR: f32 = 4e-6;

impl Tracer<'_> {
    /// Returns whether anything opaque, `except` a primitive, may reach into a box. May return true if nothing does:
    /// instances are not looked at.
    #[inline(always)]
    pub(crate) fn may_meet_opaque<S: Simd>(
        &self,
        simd: S,
        scene: &Scene,
        bounds: &Aabb,
        except: Option<PrimitiveId>,
    ) -> bool {
        if self.instances.is_some() || self.planes.iter().any(|plane| may_meet(plane, bounds)) {
            return true;
        }
        let mut stack = [Child::NONE; STACK];
        stack[0] = self.bvh.root();
        let (mut count, mut blocks) = (1, 0);
        while count > 0 {
            count -= 1;
            let child = stack[count];
            if child == Child::NONE {
                continue;
            }
            if !child.is_inner() {
                blocks += 1;
                if blocks > BLOCKS || self.has_opaque(scene, child, bounds, except) {
                    return true;
                }
                continue;
            }
            let node = &self.bvh.nodes()[child.index()];
            let mut meets = simd.mask(u32::MAX);
            for axis in 0..3 {
                let (lower, upper) = (simd.load(&node.planes[axis]), simd.load(&node.planes[axis + 3]));
                meets = meets
                    & lower.le(simd.splat(bounds.upper[axis]))
                    & upper.ge(simd.splat(bounds.lower[axis]));
            }
            for lane in bits(meets.bits() & node.valid_bits()) {
                if count == STACK {
                    return true;
                }
                stack[count] = node.child[lane];
                count += 1;
            }
        }
        false
    }

    /// Whether a block has an opaque primitive whose padded box meets another.
    fn has_opaque(&self, scene: &Scene, block: Child, bounds: &Aabb, except: Option<PrimitiveId>) -> bool {
        let ids = self.bvh.leaf_ids(block);
        ids[..block.count()].iter().any(|&id| {
            let id = PrimitiveId(id);
            if Some(id) == except || !scene.may_be_opaque(scene.material_of(id)) {
                return false;
            }
            let own = match scene.primitive(id) {
                Primitive::Triangle(i) => Aabb::around(scene.triangle(i)),
                Primitive::Sphere(i) => scene.sphere_bounds(i),
                Primitive::Plane(_) => return true,
            };
            let own = padded(own);
            let meets = own.lower.cmple(bounds.upper) & own.upper.cmpge(bounds.lower);
            meets.all()
        })
    }
}

fn may_meet(plane: &Plane, bounds: &Aabb) -> bool {
    let (center, half) = (
        (bounds.lower + bounds.upper) * 0.5,
        (bounds.upper - bounds.lower) * 0.5,
    );
    let distance = (center - plane.point).dot(plane.normal).abs();
    distance - half.dot(plane.normal.abs()) <= PLANE_ERROR * (max_abs(center) + max_abs(plane.point))
}

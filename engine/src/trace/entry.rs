//! Entry nodes: where neighbouring bundles of camera rays start instead of at the root.
//!
//! The frustum of up to 1024 rays descends once and finds up to eight subtrees that any of them may meet; these
//! become the children of a virtual node. Without subtrees the bundles hit nothing. After Reshetov, Soupikov
//! and Hurley, *Multi-Level Ray Tracing Algorithm*, 2005, who find a single subtree.
// Tuned: see docs/lab-notes.md#entry-nodes

use super::{bits, frustum::Frustum};
use crate::{
    accel::{Child, Node8},
    lanes::LANES,
    math::Aabb,
    simd::EightLanes,
};

/// At most this many nodes are opened to find entry nodes: time for it against a closer start.
// Tuned: see docs/lab-notes.md#entry-nodes
const MOST_OPENED: usize = 6;

/// A subtree that the rays may meet.
#[derive(Clone, Copy)]
struct Met {
    child: Child,
    bounds: Aabb,
    /// Half of the box's surface; negative if it is not to be opened.
    area: f32,
}

/// Returns a node whose children hold everything below the first of `nodes` that rays within `frustum` may hit.
#[inline(always)]
pub(super) fn entry_node<V8: EightLanes>(nodes: &[Node8], frustum: &Frustum<V8>) -> Node8 {
    let nothing = Met {
        child: Child::NONE,
        bounds: Aabb::EMPTY,
        area: -1.0,
    };
    let mut met = [nothing; LANES];
    let mut count = children_met(&nodes[0], frustum, &mut met);
    for _ in 0..MOST_OPENED {
        let (mut largest, mut area) = (0, -1.0);
        for (i, met) in met[..count].iter().enumerate() {
            if met.area >= area {
                (largest, area) = (i, met.area);
            }
        }
        if area < 0.0 {
            break;
        }
        let mut opened = [nothing; LANES];
        let more = children_met(&nodes[met[largest].child.index()], frustum, &mut opened);
        if count - 1 + more > LANES {
            met[largest].area = -1.0;
            continue;
        }
        // The last one replaces the opened one.
        count -= 1;
        met[largest] = met[count];
        for opened in &opened[..more] {
            met[count % LANES] = *opened;
            count += 1;
        }
    }
    let mut children = [(Child::NONE, Aabb::EMPTY); LANES];
    for i in 0..LANES {
        children[i] = (met[i].child, met[i].bounds);
    }
    Node8::new(&children[..count])
}

/// Stores the children of `of` that the frustum meets into `met` and returns their count.
#[inline(always)]
fn children_met<V8: EightLanes>(node: &Node8, frustum: &Frustum<V8>, met: &mut [Met; LANES]) -> usize {
    let (candidates, _) = frustum.children(node);
    let mut count = 0;
    for c in bits(candidates & node.valid_bits()) {
        let child = node.child[c % LANES];
        let (lower, upper) = node.corners(c);
        let size = upper - lower;
        met[count % LANES] = Met {
            child,
            bounds: Aabb { lower, upper },
            area: if child.is_inner() {
                size.x * (size.y + size.z) + size.y * size.z
            } else {
                -1.0
            },
        };
        count += 1;
    }
    count
}

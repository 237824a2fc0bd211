//! Collapses a binary tree: which of its nodes become children of wide nodes, and which become blocks.
//!
//! The optimal collapse of Ylitie, Karras and Laine, *Efficient Incoherent Ray Traversal on GPUs Through Compressed
//! Wide BVHs*, 2017, from the leaves up. Differs: blocks are of one kind of primitive, and the SAH weighs boxes for
//! [bundles of rays](super::tree).
// Tried: see docs/lab-notes.md#collapse

/// The most children of a node, and primitives of a block.
pub(super) const WIDTH: usize = 8;

/// Cost of a visit to an inner node, of a visit to a block, and of each primitive in a block, in visits to inner nodes: they
/// trade fuller blocks for fewer primitives tested.
// Tuned: see docs/lab-notes.md#varied-constants
const NODE_COST: f32 = 1.0;
const BLOCK_COST: f32 = 0.8;
const PRIMITIVE_COST: f32 = 0.05;

/// The cheapest form of a subtree of the binary tree, by the surface area heuristic.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Plan {
    /// Cost as one to seven children of a wide node: `cost[i - 1]` with at most i of them.
    cost: [f32; WIDTH - 1],
    /// Triangles below, capped at one more than fit a block.
    triangles: u8,
    spheres: u8,
    /// Whether the subtree, as one child, is a block.
    pub(super) is_block: bool,
}

impl Plan {
    /// A block of primitives of one kind, at most [`WIDTH`]; `visits`: how often it is visited.
    pub(super) fn block(triangles: usize, spheres: usize, visits: f32) -> Self {
        let mut plan = Self {
            cost: [0.0; WIDTH - 1],
            triangles: triangles as u8,
            spheres: spheres as u8,
            is_block: true,
        };
        plan.cost = [plan.block_cost(visits); WIDTH - 1];
        plan
    }

    /// A node above two subtrees, which may become a block if they are few enough; `visits` as for
    /// [`block`](Self::block).
    #[inline(always)]
    pub(super) fn inner(left: &Self, right: &Self, visits: f32, may_be_block: bool) -> Self {
        let most = WIDTH as u8 + 1;
        let mut plan = Self {
            cost: [0.0; WIDTH - 1],
            triangles: (left.triangles + right.triangles).min(most),
            spheres: (left.spheres + right.spheres).min(most),
            is_block: false,
        };
        plan.cost[0] = visits * NODE_COST + best_split::<WIDTH>(left, right).1;
        if !may_be_block {
            // So that no larger subtree becomes a block either.
            plan.triangles = most;
        } else if plan.fits_block() {
            let block = plan.block_cost(visits);
            plan.is_block = block <= plan.cost[0];
            plan.cost[0] = plan.cost[0].min(block);
        }
        // Unrolled, each with its own number of sums.
        let splits = [
            best_split::<2>(left, right).1,
            best_split::<3>(left, right).1,
            best_split::<4>(left, right).1,
            best_split::<5>(left, right).1,
            best_split::<6>(left, right).1,
            best_split::<7>(left, right).1,
        ];
        for i in 1..WIDTH - 1 {
            plan.cost[i] = plan.cost[i - 1].min(splits[i - 1]);
        }
        plan
    }

    /// The same subtree where it may be one child only.
    pub(super) fn as_one_child(&self) -> Self {
        Self {
            cost: [self.cost[0]; WIDTH - 1],
            ..*self
        }
    }

    /// Whether the subtree's block holds triangles, not spheres.
    pub(super) fn has_triangles(&self) -> bool {
        self.triangles > 0
    }

    fn fits_block(&self) -> bool {
        let (t, s) = (usize::from(self.triangles), usize::from(self.spheres));
        (t == 0 && s <= WIDTH) || (s == 0 && t <= WIDTH)
    }

    fn block_cost(&self, visits: f32) -> f32 {
        visits * (BLOCK_COST + PRIMITIVE_COST * f32::from(self.triangles + self.spheres))
    }

    /// How many of `slots` children the subtree uses: fewer if more do not pay.
    fn slots_used(&self, mut slots: usize) -> usize {
        while slots > 1 && (slots == WIDTH || self.cost[slots - 1] == self.cost[slots - 2]) {
            slots -= 1;
        }
        slots
    }
}

/// The best division of `CHILDREN` slots between two subtrees: the left one's share, and the cost.
#[inline(always)]
fn best_split<const CHILDREN: usize>(left: &Plan, right: &Plan) -> (usize, f32) {
    let mut best = (1, f32::INFINITY);
    for share in 1..CHILDREN {
        let cost = left.cost[share - 1] + right.cost[CHILDREN - share - 1];
        if cost < best.1 {
            best = (share, cost);
        }
    }
    best
}

fn best_share(left: &Plan, right: &Plan, slots: usize) -> usize {
    match slots {
        2 => 1,
        3 => best_split::<3>(left, right).0,
        4 => best_split::<4>(left, right).0,
        5 => best_split::<5>(left, right).0,
        6 => best_split::<6>(left, right).0,
        7 => best_split::<7>(left, right).0,
        _ => best_split::<8>(left, right).0,
    }
}

/// A binary tree with plans.
pub(super) trait Planned {
    /// A handle of a node.
    type Node: Copy;
    /// The plan of a node.
    fn plan(&self, node: Self::Node) -> &Plan;
    /// Both children of a node that can be opened.
    fn children(&self, node: Self::Node) -> Option<[Self::Node; 2]>;
}

/// The children of a wide node.
#[derive(Clone, Copy)]
pub(super) struct Children<N> {
    nodes: [Option<N>; WIDTH],
    count: usize,
}

impl<N: Copy> Children<N> {
    /// From left to right.
    pub(super) fn iter(&self) -> impl Iterator<Item = N> + '_ {
        self.nodes[..self.count].iter().filter_map(|&node| node)
    }

    pub(super) fn len(&self) -> usize {
        self.count
    }
}

/// The up to eight nodes that become the children of the wide node for `node`, as planned. A root that is planned as a
/// block becomes the only child of the wide node, or its parts do.
pub(super) fn widen<T: Planned>(tree: &T, node: T::Node) -> Children<T::Node> {
    let mut children = Children {
        nodes: [None; WIDTH],
        count: 0,
    };
    let plan = tree.plan(node);
    let slots = if plan.is_block {
        plan.slots_used(WIDTH)
    } else {
        WIDTH
    };
    open(tree, node, slots, &mut children);
    children
}

fn open<T: Planned>(tree: &T, node: T::Node, slots: usize, children: &mut Children<T::Node>) {
    match tree.children(node) {
        Some([left, right]) if slots > 1 => {
            let (l, r) = (tree.plan(left), tree.plan(right));
            let share = best_share(l, r, slots);
            open(tree, left, l.slots_used(share), children);
            open(tree, right, r.slots_used(slots - share), children);
        }
        _ => {
            children.nodes[children.count] = Some(node);
            children.count += 1;
        }
    }
}

//! What a ray costs: boxes and primitives that the scalar baseline tests for it, counted in a traversal of its own.

use crate::{
    accel::BinaryBvh,
    ray::{Hit, Ray},
    reference::{RaySlabs, intersect_shape},
};

/// The count that is shown in the warmest colour.
pub const MOST: u32 = 512;

/// Tests of one ray.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cost {
    /// Boxes of the binary BVH.
    pub boxes: u32,
    /// Triangles and spheres.
    pub primitives: u32,
}

impl Cost {
    /// All tests.
    #[must_use]
    pub fn total(self) -> u32 {
        self.boxes + self.primitives
    }
}

/// The nearest hit over the binary BVH, nearer child first, and what it took.
#[must_use]
pub fn closest_hit(bvh: &BinaryBvh, ray: &Ray, stack: &mut Vec<(u32, f32)>) -> (Hit, Cost) {
    let slabs = RaySlabs::new(ray);
    let mut best = Hit::miss(ray.t_max);
    let mut cost = Cost::default();
    let enter = |node_i: u32, cost: &mut Cost| {
        let (near, far) = slabs.interval(bvh.nodes.get(node_i as usize)?.bounds());
        cost.boxes += 1;
        (near <= far).then_some((node_i, near))
    };
    stack.clear();
    stack.extend(enter(0, &mut cost));
    while let Some((node_i, near)) = stack.pop() {
        if near > best.t {
            continue;
        }
        let node = &bvh.nodes[node_i as usize];
        if node.count == 0 {
            let children = [node.first, node.first + 1].map(|child| enter(child, &mut cost));
            let nearer_last = match children {
                [Some((_, near0)), Some((_, near1))] if near0 <= near1 => [children[1], children[0]],
                _ => children,
            };
            stack.extend(nearer_last.into_iter().flatten());
            continue;
        }
        let leaf = node.first as usize..(node.first + node.count) as usize;
        for (&id, shape) in bvh.primitives[leaf.clone()].iter().zip(&bvh.shapes[leaf]) {
            cost.primitives += 1;
            if let Some(hit) = intersect_shape(id, shape, ray, &slabs)
                && best.loses_to(hit.t, id)
            {
                best = hit;
            }
        }
    }
    (best, cost)
}

/// Black for nothing, blue, green, yellow, red, white for [`MOST`] tests and more; each colour is a doubling or so,
/// because costs differ by factors.
#[must_use]
pub fn color(tests: u32) -> [f32; 3] {
    const STOPS: [[f32; 3]; 6] = [
        [0.0, 0.0, 0.1],
        [0.0, 0.2, 0.9],
        [0.0, 0.7, 0.3],
        [0.95, 0.9, 0.1],
        [0.9, 0.1, 0.05],
        [1.0, 1.0, 1.0],
    ];
    let steps = STOPS.len() - 1;
    let share = ((1.0 + tests as f32).log2() / (1.0 + MOST as f32).log2()).min(1.0);
    let place = share * steps as f32;
    let i = (place as usize).min(steps - 1);
    let along = place - i as f32;
    std::array::from_fn(|c| STOPS[i][c] + (STOPS[i + 1][c] - STOPS[i][c]) * along)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        accel::Bvh,
        generate::{Kind, Options, generate},
        reference::bvh,
        render::Settings,
    };

    #[test]
    fn hits_are_those_of_the_baseline() {
        let options = Options {
            seed: 1,
            count: Some(2000),
        };
        let generated = generate(Kind::Figure, options).unwrap();
        let camera = generated.view.camera().unwrap();
        let scene = generated.into_scene().unwrap();
        let built = Bvh::build(&scene);
        let binary = built.binary(&scene);
        let Settings { width, height, .. } = Settings::default();
        let rays = camera.pixel_rays(width, height, 1);
        let mut hits = 0;
        for (x, y) in (0..height)
            .step_by(17)
            .flat_map(|y| (0..width).step_by(13).map(move |x| (x, y)))
        {
            let ray = Ray::new(rays.eye(), rays.direction(x, y, [0, 0]));
            let (hit, cost) = closest_hit(binary, &ray, &mut Vec::new());
            assert_eq!(hit, bvh::closest_hit(binary, &mut bvh::Stack::default(), &ray));
            assert!(cost.boxes > 0 && (!hit.is_hit() || cost.primitives > 0));
            hits += usize::from(hit.is_hit());
        }
        assert!(hits > 50);
    }

    #[test]
    fn colours_grow_warmer() {
        assert_eq!(color(0), [0.0, 0.0, 0.1]);
        assert_eq!((color(MOST), color(u32::MAX)), ([1.0; 3], [1.0; 3]));
        assert!(color(4)[2] > color(100)[2] && color(200)[0] > color(20)[0]);
    }
}

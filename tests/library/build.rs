//! The BVH: every primitive is in exactly one leaf, boxes are tight, the tree is the same for any number of threads, and
//! memory is bounded.

use glam::{DVec3, Vec3};
use octray::{
    accel::{BuildQuality, Bvh, Layout, Node8, TriangleBlocks},
    generate::{Kind, Options, generate},
    geometry::padded,
    math::Aabb,
    ray::PrimitiveId,
    scene::{Primitive, Scene, SceneBuilder, Transform},
};
use std::sync::Mutex;

const QUALITIES: [BuildQuality; 3] = [BuildQuality::Fast, BuildQuality::Best, BuildQuality::Ploc];
const LAYOUTS: [Layout; 2] = [Layout::Whole, Layout::Indexed];

fn scene(kind: Kind, count: usize) -> Scene {
    let options = Options {
        seed: 3,
        count: Some(count),
    };
    let generated = generate(kind, options).expect("a scene");
    generated.into_scene().expect("valid columns")
}

fn build_on(threads: usize, scene: &Scene, quality: BuildQuality, layout: Layout) -> Bvh {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.expect("threads")
        .install(|| Bvh::build_as(scene, quality, layout))
}

fn child_bounds(node: &Node8, lane: usize) -> Aabb {
    let (lower, upper) = node.corners(lane);
    Aabb { lower, upper }
}

/// Checks the boxes below a node and counts its primitives in `seen`. Returns the box around them.
fn check(scene: &Scene, bvh: &Bvh, node_i: usize, seen: &mut [u32]) -> Aabb {
    let node = &bvh.nodes()[node_i];
    let mut all = Aabb::EMPTY;
    for lane in 0..node.count as usize {
        let child = node.child[lane];
        let below = if child.is_inner() {
            check(scene, bvh, child.index(), seen)
        } else {
            bvh.leaf_ids(child)[..child.count()]
                .iter()
                .fold(Aabb::EMPTY, |around, &id| {
                    seen[id as usize] += 1;
                    around.union(padded(match scene.primitive(PrimitiveId(id)) {
                        Primitive::Triangle(i) => Aabb::around(scene.triangle(i)),
                        Primitive::Sphere(i) => scene.sphere_bounds(i),
                        Primitive::Plane(_) => panic!("planes are in no BVH"),
                    }))
                })
        };
        assert_eq!(child_bounds(node, lane), below, "node {node_i}, child {lane}");
        all = all.union(below);
    }
    all
}

#[test]
fn every_primitive_is_in_one_leaf_and_boxes_are_tight() {
    for (kind, count) in [
        (Kind::Terrain, 2),
        (Kind::Spheres, 1),
        (Kind::Spheres, 9),
        (Kind::Flake, 3_000),
        (Kind::Figure, 10_000),
        (Kind::Terrain, 100_000),
        (Kind::Interior, 20_000),
    ] {
        let scene = scene(kind, count);
        for (quality, layout) in QUALITIES
            .into_iter()
            .flat_map(|q| LAYOUTS.map(|layout| (q, layout)))
        {
            let bvh = Bvh::build_as(&scene, quality, layout);
            let mut seen = vec![0; scene.primitive_count()];
            check(&scene, &bvh, bvh.root().index(), &mut seen);
            assert!(
                seen.iter().all(|&times| times == 1),
                "{kind:?} {count} {quality:?} {layout:?}"
            );
            let stats = bvh.stats();
            assert_eq!(
                stats.leaf_sizes.iter().sum::<usize>(),
                stats.triangle_blocks + stats.sphere_blocks
            );
            assert_eq!(stats.child_counts.iter().sum::<usize>(), bvh.nodes().len());
            assert_eq!((stats.quality, stats.layout), (quality, layout));
            let most = 100 * scene.primitive_count() + 1024;
            assert!(
                stats.memory_bytes <= most,
                "{} bytes of {most}",
                stats.memory_bytes
            );
        }
    }
}

#[test]
fn any_number_of_threads_builds_the_same_tree() {
    let scene = scene(Kind::Blobs, 150_000);
    for (quality, layout) in QUALITIES.into_iter().zip(LAYOUTS.into_iter().cycle()) {
        let [one, four] = [1, 4].map(|threads| build_on(threads, &scene, quality, layout));
        assert_eq!(one.nodes().len(), four.nodes().len());
        for (a, b) in one.nodes().iter().zip(four.nodes()) {
            assert_eq!((a.child, a.planes), (b.child, b.planes));
        }
        assert_eq!(one.triangle_blocks().len(), four.triangle_blocks().len());
        for i in 0..one.triangle_blocks().len() {
            assert_eq!(one.triangle_blocks().ids(i), four.triangle_blocks().ids(i));
        }
    }
}

#[test]
fn indexed_leaves_store_shared_vertices_once() {
    for kind in [Kind::Terrain, Kind::Figure, Kind::Blobs] {
        let scene = scene(kind, 10_000);
        let [whole, indexed] = LAYOUTS.map(|layout| Bvh::build_as(&scene, BuildQuality::Best, layout));
        let (whole, indexed) = (whole.stats().memory_bytes, indexed.stats().memory_bytes);
        assert!(
            indexed * 10 < whole * 7,
            "{kind:?}: {indexed} bytes instead of {whole}"
        );
        assert_eq!(Layout::for_scene(&scene), Layout::Whole, "{kind:?} fits a cache");
    }
}

#[test]
fn indexed_blocks_of_separate_triangles_hold_four() {
    let mut builder = SceneBuilder::new();
    let material = builder.classic_material(1).expect("a material");
    let mut random = fastrand::Rng::with_seed(11);
    for i in 0..3000 {
        let mut near = || Vec3::new(random.f32(), random.f32(), random.f32());
        let at = near() * 10.0;
        if i % 5 == 0 {
            builder.add_sphere(at, 0.1, material).expect("a sphere");
        } else {
            let corners = [at, at + near() * 0.2, at + near() * 0.2];
            builder.add_triangle(corners, material).expect("a triangle");
        }
    }
    let scene = builder.finish();
    for quality in QUALITIES {
        let bvh = Bvh::build_as(&scene, quality, Layout::Indexed);
        let mut seen = vec![0; scene.primitive_count()];
        check(&scene, &bvh, bvh.root().index(), &mut seen);
        assert!(seen.iter().all(|&times| times == 1), "{quality:?}");
        assert!(
            bvh.stats().triangle_blocks >= 600,
            "more than four triangles in a block"
        );
    }
}

#[test]
fn an_empty_scene_has_the_requested_layout() {
    let scene = SceneBuilder::new().finish();
    for layout in LAYOUTS {
        let bvh = Bvh::build_as(&scene, BuildQuality::Best, layout);
        let is_indexed = matches!(bvh.triangle_blocks(), TriangleBlocks::Indexed(_));
        assert_eq!(
            (bvh.stats().layout, is_indexed),
            (layout, layout == Layout::Indexed)
        );
    }
}

#[test]
fn a_build_ends_when_about_all_steps_are_done() {
    let mut builder = SceneBuilder::new();
    let material = builder.classic_material(1).unwrap();
    let of_spheres = |builder: &mut SceneBuilder, count: u16| {
        (0..count).try_for_each(|i| builder.add_sphere(Vec3::splat(f32::from(i)), 0.5, material))
    };
    of_spheres(&mut builder, 5000).unwrap();
    let prototype = builder
        .add_prototype(|builder| of_spheres(builder, 3000))
        .unwrap();
    for i in 0..2000 {
        let transform = Transform::IDENTITY.then_translate(DVec3::X * f64::from(i));
        builder.add_instance(prototype, &transform).unwrap();
    }
    let steps = Mutex::new(Vec::new());
    let _ = Bvh::build_watched(&builder.finish(), BuildQuality::Fast, &|progress| {
        steps.lock().unwrap().push((progress.done, progress.total));
    });
    let steps = steps.into_inner().unwrap();
    assert!(steps.len() > 8, "{steps:?}");
    let last = steps.iter().max().unwrap();
    assert!(last.0 > last.1 / 10 * 9, "{steps:?}");
}

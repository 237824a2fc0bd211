//! The reference computes the same at every level, bit for bit, on rays that break ray tracers.

use crate::long::rounds;
use glam::Vec3;
use octray::{
    accel::Bvh,
    ray::{Ray, SceneHit},
    reference::{
        Passing, brute,
        bvh::OverScene,
        cost,
        shade::{Intersect, Limits, PixelSample, SecondaryRays, radiance_at},
    },
    scene::{Scene, SceneBuilder, SphereCloud, TriangleMesh},
    verify::{Group, Random, rays, scenes},
};
use octray_engine::{at_level, simd::Level};

fn bits(hit: &SceneHit) -> (u32, u32, u32, u32, u32) {
    (
        hit.t.to_bits(),
        hit.u.to_bits(),
        hit.v.to_bits(),
        hit.primitive.0,
        hit.instance.0,
    )
}

/// A tracing method at a level.
struct At<'a> {
    level: Level,
    scene: &'a Scene,
    /// `None`: brute force.
    bvh: Option<OverScene<'a>>,
}

impl Intersect for At<'_> {
    fn closest_hit(&mut self, ray: &Ray) -> SceneHit {
        match &mut self.bvh {
            Some(bvh) => bvh.closest_hit(ray),
            None => at_level!(self.level, |simd| {
                brute::closest(simd, self.scene, ray, Passing::CutOuts(self.scene))
            }),
        }
    }

    fn opaque_hit(&mut self, ray: &Ray) -> SceneHit {
        match &mut self.bvh {
            Some(bvh) => bvh.opaque_hit(ray),
            None => at_level!(self.level, |simd| {
                brute::closest(simd, self.scene, ray, Passing::NotOpaque(self.scene))
            }),
        }
    }

    fn occluded(&mut self, ray: &Ray) -> bool {
        match &mut self.bvh {
            Some(bvh) => bvh.occluded(ray),
            None => at_level!(self.level, |simd| brute::any(simd, self.scene, ray)),
        }
    }
}

/// Brute force and the binary BVH, at each level; brute force at the portable level comes first.
fn all<'a>(scene: &'a Scene, bvh: &'a Bvh) -> Vec<At<'a>> {
    let mut all = Vec::new();
    for level in Level::all() {
        for bvh in [None, Some(OverScene::new(scene, bvh, level))] {
            all.push(At { level, scene, bvh });
        }
    }
    all
}

#[test]
fn every_level_finds_the_same_hits_at_the_same_cost() {
    let (mut rays, mut hits) = (0, 0);
    for seed in 0..rounds(64, 150) {
        let mut random = Random::new(seed, 0);
        let scene = scenes::small(&mut random, 1 + seed as usize % 64).unwrap();
        let bvh = Bvh::build(&scene);
        let mut all = all(&scene, &bvh);
        let mut stack = cost::Stack::default();
        for ray in Group::random(&mut random, &scene, 100).rays {
            let (expected, blocked) = (all[0].closest_hit(&ray), all[0].occluded(&ray));
            let (_, expected_cost) = at_level!(Level::PORTABLE, |simd| cost::counted(
                simd, &scene, &bvh, &mut stack, &ray
            ));
            for one in &mut all {
                let level = one.level;
                let what = format!("seed {seed}, {level}, {ray:?}");
                assert_eq!(bits(&one.closest_hit(&ray)), bits(&expected), "{what}");
                assert_eq!(one.occluded(&ray), blocked, "{what}");
                let (hit, cost) =
                    at_level!(level, |simd| cost::counted(simd, &scene, &bvh, &mut stack, &ray));
                assert_eq!((bits(&hit), cost), (bits(&expected), expected_cost), "{what}");
            }
            rays += 1;
            hits += u32::from(expected.is_hit());
        }
    }
    // The rays are aimed at the scenes.
    assert!(hits > rays / 4 && hits < rays, "{hits} of {rays}");
}

/// All classic materials on spheres and on a grid of triangles that share edges and lie along axes, half of them with
/// vertex normals. One light is in the plane of the grid. If `colored`, spheres and triangles have colours of their own.
fn all_materials(random: &mut Random, colored: bool) -> Scene {
    let mut builder = SceneBuilder::new();
    builder.add_light(Vec3::new(0.5, -2.0, 3.0), 0.7).unwrap();
    builder.add_light(Vec3::new(3.0, 0.25, 0.0), 0.4).unwrap();
    let above = Vec3::new(-0.5, 0.0, 2.0);
    builder.add_sphere_light(above, 0.75, 0.3, [1.0; 3]).unwrap();
    builder.set_ambient_reach(Some(1.0)).unwrap();
    for i in 0..4 {
        let material = builder.classic_material(i).unwrap();
        for _ in 0..3 {
            let radius = 0.05 + 0.2 * random.unit();
            let center = random.in_cube();
            let spheres = SphereCloud {
                x: vec![center.x],
                y: vec![center.y],
                z: vec![center.z],
                radius: vec![radius],
                colors: colors(random, usize::from(colored)),
            };
            builder.add_spheres(spheres, material).unwrap();
        }
        // A strip of the plane z = 0, and one that stands on it.
        for upright in [false, true] {
            let at = |x: f32, y: f32| {
                if upright {
                    Vec3::new(x, i as f32 * 0.5 - 1.0, y)
                } else {
                    Vec3::new(x, i as f32 * 0.5 - 1.0 + y, 0.0)
                }
            };
            let corners: Vec<Vec3> = (0..10)
                .map(|c| at((c / 2) as f32 * 0.5 - 1.0, (c % 2) as f32 * 0.5))
                .collect();
            let mesh = TriangleMesh {
                x: corners.iter().map(|c| c.x).collect(),
                y: corners.iter().map(|c| c.y).collect(),
                z: corners.iter().map(|c| c.z).collect(),
                normals: if upright {
                    corners.iter().map(|_| random.in_cube().normalize()).collect()
                } else {
                    Vec::new()
                },
                colors: colors(random, if colored { corners.len() } else { 0 }),
                uvs: Vec::new(),
                tangents: Vec::new(),
                triangles: (0..4)
                    .flat_map(|s| [[2 * s, 2 * s + 1, 2 * s + 3], [2 * s, 2 * s + 3, 2 * s + 2]])
                    .collect(),
            };
            builder.add_mesh(mesh, material).unwrap();
        }
    }
    builder.finish()
}

fn colors(random: &mut Random, count: usize) -> Vec<[f32; 3]> {
    (0..count).map(|_| [(); 3].map(|()| random.unit())).collect()
}

#[test]
fn every_level_computes_the_same_colours() {
    let limits = Limits {
        transparent: false,
        medium: None,
        max_depth: 5,
        shadows: true,
    };
    let mut traced = SecondaryRays::default();
    for seed in 0..10 {
        let mut random = Random::new(seed, 1);
        let scene = all_materials(&mut random, seed % 2 == 1);
        let bvh = Bvh::build(&scene);
        let mut all = all(&scene, &bvh);
        for i in 0..200 {
            let ray = rays::ray(&mut random, &scene);
            let sample = PixelSample {
                pixel: [seed as u32, 7],
                number: i,
                count: 200,
                ..PixelSample::default()
            };
            let mut expected = None;
            for one in &mut all {
                let mut rays = SecondaryRays::default();
                let (color, _) = radiance_at(one.level, &scene, one, (ray, sample), limits, &mut rays);
                let found = (color.map(f32::to_bits), rays);
                assert!(color.iter().all(|c| c.is_finite()), "{ray:?}: {color:?}");
                assert_eq!(found, *expected.get_or_insert(found), "seed {seed}, {ray:?}");
            }
            if let Some((_, rays)) = expected {
                traced.shadow += rays.shadow;
                traced.ambient += rays.ambient;
                traced.reflection += rays.reflection;
            }
        }
    }
    let least = traced.shadow.min(traced.ambient).min(traced.reflection);
    assert!(least > 200, "{traced:?}");
}

//! Instances: hits and pictures are those of a mesh that is stored where it stands; packets, scalar code and brute force
//! agree bit for bit; what an instance takes in memory; what the builder refuses.
//! `OCTRAY_LONG=1` makes larger pictures.

use crate::{
    long::rounds,
    sameness::{Sameness, sized},
};
use glam::{DVec3, Vec3};
use octray::{
    Level,
    accel::{BuildQuality, Bvh, Layout},
    lanes::{F32x8, LANES},
    ray::{HitPacket, InstanceId, Ray, RayPackets, SceneHit},
    reference::{
        brute,
        shade::{Intersect, PixelSample, SecondaryRays, radiance},
    },
    render::{Film, Pattern, Renderer, Settings, render},
    scene::{
        Camera, Checker, CutOut, Image, Lens, Light, LightShape, Material, MaterialId, Projection,
        PrototypeId, Scene, SceneBuilder, SphereCloud, SurfaceTextures, Texture, Transform, TriangleMesh,
        View,
    },
    trace::{Method, Tracer},
    verify::Random,
};
use std::ops::ControlFlow;

/// A closed, bumpy ball of about radius 1, with normals or without.
fn bumpy_ball(has_normals: bool) -> TriangleMesh {
    const ROWS: u32 = 12;
    const COLUMNS: u32 = 17;
    let mut random = fastrand::Rng::with_seed(11);
    let mut points = vec![Vec3::Z, Vec3::NEG_Z];
    for row in 1..ROWS {
        for column in 0..COLUMNS {
            let down = row as f32 / ROWS as f32 * std::f32::consts::PI;
            let around = column as f32 / COLUMNS as f32 * std::f32::consts::TAU;
            let direction = Vec3::new(down.sin() * around.cos(), down.sin() * around.sin(), down.cos());
            points.push(direction * (0.8 + 0.2 * random.f32()));
        }
    }
    let at = |row: u32, column: u32| 2 + (row - 1) * COLUMNS + column % COLUMNS;
    let mut triangles = Vec::new();
    for column in 0..COLUMNS {
        triangles.push([0, at(1, column), at(1, column + 1)]);
        triangles.push([1, at(ROWS - 1, column + 1), at(ROWS - 1, column)]);
        for row in 1..ROWS - 1 {
            let [a, b] = [at(row, column), at(row, column + 1)];
            let [c, d] = [at(row + 1, column), at(row + 1, column + 1)];
            triangles.extend([[a, c, d], [a, d, b]]);
        }
    }
    TriangleMesh {
        x: points.iter().map(|p| p.x).collect(),
        y: points.iter().map(|p| p.y).collect(),
        z: points.iter().map(|p| p.z).collect(),
        normals: if has_normals {
            points.iter().map(|p| p.normalize()).collect()
        } else {
            Vec::new()
        },
        triangles,
        ..TriangleMesh::default()
    }
}

/// Adds a mesh as a prototype.
fn stored(builder: &mut SceneBuilder, mesh: TriangleMesh, material: MaterialId) -> PrototypeId {
    let added = builder.add_prototype(|builder| builder.add_mesh(mesh, material));
    added.expect("a prototype")
}

/// The steps that place meshes in these tests: none, turned, moved, mirrored, stretched, and all of them.
fn transforms() -> Vec<(&'static str, Transform)> {
    let none = Transform::IDENTITY;
    let turned = none.then_rotate(DVec3::new(1.0, -2.0, 0.5), 40.0);
    let mirrored = turned.then_scale(DVec3::new(-1.0, 1.0, 1.0));
    let stretched = mirrored
        .then_scale(DVec3::new(0.3, 1.0, 1.7))
        .then_rotate(DVec3::Y, 70.0);
    let moved = stretched.then_translate(DVec3::new(0.7, -0.3, 0.2));
    vec![
        ("identity", none),
        ("moved", none.then_translate(DVec3::new(0.3, 0.2, -0.4))),
        ("turned", turned),
        ("mirrored", mirrored),
        ("stretched", stretched),
        ("all", moved),
    ]
}

/// A ball of two lights, stored where it stands, or placed there.
fn ball_scene(transform: &Transform, has_normals: bool, is_instance: bool) -> Scene {
    let mut builder = SceneBuilder::new();
    builder.set_smooth_shadows(has_normals);
    builder.add_light(Vec3::new(3.0, -4.0, 5.0), 0.6).unwrap();
    builder.add_light(Vec3::new(-4.0, -1.0, 2.0), 0.3).unwrap();
    let matte = Material::Matte {
        color: [0.9, 0.7, 0.5],
    };
    let matte = builder.add_material(matte).unwrap();
    let mut mesh = bumpy_ball(has_normals);
    if is_instance {
        let prototype = stored(&mut builder, mesh, matte);
        builder.add_instance(prototype, transform).unwrap();
    } else {
        transform.apply(&mut mesh);
        builder.add_mesh(mesh, matte).unwrap();
    }
    builder.finish()
}

/// A ray from outside the balls towards them.
fn ray_inwards(random: &mut Random) -> Ray {
    let from = loop {
        let from = random.in_cube();
        if from.length() > 0.1 {
            break from.normalize() * 4.0;
        }
    };
    Ray::new(from, (random.in_cube() * 1.3 - from).normalize())
}

#[test]
fn hits_are_those_of_the_mesh_in_place() {
    for (name, transform) in transforms() {
        let [placed, instanced] = [false, true].map(|is| ball_scene(&transform, false, is));
        let mut random = Random::new(3, 1);
        let (mut hits, mut others) = (0, 0);
        for _ in 0..3000 {
            let mut ray = ray_inwards(&mut random);
            let expected = brute::closest_hit(&placed, &ray);
            ray.origin += placed.origin() - instanced.origin();
            let found = brute::closest_hit(&instanced, &ray);
            let instance = if found.is_hit() {
                InstanceId(0)
            } else {
                InstanceId::NONE
            };
            assert_eq!(found.instance, instance, "{name}");
            if !expected.is_hit() || found.primitive != expected.primitive {
                others += u32::from(found.primitive != expected.primitive);
                continue;
            }
            hits += 1;
            let [a, b, c] = placed.triangle(expected.primitive.0 as usize);
            let facing = (b - a).cross(c - a).normalize().dot(ray.direction).abs();
            let off = (found.t - expected.t).abs() * facing.min(0.5) * 2.0;
            assert!(off <= 1e-5, "{name}: {} and {}", found.t, expected.t);
        }
        // At edges, where rounding decides.
        assert!(hits > 500 && others <= 3, "{name}: {hits} hits, {others} others");
    }
}

#[test]
fn pictures_are_those_of_the_mesh_in_place() {
    let camera = Camera::look_at(DVec3::new(2.0, -4.0, 1.5), DVec3::ZERO, DVec3::Z, 40.0).unwrap();
    for (name, transform) in transforms() {
        for has_normals in [false, true] {
            let [placed, instanced] = [false, true].map(|is| {
                let scene = ball_scene(&transform, has_normals, is);
                film(&scene, &camera, &sized(160, 160, 1))
            });
            // Normals are interpolated before the instance is stretched, and those of the mesh in place behind it.
            let is_stretched = matches!(name, "stretched" | "all");
            let tolerance = if has_normals && is_stretched { 0.1 } else { 0.002 };
            let pairs = placed.pixels().iter().zip(instanced.pixels());
            let different = pairs.filter(|(a, b)| (a[0] - b[0]).abs() > tolerance).count();
            // At outlines and the edges of shadows rounding decides.
            assert!(
                different <= 160 * 160 / 1000,
                "{name}, normals: {has_normals}: {different} pixels differ"
            );
        }
    }
}

fn film(scene: &Scene, camera: &Camera, settings: &Settings) -> Film {
    let frame = render(scene, &Bvh::build(scene), camera, settings, &|_| {
        ControlFlow::Continue(())
    });
    frame.expect("a small picture").film
}

/// A square whose texture cuts out most of it, and glows.
fn leaf(builder: &mut SceneBuilder) -> (TriangleMesh, MaterialId) {
    let pixels = (0..64).map(|i: u32| {
        let is_there = (i / 8 + i % 8).is_multiple_of(3);
        [30, 200, 90, if is_there { 255 } else { 0 }]
    });
    let image = Image::new([8, 8], pixels.collect()).unwrap();
    let texture = Texture {
        image: builder.add_image(image).unwrap(),
        ..Texture::default()
    };
    let textures = SurfaceTextures {
        base: Some(texture),
        cut_out: Some(CutOut {
            texture,
            channel: 3,
            limit: 0.5,
        }),
        emission: [0.0, 0.1, 0.0],
        ..SurfaceTextures::NONE
    };
    let matte = Material::Matte { color: [1.0; 3] };
    let material = builder.add_textured_material(matte, textures).unwrap();
    let mesh = TriangleMesh {
        x: vec![-1.0, 1.0, 1.0, -1.0],
        y: vec![-1.0, -1.0, 1.0, 1.0],
        z: vec![0.0, 0.1, 0.0, 0.1],
        uvs: vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..TriangleMesh::default()
    };
    (mesh, material)
}

/// A cloud of coloured spheres, some of them equal.
fn cloud() -> SphereCloud {
    let mut random = fastrand::Rng::with_seed(8);
    let points: Vec<[f32; 3]> = (0..30)
        .map(|_| [(); 3].map(|()| (random.f32() * 8.0).floor() / 4.0 - 1.0))
        .collect();
    SphereCloud {
        x: points.iter().map(|p| p[0]).collect(),
        y: points.iter().map(|p| p[1]).collect(),
        z: points.iter().map(|p| p[2]).collect(),
        radius: vec![0.2; 30],
        colors: points.iter().map(|p| p.map(|x| 0.5 * x + 0.5)).collect(),
    }
}

fn lights(builder: &mut SceneBuilder, shift: Vec3) {
    builder
        .add_light(shift + Vec3::new(-2.0, -3.0, 4.0), 0.3)
        .unwrap();
    builder
        .add_sphere_light(shift + Vec3::new(3.0, -4.0, 6.0), 0.5, 0.4, [1.0, 0.9, 0.8])
        .unwrap();
    let sun = LightShape::directional(DVec3::new(1.0, -2.0, 3.0), 9.0).unwrap();
    let sun = Light {
        intensity: 0.2,
        ..Light::new(sun)
    };
    builder.add(sun).unwrap();
    builder.set_ambient_reach(Some(1.0)).unwrap();
}

/// Instances of triangles, coloured spheres, cut-outs, glass and mirrors, turned, mirrored, stretched and on top of each
/// other, around a mesh and spheres of no instance that some of them repeat, on a checkered plane.
pub fn instanced_scene(shift: Vec3, smooth_shadows: bool) -> Scene {
    let mut builder = SceneBuilder::new();
    builder.set_smooth_shadows(smooth_shadows);
    builder.set_ambient_specular(smooth_shadows);
    lights(&mut builder, shift);
    let checker = Some(Checker {
        colors: [[0.9, 0.8, 0.7], [0.2, 0.3, 0.4]],
        size: 0.5,
    });
    let textures = SurfaceTextures {
        checker,
        ..SurfaceTextures::NONE
    };
    let matte = Material::Matte { color: [1.0; 3] };
    let ground = builder.add_textured_material(matte, textures).unwrap();
    let [shiny, mirror] = [2, 3].map(|number| builder.classic_material(number).unwrap());
    let glass = builder.add_material(Material::GLASS).unwrap();
    let (leaf, leaf_material) = leaf(&mut builder);
    let spheres = cloud();
    let prototypes = [
        stored(&mut builder, bumpy_ball(true), shiny),
        stored(&mut builder, bumpy_ball(false), glass),
        stored(&mut builder, bumpy_ball(false), mirror),
        stored(&mut builder, bumpy_ball(false), ground),
        stored(&mut builder, leaf, leaf_material),
        (builder.add_prototype(|builder| builder.add_spheres(spheres, shiny))).unwrap(),
        (builder.add_prototype(|builder| {
            builder.add_sphere(Vec3::X, 0.7, glass)?;
            builder.add_triangle([Vec3::ZERO, Vec3::Y, Vec3::Z], shiny)
        }))
        .unwrap(),
        builder.add_prototype(|_| Ok(())).unwrap(),
    ];
    let mut random = Random::new(17, 2);
    for i in 0..40 {
        let factors = if i % 3 == 0 {
            DVec3::new(0.2, -0.3, 0.5)
        } else {
            DVec3::splat(0.1 + 0.3 * f64::from(random.unit()))
        };
        let placed = Transform::IDENTITY
            .then_scale(factors)
            .then_rotate(random.in_cube().as_dvec3(), 360.0 * f64::from(random.unit()))
            .then_translate((shift + random.in_cube() * 1.5 + Vec3::Z).as_dvec3());
        builder.add_instance(prototypes[i % 8], &placed).unwrap();
        if i % 4 == 0 {
            // On top of it, one of the same and one of another.
            builder
                .add_instance(prototypes[(i + i % 8) % 8], &placed)
                .unwrap();
        }
    }
    let here = Transform::IDENTITY.then_translate(shift.as_dvec3());
    let mut ball = bumpy_ball(true);
    here.apply(&mut ball);
    builder.add_mesh(ball, mirror).unwrap();
    builder.add_instance(prototypes[0], &here).unwrap();
    builder.add_sphere(shift + Vec3::X, 0.7, shiny).unwrap();
    builder.add_instance(prototypes[6], &here).unwrap();
    builder
        .add_plane(shift + Vec3::Z * -0.5, Vec3::new(0.1, 0.0, 1.0), ground)
        .unwrap();
    builder.add_plane(shift, Vec3::X, glass).unwrap();
    builder.finish()
}

#[test]
fn scenes_of_instances() {
    for (name, shift, smooth_shadows) in [
        ("instances", Vec3::ZERO, false),
        ("instances with smooth shadows", Vec3::ZERO, true),
        ("far instances", Vec3::new(5000.0, -3000.0, 700.0), true),
    ] {
        let scene = instanced_scene(shift, smooth_shadows);
        let sameness = Sameness::of(name, &scene);
        let view = View::classic(2).expect("views are 1 to 6");
        let view = View {
            eye: view.eye + shift.as_dvec3(),
            target: view.target + shift.as_dvec3(),
            ..view
        };
        let lens = Lens {
            aperture: 0.1,
            focus: None,
        };
        let parallel = View {
            projection: Projection::Orthographic { height: 3.0 },
            ..view
        };
        for (view, samples, max_depth) in [(view, 1, 5), (View { lens, ..view }, 4, 3), (parallel, 1, 1)] {
            let camera = Camera::new(&view).expect("a view");
            let settings = Settings {
                max_depth,
                ..sized(rounds(45, 89), rounds(31, 61), samples)
            };
            sameness.check(&camera, &settings);
            let settings = Settings {
                adaptive: true,
                pattern: Pattern::Sobol,
                ..sized(rounds(33, 49), rounds(25, 37), 9)
            };
            sameness.check(&camera, &settings);
        }
    }
}

#[test]
fn output_variables_are_those_of_both_modes() {
    let scene = instanced_scene(Vec3::ZERO, false);
    let bvh = Bvh::build(&scene);
    let camera = Camera::classic_view(1).expect("views are 1 to 6");
    let [packet, scalar] = [octray::render::Mode::Packet, octray::render::Mode::Scalar].map(|mode| {
        let settings = Settings {
            mode,
            ..sized(64, 48, 1)
        };
        let aovs =
            Renderer::new(&scene, &bvh).aovs(&camera, &settings, false, &|_| ControlFlow::Continue(()));
        aovs.expect("AOVs").pixels
    });
    assert_eq!(packet, scalar);
}

/// Every primitive of every instance is tested.
struct Brute<'a>(&'a Scene);

impl Intersect for Brute<'_> {
    fn closest_hit(&mut self, ray: &Ray) -> SceneHit {
        brute::closest_hit(self.0, ray)
    }

    fn opaque_hit(&mut self, ray: &Ray) -> SceneHit {
        brute::opaque_hit(self.0, ray)
    }

    fn occluded(&mut self, ray: &Ray) -> bool {
        brute::occluded(self.0, ray)
    }
}

#[test]
fn brute_force_makes_the_same_picture() {
    let camera = Camera::classic_view(2).expect("views are 1 to 6");
    brute_force_agrees(&instanced_scene(Vec3::ZERO, true), &camera);
}

/// A small picture is that of brute force.
pub fn brute_force_agrees(scene: &Scene, camera: &Camera) {
    let film = film(scene, camera, &sized(24, 24, 1));
    let rays = camera.pixel_rays(scene, 24, 24, 1);
    for (i, pixel) in film.pixels().iter().enumerate() {
        let [x, y] = [i as u32 % 24, i as u32 / 24];
        let sample = PixelSample {
            pixel: [x, y],
            number: 0,
            count: 1,
            cone: rays.cone(),
        };
        let (ray, depth) = (rays.ray(x, y, [0, 0]), Settings::default().max_depth);
        let mut counts = SecondaryRays::default();
        let expected = radiance(scene, &mut Brute(scene), ray, sample, depth, true, &mut counts);
        assert_eq!(pixel.map(f32::to_bits), expected.map(f32::to_bits), "{x} {y}");
    }
}

/// Closest hits and occlusion of a packet's rays.
type Found = [(SceneHit, bool); LANES];

fn brute_hits(scene: &Scene, rays: &[Ray; LANES]) -> Found {
    rays.map(|ray| (brute::closest_hit(scene, &ray), brute::occluded(scene, &ray)))
}

/// Compares them with what brute force finds.
fn compare_packet(name: &str, tracer: &mut Tracer<'_>, rays: &[Ray; LANES], expected: &Found) {
    let mut packets = RayPackets::default();
    packets.restart(None);
    packets.push_rays(rays);
    let mut hits = vec![HitPacket::miss(F32x8::ZERO)];
    tracer.closest_hit(packets.origins(), packets.packets(), &mut hits);
    let mut blocked = vec![0_u8];
    tracer.occluded(packets.origins(), packets.packets(), &mut blocked);
    for (lane, (ray, (expected, is_blocked))) in rays.iter().zip(expected).enumerate() {
        let found = tracer.scene_hit(&hits, 0, lane);
        let numbers = |hit: &SceneHit| [hit.t, hit.u, hit.v].map(f32::to_bits);
        let bits = |hit| (numbers(hit), hit.primitive, hit.instance);
        let what = format!("{name}: {ray:?}: {found:?}, {expected:?}");
        assert_eq!(bits(&found), bits(expected), "{what}");
        assert_eq!(blocked[0] >> lane & 1 == 1, *is_blocked, "{name}: {ray:?}");
    }
}

#[test]
fn every_level_finds_the_hits_of_brute_force() {
    let scene = instanced_scene(Vec3::new(5000.0, -3000.0, 700.0), false);
    let mut random = Random::new(29, 3);
    let packets = [(); 60].map(|()| {
        let rays = std::array::from_fn(|_| {
            let mut ray = ray_inwards(&mut random);
            ray.t_max = random.pick(&[octray::ray::T_MAX, 3.0, 4.0, 0.0]);
            ray
        });
        (rays, brute_hits(&scene, &rays))
    });
    for layout in [Layout::Whole, Layout::Indexed] {
        let bvh = Bvh::build_as(&scene, BuildQuality::Best, layout);
        for level in Level::all() {
            for method in [Method::Adaptive, Method::Packet, Method::Single] {
                let mut tracer = Tracer::with_method(&bvh, method).at_level(level).of_scene(&scene);
                for (rays, expected) in &packets {
                    compare_packet(&format!("{level}, {method:?}"), &mut tracer, rays, expected);
                }
            }
        }
    }
}

#[test]
fn the_first_of_coincident_instances_wins() {
    let mut builder = SceneBuilder::new();
    let matte = builder.classic_material(1).unwrap();
    let first = stored(&mut builder, bumpy_ball(false), matte);
    let second = stored(&mut builder, bumpy_ball(false), matte);
    let placed = Transform::IDENTITY.then_rotate(DVec3::ONE, 25.0);
    // The prototype that is stored last is placed first.
    for prototype in [second, first, second] {
        builder.add_instance(prototype, &placed).unwrap();
    }
    let scene = builder.finish();
    let bvh = Bvh::build(&scene);
    let mut tracer = Tracer::new(&bvh).with_instances(&scene);
    let mut random = Random::new(5, 5);
    let (triangles, mut hits) = (&scene.prototypes()[second.0 as usize].triangles, 0);
    for _ in 0..200 {
        let rays = std::array::from_fn(|_| ray_inwards(&mut random));
        let expected = brute_hits(&scene, &rays);
        compare_packet("coincident", &mut tracer, &rays, &expected);
        for (hit, _) in expected {
            if hit.is_hit() {
                hits += 1;
                assert_eq!(hit.instance, InstanceId(0));
                assert!(triangles.contains(&hit.primitive.0));
            }
        }
    }
    assert!(hits > 500, "{hits}");
}

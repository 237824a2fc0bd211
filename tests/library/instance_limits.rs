//! Instances at their limits: sizes and places without acne or leaks, what they take in memory, and what the builder
//! refuses.

use crate::sameness::sized;
use glam::{DVec3, Vec3};
use octray::{
    accel::Bvh,
    error::SceneError,
    format::load_from_bytes,
    ray::{InstanceId, Ray},
    reference::brute,
    render::{Film, render},
    scene::{
        Background, Camera, Material, MaterialId, Motion, PrototypeId, Scene, SceneBuilder, Step, Transform,
        TriangleMesh,
    },
    verify::Random,
};
use std::{ops::ControlFlow, path::Path};

/// The cube whose sides are `2 * half` long.
fn cube(middle: Vec3, half: f32) -> TriangleMesh {
    let sides = [
        [0, 1, 3, 2],
        [4, 6, 7, 5],
        [0, 4, 5, 1],
        [2, 3, 7, 6],
        [0, 2, 6, 4],
        [1, 5, 7, 3],
    ];
    let column = |axis: u32| {
        (0..8_u32).map(move |i| middle[axis as usize] + half * ((i >> axis & 1) as f32 * 2.0 - 1.0))
    };
    TriangleMesh {
        x: column(0).collect(),
        y: column(1).collect(),
        z: column(2).collect(),
        triangles: sides
            .into_iter()
            .flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]])
            .collect(),
        ..TriangleMesh::default()
    }
}

/// An octahedron whose sides are divided `steps` times, blown up to a ball of this radius.
fn ball(middle: Vec3, radius: f32, steps: u32) -> TriangleMesh {
    let mut corners: Vec<[Vec3; 3]> = (0..8)
        .map(|i: u32| {
            let sign = |axis: u32| (i >> axis & 1) as f32 * 2.0 - 1.0;
            [Vec3::X * sign(0), Vec3::Y * sign(1), Vec3::Z * sign(2)]
        })
        .collect();
    for _ in 0..steps {
        let divided = corners.into_iter().flat_map(|[a, b, c]| {
            let [ab, bc, ca] = [(a + b).normalize(), (b + c).normalize(), (c + a).normalize()];
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        });
        corners = divided.collect();
    }
    let points = || corners.as_flattened().iter().map(|&p| middle + p * radius);
    TriangleMesh {
        x: points().map(|p| p.x).collect(),
        y: points().map(|p| p.y).collect(),
        z: points().map(|p| p.z).collect(),
        triangles: (0..corners.len() as u32)
            .map(|t| [0, 1, 2].map(|i| 3 * t + i))
            .collect(),
        ..TriangleMesh::default()
    }
}

fn stored(builder: &mut SceneBuilder, mesh: TriangleMesh, material: MaterialId) -> PrototypeId {
    let added = builder.add_prototype(|builder| builder.add_mesh(mesh, material));
    added.expect("a prototype")
}

fn film(scene: &Scene, camera: &Camera) -> Film {
    let frame = render(scene, &Bvh::build(scene), camera, &sized(64, 64, 1), &|_| {
        ControlFlow::Continue(())
    });
    frame.expect("a small picture").film
}

/// A stored mesh's size and middle, what it is scaled by, and how far away it is placed, in units of its size there.
#[derive(Clone, Copy, Debug)]
struct Place {
    size: f32,
    middle: Vec3,
    scale: f64,
    far: f64,
}

const fn place(size: f32, scale: f64, far: f64) -> Place {
    Place {
        size,
        middle: Vec3::ZERO,
        scale,
        far,
    }
}

const PLACES: [Place; 12] = [
    place(1.0, 1.0, 0.0),
    place(1.0, 1e-6, 0.0),
    place(1.0, 1e-3, 0.0),
    place(1.0, 1e3, 0.0),
    place(1.0, 1e6, 0.0),
    place(1.0, 1.0, 1e6),
    place(1.0, 1e-3, 1e5),
    place(1.0, 1e3, 1e3),
    // Nanometres.
    place(1e9, 1e-9, 0.0),
    place(1e9, 1e-9, 1e4),
    place(1e-6, 1e6, 0.0),
    // From the middle of the Earth.
    Place {
        middle: Vec3::new(6e6, -2e6, 1e6),
        ..place(1e3, 1e-3, 0.0)
    },
];

impl Place {
    fn radius(self) -> f64 {
        f64::from(self.size) * self.scale
    }

    /// Where the mesh's middle is placed.
    fn target(self) -> DVec3 {
        DVec3::new(1.0, -0.7, 0.4) * (self.far * self.radius())
    }

    /// Places a mesh with this middle, turned, and enlarged by another factor.
    fn transform(self, middle: Vec3, factor: f64) -> Transform {
        Transform::IDENTITY
            .then_translate(-middle.as_dvec3())
            .then_rotate(DVec3::new(1.0, 2.0, 3.0), 40.0)
            .then_scale(DVec3::splat(self.scale * factor))
            .then_translate(self.target())
    }
}

/// A white ball at `place` and its picture from the light, whose radius is a share of the ball's.
fn ball_seen_from_the_light(place: Place, share: f64) -> Film {
    let (radius, middle) = (place.radius(), place.target());
    let mut builder = SceneBuilder::new();
    builder.set_ambient(0.0).unwrap();
    builder
        .set_background(Background::constant([0.0, 0.0, 1.0]))
        .unwrap();
    let eye = middle + DVec3::new(3.0, -2.0, 1.5) * radius;
    let light = eye.as_vec3();
    builder
        .add_sphere_light(light, (share * radius) as f32, 1.0, [1.0; 3])
        .unwrap();
    let white = builder.add_material(Material::Matte { color: [1.0; 3] }).unwrap();
    let prototype = stored(&mut builder, ball(place.middle, place.size, 3), white);
    builder
        .add_instance(prototype, &place.transform(place.middle, 1.0))
        .unwrap();
    let camera = Camera::look_at(eye, middle, DVec3::Z, 25.0).unwrap();
    film(&builder.finish(), &camera)
}

#[test]
fn convex_meshes_do_not_shadow_themselves() {
    for place in PLACES {
        let [hard, soft] = [0.0, 0.1].map(|share| ball_seen_from_the_light(place, share));
        let (mut lit, mut dark) = (0, 0);
        for (hard, soft) in hard.pixels().iter().zip(soft.pixels()) {
            if hard[2] < 1.0 || hard[0] > 0.0 {
                lit += 1;
                // The light is at the eye, so a side without light is not seen.
                dark += u32::from(hard[0] == 0.0 || hard[0] > 0.1 && soft[0] < 0.01);
            }
        }
        // At the outline, where the light's rounded position decides.
        assert!(
            lit > 1000 && dark <= 2,
            "{place:?}: {dark} of {lit} pixels are dark"
        );
    }
}

#[test]
fn no_light_leaks_out_of_a_closed_instance() {
    for place in PLACES {
        let (radius, middle) = (place.radius(), place.target());
        let mut builder = SceneBuilder::new();
        builder.set_ambient(0.0).unwrap();
        builder.set_background(Background::constant([0.0; 3])).unwrap();
        // Lights in the middle and in a corner of a cube; outside, around it, and a ball around it that is no light.
        let white = builder.add_material(Material::Matte { color: [1.0; 3] }).unwrap();
        let inner = stored(&mut builder, cube(place.middle, place.size), white);
        let outer = stored(&mut builder, ball(Vec3::ZERO, place.size, 2), white);
        builder
            .add_instance(inner, &place.transform(place.middle, 1.0))
            .unwrap();
        builder
            .add_instance(outer, &place.transform(Vec3::ZERO, 20.0))
            .unwrap();
        for inside in [DVec3::new(0.1, -0.2, 0.3), DVec3::new(-0.4, 0.4, 0.3)] {
            let at = (middle + inside * radius).as_vec3();
            builder.add_light(at, 1.0).unwrap();
        }
        let scene = builder.finish();
        let eye = middle + DVec3::new(4.0, -3.0, 2.5) * radius;
        let camera = Camera::look_at(eye, middle, DVec3::Z, 60.0).unwrap();
        for (i, pixel) in film(&scene, &camera).pixels().iter().enumerate() {
            assert_eq!(*pixel, [0.0; 3], "{place:?}: pixel {i}");
        }
        // From within all of it is lit.
        let eye = middle + DVec3::new(0.3, 0.2, -0.1) * radius;
        let camera = Camera::look_at(eye, middle + DVec3::X * radius, DVec3::Z, 60.0).unwrap();
        for (i, pixel) in film(&scene, &camera).pixels().iter().enumerate() {
            assert!(pixel[0] > 0.05, "{place:?}: pixel {i} is {pixel:?}");
        }
    }
}

/// From the middle of each of five instances, which differ in size by twelve powers of ten, its sides are as far as they
/// should be.
#[test]
fn instances_of_all_sizes_in_one_scene() {
    let mut builder = SceneBuilder::new();
    let matte = builder.classic_material(1).unwrap();
    let prototype = stored(&mut builder, cube(Vec3::ZERO, 1.0), matte);
    let sizes = [1e-6, 1e-3, 1.0, 1e3, 1e6];
    let middle_of = |size: f64| DVec3::new(10.0, 0.0, 3.0) * size;
    for size in sizes {
        let placed = Transform::IDENTITY
            .then_scale(DVec3::splat(size))
            .then_translate(middle_of(size));
        builder.add_instance(prototype, &placed).unwrap();
    }
    let scene = builder.finish();
    for (i, size) in (0..).zip(sizes) {
        let middle = middle_of(size).as_vec3() - scene.origin();
        for axis in Vec3::AXES {
            for direction in [axis, -axis] {
                let hit = brute::closest_hit(&scene, &Ray::new(middle, direction));
                assert_eq!(hit.instance, InstanceId(i), "{size} {direction}: {hit:?}");
                let distance = f64::from(hit.t) / size;
                assert!((distance - 1.0).abs() < 1e-5, "{size} {direction}: {hit:?}");
            }
        }
    }
}

#[test]
fn an_instance_takes_a_hundred_bytes() {
    const COUNT: usize = 100_000;
    let bytes = |count: usize| {
        let mut builder = SceneBuilder::new();
        let matte = builder.classic_material(1).unwrap();
        let prototype = stored(&mut builder, cube(Vec3::ZERO, 1.0), matte);
        let mut random = Random::new(1, 1);
        for _ in 0..count {
            let placed = Transform::IDENTITY
                .then_rotate(random.in_cube().as_dvec3(), 90.0)
                .then_translate((random.in_cube() * 300.0).as_dvec3());
            builder.add_instance(prototype, &placed).unwrap();
        }
        let scene = builder.finish();
        assert_eq!(scene.primitive_count(), 12);
        scene.memory_bytes() + Bvh::build(&scene).stats().memory_bytes
    };
    let each = (bytes(COUNT) - bytes(1)) / COUNT;
    assert!(each <= 100, "{each} bytes");
}

#[test]
fn the_builder_refuses_what_cannot_be_traced() {
    let mut builder = SceneBuilder::new();
    let matte = builder.classic_material(1).unwrap();
    let prototype = stored(&mut builder, cube(Vec3::ZERO, 1.0), matte);
    let none = Transform::IDENTITY;
    let flat = [
        none.then_scale(DVec3::new(1.0, 1.0, 0.0)),
        none.then_scale(DVec3::ZERO),
        none.then_rotate(DVec3::ONE, 30.0)
            .then_scale(DVec3::new(1.0, 1.0, 1e-12)),
        Transform::from_rows([[1.0, 2.0, 3.0, 0.0], [2.0, 4.0, 6.0, 0.0], [0.0, 0.0, 1.0, 0.0]]),
        Transform::from_rows([
            [f64::NAN, 0.0, 0.0, 0.0],
            [0.0, 1.0, 0.0, 0.0],
            [0.0, 0.0, 1.0, 0.0],
        ]),
        Transform::from_rows([
            [1.0, 0.0, 0.0, 0.0],
            [0.0, f64::INFINITY, 0.0, 0.0],
            [0.0, 0.0, 1.0, 0.0],
        ]),
    ];
    for transform in flat {
        let error = builder.add_instance(prototype, &transform);
        assert_eq!(error, Err(SceneError::Flat), "{transform:?}");
    }
    let far = [
        none.then_translate(DVec3::X * 2e9),
        none.then_translate(DVec3::new(0.0, f64::NAN, 0.0)),
        none.then_scale(DVec3::splat(1e10)),
    ];
    for transform in far {
        let error = builder.add_instance(prototype, &transform);
        assert!(
            matches!(error, Err(SceneError::NotUsable { .. })),
            "{transform:?}: {error:?}"
        );
    }
    let mut motion = Motion::default();
    motion.add(1.0, vec![Step::Translate(DVec3::ZERO)]).unwrap();
    motion.add(2.0, vec![Step::Translate(DVec3::X * 2e9)]).unwrap();
    assert!(builder.add_moving_instance(prototype, &none, motion).is_err());
    // What was refused is not there.
    assert!(builder.finish().instances().is_empty());
    let mut builder = SceneBuilder::within(10_000);
    let matte = builder.classic_material(1).unwrap();
    let prototype = stored(&mut builder, cube(Vec3::ZERO, 1.0), matte);
    let added = (0..100)
        .filter(|_| builder.add_instance(prototype, &none).is_ok())
        .count();
    assert!(added > 0 && added < 100, "{added}");
    assert_eq!(builder.finish().instances().len(), added);
}

#[test]
fn prototypes_hold_no_prototypes() {
    let mut builder = SceneBuilder::new();
    let matte = builder.classic_material(1).unwrap();
    let outer = builder.add_prototype(|builder| {
        builder.add_sphere(Vec3::X, 1.0, matte)?;
        let inner = builder.add_prototype(|builder| builder.add_sphere(Vec3::ZERO, 1.0, matte));
        inner.map(drop)
    });
    assert_eq!(outer, Err(SceneError::Nested));
    let ball = builder.add_prototype(|builder| builder.add_sphere(Vec3::ZERO, 1.0, matte));
    let ball = ball.expect("a prototype");
    let outer = builder.add_prototype(|builder| builder.add_instance(ball, &Transform::IDENTITY));
    assert_eq!(outer, Err(SceneError::Nested));
}

#[test]
fn a_mesh_that_no_instance_places_is_not_there() {
    let mut builder = SceneBuilder::new();
    let matte = builder.classic_material(1).unwrap();
    let cube = stored(&mut builder, cube(Vec3::ZERO, 1.0), matte);
    let nothing = builder.add_prototype(|_| Ok(())).unwrap();
    let no_area = stored(
        &mut builder,
        TriangleMesh {
            x: vec![0.0, 1.0, 2.0],
            y: vec![0.0; 3],
            z: vec![0.0; 3],
            triangles: vec![[0, 1, 2], [0, 0, 0]],
            ..TriangleMesh::default()
        },
        matte,
    );
    let aside = Transform::IDENTITY.then_translate(DVec3::Y * 5.0);
    for prototype in [nothing, no_area, nothing] {
        builder.add_instance(prototype, &aside).unwrap();
    }
    let scene = builder.finish();
    // An instance of nothing is left out.
    assert_eq!((scene.prototypes().len(), scene.instances().len()), (3, 1));
    let prototype = &scene.prototypes()[cube.0 as usize];
    assert!(!prototype.is_empty() && scene.prototypes()[nothing.0 as usize].is_empty());
    for ray in [
        Ray::new(Vec3::X * 9.0, -Vec3::X),
        Ray::new(Vec3::new(9.0, 5.0, 0.0), -Vec3::X),
        Ray::new(Vec3::ZERO, Vec3::Y),
    ] {
        assert!(!brute::closest_hit(&scene, &ray).is_hit());
        assert!(!brute::occluded(&scene, &ray));
    }
    // Nor has the picture anything but the sky.
    let camera = Camera::look_at(DVec3::new(5.0, -9.0, 3.0), DVec3::ZERO, DVec3::Z, 60.0).unwrap();
    let film = film(&scene, &camera);
    assert!(film.pixels().iter().all(|pixel| *pixel == film.pixels()[0]));
}

/// A mesh is stored once for each material; what comes before `placements` applies to it before they do.
#[test]
fn statements_share_what_they_store() {
    const SCENE: &[u8] = b"material matte
instance a.obj
instance a.obj translate 10 0 0
instance a.obj scale 2 placements \"my trees.txt\" translate 0 0 5
material own
instance a.obj translate 0 10 0
instance empty.obj
";
    let open = &mut |path: &Path| match path.to_str() {
        Some("a.obj") => Ok(b"v 0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 3\n".to_vec()),
        Some("my trees.txt") => Ok(b"3 0 0 # far\n0 -1 0 0  1 0 0 7  0 0 1 0\n".to_vec()),
        Some("empty.obj") => Ok(b"# nothing\n".to_vec()),
        _ => Err(std::io::ErrorKind::NotFound.into()),
    };
    let scene = load_from_bytes(SCENE, Path::new("a.scn"), open).unwrap();
    assert_eq!((scene.prototypes().len(), scene.primitive_count()), (3, 2));
    let bounds: Vec<[Vec3; 2]> = (0..scene.instances().len() as u32)
        .map(|i| scene.instance_bounds(InstanceId(i)))
        .map(|bounds| [bounds.lower, bounds.upper].map(|corner| corner + scene.origin()))
        .collect();
    let expected = [
        [0.0, 0.0, 0.0, 1.0, 1.0, 1.0],
        [10.0, 0.0, 0.0, 11.0, 1.0, 1.0],
        [3.0, 0.0, 5.0, 5.0, 2.0, 7.0],
        [-2.0, 7.0, 5.0, 0.0, 9.0, 7.0],
        [0.0, 10.0, 0.0, 1.0, 11.0, 1.0],
    ];
    assert_eq!(bounds.len(), expected.len());
    for (found, expected) in bounds.iter().zip(expected) {
        for (found, expected) in found.iter().flat_map(Vec3::to_array).zip(expected) {
            assert!((found - expected).abs() < 1e-4, "{bounds:?}");
        }
    }
}

//! Scenes made from bytes, rendered by packets, by scalar code over a BVH and by brute force: the same picture, bit for
//! bit.

use arbitrary::{Result, Unstructured};
use glam::{DVec3, Vec3};
use octray::{
    Level,
    accel::Bvh,
    error::SceneError,
    ray::{Ray, SceneHit},
    reference::{
        brute, medium_at,
        shade::{Intersect, Limits, PixelSample, SecondaryRays, radiance_at},
    },
    render::{Film, Filter, Mode, Pattern, Settings, render},
    scene::{
        Background, Camera, Environment, Lens, Light, LightShape, Material, Opacity, Projection, Scene,
        SceneBuilder, Spot, SurfaceTextures, Transform, TriangleMesh, View,
    },
};
use std::ops::ControlFlow;

const SIDE: u32 = 16;
/// More primitives are slower and find nothing more.
const MOST_PRIMITIVES: usize = 64;

/// A coordinate, mostly on a grid so that some are equal.
fn coordinate(u: &mut Unstructured<'_>) -> Result<f32> {
    Ok(match u.int_in_range(0..=15)? {
        0 => {
            let any = f32::from_bits(u.arbitrary()?);
            if any.abs() <= 1e9 { any } else { 1e9 }
        }
        1 => f32::from(u.arbitrary::<i16>()?) / 256.0,
        2 => f32::from(u.arbitrary::<i8>()?) * 1e4,
        3 => f32::from(u.arbitrary::<i8>()?) * 1e-5,
        _ => f32::from(u.arbitrary::<i8>()?) / 64.0,
    })
}

fn point(u: &mut Unstructured<'_>) -> Result<Vec3> {
    Ok(Vec3::new(coordinate(u)?, coordinate(u)?, coordinate(u)?))
}

fn share(u: &mut Unstructured<'_>) -> Result<f32> {
    Ok(f32::from(u.arbitrary::<u8>()?) / 255.0)
}

fn color(u: &mut Unstructured<'_>) -> Result<[f32; 3]> {
    Ok([share(u)?, share(u)?, share(u)?])
}

fn material(u: &mut Unstructured<'_>) -> Result<Material> {
    Ok(match u.int_in_range(0..=5)? {
        0 => Material::Silhouette { color: color(u)? },
        1 => Material::Matte { color: color(u)? },
        2 => Material::BlinnPhong {
            diffuse: color(u)?,
            specular: color(u)?,
            k_d: share(u)?,
            k_s: share(u)?,
            alpha: u.int_in_range(1..=10_000)?,
        },
        3 => Material::Reflection {
            color: color(u)?,
            mirror_share: share(u)?,
        },
        4 => Material::Glass {
            index: 0.3 + 2.7 * share(u)?,
            tint: color(u)?,
            depth: 0.01 + share(u)?,
        },
        _ => Material::CLASSIC[u.int_in_range(0..=3)?],
    })
}

/// Without a byte of its own, as the opacity.
fn is_one_sided(material: &Material) -> bool {
    match material {
        Material::Silhouette { color } | Material::Matte { color } | Material::Reflection { color, .. } => {
            color[0] > 0.5
        }
        Material::BlinnPhong { diffuse, .. } => diffuse[0] > 0.5,
        Material::Glass { .. } => false,
    }
}

/// Without a byte of its own, so that old inputs keep their meaning.
fn opacity(material: &Material) -> Option<Opacity> {
    match material {
        Material::Silhouette { color: [r, g, b] }
        | Material::Matte { color: [r, g, b] }
        | Material::Reflection { color: [r, g, b], .. }
        | Material::BlinnPhong {
            diffuse: [r, g, b], ..
        } if b > r => Opacity::new(*g, None).map(|opacity| Opacity {
            is_tinted: *r > 0.2,
            ..opacity
        }),
        _ => None,
    }
}

/// A light of any kind, which may be unusable.
fn light(u: &mut Unstructured<'_>) -> Result<Light> {
    let center = point(u)?;
    let shape = match u.int_in_range(0..=3)? {
        0 | 1 => LightShape::Point { position: center },
        2 => LightShape::Rectangle {
            center,
            edges: [point(u)?, point(u)?],
        },
        _ => LightShape::directional(center.as_dvec3(), share(u)? * 20.0)
            .unwrap_or(LightShape::Point { position: center }),
    };
    let spot = Spot::new(point(u)?.as_dvec3(), share(u)? * 40.0, 40.0);
    let (has_spot, has_falloff) = (u.arbitrary()?, u.arbitrary()?);
    Ok(Light {
        intensity: share(u)? * 2.0,
        color: color(u)?,
        falloff: if has_falloff {
            Some(coordinate(u)?.abs())
        } else {
            None
        },
        spot: spot.ok().filter(|_| has_spot),
        ..Light::new(shape)
    })
}

/// Adds lights, materials and primitives until the bytes end. The builder may refuse some.
fn fill(u: &mut Unstructured<'_>, builder: &mut SceneBuilder) -> Result<()> {
    let mut current = builder.classic_material(1).expect("there are four");
    let mut last = [Vec3::ZERO, Vec3::X, Vec3::Y];
    for _ in 0..MOST_PRIMITIVES {
        if u.is_empty() {
            break;
        }
        match u.int_in_range(0..=11)? {
            11 => {
                let _ = builder.add_plane(point(u)?, point(u)?, current);
            }
            10 => {
                let [bottom, top] = [color(u)?, color(u)?];
                let _ = builder.set_environment(Environment::Background(Background { bottom, top }));
            }
            0 => {
                let _ = builder.add(light(u)?);
            }
            1 => {
                let (at, radius) = (point(u)?, coordinate(u)?.abs());
                let _ = builder.add_sphere_light(at, radius, share(u)? * 2.0, color(u)?);
            }
            2 => {
                let material = material(u)?;
                let textures = SurfaceTextures {
                    opacity: opacity(&material),
                    one_sided: is_one_sided(&material),
                    ..SurfaceTextures::NONE
                };
                let added = builder.add_textured_material(material, textures);
                current = added.expect("all numbers are shares");
            }
            3..=5 => {
                let (at, radius) = (point(u)?, coordinate(u)?.abs());
                // Without bytes of their own, so that old inputs keep their meaning.
                if at.y < -1.0 {
                    let add = |builder: &mut SceneBuilder| builder.add_sphere(at, radius, current);
                    place(builder, add, [at, last[0], last[1], last[2]]);
                } else {
                    let _ = builder.add_sphere(at, radius, current);
                }
            }
            6 => {
                // A fan with normals.
                let corners = [point(u)?, point(u)?, point(u)?, point(u)?];
                let mesh = TriangleMesh {
                    x: corners.map(|c| c.x).to_vec(),
                    y: corners.map(|c| c.y).to_vec(),
                    z: corners.map(|c| c.z).to_vec(),
                    normals: vec![point(u)?, point(u)?, point(u)?, Vec3::ZERO],
                    // Without bytes of their own, so that old inputs keep their meaning.
                    colors: if corners[0].x > 0.0 {
                        corners
                            .map(|c| c.to_array().map(|channel| channel.abs().min(1.0)))
                            .to_vec()
                    } else {
                        Vec::new()
                    },
                    uvs: Vec::new(),
                    tangents: Vec::new(),
                    triangles: vec![[0, 1, 2], [0, 2, 3], [3, 2, 0]],
                };
                if corners[1].y > 0.5 {
                    place(builder, |builder| builder.add_mesh(mesh, current), corners);
                } else {
                    let _ = builder.add_mesh(mesh, current);
                }
            }
            // A neighbour across an edge.
            7 => {
                last = [last[1], last[0], point(u)?];
                let _ = builder.add_triangle(last, current);
            }
            _ => {
                last = [point(u)?, point(u)?, point(u)?];
                let _ = builder.add_triangle(last, current);
            }
        }
    }
    Ok(())
}

/// Places what `add` adds where it is, and twice elsewhere: turned about `axis`, scaled and moved.
fn place(
    builder: &mut SceneBuilder,
    add: impl FnOnce(&mut SceneBuilder) -> std::result::Result<(), SceneError>,
    [axis, turn, factors, offset]: [Vec3; 4],
) {
    let Ok(prototype) = builder.add_prototype(add) else {
        return;
    };
    let elsewhere = Transform::IDENTITY
        .then_rotate(axis.as_dvec3(), f64::from(turn.x) * 90.0)
        .then_scale(factors.as_dvec3())
        .then_translate(offset.as_dvec3());
    for transform in [elsewhere, Transform::IDENTITY, elsewhere] {
        // Flat or too far away.
        let _ = builder.add_instance(prototype, &transform);
    }
}

fn view(u: &mut Unstructured<'_>) -> Result<Option<Camera>> {
    if u.ratio(1, 4)? {
        return Ok(Camera::classic_view(u.int_in_range(1..=6)?));
    }
    let (eye, target) = (point(u)?.as_dvec3(), point(u)?.as_dvec3());
    let fov = f64::from(u.int_in_range(1u8..=179)?);
    let up = *u.choose(&[DVec3::Z, DVec3::Y, DVec3::new(0.3, -0.2, 1.0)])?;
    // Without a byte of its own, so that old inputs keep their meaning.
    let projection = if fov > 170.0 {
        Projection::Orthographic { height: fov - 170.0 }
    } else {
        Projection::Perspective { fov_degrees: fov }
    };
    Ok(Camera::new(&View {
        eye,
        target,
        up,
        projection,
        lens: if (90.0..100.0).contains(&fov) {
            Lens {
                aperture: (fov - 90.0) * 0.02,
                focus: None,
            }
        } else {
            Lens::PINHOLE
        },
    })
    .ok())
}

fn settings(u: &mut Unstructured<'_>) -> Result<Settings> {
    let settings = Settings {
        width: SIDE,
        height: SIDE,
        samples: [1, 4][u.int_in_range(0..=1)?],
        pattern: *u.choose(&[Pattern::Grid, Pattern::Grid, Pattern::Stratified, Pattern::Sobol])?,
        filter: *u.choose(&[Filter::Box, Filter::Box, Filter::Tent, Filter::BlackmanHarris])?,
        max_depth: u.int_in_range(1..=6)?,
        shadows: u.ratio(7, 8)?,
        ..Settings::default()
    };
    Ok(Settings {
        // Without a byte of its own, so that old inputs keep their meaning.
        adaptive: settings.pattern == Pattern::Sobol && settings.max_depth.is_multiple_of(2),
        ..settings
    })
}

struct EveryPrimitive<'a>(&'a Scene);

impl Intersect for EveryPrimitive<'_> {
    fn closest_hit(&mut self, ray: &Ray) -> SceneHit {
        brute::closest_hit(self.0, ray)
    }

    fn opaque_hit(&mut self, ray: &Ray) -> SceneHit {
        brute::opaque_hit(self.0, ray)
    }

    fn visible_hit(&mut self, ray: &Ray, only_opaque: bool) -> SceneHit {
        brute::visible_hit(self.0, ray, only_opaque)
    }

    fn occluded(&mut self, ray: &Ray) -> bool {
        brute::occluded(self.0, ray)
    }
}

/// The target; see the module.
pub fn picture(bytes: &[u8]) {
    let mut u = Unstructured::new(bytes);
    let (Ok(Some(camera)), Ok(settings)) = (view(&mut u), settings(&mut u)) else {
        return;
    };
    let mut builder = SceneBuilder::new();
    if let (Ok(bottom), Ok(top), Ok(ambient)) = (color(&mut u), color(&mut u), share(&mut u)) {
        builder
            .set_background(Background { bottom, top })
            .expect("shares");
        builder.set_ambient(ambient).expect("a share");
    }
    if let (Ok(true), Ok(reach)) = (u.ratio(1, 4), coordinate(&mut u)) {
        let _ = builder.set_ambient_reach(Some(reach));
    }
    // By the length, so that bytes keep their meaning.
    builder.set_smooth_shadows(bytes.len() % 2 == 1);
    builder.set_ambient_specular(bytes.len() % 4 == 1);
    // The bytes may end at any point of this.
    let _ = fill(&mut u, &mut builder);
    let scene = builder.finish();
    let bvh = Bvh::build(&scene);
    let film = |mode| -> Film {
        let settings = Settings { mode, ..settings };
        let frame = render(&scene, &bvh, &camera, &settings, &|_| ControlFlow::Continue(()));
        frame.expect("16x16 pixels are within every limit").film
    };
    let (packet, scalar) = (film(Mode::Packet), film(Mode::Scalar));
    same("packets", &packet, "scalar code", &scalar);
    // Brute force has no lens and one ray a pixel.
    let one_ray = settings.samples == 1 && settings.pattern == Pattern::Grid && !camera.has_lens();
    if one_ray && settings.filter == Filter::Box {
        same(
            "packets",
            &packet,
            "every primitive",
            &brute_force(&scene, &camera, &settings),
        );
    }
}

fn brute_force(scene: &Scene, camera: &Camera, settings: &Settings) -> Film {
    let rays = camera.pixel_rays(scene, SIDE, SIDE, 1);
    let view = camera.view();
    let eye = (scene.relative(view.eye), view.target - view.eye);
    let all = &mut EveryPrimitive(scene);
    let medium = medium_at(Level::current(), scene, &mut |ray| all.closest_hit(ray), eye);
    let limits = Limits {
        max_depth: settings.max_depth,
        shadows: settings.shadows,
        transparent: false,
        medium,
    };
    let mut film = Film::new(SIDE, SIDE);
    for (i, pixel) in (0..).zip(film.pixels_mut()) {
        let ray = rays.ray(i % SIDE, i / SIDE, [0, 0]);
        let mut counts = SecondaryRays::default();
        let sample = PixelSample {
            pixel: [i % SIDE, i / SIDE],
            number: 0,
            count: settings.samples,
            cone: rays.cone(),
        };
        (*pixel, _) = radiance_at(Level::current(), scene, all, (ray, sample), limits, &mut counts);
    }
    film
}

fn same(a: &str, ours: &Film, b: &str, theirs: &Film) {
    for (i, (ours, theirs)) in ours.pixels().iter().zip(theirs.pixels()).enumerate() {
        let (x, y) = (i % SIDE as usize, i / SIDE as usize);
        assert_eq!(
            ours.map(f32::to_bits),
            theirs.map(f32::to_bits),
            "pixel {x},{y}: {a} {ours:?}, {b} {theirs:?}"
        );
        assert!(
            ours.iter().all(|channel| channel.is_finite()),
            "pixel {x},{y}: {ours:?}"
        );
    }
}

//! Queries through the public interface, against the tracer on prepared packets: rays per second of the same rays, in
//! turn, on one thread, median of nine. Then single rays, inside tests and closest points.
//!
//! ```text
//! cargo bench --bench queries
//! cargo bench --bench queries -- interior
//! ```

use octray::{
    Geometry, Hit, Ray,
    accel::Bvh,
    bench::{SuiteScene, suite},
    glam::{DVec3, Vec3},
    lanes::{F32x8, LANES},
    query::Rays,
    ray::{HitPacket, RayPackets},
    scene::Scene,
    trace::Tracer,
};
use std::{error::Error, time::Instant};

const ROUNDS: usize = 9;
const SIDE: usize = 1024;

fn main() -> Result<(), Box<dyn Error>> {
    let named: Vec<String> = std::env::args().skip(1).filter(|arg| arg != "--bench").collect();
    println!("{}", octray::bench::machine());
    println!("scene      rays      tracer   slice  arrays f64  slice/tracer   Mrays/s, one thread");
    for scene in suite() {
        if named.is_empty() || named.iter().any(|name| name == scene.name) {
            run(&scene)?;
        }
    }
    Ok(())
}

/// The scene's triangles, world space.
fn geometry_of(scene: &Scene) -> Result<Geometry, Box<dyn Error>> {
    let vertices = scene.vertices();
    let positions: Vec<[f32; 3]> = (0..vertices.x.len())
        .map(|i| (vertices.position(i as u32) + scene.origin()).to_array())
        .collect();
    Ok(Geometry::from_triangles(&positions, &scene.triangles().corners)?)
}

fn run(suite_scene: &SuiteScene) -> Result<(), Box<dyn Error>> {
    let (scene, camera) = suite_scene.make()?;
    if scene.triangles().corners.is_empty() {
        return Ok(());
    }
    let name = suite_scene.name;
    let geometry = geometry_of(&scene)?;
    let rays = camera.pixel_rays(&scene, SIDE as u32, SIDE as u32, 1);
    let camera_rays: Vec<Ray> = (0..SIDE * SIDE)
        .map(|i| {
            // Blocks of 16 pixels, as the renderer has them.
            let (block, in_block) = (i / 256, i % 256);
            let (x, y) = (block % 64 * 16 + in_block % 16, block / 64 * 16 + in_block / 16);
            Ray::new(camera.eye(), rays.direction(x as u32, y as u32, [0; 2]))
        })
        .collect();
    let [lower, upper] = geometry.bounds().ok_or("nothing to hit")?;
    let mut random = oorandom::Rand32::new(7);
    let mut point =
        || lower + (upper - lower) * DVec3::new(part(&mut random), part(&mut random), part(&mut random));
    let random_rays: Vec<Ray> = (0..SIDE * SIDE)
        .map(|_| {
            let (from, to) = (point().as_vec3(), point().as_vec3());
            Ray::new(from, (to - from).normalize_or(Vec3::X))
        })
        .collect();
    let bvh = Bvh::build(&scene);
    rays_a_second(name, "camera", &geometry, &scene, &bvh, &camera_rays);
    let rows: Vec<Ray> = (0..SIDE * SIDE)
        .map(|i| {
            Ray::new(
                camera.eye(),
                rays.direction((i % SIDE) as u32, (i / SIDE) as u32, [0; 2]),
            )
        })
        .collect();
    rays_a_second(name, "rows", &geometry, &scene, &bvh, &rows);
    rays_a_second(name, "random", &geometry, &scene, &bvh, &random_rays);
    let points: Vec<[f64; 3]> = (0..20_000).map(|_| point().to_array()).collect();
    single(name, &geometry, &camera_rays, &random_rays, &points);
    Ok(())
}

fn part(random: &mut oorandom::Rand32) -> f64 {
    f64::from(random.rand_float())
}

fn rays_a_second(name: &str, kind: &str, geometry: &Geometry, scene: &Scene, bvh: &Bvh, rays: &[Ray]) {
    let is_shared = rays.windows(2).all(|two| two[0].origin == two[1].origin);
    let origin = scene.origin();
    let mut packets = RayPackets::default();
    packets.restart(is_shared.then(|| rays[0].origin - origin));
    for eight in rays.chunks(LANES) {
        packets.push_rays(&std::array::from_fn(|lane| {
            let ray = &eight[lane.min(eight.len() - 1)];
            octray::ray::Ray::new(ray.origin - origin, ray.direction)
        }));
    }
    let origins: Vec<[f64; 3]> = rays.iter().map(|ray| ray.origin.as_dvec3().to_array()).collect();
    let directions: Vec<[f64; 3]> = rays
        .iter()
        .map(|ray| ray.direction.as_dvec3().to_array())
        .collect();
    let (mut tracer, mut worker) = (Tracer::new(bvh), geometry.worker());
    let mut found = vec![HitPacket::miss(F32x8::ZERO); packets.packets().len()];
    let (mut hits, mut again) = (vec![Hit::miss(0.0); rays.len()], vec![Hit::miss(0.0); rays.len()]);
    let mut times = [const { Vec::new() }; 3];
    for _ in 0..ROUNDS {
        let start = Instant::now();
        tracer.closest_hit(packets.origins(), packets.packets(), &mut found);
        times[0].push(start.elapsed().as_secs_f64());
        let start = Instant::now();
        worker.closest_hits(rays, &mut hits);
        times[1].push(start.elapsed().as_secs_f64());
        let start = Instant::now();
        let arrays = Rays::from_arrays(&origins, &directions).expect("as many of each");
        worker.closest_hits(arrays, &mut again);
        times[2].push(start.elapsed().as_secs_f64());
    }
    assert!(hits == again, "arrays and slices are the same rays");
    let [tracer, slice, arrays] = times.map(|times| rays.len() as f64 / median(times) / 1e6);
    let ratio = slice / tracer;
    println!("{name:10} {kind:8} {tracer:7.1} {slice:7.1} {arrays:11.1} {ratio:13.2}");
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// Nanoseconds of one question after the other.
fn single(name: &str, geometry: &Geometry, camera: &[Ray], random: &[Ray], points: &[[f64; 3]]) {
    let each = |count: usize, ask: &dyn Fn()| {
        let times = (0..3).map(|_| {
            let start = Instant::now();
            ask();
            start.elapsed().as_secs_f64()
        });
        median(times.collect()) / count as f64 * 1e9
    };
    let ask = |rays: &[Ray]| {
        std::hint::black_box(
            rays.iter()
                .filter(|ray| geometry.closest_hit(ray).is_some())
                .count(),
        );
    };
    let (camera, random) = (&camera[..200_000], &random[..200_000]);
    println!(
        "{name:10} one by one: camera {:.0} ns, random {:.0} ns, occluded {:.0} ns, all hits {:.0} ns, closest point {:.0} ns, inside {:.0} ns",
        each(camera.len(), &|| ask(camera)),
        each(random.len(), &|| ask(random)),
        each(random.len(), &|| {
            std::hint::black_box(random.iter().filter(|ray| geometry.occluded(ray)).count());
        }),
        each(random.len(), &|| {
            std::hint::black_box(
                random
                    .iter()
                    .map(|ray| geometry.all_hits(ray, None).len())
                    .sum::<usize>(),
            );
        }),
        each(points.len(), &|| {
            std::hint::black_box(points.iter().filter_map(|&at| geometry.closest_point(at)).count());
        }),
        each(points.len(), &|| {
            std::hint::black_box(
                points
                    .iter()
                    .filter(|&&at| geometry.contains(at) == Ok(true))
                    .count(),
            );
        }),
    );
}

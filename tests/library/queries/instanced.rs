//! Queries of placed geometries against brute force: the engine's, bit for bit, and one of `f64` over all placed triangles.

use super::{Mesh, Random, cube, meshes, rays};
use glam::{DVec3, Vec3};
use octray::{
    Geometry, Hit, InstanceId, InstancedGeometry, InstancedHit, Level, PrimitiveId, QueryError, Ray, Rays,
    query::{AllHits, Sphere, unit::UnitRay},
    reference::brute,
    scene::Transform,
};

pub(super) fn geometry((positions, triangles): &Mesh) -> Geometry {
    Geometry::from_triangles(positions, triangles).unwrap()
}

/// Meshes with shared edges, equal triangles and a needle; an empty one; and one with spheres, two of them equal.
pub(super) fn geometries() -> Vec<Geometry> {
    let mut all: Vec<Geometry> = meshes().iter().map(geometry).collect();
    all.insert(1, geometry(&(Vec::new(), Vec::new())));
    let sphere = |x: f64| Sphere {
        center: [x, 0.2, 0.1],
        radius: 0.6,
    };
    let (positions, triangles) = cube(2, |at| at * 0.7);
    all.push(Geometry::new(&positions, &triangles, &[sphere(0.0), sphere(0.5), sphere(0.0)]).unwrap());
    all
}

/// Turned, mirrored, stretched and moved, in a scene of about this size.
fn transform(random: &mut Random, i: usize, size: f64) -> Transform {
    let factors = match i % 4 {
        0 => DVec3::splat(0.4),
        1 => DVec3::new(0.2, -0.5, 0.8),
        2 => DVec3::new(-1.0, -0.02, -0.3),
        _ => random.vector().as_dvec3() + DVec3::new(1.1, 1.2, 1.3),
    };
    let turned = Transform::IDENTITY
        .then_scale(factors * size)
        .then_rotate(random.vector().as_dvec3(), f64::from(random.signed()) * 180.0);
    match i % 5 {
        // Along the axes, and some of them in the same place.
        0 => Transform::IDENTITY.then_scale(DVec3::splat(size)),
        1 => turned,
        _ => turned.then_translate(random.vector().as_dvec3() * (1.5 * size)),
    }
}

fn instances(random: &mut Random, count: usize, size: f64) -> Vec<(usize, Transform)> {
    let placed = |i: usize| (random.0.usize(..5), transform(random, i, size));
    (0..count).map(placed).collect()
}

pub(super) fn all_of(meshes: &[Geometry], instances: &[(usize, Transform)]) -> InstancedGeometry {
    InstancedGeometry::new(&meshes.iter().collect::<Vec<_>>(), instances).unwrap()
}

/// Rays as for one mesh, in a scene of this size.
fn rays_of(random: &mut Random, count: usize, size: f32) -> Vec<Ray> {
    let scaled = |ray: Ray| Ray {
        origin: ray.origin * size,
        t_min: ray.t_min * size,
        t_max: ray.t_max * size,
        ..ray
    };
    let rays = rays(random, &meshes()[0].0, count);
    rays.into_iter().map(scaled).collect()
}

/// The closest hit of a ray without a beginning, one primitive after the other.
fn by_brute_force(
    scene: &InstancedGeometry,
    (meshes, instances): (&[Geometry], &[(usize, Transform)]),
    ray: &Ray,
) -> InstancedHit {
    let unit = UnitRay::new(ray, scene.middle());
    let found = brute::closest_hit(scene.scene(), &unit.ray);
    let t = (f64::from(found.t) / unit.length) as f32;
    if !found.is_hit() || t == f32::INFINITY {
        return InstancedHit::default();
    }
    let stored = scene.scene();
    let kept: Vec<usize> = (0..instances.len())
        .filter(|&i| meshes[instances[i].0].bounds().is_some())
        .collect();
    let i = found.instance.0 as usize;
    let prototype = &stored.prototypes()[stored.instances()[i].prototype().0 as usize];
    let all_triangles = stored.triangles().corners.len() as u32;
    let id = found.primitive.0;
    let primitive = if id < all_triangles {
        id - prototype.triangles.start
    } else {
        id - all_triangles - prototype.spheres.start + prototype.triangles.len() as u32
    };
    InstancedHit {
        t,
        u: found.u,
        v: found.v,
        primitive: PrimitiveId(primitive),
        instance: InstanceId(kept[i] as u32),
    }
}

fn is_ordered(hits: &[InstancedHit]) -> bool {
    let key = |hit: &InstancedHit| (hit.t, hit.instance, hit.primitive);
    hits.windows(2).all(|two| key(&two[0]) <= key(&two[1]))
}

#[test]
fn every_query_agrees_with_brute_force_to_the_bit() {
    let mut random = Random::new(31);
    let meshes = geometries();
    for (size, count) in [(1.0, 1), (1.0, 12), (1.0, 60), (1e-7, 20), (1e6, 20)] {
        let instances = instances(&mut random, count, f64::from(size));
        let scene = all_of(&meshes, &instances);
        let rays = rays_of(&mut random, 1200, size);
        let mut closest = vec![InstancedHit::default(); rays.len()];
        let mut occluded = vec![false; rays.len()];
        scene.closest_hits(&rays, &mut closest);
        scene.occluded_each(&rays, &mut occluded);
        let all = scene.all_hits_each(&rays, None);
        let mut found = 0;
        for (i, ray) in rays.iter().enumerate() {
            let first = closest[i].is_hit().then_some(closest[i]);
            found += usize::from(first.is_some());
            assert_eq!(scene.closest_hit(ray), first, "{ray:?}");
            assert_eq!(scene.occluded(ray), first.is_some(), "{ray:?}");
            assert_eq!(occluded[i], first.is_some(), "{ray:?}");
            let hits = all.of_ray(i);
            assert!(is_ordered(hits), "{hits:?}");
            assert_eq!(first.map(|hit| hit.t), hits.first().map(|hit| hit.t), "{ray:?}");
            assert!(first.is_none_or(|hit| hits.contains(&hit)), "{ray:?}");
            for limit in [0, 1, 3, 20] {
                assert_eq!(scene.all_hits(ray, Some(limit)), hits[..hits.len().min(limit)]);
            }
            // The ends of rays cut the hits of the whole line.
            let line = Ray {
                t_min: 0.0,
                t_max: f32::INFINITY,
                ..*ray
            };
            let mut whole = scene.all_hits(&line, None);
            whole.retain(|hit| hit.t > ray.t_min && hit.t < ray.t_max);
            assert_eq!(whole, hits, "{ray:?}");
            for ray in [Ray { t_min: 0.0, ..*ray }, line] {
                let expected = by_brute_force(&scene, (&meshes, &instances), &ray);
                let expected = expected.is_hit().then_some(expected);
                assert_eq!(scene.closest_hit(&ray), expected, "{ray:?}");
            }
        }
        assert!(found > rays.len() / 20, "{size} {count}: {found}");
    }
}

#[test]
fn levels_threads_and_shared_origins_find_the_same_hits() {
    let mut random = Random::new(32);
    let (meshes, origin) = (geometries(), Vec3::new(0.4, -3.0, 0.9));
    let instances = instances(&mut random, 40, 1.0);
    // Neighbours are anywhere, or as in a picture.
    let scattered = (0..9000).map(|_| random.vector() - origin).collect::<Vec<_>>();
    let rows = (0..9000).map(|i| Vec3::new((i % 90) as f32 - 45.0, 60.0, (i / 90) as f32 - 50.0));
    for directions in [scattered, rows.collect()] {
        let scene = all_of(&meshes, &instances);
        let closest = |&direction: &Vec3| scene.closest_hit(&Ray::new(origin, direction));
        let expected: Vec<InstancedHit> = (directions.iter())
            .map(|direction| closest(direction).unwrap_or_default())
            .collect();
        assert!(expected.iter().filter(|hit| hit.is_hit()).count() > 2000);
        let each = vec![origin; directions.len()];
        for level in Level::all() {
            let scene = all_of(&meshes, &instances).at_level(level);
            for origins in [&each[..1], &each] {
                let rays = Rays::from_arrays(origins, &directions).unwrap();
                let mut hits = vec![InstancedHit::default(); directions.len()];
                scene.worker().closest_hits(rays, &mut hits);
                assert!(hits == expected, "{level}");
                for threads in [1, 3] {
                    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
                    hits.fill(InstancedHit::default());
                    pool.build()
                        .unwrap()
                        .install(|| scene.closest_hits(rays, &mut hits));
                    assert!(hits == expected, "{level}");
                }
                let mut occluded = vec![false; hits.len()];
                scene.occluded_each(rays, &mut occluded);
                assert!(occluded.iter().zip(&hits).all(|(&is, hit)| is == hit.is_hit()));
            }
        }
    }
}

pub(super) type Rows = [[f64; 4]; 3];

pub(super) fn placed(rows: &Rows, [x, y, z]: [f32; 3]) -> DVec3 {
    let [x, y, z] = [x, y, z].map(f64::from);
    DVec3::from(rows.map(|[a, b, c, d]| a * x + b * y + c * z + d))
}

/// Where a line meets a triangle in `f64`: t, and the least barycentric weight.
fn met([origin, direction]: [DVec3; 2], [a, b, c]: [DVec3; 3]) -> Option<(f64, f64)> {
    let (ab, ac) = (b - a, c - a);
    let across = direction.cross(ac);
    let determinant = ab.dot(across);
    let u = (origin - a).dot(across) / determinant;
    let around = (origin - a).cross(ab);
    let v = direction.dot(around) / determinant;
    let t = ac.dot(around) / determinant;
    t.is_finite().then_some((t, u.min(v).min(1.0 - u - v)))
}

/// Matrices that do not flatten much, mirrored or not, `far` from 0.
pub(super) fn matrix(random: &mut Random, far: f64) -> Rows {
    loop {
        let mut rows = [(); 3].map(|()| [(); 4].map(|()| f64::from(random.signed()) + 1e-9));
        let [a, b, c] = rows.map(|[x, y, z, _]| DVec3::new(x, y, z));
        if a.cross(b).dot(c).abs() > 0.3 {
            for row in &mut rows {
                row[3] += far;
            }
            return rows;
        }
    }
}

#[test]
fn hits_are_those_of_triangles_that_are_placed_in_f64() {
    let mut random = Random::new(33);
    let meshes = meshes();
    let stored: Vec<Geometry> = meshes.iter().map(geometry).collect();
    for round in 0..9 {
        let far = [0.0, 2e6, -7e8][round % 3];
        let matrices: Vec<Rows> = (0..6).map(|_| matrix(&mut random, far)).collect();
        let instances = (0..).zip(&matrices);
        let instances: Vec<(usize, Transform)> = instances
            .map(|(i, rows)| (i % 3, Transform::from_rows(*rows)))
            .collect();
        let scene = all_of(&stored, &instances);
        let (mut hits, mut misses) = (0, 0);
        for _ in 0..300 {
            let origin = random.vector().as_dvec3() * 4.0 + far;
            let direction = (random.vector().as_dvec3() * 3.0 + far) - origin;
            let (from, along) = ([origin.to_array()], [direction.to_array()]);
            let mut found = [InstancedHit::default()];
            scene.closest_hits(Rays::from_arrays(&from, &along).unwrap(), &mut found);
            let [found] = found;
            let (mut met_there, mut is_sure) = (Vec::new(), true);
            for (i, (rows, (mesh, _))) in (0..).zip(matrices.iter().zip(&instances)) {
                let (positions, triangles) = &meshes[*mesh];
                for (id, triangle) in (0..).zip(triangles) {
                    let corners = triangle.map(|corner| placed(rows, positions[corner as usize]));
                    let Some((t, least)) = met([origin, direction], corners) else {
                        continue;
                    };
                    is_sure &= t < -1e-3 || least.abs() > 1e-4;
                    if t > 0.0 && least > 0.0 {
                        met_there.push((t, InstanceId(i), PrimitiveId(id)));
                    }
                }
            }
            met_there.sort_by(|a, b| a.partial_cmp(b).unwrap());
            let best = met_there.first();
            // Neither at an edge, nor where two surfaces cross.
            let is_near =
                |other: &&(f64, _, _)| best.is_some_and(|best| other.0 > best.0 && other.0 < best.0 + 1e-4);
            if !is_sure || met_there.iter().any(|other| is_near(&other)) {
                continue;
            }
            let Some(&(t, instance, primitive)) = best else {
                misses += 1;
                assert!(!found.is_hit());
                continue;
            };
            hits += 1;
            assert_eq!((found.instance, found.primitive), (instance, primitive));
            let (rows, (mesh, _)) = (&matrices[instance.0 as usize], &instances[instance.0 as usize]);
            let (positions, triangles) = &meshes[*mesh];
            let [a, b, c] = triangles[primitive.0 as usize].map(|i| placed(rows, positions[i as usize]));
            let normal = (b - a).cross(c - a).normalize();
            let facing = normal.dot(direction).abs();
            let off = (f64::from(found.t) - t).abs() * facing;
            assert!(off < 5e-6, "{far}: {} and {t}", found.t);
            let surface = scene.surface(origin, direction, &found);
            let off = surface.position.distance(origin + direction * t) * facing / direction.length();
            assert!(off < 1e-5, "{far}: {off}");
            assert!(surface.normal.dot(normal).abs() > 1.0 - 1e-9);
        }
        assert!(hits > 100 && misses > 3, "{far}: {hits} {misses}");
    }
}

#[test]
fn placed_where_they_are_meshes_have_the_hits_of_their_geometry() {
    let mut random = Random::new(34);
    for mesh in meshes() {
        let geometry = geometry(&mesh);
        let scene = InstancedGeometry::new(&[&geometry], &[(0, Transform::IDENTITY)]).unwrap();
        assert_eq!(scene.bounds(), geometry.bounds());
        let rays = rays(&mut random, &mesh.0, 2000);
        let (mut one, mut other) = (vec![Hit::default(); 2000], vec![InstancedHit::default(); 2000]);
        geometry.closest_hits(&rays, &mut one);
        scene.closest_hits(&rays, &mut other);
        let mut different = 0;
        for (ray, (one, other)) in rays.iter().zip(one.iter().zip(&other)) {
            if one.primitive == other.primitive {
                let off = (one.t - other.t).abs() * ray.direction.length();
                assert!(!one.is_hit() || off < 1e-5, "{one:?} {other:?}");
            } else {
                // Where a ray meets an edge, or its end, rounding decides.
                different += 1;
            }
        }
        assert!(different < 20, "{different}");
    }
}

#[test]
fn outside_stays_outside() {
    let (positions, triangles) = cube(6, |at| at.normalize());
    let ball = Geometry::from_triangles(&positions, &triangles).unwrap();
    let sphere = Sphere {
        center: [7.0, 8.0, 9.0],
        radius: 2.0,
    };
    let sphere = Geometry::new(&[] as &[[f32; 3]], &[], &[sphere]).unwrap();
    let to_unit = Transform::IDENTITY
        .then_translate(-DVec3::new(7.0, 8.0, 9.0))
        .then_scale(DVec3::splat(0.5));
    let stretched = |mirror: f64| {
        Transform::IDENTITY
            .then_scale(DVec3::new(mirror, 0.5, 2.0))
            .then_translate(DVec3::new(5e5, 1.0, 0.0))
    };
    for mirror in [1.0, -1.0] {
        let scene = InstancedGeometry::new(&[&ball], &[(0, stretched(mirror))]).unwrap();
        let ellipsoid = to_unit.then_transform(&stretched(mirror));
        let exact = InstancedGeometry::new(&[&sphere], &[(0, ellipsoid)]).unwrap();
        let mut random = Random::new(35);
        for _ in 0..500 {
            let origin = random.vector().as_dvec3().normalize() * 5.0 + DVec3::new(5e5, 1.0, 0.0);
            let direction = random.vector().as_dvec3() * 0.2 + DVec3::new(5e5, 1.0, 0.0) - origin;
            let (from, along) = ([origin.to_array()], [direction.to_array()]);
            let rays = Rays::from_arrays(&from, &along).unwrap();
            let (mut hits, all) = ([InstancedHit::default(); 2], exact.all_hits_each(rays, None));
            scene.closest_hits(rays, &mut hits[..1]);
            exact.closest_hits(rays, &mut hits[1..]);
            let [of_ball, of_sphere] = hits;
            assert!((of_ball.t - of_sphere.t).abs() < 0.02);
            assert_eq!(all.hits.len(), 2);
            assert_eq!(all.hits[0], of_sphere);
            for (scene, hit, tolerance) in [(&scene, of_ball, 0.1), (&exact, of_sphere, 1e-6)] {
                let surface = scene.surface(origin, direction, &hit);
                let at = (surface.position - DVec3::new(5e5, 1.0, 0.0)) / DVec3::new(1.0, 0.5, 2.0);
                assert!((at.length() - 1.0).abs() < 0.03 + tolerance, "{at}");
                // The gradient of the ellipsoid.
                let outward = (at / DVec3::new(1.0, 0.5, 2.0)).normalize();
                assert!(
                    surface.normal.dot(outward) > 1.0 - tolerance,
                    "{}",
                    surface.normal
                );
                assert!(surface.normal.dot(direction) < 0.0);
            }
        }
    }
}

#[test]
fn moved_instances_are_those_of_a_new_scene() {
    let mut random = Random::new(36);
    let meshes = geometries();
    let start = instances(&mut random, 30, 1.0);
    let mut scene = all_of(&meshes, &start);
    let rays = rays_of(&mut random, 800, 1.0);
    let hits_of = |scene: &InstancedGeometry| -> AllHits<InstancedHit> { scene.all_hits_each(&rays, None) };
    let before = hits_of(&scene);
    for round in 0..4 {
        let far = DVec3::X * [0.0, 3.0, 5e4, 0.0][round];
        let moved: Vec<(usize, Transform)> = (start.iter().enumerate())
            .map(|(i, &(mesh, _))| (mesh, transform(&mut random, i, 1.1).then_translate(far)))
            .collect();
        let transforms: Vec<Transform> = moved.iter().map(|instance| instance.1).collect();
        let (old, copy) = (hits_of(&scene), scene.moved(&transforms).unwrap());
        assert_eq!(hits_of(&scene), old);
        scene.move_instances(&transforms).unwrap();
        let new = all_of(&meshes, &moved);
        assert_eq!(hits_of(&scene), hits_of(&new));
        assert_eq!(hits_of(&copy), hits_of(&new));
        assert_eq!((scene.bounds(), scene.middle()), (new.bounds(), new.middle()));
        // What is refused changes nothing.
        let mut wrong = transforms.clone();
        let last = (0..30).rfind(|&i| meshes[start[i].0].bounds().is_some()).unwrap();
        wrong[last] = Transform::IDENTITY.then_translate(DVec3::X * 3e9);
        let error = scene.move_instances(&wrong).unwrap_err();
        assert!(matches!(error, QueryError::Coordinate { index, .. } if index == last));
        let short = scene.move_instances(&transforms[1..]);
        assert!(matches!(short, Err(QueryError::Length { found: 29, .. })));
        assert_eq!(hits_of(&scene), hits_of(&new));
    }
    let back: Vec<Transform> = start.iter().map(|instance| instance.1).collect();
    scene.move_instances(&back).unwrap();
    assert_eq!(hits_of(&scene), before);
}

#[test]
fn what_cannot_be_placed_is_refused_by_its_index() {
    let [ball, nothing] = [cube(2, |at| at), (Vec::new(), Vec::new())].map(|mesh| geometry(&mesh));
    let (here, meshes) = (Transform::IDENTITY, [&nothing, &ball]);
    let refused = |transform: Transform| {
        let instances = [(0, here), (1, here), (1, transform), (0, here), (1, transform)];
        let mut scene = InstancedGeometry::new(&meshes, &instances.map(|(mesh, _)| (mesh, here))).unwrap();
        let error = InstancedGeometry::new(&meshes, &instances).unwrap_err();
        assert_eq!(
            scene.move_instances(&instances.map(|instance| instance.1)),
            Err(error.clone())
        );
        error
    };
    let flat = QueryError::Flat { instance: 2 };
    assert_eq!(refused(here.then_scale(DVec3::new(1.0, 0.0, 1.0))), flat);
    assert_eq!(refused(here.then_scale(DVec3::splat(1e-60))), flat);
    for number in [f64::NAN, f64::INFINITY] {
        let error = refused(here.then_translate(DVec3::Y * number));
        assert_eq!(error, QueryError::NotFinite { instance: 2 });
    }
    for far in [2e9, 1e300] {
        let expected = QueryError::Coordinate {
            what: "instance",
            index: 2,
            value: far + 1.0,
        };
        assert_eq!(refused(here.then_translate(DVec3::Y * far)), expected);
    }
    let error = InstancedGeometry::new(&meshes, &[(1, here), (2, here)]).unwrap_err();
    let expected = QueryError::MeshIndex {
        instance: 1,
        index: 2,
        meshes: 2,
    };
    assert_eq!(error, expected);
    let many = vec![&nothing; (1 << 16) + 1];
    assert!(matches!(
        InstancedGeometry::new(&many, &[]),
        Err(QueryError::TooMany { what: "meshes", .. })
    ));
}

#[test]
fn nothing_is_hit_where_nothing_is() {
    let nothing = geometry(&(Vec::new(), Vec::new()));
    let flat = geometry(&(vec![[0.0; 3], [1.0, 0.0, 0.0]], vec![[0, 1, 1]]));
    let here = Transform::IDENTITY;
    let ray = Ray::new([0.2, 0.0, 1.0], [0.0, 0.0, -1.0]);
    let instances = [
        &[][..],
        &[(0, here)],
        &[(1, here), (0, here.then_scale(DVec3::ZERO)), (1, here)],
    ];
    for (i, instances) in instances.into_iter().enumerate() {
        let mut scene = InstancedGeometry::new(&[&nothing, &flat], instances).unwrap();
        assert_eq!(scene.instance_count(), instances.len());
        assert_eq!(scene.bounds().is_some(), i == 2);
        scene.move_instances(&vec![here; instances.len()]).unwrap();
        let mut hits = [InstancedHit::default(); 3];
        scene.closest_hits(&[ray; 3], &mut hits);
        assert!(hits == [InstancedHit::default(); 3] && hits[0].t == f32::INFINITY);
        assert!(scene.closest_hit(&ray).is_none() && !scene.occluded(&ray));
        assert!(scene.all_hits(&ray, None).is_empty());
        scene.closest_hits(&[] as &[Ray], &mut []);
    }
}

/// A kilometre of poles in coordinates of a map, hit to the millimetre by rays from above.
#[test]
fn map_coordinates_keep_their_millimetres() {
    let middle = DVec3::new(432_100.125, 5_812_345.75, 214.5);
    let (positions, triangles) = cube(1, |at| at);
    let positions: Vec<[f64; 3]> = (positions.iter())
        .map(|&at| (Vec3::from(at).as_dvec3() * DVec3::new(0.05, 0.05, 2.0) + middle).to_array())
        .collect();
    let pole = Geometry::from_triangles(&positions, &triangles).unwrap();
    // The pole stands in map coordinates, and is moved from there.
    let place = |i: usize| DVec3::new((i % 32) as f64 * 31.0, (i / 32) as f64 * 31.0, i as f64 * 0.001);
    let instances: Vec<(usize, Transform)> = (0..1024)
        .map(|i| (0, Transform::IDENTITY.then_translate(place(i))))
        .collect();
    let scene = InstancedGeometry::new(&[&pole], &instances).unwrap();
    let origins: Vec<[f64; 3]> = (0..1024)
        .map(|i| (middle + place(i) + DVec3::new(0.049, -0.049, 100.0)).to_array())
        .collect();
    let down = vec![[0.0, 0.0, -1.0]; origins.len()];
    let mut hits = vec![InstancedHit::default(); origins.len()];
    scene.closest_hits(Rays::from_arrays(&origins, &down).unwrap(), &mut hits);
    for (i, hit) in hits.iter().enumerate() {
        assert_eq!(hit.instance, InstanceId(i as u32));
        assert!((hit.t - 98.0).abs() < 2e-4, "{i}: {hit:?}");
        let surface = scene.surface(DVec3::from_array(origins[i]), DVec3::NEG_Z, hit);
        assert!((surface.position.z - (middle + place(i)).z - 2.0).abs() < 2e-4);
    }
}

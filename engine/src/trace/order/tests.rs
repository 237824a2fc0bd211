use super::*;
use crate::{
    lanes::{F32x8, Vec3x8},
    simd::Portable,
};
use glam::Vec3;

fn packets(directions: &[[Vec3; LANES]]) -> Vec<RayPacket> {
    let packet = |d: &[Vec3; LANES]| RayPacket {
        direction: Vec3x8::from_lanes(*d),
        t_max: F32x8::splat(1.0),
    };
    directions.iter().map(packet).collect()
}

#[test]
fn rays_of_one_square_come_together_in_the_order_they_had() {
    let (x, z) = (Vec3::X, -Vec3::Z);
    let mut rays = packets(&[[x, z, x, z, x, z, x, z], [z; LANES], [Vec3::NAN; LANES]]);
    rays[1].t_max = F32x8::splat(0.0);
    let mut sorted = Sorted::new();
    assert!(sorted.by_direction(Portable, &rays));
    let mut order = sorted.rays().to_vec();
    assert_eq!(order[..4], [0, 2, 4, 6]);
    order.sort_unstable();
    assert_eq!(order, [0, 1, 2, 3, 4, 5, 6, 7, 16, 17, 18, 19, 20, 21, 22, 23]);
}

/// Packets of rays toward a square, each as wide as one of `parts` parts of it.
fn toward(parts: usize, from: Vec3, u: Vec3, v: Vec3) -> Vec<RayPacket> {
    let mut random = fastrand::Rng::with_seed(1);
    let directions: Vec<[Vec3; LANES]> = (0..PACKETS)
        .map(|_| {
            let corner = [random.usize(..parts) as f32, random.usize(..parts) as f32];
            [(); LANES].map(|()| {
                let [x, y] = corner.map(|corner| (corner + random.f32()) / parts as f32);
                from + u * x + v * y
            })
        })
        .collect();
    packets(&directions)
}

#[test]
fn rays_of_one_cell_come_together_where_packets_spread() {
    let (u, v) = (Vec3::X * 0.01, Vec3::Y * 0.01);
    let way = Vec3::new(0.1, -0.2, -1.0);
    assert!(!Sorted::new().by_place(Portable, &toward(20, way, u, v)));
    let mut rays = toward(2, way, u, v);
    rays[1].t_max = F32x8::splat(0.0);
    rays[2].t_max = F32x8::from([1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0]);
    let mut sorted = Sorted::new();
    assert!(sorted.by_place(Portable, &rays));
    // The sides of 64 packets: squares have 16 in all, rows would have 65, and skipped_sorts rays 128.
    let mut sides = 0.0;
    for packet in sorted.rays().chunks(RAYS / 64) {
        let place = |&ray: &u16| {
            let ray = usize::from(ray);
            rays[ray / LANES].direction.lane(ray % LANES)
        };
        let lower = packet.iter().map(place).reduce(Vec3::min).unwrap();
        let upper = packet.iter().map(place).reduce(Vec3::max).unwrap();
        sides += (upper - lower).element_sum() / 0.01;
    }
    assert!(sides < 30.0, "{sides}");
    let mut all = sorted.rays().to_vec();
    all.sort_unstable();
    let live = |&ray: &u16| {
        let ray = usize::from(ray);
        rays[ray / LANES].t_max.as_array()[ray % LANES] > 0.0
    };
    let expected: Vec<u16> = (0..RAYS as u16).filter(live).collect();
    assert_eq!(all, expected);
}

#[test]
fn rays_every_way_from_a_point_are_all_there() {
    let mut rays = toward(1, Vec3::NEG_ONE, Vec3::X * 2.0, Vec3::Y * 2.0);
    for (rays, flip) in rays.iter_mut().zip([1.0, -1.0].into_iter().cycle()) {
        rays.direction.z = rays.direction.z.to_array().map(|z| z * flip).into();
    }
    rays[0].direction.x = F32x8::splat(f32::NAN);
    rays[1].direction = Vec3x8::splat(Vec3::ZERO);
    let mut sorted = Sorted::new();
    assert!(sorted.by_place(Portable, &rays));
    let mut all = sorted.rays().to_vec();
    all.sort_unstable();
    assert!(all.iter().copied().eq(0..RAYS as u16));
}

#[test]
fn an_octahedron_folds_out_to_a_square() {
    let octahedron = Octahedron::toward([0.1, -0.9, 0.3]);
    let places = |v: Vec3| {
        let [a, b] = octahedron.places(Portable, &packets(&[[v; LANES]])[0]);
        [a.first(), b.first()]
    };
    assert_eq!(places(Vec3::NEG_Y), [0.0, 0.0]);
    assert_eq!(places(Vec3::Z), [1.0, 0.0]);
    assert_eq!(places(Vec3::NEG_X), [0.0, -1.0]);
    assert_eq!(places(Vec3::Y).map(f32::abs), [1.0, 1.0]);
    // The fold is no jump.
    let [before, behind] = [-1e-4, 1e-4].map(|y| places(Vec3::new(0.6, y, 0.8)));
    for (p, q) in before.into_iter().zip(behind) {
        assert!((p - q).abs() < 1e-3, "{before:?} {behind:?}");
    }
}

#[test]
fn rays_that_agree_stay_where_they_are() {
    assert!(!Sorted::new().by_direction(Portable, &packets(&[[Vec3::X; LANES], [Vec3::Y; LANES]])));
}

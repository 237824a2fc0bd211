//! Tests of `instance`.

use super::*;

#[test]
fn the_end_of_an_image_is_the_least_t_at_the_end_of_the_ray() {
    let mut random = fastrand::Rng::with_seed(3);
    for round in 0..200_000 {
        let power = |random: &mut fastrand::Rng, most: f64| 10_f64.powf((random.f64() * 2.0 - 1.0) * most);
        let length = [1.0, power(&mut random, 9.0), power(&mut random, 30.0)][round % 3];
        let end = power(&mut random, 45.0) as f32;
        let t_max = [end, 1.0, T_MAX, f32::MIN_POSITIVE, 1e-40, 0.0][round % 6].min(T_MAX);
        let image = ImageRay::new(Ray::new(Vec3::ZERO, Vec3::X), length).unwrap();
        let end = image.end(t_max);
        assert!(end == T_MAX || image.in_scene(end) >= t_max, "{length} {t_max}");
        assert!(
            end == 0.0 || image.in_scene(end.next_down()) < t_max,
            "{length} {t_max}"
        );
        if image.in_scene(T_MAX) > t_max {
            assert!(image.in_scene(image.beyond(t_max)) >= t_max, "{length} {t_max}");
        }
    }
}

use super::*;

fn cloud(colors: Vec<[f32; 3]>) -> SphereCloud {
    SphereCloud {
        x: vec![1.0, 2.0],
        y: vec![3.0, 4.0],
        z: vec![5.0, 6.0],
        radius: vec![0.5, 0.25],
        colors,
    }
}

#[test]
fn spheres_without_colours_are_white_beside_others() {
    let (mut builder, matte) = (SceneBuilder::new(), MaterialId(1));
    builder.add_sphere(Vec3::ZERO, 1.0, matte).expect("a sphere");
    builder.add_spheres(cloud(Vec::new()), matte).expect("spheres");
    assert!(builder.spheres.color.is_empty());
    let red = [1.0, 0.0, 0.25];
    builder.add_spheres(cloud(vec![red; 2]), matte).expect("spheres");
    builder.add_sphere(Vec3::ZERO, 2.0, matte).expect("a sphere");
    builder.add_spheres(cloud(Vec::new()), matte).expect("spheres");
    let scene = builder.finish();
    let spheres = scene.spheres();
    let white = WHITE;
    assert_eq!(
        spheres.color,
        [white, white, white, red, red, white, white, white]
    );
    assert_eq!(spheres.radius, [1.0, 0.5, 0.25, 0.5, 0.25, 2.0, 0.5, 0.25]);
    assert_eq!(
        (spheres.center_x[3], spheres.center_y[4], spheres.center_z[7]),
        (1.0, 4.0, 6.0)
    );
    assert_eq!(spheres.material, [matte; 8]);
    assert!(scene.has_colors() && scene.memory_bytes() >= 8 * 32);
}

#[test]
fn what_is_no_sphere_is_refused() {
    let add = |change: fn(&mut SphereCloud)| {
        let mut spheres = cloud(vec![[0.5; 3]; 2]);
        change(&mut spheres);
        SceneBuilder::new().add_spheres(spheres, MaterialId(0))
    };
    assert_eq!(add(|_| {}), Ok(()));
    for radius in [0.0, -1.0] {
        let mut spheres = cloud(Vec::new());
        spheres.radius[1] = radius;
        let added = SceneBuilder::new().add_spheres(spheres, MaterialId(0));
        assert_eq!(
            added,
            Err(SceneError::NotPositive {
                what: "radius",
                value: radius
            })
        );
    }
    let what = |change| match add(change) {
        Err(SceneError::NotUsable { what, .. } | SceneError::OutOfRange { what, .. }) => what,
        other => panic!("{other:?}"),
    };
    assert_eq!(what(|s| s.radius[0] = f32::NAN), "radius");
    assert_eq!(what(|s| s.y[1] = f32::INFINITY), "y");
    assert_eq!(what(|s| s.colors[1] = [0.0, 1.5, 0.0]), "green");
    assert_eq!(what(|s| s.colors[0] = [0.0, 1.0, f32::NAN]), "blue");
    let length = add(|s| s.colors.push([0.0; 3]));
    assert!(matches!(
        length,
        Err(SceneError::ArrayLength { what: "colours", .. })
    ));
    let length = add(|s| s.radius.truncate(1));
    assert!(matches!(
        length,
        Err(SceneError::ArrayLength { what: "radii", .. })
    ));
    let memory = SceneBuilder::within(300).add_spheres(cloud(vec![[0.5; 3]; 2]), MaterialId(0));
    assert!(memory.is_ok());
    let memory = SceneBuilder::within(250).add_spheres(cloud(vec![[0.5; 3]; 2]), MaterialId(0));
    assert!(matches!(memory, Err(SceneError::OverLimit { needed: 264, .. })));
}

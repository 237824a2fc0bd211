//! Scenes of the kinds that break ray tracers: triangles that are slivers, huge, tiny, coplanar, duplicated or
//! axis-aligned, and surfaces of shared edges; also very small, very large or far from the origin, with and without
//! colours, cut out in parts, half-transparent, beside infinite planes, and as instances.

use super::Random;
use crate::{
    error::SceneError,
    generate::{Kind, Options, generate},
    scene::{
        CutOut, Image, Material, MaterialId, Opacity, Scene, SceneBuilder, SphereCloud, SurfaceTextures,
        Texture, Transform, TriangleMesh, Wrap,
    },
};
use glam::{DVec3, Mat3, Vec3};

/// Returns a point of a coarse grid, so that coordinates coincide.
fn on_grid(random: &mut Random) -> Vec3 {
    (random.in_cube() * 2.0).round() * 0.5
}

fn point(random: &mut Random) -> Vec3 {
    if random.one_in(2) {
        on_grid(random)
    } else {
        random.in_cube()
    }
}

/// Returns a point at most about `size` from `a`.
fn another(random: &mut Random, a: Vec3, size: f32) -> Vec3 {
    if size < 1.0 {
        a + point(random) * size
    } else {
        point(random)
    }
}

/// Makes a triangle. `size` is that of ordinary triangles, neither tiny nor huge.
fn corners(random: &mut Random, earlier: &[[Vec3; 3]], size: f32) -> [Vec3; 3] {
    let a = point(random);
    let near = |random: &mut Random, a: Vec3, size: f32| a + random.in_cube() * size;
    match random.below(9) {
        // A sliver.
        0 => {
            let b = near(random, a, 2.0 * size);
            let on_edge = a + (b - a) * random.unit();
            [a, b, near(random, on_edge, 1e-6)]
        }
        // Tiny.
        1 => [a, near(random, a, 1e-4), near(random, a, 1e-4)],
        // Huge.
        2 => [a, near(random, a, 1e4), near(random, a, 1e4)],
        // Axis-aligned.
        3 => {
            let axis = random.index(3);
            [(); 3].map(|()| {
                let mut p = another(random, a, size);
                p[axis] = a[axis];
                p
            })
        }
        // A duplicate, perhaps with the opposite winding.
        4 if !earlier.is_empty() => {
            let [a, b, c] = random.pick(earlier);
            if random.one_in(2) { [a, b, c] } else { [c, b, a] }
        }
        // A neighbour across an edge.
        5 if !earlier.is_empty() => {
            let [a, b, _] = random.pick(earlier);
            [b, a, another(random, a, size)]
        }
        // No area.
        6 if random.one_in(4) => [a, a + (point(random) - a) * 0.5, a],
        // Sub-pixel, far from the origin.
        7 => {
            let far = a + Vec3::splat(100.0);
            [far, near(random, far, 1e-3), near(random, far, 1e-3)]
        }
        _ => [a, another(random, a, size), another(random, a, size)],
    }
}

/// Scale and position of a scene.
struct Placement {
    scale: f32,
    shift: Vec3,
}

impl Placement {
    fn random(random: &mut Random) -> Self {
        let scale = random.pick(&[1.0, 1.0, 1.0, 1.0, 1e-3, 1e-7, 1e4]);
        let shift = if random.one_in(5) {
            random.in_cube() * 100.0 * scale
        } else {
            Vec3::ZERO
        };
        Self { scale, shift }
    }

    fn apply(&self, p: Vec3) -> Vec3 {
        p * self.scale + self.shift
    }
}

fn mesh(corners: &[Vec3], triangles: Vec<[u32; 3]>) -> TriangleMesh {
    let coordinates = |axis: usize| corners.iter().map(|c| c[axis]).collect();
    TriangleMesh {
        x: coordinates(0),
        y: coordinates(1),
        z: coordinates(2),
        normals: Vec::new(),
        colors: Vec::new(),
        uvs: Vec::new(),
        tangents: Vec::new(),
        triangles,
    }
}

/// Gives every fourth scene a colour for each of `count` vertices or spheres; others none.
fn colors(random: &mut Random, count: usize) -> Vec<[f32; 3]> {
    if !random.one_in(4) {
        return Vec::new();
    }
    let mut color = || [(); 3].map(|()| random.pick(&[0.0, 0.2, 0.8, 1.0]));
    (0..count).map(|_| color()).collect()
}

/// Makes unconnected triangles and spheres, about a quarter of them spheres; `size` as for [`corners`].
fn soup(random: &mut Random, placement: &Placement, count: usize, size: f32) -> Result<Scene, SceneError> {
    let mut builder = SceneBuilder::new();
    add_soup(&mut builder, random, placement, count, size)?;
    add_planes(&mut builder, random, placement)?;
    Ok(builder.finish())
}

/// Adds what [`soup`] is made of.
fn add_soup(
    builder: &mut SceneBuilder,
    random: &mut Random,
    placement: &Placement,
    count: usize,
    size: f32,
) -> Result<(), SceneError> {
    let (mut triangles, mut spheres) = (Vec::<[Vec3; 3]>::new(), SphereCloud::default());
    for _ in 0..count {
        if random.one_in(4) {
            let radius = random.pick(&[size, 0.3 * size, 1e-4, 1e3]) * (random.unit() + 1e-3);
            let center = placement.apply(point(random));
            spheres.x.push(center.x);
            spheres.y.push(center.y);
            spheres.z.push(center.z);
            spheres.radius.push(radius * placement.scale);
        } else {
            triangles.push(corners(random, &triangles, size));
        }
    }
    let corners: Vec<Vec3> = triangles
        .as_flattened()
        .iter()
        .map(|&c| placement.apply(c))
        .collect();
    let indices = (0..triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]);
    let mut mesh = mesh(&corners, indices.collect());
    mesh.colors = colors(random, corners.len());
    let (material, has_image) = material(random, builder)?;
    if has_image {
        mesh.uvs = texture_coordinates(random, corners.len());
    }
    builder.add_mesh(mesh, material)?;
    spheres.colors = colors(random, spheres.radius.len());
    builder.add_spheres(spheres, material)
}

/// Returns a material, and whether it has an image: in a third of the calls one that is cut out in parts, or through which
/// one sees, in part.
fn material(random: &mut Random, builder: &mut SceneBuilder) -> Result<(MaterialId, bool), SceneError> {
    if !random.one_in(3) {
        return Ok((MaterialId(0), false));
    }
    let texels = (0..16).map(|_| {
        [
            255,
            0,
            random.pick(&[0, 255]),
            random.pick(&[0, 1, 127, 128, 255]),
        ]
    });
    let image = builder.add_image(Image::new([4, 4], texels.collect())?)?;
    let texture = Texture {
        image,
        wrap: [(); 2].map(|()| random.pick(&[Wrap::Repeat, Wrap::Mirror, Wrap::Clamp])),
        nearest: random.one_in(2),
    };
    let cut_out = CutOut {
        texture,
        channel: random.pick(&[2, 3]),
        limit: random.pick(&[0.5, 0.5, 0.01, 1.0]),
    };
    let factor = random.pick(&[0.0, 0.4, 0.5, 1.0]);
    let textures = SurfaceTextures {
        cut_out: random.one_in(2).then_some(cut_out),
        opacity: Opacity::new(factor, random.one_in(2).then_some(texture)),
        ..SurfaceTextures::default()
    };
    let material = builder.add_textured_material(Material::Matte { color: [0.8; 3] }, textures)?;
    Ok((material, true))
}

/// Returns texture coordinates of `count` vertices.
fn texture_coordinates(random: &mut Random, count: usize) -> Vec<[f32; 2]> {
    let mut one = || [(); 2].map(|()| random.pick(&[0.0, 0.25, 1.0, 3.7]) * random.signed());
    (0..count).map(|_| one()).collect()
}

/// Adds up to two planes to a fifth of the scenes.
fn add_planes(
    builder: &mut SceneBuilder,
    random: &mut Random,
    placement: &Placement,
) -> Result<(), SceneError> {
    if !random.one_in(5) {
        return Ok(());
    }
    for _ in 0..=random.below(2) {
        let normal = if random.one_in(2) {
            Vec3::Z
        } else {
            random.in_cube()
        };
        let (material, _) = material(random, builder)?;
        builder.add_plane(placement.apply(point(random)), normal, material)?;
    }
    Ok(())
}

/// Returns a placement of an instance: turned, of any size, mirrored, stretched, and sometimes like the one before.
fn transform(random: &mut Random, before: Transform, around: &Placement) -> Transform {
    if random.one_in(6) {
        return before;
    }
    let axis = if random.one_in(3) {
        Vec3::Z
    } else {
        random.in_cube()
    };
    let degrees = random.pick(&[0.0, 90.0, 180.0, 33.3]) * f64::from(random.signed());
    let size = random.pick(&[1.0, 1.0, 0.3, -0.2, 10.0, 1e-3]);
    let factors = if random.one_in(3) {
        DVec3::new(size, 0.1 * size, 3.0)
    } else {
        DVec3::splat(size)
    };
    Transform::IDENTITY
        .then_scale(factors * f64::from(around.scale))
        .then_rotate(axis.as_dvec3(), degrees)
        .then_translate(around.apply(point(random)).as_dvec3())
}

/// Makes a scene of one or two prototypes with half of `count` primitives each, and of their instances.
fn instanced(random: &mut Random, placement: &Placement, count: usize) -> Result<Scene, SceneError> {
    let mut builder = SceneBuilder::new();
    let mut prototypes = Vec::new();
    for _ in 0..=random.below(2) {
        let own = Placement::random(random);
        let prototype =
            builder.add_prototype(|builder| add_soup(builder, random, &own, count.div_ceil(2), 1.0))?;
        prototypes.push((prototype, own.scale));
        if random.one_in(3) {
            add_soup(&mut builder, random, placement, 1 + count / 4, 1.0)?;
        }
    }
    let mut placed = Transform::IDENTITY;
    for _ in 0..=random.below(12) {
        let (prototype, scale) = random.pick(&prototypes);
        placed = transform(random, placed, placement);
        let to_size_1 = Transform::IDENTITY.then_scale(DVec3::splat(f64::from(scale).recip()));
        match builder.add_instance(prototype, &to_size_1.then_transform(&placed)) {
            // Thrown too far.
            Err(SceneError::NotUsable { .. }) | Ok(()) => {}
            Err(error) => return Err(error),
        }
    }
    add_planes(&mut builder, random, placement)?;
    Ok(builder.finish())
}

/// Makes a surface of about `count` triangles that share edges: flat, stepped or rough; rotated or axis-aligned.
fn surface(random: &mut Random, placement: &Placement, count: usize) -> Result<Scene, SceneError> {
    let across = (count / 2).max(1).isqrt();
    let down = (count / 2 / across).max(1);
    let kind = random.below(3);
    let turn = if random.one_in(2) {
        Mat3::IDENTITY
    } else {
        let axis = random.in_cube().normalize_or(Vec3::Z);
        Mat3::from_axis_angle(axis, random.unit() * 3.0)
    };
    let mut corners = Vec::new();
    for y in 0..=down {
        for x in 0..=across {
            let height = match kind {
                0 => 0.0,
                1 => random.below(2) as f32 * 0.5,
                _ => random.signed(),
            };
            let on_plane = Vec3::new(x as f32 / across as f32, y as f32 / down as f32, height);
            corners.push(
                placement.apply(turn * (on_plane * Vec3::new(2.0, 2.0, 1.0) - Vec3::new(1.0, 1.0, 0.0))),
            );
        }
    }
    let mut triangles = Vec::new();
    for y in 0..down {
        for x in 0..across {
            let a = (y * (across + 1) + x) as u32;
            let (b, c, d) = (a + 1, a + across as u32 + 1, a + across as u32 + 2);
            triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    let mut builder = SceneBuilder::new();
    let mut mesh = mesh(&corners, triangles);
    mesh.colors = colors(random, corners.len());
    let (material, has_image) = material(random, &mut builder)?;
    if has_image {
        mesh.uvs = texture_coordinates(random, corners.len());
    }
    builder.add_mesh(mesh, material)?;
    add_planes(&mut builder, random, placement)?;
    Ok(builder.finish())
}

/// Makes a scene of `count` primitives, or of about as many if it is a surface.
///
/// # Errors
/// None in practice: all coordinates are within the builder's limits.
pub fn small(random: &mut Random, count: usize) -> Result<Scene, SceneError> {
    let placement = Placement::random(random);
    if random.one_in(4) {
        instanced(random, &placement, count)
    } else if random.one_in(5) && count > 1 {
        surface(random, &placement, count)
    } else {
        soup(random, &placement, count, 1.0)
    }
}

/// Makes a scene of about `count` primitives: small unconnected ones, a surface, or a generated scene.
///
/// # Errors
/// None in practice: all coordinates are within the builder's limits.
pub fn large(random: &mut Random, count: usize) -> Result<Scene, SceneError> {
    let kinds: Vec<Kind> = Kind::ALL
        .into_iter()
        .filter(|kind| kind.min_count() <= count)
        .collect();
    let options = Options {
        seed: u64::from(random.below(u32::MAX)),
        count: Some(count),
    };
    let kind = random.pick(&kinds);
    let placement = Placement::random(random);
    match random.below(3) {
        0 => surface(random, &placement, count),
        1 => {
            let size = (count as f32).cbrt().recip();
            soup(random, &placement, count, size)
        }
        _ => match generate(kind, options) {
            Ok(generated) => generated.into_scene(),
            // Cannot happen: only kinds that allow this count are chosen.
            Err(_) => surface(random, &placement, count),
        },
    }
}

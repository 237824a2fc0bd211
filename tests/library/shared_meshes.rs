//! glTF files whose meshes are stored once: packets, scalar code and brute force agree on the picture, which is that of
//! the file baked.

use crate::sameness::{check, sized};
use glam::{DVec3, Vec3};
use octray::{
    accel::Bvh,
    format::mesh::{Sharing, parse_shared},
    render::{Film, render},
    scene::{Camera, FitView, Scene, SceneBuilder},
};
use std::{fmt::Write as _, ops::ControlFlow, path::Path};

/// A wavy tube with colours, of two materials, as the bytes and the JSON of a glTF file. Nodes place it turned, mirrored,
/// stretched or scaled, within another, flattened, and by `EXT_mesh_gpu_instancing`; a second mesh stands once.
fn file(has_normals: bool, is_stretched: bool) -> (String, Vec<u8>) {
    const ROUND: usize = 12;
    let mut columns: [Vec<f32>; 3] = [const { Vec::new() }; 3];
    for row in 0..6 {
        for i in 0..ROUND {
            let (sin, cos) = (i as f32 * std::f32::consts::TAU / ROUND as f32).sin_cos();
            let radius = 0.3 + 0.1 * (row as f32 * 1.7 + i as f32).sin();
            columns[0].extend([radius * cos, row as f32 * 0.2, radius * sin]);
            columns[1].extend([cos, 0.0, sin]);
            columns[2].extend([0.2 + row as f32 * 0.15, 0.5 + 0.5 * cos, 0.8]);
        }
    }
    let mut bytes: Vec<u8> = columns.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    let instances: [f32; 16] = [
        1.5, 0.0, -1.0, -1.2, 0.3, -1.5, // translations
        0.0, 0.6, 0.0, 0.8, 0.5, 0.5, 0.5, 0.5, // rotations
        0.0, 0.0,
    ];
    bytes.extend(instances.iter().flat_map(|x| x.to_le_bytes()));
    for row in 0..5 {
        for i in 0..ROUND {
            let at = |row: usize, i: usize| (row * ROUND + i % ROUND) as u16;
            let [a, b, c, d] = [at(row, i), at(row, i + 1), at(row + 1, i + 1), at(row + 1, i)];
            bytes.extend([a, b, c, a, c, d].iter().flat_map(|x| x.to_le_bytes()));
        }
    }
    let scale = if is_stretched { "0.5,2,1" } else { "1.5,1.5,1.5" };
    let normals = if has_normals { r#""NORMAL":1,"# } else { "" };
    let mut json = format!(
        r#"{{"asset":{{"version":"2.0"}},"extensionsUsed":["EXT_mesh_gpu_instancing"],"scenes":[{{"nodes":[0,1,3,5,6,7]}}],
"nodes":[{{"mesh":0,"rotation":[0.6,0,0,0.8]}},{{"scale":[-1,1,1],"children":[2],"translation":[1,0,0]}},
{{"mesh":0,"rotation":[0,0,0.6,0.8]}},{{"scale":[{scale}],"children":[4],"translation":[-1,0,0]}},
{{"mesh":0,"rotation":[0.6,0,0,0.8]}},{{"mesh":0,"scale":[1,1,0],"translation":[0,1,0.5]}},
{{"mesh":0,"extensions":{{"EXT_mesh_gpu_instancing":{{"attributes":{{"TRANSLATION":3,"ROTATION":4}}}}}}}},
{{"mesh":1,"scale":[4,0.3,4],"translation":[0,-1.2,0]}}],
"materials":[{{"pbrMetallicRoughness":{{"baseColorFactor":[1,0.6,0.2,1]}}}},{{"emissiveFactor":[0,0.2,0.1]}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,{normals}"COLOR_0":2}},"indices":5,"material":0}},
{{"attributes":{{"POSITION":0}},"indices":6,"material":1}}]}},{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":5}}]}}],
"buffers":[{{"byteLength":{},"uri":"a.bin"}}],"bufferViews":[{{"buffer":0,"byteLength":{}}}],"accessors":["#,
        bytes.len(),
        bytes.len()
    );
    for (offset, kind, count, of) in [
        (0, 5126, 72, "VEC3"),
        (864, 5126, 72, "VEC3"),
        (1728, 5126, 72, "VEC3"),
        (2592, 5126, 2, "VEC3"),
        (2616, 5126, 2, "VEC4"),
        (2656, 5123, 270, "SCALAR"),
        (3196, 5123, 90, "SCALAR"),
    ] {
        let comma = if offset == 0 { "" } else { "," };
        let _ = write!(
            json,
            r#"{comma}{{"bufferView":0,"byteOffset":{offset},"componentType":{kind},"count":{count},"type":"{of}"}}"#
        );
    }
    (json + "]}", bytes)
}

/// The scene of the file, and a camera that frames it.
fn scene((json, bytes): &(String, Vec<u8>), sharing: Sharing, smooth: bool) -> (Scene, Camera) {
    let open = &mut |_: &Path| Ok(bytes.clone());
    let mut mesh = parse_shared(json.clone().into(), Path::new("a.gltf"), open, sharing).expect("a mesh");
    assert!(mesh.notes.is_empty(), "{:?}", mesh.notes);
    if smooth {
        mesh.columns.smooth_normals(60.0).expect("little memory");
        for part in &mut mesh.shared {
            part.columns.smooth_normals(60.0).expect("little memory");
        }
    }
    mesh.linearize();
    let view = FitView {
        towards_viewer: DVec3::new(0.5, 0.4, 1.0),
        up: DVec3::Y,
        fov_degrees: Some(35.0),
        aspect: 1.0,
    };
    let fit = view.fit_around(&mesh.placed(), 0.0).expect("a view");
    let turning = view.fit_turning_around(&mesh.placed(), 0.0).expect("a view");
    assert!(turning.eye.distance(turning.target) > fit.eye.distance(fit.target) * 0.5);
    let camera = Camera::look_at(fit.eye, fit.target, DVec3::Y, 35.0).expect("a camera");
    let mut builder = SceneBuilder::new();
    builder.add_light(Vec3::new(3.0, 5.0, 6.0), 0.7).expect("a light");
    builder.set_ambient_reach(Some(1.0)).expect("a reach");
    mesh.add_to(&mut builder, None).expect("a scene");
    (builder.finish(), camera)
}

fn film(scene: &Scene, camera: &Camera) -> Film {
    let settings = sized(96, 96, 4);
    let frame = render(scene, &Bvh::build(scene), camera, &settings, &|_| {
        ControlFlow::Continue(())
    });
    frame.expect("a small picture").film
}

#[test]
fn pictures_are_those_of_the_file_baked() {
    for (has_normals, smooth) in [(true, false), (false, false), (false, true)] {
        // Normals of stretched instances are interpolated before they are placed, so their pixels differ.
        let file = file(has_normals, !has_normals && !smooth);
        let (baked, camera) = scene(&file, Sharing::Never, smooth);
        let (shared, other) = scene(&file, Sharing::Always, smooth);
        assert_eq!(camera.view().eye, other.view().eye);
        assert_eq!((baked.instances().len(), shared.instances().len()), (0, 5));
        // Once stored, once flat, and the other mesh.
        let [baked_count, shared_count] = [&baked, &shared].map(|scene| scene.triangles().corners.len());
        assert_eq!((baked_count, shared_count), (6 * 120 + 90, 2 * 120 + 90));
        let (baked, placed) = (film(&baked, &camera), film(&shared, &camera));
        let pairs = baked.pixels().iter().zip(placed.pixels());
        let differs = |a: &[f32; 3], b: &[f32; 3]| (0..3).any(|i| (a[i] - b[i]).abs() > 0.02);
        let different = pairs.filter(|(a, b)| differs(a, b)).count();
        assert!(
            different <= 96 * 96 / 200,
            "normals: {has_normals}, {smooth}: {different} pixels differ"
        );
        if has_normals {
            let (shared, camera) = scene(&self::file(true, true), Sharing::Always, smooth);
            check("a shared glTF file", &shared, &camera, &sized(40, 40, 1));
        }
    }
}

//! Lines of files without faces: every format has them, and they are as thick as they should be.

use crate::sameness;
use glam::{DVec3, Vec3};
use octray::{
    error::SceneError,
    format::{
        load_from_bytes,
        mesh::{self, LoadedMesh},
    },
    ray::Ray,
    reference::brute,
    scene::{Camera, Scene, SceneBuilder},
};
use std::{f32::consts::FRAC_PI_8, io, path::Path};

/// Positions of a square, which is not at vertex 0.
const CORNERS: [[f32; 3]; 5] = [
    [9.0, 9.0, 9.0],
    [0.0, 0.0, 0.0],
    [4.0, 0.0, 0.0],
    [4.0, 3.0, 0.0],
    [0.0, 3.0, 0.0],
];

fn read(name: &str, bytes: &[u8], buffer: &[u8]) -> LoadedMesh {
    let open = &mut |path: &Path| match path.to_str() {
        Some("a.bin") => Ok(buffer.to_vec()),
        _ => Err(io::ErrorKind::NotFound.into()),
    };
    mesh::parse(bytes.to_vec(), Path::new(name), open).unwrap_or_else(|error| panic!("{error}"))
}

/// The ends of all lines, and the positions of all vertices.
fn ends(mesh: &LoadedMesh) -> (Vec<[[f32; 3]; 2]>, Vec<[f32; 3]>) {
    let all = &mesh.columns;
    assert!(
        all.triangles.is_empty() && mesh.notes.is_empty(),
        "{:?}",
        mesh.notes
    );
    let positions: Vec<[f32; 3]> = (0..all.x.len()).map(|i| [all.x[i], all.y[i], all.z[i]]).collect();
    let lines = &mesh.cloud.as_ref().expect("no faces").lines;
    let lines = lines.iter().map(|ends| ends.map(|i| positions[i as usize]));
    (lines.collect(), positions)
}

fn vertices() -> String {
    let line = |[x, y, z]: &[f32; 3]| format!("v {x} {y} {z}\n");
    CORNERS.iter().map(line).collect()
}

fn square() -> Vec<[[f32; 3]; 2]> {
    let pairs = [[1, 2], [2, 3], [3, 4], [4, 1]];
    pairs.map(|pair| pair.map(|i| CORNERS[i])).to_vec()
}

#[test]
fn lines_of_obj() {
    let obj = |elements: &str| ends(&read("a.obj", (vertices() + elements).as_bytes(), &[]));
    for elements in [
        "l 2 3 4 5 2\n",
        "l 2/1 3/7 4/2 # 9\nl -2 \\\n 5 2",
        "l 2 3\nl 3 4\nl 4 5\nl 5 2\n",
    ] {
        // The first vertex is in no line.
        assert_eq!(obj(elements), (square(), CORNERS[1..].to_vec()), "{elements}");
    }
    assert_eq!(obj("p 1\nl 2 3 4 5 2\n"), (square(), CORNERS.to_vec()));
    assert_eq!(obj("p 5 -3\n"), (vec![], vec![CORNERS[2], CORNERS[4]]));
    assert_eq!(obj(""), (vec![], CORNERS.to_vec()));
    // Vertices may follow, and colours keep their vertices.
    let mesh = read(
        "a.obj",
        b"v 0 0 0 1 0 0\nl 2 3\nv 1 0 0 0 1 0\nv 2 0 0 0 0 1\n",
        &[],
    );
    assert_eq!(mesh.columns.colors, [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    // Where two materials meet, a vertex has both; one material stays what it is.
    let library = "newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\n";
    let read_with = |elements: &str| {
        let text = format!("mtllib a.bin\nv 0 0 0\nv 1 0 0\nv 2 0 0\n{elements}");
        read("a.obj", text.as_bytes(), library.as_bytes())
    };
    let mesh = read_with("usemtl red\nl 1 2\nusemtl blue\nl 2 3\n");
    assert_eq!(
        (&mesh.columns.x[..], mesh.surfaces.len()),
        (&[0.0, 1.0, 2.0, 1.0][..], 0)
    );
    let [red, blue] = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    assert_eq!(mesh.columns.colors, [red, red, blue, blue]);
    assert_eq!(mesh.cloud.expect("no faces").lines, [[0, 1], [3, 2]]);
    let mesh = read_with("usemtl blue\nl 3 2\n");
    assert_eq!((mesh.surfaces.len(), mesh.surfaces[0].diffuse), (1, blue));
    assert!(mesh.columns.colors.is_empty());
    // With faces they are left out, whatever they say.
    let mesh = read("a.obj", (vertices() + "f 2 3 4\nl 7 x\np 0\n").as_bytes(), &[]);
    assert!(mesh.cloud.is_none());
    assert_eq!(mesh.notes, ["a.obj: left out: 1 line element, 1 point element"]);
}

#[test]
fn lines_of_ply() {
    let header = |format: &str, edge: &str| {
        format!(
            "ply\nformat {format} 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n\
             element edge 4\n{edge}end_header\n"
        )
    };
    let positions = || CORNERS.iter().flatten();
    let edge = "property int vertex1\nproperty int vertex2\n";
    let text: String = positions().map(|x| format!("{x}\n")).collect();
    let ascii = header("ascii", edge) + &text + "1 2\n2 3\n3 4\n4 1\n";
    let mut little = header("binary_little_endian", edge).into_bytes();
    little.extend(positions().flat_map(|x| x.to_le_bytes()));
    little.extend([1_i32, 2, 2, 3, 3, 4, 4, 1].iter().flat_map(|i| i.to_le_bytes()));
    let edge = "property ushort vertex2\nproperty uchar vertex1\n";
    let mut big = header("binary_big_endian", edge).into_bytes();
    big.extend(positions().flat_map(|x| x.to_be_bytes()));
    big.extend([0, 2, 1, 0, 3, 2, 0, 4, 3, 0, 1, 4]);
    for bytes in [ascii.clone().into_bytes(), little, big] {
        assert_eq!(ends(&read("a.ply", &bytes, &[])), (square(), CORNERS.to_vec()));
    }
    let faces = ascii.replace(
        "end_header",
        "element face 1\nproperty list uchar int vertex_index\nend_header",
    );
    let mesh = read("a.ply", (faces + "3 1 2 3\n").as_bytes(), &[]);
    assert_eq!((mesh.cloud, mesh.columns.triangles.len()), (None, 1));
    assert_eq!(mesh.notes, ["a.ply: left out: 4 `edge` records"]);
}

#[cfg(feature = "gltf")]
#[test]
fn lines_of_gltf() {
    let file = |mode: u8, indices: &[u8], first: usize, count: usize| {
        let positions = CORNERS[first..].as_flattened();
        let mut buffer: Vec<u8> = positions.iter().flat_map(|x| x.to_le_bytes()).collect();
        let start = buffer.len();
        buffer.extend(indices);
        let named = if indices.is_empty() { "" } else { r#","indices":1"# };
        let text = format!(
            r#"{{"asset":{{"version":"2.0"}},"nodes":[{{"mesh":0}}],"materials":[{{"pbrMetallicRoughness":
            {{"baseColorFactor":[1,0,0,1]}}}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"mode":{mode},
            "material":0{named}}}]}}],"buffers":[{{"byteLength":{},"uri":"a.bin"}}],"bufferViews":[{{"buffer":0,
            "byteLength":{start}}},{{"buffer":0,"byteOffset":{start},"byteLength":{}}}],"accessors":[{{"bufferView":0,
            "componentType":5126,"count":{},"type":"VEC3"}},{{"bufferView":1,"componentType":5121,"count":{count},
            "type":"SCALAR"}}]}}"#,
            buffer.len(),
            indices.len().max(1),
            start / 12,
        );
        buffer.push(0);
        let mesh = read("a.gltf", text.as_bytes(), &buffer);
        assert!(mesh.columns.colors.iter().all(|color| *color == [1.0, 0.0, 0.0]));
        ends(&mesh)
    };
    let expected = (square(), CORNERS[1..].to_vec());
    // Lines, a loop, a strip; the last index of the first is left over.
    assert_eq!(file(1, &[1, 2, 2, 3, 3, 4, 4, 1, 0][..8], 0, 8), expected);
    assert_eq!(file(2, &[1, 2, 3, 4], 0, 4), expected);
    assert_eq!(file(3, &[1, 2, 3, 4, 1], 0, 5), expected);
    assert_eq!(file(2, &[], 1, 1), expected);
    let (mut open, all) = expected;
    open.pop();
    assert_eq!(file(3, &[], 1, 1), (open.clone(), all.clone()));
    open.remove(1);
    assert_eq!(file(1, &[], 1, 1), (open, all));
    assert_eq!(file(2, &[1, 2], 0, 2).0, [[CORNERS[1], CORNERS[2]]]);
}

fn scene(text: &str, radius: f32) -> Scene {
    let mut mesh = read("a.obj", text.as_bytes(), &[]);
    mesh.cloud.as_mut().expect("lines").radius = Some(radius);
    let mut builder = SceneBuilder::new();
    builder.add_light(Vec3::new(2.0, 5.0, 9.0), 0.8).expect("a light");
    mesh.add_to(&mut builder, None).expect("a scene");
    builder.finish()
}

/// Rays from above meet the line as an octagon within its circle, and its ends as spheres.
#[test]
fn a_line_is_as_thick_as_its_diameter() {
    let radius = 0.25_f32;
    let scene = scene("v -2 0 0\nv 2 0 0\nl 1 2 2\n", radius);
    let least = radius * FRAC_PI_8.cos();
    for i in -60..=60 {
        for x in [-2.1_f32, -1.9, 0.3, 2.2] {
            let y = i as f32 * 0.005;
            let ray = Ray::new(Vec3::new(x, y, 10.0), Vec3::NEG_Z);
            let hit = brute::closest_hit(&scene, &ray).hit;
            let beyond = (x.abs() - 2.0).max(0.0);
            let from_axis = y.hypot(beyond);
            if from_axis > radius {
                assert!(!hit.is_hit(), "{x} {y}");
            } else if beyond > 0.0 || from_axis < least {
                let z = 10.0 - hit.t;
                let reach = from_axis.hypot(z);
                let least = if beyond > 0.0 { radius } else { least };
                assert!(reach > least - 1e-4 && reach < radius + 1e-4, "{x} {y}: {z}");
            }
        }
    }
}

#[test]
fn lines_are_the_same_in_all_modes() {
    let scene = scene(
        "v -1 0 0 1 0 0\nv 1 0 0.5 0 1 0\nv 0 1 0 0 0 1\nv 0 -1 1 1 1 1\nl 1 2 3 4 1\np 3\n",
        0.1,
    );
    let eye = DVec3::new(2.0, -3.0, 2.5);
    let camera = Camera::look_at(eye, DVec3::ZERO, DVec3::Z, 40.0).expect("a camera");
    sameness::check("lines", &scene, &camera, &sameness::sized(97, 61, 4));
}

/// Ten bytes of a file become thousands, so they are counted before they are made.
#[test]
fn memory_is_counted_first() {
    let add = |memory: u64| {
        let mesh = read("a.obj", (vertices() + "l 2 3 4 5 2\n").as_bytes(), &[]);
        mesh.add_to(&mut SceneBuilder::within(memory), None)
    };
    // 64 triangles with 64 vertices, 4 spheres.
    let needed = 64 * (16 + 100) + 4 * (20 + 100) + 2 * 64 * 12;
    assert_eq!(add(needed), Ok(()));
    assert_eq!(
        add(needed - 1),
        Err(SceneError::OverLimit {
            needed,
            limit: needed - 1
        })
    );
    // Indices of a mesh that was changed are checked.
    let mut mesh = read("a.obj", b"v 0 0 0\nv 1 0 0\nl 1 2", &[]);
    mesh.cloud.as_mut().expect("lines").lines.push([0, 2]);
    let beyond = mesh.add_to(&mut SceneBuilder::new(), None);
    assert_eq!(
        beyond,
        Err(SceneError::LineIndex {
            index: 2,
            vertices: 2
        })
    );
}

#[test]
fn scenes_place_lines() {
    let load = |text: &str| {
        let open = &mut |_: &Path| Ok(b"v 0 0 0\nv 3 0 0\nv 3 4 0\nl 1 2 3\n".to_vec());
        load_from_bytes(text.as_bytes(), Path::new("a.scn"), open).unwrap_or_else(|error| panic!("{error}"))
    };
    let scene = load(
        "light 1 2 9 0.5\nmesh a.obj\nmesh a.obj translate 0 9 0 point_size 0.5\nmesh a.obj scale 2\n\
         instance a.obj point_size 0.25\n",
    );
    let (spheres, triangles) = (scene.spheres(), scene.triangles());
    assert_eq!((spheres.radius.len(), triangles.corners.len()), (12, 4 * 32));
    // 1/400 of the diagonal, after placement.
    for (i, radius) in [(0, 0.0125), (3, 0.25), (6, 0.025)] {
        assert!((spheres.radius[i] - radius).abs() < 1e-6, "{:?}", spheres.radius);
    }
}

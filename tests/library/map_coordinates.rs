//! Meshes in coordinates of a map are loaded relative to an offset; everything else in their files is read once.

use glam::{DVec3, Vec3};
use octray::{
    Geometry,
    format::mesh::{LoadedMesh, Sharing, load_within, parse, parse_shared},
    scene::{SceneBuilder, TriangleMesh},
};
use std::{io, path::Path};

fn nothing(_: &Path) -> io::Result<Vec<u8>> {
    Err(io::ErrorKind::NotFound.into())
}

fn load(bytes: impl Into<Vec<u8>>, name: &str) -> LoadedMesh {
    parse(bytes.into(), Path::new(name), &mut nothing).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// The positions of a mesh in its file.
fn positions(mesh: &LoadedMesh) -> Vec<[f64; 3]> {
    let TriangleMesh { x, y, z, .. } = &mesh.columns;
    let points = x.iter().zip(y).zip(z).map(|((&x, &y), &z)| Vec3::new(x, y, z));
    points
        .map(|point| (point.as_dvec3() + mesh.offset).to_array())
        .collect()
}

/// A square with a notch, 2 m wide.
const CORNERS: [[f64; 3]; 5] = [
    [499_999.000_976_562_5, 4_000_000.0, 0.25],
    [500_001.000_976_562_5, 4_000_000.0, 0.25],
    [500_001.000_976_562_5, 4_000_002.125, 0.25],
    [500_000.0, 4_000_000.5, 0.25],
    [499_999.000_976_562_5, 4_000_002.0, 0.25],
];

/// The area of a polygon seen from above, if its corners are counterclockwise.
fn area(corners: &[[f64; 3]]) -> f64 {
    let [x0, y0, _] = corners[0];
    let sides = corners.iter().zip(corners.iter().cycle().skip(1));
    0.5 * sides
        .map(|(a, b)| (a[0] - x0) * (b[1] - y0) - (b[0] - x0) * (a[1] - y0))
        .sum::<f64>()
}

fn ply(format: &str, scalars: [&str; 3], more: &str, vertices: &[u8], face: &[u8]) -> Vec<u8> {
    let [x, y, z] = scalars;
    let header = format!(
        "ply\nformat {format} 1.0\nelement vertex 5\nproperty {x} x\nproperty {y} y\nproperty {z} z\n{more}\
         element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    );
    [header.as_bytes(), vertices, face].concat()
}

/// Fast paths and slow ones, and polygons, which are triangulated by their exact corners.
#[test]
fn every_reader_keeps_the_digits() {
    let lines = |end: &str| -> String {
        let line = |[x, y, z]: [f64; 3]| format!("{x} {y} {z}{end}\n");
        CORNERS.into_iter().map(line).collect()
    };
    let binary = |list: &[u8]| -> Vec<u8> {
        let record = |corner: &[f64; 3]| [&corner.map(f64::to_le_bytes).concat()[..], list].concat();
        CORNERS.iter().flat_map(record).collect()
    };
    let face = [&[5][..], &[0_i32, 1, 2, 3, 4].map(i32::to_le_bytes).concat()].concat();
    let (doubles, list) = (["double"; 3], "property list uchar uchar extra\n");
    let little = "binary_little_endian";
    let obj: String = lines("").lines().map(|line| format!("v {line}\n")).collect();
    for (name, bytes) in [
        (
            "a.ply",
            ply("ascii", doubles, "", lines("").as_bytes(), b"5 0 1 2 3 4\n"),
        ),
        (
            "slow.ply",
            ply("ascii", doubles, list, lines(" 1 7").as_bytes(), b"5 0 1 2 3 4\n"),
        ),
        ("binary.ply", ply(little, doubles, "", &binary(&[]), &face)),
        (
            "slow_binary.ply",
            ply(little, doubles, list, &binary(&[1, 7]), &face),
        ),
        ("a.obj", (obj + "f 1 2 3 4 5\n").into_bytes()),
        (
            "a.off",
            format!("OFF 5 1 0\n{}5 0 1 2 3 4\n", lines("")).into_bytes(),
        ),
    ] {
        let mesh = load(bytes, name);
        assert_eq!(positions(&mesh), CORNERS, "{name}");
        let found: f64 = mesh
            .columns
            .triangles
            .iter()
            .map(|triangle| area(&triangle.map(|i| CORNERS[i as usize])))
            .sum();
        assert_eq!(
            (mesh.columns.triangles.len(), found),
            (3, area(&CORNERS)),
            "{name}"
        );
    }
    // Whole numbers of 32 bits have more digits than `f32`, too.
    let whole = |scale: i32| -> Vec<u8> {
        let corners = [[0, 0], [3, 0], [3, 3], [1, 1], [0, 3]];
        let corner = |[x, y]: [i32; 2]| {
            [x * scale + 100_000_001, y * scale, 0]
                .map(i32::to_le_bytes)
                .concat()
        };
        corners.into_iter().flat_map(corner).collect()
    };
    let mesh = load(ply(little, ["int"; 3], "", &whole(100), &face), "a.ply");
    assert_eq!(positions(&mesh)[1], [100_000_301.0, 0.0, 0.0]);
    // Large enough for its place.
    let mesh = load(ply(little, ["int"; 3], "", &whole(1_000_000), &face), "a.ply");
    assert_eq!((mesh.offset, mesh.columns.x[0]), (DVec3::ZERO, 100_000_000.0));
}

/// Parts that would fall together in `f32` are read.
#[test]
fn a_mesh_smaller_than_a_step_is_seen() {
    let obj = "v 500000.001 4000000.001 9\nv 500000.002 4000000.001 9\nv 500000.001 4000000.003 9\nf 1 2 3\n";
    let mesh = load(obj, "a.obj");
    let size = |column: &[f32]| {
        column
            .iter()
            .fold(0.0_f32, |most, &x| most.max((x - column[0]).abs()))
    };
    assert!((size(&mesh.columns.x) - 0.001).abs() < 1e-8);
    assert!((size(&mesh.columns.y) - 0.002).abs() < 1e-8);
    // Near 0 the same is ordinary, and a single point is as it was.
    for (text, x) in [
        ("v 0.1 0.1 9\nv 0.2 0.1 9\nv 0.1 0.3 9\nf 1 2 3\n", 0.1),
        ("v 0.1 0.1 9\n", 0.1),
    ] {
        let mesh = load(text, "a.obj");
        assert_eq!((mesh.offset, mesh.columns.x[0]), (DVec3::ZERO, x));
    }
}

/// Images are read once, notes are said once, and the memory of the first reading is free for the second.
#[test]
fn images_and_notes_are_kept() {
    let mut image = io::Cursor::new(Vec::new());
    image::RgbImage::from_pixel(64, 64, image::Rgb([200, 10, 10]))
        .write_to(&mut image, image::ImageFormat::Png)
        .expect("memory");
    let image = image.into_inner();
    let obj = |at: [f64; 2]| {
        let [x, y] = at;
        format!(
            "mtllib a.mtl\nv {x} {y} 0\nv {} {y} 0\nv {x} {} 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3\nf 1 2\n\
             usemtl b\nf 3/1 2/2 1/3\n",
            x + 1.001,
            y + 1.001
        )
    };
    let mut asked = [0; 2];
    let mut read = |at| {
        let open = &mut |path: &Path| match path.to_str() {
            Some("a.mtl") => Ok(b"newmtl a\nKd 1 1 1\nmap_Kd a.png\nnewmtl b\nmap_Kd none.png\n".to_vec()),
            Some("a.png") => {
                asked[0] += 1;
                Ok(image.clone())
            }
            _ => {
                asked[1] += 1;
                nothing(path)
            }
        };
        parse(obj(at).into(), Path::new("a.obj"), open).expect("a mesh")
    };
    let (near, far) = (read([0.0; 2]), read([500_000.0, 4e6]));
    assert_eq!(asked, [2, 2]);
    assert!(far.offset != DVec3::ZERO && near.offset == DVec3::ZERO);
    assert_eq!((&near.notes, &near.surfaces), (&far.notes, &far.surfaces));
    assert_eq!(
        (&near.surface_of, &near.columns.uvs),
        (&far.surface_of, &far.columns.uvs)
    );
    assert_eq!((near.images.len(), far.images.len()), (1, 1));
    assert_eq!(near.texture_files, far.texture_files);

    let folder = tempfile::tempdir().expect("a folder");
    let peak = |x: f64| {
        let path = folder.path().join("a.obj");
        let line = |i: u32| {
            format!(
                "v {} {} 0\n",
                x + f64::from(i % 100) * 0.001,
                f64::from(i / 100) * 0.001
            )
        };
        let vertices: String = (0..10_000).map(line).collect();
        let faces: String = (1..9_800)
            .map(|i| format!("f {i} {} {}\n", i + 1, i + 100))
            .collect();
        std::fs::write(&path, vertices + &faces).expect("it is written");
        let fits = |memory: &u64| load_within(&path, &mut Vec::new(), *memory << 14).is_ok();
        (1..1000).find(fits).expect("it fits")
    };
    let (near, far) = (peak(0.0), peak(500_000.0));
    // The text of the file is longer, too.
    assert!(far < near + near / 8, "{near} {far}");
}

/// Whoever does not ask for the offset gets the coordinates of the file, rounded as ever.
#[test]
fn scenes_and_queries_are_in_world_space() {
    let mesh = || {
        load(
            "v 500000.001 4000000 9\nv 500001.001 4000000 9\nv 500000.001 4000001 9.5\nf 1 2 3\n",
            "a.obj",
        )
    };
    let mut builder = SceneBuilder::new();
    mesh().add_to(&mut builder, None).expect("it fits");
    let scene = builder.finish();
    assert_eq!(
        (scene.offset(), scene.bounds().lower),
        (DVec3::ZERO, Vec3::new(500_000.0, 4e6, 9.0))
    );
    let mut builder = SceneBuilder::new();
    builder.set_offset(mesh().offset).expect("a position");
    mesh().add_to(&mut builder, None).expect("it fits");
    let scene = builder.finish();
    let lower = scene.bounds().lower.as_dvec3() + scene.offset();
    assert!(
        lower.distance(DVec3::new(500_000.001, 4e6, 9.0)) < 1e-6,
        "{lower}"
    );
    let mut moved = mesh();
    moved.move_offset(DVec3::ZERO);
    assert_eq!((moved.offset, moved.columns.x[0]), (DVec3::ZERO, 500_000.0));

    let mesh = mesh();
    let geometry = Geometry::from_mesh_at(&mesh.columns, mesh.offset).expect("a geometry");
    let [lower, _] = geometry.bounds().expect("bounds");
    assert!(
        lower.distance(DVec3::new(500_000.001, 4e6, 9.0)) < 1e-6,
        "{lower}"
    );
    let [corner, ..] = geometry.triangle(0);
    assert!(
        corner.distance(DVec3::new(500_000.001, 4e6, 9.0)) < 1e-6,
        "{corner}"
    );
}

/// Vertices of glTF are `f32`: if they are far from 0 themselves, turning them by a node makes them no finer.
#[test]
fn vertices_that_are_lost_stay_as_they_are() {
    let offset_of = |at: f32, node: &str, sharing| {
        let corners = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].map(|x: f32| x + at);
        let bytes: Vec<u8> = corners.map(f32::to_le_bytes).concat();
        let json = format!(
            r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0,{node}}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],"buffers":[{{"byteLength":36,"uri":"a.bin"}}],
"bufferViews":[{{"buffer":0,"byteLength":36}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}}]}}"#
        );
        let open = &mut |_: &Path| Ok(bytes.clone());
        let mesh = parse_shared(json.into(), Path::new("a.gltf"), open, sharing).expect("a mesh");
        mesh.offset
    };
    let turned = r#""rotation":[-0.70710677,0,0,0.70710677]"#;
    for sharing in [Sharing::Never, Sharing::Always] {
        assert_eq!(offset_of(500_000.0, turned, sharing), DVec3::ZERO);
        let moved = format!(r#"{turned},"translation":[500000,0,0.1]"#);
        assert_ne!(offset_of(1.0, &moved, sharing), DVec3::ZERO);
        let shrunk = r#""scale":[1e-4,1e-4,1e-4],"translation":[500000,0,0.1]"#;
        assert_ne!(offset_of(0.5, shrunk, sharing), DVec3::ZERO);
    }
}

/// Shared meshes of a glTF file stay shared: their placements are moved.
#[test]
fn placements_are_moved() {
    let bytes: Vec<u8> = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]
        .map(f32::to_le_bytes)
        .concat();
    let json = r#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0,1]}],
"nodes":[{"mesh":0,"translation":[500000.0009765625,4000000,0]},{"mesh":0,"translation":[500001,4000001,1]}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"buffers":[{"byteLength":36,"uri":"a.bin"}],
"bufferViews":[{"buffer":0,"byteLength":36}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}]}"#;
    let load = |sharing| {
        let open = &mut |_: &Path| Ok(bytes.clone());
        parse_shared(json.into(), Path::new("a.gltf"), open, sharing).expect("a mesh")
    };
    let (baked, shared) = (load(Sharing::Never), load(Sharing::Always));
    assert_eq!((baked.offset, shared.shared.len()), (shared.offset, 1));
    assert_eq!(positions(&baked)[0], [500_000.000_976_562_5, 4e6, 0.0]);
    let first = shared.shared[0].placements[0].point(Vec3::ZERO).as_dvec3() + shared.offset;
    assert_eq!(first.to_array(), [500_000.000_976_562_5, 4e6, 0.0]);
}

/// A triangle at 0 among map coordinates makes only itself coarse.
#[test]
fn an_outlier_does_not_make_a_mesh_coarse() {
    let mut obj = String::new();
    for i in 0..100 {
        obj += &format!("v {}.001 {}.003 9\n", 500_000 + i % 10, 4_000_000 + i / 10);
    }
    for i in 0..90 {
        if i % 10 < 9 {
            obj += &format!("f {} {} {} {}\n", i + 1, i + 2, i + 12, i + 11);
        }
    }
    let fine = load(obj.as_str(), "a.obj");
    let mesh = load(obj + "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\n", "a.obj");
    let (found, expected) = (positions(&mesh), positions(&fine));
    assert_eq!(found.len(), 103);
    assert!(fine.notes.is_empty(), "{:?}", fine.notes);
    let expected_note = "a.obj: 3 vertices are far from all others: the mesh is 4000009 long, but 9 without them, so the rest is \
                         a dot in a picture of all";
    assert_eq!(mesh.notes, [expected_note]);
    for (found, expected) in found.iter().zip(&expected) {
        let far = DVec3::from_array(*found).distance(DVec3::from_array(*expected));
        assert!(far < 1e-5, "{found:?} {expected:?}");
    }
}

/// Stray vertices are noted near 0, too, but not those that no face uses, which are dropped, nor a mesh that is merely long.
#[test]
fn stray_vertices_are_noted() {
    let square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 1\nf 1 2 3 4\nf 1 2 5\n";
    let notes = |more: &str| load(format!("{square}{more}"), "a.obj").notes;
    assert_eq!(
        notes("v 0 0 1e6\nf 1 2 -1\n"),
        [
            "a.obj: 1 vertex is far from all others: the mesh is 1000000 long, but 1 without it, so the rest is a dot in a \
             picture of all"
        ]
    );
    for more in ["", "v 0 0 1e6\n", "v 0 0 900\nf 1 2 -1\n"] {
        assert!(notes(more).is_empty(), "{more}");
    }
    // As many elsewhere.
    let other = "v 0 0 1e6\nv 1 0 1e6\nv 1 1 1e6\nv 0 1 1e6\nf -1 -2 -3 -4\n";
    assert!(notes(other).is_empty());
    // A vertex that no face uses does not make the others coarse either.
    let far = "v 500000.001 4000000 9\nv 500001.001 4000000 9\nv 500000.001 4000001 9.5\nf 1 2 3\n";
    let (alone, unused) = (
        load(far, "a.obj"),
        load(format!("v 0 0 0\n{}", far.replace("1 2 3\n", "2 3 4\n")), "a.obj"),
    );
    assert_eq!((unused.offset, &unused.notes), (alone.offset, &alone.notes));
    assert_eq!(positions(&unused), positions(&alone));
}

//! The fuzz targets. `fuzz/` calls these functions with bytes that a fuzzer makes up; `tests/library/replay.rs` calls
//! them with the seeds and with every input that once failed.

pub mod archive;
#[cfg(feature = "cli")]
pub mod arguments;
mod grammar;
pub mod picture;
mod shapes;

use octray::{
    accel::Bvh,
    error::escape,
    format::{Loaded, load_any, load_from_bytes, load_from_bytes_within, mesh as any_mesh, ply},
    ray::{Hit, PrimitiveId},
    render::{Film, Mode, Settings, render as render_frame},
    scene::{Camera, Scene, SceneBuilder, TexturePoint, TriangleMesh},
};
use std::{
    io,
    ops::ControlFlow,
    path::Path,
    time::{Duration, Instant},
};

/// No mesh takes longer to read, smooth and add to a scene.
const MOST_TIME: Duration = Duration::from_secs(10);

/// The content of every mesh that a fuzzed scene names.
const MESH: &[u8] = b"ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
    property float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 0\n1 0 0\n0 1 0\n0 0 1\n4 0 1 2 3\n3 1 2 3\n";

/// The content of every file of placements that a fuzzed scene names.
const PLACEMENTS: &[u8] =
    b"0.5 0 0 # a position\n0 -1 0 1  1 0 0 -1  0 0 -0.5 0.3\n1 0 0 0  0 2 0 0  0 0 1 2  0 0 0 1\n";

/// Loads a scene, or shows the error. Panics if either fails.
fn load(text: &[u8]) -> Option<Scene> {
    let open = &mut |path: &Path| match path.to_str() {
        Some("no.ply") => Err(io::ErrorKind::NotFound.into()),
        Some("loop.scn") => Ok(b"include loop.scn".to_vec()),
        // A new path each time, up to the depth that is allowed.
        Some(deep) if deep.ends_with("deep.scn") => Ok(b"include x/deep.scn".to_vec()),
        Some(_) if path.extension().is_some_and(|extension| extension == "scn") => {
            Ok(b"material matte\nsphere 0 0 0.5 0.2\nmesh a.ply".to_vec())
        }
        Some(_) if path.extension().is_some_and(|extension| extension == "txt") => Ok(PLACEMENTS.to_vec()),
        _ => Ok(MESH.to_vec()),
    };
    load_from_bytes(text, Path::new("fuzz.scn"), open)
        .map_err(|error| show(&error))
        .ok()
}

fn show(error: &octray::error::LoadError) {
    let text = format!("{error}{}", error.report());
    assert!(
        text.split('\n').all(|line| escape(line) == line),
        "control characters: {text:?}"
    );
    // An escaped message of a thousand characters for each level of inclusion, twice.
    assert!(text.len() < 400_000, "an error of {} bytes", text.len());
}

/// Scene text.
pub fn scn(bytes: &[u8]) {
    if let Some(mut scene) = load(bytes) {
        let columns = scene.triangles().material.len() + scene.spheres().material.len();
        assert_eq!(scene.primitive_count(), columns);
        let frames = scene.frame_count();
        for time in [0.0, f64::from(frames) * 0.7, frames.into()] {
            if let Err(error) = scene.set_time(time) {
                assert!(scene.moves(), "{error}");
            }
            let bounds = scene.bounds();
            assert!(bounds.is_empty() || bounds.lower.is_finite() && bounds.upper.is_finite());
        }
    }
}

/// A file of placements, text or an array.
pub fn placements(bytes: &[u8]) {
    const SCENE: &[u8] = b"material matte\ninstance a.ply scale 2 placements a rotate 1 0 0 30\n";
    let open = &mut |path: &Path| Ok(if path.ends_with("a") { bytes } else { MESH }.to_vec());
    let start = Instant::now();
    match load_from_bytes(SCENE, Path::new("fuzz.scn"), open) {
        Ok(scene) => {
            // A placement has at least three numbers, of a digit and a space or of four bytes.
            assert!(scene.instances().len() <= bytes.len().div_ceil(6));
            let bounds = scene.bounds();
            assert!(bounds.lower.is_finite() && bounds.upper.is_finite() || scene.instances().is_empty());
        }
        Err(error) => show(&error),
    }
    assert!(start.elapsed() < MOST_TIME, "{:?}", start.elapsed());
}

/// An image of one pixel, BMP.
const PIXEL: &[u8] =
    b"BM\x3a\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\x01\0\0\0\x01\0\0\0\x01\0\x18\0\0\0\0\0\x04\0\0\0\
    \0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x10\x20\xff\0";

/// A mesh file. Each image that it names has one pixel.
pub fn ply(bytes: &[u8]) {
    any(bytes, "fuzz.ply", PIXEL);
    match ply::parse(bytes, Path::new("fuzz.ply")) {
        Ok(mesh) => {
            check(&mesh);
            assert!(mesh.x.len() <= bytes.len() && mesh.triangles.len() <= bytes.len());
        }
        Err(error) => show(&error),
    }
}

/// Expects columns of equal length, finite numbers and indices of vertices.
fn check(mesh: &TriangleMesh) {
    let vertices = mesh.x.len();
    assert!(mesh.y.len() == vertices && mesh.z.len() == vertices);
    assert!(mesh.normals.is_empty() || mesh.normals.len() == vertices);
    assert!(mesh.uvs.is_empty() || mesh.uvs.len() == vertices);
    assert!(mesh.tangents.is_empty() || mesh.tangents.len() == vertices);
    assert!(mesh.tangents.as_flattened().iter().all(|x| x.is_finite()));
    assert!(mesh.uvs.as_flattened().iter().all(|uv| uv.is_finite()));
    let numbers = mesh.x.iter().chain(&mesh.y).chain(&mesh.z);
    assert!(numbers.copied().all(f32::is_finite));
    let mut corners = mesh.triangles.iter().flatten();
    assert!(corners.all(|&index| (index as usize) < vertices));
}

/// An OBJ file and, after a byte of value 0, the material file that it names.
pub fn obj(bytes: &[u8]) {
    let mut parts = bytes.splitn(2, |&byte| byte == 0);
    let file = parts.next().unwrap_or_default();
    let library = parts.next().unwrap_or(b"newmtl a\nKd 1 0 0\nKs 1\nNs 9\n");
    any(file, "fuzz.obj", library);
}

/// An OFF file.
pub fn off(bytes: &[u8]) {
    any(bytes, "fuzz.off", b"");
}

/// An STL file, text or binary.
pub fn stl(bytes: &[u8]) {
    any(bytes, "fuzz.stl", b"");
}

/// A glTF file, JSON or binary. Each file that it names has 64 bytes.
pub fn gltf(bytes: &[u8]) {
    any(bytes, "fuzz.gltf", &[0x3f; 64]);
    let open = &mut |_: &Path| Ok(vec![0x3f; 64]);
    let start = Instant::now();
    if let Ok(mesh) = any_mesh::parse_shared(
        bytes.to_vec(),
        Path::new("fuzz.gltf"),
        open,
        any_mesh::Sharing::Always,
    ) {
        let of_parts = mesh.shared.iter().map(|part| &part.columns);
        of_parts.for_each(check);
        let _ = mesh.add_to(&mut SceneBuilder::new(), None);
    }
    let moment = any_mesh::Moment {
        animation: None,
        seconds: 0.5,
    };
    if let Ok(mesh) = any_mesh::parse_posed(bytes.to_vec(), Path::new("fuzz.gltf"), open, moment) {
        check(&mesh.columns);
    }
    assert!(start.elapsed() < MOST_TIME, "{:?}", start.elapsed());
}

/// What a 3MF file may take: a small one may hold much.
const THREEMF_MEMORY: u64 = 256 << 20;

/// A 3MF file, or the text of its model part.
pub fn threemf(bytes: &[u8]) {
    let of_model;
    let archive = if bytes.starts_with(b"PK\x03\x04") {
        bytes
    } else {
        of_model = archive::of_model(bytes);
        &of_model
    };
    let start = Instant::now();
    match load_any(archive, Path::new("fuzz.3mf"), &mut Vec::new(), THREEMF_MEMORY) {
        Ok(Loaded::Mesh(mesh)) => {
            // What parts inflate to counts, and components may place an object often.
            let most = 3 * (8 * 1033 * archive.len() + (1 << 22));
            use_mesh(*mesh, most, &mut SceneBuilder::within(THREEMF_MEMORY));
        }
        Ok(Loaded::Scene(_)) => panic!("an archive is no scene"),
        Err(error) => show(&error),
    }
    assert!(start.elapsed() < MOST_TIME, "{:?}", start.elapsed());
}

/// A VTK file.
pub fn vtk(bytes: &[u8]) {
    let open = &mut |_: &Path| Err(std::io::ErrorKind::NotFound.into());
    let start = Instant::now();
    match any_mesh::parse_within(bytes.to_vec(), Path::new("fuzz.vtk"), open, MEMORY) {
        Ok(mesh) => {
            // What blocks inflate to counts.
            let most = 100 * (1033 * bytes.len() + 64);
            use_mesh(mesh, most, &mut SceneBuilder::within(MEMORY));
        }
        Err(error) => show(&error),
    }
    assert!(start.elapsed() < MOST_TIME, "{:?}", start.elapsed());
}

/// What a load may take, bytes: a few bytes of a file may be an image of a gigabyte, or compressed triangles.
const MEMORY: u64 = 256 << 20;

/// A mesh file; `named` is the content of each file that it names.
fn any(bytes: &[u8], name: &str, named: &[u8]) {
    let open = &mut |_: &Path| Ok(named.to_vec());
    let start = Instant::now();
    match any_mesh::parse_within(bytes.to_vec(), Path::new(name), open, MEMORY) {
        Ok(mesh) => use_mesh(mesh, 100 * (bytes.len() + 64), &mut SceneBuilder::new()),
        Err(error) => show(&error),
    }
    assert!(start.elapsed() < MOST_TIME, "{:?}", start.elapsed());
}

/// An image all around a sphere.
fn environment(bytes: &[u8]) {
    let scene = b"environment a rotate 30\nmaterial matte\nsphere 0 0 0.5 0.5\n";
    let open = &mut |_: &Path| Ok(bytes.to_vec());
    match load_from_bytes_within(scene, Path::new("fuzz.scn"), open, MEMORY) {
        Ok(scene) => {
            let environment = scene.environment().expect("an environment");
            for direction in [glam::Vec3::X, glam::Vec3::NEG_Z, glam::Vec3::new(-0.6, 0.0, 0.8)] {
                let color = environment.color(direction);
                assert!(
                    color.iter().all(|light| light.is_finite() && *light >= 0.0),
                    "{color:?}"
                );
            }
        }
        Err(error) => show(&error),
    }
}

/// Checks, smooths and adds a mesh that should have `most` corners at most.
fn use_mesh(mut mesh: any_mesh::LoadedMesh, most: usize, builder: &mut SceneBuilder) {
    check(&mesh.columns);
    let corners = mesh.columns.triangles.len() * 3;
    assert!(corners <= most, "{corners} corners, expected at most {most}");
    if !mesh.surfaces.is_empty() {
        assert_eq!(mesh.surface_of.len(), mesh.columns.triangles.len());
    }
    if mesh.columns.triangles.len() < 100_000 {
        mesh.columns.smooth_normals(45.0).expect("little memory");
        check(&mesh.columns);
    }
    // The builder may refuse a mesh that is too far away.
    let _ = mesh.add_to(builder, None);
}

/// An image all around, and on a triangle, which it cuts out and lights up, too.
pub fn texture(bytes: &[u8]) {
    environment(bytes);
    const MESH: &str =
        "mtllib a.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 3 0\nvt 0 -2\nf 1/1 2/2 3/3\n";
    const LIBRARY: &[u8] = b"newmtl a\nKd 1 1 1\nmap_Kd a\nmap_d a\nmap_Ke a\n";
    let open = &mut |path: &Path| Ok(if path.ends_with("a.mtl") { LIBRARY } else { bytes }.to_vec());
    let start = Instant::now();
    let mesh = any_mesh::parse_within(MESH.into(), Path::new("a.obj"), open, MEMORY);
    let mesh = mesh.expect("a mesh, whatever its image is");
    assert_eq!(mesh.images.len() + mesh.notes.len(), 1, "{:?}", mesh.notes);
    let mut builder = SceneBuilder::new();
    mesh.add_to(&mut builder, None).expect("a scene");
    let scene = builder.finish();
    for [u, v] in [[0.2, 0.3], [0.0, 0.0], [1.0, 0.0]] {
        let id = PrimitiveId(0);
        let _ = scene.is_cut_out(id, [u, v]);
        let point = TexturePoint {
            hit: Hit {
                t: 1.0,
                u,
                v,
                primitive: id,
            }
            .into(),
            point: glam::Vec3::ZERO,
            normal: glam::Vec3::Z,
            direction: glam::Vec3::Z,
            width: u,
        };
        let own = scene.textured(&point);
        let is_share = |channel: &f32| (0.0..=1.0).contains(channel);
        assert!(
            own.base
                .iter()
                .chain(&own.specular)
                .chain(&own.emitted)
                .all(is_share),
            "{own:?}"
        );
    }
    assert!(start.elapsed() < MOST_TIME, "{:?}", start.elapsed());
}

/// A mesh that uses its parts again and again; see [`shapes`]. Each file that it names has 64 bytes.
pub fn mesh_grammar(bytes: &[u8]) {
    let (name, text) = shapes::mesh(bytes);
    any(text.as_bytes(), name, &[0x3f; 64]);
}

/// Text that is almost a scene; see [`grammar`].
pub fn scn_grammar(bytes: &[u8]) {
    scn(grammar::scene(bytes).as_bytes());
}

/// A file that is almost PLY; see [`grammar`].
pub fn ply_grammar(bytes: &[u8]) {
    ply(&grammar::ply(bytes));
}

/// Scene text, rendered by packets and by the scalar reference: the same picture, bit for bit.
pub fn render(bytes: &[u8]) {
    let Some(scene) = load(bytes) else { return };
    let bvh = Bvh::build(&scene);
    let view = 1 + bytes.len() as u32 % 6;
    let Some(camera) = Camera::classic_view(view) else {
        return;
    };
    let film = |mode| -> Film {
        let settings = Settings {
            width: 16,
            height: 16,
            mode,
            ..Settings::default()
        };
        let frame = render_frame(&scene, &bvh, &camera, &settings, &|_| ControlFlow::Continue(()));
        frame.expect("16x16 pixels are within every limit").film
    };
    let (packet, scalar) = (film(Mode::Packet), film(Mode::Scalar));
    let pixels = packet.pixels().iter().zip(scalar.pixels()).enumerate();
    for (i, (packet, scalar)) in pixels {
        let (x, y) = (i % 16, i / 16);
        assert_eq!(
            packet.map(f32::to_bits),
            scalar.map(f32::to_bits),
            "view {view}, pixel {x},{y}: packet {packet:?}, scalar {scalar:?}"
        );
    }
    assert_eq!(packet.to_rgb8(), scalar.to_rgb8());
}

/// Returns the target of this name.
#[allow(dead_code, reason = "fuzz targets call their functions directly")]
pub fn by_name(name: &str) -> Option<fn(&[u8])> {
    match name {
        "scn" => Some(scn),
        "placements" => Some(placements),
        "ply" => Some(ply),
        "obj" => Some(obj),
        "off" => Some(off),
        "stl" => Some(stl),
        "gltf" => Some(gltf),
        "texture" => Some(texture),
        "threemf" => Some(threemf),
        "vtk" => Some(vtk),
        "scn_grammar" => Some(scn_grammar),
        "ply_grammar" => Some(ply_grammar),
        "mesh_grammar" => Some(mesh_grammar),
        "render" => Some(render),
        "picture" => Some(picture::picture),
        #[cfg(feature = "cli")]
        "arguments" => Some(arguments::arguments),
        _ => None,
    }
}

//! Hostile scenes and glTF files: whatever they repeat or promise, they load soon and within their memory, or are refused.

use crate::long::rounds;
use base64::{Engine, prelude::BASE64_STANDARD};
use octray::{
    error::LoadError,
    format::{self, Loaded, mesh},
    scene::Scene,
};
use std::{
    fs::{self, File},
    io::{self, Read},
    path::{Path, PathBuf},
    time::{Duration, Instant},
};
use tempfile::TempDir;

const MEMORY: u64 = 300 << 20;

/// A folder of files.
struct Files(TempDir);

impl Files {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("a folder"))
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.path().join(name);
        fs::write(&path, bytes).expect("a file");
        path
    }

    /// A file of zeros that takes no room on the disk.
    fn zeros(&self, name: &str, length: u64) {
        let file = File::create(self.0.path().join(name)).expect("a file");
        file.set_len(length).expect("its length");
    }
}

fn soon<T>(work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let result = work();
    let time = start.elapsed();
    assert!(time < Duration::from_secs(10), "{time:?}");
    result
}

fn load_mesh(path: &Path, memory: u64) -> Result<mesh::LoadedMesh, LoadError> {
    soon(|| mesh::load_within(path, &mut Vec::new(), memory))
}

fn load_scene(path: &Path, memory: u64) -> Result<Scene, LoadError> {
    soon(|| format::load_within(path, &mut Vec::new(), memory))
}

fn report<T>(result: Result<T, LoadError>) -> String {
    result.err().expect("it is refused").report()
}

/// `count` times `text`, between commas; `#` stands for the number.
fn list(text: &str, count: usize) -> String {
    let items: Vec<String> = (0..count).map(|i| text.replace('#', &i.to_string())).collect();
    items.join(",")
}

fn gltf(body: &str) -> String {
    format!(r#"{{"asset":{{"version":"2.0"}},{body}}}"#)
}

/// A buffer inside the file.
fn buffer(bytes: &[u8]) -> String {
    let data = BASE64_STANDARD.encode(bytes);
    let length = bytes.len();
    format!(
        r#""bufferViews":[{{"buffer":0,"byteLength":{length}}}],
        "buffers":[{{"byteLength":{length},"uri":"data:;base64,{data}"}}]"#
    )
}

/// The positions of a triangle.
fn triangle() -> Vec<u8> {
    let numbers: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    numbers.iter().flat_map(|number| number.to_le_bytes()).collect()
}

/// A file of one triangle, whose nodes are `nodes`.
fn of_nodes(nodes: &str) -> String {
    gltf(&format!(
        r#""nodes":[{nodes}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
        "cameras":[{{"name":"{}","type":"perspective","perspective":{{"yfov":0.5,"znear":0.1}}}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}}],{}"#,
        "é".repeat(1000),
        buffer(&triangle())
    ))
}

const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
    element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

#[test]
fn sparse_accessors_of_nothing() {
    let files = Files::new();
    let body = |indices: &str| {
        let primitive = format!(r#"{{"attributes":{{"POSITION":#}}{indices}}}"#);
        gltf(&format!(
            r#""nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{}]}}],"accessors":[{},
            {{"bufferView":0,"componentType":5121,"count":3,"type":"SCALAR"}}],{}"#,
            list(&primitive, 70),
            list(
                r#"{"componentType":5126,"count":4194304,"type":"VEC3","sparse":{"count":1,
                "indices":{"bufferView":0,"componentType":5121},"values":{"bufferView":0}}}"#,
                70
            ),
            buffer(&triangle())
        ))
    };
    let all = files.write("all.gltf", body(""));
    assert!(report(load_mesh(&all, MEMORY)).contains("triangles, counted once for each node"));
    let few = files.write("few.gltf", body(r#","indices":70"#));
    let mesh = load_mesh(&few, MEMORY).expect("few vertices");
    assert_eq!((mesh.columns.triangles.len(), mesh.columns.x.len()), (70, 70));
}

#[test]
fn sparse_accessors_of_the_same_bytes() {
    let files = Files::new();
    let body = gltf(&format!(
        r#""nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{}]}}],"accessors":[{}],{}"#,
        list(r#"{"attributes":{"POSITION":#}}"#, 100),
        list(
            r#"{"componentType":5120,"count":3,"type":"VEC3","sparse":{"count":10000,
            "indices":{"bufferView":0,"componentType":5121},"values":{"bufferView":0}}}"#,
            100
        ),
        buffer(&[0; 30_000])
    ));
    let path = files.write("a.gltf", body);
    assert!(report(load_mesh(&path, MEMORY)).contains("sparse accessors replace"));
}

#[test]
fn buffers_that_name_one_file() {
    let files = Files::new();
    files.zeros("big.bin", 50 << 20);
    let body = gltf(&format!(
        r#""nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{}]}}],"accessors":[{}],"bufferViews":[{}],"buffers":[{}]"#,
        list(r#"{"attributes":{"POSITION":#}}"#, 200),
        list(
            r#"{"bufferView":#,"componentType":5126,"count":3,"type":"VEC3"}"#,
            200
        ),
        list(r#"{"buffer":#,"byteLength":36}"#, 200),
        list(r#"{"byteLength":36,"uri":"./big.bin"}"#, 199) + r#",{"byteLength":36,"uri":"big.bin"}"#,
    ));
    let path = files.write("a.gltf", &body);
    let mesh = load_mesh(&path, MEMORY).expect("one buffer");
    assert_eq!(mesh.columns.triangles.len(), 200);
    assert!(
        report(load_mesh(&path, 40 << 20))
            .contains("the file has 50.0 MiB, above the memory limit of 40.0 MiB")
    );
    files.zeros("other.bin", 30 << 20);
    let path = files.write("b.gltf", body.replacen("./big.bin", "other.bin", 1));
    assert!(report(load_mesh(&path, 60 << 20)).contains("above the memory limit of 60.0 MiB"));
}

#[test]
fn nodes_of_nothing() {
    let files = Files::new();
    let path = files.write("a.gltf", gltf(&format!(r#""nodes":[{}]"#, list("{}", 1_000_000))));
    assert!(report(load_mesh(&path, MEMORY)).contains("loading takes"));
    let path = files.write("b.gltf", gltf(&format!(r#""nodes":[{}]"#, list("{}", 100_000))));
    assert!(load_mesh(&path, MEMORY).is_ok());
}

/// 88 KB: every node places every primitive, and every primitive names all positions and normals.
#[test]
fn nodes_times_primitives() {
    let files = Files::new();
    let with = |nodes: usize, primitives: usize| {
        let body = gltf(&format!(
            r#""nodes":[{}],"meshes":[{{"primitives":[{}]}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"count":2000,"type":"VEC3"}},
            {{"bufferView":0,"componentType":5121,"count":3,"type":"SCALAR"}}],{}"#,
            list(r#"{"mesh":0}"#, nodes),
            list(
                r#"{"attributes":{"POSITION":0,"NORMAL":0},"indices":1}"#,
                primitives
            ),
            buffer(&[0; 24_000])
        ));
        files.write("a.gltf", body)
    };
    let mesh = load_mesh(&with(1000, 800), 1 << 30).expect("it is not large");
    assert_eq!(
        (mesh.columns.triangles.len(), mesh.columns.x.len()),
        (800_000, 800_000)
    );
    assert!(report(load_mesh(&with(1000, 800), 50 << 20)).contains("BVH included, above the memory limit"));
    assert!(report(load_mesh(&with(8000, 1000), u64::MAX)).contains("8000000 triangles, counted once"));
}

#[test]
fn cameras_of_meshes() {
    let files = Files::new();
    let path = files.write("a.gltf", of_nodes(&list(r#"{"camera":0}"#, 3000)));
    let mesh = load_mesh(&path, MEMORY).expect("cameras");
    assert_eq!(mesh.cameras.len(), 1024);
    assert_eq!(mesh.cameras[0].name, "é".repeat(32));
    assert!(
        mesh.notes.concat().contains("left out: 1976 cameras"),
        "{:?}",
        mesh.notes
    );
    let text = "mesh a.gltf translate # 0 0\n";
    let text: String = (0..2000).map(|i| text.replace('#', &i.to_string())).collect();
    let scene = load_scene(&files.write("a.scn", text), MEMORY).expect("a scene");
    assert_eq!(scene.mesh_cameras().len(), 1024);
}

#[test]
fn cameras_of_a_scene() {
    let text = |count: usize| -> String {
        (0..count)
            .map(|i| format!("camera c{i} eye 1 2 3 target 0 0 0\n"))
            .collect()
    };
    let load = |count| {
        format::load_from_bytes(
            text(count).as_bytes(),
            Path::new("a.scn"),
            &mut |_| Ok(Vec::new()),
        )
    };
    assert_eq!(load(1024).expect("as many as may be").cameras().len(), 1024);
    assert!(report(load(1025)).contains("a.scn:1025:1: more than 1024 cameras in one scene"));
}

fn placements(name: &str, count: usize) -> String {
    (0..count)
        .map(|i| format!("mesh {name} translate {i} 0 0\n"))
        .collect()
}

/// The buffer is read twice, not a hundred times.
#[test]
fn a_mesh_placed_often() {
    let files = Files::new();
    files.zeros("big.bin", 200 << 20);
    let with_buffer = of_nodes(r#"{"mesh":0}"#);
    let start = with_buffer.find(r#""uri":""#).expect("a buffer");
    files.write(
        "a.gltf",
        with_buffer[..start].to_owned() + r#""uri":"big.bin"}]}"#,
    );
    let path = files.write("a.scn", placements("a.gltf", 100));
    let scene = load_scene(&path, MEMORY).expect("a scene");
    assert_eq!(scene.primitive_count(), 100);

    files.write("a.ply", PLY);
    let path = files.write("b.scn", placements("a.ply", 20_000));
    let scene = load_scene(&path, MEMORY).expect("a scene");
    assert_eq!(scene.primitive_count(), 20_000);
    let corner = |i: u32| scene.vertices().position(3 * i) + scene.origin();
    assert_eq!((corner(0).x, corner(1).x, corner(19_999).x), (0.0, 1.0, 19_999.0));
}

/// Surfaces are added once, however often the mesh is placed.
#[test]
fn a_mesh_of_many_materials_placed_often() {
    let files = Files::new();
    let library: String = (0..20_000)
        .map(|i| format!("newmtl m{i}\nKd 0 0 {}\n", f64::from(i) / 20_000.0))
        .collect();
    files.write("a.mtl", library);
    files.write("a.obj", format!("mtllib a.mtl\nusemtl m7\n{OBJ}"));
    let path = files.write("a.scn", placements("a.obj", 1000));
    let scene = load_scene(&path, MEMORY).expect("a scene");
    let materials = &scene.triangles().material;
    assert_eq!(materials.len(), 1000);
    assert!(materials.iter().all(|id| *id == materials[0]));
}

/// A kept mesh looks as one that was just read, with the material of the line or its own.
#[test]
fn copies_are_equal() {
    let files = Files::new();
    files.write("a.mtl", "newmtl m\nKd 1 0 0\n");
    files.write("a.obj", format!("mtllib a.mtl\nusemtl m\n{OBJ}"));
    let text = "mesh a.obj\nmesh a.obj translate 1 0 0\nmesh a.obj translate 2 0 0\nmaterial 1\n\
        mesh a.obj translate 3 0 0\nmaterial own\nmesh a.obj translate 4 0 0 scale -1\n";
    let scene = load_scene(&files.write("a.scn", text), MEMORY).expect("a scene");
    let materials: Vec<u32> = scene.triangles().material.iter().map(|id| id.0).collect();
    assert_eq!(materials, [4, 4, 4, 1, 4]);
    let x: Vec<f32> = scene.vertices().x.iter().map(|x| x + scene.origin().x).collect();
    assert_eq!(
        x,
        [
            0.0, 1.0, 0.0, 1.0, 2.0, 1.0, 2.0, 3.0, 2.0, 3.0, 4.0, 3.0, -4.0, -5.0, -4.0
        ]
    );
    assert_eq!(scene.triangles().corners[4], [12, 14, 13]);
}

/// Few folders are searched for names like the missing ones.
#[test]
fn thousands_of_missing_libraries() {
    let files = Files::new();
    let name = "n".repeat(70);
    for i in 0..rounds(1000, 2000) {
        files.write(&format!("{name}{i}"), "");
    }
    let libraries: String = (0..30).map(|i| format!("mtllib {name}x{i}\n")).collect();
    let mut text = "light 9 -4 10 0.7\n".to_owned();
    let count = rounds(100, 300);
    for i in 0..count {
        files.write(&format!("{i}.obj"), format!("{libraries}{OBJ}"));
        text += &format!("mesh {i}.obj\n");
    }
    let scene = load_scene(&files.write("a.scn", text), MEMORY).expect("a scene");
    assert_eq!(scene.primitive_count(), count);
    assert!(scene.sources().notes.len() <= 1000);
}

#[test]
fn standard_input_without_an_end_or_a_beginning() {
    let load = |reader: &mut dyn Read| -> Result<Loaded, LoadError> {
        soon(|| format::load_any(reader, Path::new("standard input"), &mut Vec::new(), 50 << 20))
    };
    let endless = report(load(&mut io::repeat(b' ')));
    assert_eq!(
        endless,
        "standard input: loading takes 64.0 MiB of memory or more, above the memory limit of 50.0 MiB"
    );
    let empty = report(load(&mut io::empty()));
    assert_eq!(
        empty,
        "standard input: the input is empty, expected a scene or a mesh"
    );
}

/// Its size reads as 0.
#[cfg(target_os = "linux")]
#[test]
fn a_file_without_an_end() {
    let files = Files::new();
    let with_buffer = of_nodes(r#"{"mesh":0}"#);
    let start = with_buffer.find(r#""uri":""#).expect("a buffer");
    let body = with_buffer[..start].to_owned() + r#""uri":"/proc/self/pagemap"}]}"#;
    let path = files.write("a.gltf", body);
    assert!(report(load_mesh(&path, u64::MAX)).contains("the file seems empty but has more than 16.0 MiB"));
    let path = files.write("a.scn", "include /proc/self/pagemap\n");
    assert!(report(load_scene(&path, u64::MAX)).contains("the file seems empty"));
    let path = files.write("a.obj", format!("mtllib /proc/self/pagemap\n{OBJ}"));
    let notes = load_mesh(&path, u64::MAX)
        .expect("a mesh without its library")
        .notes;
    assert!(notes.concat().contains("the file seems empty"), "{notes:?}");
}

/// A link turns from a file into a device and back while it is opened.
#[cfg(unix)]
#[test]
fn a_name_that_changes_its_meaning() {
    use std::{
        os::unix::fs::symlink,
        sync::atomic::{AtomicBool, Ordering},
    };
    let files = Files::new();
    let file = files.write("a.ply", PLY);
    let path = files.0.path().join("link.ply");
    let flip = |to: &Path| {
        let new = files.0.path().join("new");
        symlink(to, &new).expect("a link");
        fs::rename(new, &path).expect("its name");
    };
    flip(&file);
    let stop = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while !stop.load(Ordering::Relaxed) {
                flip(Path::new("/dev/zero"));
                flip(&file);
            }
        });
        let start = Instant::now();
        while start.elapsed() < Duration::from_secs(1) {
            match load_mesh(&path, MEMORY) {
                Ok(mesh) => assert_eq!(mesh.columns.triangles.len(), 1),
                Err(error) => {
                    let message = error.to_string();
                    assert!(
                        message.contains("this is a pipe or a device, expected a file"),
                        "{message}"
                    );
                }
            }
        }
        stop.store(true, Ordering::Relaxed);
    });
}

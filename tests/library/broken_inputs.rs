//! Hundreds of broken scenes and meshes: each must load or be refused, quickly and without a panic.
//!
//! `OCTRAY_LONG=1` breaks shipped meshes at more places.

use crate::{long::rounds, random::Random};
use octray::format::{load, load_from_bytes, mesh as any_mesh, ply};
use std::{
    fs, io,
    panic::{AssertUnwindSafe, catch_unwind},
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

/// Far more than any input needs on a slow, busy machine.
const TIME_LIMIT: Duration = Duration::from_secs(5);

const SCENE: &[u8] = b"// a scene\nlight 9 -4 10 0.7\nmaterial 2\r\nsphere 0.65 -0.6 0.4 0.2 // ball\n\
    ply_file a.ply\nply_file \"b c.ply\"\nmaterial 1";

const LANGUAGE: &[u8] = b"camera \"a b\" eye 3 2 1.5 target 0 0 0.5 up 0 0 1 fov 30\nbackground bottom 1 1 1 top 0 0 1\n\
    ambient 0.3\nlight 9 -4 10 0.7 color 1 0.8 0.6\nmaterial blinn_phong cd 0.5 0.2 1 cs 1 1 1 kd 0.5 ks 0.5 alpha 20\n\
    mesh \"b c.ply\" scale 1 -2 1 rotate 1 1 0 33 translate 0 0 1\nmaterial reflection mix 0.5\n\
    triangle 0 0 0 1 0 0 0 1 1\ninclude part.scn\nmaterial own\nmesh a.ply scale 2\n\
    camera c eye 1 0 0 target 0 0 0 ortho 2 aperture 0.1 focus 3\nmaterial matte checker 0 0 1 size 2\n\
    plane 0 0 1 normal 0 1 1";

fn header(format: &str, vertices: &str, faces: &str) -> String {
    format!(
        "ply\nformat {format} 1.0\ncomment a mesh\nelement vertex {vertices}\nproperty float x\nproperty float y\n\
         property float z\nelement face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )
}

fn ascii_mesh() -> Vec<u8> {
    (header("ascii", "4", "2") + "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n3 0 1 2\n").into_bytes()
}

fn binary_mesh() -> Vec<u8> {
    let mut bytes = header("binary_little_endian", "4", "1").into_bytes();
    let corners = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0];
    bytes.extend(corners.iter().flat_map(|value| value.to_le_bytes()));
    bytes.push(4);
    bytes.extend([0_i32, 1, 2, 3].iter().flat_map(|index| index.to_le_bytes()));
    bytes
}

/// Runs `work`; fails with `what` if it panics or takes too long.
fn must_end<T>(what: &str, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let done = catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|_| panic!("{what}: a panic"));
    let took = start.elapsed();
    assert!(took < TIME_LIMIT, "{what}: {took:?}");
    done
}

/// Returns whether the scene loads.
fn scene(what: &str, text: &[u8]) -> bool {
    must_end(what, || {
        let open = &mut |path: &Path| match path.to_str() {
            Some("a.ply") => Ok(ascii_mesh()),
            Some("b c.ply") => Ok(binary_mesh()),
            Some("part.scn") => Ok(b"material matte\nply_file a.ply".to_vec()),
            _ => Err(io::ErrorKind::NotFound.into()),
        };
        match load_from_bytes(text, Path::new("broken.scn"), open) {
            Ok(_) => true,
            Err(error) => !error.report().starts_with("broken.scn:"),
        }
    })
}

fn mesh(what: &str, bytes: &[u8]) -> bool {
    must_end(what, || match ply::parse(bytes, Path::new("broken.ply")) {
        Ok(mesh) => {
            assert!(mesh.triangles.len() <= bytes.len());
            true
        }
        Err(error) => !error.report().starts_with("broken.ply:"),
    })
}

/// Every truncation, two flips of every byte, and random bytes spliced in.
fn broken(valid: &[u8], random: &mut Random) -> Vec<(String, Vec<u8>)> {
    let mut inputs = Vec::new();
    for length in 0..valid.len() {
        inputs.push((format!("cut at {length}"), valid[..length].to_vec()));
        for _ in 0..2 {
            let bit = random.below(8);
            let mut flipped = valid.to_vec();
            flipped[length] ^= 1 << bit;
            inputs.push((format!("bit {bit} of byte {length} flipped"), flipped));
        }
    }
    for i in 0..200 {
        let mut spliced = valid.to_vec();
        let (at, count) = (random.below(valid.len()), 1 + random.below(16));
        let bytes = random.bytes(count);
        let replaced = at..valid.len().min(at + random.below(16));
        spliced.splice(replaced, bytes);
        inputs.push((format!("splice {i}"), spliced));
    }
    inputs
}

#[test]
fn broken_scenes() {
    let mut random = Random(1);
    for valid in [SCENE, LANGUAGE] {
        assert!(scene("valid", valid));
        let loaded = broken(valid, &mut random)
            .iter()
            .filter(|(what, text)| scene(what, text))
            .count();
        assert!(loaded > 0, "a scene cut behind a line is a scene");
    }
    for count in 0..300 {
        scene("random bytes", &random.bytes(count * 7));
    }
}

#[test]
fn broken_text_meshes() {
    assert!(mesh("valid", &ascii_mesh()));
    for (what, bytes) in broken(&ascii_mesh(), &mut Random(2)) {
        mesh(&what, &bytes);
    }
}

#[test]
fn broken_binary_meshes() {
    let valid = binary_mesh();
    assert!(mesh("valid", &valid));
    let mut random = Random(3);
    for (what, bytes) in broken(&valid, &mut random) {
        let loaded = mesh(&what, &bytes);
        assert!(!(loaded && what.starts_with("cut")), "{what} was not noticed");
    }
    for count in 0..300 {
        let bytes = random.bytes(count * 7);
        mesh("random bytes", &bytes);
        for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
            let vertices = (count / 2).to_string();
            mesh(
                "random body",
                &[header(format, &vertices, "50").as_bytes(), &bytes].concat(),
            );
        }
    }
}

/// Returns whether a mesh of any format loads.
fn read_any(what: &str, name: &str, bytes: Vec<u8>) -> bool {
    let length = bytes.len();
    must_end(what, || {
        let open = &mut |_: &Path| Ok(b"newmtl a\nKd 1 0\nKs 1\nNs x\n".to_vec());
        match any_mesh::parse(bytes, Path::new(name), open) {
            Ok(mesh) => {
                let columns = &mesh.columns;
                let vertices = columns.x.len();
                let finite = |column: &[f32]| column.iter().all(|value| value.is_finite());
                assert!(finite(&columns.x) && finite(&columns.y) && finite(&columns.z));
                assert!(columns.normals.is_empty() || columns.normals.len() == vertices);
                let corners = columns.triangles.as_flattened();
                assert!(corners.iter().all(|&index| (index as usize) < vertices));
                assert!(
                    corners.len() <= 100 * length,
                    "{} corners of {length} bytes",
                    corners.len()
                );
                if !mesh.surfaces.is_empty() {
                    assert_eq!(mesh.surface_of.len(), columns.triangles.len());
                }
                true
            }
            Err(error) => !error.report().starts_with(name),
        }
    })
}

/// Shipped meshes of each format.
#[test]
fn broken_meshes_of_every_format() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/meshes");
    for name in [
        "vase.obj",
        "house.stl",
        "gear.stl",
        "mobile.gltf",
        "helix.ply",
        "stairs.3mf",
    ] {
        let valid = fs::read(folder.join(name)).expect("a shipped mesh");
        assert!(read_any(name, name, valid.clone()));
        let mut random = Random(valid.len() as u64);
        // Every byte of a large file would take too long.
        for _ in 0..rounds(200, 1500) {
            let at = random.below(valid.len());
            read_any(&format!("{name} cut at {at}"), name, valid[..at].to_vec());
            let mut flipped = valid.clone();
            flipped[at] ^= 1 << random.below(8);
            read_any(&format!("{name}: byte {at} flipped"), name, flipped);
            let mut spliced = valid.clone();
            let count = 1 + random.below(8);
            spliced.splice(at..valid.len().min(at + random.below(8)), random.bytes(count));
            read_any(&format!("{name}: bytes at {at} replaced"), name, spliced);
        }
        for count in 0..200 {
            read_any("random bytes", name, random.bytes(count * 7));
            let start = random.below(valid.len());
            let bytes = [&valid[..start], &random.bytes(count)].concat();
            read_any("a random end", name, bytes);
        }
    }
}

#[test]
fn hostile_meshes() {
    let json = |body: &str| format!(r#"{{"asset":{{"version":"2.0"}},{body}}}"#).into_bytes();
    let children: String = (1..50_000).map(|i| format!(r#"{{"children":[{i}]}},"#)).collect();
    let deep = format!(r#""scenes":[{{"nodes":[0]}}],"nodes":[{children}{{}}]"#);
    assert!(read_any("deep nodes", "a.gltf", json(&deep)));
    read_any(
        "deep JSON",
        "a.gltf",
        json(&format!(r#""extras":{}"#, "[".repeat(100_000))),
    );
    // A small mesh may be placed 20,000 times, a large one may not.
    let many = (0..20_000).map(|_| r#"{"mesh":0}"#).collect::<Vec<_>>().join(",");
    let data = "A".repeat(4 * 12 * 1000);
    let bomb = format!(
        r#""nodes":[{many}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":1,"type":"VEC3"}},
        {{"bufferView":0,"componentType":5121,"count":36000,"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":36000}}],
        "buffers":[{{"byteLength":36000,"uri":"data:;base64,{data}"}}]"#
    );
    assert!(!must_end("a mesh placed too often", || {
        let open = &mut |_: &Path| Err(io::ErrorKind::NotFound.into());
        any_mesh::parse(json(&bomb), Path::new("a.gltf"), open).is_ok()
    }));
    let polygon = format!("v 0 0 0\nf{}\n", " 1".repeat(500_000));
    assert!(read_any(
        "a polygon of many corners",
        "a.obj",
        polygon.into_bytes()
    ));
    read_any("joined lines", "a.obj", b"v 0 0 0 \\\n".repeat(100_000));
    read_any("one long line", "a.obj", vec![b'f'; 1_000_000]);
    read_any("many words", "a.obj", b"f ".repeat(500_000));
    read_any(
        "many materials",
        "a.obj",
        b"mtllib a b\nusemtl a\n".repeat(10_000),
    );
    read_any("solids", "a.stl", b"solid\nendsolid\n".repeat(100_000));
}

#[test]
fn huge_counts_and_odd_types() {
    let counts = [
        "-1",
        "1e9",
        "99999999",
        "4294967295",
        "4294967296",
        "18446744073709551615",
        "18446744073709551616",
        "",
    ];
    let types = [
        "char", "uchar", "short", "ushort", "int", "uint", "float", "double", "string", "",
    ];
    for format in ["ascii", "binary_little_endian", "binary_big_endian", "text", ""] {
        for count in counts {
            for element in ["vertex", "face", "other"] {
                let text =
                    header(format, "1", "1").replace(&format!("{element} 1"), &format!("{element} {count}"));
                mesh(
                    &format!("{format} {element} {count}"),
                    (text + "0 0 0\n3 0 0 0\n").as_bytes(),
                );
            }
        }
        for count in types {
            for item in types {
                let text = header(format, "1", "1").replace("uchar int", &format!("{count} {item}"));
                for body in [
                    "0 0 0\n3 0 0 0\n",
                    "0 0 0\n-1 0",
                    "nan inf 1e999",
                    "\u{ff}\u{ff}\u{ff}\u{ff}\u{ff}\u{ff}",
                ] {
                    mesh(
                        &format!("{format} {count} {item}"),
                        (text.clone() + body).as_bytes(),
                    );
                }
            }
        }
    }
    // Records without properties take no bytes: any count fits, and none may be visited.
    let nothing = format!(
        "ply\nformat ascii 1.0\nelement nothing {}\nelement vertex 0\nend_header\n",
        u64::MAX
    );
    assert!(mesh("records of nothing", nothing.as_bytes()));
}

#[test]
fn long_inputs() {
    let million = 1_000_000;
    scene("one long word", &vec![b'x'; million]);
    scene(
        "one long comment",
        &[b"//".as_slice(), &vec![b'/'; million]].concat(),
    );
    scene("only newlines", &vec![b'\n'; million]);
    scene("only quotes", &vec![b'"'; million]);
    scene(
        "long numbers",
        &[b"sphere 0 0 0 0.".as_slice(), &vec![b'1'; 60_000], b"\n"].concat(),
    );
    let deep = format!("ply_file {}a.ply", "a/".repeat(20_000));
    scene("a deep path", deep.as_bytes());
    let start = header("ascii", "1", "1").into_bytes();
    let word = "x".repeat(500_000);
    let odd = format!("ply\nformat ascii 1.0\nelement face 1\nproperty {word} {word}\nend_header\n");
    let error = ply::parse(odd.as_bytes(), Path::new("a.ply")).expect_err("no such type");
    assert!(
        error.report().len() < 1000,
        "an error of {} bytes",
        error.report().len()
    );
    mesh(
        "a long number",
        &[start.as_slice(), &vec![b'1'; million], b" 0 0\n0\n"].concat(),
    );
    mesh(
        "a long header",
        &[b"ply\n".as_slice(), &vec![b'p'; 2 * million]].concat(),
    );
    let properties = "property list uchar uchar vertex_indices\n".repeat(20_000);
    mesh(
        "many lists",
        format!("ply\nformat ascii 1.0\nelement face 1\n{properties}end_header\n").as_bytes(),
    );
    let polygon = [
        header("ascii", "1", "1").as_bytes(),
        b"0 0 0\n500000",
        &b" 0".repeat(500_000),
    ]
    .concat();
    assert!(!mesh(
        "a polygon of a list type too small",
        &polygon[..polygon.len() - 3]
    ));
    assert!(mesh("a polygon of many corners", &polygon));
}

/// An empty folder for this test.
fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

/// The error of a scene file, without its name.
fn refused(what: &str, path: &Path) -> String {
    let error = must_end(what, || load(path)).expect_err(what);
    error.to_string().replace(&*path.to_string_lossy(), "SCENE")
}

/// Ten thousand lines that name one mesh must not become ten thousand meshes, however they write its path.
#[test]
fn one_mesh_named_ten_thousand_times() {
    let folder = folder();
    let inside = |name: &str| folder.path().join(name);
    fs::create_dir(inside("folder")).expect("created");
    let corners = 100_000;
    let mut mesh = header("binary_little_endian", &corners.to_string(), "0").into_bytes();
    mesh.extend(std::iter::repeat_n(0, corners * 12));
    fs::write(inside("mesh.ply"), mesh).expect("written");
    let text = "ply_file mesh.ply\nply_file ././mesh.ply\nply_file folder/../mesh.ply\n".repeat(4000);
    fs::write(inside("many.scn"), text).expect("written");
    let scene = must_end("many times", || load(&inside("many.scn"))).expect("loaded");
    assert_eq!(scene.vertices().x.len(), corners);
}

#[test]
fn files_that_are_none() {
    let folder = folder();
    let inside = |name: &str| folder.path().join(name);
    assert_eq!(refused("missing", &inside("no.scn")), "SCENE: file not found");
    assert_eq!(
        refused("a folder", folder.path()),
        "SCENE: this is a directory, expected a file"
    );
    assert!(load(Path::new("")).is_err());
    let deep: PathBuf = std::iter::repeat_n("deep", 2000).collect();
    // Long paths lose their middle.
    for path in [deep, inside(&"x".repeat(5000))] {
        let error = refused("a long path", &path);
        assert!(error.len() < 300 && error.contains("..."), "{error}");
    }

    fs::write(inside("empty.scn"), "").expect("written");
    assert_eq!(
        load(&inside("empty.scn"))
            .expect("nothing is a scene")
            .primitive_count(),
        0
    );
    for (mesh, reason) in [
        (".", "this is a directory, expected a file"),
        ("no.ply", "file not found"),
    ] {
        fs::write(inside("mesh.scn"), format!("\n  ply_file {mesh}")).expect("written");
        let error = refused(mesh, &inside("mesh.scn"));
        assert!(
            error.starts_with("SCENE:2:12: cannot load ") && error.ends_with(reason),
            "{error}"
        );
    }
    fs::write(inside("self.scn"), "ply_file self.scn").expect("written");
    assert!(refused("itself", &inside("self.scn")).contains("not a PLY mesh"));
}

#[cfg(unix)]
#[test]
fn pipes_devices_and_locked_files() {
    use std::{
        os::unix::{ffi::OsStrExt, fs::PermissionsExt},
        process::Command,
    };
    let folder = folder();
    let inside = |name: &str| folder.path().join(name);
    let message = "SCENE: this is a pipe or a device, expected a file";
    for device in ["/dev/zero", "/dev/null"] {
        assert_eq!(refused(device, Path::new(device)), message);
    }
    let pipe = inside("pipe.scn");
    if Command::new("mkfifo")
        .arg(&pipe)
        .status()
        .is_ok_and(|status| status.success())
    {
        assert_eq!(refused("a pipe", &pipe), message);
        fs::write(inside("mesh.scn"), "ply_file pipe.scn").expect("written");
        assert!(refused("a pipe as mesh", &inside("mesh.scn")).ends_with("expected a file"));
    }
    fs::write(inside("zero.scn"), "ply_file /dev/zero").expect("written");
    assert!(refused("zeros as mesh", &inside("zero.scn")).ends_with("expected a file"));

    // Claims to be a regular file, but reading waits for the kernel's next message.
    if Path::new("/proc/kmsg").is_file() {
        let direct = must_end("the kernel's messages", || load(Path::new("/proc/kmsg")).is_err());
        fs::write(inside("kernel.scn"), "include /proc/kmsg").expect("written");
        let included = must_end("the same, included", || load(&inside("kernel.scn")).is_err());
        fs::write(inside("kernel.scn"), "ply_file /proc/kmsg").expect("written");
        let mesh = must_end("the same as mesh", || load(&inside("kernel.scn")).is_err());
        assert!(direct && included && mesh);
    }

    std::os::unix::fs::symlink(inside("loop.scn"), inside("loop.scn")).expect("a link");
    assert!(refused("a link to itself", &inside("loop.scn")).starts_with("SCENE: "));

    let odd = folder
        .path()
        .join(std::ffi::OsStr::from_bytes(b"\x1b[2J\xff.scn"));
    let error = must_end("an odd name", || load(&odd))
        .expect_err("missing")
        .to_string();
    assert!(!error.contains('\x1b'), "{error:?}");

    let locked = inside("locked.scn");
    fs::write(&locked, "").expect("written");
    fs::set_permissions(&locked, fs::Permissions::from_mode(0o000)).expect("locked");
    // The super-user may read it nevertheless.
    if fs::read(&locked).is_err() {
        assert!(refused("locked", &locked).contains("permission denied"));
    }
}

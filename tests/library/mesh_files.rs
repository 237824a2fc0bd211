//! All readers of a mesh agree with each other and, for OBJ, with tobj.

use crate::random::Random;
use octray::{error::LoadError, format::mesh, scene::TriangleMesh};
use std::{fmt::Write as _, fs, io, path::Path};

/// Positions with normals, and polygons.
struct Polygons {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    faces: Vec<Vec<u32>>,
}

impl Polygons {
    /// Faces have from `corners[0]` to `corners[0] + corners[1]` corners. Each vertex is one of a face with three or more.
    fn new(count: u32, corners: [u32; 2]) -> Self {
        let mut random = Random(u64::from(count) + 1);
        let number = |random: &mut Random| (random.below(2_000_001) as f32 - 1e6) * 1e-5;
        let mut vectors = || {
            (0..count)
                .map(|_| std::array::from_fn(|_| number(&mut random)))
                .collect()
        };
        let (positions, normals) = (vectors(), vectors());
        let faces = (0..2 * count).map(|i| {
            let corners = corners[0] as usize + random.below(corners[1] as usize + 1);
            let others = (1..corners).map(|_| random.below(count as usize) as u32);
            let mut face: Vec<u32> = [i % count].into_iter().chain(others).collect();
            face.truncate(corners);
            face
        });
        let mut faces: Vec<Vec<u32>> = faces.collect();
        let mut used = vec![false; count as usize];
        for &corner in faces.iter().filter(|face| face.len() > 2).flatten() {
            used[corner as usize] = true;
        }
        let unused = (0..count).filter(|&i| !used[i as usize]);
        faces.extend(unused.map(|i| vec![0, i, count - 1]));
        Self {
            positions,
            normals,
            faces,
        }
    }

    /// The triangles as the OBJ reader makes them; OBJ has no faces of fewer than three corners.
    fn triangles(&self) -> Vec<[u32; 3]> {
        let triangles = read(self.obj().into_bytes(), "a.obj").triangles;
        let corners = self.faces.iter().map(|face| face.len().saturating_sub(2));
        assert_eq!(triangles.len(), corners.sum::<usize>());
        triangles
    }

    /// A PLY file; `extra` adds properties around those that are needed.
    fn ply(&self, format: &str, extra: bool) -> Vec<u8> {
        let (uchar, short) = if extra {
            ("property uchar red\n", "property short flags\n")
        } else {
            ("", "")
        };
        let mut bytes = format!(
            "ply\nformat {format} 1.0\nelement vertex {}\n{uchar}property float x\nproperty float y\nproperty float z\n\
             property float nx\nproperty float ny\nproperty float nz\n{short}element face {}\n{short}\
             property list uchar int vertex_indices\n{uchar}end_header\n",
            self.positions.len(),
            self.faces.len()
        )
        .into_bytes();
        for (position, normal) in self.positions.iter().zip(&self.normals) {
            let numbers: Vec<f32> = position.iter().chain(normal).copied().collect();
            if format == "ascii" {
                let words: Vec<String> = numbers.iter().map(ToString::to_string).collect();
                let line = words.join(" ");
                bytes.extend(
                    if extra {
                        format!("7 {line} -3\n")
                    } else {
                        format!("{line}\n")
                    }
                    .into_bytes(),
                );
                continue;
            }
            bytes.extend(&[7][..usize::from(extra)]);
            for number in numbers {
                bytes.extend(if format.contains("big") {
                    number.to_be_bytes()
                } else {
                    number.to_le_bytes()
                });
            }
            bytes.extend(&[0, 1][..2 * usize::from(extra)]);
        }
        for face in &self.faces {
            if format == "ascii" {
                let words: Vec<String> = face.iter().map(ToString::to_string).collect();
                let line = format!("{} {}", face.len(), words.join(" "));
                bytes.extend(
                    if extra {
                        format!("-3 {line} 7\n")
                    } else {
                        format!("{line}\n")
                    }
                    .into_bytes(),
                );
                continue;
            }
            bytes.extend(&[0, 1][..2 * usize::from(extra)]);
            bytes.push(face.len() as u8);
            for index in face {
                bytes.extend(if format.contains("big") {
                    index.to_be_bytes()
                } else {
                    index.to_le_bytes()
                });
            }
            bytes.extend(&[7][..usize::from(extra)]);
        }
        bytes
    }

    /// An OBJ file; each corner has the normal of its vertex.
    fn obj(&self) -> String {
        let mut text = String::new();
        for [x, y, z] in &self.positions {
            let _ = writeln!(text, "v {x} {y} {z}");
        }
        for [x, y, z] in &self.normals {
            let _ = writeln!(text, "vn {x} {y} {z}");
        }
        for face in self.faces.iter().filter(|face| face.len() > 2) {
            let corners: Vec<String> = face.iter().map(|i| format!("{0}//{0}", i + 1)).collect();
            let _ = writeln!(text, "f {}", corners.join(" "));
        }
        text
    }
}

fn parse(bytes: Vec<u8>, name: &str) -> Result<mesh::LoadedMesh, LoadError> {
    let mut nothing = |_: &Path| Err(io::ErrorKind::NotFound.into());
    mesh::parse(bytes, Path::new(name), &mut nothing)
}

fn read(bytes: Vec<u8>, name: &str) -> TriangleMesh {
    let parsed = parse(bytes, name).unwrap_or_else(|error| panic!("{error}"));
    parsed.columns
}

/// Loads a file with these bytes: the mesh, or the error without the folder.
fn load(bytes: &[u8], name: &str) -> Result<TriangleMesh, String> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(name);
    fs::write(&path, bytes).expect("the file is written");
    let place = format!("{}/", folder.path().display());
    let loaded = mesh::load(&path).map_err(|error| error.to_string().replace(&place, ""))?;
    Ok(loaded.columns)
}

fn assert_same(a: &TriangleMesh, b: &TriangleMesh) {
    assert!(a.x == b.x && a.y == b.y && a.z == b.z && a.normals == b.normals && a.triangles == b.triangles);
}

#[test]
fn ply_of_every_layout() {
    // Sizes for one thread and for several, which read 4096 records or 128 KiB of text at a time; triangles, quads and
    // mixed faces.
    for (count, corners) in [
        (3, [3, 0]),
        (50, [4, 0]),
        (5_000, [3, 0]),
        (5_000, [4, 0]),
        (9_000, [3, 4]),
        (500, [0, 5]),
    ] {
        let polygons = Polygons::new(count, corners);
        let triangles = polygons.triangles();
        for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
            for extra in [false, true] {
                let bytes = polygons.ply(format, extra);
                let loaded = load(&bytes, "a.ply").expect("a mesh");
                let mesh = read(bytes, "a.ply");
                assert_same(&mesh, &loaded);
                let found = (0..mesh.x.len()).map(|i| [mesh.x[i], mesh.y[i], mesh.z[i]]);
                assert!(
                    found.eq(polygons.positions.iter().copied()),
                    "{count} {corners:?} {format}"
                );
                let normals = mesh.normals.iter().map(glam::Vec3::to_array);
                assert!(
                    normals.eq(polygons.normals.iter().copied()),
                    "{count} {corners:?} {format}"
                );
                assert!(mesh.triangles == triangles, "{count} {corners:?} {format}");
            }
        }
    }
}

/// The place of a fault deep in a large file is right.
#[test]
fn faults_in_large_files() {
    let mut polygons = Polygons::new(12_000, [3, 0]);
    polygons.faces[18_678][1] = 12_000;
    let refused = |bytes: Vec<u8>| {
        let mut nothing = |_: &Path| Err(io::ErrorKind::NotFound.into());
        let of_file = load(&bytes, "a.ply").expect_err("it is refused");
        let error = mesh::parse(bytes, Path::new("a.ply"), &mut nothing).expect_err("it is refused");
        assert_eq!(error.to_string(), of_file);
        of_file
    };
    let message = "vertex index 12000, but the file has only 12000 vertices";
    assert_eq!(
        refused(polygons.ply("ascii", false)),
        format!("a.ply:{}:1: {message}", 12 + 12_000 + 18_679)
    );
    assert!(
        refused(polygons.ply("binary_little_endian", true))
            .starts_with(&format!("a.ply: {message} (face 18679"))
    );
    polygons.faces[18_678][1] = 0;
    polygons.positions[9_456][2] = f32::NAN;
    let faces = polygons.faces.iter();
    let without = faces.filter(|face| face.contains(&9_456)).count();
    for format in ["ascii", "binary_big_endian"] {
        let mesh = parse(polygons.ply(format, false), "a.ply").expect("a mesh");
        let note =
            format!("a.ply: left out: 1 vertex that is NaN or too large, {without} triangles that use it");
        assert_eq!(mesh.notes, [note]);
        assert_eq!(
            (mesh.columns.x.len(), mesh.columns.triangles.len()),
            (11_999, 24_000 - without)
        );
    }
    for position in &mut polygons.positions {
        position[2] = f32::NAN;
    }
    assert!(refused(polygons.ply("ascii", false)).starts_with("a.ply:13:"));
    assert!(
        refused(polygons.ply("binary_big_endian", false)).starts_with("a.ply: vertex 1 of 12000: z is NaN")
    );
}

/// A 3MF file of the same triangles gives the same mesh.
#[cfg(feature = "threemf")]
#[test]
fn threemf_of_triangles() {
    for count in [3, 5000] {
        let polygons = Polygons::new(count, [3, 0]);
        let vertex = |[x, y, z]: &[f32; 3]| format!("<vertex x='{x}' y=\"{y}\" z=' {z} '/>");
        let vertices: String = polygons.positions.iter().map(vertex).collect();
        let triangle = |corners: &Vec<u32>| {
            let [a, b, c] = corners[..] else {
                unreachable!("three corners")
            };
            format!("<triangle v3=\"{c}\" v1=\"{a}\" v2=\"{b}\">\n</triangle>")
        };
        let triangles: String = polygons.faces.iter().map(triangle).collect();
        let model = format!(
            "<?xml version='1.0'?><model><resources><object id='4'><mesh><vertices>{vertices}</vertices>\
             <triangles>{triangles}</triangles></mesh></object></resources><build><item objectid='4'/></build></model>"
        );
        let bytes = crate::targets::archive::of_model(model.as_bytes());
        // The name does not matter: an archive is nothing else.
        let (file, mesh) = (load(&bytes, "a.obj").expect("a mesh"), read(bytes, "a.3mf"));
        assert_same(&file, &mesh);
        let found = (0..mesh.x.len()).map(|i| [mesh.x[i], mesh.y[i], mesh.z[i]]);
        assert!(found.eq(polygons.positions.iter().copied()) && mesh.triangles == polygons.triangles());
    }
}

/// A file that is read in pieces gives the same mesh and the same errors as its bytes.
#[test]
fn a_file_is_what_its_bytes_are() {
    let plain = Polygons::new(2_000, [3, 0]).ply("binary_little_endian", false);
    let long_header = format!("ply\n{}", "comment nothing to be read here\n".repeat(2_000));
    let long = [long_header.as_bytes(), &plain[4..]].concat();
    assert_same(
        &read(plain.clone(), "a.ply"),
        &load(&long, "a.ply").expect("a mesh"),
    );

    let replaced = |from: &str, to: &str| {
        let body = plain
            .windows(11)
            .position(|word| word == b"end_header\n")
            .expect("a header");
        let header = String::from_utf8_lossy(&plain[..body]).replace(from, to);
        [header.as_bytes(), &plain[body..]].concat()
    };
    for bytes in [
        plain[..plain.len() - 1].to_vec(),
        plain[..150].to_vec(),
        plain[..20].to_vec(),
        Vec::new(),
        replaced("element face 4000", "element face 4001"),
        replaced("element vertex 2000", "element vertex 1999"),
        replaced("element vertex 2000", "element vertex 18446744073709551615"),
        replaced("property float y", "property list uchar float y"),
        replaced("float", "flaot"),
        [long_header.as_bytes(), &plain[4..90]].concat(),
    ] {
        let mut nothing = |_: &Path| Err(io::ErrorKind::NotFound.into());
        let error = mesh::parse(bytes.clone(), Path::new("a.ply"), &mut nothing).expect_err("it is refused");
        assert_eq!(load(&bytes, "a.ply").err(), Some(error.to_string()));
    }
}

/// Every corner of an OBJ file is as tobj reads it.
#[test]
fn obj_as_tobj_reads_it() {
    // Triangles only: tobj makes fans of concave polygons, too.
    let polygons = Polygons::new(700, [3, 0]);
    let text = polygons.obj();
    let ours = read(text.clone().into_bytes(), "a.obj");
    let options = tobj::LoadOptions {
        triangulate: true,
        single_index: true,
        ..tobj::LoadOptions::default()
    };
    let (models, _) = tobj::load_obj_buf(&mut text.as_bytes(), &options, |_| {
        Err(tobj::LoadError::OpenFileFailed)
    })
    .expect("tobj reads it");
    let theirs = &models[0].mesh;
    let corners = ours.triangles.as_flattened();
    assert_eq!((models.len(), corners.len()), (1, theirs.indices.len()));
    for (&our, &their) in corners.iter().zip(&theirs.indices) {
        let (our, their) = (our as usize, 3 * their as usize);
        assert_eq!(
            [ours.x[our], ours.y[our], ours.z[our]],
            theirs.positions[their..their + 3]
        );
        assert_eq!(ours.normals[our].to_array(), theirs.normals[their..their + 3]);
    }
}

/// A seed of the fuzz target `gltf`; `None` if it is not there.
#[cfg(feature = "gltf")]
fn seed(name: &str) -> Option<Vec<u8>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("fuzz/seeds/gltf")
        .join(name);
    let bytes = std::fs::read(&path).ok();
    if bytes.is_none() {
        println!("skipped: {} is not there", path.display());
    }
    bytes
}

/// The middle of each triangle, with what its corners have: sorted, because compression reorders triangles.
#[cfg(feature = "gltf")]
fn sorted_triangles(mesh: &TriangleMesh) -> Vec<[f32; 11]> {
    let mut all: Vec<[f32; 11]> = mesh
        .triangles
        .iter()
        .map(|corners| {
            let mut sum = [0.0; 11];
            for i in corners.map(|corner| corner as usize) {
                let normal = mesh.normals[i].to_array();
                let position = [mesh.x[i], mesh.y[i], mesh.z[i]];
                let values = [&position[..], &normal, &mesh.colors[i]].concat();
                for (sum, value) in sum.iter_mut().zip(values) {
                    *sum += value / 3.0;
                }
            }
            sum
        })
        .collect();
    let key = |row: &[f32; 11]| [row[0], row[1], row[2]].map(|x| (x * 50.0).round() as i32);
    all.sort_by_key(key);
    all
}

/// A sphere with normals and colours, by `gltf-pipeline -d` and `gltfpack -cc`, is the sphere.
#[cfg(feature = "gltf")]
#[test]
fn compressed_gltf_is_what_was_compressed() {
    let Some(plain) = seed("sphere.gltf") else { return };
    let plain = load(&plain, "sphere.gltf").expect("a mesh");
    let expected = sorted_triangles(&plain);
    assert_eq!(expected.len(), 80);
    for name in ["draco.glb", "meshopt.glb"] {
        let Some(bytes) = seed(name) else { return };
        let found = sorted_triangles(&load(&bytes, name).expect("a mesh"));
        assert_eq!(found.len(), expected.len(), "{name}");
        for (found, expected) in found.iter().zip(&expected) {
            let is_near = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.02);
            assert!(is_near, "{name}: {found:?}, expected {expected:?}");
        }
        // Any byte may be wrong.
        let bits = [1, 0x40, 0xff];
        for at in 0..bytes.len() {
            for bit in crate::long::rounds(&bits[at % 3..=at % 3], &bits) {
                let mut broken = bytes.clone();
                broken[at] ^= bit;
                let _ = parse(broken, name);
            }
        }
    }
}

//! The generated seeds of `fuzz/seeds`, whose names begin with `made-`: one file for each feature of a format. The other
//! seeds are written by hand.

use crate::targets::archive::{RELATIONSHIPS, stored};
use std::{fmt::Write as _, io::Write as _};

/// A seed: target, name, bytes.
pub type Seed = (&'static str, String, Vec<u8>);

pub fn all() -> Vec<Seed> {
    let mut seeds = Vec::new();
    plies(&mut seeds);
    textured_plies(&mut seeds);
    objs(&mut seeds);
    stls(&mut seeds);
    gltfs(&mut seeds);
    offs(&mut seeds);
    threemfs(&mut seeds);
    #[cfg(feature = "vtk")]
    seeds.extend(crate::vtk::seeds());
    textures(&mut seeds);
    placements(&mut seeds);
    arguments(&mut seeds);
    choices(&mut seeds);
    seeds
}

fn add(seeds: &mut Vec<Seed>, target: &'static str, name: &str, bytes: impl Into<Vec<u8>>) {
    seeds.push((target, format!("made-{name}"), bytes.into()));
}

/// Every number type for coordinates and indices in every encoding.
fn plies(seeds: &mut Vec<Seed>) {
    const TYPES: [(&str, usize); 8] = [
        ("char", 1),
        ("uchar", 1),
        ("short", 2),
        ("ushort", 2),
        ("int", 4),
        ("uint", 4),
        ("float", 4),
        ("double", 8),
    ];
    let points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]];
    let faces: [&[i32]; 3] = [&[0, 1, 2], &[0, 2, 3, 1], &[3, 1, 2]];
    for (kind, size) in TYPES {
        for encoding in ["ascii", "binary_little_endian", "binary_big_endian"] {
            let index = if kind == "float" || kind == "double" {
                ("int", 4)
            } else {
                (kind, size)
            };
            let header = format!(
                "ply\nformat {encoding} 1.0\ncomment seed\nelement vertex 4\nproperty {kind} x\nproperty {kind} y\n\
                 property {kind} z\nelement face 3\nproperty list uchar {} vertex_indices\nproperty uchar red\n\
                 end_header\n",
                index.0
            );
            let mut bytes = header.into_bytes();
            let mut put = |value: i32, (kind, size): (&str, usize)| {
                if encoding == "ascii" {
                    bytes.extend(format!("{value} ").into_bytes());
                    return;
                }
                let mut number = match kind {
                    "float" => (value as f32).to_le_bytes().to_vec(),
                    "double" => f64::from(value).to_le_bytes().to_vec(),
                    _ => value.to_le_bytes()[..size].to_vec(),
                };
                if encoding == "binary_big_endian" {
                    number.reverse();
                }
                bytes.extend(number);
            };
            for value in points.as_flattened() {
                put(*value, (kind, size));
            }
            for face in faces {
                put(face.len() as i32, ("uchar", 1));
                for &corner in face {
                    put(corner, index);
                }
                put(200, ("uchar", 1));
            }
            add(seeds, "ply", &format!("{kind}-{encoding}.ply"), bytes);
        }
    }
}

fn textured_plies(seeds: &mut Vec<Seed>) {
    let points = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
    let body = "end_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
    for (name, header, faces) in [
        (
            "corners",
            "element face 2\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\n\
             property int texnumber\n",
            "4 0 1 2 3 8 0 0 1 0 1 1 0 1 1\n3 0 1 2 6 0 0 1 0 0.5 nan 0\n",
        ),
        (
            "colored",
            "element face 2\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\n\
             property uchar red\nproperty uchar green\nproperty uchar blue\n",
            "3 0 1 2 6 0 0 1 0 1 1 255 0 0\n3 0 2 3 0 0 255 0\n",
        ),
    ] {
        let text = format!(
            "ply\nformat ascii 1.0\ncomment TextureFile a b.png\ncomment TextureFile c.png\n{points}{header}{body}{faces}"
        );
        add(seeds, "ply", &format!("{name}.ply"), text);
    }
    let vertices =
        "property float s\nproperty float t\nelement face 1\nproperty list uchar int vertex_indices\n";
    let text = format!(
        "ply\nformat ascii 1.0\ncomment TextureFile a.png\n{points}{vertices}end_header\n0 0 0 0 0\n1 0 0 1 0\n\
         1 1 0 1 1\n0 1 0 0 inf\n4 0 1 2 3\n"
    );
    add(seeds, "ply", "vertices.ply", text);
}

fn objs(seeds: &mut Vec<Seed>) {
    let square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.5\nvn 0 0 1\nvt 0 0\n";
    for (name, faces) in [
        ("plain", "f 1 2 3\nf 1 3 4\n"),
        ("from_the_end", "f -4 -3 -2\nf -4//-1 -2//-1 -1//-1\n"),
        ("all_indices", "f 1/1/1 2/1/1 3/1/1 4/1/1\n"),
        ("texture_only", "f 1/1 2/1 3/1\n"),
        (
            "materials",
            "usemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\ng group\ns 1\no name\n",
        ),
        ("joined_lines", "f 1 \\\n2 \\\r\n3\n"),
        ("odd_words", "l 1 2\np 1\ncurv 0 1 1 2\n# comment\nf 1 2 3\n"),
    ] {
        let library = "newmtl a\nKd 1 0 0\nKs 0.5 0.5 0.5\nNs 20\nnewmtl b\nKd 0 1 0\nd 0.5\nillum 2\n";
        let text = format!("mtllib a.mtl\n{square}{faces}\0{library}");
        add(seeds, "obj", &format!("{name}.obj"), text);
    }
}

/// Text with all counts of numbers, and arrays of all shapes and types.
fn placements(seeds: &mut Vec<Seed>) {
    let text = "# trees\n1 2 3\n\n0 -1 0 4  1 0 0 5  0 0 1 6 // turned\n1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\r\n";
    add(seeds, "placements", "text.txt", text);
    let matrix = [1, 0, 0, 5, 0, 1, 0, 6, 0, 0, 1, 7, 0, 0, 0, 1];
    for (name, shape, count) in [
        ("positions", "2, 3", 6),
        ("rows", "1, 12", 12),
        ("matrices", "1, 16", 16),
        ("nested_rows", "1, 3, 4", 12),
        ("nested_matrices", "1, 4, 4", 16),
        ("cut", "3, 3", 8),
    ] {
        for kind in ["<f4", "<f8"] {
            let header =
                format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({shape}), }}          \n");
            let mut bytes = b"\x93NUMPY\x01\0".to_vec();
            bytes.extend((header.len() as u16).to_le_bytes());
            bytes.extend(header.as_bytes());
            for number in &matrix[..count] {
                if kind == "<f4" {
                    bytes.extend((*number as f32).to_le_bytes());
                } else {
                    bytes.extend(f64::from(*number).to_le_bytes());
                }
            }
            add(seeds, "placements", &format!("{name}-{}.npy", &kind[1..]), bytes);
        }
    }
}

fn stls(seeds: &mut Vec<Seed>) {
    let facet = |x: f32| [0.0, 0.0, 1.0, x, 0.0, 0.0, x + 1.0, 0.0, 0.0, x, 1.0, 0.0];
    let mut text = String::from("solid a\n");
    for x in [0.0, 2.0] {
        let [nx, ny, nz, rest @ ..] = facet(x);
        let _ = writeln!(text, "facet normal {nx} {ny} {nz}\nouter loop");
        for corner in rest.chunks_exact(3) {
            let _ = writeln!(text, "vertex {} {} {}", corner[0], corner[1], corner[2]);
        }
        text.push_str("endloop\nendfacet\n");
    }
    text.push_str("endsolid a\n");
    add(seeds, "stl", "upper.stl", text.to_uppercase());
    add(seeds, "stl", "text.stl", text);
    let mut bytes = vec![b' '; 80];
    bytes.extend(2u32.to_le_bytes());
    for x in [0.0, 2.0] {
        for number in facet(x) {
            bytes.extend(number.to_le_bytes());
        }
        bytes.extend([0; 2]);
    }
    add(seeds, "stl", "binary.stl", &bytes[..]);
    bytes[..6].copy_from_slice(b"solid ");
    add(seeds, "stl", "binary_that_says_solid.stl", bytes);
}

fn gltfs(seeds: &mut Vec<Seed>) {
    let json = |uri: &str, extra: &str| {
        format!(
            r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0,"scale":[1,2,1]{extra}}},
{{"mesh":0,"rotation":[0,0,0.7071068,0.7071068],"translation":[1,0,0]}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},
"indices":1,"mode":4,"material":0}}]}}],"materials":[{{"pbrMetallicRoughness":{{"baseColorFactor":[1,0.5,0,1]}}}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}},
{{"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}}],"bufferViews":[{{"buffer":0,"byteLength":36}},
{{"buffer":0,"byteOffset":36,"byteLength":6}}],"buffers":[{{"byteLength":44{uri}}}]}}"#
        )
    };
    let child = r#","children":[1]"#;
    // Positions 0 0 0, 1 0 0, 0 1 0, then the indices 0 1 2.
    let data = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAABAAIAAAA=";
    let embedded = format!(r#","uri":"data:application/octet-stream;base64,{data}""#);
    add(seeds, "gltf", "embedded.gltf", json(&embedded, child));
    add(seeds, "gltf", "file.gltf", json(r#","uri":"a.bin""#, child));
    add(
        seeds,
        "gltf",
        "camera.gltf",
        json(
            &embedded,
            r#","camera":0},{"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,5,6,7,1]"#,
        )
        .replace(
            r#""scene":0"#,
            r#""cameras":[{"type":"perspective","perspective":{"yfov":0.8,"znear":0.1}}],"scene":0"#,
        ),
    );
    let instancing = r#","extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":3,"ROTATION":2,"SCALE":3}}}"#;
    add(
        seeds,
        "gltf",
        "instances.gltf",
        json(&embedded, &format!("{instancing}{child}")).replace(
            r#""type":"SCALAR"}"#,
            r#""type":"SCALAR"},{"bufferView":0,"componentType":5126,"count":2,"type":"VEC4"},
{"bufferView":0,"componentType":5126,"count":2,"type":"VEC3"}"#,
        ),
    );
    // Two joints move the first corner, and a target all of them.
    let posed = r#""targets":[{"POSITION":0}],"attributes":{"JOINTS_0":2,"WEIGHTS_0":3,"#;
    add(
        seeds,
        "gltf",
        "posed.gltf",
        json(&embedded, &format!(r#","skin":0,"weights":[0.5]{child}"#))
            .replace(r#""attributes":{"#, posed)
            .replace(
                r#""type":"SCALAR"}"#,
                r#""type":"SCALAR"},{"componentType":5121,"count":3,"type":"VEC4","sparse":{"count":1,
"indices":{"bufferView":1,"componentType":5121},"values":{"bufferView":1}}},
{"bufferView":0,"byteOffset":12,"componentType":5121,"count":3,"type":"VEC4"}"#,
            )
            .replace(r#""scene":0"#, r#""skins":[{"joints":[1,0]}],"scene":0"#),
    );
    let mut text = json("", child).into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut bin: Vec<u8> = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]
        .iter()
        .flat_map(|number| number.to_le_bytes())
        .collect();
    bin.extend([0, 0, 1, 0, 2, 0, 0, 0]);
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    glb.extend((12 + 8 + text.len() + 8 + bin.len()).to_le_bytes()[..4].iter());
    for (kind, chunk) in [(b"JSON", text), (b"BIN\0", bin)] {
        glb.extend(&chunk.len().to_le_bytes()[..4]);
        glb.extend(kind);
        glb.extend(chunk);
    }
    add(seeds, "gltf", "binary.glb", glb);
}

/// Headers, and colours of vertices and faces.
fn offs(seeds: &mut Vec<Seed>) {
    let square = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
    for (name, text) in [
        ("plain", format!("OFF\n4 1 0\n{square}4 0 1 2 3\n")),
        ("no_space", format!("OFF4 2 0 # c\n{square}3 0 1 2\n2 0 1\n")),
        (
            "faces",
            format!("OFF\n4 3 5\n{square}3 0 1 2 255 0 0\n3 0 2 3 0.5 1 1 1\n3 1 2 3 7\n"),
        ),
        ("points", format!("4 0\n{square}")),
        (
            "vertices",
            "CNOFF 2 0\n0 0 0 0 0 1 255 0 9 1\n1 0 0 0 0 1 1 1 1 1\n".to_owned(),
        ),
        (
            "texture",
            "STOFF\n3 1\n0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n".to_owned(),
        ),
    ] {
        add(seeds, "off", &format!("{name}.off"), text);
    }
}

/// Model parts of 3MF files, and whole archives.
fn threemfs(seeds: &mut Vec<Seed>) {
    const SQUARE: &str = r#"<vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/><vertex x="1" y="1" z="0"/>
<vertex x="0" y="1" z="0"/></vertices>"#;
    const TWO: &str =
        r#"<triangles><triangle v1="0" v2="1" v3="2"/><triangle v1="0" v2="2" v3="3"/></triangles>"#;
    let model = |resources: &str, attributes: &str, triangles: &str, build: &str| {
        format!(
            "<?xml version=\"1.0\"?>\n<model unit=\"inch\" xmlns:m=\"http://schemas.microsoft.com/3dmanufacturing/material/2015/02\" \
             requiredextensions=\"m\">\n<resources>{resources}<object id=\"9\" {attributes}><mesh>{SQUARE}{triangles}</mesh></object>\n\
             {build}</model>\n"
        )
    };
    let built = r#"</resources><build><item objectid="9"/></build>"#;
    let plain = model("", "", TWO, built);
    let components = model(
        "",
        "type=\"surface\"",
        TWO,
        r#"<object id="2"><components><component objectid="9" transform="0 1 0 -1 0 0 0 0 1 5 6 7"/><component objectid="9"/>
</components></object></resources><build><item objectid="2" transform="2 0 0 0 2 0 0 0 2 0 0 0"/><item objectid="2"/></build>"#,
    );
    let colors = model(
        r##"<basematerials id="1"><base name="a" displaycolor="#FF0000"/><base name="b" displaycolor="#00FF0080"/></basematerials>
<m:colorgroup id="2"><m:color color="#0000FF"/><m:color color="#FFFF00"/></m:colorgroup>
<m:compositematerials id="3" matid="1" matindices="0 1"><m:composite values="0.25 0.75"/></m:compositematerials>
<m:multiproperties id="4" pids="1 2"><m:multi pindices="0 1"/></m:multiproperties>"##,
        r#"pid="1" pindex="1""#,
        r#"<triangles><triangle v1="0" v2="1" v3="2"/><triangle v1="0" v2="2" v3="3" p1="0"/>
<triangle v1="0" v2="2" v3="3" pid="2" p1="0" p2="1" p3="0"/><triangle v1="0" v2="1" v3="3" pid="3" p1="0"/>
<triangle v1="0" v2="1" v3="3" pid="4" p1="0"/></triangles>"#,
        built,
    );
    let textures = model(
        r#"<m:texture2d id="1" path="/a.png" contenttype="image/png" tilestyleu="mirror"/><m:texture2dgroup id="2" texid="1">
<m:tex2coord u="0" v="0"/><m:tex2coord u="1" v="0"/><m:tex2coord u="0" v="1"/></m:texture2dgroup>"#,
        "",
        r#"<triangles><triangle v1="0" v2="1" v3="2" pid="2" p1="0" p2="1" p3="2"/></triangles>"#,
        built,
    );
    for (name, model) in [
        ("plain", &plain),
        ("components", &components),
        ("colors", &colors),
    ] {
        add(seeds, "threemf", &format!("{name}.model"), model.as_bytes());
    }
    let mut png = std::io::Cursor::new(Vec::new());
    let image = image::RgbImage::from_fn(2, 2, |x, y| image::Rgb([200 * x as u8, 200 * y as u8, 50]));
    image
        .write_to(&mut png, image::ImageFormat::Png)
        .expect("it is written");
    let png = png.into_inner();
    let parts = [("3D/a.model", textures.as_bytes()), ("a.png", &png)];
    add(seeds, "threemf", "textures.3mf", stored(parts));
    let other = r#"<model><resources><object id="1"><components><component p:path="/b.model" objectid="2"/></components></object>
</resources><build><item objectid="1"/></build></model>"#;
    let parts = [
        ("_rels/.rels", RELATIONSHIPS.as_bytes()),
        ("3D/3dmodel.model", other.as_bytes()),
        ("b.model", components.as_bytes()),
    ];
    add(seeds, "threemf", "parts.3mf", stored(parts));
    // As `zip` writes it: the model part is deflated.
    let mut deflater = flate2::write::DeflateEncoder::new(Vec::new(), flate2::Compression::best());
    deflater.write_all(plain.as_bytes()).expect("memory");
    let deflated = deflater.finish().expect("memory");
    let mut archive = stored([("a.model", &deflated[..])]);
    let mut checksum = flate2::Crc::new();
    checksum.update(plain.as_bytes());
    for (magic, offset) in [(b"PK\x01\x02", 10), (b"PK\x03\x04", 8)] {
        let at = archive
            .windows(4)
            .position(|window| window == magic)
            .expect("a header")
            + offset;
        archive[at] = 8;
        if offset == 10 {
            archive[at + 6..at + 10].copy_from_slice(&checksum.sum().to_le_bytes());
            archive[at + 14..at + 18].copy_from_slice(&(plain.len() as u32).to_le_bytes());
        }
    }
    add(seeds, "threemf", "deflated.3mf", archive);
}

/// A small image of each format.
fn textures(seeds: &mut Vec<Seed>) {
    let image = image::RgbaImage::from_fn(5, 3, |x, y| {
        image::Rgba([50 * x as u8, 80 * y as u8, 99, 60 * x as u8])
    });
    let rgb = image::DynamicImage::ImageRgba8(image.clone()).into_rgb8();
    for (name, format) in [
        ("a.png", image::ImageFormat::Png),
        ("a.bmp", image::ImageFormat::Bmp),
        ("a.jpg", image::ImageFormat::Jpeg),
        ("a.gif", image::ImageFormat::Gif),
        ("a.tiff", image::ImageFormat::Tiff),
    ] {
        let mut bytes = std::io::Cursor::new(Vec::new());
        let written = match format {
            image::ImageFormat::Jpeg => rgb.write_to(&mut bytes, format),
            _ => image.write_to(&mut bytes, format),
        };
        written.expect("it is written");
        add(seeds, "texture", name, bytes.into_inner());
    }
    // 1x1 pixels, lossless: RFC 9649.
    let webp = b"RIFF\x1a\0\0\0WEBPVP8L\r\0\0\0\x2f\0\0\0\x10\x07\x10\x11\x11\x88\x88\xfe\x07\0";
    add(seeds, "texture", "a.webp", &webp[..]);
}

/// A valid and an invalid value of each option, and name patterns.
fn arguments(seeds: &mut Vec<Seed>) {
    for (i, values) in [
        ["512x512", "0x5"],
        ["-1,2.5,3e2", "nan,0,0"],
        ["30", "181"],
        ["16", "5"],
        ["2.5", "256"],
        ["1e-3", "1.5"],
        ["0,0,256,128", "1,2,1,4"],
        ["1-24", "9-3"],
        ["0.5", "-1"],
        ["16G", "1.5G"],
    ]
    .iter()
    .enumerate()
    {
        for value in values {
            add(seeds, "arguments", &format!("{i}-{value}"), format!("{i}{value}"));
        }
    }
    for (name, pattern) in [
        ("stem", "out/{stem}-####.png\nscenes/cow.scn"),
        ("two_runs", "a##b###.{stem}"),
        ("no_utf", "ä#ö\n-"),
    ] {
        add(seeds, "arguments", name, format!("n{pattern}"));
    }
}

/// Random bytes, for the targets that read them as choices.
fn choices(seeds: &mut Vec<Seed>) {
    let mut random = fastrand::Rng::with_seed(1);
    for target in ["scn_grammar", "ply_grammar", "picture", "mesh_grammar"] {
        for i in 0..12 {
            let bytes: Vec<u8> = (0..32 << (i / 3)).map(|_| random.u8(..)).collect();
            add(seeds, target, &i.to_string(), bytes);
        }
    }
}

/// A seed that is cut, flipped, and repeats parts of itself.
#[cfg(any(feature = "threemf", feature = "vtk"))]
pub fn broken(seed: &[u8], random: &mut fastrand::Rng) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    for _ in 0..random.usize(1..4) {
        let at = random.usize(..bytes.len());
        match random.u8(..5) {
            0 => bytes.truncate(at.max(1)),
            1 => bytes[at] ^= 1 << random.u8(..8),
            2 => bytes[at] = b'0' + random.u8(..10),
            3 => drop(bytes.splice(at..bytes.len().min(at + random.usize(..20)), [])),
            _ => {
                let from = random.usize(..bytes.len());
                let part = bytes[from..bytes.len().min(from + random.usize(..200))].to_vec();
                bytes.splice(at..at, part);
            }
        }
        if bytes.is_empty() {
            break;
        }
    }
    bytes
}

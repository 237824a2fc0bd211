use super::*;
use crate::format::mesh::UpAxis;
use crate::scene::Projection;
#[cfg(feature = "textures")]
use crate::scene::{Material, Opacity, SurfaceTextures, Texture, Wrap};
use glam::{DVec3, Vec3};
use std::io;

mod animations;
mod lights;
#[cfg(feature = "textures")]
mod normal_maps;
mod optional;
mod poses;
mod sharing;

/// Three positions, a normal each, and indices 0, 1, 2 as bytes.
fn buffer() -> Vec<u8> {
    let numbers: [f32; 18] = [
        0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0,
    ];
    let mut bytes: Vec<u8> = numbers.iter().flat_map(|value| value.to_le_bytes()).collect();
    bytes.extend([0, 1, 2, 0]);
    bytes
}

/// One triangle twice: as it is, and within a node that is within another.
const SCENE: &str = r#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0,1]}],
"nodes":[{"mesh":0},{"children":[2,3],"translation":[10,0,0]},{"mesh":0,"scale":[2,1,1],"rotation":[0,0,1,0]},
{"camera":0,"name":"eye","translation":[0,0,5]}],
"cameras":[{"type":"perspective","perspective":{"yfov":0.5,"znear":0.1}}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0,"NORMAL":1},"indices":2,"material":0}]}],
"materials":[{"pbrMetallicRoughness":{"baseColorFactor":[1,0.5,0,1]}}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
{"bufferView":0,"byteOffset":36,"componentType":5126,"count":3,"type":"VEC3"},
{"bufferView":1,"componentType":5121,"count":3,"type":"SCALAR"}],
"bufferViews":[{"buffer":0,"byteLength":72},{"buffer":0,"byteOffset":72,"byteLength":3}],
"buffers":[{"byteLength":76,"uri":"a%20b.bin"}]}"#;

fn load(json: &str) -> Result<LoadedMesh, String> {
    parse(
        json.as_bytes(),
        Path::new("folder/a.gltf"),
        &mut |path| match path.to_str() {
            Some("folder/a b.bin") => Ok(buffer()),
            _ => Err(io::ErrorKind::NotFound.into()),
        },
        &Budget::unlimited(),
    )
    .map_err(|error| error.to_string().trim_start_matches("folder/a.gltf:").to_owned())
}

fn changed(from: &str, to: &str) -> Result<LoadedMesh, String> {
    assert!(SCENE.contains(from), "{from}");
    load(&SCENE.replacen(from, to, 1))
}

fn refused(from: &str, to: &str) -> String {
    changed(from, to).expect_err("it is refused")
}

#[test]
fn transforms_of_nodes_within_nodes() {
    let mesh = load(SCENE).expect("a mesh");
    assert_eq!(mesh.columns.x, [0.0, 1.0, 0.0, 10.0, 8.0, 10.0]);
    assert_eq!(mesh.columns.y, [0.0, 0.0, 1.0, 0.0, 0.0, -1.0]);
    assert_eq!(mesh.columns.triangles, [[0, 1, 2], [3, 4, 5]]);
    assert_eq!(mesh.columns.normals, [glam::Vec3::Z; 6]);
    assert_eq!((mesh.surfaces.len(), &mesh.surface_of[..]), (1, &[0, 0][..]));
    // 0.5 of linear light is shown as 0.735.
    let [red, green, blue] = mesh.surfaces[0].diffuse;
    assert!(red == 1.0 && (green - 0.735).abs() < 0.001 && blue == 0.0);
    let camera = &mesh.cameras[0];
    assert_eq!(
        (camera.name.as_str(), camera.eye),
        ("eye", DVec3::new(10.0, 0.0, 5.0))
    );
    assert_eq!((camera.target, camera.up), (DVec3::new(10.0, 0.0, 4.0), DVec3::Y));
    let Projection::Perspective { fov_degrees } = camera.projection else {
        panic!("{camera:?}");
    };
    assert!((fov_degrees - 0.5_f64.to_degrees()).abs() < 1e-5);
    assert_eq!(mesh.up, UpAxis::Y);
}

#[test]
fn a_file_of_its_own_or_one_for_all() {
    for [scheme, encoding] in [["data", "base64"], ["DATA", "Base64"]] {
        let as_uri = format!(
            "{scheme}:application/octet-stream;{encoding},{}",
            base64(&buffer())
        );
        let inside = changed("a%20b.bin", &as_uri).expect("a data URI");
        assert_eq!(inside.columns.triangles.len(), 2);
    }

    let json = SCENE.replace(r#","uri":"a%20b.bin""#, "");
    let mut json = json.into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let (json, bin, other) = ((b"JSON", json), (b"BIN\0", buffer()), (b"ABCD", vec![0; 4]));
    let open = &mut |_: &Path| Err(io::ErrorKind::NotFound.into());
    // Chunks of other types are ignored.
    for chunks in [vec![&json, &other, &bin, &other], vec![&json, &bin]] {
        let glb = binary(&chunks);
        let mesh = parse(&glb, Path::new("a.glb"), open, &Budget::unlimited()).expect("a binary file");
        assert_eq!(mesh.columns.x, load(SCENE).expect("a mesh").columns.x);
    }
    let glb = binary(&[&json, &other, &bin]);
    for cut in 0..glb.len() {
        let error = parse(&glb[..cut], Path::new("a.glb"), open, &Budget::unlimited());
        assert!(error.is_err(), "cut at {cut}");
    }
}

/// A .glb file of these chunks.
fn binary(chunks: &[&(&[u8; 4], Vec<u8>)]) -> Vec<u8> {
    let length = 12 + chunks.iter().map(|(_, bytes)| 8 + bytes.len()).sum::<usize>();
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    glb.extend((length as u32).to_le_bytes());
    for (kind, bytes) in chunks {
        glb.extend((bytes.len() as u32).to_le_bytes());
        glb.extend(*kind);
        glb.extend(bytes);
    }
    glb
}

fn base64(bytes: &[u8]) -> String {
    use ::base64::{Engine, prelude::BASE64_STANDARD};
    BASE64_STANDARD.encode(bytes)
}

#[test]
fn strips_fans_and_corners_without_indices() {
    let with = |mode: &str| {
        changed(r#""indices":2,"material":0"#, mode)
            .expect("a mesh")
            .columns
            .triangles
    };
    assert_eq!(with(r#""mode":5"#), [[0, 1, 2], [3, 4, 5]]);
    assert_eq!(with(r#""mode":6"#), [[0, 1, 2], [3, 4, 5]]);
    assert_eq!(with(r#""mode":4"#), [[0, 1, 2], [3, 4, 5]]);
    assert!(with(r#""mode":1"#).is_empty());
}

#[test]
fn what_is_not_read_is_said() {
    assert_eq!(
        refused(
            r#""asset":{"version":"2.0"}"#,
            r#""asset":{"version":"2.0"},"extensionsRequired":["EXT_of_another"]"#
        ),
        " the file requires the extension EXT_of_another, which octray does not support"
    );
    changed(
        r#""asset":{"version":"2.0"}"#,
        r#""asset":{"version":"2.0"},"extensionsRequired":["KHR_materials_unlit"]"#,
    )
    .expect("harmless");
    let colors = changed(r#""NORMAL":1"#, r#""COLOR_0":1"#).expect("harmless");
    assert!(colors.notes.is_empty());
    assert_eq!(colors.columns.colors, [[0.0, 0.0, 1.0]; 6]);
    let more = changed(r#""NORMAL":1"#, r#""COLOR_1":1"#).expect("harmless");
    assert_eq!(more.notes, ["folder/a.gltf: left out: more vertex colours"]);
    let own = changed(r#""NORMAL":1"#, r#""_DENSITY":1"#).expect("harmless");
    assert_eq!(
        own.notes,
        ["folder/a.gltf: left out: custom attributes of vertices"]
    );
    let without = changed(r#""POSITION":0,"NORMAL":1"#, r#""NORMAL":1"#).expect("nothing");
    assert!(without.columns.triangles.is_empty());
    assert_eq!(
        without.notes,
        ["folder/a.gltf: left out: 1 primitive without positions"]
    );
}

#[test]
fn one_note_lists_all_that_is_left_out() {
    const VECTOR: &str =
        r#""SCALAR"},{"bufferView":0,"componentType":5121,"normalized":true,"count":3,"type":"VEC4"}"#;
    assert!(load(SCENE).expect("a mesh").notes.is_empty());
    let asset = r#""asset":{"version":"2.0"},"extensionsUsed":["KHR_lights_punctual","KHR_materials_unlit","KHR_materials_sheen"],
        "extensions":{"KHR_lights_punctual":{"lights":[{"type":"point"},{"type":"odd"}]}},
        "animations":[{"channels":[],"samplers":[]}],"skins":[{"joints":[0]}],
        "textures":[{"source":0}],"images":[{"uri":"a.png"}]"#;
    let json = SCENE
        .replacen(r#""asset":{"version":"2.0"}"#, asset, 1)
        .replacen(
            r#""materials":[{"#,
            r#""materials":[{"alphaMode":"BLEND"},{"alphaMode":"MASK","emissiveFactor":[1,0,0]},{"#,
            1,
        )
        .replacen(
            r#""primitives":[{"attributes":{"POSITION":0"#,
            r#""primitives":[{"mode":0,"attributes":{"POSITION":0}},{"mode":3,"attributes":{"POSITION":0}},
            {"targets":[{"POSITION":0}],"attributes":{"POSITION":0,"COLOR_0":3,"TEXCOORD_0":1"#,
            1,
        )
        .replacen(
            r#""cameras":["#,
            r#""cameras":[{"type":"orthographic","orthographic":{"xmag":1,"ymag":1,"zfar":9,"znear":1}},"#,
            1,
        )
        .replacen(r#""scenes":["#, r#""scene":1,"scenes":[{"nodes":[0]},"#, 1)
        .replace("\"SCALAR\"}", VECTOR);
    let mesh = load(&json).expect("a mesh");
    assert!(mesh.cameras[0].projection == Projection::Orthographic { height: 2.0 });
    assert_eq!(
        mesh.notes,
        [
            "folder/a.gltf: left out: 1 animation, 1 set of points, 1 set of lines, \
             vertex alpha, 1 other scene, extensions `KHR_materials_sheen`"
        ]
    );
}

/// The triangle with texture coordinates from its positions, and a material that shows an image of 3x2 pixels.
#[cfg(feature = "textures")]
fn textured(material: &str, textures: &str) -> Result<LoadedMesh, String> {
    textured_by([255, 0, 0, 100], material, textures)
}

#[cfg(feature = "textures")]
fn textured_by(pixel: [u8; 4], material: &str, textures: &str) -> Result<LoadedMesh, String> {
    let mut png = io::Cursor::new(Vec::new());
    let image = image::RgbaImage::from_pixel(3, 2, image::Rgba(pixel));
    image
        .write_to(&mut png, image::ImageFormat::Png)
        .expect("it is written");
    let uri = format!("data:image/png;base64,{}", base64(png.get_ref()));
    // Pairs: 0 0, 0 1, 0 0.
    let accessor = r#""accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC2"},"#;
    let json = SCENE
        .replacen(r#""accessors":["#, accessor, 1)
        .replacen(
            r#"{"POSITION":0,"NORMAL":1},"indices":2"#,
            r#"{"POSITION":1,"NORMAL":2,"TEXCOORD_1":0},"indices":3"#,
            1,
        )
        .replacen(
            r#""materials":[{"pbrMetallicRoughness":{"baseColorFactor":[1,0.5,0,1]}}]"#,
            material,
            1,
        );
    let images = format!(r#""images":[{{"uri":"no.png"}},{{"uri":"{uri}"}}],"textures":{textures},"asset""#);
    load(&json.replacen(r#""asset""#, &images, 1))
}

#[cfg(feature = "textures")]
#[test]
fn textures_with_sets_transforms_samplers_and_cut_outs() {
    let material = r#""materials":[{"alphaMode":"MASK","alphaCutoff":0.25,"emissiveFactor":[0,0,1],
        "emissiveTexture":{"index":0,"texCoord":1,"extensions":{"KHR_texture_transform":{"offset":[0.5,0]}}},
        "pbrMetallicRoughness":{"baseColorFactor":[1,1,1,0.5],"baseColorTexture":{"index":0,"extensions":
        {"KHR_texture_transform":{"texCoord":1,"offset":[0.5,0],"scale":[2,3],"rotation":1.5707963}}}}}],
        "samplers":[{"wrapS":33071,"wrapT":33648,"magFilter":9728}]"#;
    let mesh = textured(material, r#"[{"source":1,"sampler":0}]"#).expect("a mesh");
    let textures = mesh.surfaces[0].textures;
    let expected = Texture {
        image: 0,
        wrap: [Wrap::Clamp, Wrap::Mirror],
        nearest: true,
    };
    assert_eq!(textures.base, Some(expected));
    // 0.25 of what the factor leaves.
    let cut_out = textures.cut_out.expect("a cut-out");
    assert_eq!(
        (cut_out.limit, cut_out.channel, cut_out.texture),
        (0.5, 3, expected)
    );
    // Its place is another one.
    assert_eq!((textures.emission, textures.emission_map), ([0.0; 3], None));
    assert_eq!(
        mesh.notes,
        ["folder/a.gltf: left out: 1 emission texture with other texture coordinates"]
    );
    assert_eq!(mesh.images[0].size(), [3, 2]);
    // A quarter turn takes v to u.
    let uvs = mesh.columns.uvs[..3]
        .iter()
        .map(|uv| uv.map(|x| (x * 1e4).round() / 1e4));
    assert_eq!(uvs.collect::<Vec<_>>(), [[0.5, 0.0], [3.5, 0.0], [0.5, 0.0]]);
}

#[cfg(feature = "textures")]
#[test]
fn an_image_that_is_missing_leaves_the_colour() {
    let material = r#""materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0,"texCoord":1}}}]"#;
    let mesh = textured(material, r#"[{"source":0}]"#).expect("a mesh");
    assert_eq!(
        mesh.notes,
        ["folder/a.gltf: texture no.png is not shown: file not found"]
    );
    let plain = SurfaceTextures {
        one_sided: true,
        ..SurfaceTextures::NONE
    };
    assert_eq!(mesh.surfaces[0].textures, plain);
    assert_eq!(mesh.surfaces[0].diffuse, Surface::NEUTRAL.diffuse);
    assert!(mesh.columns.uvs.is_empty() && mesh.images.is_empty());
    // WebP is preferred; an image of another kind is left out.
    let webp = r#"[{"source":0,"extensions":{"EXT_texture_webp":{"source":1}}}]"#;
    assert_eq!(textured(material, webp).expect("a mesh").images.len(), 1);
    let basis = r#"[{"extensions":{"KHR_texture_basisu":{"source":0}}}]"#;
    let mesh = textured(material, basis).expect("a mesh");
    assert_eq!(mesh.notes, ["folder/a.gltf: left out: 1 unsupported texture"]);
    let declared = format!(r#""extensionsUsed":["KHR_texture_basisu"],{material}"#);
    let mesh = textured(&declared, basis).expect("a mesh");
    assert_eq!(
        mesh.notes,
        ["folder/a.gltf: left out: 1 KTX2 texture (`gltf-transform ktxdecompress` makes it PNG)"]
    );
    // The factor's alpha alone is below the limit: nothing is left.
    let faint = r#""materials":[{"alphaMode":"MASK","pbrMetallicRoughness":{"baseColorFactor":[1,1,1,0.3],
        "baseColorTexture":{"index":0,"texCoord":1}}}]"#;
    let blended = faint.replace("MASK", "BLEND");
    let [faint, blended] =
        [faint, &blended].map(|material| textured(material, r#"[{"source":1}]"#).expect("a mesh"));
    assert!(faint.notes.is_empty() && blended.notes.is_empty());
    let limit = faint.surfaces[0].textures.cut_out.map(|cut_out| cut_out.limit);
    assert!(limit > Some(1.0));
    let textures = blended.surfaces[0].textures;
    assert_eq!(textures.opacity, Opacity::new(0.3, textures.base));
    let glow = r#""materials":[{"emissiveFactor":[1,1,1],"emissiveTexture":{"index":0}}]"#;
    let glow = textured(glow, basis).expect("a mesh");
    assert_eq!(glow.surfaces[0].textures, plain);
    assert_eq!(glow.notes, ["folder/a.gltf: left out: 1 unsupported texture"]);
    let strong = r#""materials":[{"emissiveFactor":[1,0.1,0],
        "extensions":{"KHR_materials_emissive_strength":{"emissiveStrength":4}}}]"#;
    let mut strong = textured(strong, basis).expect("a mesh");
    let emission = strong.surfaces[0].textures.emission;
    assert_eq!(emission[1..], [materials::display_value(0.4), 0.0]);
    strong.linearize();
    let emission = strong.surfaces[0].textures.emission;
    assert!((emission[0] - 4.0).abs() < 1e-5, "{emission:?}");
    assert!(strong.notes.is_empty(), "{:?}", strong.notes);
    let unlit = r#""materials":[{"extensions":{"KHR_materials_unlit":{}},
        "pbrMetallicRoughness":{"baseColorFactor":[0,1,0,1]}}]"#;
    let unlit = textured(unlit, "[]").expect("a mesh").surfaces[0].material();
    assert_eq!(
        unlit,
        Material::Silhouette {
            color: [0.0, 1.0, 0.0]
        }
    );
}

#[test]
fn sparse_accessors() {
    // Vertex 1 takes the place of vertex 2.
    let with = |count: u32, offset: u32| {
        format!(
            r#""sparse":{{"count":{count},"indices":{{"bufferView":1,"byteOffset":{offset},"componentType":5121}},
            "values":{{"bufferView":0,"byteOffset":24}}}},"type":"VEC3","min""#
        )
    };
    let mesh = changed(r#""type":"VEC3","min""#, &with(1, 1)).expect("a mesh");
    assert_eq!(mesh.columns.x[..3], [0.0, 0.0, 0.0]);
    assert_eq!(mesh.columns.y[..3], [0.0, 1.0, 1.0]);
    assert_eq!(
        refused(r#""type":"VEC3","min""#, &with(3, 1)),
        " accessors[0].sparse.indices (3 elements of 1 bytes) reaches beyond its buffer: the file is cut short or \
         broken"
    );
    assert_eq!(
        refused(
            r#""count":3,"type":"VEC3","min""#,
            &format!(r#""count":1,{}"#, with(1, 2))
        ),
        " accessors[0].sparse: element 2, but the accessor has only 1"
    );
    // An accessor without a buffer view is zeros.
    let zeros = with(1, 1);
    let mesh = changed(
        r#"{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min""#,
        &format!(r#"{{"componentType":5126,"count":3,{zeros}"#),
    );
    let columns = mesh.expect("a mesh").columns;
    assert_eq!(
        (&columns.x[..3], &columns.y[..3]),
        (&[0.0; 3][..], &[0.0, 1.0, 0.0][..])
    );
    // Only what is used is read.
    let many = changed(
        r#"{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min""#,
        &format!(r#"{{"componentType":5126,"count":4000000000,{zeros}"#),
    );
    assert_eq!(many.expect("a mesh").columns.y[..3], [0.0, 1.0, 0.0]);
}

#[test]
fn older_materials() {
    let mesh = changed(
        r#""pbrMetallicRoughness":{"baseColorFactor":[1,0.5,0,1]}"#,
        r#""extensions":{"KHR_materials_pbrSpecularGlossiness":{"diffuseFactor":[0,1,0,1],
        "specularFactor":[0.04,0.04,0.04]}}"#,
    );
    assert_eq!(mesh.expect("a mesh").surfaces[0].diffuse, [0.0, 1.0, 0.0]);
    changed(
        r#""asset":{"version":"2.0"}"#,
        r#""asset":{"version":"2.0"},"extensionsRequired":["KHR_technique_webgl","MSFT_texture_dds"]"#,
    )
    .expect("a matter of looks");
}

const OLD: &str = " glTF 1.0 is not supported; convert the file to glTF 2.0, for example with gltf-pipeline";

/// A camera that two nodes place counts twice, by their names.
#[test]
fn cameras_of_several_nodes() {
    let json = r#"{"asset":{"version":"2.0"},"nodes":[{"camera":0,"name":"a"},{"camera":0,"name":"b"},{"camera":0},
        {"camera":1,"name":"c"}],"cameras":[{"name":"own","type":"perspective","perspective":{"yfov":0.5,"znear":0.1}},
        {"name":"other","type":"perspective","perspective":{"yfov":0.5,"znear":0.1}}]}"#;
    let mesh = load(json).expect("cameras");
    let names: Vec<&str> = mesh.cameras.iter().map(|camera| camera.name.as_str()).collect();
    assert_eq!(names, ["a", "b", "own", "other"]);
}

#[test]
fn version_1_is_refused_with_advice() {
    let first = load(r#"{"asset":{"version":"1.0"},"accessors":{"a":{}}}"#);
    assert_eq!(first.expect_err("old"), OLD);
    let unstated = load(r#"{"nodes":{"a":{"children":[]}},"scene":"a"}"#);
    assert_eq!(unstated.expect_err("old"), OLD);
    let older = load(r#"{"asset":{"version":0.8},"accessors":{"a":{}}}"#);
    assert!(older.expect_err("old").contains("glTF 0.8 is not supported"));
    let open = &mut |_: &Path| Err(io::ErrorKind::NotFound.into());
    let binary = parse(
        b"glTF\x01\0\0\0\x20\0\0\0........................",
        Path::new("a.glb"),
        open,
        &Budget::unlimited(),
    );
    let error = binary.expect_err("old").to_string();
    assert_eq!(error, format!("a.glb:{OLD}"));
}

#[test]
fn faults() {
    assert_eq!(
        load("").expect_err("empty"),
        " the file is empty, expected a glTF mesh"
    );
    assert!(
        load("{\n\"asset\": 3}")
            .expect_err("not an object")
            .starts_with("2:10: not a valid glTF file: ")
    );
    assert!(
        load("hello")
            .expect_err("not JSON")
            .starts_with("1:1: not a valid glTF file: ")
    );
    assert_eq!(refused("2.0", "1.0"), OLD);
    assert_eq!(
        refused("a%20b.bin", "no.bin"),
        " cannot load buffers[0]\n  caused by: folder/no.bin: file not found"
    );
    assert!(
        refused("a%20b.bin", "https://example.org/a.bin")
            .contains("expected the name of a file beside this one")
    );
    assert!(refused("a%20b.bin", "data:;base64,?").contains("buffers[0] is not valid Base64"));
    assert_eq!(
        refused(r#""byteLength":76"#, r#""byteLength":77"#),
        " buffers[0] has 76 bytes, expected 77"
    );
    assert_eq!(
        refused(
            r#""count":3,"type":"VEC3","min""#,
            r#""count":4000000000,"type":"VEC3","min""#
        ),
        " accessors[0] (4000000000 elements of 12 bytes) reaches beyond its buffer: the file is cut short or broken"
    );
    assert!(
        refused(
            r#""byteOffset":72,"byteLength":3"#,
            r#""byteOffset":75,"byteLength":3"#
        )
        .contains("bufferViews[1]")
    );
    assert_eq!(
        refused(
            r#""byteOffset":72,"byteLength":3"#,
            r#""byteOffset":14,"byteLength":3"#
        ),
        " accessors[2]: vertex index 128 (number 1), but the primitive has only 3 vertices"
    );
    assert!(refused(r#""mesh":0},{"ch"#, r#""mesh":1},{"ch"#).contains("out of bounds"));
    assert!(refused(r#""children":[2,3]"#, r#""children":[1,3]"#).contains("nodes[1] has two parents"));
    assert!(
        refused(
            r#"{"mesh":0},{"children":[2,3],"translation":[10,0,0]"#,
            r#"{},{"children":[2,3],"translation":[1e30,0,0]"#
        )
        .contains("vertex 1 of 3: x is 1e30")
    );
}

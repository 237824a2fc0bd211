//! Tangents: read for normal maps, and turned with nodes, joints and morph targets.

use super::super::{
    poses::{BENT, File, load_file, strip},
    *,
};
use crate::format::mesh::Sharing;

/// A file of the strip with accessor 6 as tangents and a material of these `textures`.
fn file_of(textures: &str, change: impl Fn(&mut File), body: &str) -> String {
    let file = strip(|file| {
        change(file);
        file.floats(6, "VEC2", &[0.0; 12]);
    });
    let mut png = io::Cursor::new(Vec::new());
    let image = image::RgbaImage::from_pixel(1, 1, image::Rgba([128, 128, 255, 255]));
    let written = image.write_to(&mut png, image::ImageFormat::Png);
    written.expect("it is written");
    let images = format!(
        r#""images":[{{"uri":"data:image/png;base64,{}"}}],"textures":[{{"source":0}}],"#,
        base64(png.get_ref())
    );
    let body = body.replace(r#""NORMAL":1"#, r#""NORMAL":1,"TANGENT":6,"TEXCOORD_0":7"#);
    let body = body.replace(r#""indices":5"#, r#""indices":5,"material":0"#);
    file.finish(&format!(r#"{images}"materials":[{{{textures}}}],{body}"#))
}

const MAPPED: &str = r#""normalTexture":{"index":0}"#;
const SLANTED: [f32; 4] = [0.6, 0.8, 0.0, 1.0];

fn slanted(file: &mut File) {
    file.floats(6, "VEC4", &SLANTED.repeat(6));
}

fn tangents(json: &str, sharing: Sharing) -> Vec<[f32; 4]> {
    let mesh = load_file(json, sharing).expect("a mesh");
    assert!(mesh.notes.is_empty(), "{:?}", mesh.notes);
    let arrays = mesh.shared.iter().map(|part| &part.columns);
    let mut arrays = arrays
        .chain([&mesh.columns])
        .filter(|columns| !columns.x.is_empty());
    let columns = arrays.next().expect("vertices");
    columns
        .tangents
        .iter()
        .map(|of| of.map(|x| (x * 1e5).round() / 1e5 + 0.0))
        .collect()
}

#[test]
fn joints_turn_tangents_and_mirrors_turn_their_sign() {
    let found = tangents(&file_of(MAPPED, slanted, BENT), Sharing::Never);
    assert_eq!([found[0], found[5]], [SLANTED, [-0.8, 0.6, 0.0, 1.0]]);
    let mirrored = BENT.replace(r#""translation":[10,0,0]"#, r#""scale":[-1,1,1]"#);
    let found = tangents(&file_of(MAPPED, slanted, &mirrored), Sharing::Never);
    assert_eq!(
        [found[0], found[5]],
        [[-0.6, 0.8, 0.0, -1.0], [0.8, 0.6, 0.0, -1.0]]
    );
}

#[test]
fn nodes_and_instances() {
    let nodes = r#""nodes":[{"mesh":0,"scale":[-2,1,1]},{"mesh":0,"translation":[0,9,0]}],"#;
    let still = r#""meshes":[{"primitives":[{"attributes":{"POSITION":0,"NORMAL":1},"indices":5}]}]"#;
    let json = file_of(MAPPED, slanted, &format!("{nodes}{still}"));
    let baked = tangents(&json, Sharing::Never);
    let steep = [-1.2, 0.8].map(|x: f32| (x / 1.2_f32.hypot(0.8) * 1e5).round() / 1e5);
    assert_eq!((baked.len(), baked[6]), (12, SLANTED));
    assert_eq!(baked[0], [steep[0], steep[1], 0.0, -1.0]);
    assert_eq!(tangents(&json, Sharing::Always), [SLANTED; 6]);
}

/// Tangents need a normal map, normals, and the number of positions.
#[test]
fn tangents_that_do_not_count() {
    let still = r#""nodes":[{"mesh":0}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0,"NORMAL":1},"indices":5}]}]"#;
    let load = |textures: &str, change: &dyn Fn(&mut File), from: &str, to: &str| {
        load_file(
            &file_of(textures, change, still).replace(from, to),
            Sharing::Never,
        )
    };
    let kept = load(MAPPED, &slanted, "", "").expect("a mesh");
    assert_eq!(kept.columns.tangents, [SLANTED; 6]);
    for (textures, from, to) in [
        (
            r#""pbrMetallicRoughness":{"baseColorTexture":{"index":0}}"#,
            "",
            "",
        ),
        (MAPPED, r#""NORMAL":1,"#, ""),
        (MAPPED, r#""source":0"#, r#""extensions":{}"#),
    ] {
        let mesh = load(textures, &slanted, from, to).expect("a mesh");
        assert!(mesh.columns.tangents.is_empty(), "{textures} {from}");
    }
    let five = |file: &mut File| {
        file.floats(5, "VEC4", &SLANTED.repeat(5));
    };
    let mesh = load(MAPPED, &five, "", "").expect("a mesh");
    assert!(mesh.columns.tangents.is_empty());
    let odd = |file: &mut File| {
        let odd = [
            [0.0, 0.0, 0.0, 1.0],
            [f32::NAN, 0.0, 0.0, 1.0],
            [1.0, 0.0, 0.0, f32::NAN],
            [1.0, 0.0, 0.0, 0.0],
            [f32::INFINITY, 0.0, 0.0, 1.0],
            [0.0, 3.0, 0.0, -0.25],
        ];
        file.floats(6, "VEC4", odd.as_flattened());
    };
    let mesh = load(MAPPED, &odd, "", "").expect("a mesh");
    assert_eq!(mesh.columns.tangents[..5], [[0.0; 4]; 5]);
    assert_eq!(mesh.columns.tangents[5], [0.0, 1.0, 0.0, -1.0]);
    let error = load(MAPPED, &slanted, r#""TANGENT":6"#, r#""TANGENT":1"#).err();
    let expected = " accessors[1] holds other elements, expected tangents (vectors of 4 numbers)";
    assert_eq!(error.as_deref(), Some(expected));
}

/// Differences have no sign, and quantised numbers are shares of 127.
#[test]
fn morph_targets_and_quantised_tangents() {
    let body = r#""nodes":[{"mesh":0}],"meshes":[{"weights":[0.5],"primitives":[{"attributes":{"POSITION":0,"NORMAL":1},"indices":5,
        "targets":[{"TANGENT":1}]}]}]"#;
    let quantised = |file: &mut File| {
        let byte = [127_u8, 0, 0, 0x80];
        file.add(
            6,
            r#""componentType":5120,"normalized":true,"type":"VEC4""#,
            &byte.repeat(6),
        );
    };
    // Half of z is added.
    let found = tangents(&file_of(MAPPED, quantised, body), Sharing::Never);
    assert_eq!(found, [[0.89443, 0.0, 0.44721, -1.0]; 6]);
}

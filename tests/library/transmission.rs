//! Transmission of glTF materials, and lights that `mesh` takes from glTF files: the same pictures as with equivalent
//! statements of a scene.

use crate::glass::pixels;
use octray::{
    error::LoadError,
    format::{load_from_bytes, mesh},
    scene::{Camera, Material, Scene},
};
use std::{io, path::Path};

/// An octahedron about the origin, with `JSON` for what else the file has.
const BODY: &str = r#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0,1]}],JSON
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"material":0}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":6,"type":"VEC3","min":[-1,-1,-1],"max":[1,1,1]},
{"bufferView":1,"componentType":5121,"count":24,"type":"SCALAR"}],
"bufferViews":[{"buffer":0,"byteLength":72},{"buffer":0,"byteOffset":72,"byteLength":24}],
"buffers":[{"byteLength":96,"uri":"body.bin"}]}"#;

/// One of its nodes.
const NODES: &str = r#""nodes":[{"mesh":0},{"translation":[0,0,3]}],"#;

fn buffer() -> Vec<u8> {
    let axes = [
        [1, 0, 0],
        [-1, 0, 0],
        [0, 1, 0],
        [0, -1, 0],
        [0, 0, 1],
        [0, 0, -1_i8],
    ];
    let corners = axes.iter().flatten();
    let mut bytes: Vec<u8> = corners.flat_map(|&x| f32::from(x).to_le_bytes()).collect();
    for [a, b] in [[0, 2], [2, 1], [1, 3], [3, 0]] {
        bytes.extend([a, b, 4, b, a, 5]);
    }
    bytes
}

/// A file of the octahedron with this material.
fn with_material(material: &str) -> String {
    let used = r#""extensionsRequired":["KHR_materials_transmission","KHR_materials_volume","KHR_materials_ior"],
        "extensionsUsed":["KHR_materials_transmission","KHR_materials_volume","KHR_materials_ior"],"#;
    BODY.replace("JSON", &format!(r#"{used}{NODES}"materials":[{material}],"#))
}

fn load(text: &str, gltf: &str) -> Result<Scene, LoadError> {
    load_from_bytes(
        text.as_bytes(),
        Path::new("a.scn"),
        &mut |path| match path.to_str() {
            Some("body.gltf") => Ok(gltf.into()),
            Some("body.bin") => Ok(buffer()),
            _ => Err(io::ErrorKind::NotFound.into()),
        },
    )
}

fn scene(text: &str, gltf: &str) -> Scene {
    let text = format!("light 3 -4 9 0.7\nbackground bottom 0.2 0.3 0.5 top 0.9 0.8 0.4\n{text}");
    load(&text, gltf).unwrap_or_else(|error| panic!("{text}: {}", error.report()))
}

fn picture(scene: &Scene) -> Vec<[f32; 3]> {
    let camera = Camera::classic_view(1).unwrap();
    pixels(scene, &camera, 4)
}

fn surface(gltf: &str) -> mesh::Surface {
    let open = &mut |_: &Path| Ok(buffer());
    mesh::parse(gltf.into(), Path::new("body.gltf"), open)
        .unwrap()
        .surfaces[0]
}

/// Without thickness light goes straight on, tinted by the base colour.
#[test]
fn a_sheet_is_a_tinted_surface() {
    let sheet = with_material(
        r#"{"pbrMetallicRoughness":{"metallicFactor":0,"baseColorFactor":[1,0.2,0,1]},
        "extensions":{"KHR_materials_transmission":{"transmissionFactor":0.75},"KHR_materials_volume":{}}}"#,
    );
    let [r, g, b] = surface(&sheet).diffuse;
    let own = scene("mesh body.gltf", &sheet);
    assert!(own.sources().notes.is_empty(), "{:?}", own.sources().notes);
    let statement = format!(
        "material blinn_phong cd {r} {g} {b} cs 0 0 0 kd 1 ks 1 alpha 4 opacity 0.25 tinted\nmesh body.gltf"
    );
    assert_eq!(picture(&own), picture(&scene(&statement, &sheet)));
    let plain = statement.replace(" tinted", "");
    assert_ne!(picture(&own), picture(&scene(&plain, &sheet)));
}

/// With thickness it is the boundary of a body: refraction by its index, and colour by depth.
#[test]
fn a_volume_is_glass() {
    let material = r#"{"pbrMetallicRoughness":{"metallicFactor":0},"extensions":{
        "KHR_materials_transmission":{"transmissionFactor":0.9},"KHR_materials_ior":{"ior":1.33},
        "KHR_materials_volume":{"thicknessFactor":1,"attenuationDistance":0.5,"attenuationColor":[1,0.2,0.6]}}}"#;
    let body = with_material(material);
    let Some(Material::Glass { tint: [r, g, b], .. }) = surface(&body).glass else {
        panic!("no glass")
    };
    assert!(
        r == 1.0 && (g - 0.4845).abs() < 1e-3,
        "the display value of 0.2, not {g}"
    );
    let own = scene("mesh body.gltf", &body);
    assert!(own.sources().notes.is_empty(), "{:?}", own.sources().notes);
    let statement = format!("material glass ior 1.33 tint {r} {g} {b} depth 0.5\nmesh body.gltf");
    assert_eq!(picture(&own), picture(&scene(&statement, &body)));
    // Linear light of it again, for styles that are written with the sRGB curve.
    let mut mesh = mesh::parse((&*body).into(), Path::new("a.gltf"), &mut |_| Ok(buffer())).unwrap();
    mesh.linearize();
    let linear = mesh.surfaces[0].material();
    assert!(matches!(linear, Material::Glass { tint: [_, g, _], .. } if (g - 0.2).abs() < 1e-6));
    // Without a distance it is clear, and an index of 0 is no index.
    let clear = material
        .replace(r#""attenuationDistance":0.5,"#, "")
        .replace("1.33", "0");
    assert_eq!(surface(&with_material(&clear)).material(), Material::GLASS);
}

/// Glass and unlit surfaces show as much without light.
#[test]
fn what_needs_no_light_is_not_noted() {
    let glass = r#"{"extensions":{"KHR_materials_transmission":{"transmissionFactor":1},
        "KHR_materials_volume":{"thicknessFactor":1}},"pbrMetallicRoughness":{"metallicFactor":0}}"#;
    let unlit = r#"{"extensions":{"KHR_materials_unlit":{}}}"#;
    for (material, needs_light) in [
        (glass.to_owned(), false),
        (unlit.to_owned(), false),
        // No triangle has the second.
        (format!("{unlit},{{}}"), false),
        ("{}".to_owned(), true),
    ] {
        let gltf = with_material(&material);
        // Once, and so often that the file is kept.
        let thrice = "mesh body.gltf translate 1 0 0\nmesh body.gltf translate 2 0 0\nmesh body.gltf";
        for text in ["mesh body.gltf", thrice, "instance body.gltf"] {
            let scene = load(text, &gltf).unwrap_or_else(|error| panic!("{}", error.report()));
            let notes = &scene.sources().notes;
            let is_noted = notes.iter().any(|note| note.contains("the scene has no light"));
            assert_eq!(is_noted, needs_light, "{material} {text}: {notes:?}");
        }
    }
    let matte = load("material matte\ninstance body.gltf", &with_material(unlit)).unwrap();
    assert_eq!(matte.sources().notes.len(), 1);
}

#[test]
fn what_is_left_out_of_transmission() {
    let transmission = |factors: &str, pbr: &str| {
        with_material(&format!(
            r#"{{"pbrMetallicRoughness":{{{pbr}}},"extensions":{{"KHR_materials_transmission":
            {{"transmissionFactor":{factors}}},"KHR_materials_volume":{{"thicknessFactor":1}}}}}}"#
        ))
    };
    let white = r#""metallicFactor":0"#;
    let notes = |gltf: &str| scene("mesh body.gltf", gltf).sources().notes.join("\n");
    let faint = transmission("0.4", white);
    assert_eq!(
        notes(&faint),
        "body.gltf: left out: 1 volume that lets little light through"
    );
    assert_eq!(surface(&faint).glass, None);
    let colored = transmission("1", r#""metallicFactor":0,"baseColorFactor":[1,0.5,0,1]"#);
    assert_eq!(notes(&colored), "body.gltf: left out: 1 base colour of glass");
    // Metal lets nothing through.
    let metal = transmission("1", r#""metallicFactor":1"#);
    assert_eq!((notes(&metal), surface(&metal).glass), (String::new(), None));
}

/// A lamp of 40 candela above the body, a sun from +x and a spot that misses.
fn lamps() -> String {
    let lights = r#""extensions":{"KHR_lights_punctual":{"lights":[
        {"type":"point","color":[1,0.5,0.25],"intensity":40},{"type":"directional","intensity":7}]}},"#;
    let nodes = r#""nodes":[{"mesh":0,"extensions":{"KHR_lights_punctual":{"light":1}}},
        {"translation":[0,0,3],"extensions":{"KHR_lights_punctual":{"light":0}}}],"#;
    BODY.replace("JSON", &format!(r#"{lights}{nodes}"materials":[{{}}],"#))
}

#[test]
fn lights_of_meshes_in_scenes() {
    let lamps = lamps();
    let read = |text: &str| load(text, &lamps).unwrap_or_else(|error| panic!("{}", error.report()));
    let without = read("mesh body.gltf");
    assert!(without.lights().is_empty());
    assert_eq!(
        without.sources().notes[0],
        "body.gltf: left out: 2 lights (`mesh` takes them with `lights`)"
    );
    // The lamp gives 40/9 in the middle, the sun 7: together 0.8. A mesh twice as large has them twice as far away.
    for (steps, at, to_light, distance) in [
        ("", "0 0 3", "0 0 1", 3.0),
        ("scale 2 rotate 0 1 0 90 translate 0 1 0", "6 1 0", "1 0 0", 6.0),
    ] {
        let taken = read(&format!("mesh body.gltf {steps} lights 0.8"));
        assert!(taken.sources().notes.is_empty(), "{:?}", taken.sources().notes);
        let lamp = 40.0 / (distance * distance);
        let [lamp, sun] = [lamp, 7.0].map(|part| (0.8 * part / (lamp + 7.0)) as f32);
        let stated = read(&format!(
            "directional_light {to_light} {sun}\nlight {at} {lamp} color 1 0.5 0.25 falloff {distance}\nmesh body.gltf {steps}"
        ));
        assert_eq!(taken.lights().len(), 2);
        for (taken, stated) in taken.lights().iter().zip(stated.lights()) {
            assert!((taken.intensity / stated.intensity - 1.0).abs() < 1e-6);
            assert_eq!((taken.color, taken.falloff), (stated.color, stated.falloff));
            let [taken, stated] = [taken, stated].map(|light| light.shape.direction_from([0.5; 3].into()));
            assert!(taken.distance(stated) < 1e-6, "{taken} {stated}");
        }
    }
    // Once in each place, and from a copy that is kept.
    let twice = read(
        "mesh body.gltf\nmesh body.gltf lights 1\nmesh body.gltf lights 1\nmesh body.gltf translate 9 0 0 lights 1",
    );
    assert_eq!(twice.lights().len(), 4);
    let none = load("mesh body.gltf lights 1", &with_material("{}")).unwrap();
    assert_eq!(
        none.sources().notes[0],
        "body.gltf: `lights`, but the file has none that can be read"
    );
}

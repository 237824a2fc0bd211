use super::textured_by;
use crate::scene::Image;

mod tangents;

const BLUE: [u8; 4] = [128, 128, 255, 255];
const TEXTURES: &str = r#"[{"source":1}]"#;

#[test]
fn normal_maps_that_lie_where_the_base_colour_lies() {
    let moved = r#""extensions":{"KHR_texture_transform":{"offset":[0.5,0],"scale":[2,3],"rotation":1}}"#;
    let material = |moved: &str| {
        format!(
            r#""materials":[{{"normalTexture":{{"index":0,"texCoord":1,"scale":-0.5,{moved}}},
            "pbrMetallicRoughness":{{"baseColorTexture":{{"index":0,"texCoord":1,{moved}}}}}}}]"#
        )
    };
    // The image is a colour, too, and so there twice.
    let mesh = textured_by(BLUE, &material(moved), TEXTURES).expect("a mesh");
    let kinds: Vec<bool> = mesh.images.iter().map(Image::has_numbers).collect();
    assert_eq!(kinds, [false, true]);
    let textures = mesh.surfaces[0].textures;
    let images = [textures.base, textures.normal_map.map(|map| map.texture)];
    assert_eq!(
        images.map(|texture| texture.map(|texture| texture.image)),
        [Some(0), Some(1)]
    );
    let alone = material(moved).replace("baseColorTexture", "extras");
    let mesh = textured_by(BLUE, &alone, TEXTURES).expect("a mesh");
    assert!(mesh.notes.is_empty(), "{:?}", mesh.notes);
    let map = mesh.surfaces[0].textures.normal_map.expect("a map");
    assert_eq!((map.scale, map.texture.image), (-0.5, 0));
    assert!(mesh.images[0].has_numbers());
    // Moved by its own transform.
    assert!((mesh.columns.uvs[0][0] - 0.5).abs() < 1e-6);
    // To the right, by 45 degrees; and a colour that is no normal.
    for texel in [[218, 128, 218, 255], [255, 64, 0, 255]] {
        let mesh = textured_by(texel, &alone, TEXTURES).expect("a mesh");
        assert!(mesh.notes.is_empty(), "{:?}", mesh.notes);
        assert!(mesh.surfaces[0].textures.normal_map.is_some());
    }
}

#[test]
fn normal_maps_elsewhere_are_left_out() {
    let material = r#""materials":[{"normalTexture":{"index":0,"texCoord":1,
        "extensions":{"KHR_texture_transform":{"offset":[0.5,0]}}},
        "pbrMetallicRoughness":{"baseColorTexture":{"index":0,"texCoord":1}}}]"#;
    let mesh = textured_by(BLUE, material, TEXTURES).expect("a mesh");
    assert_eq!(mesh.surfaces[0].textures.normal_map, None);
    assert_eq!(
        mesh.notes,
        ["folder/a.gltf: left out: 1 normal map with other texture coordinates"]
    );
    let unlit = material.replace(r#""pbr"#, r#""extensions":{"KHR_materials_unlit":{}},"pbr"#);
    let mesh = textured_by(BLUE, &unlit, TEXTURES).expect("a mesh");
    assert!(mesh.notes.is_empty() && mesh.surfaces[0].textures.normal_map.is_none());
}

/// Green is roughness, times each material's own factor; the same image is a colour elsewhere.
#[test]
fn roughness_maps() {
    let material = |factor: f32| {
        format!(
            r#"{{"pbrMetallicRoughness":{{"roughnessFactor":{factor},"metallicFactor":0,"baseColorTexture":{{"index":0,"texCoord":1}},
            "metallicRoughnessTexture":{{"index":0,"texCoord":1}}}}}}"#
        )
    };
    for factor in [1.0, 0.25] {
        let materials = format!(r#""materials":[{},{}]"#, material(factor), material(0.5));
        let mesh = textured_by([10, 200, 30, 255], &materials, TEXTURES).expect("a mesh");
        assert!(mesh.notes.is_empty(), "{:?}", mesh.notes);
        let textures = mesh.surfaces[0].textures;
        let mean = |texture: Option<crate::scene::Texture>| {
            mesh.images[texture.expect("a map").image as usize].mean()
        };
        assert_eq!(mean(textures.base), [10, 200, 30, 255]);
        let smoothness = (255.0 - 200.0 * factor + 0.5) as u8;
        let strength = (0.6 * f32::from(smoothness) + 0.5) as u8;
        assert_eq!(mean(textures.specular_map), [strength, strength, strength, 255]);
        let exponent = crate::format::gltf::materials::exponent(1.0 - f32::from(smoothness) / 255.0);
        assert_eq!(mesh.surfaces[0].alpha, exponent);
    }
    // A map that is missing: half as rough.
    let missing = format!(r#""materials":[{}]"#, material(1.0));
    let mesh = textured_by([10, 200, 30, 255], &missing, r#"[{"source":0}]"#).expect("a mesh");
    assert_eq!(
        mesh.notes,
        ["folder/a.gltf: texture no.png is not shown: file not found"]
    );
    assert_eq!(mesh.surfaces[0].textures.specular_map, None);
    assert_eq!(mesh.surfaces[0].specular, [0.3; 3]);
    assert_eq!(
        mesh.surfaces[0].alpha,
        crate::format::gltf::materials::exponent(0.5)
    );
}

/// Blue is metal, times the factor: highlights have the base colour there, that of the texture times the factor's.
#[test]
fn maps_of_metal() {
    let of = |pixel: [u8; 4], pbr: &str| {
        let materials = format!(r#""materials":[{{"pbrMetallicRoughness":{{{pbr}}}}}]"#);
        let mesh = textured_by(pixel, &materials, TEXTURES).expect("a mesh");
        assert!(mesh.notes.is_empty(), "{:?}", mesh.notes);
        let surface = mesh.surfaces[0];
        let map = surface.textures.specular_map;
        (
            map.map(|map| mesh.images[map.image as usize].mean()),
            surface.specular,
        )
    };
    let [base, map] = [r#""baseColorTexture""#, r#""metallicRoughnessTexture""#]
        .map(|name| format!(r#"{name}:{{"index":0,"texCoord":1}}"#));
    // The same image is the base colour: green 55 is a smoothness of 200, six tenths of it 120; blue 255 is metal.
    let gold = [230, 55, 255, 255];
    let strong = [1.0; 3];
    assert_eq!(
        of(gold, &format!("{base},{map}")),
        (Some([108, 26, 120, 255]), strong)
    );
    let half = of(gold, &format!(r#"{base},{map},"metallicFactor":0.5"#));
    assert_eq!(half.0, Some([114, 73, 120, 255]));
    let factor = r#""baseColorFactor":[1,0,1,1]"#;
    assert_eq!(
        of(gold, &format!("{factor},{base},{map}")).0,
        Some([108, 0, 120, 255])
    );
    assert_eq!(of(gold, &format!("{factor},{map}")).0, Some([120, 0, 120, 255]));
    let plain = [230, 55, 0, 255];
    assert_eq!(of(plain, &format!("{base},{map}")).0, Some([120, 120, 120, 255]));
    // Without a map, highlights of a metal are those of the texture.
    let smooth = r#""roughnessFactor":0.5"#;
    assert_eq!(of(gold, &format!("{base},{smooth}")), (Some(gold), [0.3; 3]));
    let (none, _) = of(gold, &format!(r#"{base},{smooth},"metallicFactor":0"#));
    assert_eq!(none, None);
}

/// A small file cannot make a large image be decoded for each of many materials.
#[test]
fn many_factors_of_roughness() {
    let material = |i: usize| {
        format!(
            r#"{{"pbrMetallicRoughness":{{"roughnessFactor":{},"metallicRoughnessTexture":{{"index":0,"texCoord":1}}}}}}"#,
            i as f32 / 1000.0
        )
    };
    for (count, images) in [(16, 16), (1000, 17)] {
        let all: Vec<String> = (0..count).map(material).collect();
        let materials = format!(r#""materials":[{}]"#, all.join(","));
        let mesh = textured_by([10, 200, 30, 255], &materials, TEXTURES).expect("a mesh");
        assert_eq!(mesh.images.len(), images);
    }
}

/// Often an image of occlusion, roughness and metal, of which occlusion is the red.
#[test]
fn occlusion_maps() {
    let pbr = r#""pbrMetallicRoughness":{"metallicRoughnessTexture":{"index":0,"texCoord":1}}"#;
    let load = |more: &str, texture: &str| {
        let materials = format!(r#""materials":[{{{more}"occlusionTexture":{{"index":0{texture}}},{pbr}}}]"#);
        textured_by([10, 200, 0, 255], &materials, TEXTURES).expect("a mesh")
    };
    let mesh = load("", r#","texCoord":1,"strength":0.5"#);
    assert!(mesh.notes.is_empty(), "{:?}", mesh.notes);
    let map = mesh.surfaces[0].textures.occlusion_map.expect("a map");
    let image = &mesh.images[map.texture.image as usize];
    assert_eq!(
        (map.strength, image.has_numbers(), image.mean()),
        (0.5, true, [10, 200, 0, 255])
    );
    assert!(mesh.surfaces[0].textures.specular_map.is_some() && mesh.images.len() == 2);
    let moved = r#","texCoord":1,"extensions":{"KHR_texture_transform":{"offset":[0.5,0]}}"#;
    for elsewhere in ["", moved] {
        let mesh = load("", elsewhere);
        assert_eq!(
            mesh.notes,
            ["folder/a.gltf: left out: 1 occlusion map with other texture coordinates"]
        );
        assert_eq!(mesh.surfaces[0].textures.occlusion_map, None);
    }
    let unlit = load(r#""extensions":{"KHR_materials_unlit":{}},"#, "");
    assert!(unlit.notes.is_empty() && unlit.surfaces[0].textures.occlusion_map.is_none());
}

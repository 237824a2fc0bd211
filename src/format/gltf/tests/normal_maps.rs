use super::textured_by;

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
    // The image is a colour, too, so that it has the mipmaps of one.
    let mesh = textured_by(BLUE, &material(moved), TEXTURES).expect("a mesh");
    assert_eq!(mesh.surfaces[0].textures.normal_map, None);
    let alone = material(moved).replace("baseColorTexture", "extras");
    let mesh = textured_by(BLUE, &alone, TEXTURES).expect("a mesh");
    assert!(mesh.notes.is_empty(), "{:?}", mesh.notes);
    let map = mesh.surfaces[0].textures.normal_map.expect("a map");
    assert_eq!((map.scale, map.texture.image), (-0.5, 0));
    assert!(mesh.images[0].has_numbers());
    // Moved by its own transform.
    assert!((mesh.columns.uvs[0][0] - 0.5).abs() < 1e-6);
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
        ["folder/a.gltf: left out: 1 normal map with a different transform"]
    );
    let unlit = material.replace(r#""pbr"#, r#""extensions":{"KHR_materials_unlit":{}},"pbr"#);
    let mesh = textured_by(BLUE, &unlit, TEXTURES).expect("a mesh");
    assert!(mesh.notes.is_empty() && mesh.surfaces[0].textures.normal_map.is_none());
}

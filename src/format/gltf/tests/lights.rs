//! `KHR_lights_punctual`.

use super::*;
use crate::format::gltf::lights::PunctualLights;
use crate::scene::{Light, LightShape};

#[test]
fn punctual_lights() {
    let lit = |lights: &str, nodes: &str| {
        let scene = SCENE.replacen(r#""asset":{"version":"2.0"}"#, &format!(
            r#""asset":{{"version":"2.0"}},"extensions":{{"KHR_lights_punctual":{{"lights":[{lights}]}}}}"#
        ), 1);
        let scene = scene.replacen(
            r#"{"camera":0,"name":"eye""#,
            &format!(
                r#"{{"extensions":{{"KHR_lights_punctual":{{"light":{nodes}}}}},"camera":0,"name":"eye""#
            ),
            1,
        );
        load(&scene).expect("a mesh")
    };
    let all = r#"{"type":"point","color":[1,0.5,2],"intensity":40},
        {"type":"spot","spot":{"innerConeAngle":0.1,"outerConeAngle":0.5}},{"type":"directional","intensity":3}"#;
    let position = Vec3::new(10.0, 0.0, 5.0);
    let mesh = lit(all, "0");
    let point = Light {
        intensity: 40.0,
        color: [1.0, 0.5, 1.0],
        falloff: Some(1.0),
        ..Light::new(LightShape::Point { position })
    };
    assert_eq!(mesh.lights, [point]);
    let spot = lit(all, "1").lights[0];
    assert_eq!(
        (spot.shape, spot.intensity),
        (LightShape::Point { position }, 1.0)
    );
    let cone = spot.spot.expect("a cone");
    assert_eq!(cone.direction(), Vec3::NEG_Z);
    let [inner, outer] = cone.degrees().map(f32::to_radians);
    assert!(
        (inner - 0.1).abs() < 1e-3 && (outer - 0.5).abs() < 1e-3,
        "{inner} {outer}"
    );
    let sun = lit(all, "2").lights[0];
    let to_light = Vec3::Z;
    assert_eq!(
        (sun.shape, sun.falloff),
        (LightShape::Directional { to_light, sine: 0.0 }, None)
    );
    assert_eq!(sun.intensity, 3.0);

    let left_out = |lights: &str, node: &str| {
        let mesh = lit(lights, node);
        assert!(mesh.lights.is_empty(), "{lights}");
        mesh.notes.join("")
    };
    let one = "folder/a.gltf: left out: 1 light";
    for light in [
        r#"{"type":"odd"}"#,
        r#"{"type":"point","intensity":-1}"#,
        r#"{"type":7}"#,
        r#"{"type":"spot","spot":{"outerConeAngle":9}}"#,
        r#"{"type":"point","color":[1,1]}"#,
    ] {
        assert_eq!(left_out(light, "0"), one, "{light}");
    }
    assert_eq!(left_out(r#"{"type":"point"}"#, "1"), one);
    // A fault in one light is no fault of others, and definitions that no node places do not count.
    assert_eq!(lit(r#"{"type":"point"},{"intensity":"x"}"#, "0").lights.len(), 1);
    let many = vec![r#"{"type":"point"}"#; 1025].join(",");
    assert_eq!(lit(&many, "0").lights.len(), 1);
}

/// Values that nothing reads need not be UTF-8.
#[test]
fn lights_beside_other_encodings() {
    let json = SCENE.replacen(
        r#""asset":{"version":"2.0"}"#,
        r#""asset":{"version":"2.0"},"extras":"Andr?","extensions":{"KHR_lights_punctual":{"lights":[{"type":"point"}]}}"#,
        1,
    );
    let json = json.replacen(
        r#"{"camera":0"#,
        r#"{"extensions":{"KHR_lights_punctual":{"light":0}},"camera":0"#,
        1,
    );
    let json: Vec<u8> = json
        .bytes()
        .map(|byte| if byte == b'?' { 0xe9 } else { byte })
        .collect();
    let lights = PunctualLights::of(&json);
    assert!((0..4).any(|node| lights.is_at(node)));
}

//! What the specification lets a file leave out, and parts of it that are not shown.

use super::{animations::posed, *};

#[test]
fn a_scene_may_have_no_nodes() {
    let mesh = changed(r#"{"nodes":[0,1]}"#, r#"{"name":"empty"}"#).expect("an empty scene");
    assert!(mesh.columns.triangles.is_empty());
    let other = changed(r#""scenes":["#, r#""scene":1,"scenes":[{},"#).expect("the second scene");
    assert_eq!(other.columns.triangles.len(), 2);
    // Faults elsewhere keep their place.
    let error = refused(r#""scenes":[{"nodes":[0,1]}]"#, r#""scenes":[{"nodes":0}]"#);
    assert!(error.contains("not a valid glTF file"), "{error}");
}

/// Data URIs and names make a file long.
#[test]
fn long_files_may_leave_out_nodes() {
    let pad = "x".repeat(2 << 20);
    let long = SCENE.replacen(r#""asset":{"#, &format!(r#""asset":{{"generator":"{pad}","#), 1);
    let scenes = long.replacen(r#""scenes":["#, r#""scene":1,"scenes":[{},"#, 1);
    assert_eq!(load(&scenes).expect("a mesh").columns.triangles.len(), 2);
    let channels = r#""animations":[{"channels":[{"sampler":0,"target":{"path":"translation"}}],
        "samplers":[{"input":0,"output":0}]}],"scenes":["#;
    let channels = long.replacen(r#""scenes":["#, channels, 1);
    assert_eq!(load(&channels).expect("a mesh").columns.triangles.len(), 2);
    let parse = |memory: u64| {
        let open = &mut |_: &Path| Ok(buffer());
        let budget = Budget::new(memory);
        let mesh = parse(scenes.as_bytes(), Path::new("a.gltf"), open, &budget);
        mesh.map(|_| budget.taken()).map_err(|error| error.to_string())
    };
    // The tree of values is counted, and given back.
    let error = parse(5 << 20).expect_err("a small limit");
    assert!(error.starts_with("a.gltf: loading takes"), "{error}");
    let taken = parse(8 << 20).expect("a mesh");
    assert!(taken < 4 << 20, "{taken}");
}

#[test]
fn accessors_without_buffer_views_are_zeros() {
    let view = r#"{"bufferView":0,"byteOffset":36,"componentType":5126,"count":3,"type":"VEC3"}"#;
    let zeros = r#"{"componentType":5126,"count":3,"type":"VEC3"}"#;
    let mesh = changed(view, zeros).expect("a mesh");
    assert_eq!(mesh.columns.normals, [Vec3::ZERO; 6]);
    assert_eq!(mesh.columns.triangles.len(), 2);
    let many = changed(view, &zeros.replace(":3,", ":4000000000,")).map(|mesh| mesh.columns.normals);
    assert!(
        many.expect("a mesh").is_empty(),
        "only one normal for each vertex counts"
    );
    let positions = r#"{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min""#;
    let huge = r#"{"componentType":5126,"count":4000000000,"type":"VEC3","min""#;
    let json = SCENE.replacen(positions, huge, 1);
    let json = json.replacen(r#""NORMAL":1},"indices":2"#, r#""NORMAL":1}"#, 1);
    let error = load(&json).map(|_| ()).expect_err("it is refused");
    assert!(
        error.contains("2666666666 triangles, counted once for each node"),
        "{error}"
    );
    // Times from the file, zeros as translations.
    let moved = SCENE.replacen(r#""accessors":["#, &format!(r#""accessors":[{zeros},"#), 1);
    let moved = moved
        .replacen(
            r#""POSITION":0,"NORMAL":1},"indices":2"#,
            r#""POSITION":1},"indices":3"#,
            1,
        )
        .replacen(
            r#""bufferViews":["#,
            r#""animations":[{"channels":[{"sampler":0,"target":{"node":1,"path":"translation"}}],
            "samplers":[{"input":4,"output":0}]}],"bufferViews":["#,
            1,
        )
        .replacen(
            r#""type":"SCALAR"}]"#,
            r#""type":"SCALAR"},{"bufferView":0,"componentType":5126,"count":2,"type":"SCALAR"}]"#,
            1,
        )
        .replacen("a%20b.bin", &format!("data:;base64,{}", base64(&buffer())), 1);
    let mesh = posed(&moved, None, 0.0).expect("a mesh");
    assert_eq!(mesh.columns.x, [0.0, 1.0, 0.0, 0.0, -2.0, 0.0]);
}

/// The same gold as both kinds of material.
#[test]
fn metal_of_specular_colour_and_glossiness() {
    let from = r#""pbrMetallicRoughness":{"baseColorFactor":[1,0.5,0,1]}"#;
    let metal = r#""pbrMetallicRoughness":{"baseColorFactor":[1,0.77,0.34,1],"metallicFactor":1,"roughnessFactor":0.4}"#;
    let old = |factors: &str| {
        let material = format!(r#""extensions":{{"KHR_materials_pbrSpecularGlossiness":{{{factors}}}}}"#);
        changed(from, &material).expect("a mesh")
    };
    let gold = old(r#""diffuseFactor":[0,0,0,1],"specularFactor":[1,0.77,0.34],"glossinessFactor":0.6"#);
    let expected = changed(from, metal).expect("a mesh").surfaces[0];
    let found = gold.surfaces[0];
    for (found, expected) in [
        (found.diffuse, expected.diffuse),
        (found.specular, expected.specular),
    ] {
        let is_near = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-3);
        assert!(is_near, "{found:?}, expected {expected:?}");
    }
    assert!(gold.notes.is_empty());
    // Nothing is reflected: as bright as a dielectric, and no metal.
    let matt = old(r#""diffuseFactor":[0.48,0,0,1],"specularFactor":[0,0,0]"#).surfaces[0];
    assert_eq!(matt.diffuse[1..], [0.0, 0.0]);
    assert!(
        (matt.diffuse[0] - materials::display_value(0.5)).abs() < 1e-5,
        "{matt:?}"
    );
    // Partly metal, whose base colour is brighter than either colour.
    let half = old(r#""diffuseFactor":[0.5,0.5,0.5,1],"specularFactor":[0.5,0.5,0.5]"#).surfaces[0];
    let is_between = half.specular[0] < half.diffuse[0] && half.diffuse[0] > materials::display_value(0.5);
    assert!(is_between, "{half:?}");
    // Beyond the range.
    let odd = old(r#""diffuseFactor":[9e37,-1,0,1],"specularFactor":[9e37,0,-5]"#).surfaces[0];
    assert!(
        odd.diffuse.iter().all(|channel| (0.0..=1.0).contains(channel)),
        "{odd:?}"
    );
    // A texture has its own colours.
    let map = r#""specularGlossinessTexture":{"index":0}"#;
    let textured = |factors: &str| {
        let material =
            format!(r#""extensions":{{"KHR_materials_pbrSpecularGlossiness":{{{factors},{map}}}}}"#);
        let json = SCENE.replacen(from, &material, 1);
        let asset = r#""textures":[{"source":0}],"images":[{"uri":"a.png"}],"asset""#;
        load(&json.replacen(r#""asset""#, asset, 1)).expect("a mesh")
    };
    let gold = textured(r#""diffuseFactor":[0,0,0,1],"specularFactor":[1,0.77,0.34]"#);
    assert_eq!(gold.surfaces[0].diffuse, [0.0; 3]);
    assert_eq!(
        gold.notes,
        ["folder/a.gltf: left out: 1 glossiness map, 1 specular colour of a textured material"]
    );
    let plain = textured(r#""diffuseFactor":[0,1,0,1]"#);
    assert_eq!(plain.surfaces[0].diffuse, [0.0, 1.0, 0.0]);
    assert_eq!(plain.notes, ["folder/a.gltf: left out: 1 glossiness map"]);
}

#[test]
fn factors_cut_all_of_a_material_away() {
    let from = r#""materials":[{"pbrMetallicRoughness":{"baseColorFactor":[1,0.5,0,1]}"#;
    let triangles = |alpha: f32, rest: &str| {
        let material = format!(
            r#""materials":[{{"alphaMode":"MASK"{rest},"pbrMetallicRoughness":{{"baseColorFactor":[1,0,0,{alpha}]}}"#
        );
        let mesh = changed(from, &material).expect("a mesh");
        let count = mesh.columns.triangles.len();
        let told = mesh
            .notes
            .iter()
            .filter(|note| note.contains("1 material below its alpha cutoff"));
        assert_eq!(told.count(), usize::from(count == 0), "{:?}", mesh.notes);
        count
    };
    assert_eq!([triangles(0.4, ""), triangles(0.5, "")], [0, 2]);
    let limit = r#","alphaCutoff":0.3"#;
    assert_eq!([triangles(0.29, limit), triangles(0.4, limit)], [0, 2]);
    let old = r#""materials":[{"alphaMode":"MASK","extensions":{"KHR_materials_pbrSpecularGlossiness":
        {"diffuseFactor":[1,1,1,0.4]}}"#;
    assert!(changed(from, old).expect("nothing").columns.triangles.is_empty());
}

#[test]
fn hidden_nodes_show_nothing() {
    let hidden = r#""extensions":{"KHR_node_visibility":{"visible":false}}"#;
    let with = |from: &str, to: &str| {
        let json = SCENE.replacen(from, to, 1);
        let used = r#""extensionsUsed":["KHR_node_visibility"],"extensionsRequired":["KHR_node_visibility"],"asset""#;
        let mesh = load(&json.replacen(r#""asset""#, used, 1)).expect("a mesh");
        let told = mesh.notes.iter().filter(|note| note.contains("1 hidden node"));
        let is_hidden = json.contains(r#""visible":false"#);
        assert_eq!(
            (told.count(), mesh.notes.len()),
            (is_hidden.into(), is_hidden.into())
        );
        assert_eq!(mesh.cameras.len(), 1, "cameras stay");
        mesh.columns.x
    };
    let first = with(
        r#""nodes":[{"mesh":0}"#,
        &format!(r#""nodes":[{{"mesh":0,{hidden}}}"#),
    );
    assert_eq!(first, [10.0, 8.0, 10.0]);
    // With all nodes below it, even those that say otherwise.
    let parent = format!(r#"{{{hidden},"children""#);
    let visible = r#""translation":[10,0,0]},{"extensions":{"KHR_node_visibility":{"visible":true}},"#;
    assert_eq!(with(r#"{"children""#, &parent), [0.0, 1.0, 0.0]);
    let inside = format!(r#"{{{hidden},"children":[2,3],{visible}"#);
    let all = r#"{"children":[2,3],"translation":[10,0,0]},{"#;
    assert_eq!(with(all, &inside), [0.0, 1.0, 0.0]);
    let visible = hidden.replace("false", "true");
    assert_eq!(
        with(r#"{"children""#, &format!(r#"{{{visible},"children""#)).len(),
        6
    );
    let faulty = hidden.replace("false", "3");
    assert_eq!(
        with(r#"{"children""#, &format!(r#"{{{faulty},"children""#)).len(),
        6
    );
}

#[test]
fn materials_are_one_sided_unless_they_say_otherwise() {
    let from = r#""materials":[{"#;
    let is_one_sided = |rest: &str| {
        let mesh = changed(from, &format!(r#""materials":[{{{rest}"#)).expect("a mesh");
        mesh.surfaces[0].textures.one_sided
    };
    assert!(is_one_sided("") && is_one_sided(r#""doubleSided":false,"#));
    assert!(!is_one_sided(r#""doubleSided":true,"#));
    let glass = r#""extensions":{"KHR_materials_transmission":{"transmissionFactor":1}},"pbrMetallicRoughness":{"metallicFactor":0}},{"#;
    assert!(!is_one_sided(glass));
    let without = changed(r#","material":0"#, "").expect("a mesh");
    assert!(without.surfaces.iter().all(|surface| !surface.textures.one_sided));
}

/// A set of points, and a triangle in a node of its own.
#[test]
fn what_the_scene_does_not_show_makes_no_cloud_a_mesh() {
    let points = r#""meshes":[{"primitives":[{"mode":0,"attributes":{"POSITION":0}}]},"#;
    let both = SCENE
        .replace(r#""meshes":["#, points)
        .replacen(r#"{"mesh":0}"#, r#"{"mesh":1}"#, 1);
    let shown = |scenes: &str| {
        let json = both.replace(r#""scenes":[{"nodes":[0,1]}]"#, scenes);
        load(&json).map(|mesh| (mesh.cloud.is_some(), mesh.columns.x.len()))
    };
    assert_eq!(shown(r#""scenes":[{"nodes":[1]}]"#), Ok((true, 3)));
    assert_eq!(
        shown(r#""scenes":[{"nodes":[0]},{"nodes":[1]}],"scene":1"#),
        Ok((true, 3))
    );
    assert_eq!(
        shown(r#""scenes":[{"nodes":[0,1]},{"nodes":[1]}]"#),
        Ok((false, 3))
    );
    let hidden = both.replacen(
        r#"{"mesh":1}"#,
        r#"{"mesh":1,"extensions":{"KHR_node_visibility":{"visible":false}}}"#,
        1,
    );
    assert!(load(&hidden).expect("points").cloud.is_some());
}

//! Meshes that are stored once, and `EXT_mesh_gpu_instancing`.

use super::*;
use crate::format::mesh::Sharing;
use crate::scene::{SceneBuilder, Transform};

/// Reads a file; its buffer has this behind the triangle.
fn load_with(json: &str, more: &[f32], sharing: Sharing) -> Result<LoadedMesh, String> {
    let mut bytes = buffer();
    bytes.extend(more.iter().flat_map(|value| value.to_le_bytes()));
    let json = json.replacen(
        r#""byteLength":76"#,
        &format!(r#""byteLength":{}"#, bytes.len()),
        1,
    );
    parse(
        json.as_bytes(),
        Path::new("a.gltf"),
        &mut |_| Ok(bytes.clone()),
        &Budget::unlimited().with_sharing(sharing),
    )
    .map_err(|error| error.to_string().trim_start_matches("a.gltf:").to_owned())
}

/// The triangle at the nodes, and a group that mirrors it.
fn at_nodes(nodes: &str) -> String {
    let nodes = format!(r#""nodes":[{{"mesh":0}},{nodes}"#);
    SCENE.replacen(r#""nodes":[{"mesh":0},"#, &nodes, 1)
}

/// The positions of all triangles in all places, sorted.
fn positions(mesh: &LoadedMesh) -> Vec<[u32; 3]> {
    let mut all = Vec::new();
    for placed in mesh.placed() {
        let columns = placed.mesh;
        for placement in placed.placements {
            for i in columns.triangles.as_flattened() {
                let i = *i as usize;
                let point = Vec3::new(columns.x[i], columns.y[i], columns.z[i]);
                all.push(placement.point(point).to_array().map(|x| (x + 0.0).to_bits()));
            }
        }
    }
    all.sort_unstable();
    all
}

#[test]
fn shared_meshes_stand_where_baked_ones_do() {
    let [baked, shared] = [Sharing::Never, Sharing::Always].map(|sharing| load_with(SCENE, &[], sharing));
    let (baked, shared) = (baked.expect("a mesh"), shared.expect("a mesh"));
    assert!(baked.shared.is_empty() && shared.columns.triangles.is_empty());
    let [part] = &shared.shared[..] else {
        panic!("{:?}", shared.shared)
    };
    assert_eq!((part.columns.x.len(), part.placements.len()), (3, 2));
    assert_eq!(part.placements[0], Transform::IDENTITY);
    assert_eq!(positions(&shared), positions(&baked));
    assert_eq!((&shared.surfaces, &part.surface_of), (&baked.surfaces, &vec![0]));
    assert_eq!(shared.cameras, baked.cameras);
    // Few triangles are baked.
    let pays = load_with(SCENE, &[], Sharing::WherePays).expect("a mesh");
    assert!(pays.shared.is_empty() && pays.columns.x == baked.columns.x);
    let mut builder = SceneBuilder::new();
    shared.add_to(&mut builder, None).expect("a scene");
    let scene = builder.finish();
    assert_eq!((scene.triangles().corners.len(), scene.instances().len()), (1, 2));
}

#[test]
fn flat_nodes_are_baked_and_those_without_size_left_out() {
    let nodes = r#"{"children":[2,3,4,5,6]},{"mesh":0,"scale":[1,1,0]},{"mesh":0,"scale":[-1,2,3]},
        {"mesh":0,"scale":[0,0,0]},{"mesh":0,"scale":[0,0,3]},{"mesh":0,"translation":[5,0,0]}],"unused":["#;
    let json = at_nodes(nodes);
    let mesh = load_with(&json, &[], Sharing::Always).expect("a mesh");
    assert_eq!(
        (mesh.columns.triangles.len(), mesh.shared[0].placements.len()),
        (1, 3)
    );
    assert_eq!(
        mesh.notes,
        ["a.gltf: left out: 2 placements scaled to lines or points"]
    );
    let far = json.replace("[5,0,0]", "[3e9,0,0]");
    assert_eq!(
        load_with(&far, &[], Sharing::Always).expect_err("far away"),
        " nodes[6]: cannot place its mesh: x is 3e9, but numbers above 1e9 are not supported"
    );
}

/// Two instances of the triangle, with these attributes: 0 has translations, 1 rotations, 2 scales, 3 one vector.
fn instanced(attributes: &str) -> String {
    let node = format!(
        r#"{{"mesh":0,"translation":[1,0,0],"extensions":{{"EXT_mesh_gpu_instancing":{{"attributes":{attributes}}}}}}}"#
    );
    SCENE
        .replacen(
            r#""asset":{"version":"2.0"}"#,
            r#""asset":{"version":"2.0"},
            "extensionsUsed":["EXT_mesh_gpu_instancing"],"extensionsRequired":["EXT_mesh_gpu_instancing"]"#,
            1,
        )
        .replacen(r#"{"mesh":0},{"children""#, &format!(r#"{node},{{"children""#), 1)
        .replacen(r#"{"mesh":0,"scale":[2,1,1],"rotation":[0,0,1,0]}"#, "{}", 1)
        .replacen(
            r#""accessors":["#,
            r#""accessors":[{"bufferView":2,"componentType":5126,"count":2,"type":"VEC3"},
            {"bufferView":2,"byteOffset":24,"componentType":5126,"count":2,"type":"VEC4"},
            {"bufferView":2,"byteOffset":56,"componentType":5126,"count":2,"type":"VEC3"},
            {"bufferView":2,"componentType":5126,"count":1,"type":"VEC3"},"#,
            1,
        )
        .replacen(
            r#"{"POSITION":0,"NORMAL":1},"indices":2"#,
            r#"{"POSITION":4,"NORMAL":5},"indices":6"#,
            1,
        )
        .replacen(
            r#""byteOffset":72,"byteLength":3}"#,
            r#""byteOffset":72,"byteLength":3},{"buffer":0,"byteOffset":76,"byteLength":80}"#,
            1,
        )
}

const INSTANCES: [f32; 20] = [
    0.0, 0.0, 0.0, 0.0, 7.0, 0.0, // translations
    0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 3.0, 0.0, // rotations: none, and half a turn about z
    1.0, 1.0, 1.0, 2.0, -1.0, 1.0, // scales
];

#[test]
fn instances_of_a_node() {
    let all = instanced(r#"{"TRANSLATION":0,"ROTATION":1,"SCALE":2,"_ID":0}"#);
    for sharing in [Sharing::Never, Sharing::Always] {
        let mesh = load_with(&all, &INSTANCES, sharing).expect("a mesh");
        assert_eq!(mesh.shared.len(), usize::from(sharing == Sharing::Always));
        let mut expected = [
            [1.0, 0.0, 0.0],
            [2.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [1.0, 7.0, 0.0],
            [-1.0, 7.0, 0.0],
            [1.0, 8.0, 0.0_f32],
        ]
        .map(|point| point.map(f32::to_bits));
        expected.sort_unstable();
        assert_eq!(positions(&mesh), expected, "{sharing:?}");
        assert!(mesh.notes.is_empty(), "{:?}", mesh.notes);
    }
    // Without attributes that place anything it stands there once.
    for attributes in ["{}", r#"{"_ID":0}"#] {
        let mesh = load_with(&instanced(attributes), &INSTANCES, Sharing::Never).expect("a mesh");
        assert_eq!(mesh.columns.triangles.len(), 1, "{attributes}");
    }
}

#[test]
fn faults_of_instances() {
    let refused = |attributes: &str, place: usize, value: f32| {
        let mut numbers = INSTANCES;
        numbers[place] = value;
        let json = instanced(attributes);
        let [never, always] = [Sharing::Never, Sharing::Always]
            .map(|sharing| load_with(&json, &numbers, sharing).expect_err("it is refused"));
        assert_eq!(never, always);
        never
    };
    let node = " nodes[0].extensions.EXT_mesh_gpu_instancing:";
    let all = r#"{"TRANSLATION":0,"ROTATION":1,"SCALE":2}"#;
    assert_eq!(
        refused(r#"{"TRANSLATION":0,"SCALE":3}"#, 0, 0.0),
        format!("{node} its accessors have 2 and 1 elements, expected equal numbers")
    );
    assert_eq!(
        refused(r#"{"SCALE":70}"#, 0, 0.0),
        format!("{node} accessor 70, but the file has only 7")
    );
    assert_eq!(
        refused(r#"{"SCALE":1}"#, 0, 0.0),
        " accessors[1] holds other elements, expected vectors of 3 numbers"
    );
    assert_eq!(
        refused(r#"{"ROTATION":0}"#, 0, 0.0),
        " accessors[0] holds other elements, expected quaternions (vectors of 4 numbers)"
    );
    assert_eq!(
        refused(all, 4, f32::INFINITY),
        " accessors[0]: translation 2 of 2 has a number that is not finite"
    );
    assert_eq!(
        refused(all, 14, f32::NAN),
        " accessors[2]: scale 1 of 2 has a number that is not finite"
    );
    assert_eq!(
        refused(all, 12, 0.0),
        " accessors[1]: rotation 2 of 2 is no quaternion of a length above 0"
    );
    let odd = refused(r#"{"SCALE":-1}"#, 0, 0.0);
    assert!(
        odd.ends_with("not valid EXT_mesh_gpu_instancing: invalid value: integer `-1`, expected usize"),
        "{odd}"
    );
    // Zeros take no bytes.
    let many = instanced(r#"{"TRANSLATION":3}"#).replacen(
        r#"{"bufferView":2,"componentType":5126,"count":1,"type":"VEC3"}"#,
        r#"{"componentType":5126,"count":4000000000,"type":"VEC3","sparse":{"count":1,
            "indices":{"bufferView":1,"componentType":5121},"values":{"bufferView":0}}}"#,
        1,
    );
    let error = load_with(&many, &INSTANCES, Sharing::Always).expect_err("too many");
    assert!(
        error.starts_with(" 4000000000 instances, expected at most "),
        "{error}"
    );
}

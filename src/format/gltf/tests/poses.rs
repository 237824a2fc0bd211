//! Skins and morph targets.

use super::*;
use crate::format::mesh::Sharing;
use glam::DMat4;
use std::fmt::Write as _;

/// A glTF file with its buffer inside, part by part.
#[derive(Default)]
pub(super) struct File {
    buffer: Vec<u8>,
    views: Vec<String>,
    accessors: Vec<String>,
}

impl File {
    /// Adds an accessor; `kind` is the rest of its JSON. Returns its index.
    pub(super) fn add(&mut self, count: usize, kind: &str, bytes: &[u8]) -> usize {
        self.buffer.resize(self.buffer.len().next_multiple_of(4), 0);
        let (view, start, length) = (self.views.len(), self.buffer.len(), bytes.len());
        self.views.push(format!(
            r#"{{"buffer":0,"byteOffset":{start},"byteLength":{length}}}"#
        ));
        self.buffer.extend(bytes);
        self.accessors
            .push(format!(r#"{{"bufferView":{view},"count":{count},{kind}}}"#));
        self.accessors.len() - 1
    }

    pub(super) fn floats(&mut self, count: usize, kind: &str, numbers: &[f32]) -> usize {
        let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        let kind = format!(r#""componentType":5126,"type":"{kind}""#);
        self.add(count, &kind, &bytes)
    }

    pub(super) fn finish(&self, body: &str) -> String {
        let mut json = format!(r#"{{"asset":{{"version":"2.0"}},{body},"#);
        let _ = write!(
            json,
            r#""accessors":[{}],"bufferViews":[{}],"buffers":[{{"byteLength":{},"uri":"data:;base64,{}"}}]}}"#,
            self.accessors.join(","),
            self.views.join(","),
            self.buffer.len(),
            base64(&self.buffer)
        );
        json
    }
}

/// A strip of two squares along y, with normals along z. Its lower edge follows the first joint, the upper one the second,
/// and the middle both. The second joint is at the middle, turned a quarter about z, and its parent is moved by 10 along
/// x. Joints and weights are accessors 2 and 3, inverse bind matrices 4.
pub(super) fn strip(change: impl Fn(&mut File)) -> File {
    let mut file = File::default();
    let positions = [0, 1, 2].map(|y| [0.0, y as f32, 0.0, 1.0, y as f32, 0.0]);
    file.floats(6, "VEC3", positions.as_flattened());
    file.floats(6, "VEC3", &[0.0, 0.0, 1.0].repeat(6));
    // The numbers of joints without weight are arbitrary.
    let joints = [
        [0, 99, 7, 7],
        [0, 99, 7, 7],
        [0, 1, 0, 0],
        [0, 1, 0, 0],
        [1, 5, 5, 5],
        [1, 5, 5, 5],
    ];
    file.add(6, r#""componentType":5121,"type":"VEC4""#, joints.as_flattened());
    let weights = [1.0, 0.0, 0.0, 0.0].repeat(2);
    let middle = [0.5, 0.5, 0.0, 0.0].repeat(2);
    file.floats(6, "VEC4", &[&weights[..], &middle[..], &weights[..]].concat());
    let mut matrices = [DMat4::IDENTITY.to_cols_array().map(|x| x as f32); 2];
    matrices[1][13] = -1.0;
    file.floats(2, "MAT4", matrices.as_flattened());
    file.add(
        9,
        r#""componentType":5121,"type":"SCALAR""#,
        &[0, 1, 2, 2, 1, 3, 2, 3, 4],
    );
    change(&mut file);
    file
}

/// The strip at a node that is moved itself, which does not count.
pub(super) const BENT: &str = r#""nodes":[{"mesh":0,"skin":0,"translation":[0,0,70]},{"children":[2],"translation":[10,0,0]},
    {"translation":[0,1,0],"rotation":[0,0,0.70710678,0.70710678]}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0,"NORMAL":1,"JOINTS_0":2,"WEIGHTS_0":3},"indices":5}]}],
    "skins":[{"joints":[1,2],"inverseBindMatrices":4}]"#;

pub(super) fn load_file(json: &str, sharing: Sharing) -> Result<LoadedMesh, String> {
    let open = &mut |_: &Path| Err(io::ErrorKind::NotFound.into());
    let budget = Budget::new(1 << 30).with_sharing(sharing);
    parse(json.as_bytes(), Path::new("a.gltf"), open, &budget)
        .map_err(|error| error.to_string().trim_start_matches("a.gltf:").to_owned())
}

fn loaded(json: &str) -> LoadedMesh {
    load_file(json, Sharing::Never).expect("a mesh")
}

/// The positions of a mesh, rounded: turns in files are not exact.
pub(super) fn points(mesh: &LoadedMesh) -> Vec<[f32; 3]> {
    let round = |x: f32| (x * 1e5).round() / 1e5 + 0.0;
    let columns = &mesh.columns;
    let all = columns.x.iter().zip(&columns.y).zip(&columns.z);
    all.map(|((x, y), z)| [*x, *y, *z].map(round)).collect()
}

/// The strip, bent to the left in the middle.
const BENT_POINTS: [[f32; 3]; 6] = [
    [10.0, 0.0, 0.0],
    [11.0, 0.0, 0.0],
    // The means of 10 1 0 twice, and of 11 1 0 and 10 2 0.
    [10.0, 1.0, 0.0],
    [10.5, 1.5, 0.0],
    [9.0, 1.0, 0.0],
    [9.0, 2.0, 0.0],
];

#[test]
fn two_joints_bend_a_strip() {
    let mesh = loaded(&strip(|_| {}).finish(BENT));
    assert_eq!(points(&mesh), BENT_POINTS);
    assert_eq!(mesh.columns.triangles, [[0, 1, 2], [2, 1, 3], [2, 3, 4]]);
    assert_eq!(mesh.columns.normals, [Vec3::Z; 6]);
    assert!(mesh.notes.is_empty(), "{:?}", mesh.notes);
    // Joints outside the scene have a place, too.
    let outside = format!(r#""scenes":[{{"nodes":[0]}}],{BENT}"#);
    assert_eq!(points(&loaded(&strip(|_| {}).finish(&outside))), BENT_POINTS);
    // Without inverse bind matrices, all is placed by the joints alone.
    let without = BENT.replace(r#","inverseBindMatrices":4"#, "");
    let mesh = loaded(&strip(|_| {}).finish(&without));
    assert_eq!(points(&mesh)[4..], [[8.0, 1.0, 0.0], [8.0, 2.0, 0.0]]);
    // Primitives without joints stand where their node does.
    let rigid = BENT.replace(r#","JOINTS_0":2,"WEIGHTS_0":3"#, "");
    assert_eq!(
        points(&loaded(&strip(|_| {}).finish(&rigid)))[0],
        [0.0, 0.0, 70.0]
    );
}

#[test]
fn weights_of_all_types_and_sets() {
    // Bytes and shorts, marked as normalised or not, and sums that are not 1.
    let bytes = [
        [255, 0, 0, 0],
        [255, 0, 0, 0],
        [128, 128, 0, 0],
        [9, 9, 0, 0],
        [3, 0, 0, 0],
        [0; 4],
    ];
    let shorts: Vec<u8> = bytes
        .iter()
        .flatten()
        .flat_map(|&weight| u16::from(weight).to_le_bytes())
        .collect();
    for kind in [
        r#""componentType":5121,"normalized":true"#,
        r#""componentType":5121"#,
        r#""componentType":5123,"normalized":true"#,
    ] {
        let bytes = if kind.contains("5121") {
            bytes.as_flattened()
        } else {
            &shorts
        };
        let file = strip(|file| {
            file.add(6, &format!(r#"{kind},"type":"VEC4""#), bytes);
        });
        let mesh = loaded(&file.finish(&BENT.replace(r#""WEIGHTS_0":3"#, r#""WEIGHTS_0":6"#)));
        // The last vertex has no weights: it follows its first joint.
        assert_eq!(points(&mesh), BENT_POINTS, "{kind}");
    }
    // Two sets: the second moves all to the first joint, with three quarters of the weight.
    let file = strip(|file| {
        file.add(6, r#""componentType":5123,"type":"VEC4""#, &[0; 48]);
        file.floats(6, "VEC4", &[3.0, 0.0, 0.0, 0.0].repeat(6));
    });
    let more = BENT.replace(r#""WEIGHTS_0":3"#, r#""WEIGHTS_0":3,"JOINTS_1":6,"WEIGHTS_1":7"#);
    let mesh = loaded(&file.finish(&more));
    assert_eq!(points(&mesh)[4], [9.75, 1.75, 0.0]);
}

#[test]
fn normals_follow_joints() {
    // The second joint stretches by 4 along x and mirrors z. Normals stay normal to what they were.
    let slanted = [0.6, 0.0, 0.8].repeat(6);
    let file = strip(|file| {
        file.floats(6, "VEC3", &slanted);
    });
    let body = BENT
        .replace(r#""NORMAL":1"#, r#""NORMAL":6"#)
        .replace(r#""rotation":[0,0,0.70710678,0.70710678]"#, r#""scale":[4,1,-1]"#);
    let normals = loaded(&file.finish(&body)).columns.normals;
    assert_eq!(normals[0], Vec3::new(0.6, 0.0, 0.8));
    assert!(
        normals[5].abs_diff_eq(Vec3::new(0.15, 0.0, -0.8).normalize(), 1e-6),
        "{}",
        normals[5]
    );
    // A skin that is mirrored as a whole keeps its front.
    let mirrored = BENT.replace(r#""translation":[10,0,0]"#, r#""scale":[-1,1,1]"#);
    let mesh = loaded(&strip(|_| {}).finish(&mirrored));
    assert_eq!(mesh.columns.triangles[0], [0, 2, 1]);
    assert_eq!(mesh.columns.normals, [Vec3::Z; 6]);
}

#[test]
fn each_node_has_its_own_pose() {
    let poses = BENT
        .replace(r#""nodes":["#, r#""scenes":[{"nodes":[0,1,3,4,5]}],"nodes":["#)
        .replace(
            r"0.70710678]}]",
            r#"0.70710678]},{"mesh":0,"skin":1,"scale":[7,7,7]},{"mesh":0,"skin":0},{"mesh":0,"translation":[0,0,3]}]"#,
        )
        .replace(r#""inverseBindMatrices":4}"#, r#""inverseBindMatrices":4},{"joints":[1,1]}"#);
    let json = strip(|_| {}).finish(&poses);
    let plain: Vec<[f32; 3]> = (0..6).map(|i| [(i % 2) as f32, (i / 2) as f32, 0.0]).collect();
    let moved = |by: [f32; 3]| {
        plain
            .iter()
            .map(move |point| [0, 1, 2].map(|axis| point[axis] + by[axis]))
    };
    let mut expected = BENT_POINTS.to_vec();
    expected.extend(moved([10.0, 0.0, 0.0]));
    expected.extend(BENT_POINTS);
    expected.extend(moved([0.0, 0.0, 3.0]));
    for sharing in [Sharing::Never, Sharing::Always] {
        let mesh = load_file(&json, sharing).expect("a mesh");
        assert!(mesh.shared.is_empty());
        assert_eq!(points(&mesh), expected, "{sharing:?}");
    }
}

#[test]
fn faults_of_skins() {
    let refused = |change: &dyn Fn(&mut File), from: &str, to: &str| {
        assert!(BENT.contains(from), "{from}");
        let json = strip(change).finish(&BENT.replace(from, to));
        load_file(&json, Sharing::Never).expect_err("it is refused")
    };
    let same = |from: &str, to: &str| refused(&|_| {}, from, to);
    assert_eq!(
        same(r#""joints":[1,2],"inverseBindMatrices":4"#, r#""joints":[1]"#),
        " accessors[2]: vertex 3 of 6: joint 1, but the skin has only 1 joint"
    );
    assert!(same(r#""joints":[1,2]"#, r#""joints":[1,9]"#).contains("skins[0].joints[1]: "));
    assert_eq!(
        same(r#""joints":[1,2]"#, r#""joints":[]"#),
        " skins[0] has no joints"
    );
    assert_eq!(
        same(r#""joints":[1,2]"#, r#""joints":[1,2,2]"#),
        " accessors[4] has 2 matrices, but skins[0] has 3 joints"
    );
    assert_eq!(
        same(r#""inverseBindMatrices":4"#, r#""inverseBindMatrices":3"#),
        " accessors[3] holds other elements, expected matrices (16 floats)"
    );
    assert_eq!(
        same(r#""JOINTS_0":2"#, r#""JOINTS_0":3"#),
        " accessors[3] holds other elements, expected joints (4 bytes or unsigned shorts)"
    );
    assert_eq!(
        same(r#""WEIGHTS_0":3"#, r#""WEIGHTS_0":1"#),
        " accessors[1] holds other elements, expected weights (4 bytes, unsigned shorts or floats)"
    );
    assert_eq!(
        same(r#","WEIGHTS_0":3"#, ""),
        " meshes[0].primitives[0] has JOINTS_0 but no WEIGHTS_0"
    );
    assert_eq!(
        same(r#""JOINTS_0":2,"#, ""),
        " meshes[0].primitives[0] has WEIGHTS_0 but no JOINTS_0"
    );
    let few = |file: &mut File| {
        file.floats(5, "VEC4", &[1.0; 20]);
    };
    assert_eq!(
        refused(&few, r#""WEIGHTS_0":3"#, r#""WEIGHTS_0":6"#),
        " accessors[6] has 5 elements, but the primitive has 6 vertices"
    );
    let odd = |file: &mut File| {
        file.floats(6, "VEC4", &[f32::NAN; 24]);
        file.floats(2, "MAT4", &[f32::INFINITY; 32]);
    };
    assert_eq!(
        refused(&odd, r#""WEIGHTS_0":3"#, r#""WEIGHTS_0":6"#),
        " accessors[6]: vertex 1 of 6: weight is NaN, expected a finite number"
    );
    assert_eq!(
        refused(&odd, r#"Matrices":4"#, r#"Matrices":7"#),
        " accessors[7]: matrix 1 of 2 has a number that is not finite"
    );
    // Joints that contain themselves, outside the scene.
    let cycle = r#"0.70710678],"children":[1]}"#;
    let nodes = r#""scenes":[{"nodes":[0]}],"nodes":[{"mesh""#;
    let body = BENT
        .replace("0.70710678]}", cycle)
        .replace(r#""nodes":[{"mesh""#, nodes);
    assert_eq!(
        load_file(&strip(|_| {}).finish(&body), Sharing::Never).expect_err("a cycle"),
        " nodes[1] has two parents or contains itself"
    );
}

/// The strip without joints; its first target moves it along z, the second one along x, and changes normals.
fn morphed(weights: &str) -> String {
    let file = strip(|file| {
        file.floats(6, "VEC3", &[0.0, 0.0, 2.0].repeat(6));
        file.floats(6, "VEC3", &[4.0, 0.0, 0.0].repeat(6));
        file.floats(6, "VEC3", &[2.0, 0.0, 0.0].repeat(6));
    });
    let targets = format!(
        r#""indices":5,"targets":[{{"POSITION":6,"TANGENT":99}},{{"POSITION":7,"NORMAL":8}}]}}]{weights}"#
    );
    file.finish(&BENT.replace(r#""indices":5}]"#, &targets))
}

#[test]
fn morph_targets_are_added_by_weight() {
    let rigid = |weights: &str| morphed(weights).replace(r#""skin":0,"#, "");
    // The node is at z = 70.
    let without = loaded(&rigid(""));
    assert_eq!(points(&without)[5], [1.0, 2.0, 70.0]);
    assert!(without.notes.is_empty(), "{:?}", without.notes);
    let of_mesh = loaded(&rigid(r#","weights":[0.5,0]"#));
    assert_eq!(points(&of_mesh)[5], [1.0, 2.0, 71.0]);
    assert_eq!(of_mesh.columns.normals, [Vec3::Z; 6]);
    let both = loaded(&rigid(r#","weights":[-1,0.5]"#));
    assert_eq!(points(&both)[5], [3.0, 2.0, 68.0]);
    let slanted = Vec3::new(1.0, 0.0, 1.0).normalize();
    assert!(both.columns.normals[3].abs_diff_eq(slanted, 1e-6));
    // The node's weights count more than the mesh's, and make a mesh of their own.
    let nodes = r#""nodes":[{"mesh":0,"weights":[1,0]},{"mesh":0},{"mesh":0},"#;
    let nodes = rigid(r#","weights":[0.5,0]"#)
        .replace(r#""nodes":["#, nodes)
        .replace(r#""children":[2]"#, r#""children":[5]"#);
    for (sharing, parts) in [(Sharing::Never, 0), (Sharing::Always, 1)] {
        let mesh = load_file(&nodes, sharing).expect("a mesh");
        assert_eq!(mesh.shared.len(), parts);
        assert_eq!(points(&mesh)[5], [1.0, 2.0, 2.0]);
        if let [part] = &mesh.shared[..] {
            assert_eq!((part.columns.z[5], part.placements.len()), (1.0, 3));
        }
    }
}

#[test]
fn morph_targets_come_before_joints() {
    // The upper edge is moved up, then turned to the left.
    let mesh = loaded(&morphed(r#","weights":[0.5,0.25]"#));
    assert_eq!(points(&mesh)[..2], [[11.0, 0.0, 1.0], [12.0, 0.0, 1.0]]);
    assert_eq!(points(&mesh)[4..], [[9.0, 2.0, 1.0], [9.0, 3.0, 1.0]]);
}

#[test]
fn targets_may_be_sparse_and_change_colours() {
    let file = strip(|file| {
        // Only the last vertex moves.
        file.add(1, r#""componentType":5121,"type":"SCALAR""#, &[5]);
        file.floats(1, "VEC3", &[0.0, 8.0, 0.0]);
        file.accessors.push(
            r#"{"count":6,"componentType":5126,"type":"VEC3","sparse":{"count":1,
            "indices":{"bufferView":6,"componentType":5121},"values":{"bufferView":7}}}"#
                .to_owned(),
        );
        file.floats(6, "VEC4", &[0.0, 0.25, 1.0, 1.0].repeat(6));
        file.add(
            6,
            r#""componentType":5120,"normalized":true,"type":"VEC3""#,
            &[127, 127, 129].repeat(6),
        );
    });
    let body = BENT
        .replace(r#""skin":0,"#, "")
        .replace(r#""JOINTS_0":2,"WEIGHTS_0":3"#, r#""COLOR_0":9"#)
        .replace(
            r#""indices":5}]"#,
            r#""indices":5,"targets":[{"POSITION":8,"COLOR_0":10}]}],"weights":[0.75]"#,
        );
    let mesh = loaded(&file.finish(&body));
    assert_eq!(points(&mesh)[4..], [[0.0, 2.0, 70.0], [1.0, 8.0, 70.0]]);
    let expected = [0.75, 1.0, 0.25].map(materials::display_value);
    assert_eq!(mesh.columns.colors[0], expected);
    assert!(mesh.notes.is_empty(), "{:?}", mesh.notes);
}

#[test]
fn faults_of_morph_targets() {
    let refused = |target: &str| {
        let targets = format!(r#""indices":5,"targets":[{target}]}}],"weights":[1]"#);
        let json = strip(|_| {}).finish(&BENT.replace(r#""indices":5}]"#, &targets));
        load_file(&json, Sharing::Never).expect_err("it is refused")
    };
    assert_eq!(
        refused(r#"{"POSITION":70}"#),
        " meshes[0].primitives[0].targets[0]: accessor 70, but the file has only 6"
    );
    assert_eq!(
        refused(r#"{"NORMAL":3}"#),
        " accessors[3] holds other elements, expected vectors of 3 numbers"
    );
    assert_eq!(
        refused(r#"{"COLOR_0":5}"#),
        " accessors[5] holds other elements, expected differences of colours (3 or 4 numbers)"
    );
    let odd = refused(r#"{"POSITION":0,"_OWN":-1}"#);
    assert!(
        odd.ends_with("not valid morph targets: invalid value: integer `-1`, expected usize"),
        "{odd}"
    );
    let huge = strip(|_| {}).finish(&BENT.replace(
        r#""indices":5}]"#,
        r#""indices":5,"targets":[{"POSITION":0}]}],"weights":[1e300]"#,
    ));
    let error = load_file(&huge, Sharing::Never).expect_err("too far");
    assert!(error.contains("vertex 1 of 6: "), "{error}");
    let few = strip(|file| {
        file.floats(1, "VEC3", &[0.0; 3]);
    });
    let few = few.finish(&BENT.replace(
        r#""indices":5}]"#,
        r#""indices":5,"targets":[{"POSITION":6}]}],"weights":[1]"#,
    ));
    assert_eq!(
        load_file(&few, Sharing::Never).expect_err("too few"),
        " accessors[6] has 1 difference, but the primitive has 6 vertices"
    );
}

/// Small files whose poses would take hours.
#[test]
fn poses_of_the_same_bytes() {
    let list = |text: &str, count: usize| vec![text; count].join(",");
    let of_vertices = |count: usize| {
        let mut file = File::default();
        file.add(
            count,
            r#""componentType":5120,"type":"VEC3""#,
            &vec![1; 3 * count],
        );
        file.add(3, r#""componentType":5121,"type":"SCALAR""#, &[0, 1, 2, 0]);
        file
    };
    let with = |file: &File, nodes: usize, targets: usize| {
        file.finish(&format!(
            r#""nodes":[{}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"targets":[{}]}}],"weights":[{}]}}]"#,
            list(r#"{"mesh":0}"#, nodes),
            list(r#"{"POSITION":0}"#, targets),
            list("1", targets)
        ))
    };
    assert_eq!(loaded(&with(&of_vertices(6_000), 2, 20)).columns.x[0], 21.0);
    let file = of_vertices(60_000);
    for json in [with(&file, 1, 2000), with(&file, 2, 180)] {
        let error = load_file(&json, Sharing::Never).expect_err("too many");
        assert!(
            error.starts_with(" skins and morph targets change vertices "),
            "{error}"
        );
    }
    // Every node has a skin of its own.
    let nodes: Vec<String> = (0..3000).map(|i| format!(r#"{{"mesh":0,"skin":{i}}}"#)).collect();
    let json = file.finish(&format!(
        r#""nodes":[{}],"skins":[{}],"meshes":[{{"primitives":[{}]}}]"#,
        nodes.join(","),
        list(r#"{"joints":[0]}"#, 3000),
        list(r#"{"attributes":{"POSITION":0},"indices":1}"#, 3000)
    ));
    let error = load_file(&json, Sharing::Never).expect_err("too many");
    assert!(
        error.starts_with(" skins and morph targets change vertices "),
        "{error}"
    );
}

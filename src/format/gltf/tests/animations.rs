//! Poses of animations.

use super::poses::{BENT, File, points, strip};
use super::*;
use crate::format::mesh::Moment;

/// Keyframes at 1 and 3 seconds.
const TIMES: [f32; 2] = [1.0, 3.0];

pub(super) fn posed(json: &str, animation: Option<&str>, seconds: f64) -> Result<LoadedMesh, String> {
    let open = &mut |_: &Path| Err(io::ErrorKind::NotFound.into());
    let moment = Moment {
        animation: animation.map(str::to_owned),
        seconds,
    };
    let budget = Budget::new(1 << 30).with_moment(Some(moment));
    parse(json.as_bytes(), Path::new("a.gltf"), open, &budget)
        .map_err(|error| error.to_string().trim_start_matches("a.gltf: ").to_owned())
}

/// The strip, a child of node 1 without its skin, and one animation of that: accessors 6 and 7 are its times and values.
fn moved(path: &str, interpolation: &str, kind: &str, values: &[&[f32]]) -> String {
    let file = strip(|file| {
        file.floats(2, "SCALAR", &TIMES);
        file.floats(values.len(), kind, &values.concat());
    });
    let nodes = r#""nodes":[{"mesh":0},{"children":[0],"translation":[10,0,0],"scale":[1,1,2]}],"scenes":[{"nodes":[1]}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":5}]}]"#;
    file.finish(&format!(
        r#"{nodes},"animations":[{{"name":"go","channels":[{{"sampler":0,"target":{{"node":1,"path":"{path}"}}}}],
        "samplers":[{{"input":6,"output":7,"interpolation":"{interpolation}"}}]}}]"#
    ))
}

/// Where the corner 1 0 0 of the strip is at these times.
fn corner_at(json: &str, times: &[f64]) -> Vec<[f32; 3]> {
    let at = |&seconds: &f64| points(&posed(json, None, seconds).expect("a mesh"))[1];
    times.iter().map(at).collect()
}

#[test]
fn translations_go_from_keyframe_to_keyframe() {
    let values: [&[f32]; 2] = [&[0.0, 2.0, 0.0], &[4.0, 2.0, 8.0]];
    let linear = moved("translation", "LINEAR", "VEC3", &values);
    assert_eq!(
        corner_at(&linear, &[0.0, 1.0, 1.5, 3.0, 99.0]),
        [
            [1.0, 2.0, 0.0],
            [1.0, 2.0, 0.0],
            [2.0, 2.0, 2.0],
            [5.0, 2.0, 8.0],
            [5.0, 2.0, 8.0]
        ]
    );
    let step = moved("translation", "STEP", "VEC3", &values);
    assert_eq!(
        corner_at(&step, &[0.0, 2.9, 3.0]),
        [[1.0, 2.0, 0.0], [1.0, 2.0, 0.0], [5.0, 2.0, 8.0]]
    );
    // Arriving tangent, value, leaving tangent. In the middle: the mean of values, and an eighth of the time between
    // keyframes times the difference of tangents.
    let zero = &[0.0, 0.0, 0.0][..];
    let cubic = [
        zero,
        &[0.0, 2.0, 0.0],
        &[0.0, 8.0, 0.0],
        &[4.0, 0.0, 0.0],
        &[4.0, 2.0, 8.0],
        zero,
    ];
    let cubic = moved("translation", "CUBICSPLINE", "VEC3", &cubic);
    assert_eq!(
        corner_at(&cubic, &[1.0, 2.0, 3.0]),
        [[1.0, 2.0, 0.0], [2.0, 4.0, 4.0], [5.0, 2.0, 8.0]]
    );
}

/// A keyframe for 2.7 seconds is stored as 2.700000047.
#[test]
fn a_keyframe_counts_from_its_own_time_on() {
    for (key, before) in [(2.7_f32, 2.699_999), (0.04 * 3.0, 0.119_999)] {
        let file = strip(|file| {
            file.floats(2, "SCALAR", &[0.0, key]);
            file.floats(2, "VEC3", &[0.0, 0.0, 0.0, 4.0, 0.0, 0.0]);
        });
        let json = file.finish(
            r#""nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":5}]}],
            "animations":[{"channels":[{"sampler":0,"target":{"node":0,"path":"translation"}}],
            "samplers":[{"input":6,"output":7,"interpolation":"STEP"}]}]"#,
        );
        let time = format!("{key}").parse().expect("a number");
        assert_eq!(
            corner_at(&json, &[before, time]),
            [[1.0, 0.0, 0.0], [5.0, 0.0, 0.0]]
        );
    }
}

#[test]
fn rotations_turn_the_shorter_way_and_scales_grow() {
    let half = std::f32::consts::FRAC_1_SQRT_2;
    // The negative of a quarter turn about z, which is the same rotation.
    let turn = moved(
        "rotation",
        "LINEAR",
        "VEC4",
        &[&[0.0, 0.0, 0.0, 1.0], &[0.0, 0.0, -half, -half]],
    );
    // A third of the way, 30 degrees; what the animation does not name stays: the translation.
    let third = 1.0 + 2.0 / 3.0;
    let (sin, cos) = (0.5, 0.866_03);
    assert_eq!(
        corner_at(&turn, &[1.0, third, 3.0]),
        [[11.0, 0.0, 0.0], [10.0 + cos, sin, 0.0], [10.0, 1.0, 0.0]]
    );
    let grow = moved("scale", "LINEAR", "VEC3", &[&[1.0, 1.0, 1.0], &[3.0, 1.0, 1.0]]);
    assert_eq!(corner_at(&grow, &[2.0]), [[12.0, 0.0, 0.0]]);
    // Zeros are no rotation.
    let none = moved("rotation", "LINEAR", "VEC4", &[&[0.0; 4], &[0.0; 4]]);
    assert_eq!(corner_at(&none, &[2.0]), [[11.0, 0.0, 0.0]]);
}

/// The second joint turns back, so the strip is straight.
#[test]
fn joints_move_skins() {
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let file = strip(|file| {
        file.floats(2, "SCALAR", &TIMES);
        file.floats(2, "VEC4", &[0.0, 0.0, half, half, 0.0, 0.0, 0.0, 1.0]);
    });
    let json = file.finish(&format!(
        r#"{BENT},"animations":[{{"channels":[{{"sampler":0,"target":{{"node":2,"path":"rotation"}}}}],
        "samplers":[{{"input":6,"output":7}}]}}]"#
    ));
    let top = |seconds| points(&posed(&json, None, seconds).expect("a mesh"))[4..].to_vec();
    assert_eq!(top(0.0), [[9.0, 1.0, 0.0], [9.0, 2.0, 0.0]]);
    assert_eq!(top(3.0), [[10.0, 2.0, 0.0], [11.0, 2.0, 0.0]]);
}

#[test]
fn weights_of_morph_targets_change() {
    let file = strip(|file| {
        file.floats(2, "SCALAR", &TIMES);
        file.floats(4, "SCALAR", &[1.0, 0.0, 0.0, 1.0]);
        file.floats(6, "VEC3", &[0.0, 0.0, 4.0].repeat(6));
        file.floats(6, "VEC3", &[2.0, 0.0, 0.0].repeat(6));
    });
    let json = file.finish(
        r#""nodes":[{"mesh":0},{"mesh":0,"translation":[0,0,50]}],"meshes":[{"weights":[0.5,0.5],"primitives":[
        {"attributes":{"POSITION":0},"indices":5,"targets":[{"POSITION":8},{"POSITION":9}]}]}],
        "animations":[{"channels":[{"sampler":0,"target":{"node":0,"path":"weights"}}],"samplers":[{"input":6,"output":7}]}]"#,
    );
    let at = |seconds| points(&posed(&json, None, seconds).expect("a mesh"));
    assert_eq!(
        [at(1.0)[0], at(1.5)[0], at(3.0)[0]],
        [[0.0, 0.0, 4.0], [0.5, 0.0, 3.0], [2.0, 0.0, 0.0]]
    );
    // The other node has the weights of the mesh.
    assert_eq!(at(1.0)[6], [1.0, 0.0, 52.0]);
}

#[test]
fn animations_are_chosen_by_name_or_number() {
    let json = moved("translation", "STEP", "VEC3", &[&[0.0; 3], &[0.0; 3]]);
    for chosen in ["go", "1"] {
        let mesh = posed(&json, Some(chosen), 0.0).expect("a mesh");
        assert!(mesh.notes.is_empty(), "{:?}", mesh.notes);
    }
    for unknown in ["2", "0", "Go"] {
        assert_eq!(
            posed(&json, Some(unknown), 0.0).expect_err("unknown"),
            format!("there is no animation `{unknown}`, expected `go`")
        );
    }
    let without = strip(|_| {}).finish(BENT);
    assert_eq!(
        posed(&without, None, 0.0).expect_err("none"),
        "there is no animation in the file"
    );
}

/// Tangents before the first keyframe of a spline and after its last one; keyframes after the time.
#[test]
fn what_does_not_count_may_be_nan() {
    let nan = &[f32::NAN; 3][..];
    let [one, two] = [&[1.0; 3][..], &[2.0; 3][..]];
    let zero = &[0.0; 3][..];
    let cubic = moved(
        "translation",
        "CUBICSPLINE",
        "VEC3",
        &[nan, one, zero, zero, two, nan],
    );
    assert_eq!(
        corner_at(&cubic, &[0.0, 1.0, 3.0]),
        [[2.0, 1.0, 1.0], [2.0, 1.0, 1.0], [3.0, 2.0, 2.0]]
    );
    let linear = moved("translation", "LINEAR", "VEC3", &[one, nan]);
    assert_eq!(corner_at(&linear, &[1.0]), [[2.0, 1.0, 1.0]]);
    for seconds in [2.0, 3.0] {
        assert_eq!(
            posed(&linear, None, seconds).expect_err("NaN"),
            format!("animations[0].channels[0]: its value at {seconds} seconds is not finite")
        );
    }
}

/// Sparse accessors without a view have as many zeros as they say.
#[test]
fn counts_without_bytes() {
    let zeros = |index: usize, count: usize, kind: &str| {
        format!(
            r#"{{"count":{count},"componentType":5126,"type":"{kind}","sparse":{{"count":1,
            "indices":{{"bufferView":{index},"componentType":5121}},"values":{{"bufferView":{index}}}}}}}"#
        )
    };
    let mut file = File::default();
    file.floats(3, "VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    let json = |times: usize, values: usize, path: &str, kind: &str, interpolation: &str| {
        let json = file.finish(&format!(
            r#""nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},
            "targets":[{{"POSITION":0}},{{"POSITION":0}}]}}]}}],"animations":[{{"channels":[{{"sampler":0,
            "target":{{"node":0,"path":"{path}"}}}}],"samplers":[{{"input":1,"output":2,"interpolation":"{interpolation}"}}]}}]"#
        ));
        let more = [zeros(0, times, "SCALAR"), zeros(0, values, kind)].join(",");
        json.replace("],\"bufferViews\"", &format!(",{more}],\"bufferViews\""))
    };
    let place = "animations[0].channels[0]";
    let most = usize::MAX;
    let fault = posed(
        &json(1 << 63, most, "translation", "VEC3", "CUBICSPLINE"),
        None,
        0.0,
    );
    assert_eq!(
        fault.expect_err("too few"),
        format!(
            "{place}: {most} values for {} keyframes, expected three for each",
            1_u64 << 63
        )
    );
    let none = moved("weights", "LINEAR", "SCALAR", &[]);
    assert_eq!(
        posed(&none, None, 0.0).expect_err("none"),
        format!("{place}: 0 values for 2 keyframes, expected one of each weight for each")
    );
    // The mesh has two targets.
    assert!(posed(&json(1, 1 << 40, "weights", "SCALAR", "LINEAR"), None, 0.0).is_ok());
}

#[test]
fn faults_of_animations() {
    let json = moved("translation", "LINEAR", "VEC3", &[&[0.0; 3], &[0.0; 3]]);
    let place = "animations[0].channels[0]";
    let missing = format!("{place} names a sampler or a node that the file does not have");
    for (from, to, expected) in [
        (r#""sampler":0"#, r#""sampler":7"#, missing.clone()),
        (r#""node":1"#, r#""node":9"#, missing),
        (
            r#""output":7"#,
            r#""output":70"#,
            format!("{place} names an accessor that the file does not have"),
        ),
        (
            r#""output":7"#,
            r#""output":6"#,
            "accessors[6] holds other elements, expected vectors of 3 numbers".to_owned(),
        ),
        (
            r#""input":6"#,
            r#""input":0"#,
            "accessors[0] holds other elements, expected times (floats)".to_owned(),
        ),
        (
            r#""LINEAR""#,
            r#""CUBICSPLINE""#,
            format!("{place}: 2 values for 2 keyframes, expected three for each"),
        ),
    ] {
        assert_eq!(posed(&json.replace(from, to), None, 0.0).expect_err(to), expected);
    }
    // What octray does not know is left alone; such channels may have no node.
    let unknown = json.replace(r#""path":"translation""#, r#""path":"pointer""#);
    assert_eq!(corner_at(&unknown, &[2.0]), [[11.0, 0.0, 0.0]]);
    let nowhere = unknown.replace(r#""node":1,"#, "");
    assert_eq!(corner_at(&nowhere, &[2.0]), [[11.0, 0.0, 0.0]]);
    // Times that do not ascend are no reason to fail.
    let odd = strip(|file| {
        file.floats(3, "SCALAR", &[f32::NAN, 5.0, -1.0]);
        file.floats(3, "VEC3", &[1.0; 9]);
    });
    let body = r#""nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":5}]}],
        "animations":[{"channels":[{"sampler":0,"target":{"node":0,"path":"translation"}}],"samplers":[{"input":6,"output":7}]}]"#;
    let odd = odd.finish(body);
    for seconds in [0.0, 5.0, 6.0] {
        assert_eq!(corner_at(&odd, &[seconds]), [[2.0, 1.0, 1.0]]);
    }
}

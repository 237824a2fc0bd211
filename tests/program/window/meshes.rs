//! Meshes in the window.

use super::{BELOW_MESSAGE, Screen, Viewer, difference, keep, wait_for};
use crate::long::is_long;

/// As wide as messages need, and low: soft light takes long without optimisation.
const SIZE: [u32; 2] = [200, 80];

/// In each style, and with options of its own, the picture at rest is what the printed command makes, and what is saved.
/// `OCTRAY_LONG=1` adds 64 samples by brute force.
pub fn look_as_render_makes_them(screen: &Screen) {
    for (options, samples) in [
        (&[][..], "up to 64 samples - done"),
        (
            &["--style=clay", "--samples=auto", "--linear"],
            "up to 16 samples - done",
        ),
        (
            &["--style=plain", "--samples=3", "--srgb", "--edges=2"],
            "3 samples - done",
        ),
        (
            &[
                "--samples=16",
                "--pattern=stratified",
                "--filter=box",
                "--no-shadows",
            ],
            "16 samples - done",
        ),
    ] {
        let options = [&["--ground"], options].concat();
        let mut viewer = Viewer::open_file(screen, "t.ply", &triangle("1"), SIZE, &options);
        viewer.drag(1, [60, 60], [100, 70]);
        let line = viewer.camera_options();
        let printed: Vec<&str> = line.split_whitespace().collect();
        viewer.wait_for_title(samples);
        let expected = viewer.render(&printed);
        viewer.wait_for_picture(&line, &expected, BELOW_MESSAGE);
        keep(&viewer.shot(), &format!("mesh-{}", options.len()));
        viewer.key("s");
        viewer.wait_for_file("t-1.png");
        assert_eq!(difference(&viewer.picture("t-1.png"), &expected, 0), 0, "{line}");
        if is_long() || !samples.contains("64") {
            // Brute force takes all samples everywhere, and says so.
            viewer.key("b");
            let line = viewer.camera_options();
            let printed: Vec<&str> = line.split_whitespace().collect();
            viewer.wait_for_title(samples.trim_start_matches("up to "));
            viewer.wait_for_picture(&line, &viewer.render(&printed), BELOW_MESSAGE);
        }
        viewer.quit("q");
    }
    // A mesh that has lights of its own keeps them.
    let mut viewer = Viewer::open_file(screen, "t.gltf", LIT, SIZE, &["--samples=auto"]);
    viewer.drag(1, [60, 60], [100, 70]);
    let line = viewer.camera_options();
    assert!(!line.contains("--lit-from"), "{line}");
    let printed: Vec<&str> = line.split_whitespace().collect();
    viewer.wait_for_picture(&line, &viewer.render(&printed), BELOW_MESSAGE);
    viewer.quit("q");
    // Nothing but the number of samples and the camera differs from render without options.
    let mut viewer = Viewer::open_file(screen, "t.ply", &triangle("1"), SIZE, &["--samples=auto"]);
    viewer.wait_for_title("up to 16 samples - done");
    viewer.wait_for_picture("no options", &viewer.render(&[]), 0);
    viewer.key("e");
    let line = viewer.camera_options();
    assert!(line.contains(" --edges=1"), "{line}");
    let printed: Vec<&str> = line.split_whitespace().collect();
    viewer.wait_for_picture(&line, &viewer.render(&printed), BELOW_MESSAGE);
    viewer.quit("q");
}

/// Every side and every turn is what render makes of the printed options.
pub fn have_six_sides_and_turn(screen: &Screen) {
    let mut viewer = Viewer::open_file(screen, "t.ply", &triangle("1"), SIZE, &["--ground"]);
    viewer.key("a");
    let start = viewer.camera_options();
    let mut seen = vec![start.clone()];
    let mut check = |viewer: &Viewer, what: &str| {
        let line = viewer.camera_options();
        assert!(!seen.contains(&line), "{what}: {line}");
        let options: Vec<&str> = line.split_whitespace().collect();
        viewer.wait_for_picture(what, &viewer.render(&options), BELOW_MESSAGE);
        seen.push(line);
    };
    for side in 1..=6 {
        viewer.key(&side.to_string());
        check(&viewer, &format!("side {side}"));
    }
    let up = |line: &str| {
        line.split_whitespace()
            .find(|word| word.starts_with("--up="))
            .map(str::to_owned)
    };
    viewer.key("u");
    wait_for("another up axis", || {
        let line = viewer.camera_options();
        if up(&line) == up(&start) {
            Err(line)
        } else {
            Ok(())
        }
    });
    check(&viewer, "turned");
    viewer.key("Home");
    check(&viewer, "the starting camera, turned");
    // A camera that stands there follows the file.
    let before = viewer.camera_options();
    viewer.write("t.ply", &triangle("5"));
    wait_for("another camera", || match viewer.camera_options() {
        line if line == before => Err(line),
        _ => Ok(()),
    });
    check(&viewer, "the starting camera of another file, turned");
    viewer.quit("q");
}

/// A triangle in the light of a lamp.
const LIT: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1]}],
    "extensionsUsed":["KHR_lights_punctual"],
    "extensions":{"KHR_lights_punctual":{"lights":[{"type":"point","color":[1,0.5,0.2],"intensity":9}]}},
    "nodes":[{"mesh":0},{"translation":[1,2,3],"extensions":{"KHR_lights_punctual":{"light":0}}}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[-2,-2,0],"max":[2,2,0]}],
    "bufferViews":[{"buffer":0,"byteLength":36}],
    "buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAwAAAAMAAAAAAAAAAQAAAAMAAAAAAAAAAAAAAAEAAAAAA"}]}"#;

/// A mesh of one triangle at this height.
pub fn triangle(z: &str) -> String {
    format!(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
         element face 1\nproperty list uchar int vertex_indices\nend_header\n-2 -2 {z}\n2 -2 {z}\n0 2 {z}\n3 0 1 2\n"
    )
}

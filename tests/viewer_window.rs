//! The live window under a display of its own (Xvfb), with keys and mouse from xdotool: what the screen shows is
//! compared with what `octray render` makes of the same camera. Skipped where one of the two is missing.
#![cfg(target_os = "linux")]

mod program;
mod window;

use std::time::Duration;
use window::{Screen, Viewer, difference, idle_ticks, keep, wait_for_messages_to_go};

const SIZE: [u32; 2] = [200, 150];

/// All of it on one display, one window after the other: pointer and focus are shared.
#[test]
fn the_window_does_what_its_keys_say() {
    if std::env::var_os("OCTRAY_WINDOW").is_none() {
        println!("skipped: set OCTRAY_WINDOW=1 to try the window; on a busy machine its waits can run out");
        return;
    }
    let Some(screen) = Screen::start() else { return };
    at_rest_it_is_what_render_makes(&screen);
    every_key_does_something(&screen);
    mouse_and_flight_move_the_camera(&screen);
    the_window_resizes(&screen);
    changed_files_are_loaded(&screen);
    at_rest_it_uses_no_cpu(&screen);
    it_ends_at_once(&screen);
    benchmarks_are_reported(&screen);
}

fn at_rest_it_is_what_render_makes(screen: &Screen) {
    let mut viewer = Viewer::open(screen, SIZE, &["--view", "3"]);
    viewer.wait_for_title("64 samples - done");
    assert_eq!(
        difference(&viewer.shot(), &viewer.render(&["--view=3", "--samples=64"])),
        0
    );
    viewer.key("a");
    viewer.wait_for_title("1 sample - done");
    wait_for_messages_to_go();
    assert_eq!(difference(&viewer.shot(), &viewer.render(&["--view=3"])), 0);
    for (key, view) in [("1", 1), ("2", 2), ("4", 4), ("5", 5), ("6", 6)] {
        viewer.key(key);
        viewer.settle();
        let expected = viewer.render(&[&format!("--view={view}")]);
        assert_eq!(difference(&viewer.shot(), &expected), 0, "viewpoint {view}");
    }
    viewer.quit("q");
    // Without shadows, scalar, another depth: as render has it.
    let options = ["--view=1", "--no-shadows", "--max-depth=1", "--mode=scalar"];
    let mut viewer = Viewer::open(screen, SIZE, &options);
    viewer.wait_for_title("64 samples - done");
    let expected = viewer.render(&["--view=1", "--no-shadows", "--max-depth=1", "--samples=64"]);
    assert_eq!(difference(&viewer.shot(), &expected), 0);
    viewer.quit("Escape");
}

fn every_key_does_something(screen: &Screen) {
    let mut viewer = Viewer::open(screen, SIZE, &["--view=1"]);
    viewer.key("a");
    viewer.settle();
    wait_for_messages_to_go();
    let plain = viewer.shot();
    let all = viewer.pixels();
    // Each of these changes the picture, and pressed again gives the old one back.
    for (key, least) in [
        ("r", 0.01),
        ("n", 0.01),
        ("h", 0.1),
        ("B", 0.005),
        ("question", 0.05),
        ("i", 0.03),
        ("m", 0.03),
    ] {
        viewer.move_mouse(100, 75);
        viewer.key(key);
        viewer.settle();
        let shown = viewer.shot();
        keep(&shown, key);
        let changed = difference(&shown, &plain) as f64 / all;
        assert!(changed > least, "{key}: {changed}");
        viewer.key(key);
        viewer.settle();
        wait_for_messages_to_go();
        assert_eq!(difference(&viewer.shot(), &plain), 0, "{key} twice");
    }
    // Levels of the hierarchy.
    viewer.key("bracketright");
    viewer.settle();
    let level = viewer.shot();
    keep(&level, "level");
    assert!(difference(&level, &plain) > 0);
    viewer.key("bracketleft");
    // Brute force shows the same.
    viewer.key("b");
    viewer.settle();
    wait_for_messages_to_go();
    assert_eq!(difference(&viewer.shot(), &plain), 0, "brute force");
    viewer.key("b");
    // Single rays, with figures on the screen.
    viewer.key("p");
    viewer.settle();
    keep(&viewer.shot(), "p");
    viewer.key("i");
    viewer.settle();
    wait_for_messages_to_go();
    assert_eq!(difference(&viewer.shot(), &plain), 0, "single rays");
    // The object fills the picture.
    viewer.key("f");
    viewer.settle();
    let framed = viewer.shot();
    keep(&framed, "f");
    assert!(difference(&framed, &plain) > 0);
    // Saved twice, under two names, as it is shown.
    viewer.key("s");
    viewer.key("s");
    viewer.wait_for_file("a-1.png");
    viewer.wait_for_file("a-2.png");
    assert_eq!(difference(&viewer.picture("a-1.png"), &framed), 0);
    assert_eq!(difference(&viewer.picture("a-2.png"), &framed), 0);
    // The camera as printed renders the same picture.
    viewer.key("c");
    let line = viewer.next_line();
    let options: Vec<&str> = line
        .strip_prefix("octray render a.scn ")
        .expect(&line)
        .split_whitespace()
        .collect();
    assert_eq!(difference(&viewer.render(&options), &framed), 0, "{line}");
    viewer.quit("q");
}

fn mouse_and_flight_move_the_camera(screen: &Screen) {
    let mut viewer = Viewer::open(screen, SIZE, &["--view=1"]);
    viewer.key("a");
    viewer.settle();
    let eye = |viewer: &mut Viewer| {
        viewer.key("c");
        let line = viewer.next_line();
        let (_, rest) = line.split_once("--eye=").expect(&line);
        let (eye, _) = rest.split_once(' ').expect(&line);
        let eye: Vec<f64> = eye
            .split(',')
            .map(|number| number.parse().expect(&line))
            .collect();
        [eye[0], eye[1], eye[2] - 0.5]
    };
    let azimuth = |[x, y, _]: [f64; 3]| y.atan2(x).to_degrees();
    let distance = |v: [f64; 3]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    let before = eye(&mut viewer);
    viewer.drag(1, [60, 60], [100, 60]);
    let after = eye(&mut viewer);
    assert!(
        (azimuth(after) - azimuth(before) + 10.0).abs() < 1e-6,
        "{before:?} {after:?}"
    );
    assert!((distance(after) - distance(before)).abs() < 1e-9);
    viewer.drag(3, [60, 60], [60, 40]);
    assert!(distance(eye(&mut viewer)) < distance(after) - 0.3);
    viewer.click(5);
    viewer.click(5);
    viewer.click(5);
    viewer.click(5);
    assert!(distance(eye(&mut viewer)) > distance(after));
    viewer.settle();
    wait_for_messages_to_go();
    let line = viewer.camera_options();
    let options: Vec<&str> = line.split_whitespace().collect();
    viewer.settle();
    wait_for_messages_to_go();
    assert_eq!(difference(&viewer.shot(), &viewer.render(&options)), 0);
    for key in ["Up", "Down", "Left", "Right", "Prior", "Next"] {
        let before = eye(&mut viewer);
        viewer.key(key);
        let after = eye(&mut viewer);
        assert!(before != after, "{key}");
    }
    viewer.quit("q");
}

fn the_window_resizes(screen: &Screen) {
    let mut viewer = Viewer::open(screen, SIZE, &["--view=1"]);
    viewer.key("a");
    viewer.settle();
    for size in [[333, 217], [64, 300], [500, 400]] {
        viewer.resize(size);
        viewer.wait_for_title(&format!("{}x{} - 1 sample - done", size[0], size[1]));
        wait_for_messages_to_go();
        assert_eq!(
            difference(&viewer.shot(), &viewer.render(&["--view=1"])),
            0,
            "{size:?}"
        );
    }
    viewer.quit("q");
}

fn changed_files_are_loaded(screen: &Screen) {
    let mut viewer = Viewer::open(screen, SIZE, &["--view=1"]);
    viewer.key("a");
    viewer.settle();
    wait_for_messages_to_go();
    let before = viewer.shot();
    let scene = "light 3 -2 5 0.7\nmaterial 2\nsphere 0 0 0.5 0.9\n";
    viewer.write("a.scn", "light 3 -2 5 0.7\nmaterial 2\nsphere 0 0 0.5 wide\n");
    viewer.wait_for_change(&before);
    let broken = viewer.shot();
    keep(&broken, "error");
    // The last good picture stays below the message.
    let lower =
        |picture: &image::RgbImage| image::imageops::crop_imm(picture, 0, 120, SIZE[0], 30).to_image();
    assert_eq!(difference(&lower(&broken), &lower(&before)), 0);
    viewer.write("a.scn", scene);
    viewer.wait_for_change(&broken);
    viewer.settle();
    wait_for_messages_to_go();
    let reloaded = viewer.shot();
    assert_eq!(difference(&reloaded, &viewer.render(&["--view=1"])), 0);
    // A mesh that the scene names from now on is watched as well.
    let triangle = |z: &str| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
             element face 1\nproperty list uchar int vertex_indices\nend_header\n-2 -2 {z}\n2 -2 {z}\n0 2 {z}\n3 0 1 2\n"
        )
    };
    viewer.write("meshes/t.ply", &triangle("0"));
    viewer.write("a.scn", &format!("{scene}ply_file meshes/t.ply\n"));
    viewer.wait_for_change(&reloaded);
    viewer.settle();
    wait_for_messages_to_go();
    let with_mesh = viewer.shot();
    viewer.write("meshes/t.ply", &triangle("1"));
    viewer.wait_for_change(&with_mesh);
    viewer.settle();
    wait_for_messages_to_go();
    assert_eq!(difference(&viewer.shot(), &viewer.render(&["--view=1"])), 0);
    viewer.quit("q");
}

fn at_rest_it_uses_no_cpu(screen: &Screen) {
    let mut viewer = Viewer::open(screen, SIZE, &[]);
    viewer.wait_for_title("64 samples - done");
    std::thread::sleep(Duration::from_millis(300));
    // A tick is 10 ms: less than 1 % of three seconds.
    let ticks = idle_ticks(viewer.pid(), Duration::from_secs(3));
    assert!(ticks <= 2, "{ticks} ticks of CPU time in 3 s at rest");
    viewer.quit("q");
}

fn it_ends_at_once(screen: &Screen) {
    // While brute force traces a picture that takes minutes.
    let mut viewer = Viewer::open(screen, [600, 500], &[]);
    let mut many = String::from("light 3 -2 5 0.7\nmaterial 3\n");
    for i in 0..20_000 {
        many += &format!(
            "sphere {} {} 0.5 0.01\n",
            f64::from(i % 141) / 70.0 - 1.0,
            f64::from(i / 141) / 70.0 - 1.0
        );
    }
    viewer.settle();
    let before = viewer.shot();
    viewer.write("a.scn", &many);
    viewer.wait_for_change(&before);
    viewer.key("b");
    std::thread::sleep(Duration::from_millis(500));
    viewer.quit("q");
    // Closed as a window manager closes it, while it traces.
    let mut viewer = Viewer::open(screen, [600, 500], &[]);
    viewer.close();
}

fn benchmarks_are_reported(screen: &Screen) {
    let folder = program::Folder::new();
    let run = screen.run(
        &folder,
        &["view", "a.scn", "--size=64x64", "--benchmark=0.5", "--json=-"],
    );
    run.succeeded();
    for field in [
        "\"schema\":1",
        "fps",
        "frame_ms_p50",
        "frame_ms_p99",
        "full_quality_share",
        "mrays_per_s",
    ] {
        assert!(run.text().contains(field), "{}", run.text());
    }
    let no_display = program::Run::new(
        folder
            .command(&["view", "a.scn"])
            .env_remove("DISPLAY")
            .env_remove("WAYLAND_DISPLAY")
            .env_remove("WAYLAND_SOCKET")
            .output()
            .unwrap(),
    );
    no_display.failed(3, "there is no display");
}

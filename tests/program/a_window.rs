//! The live window on a virtual display (Xvfb), driven by xdotool. The screen must show what `octray render` makes with the
//! same camera. Skipped if Xvfb or xdotool is missing.
//!
//! Tests wait for a result, for a minute at most, and not for a fixed time.
#![cfg(target_os = "linux")]

use crate::signals;
use crate::window::{
    BELOW_MESSAGE, SIZE, Screen, Viewer, cameras, difference, idle_ticks, keep, loading,
    meshes::{self, triangle},
    moving, wait_for,
};
use std::{thread, time::Duration};

/// One window after the other on each of six displays: those of one share pointer and focus. All wait most of the time, and
/// none of the displays much longer than the others.
#[test]
fn the_window_does_what_its_keys_say() {
    let displays: [&[fn(&Screen)]; 6] = [
        &[at_rest_it_is_what_render_makes, every_key_does_something],
        &[
            mouse_and_flight_move_the_camera,
            a_notch_is_small_on_a_large_floor,
            the_window_resizes,
            fast_input_breaks_nothing,
            changed_files_are_loaded,
        ],
        &[
            cameras::have_lenses_and_parallel_rays,
            at_rest_it_uses_no_cpu,
            signals_end_it,
            benchmarks_are_reported,
        ],
        &[meshes::look_as_render_makes_them, meshes::have_six_sides_and_turn],
        &[
            moving::play_and_step,
            moving::step_past_a_frame,
            moving::play_a_mesh,
            loading::takes_the_last_change,
        ],
        &[it_ends_at_once, loading::is_shown],
    ];
    thread::scope(|scope| {
        for tests in displays {
            scope.spawn(move || {
                let Some(screen) = Screen::start() else { return };
                for test in tests {
                    test(&screen);
                }
            });
        }
    });
}

fn at_rest_it_is_what_render_makes(screen: &Screen) {
    let mut viewer = Viewer::open(screen, SIZE, &["--view=3"]);
    viewer.wait_for_title("64 samples - done");
    let expected = viewer.render(&["--view=3", "--samples=64"]);
    viewer.wait_for_picture("64 samples", &expected, 0);
    viewer.key("a");
    viewer.wait_for_picture("one sample", &viewer.render(&["--view=3"]), BELOW_MESSAGE);
    for view in [1, 2, 4, 5, 6] {
        viewer.key(&view.to_string());
        let expected = viewer.render(&[&format!("--view={view}")]);
        viewer.wait_for_picture(&format!("viewpoint {view}"), &expected, BELOW_MESSAGE);
    }
    viewer.wait_for_title("1 sample - done");
    viewer.quit("q");
    // The options of render apply.
    let options = ["--view=1", "--no-shadows", "--max-depth=1", "--mode=scalar"];
    let mut viewer = Viewer::open(screen, SIZE, &options);
    let expected = viewer.render(&["--view=1", "--no-shadows", "--max-depth=1", "--samples=64"]);
    viewer.wait_for_picture("options", &expected, 0);
    viewer.quit("Escape");
}

fn every_key_does_something(screen: &Screen) {
    let mut viewer = Viewer::open(screen, SIZE, &["--view=1"]);
    let plain = viewer.render(&["--view=1"]);
    let back = |viewer: &Viewer, what: &str| {
        viewer.wait_for_picture(what, &plain, BELOW_MESSAGE);
    };
    viewer.move_mouse([100, 75]);
    viewer.key("a");
    back(&viewer, "anti-aliasing off");
    // Each of these changes the picture; pressed again, it restores the old one.
    for (key, least) in [
        ("r", 0.01),
        ("n", 0.1),
        ("h", 0.1),
        ("e", 0.005),
        ("B", 0.005),
        ("question", 0.05),
        ("i", 0.03),
        ("m", 0.03),
    ] {
        viewer.key(key);
        keep(&viewer.wait_for_change(key, &plain, least), key);
        viewer.key(key);
        back(&viewer, key);
    }
    // Two of them are also layers of render, and the printed command makes them.
    for (key, aov) in [("n", "normal"), ("h", "heat")] {
        viewer.key(key);
        let line = viewer.camera_options();
        assert!(line.contains(&format!(" --aov={aov}")), "{line}");
        viewer.render(&line.split_whitespace().collect::<Vec<_>>());
        let expected = viewer.picture(&format!("expected.{aov}.png"));
        viewer.wait_for_picture(aov, &expected, 2 * BELOW_MESSAGE);
        viewer.key(key);
    }
    // Levels of the hierarchy.
    back(&viewer, "before levels");
    viewer.key("bracketright");
    wait_for("boxes", || {
        match difference(&viewer.shot(), &plain, BELOW_MESSAGE) {
            0 => Err("none".into()),
            _ => Ok(()),
        }
    });
    keep(&viewer.shot(), "level");
    viewer.key("bracketleft");
    back(&viewer, "no boxes");
    // Brute force and single rays show the same picture; the latter with figures over it.
    viewer.key("b");
    viewer.wait_for_title("1 sample - done");
    back(&viewer, "brute force");
    viewer.key("b");
    viewer.key("p");
    keep(&viewer.wait_for_change("p", &plain, 0.03), "p");
    viewer.key("i");
    // Waits until the last message has gone.
    viewer.wait_for_picture("single rays", &plain, 0);
    // A key that was pressed in another window and is still held does nothing here.
    viewer.set_focus(false);
    viewer.key_down("n");
    viewer.set_focus(true);
    viewer.camera_options();
    viewer.key_up("n");
    viewer.wait_for_picture("a key of another window", &plain, BELOW_MESSAGE);
    // The object under the mouse is framed. The printed camera renders the same.
    viewer.key("f");
    keep(&viewer.wait_for_change("f", &plain, 0.01), "f");
    let line = viewer.camera_options();
    let options: Vec<&str> = line.split_whitespace().collect();
    let framed = viewer.render(&options);
    assert!(difference(&framed, &plain, 0) > 0);
    viewer.wait_for_picture(&line, &framed, BELOW_MESSAGE);
    // Saved twice, under two names.
    viewer.key("s");
    viewer.key("s");
    for name in ["a-1.png", "a-2.png"] {
        viewer.wait_for_file(name);
        assert_eq!(difference(&viewer.picture(name), &framed, 0), 0);
    }
    viewer.key("Home");
    back(&viewer, "the starting camera");
    viewer.quit("q");
}

fn mouse_and_flight_move_the_camera(screen: &Screen) {
    let mut viewer = Viewer::open(screen, SIZE, &["--view=1"]);
    viewer.key("a");
    let eye = |viewer: &Viewer| {
        let line = viewer.camera_options();
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
    let before = eye(&viewer);
    viewer.drag(1, [60, 60], [100, 60]);
    let after = eye(&viewer);
    assert!(
        (azimuth(after) - azimuth(before) + 10.0).abs() < 1e-6,
        "{before:?} {after:?}"
    );
    assert!((distance(after) - distance(before)).abs() < 1e-9);
    viewer.drag(3, [60, 60], [60, 40]);
    assert!(distance(eye(&viewer)) < distance(after) - 0.3);
    viewer.click(5, 4);
    assert!(distance(eye(&viewer)) > distance(after));
    let line = viewer.camera_options();
    let options: Vec<&str> = line.split_whitespace().collect();
    viewer.wait_for_picture(&line, &viewer.render(&options), BELOW_MESSAGE);
    for key in ["Up", "Down", "Left", "Right", "Prior", "Next"] {
        let before = eye(&viewer);
        viewer.key(key);
        let after = eye(&viewer);
        assert!(before != after, "{key}");
    }
    // A held key flies on until it is released.
    viewer.key_down("Up");
    for _ in 0..3 {
        let before = eye(&viewer);
        wait_for("flight", || {
            if eye(&viewer) == before {
                Err("no move".into())
            } else {
                Ok(())
            }
        });
    }
    viewer.key_up("Up");
    let stands = eye(&viewer);
    thread::sleep(Duration::from_millis(100));
    assert_eq!(eye(&viewer), stands);
    viewer.quit("q");
    // A mesh keeps its first light, and the printed options have it.
    let mesh = triangle("1");
    let mut viewer = Viewer::open_file(screen, "t.ply", &mesh, SIZE, &["--ground", "--smooth-angle=30"]);
    viewer.key("a");
    viewer.drag(1, [60, 60], [100, 70]);
    let line = viewer.camera_options();
    let options: Vec<&str> = line.split_whitespace().collect();
    viewer.wait_for_picture(&line, &viewer.render(&options), BELOW_MESSAGE);
    viewer.quit("q");
}

/// A notch changes the distance by the same small factor, however large the floor is.
fn a_notch_is_small_on_a_large_floor(screen: &Screen) {
    let scene = "light 3 -2 5 0.7\nmaterial 1\nsphere 0 0 0.5 0.5\n\
                 triangle -2000 -2000 0  2000 -2000 0  0 2000 0\n";
    let mut viewer = Viewer::open_file(screen, "floor.scn", scene, SIZE, &["--eye=7,0,0.5"]);
    let x = |viewer: &Viewer| {
        let line = viewer.camera_options();
        let (_, rest) = line.split_once("--eye=").expect(&line);
        rest.split(',').next().unwrap().parse::<f64>().expect(&line)
    };
    viewer.move_mouse([100, 75]);
    viewer.click(4, 1);
    // winit reports press and release of xdotool's wheel as a notch each.
    let factor = 7.0 / x(&viewer);
    assert!(
        [1.1, 1.21].iter().any(|notch| (factor - notch).abs() < 1e-9),
        "{factor}"
    );
    for expected in [7.0, 7.0 * factor] {
        viewer.click(5, 1);
        let found = x(&viewer);
        assert!((found - expected).abs() < 1e-9, "{found}, not {expected}");
    }
    // The sphere under the mouse, not the floor.
    viewer.key("f");
    assert!(x(&viewer) < 3.0);
    viewer.quit("q");
}

fn the_window_resizes(screen: &Screen) {
    let mut viewer = Viewer::open(screen, SIZE, &["--view=1"]);
    viewer.key("a");
    for size in [[333, 217], [64, 300], [1, 1], [500, 400]] {
        viewer.resize(size);
        viewer.wait_for_title(&format!("{}x{} - 1 sample - done", size[0], size[1]));
        // The message wraps where the window is narrow.
        let top = if size[0] < 100 { size[1] / 2 } else { BELOW_MESSAGE };
        viewer.wait_for_picture(&format!("{size:?}"), &viewer.render(&["--view=1"]), top);
    }
    viewer.quit("q");
}

fn fast_input_breaks_nothing(screen: &Screen) {
    let mut viewer = Viewer::open(screen, SIZE, &["--view=1"]);
    // The size changes during a drag.
    viewer.move_mouse([20, 20]);
    viewer.button(1, true);
    for size in [[1, 1], [300, 1], [1, 300], [2, 3], [400, 300]] {
        viewer.resize(size);
        viewer.move_mouse([size[0] / 2, size[1] / 2]);
    }
    viewer.button(1, false);
    // Every key that toggles something, an even number of times.
    let toggles = [
        "r", "n", "h", "a", "b", "B", "m", "i", "question", "f", "2", "5", "u", "Home", "c",
    ];
    let again = ["r", "n", "h", "a", "b", "B", "m", "i", "question"];
    viewer.keys(&toggles);
    viewer.keys(&again);
    viewer.keys(&["n", "n", "h", "h", "r", "r", "a"]);
    viewer.resize(SIZE);
    viewer.key("3");
    viewer.wait_for_picture("after fast input", &viewer.render(&["--view=3"]), 0);
    viewer.quit("q");
    // A mesh that is a single point: nothing to frame.
    let point = triangle("0").replace("-2 -2 0\n2 -2 0\n0 2 0", "0 0 0\n0 0 0\n0 0 0");
    let mut viewer = Viewer::open_file(screen, "t.ply", &point, SIZE, &["--view=1"]);
    viewer.keys(&[
        "a",
        "f",
        "B",
        "bracketright",
        "bracketright",
        "m",
        "m",
        "bracketleft",
        "bracketleft",
    ]);
    viewer.drag(1, [60, 60], [90, 70]);
    viewer.keys(&["1", "u", "f", "5"]);
    viewer.key("Home");
    let expected = viewer.render(&["--view=1", "--samples=1"]);
    viewer.wait_for_picture("a point", &expected, 2 * BELOW_MESSAGE);
    viewer.quit("q");
}

fn changed_files_are_loaded(screen: &Screen) {
    let mut viewer = Viewer::open(screen, SIZE, &["--view=1"]);
    viewer.key("a");
    let before = viewer.render(&["--view=1"]);
    viewer.wait_for_picture("the first scene", &before, 0);
    let scene = "light 3 -2 5 0.7\nmaterial 2\nsphere 0 0 0.5 0.9\n";
    let has_error = |name: &str| {
        wait_for("an error on the screen", || {
            let shot = viewer.shot();
            let red = shot.pixels().filter(|pixel| pixel.0 == [255, 128, 128]).count();
            // The last good picture stays visible below the message.
            let other = difference(&shot, &before, 120);
            if red > 100 && other == 0 {
                keep(&shot, name);
                Ok(())
            } else {
                Err(format!("{red} red pixels, {other} others below"))
            }
        });
    };
    viewer.write("a.scn", "light 3 -2 5 0.7\nmaterial 2\nsphere 0 0 0.5 wide\n");
    has_error("error");
    viewer.remove("a.scn");
    has_error("removed");
    let shows_the_file = |what: &str| {
        viewer.wait_for_picture(what, &viewer.render(&["--view=1"]), BELOW_MESSAGE);
    };
    viewer.write("a.scn", scene);
    shows_the_file("the second scene");
    // A mesh that the changed scene names is watched as well.
    viewer.write("meshes/t.ply", &triangle("0"));
    viewer.write("a.scn", &format!("{scene}ply_file meshes/t.ply\n"));
    shows_the_file("a mesh");
    viewer.write("meshes/t.ply", &triangle("1"));
    shows_the_file("another mesh");
    // A scene without lights is dark.
    viewer.write("a.scn", "material 1\nsphere 0 0 0.5 0.9\n");
    shows_the_file("no light");
    // An empty file is a scene.
    viewer.write("a.scn", "");
    shows_the_file("an empty scene");
    viewer.quit("q");
}

fn at_rest_it_uses_no_cpu(screen: &Screen) {
    let mut viewer = Viewer::open(screen, SIZE, &[]);
    viewer.wait_for_title("64 samples - done");
    thread::sleep(Duration::from_millis(300));
    // A tick is 10 ms: less than 1 % of three seconds.
    let ticks = idle_ticks(viewer.pid(), Duration::from_secs(3));
    assert!(ticks <= 2, "{ticks} ticks of CPU time in 3 s at rest");
    viewer.quit("q");
}

fn it_ends_at_once(screen: &Screen) {
    // While brute force traces a picture that takes minutes.
    let size = [600, 500];
    let mut viewer = Viewer::open(screen, size, &[]);
    let mut many = String::from("light 3 -2 5 0.7\nmaterial 3\n");
    for i in 0..20_000 {
        many += &format!(
            "sphere {} {} 0.5 0.01\n",
            f64::from(i % 141) / 70.0 - 1.0,
            f64::from(i / 141) / 70.0 - 1.0
        );
    }
    viewer.key("a");
    viewer.write("a.scn", &many);
    let expected = viewer.render(&[]);
    viewer.wait_for_picture("many spheres", &expected, BELOW_MESSAGE);
    viewer.key("b");
    let shot = viewer.wait_for_change("brute force", &expected, 0.05);
    // The next request does not wait for it.
    viewer.key("n");
    viewer.key("b");
    viewer.wait_for_change("normals", &shot, 0.05);
    viewer.key("n");
    viewer.wait_for_picture("the BVH again", &expected, BELOW_MESSAGE);
    // Another pose does not wait either: a coarser picture or the BVH shows it at once.
    viewer.key("b");
    viewer.wait_for_change("brute force", &expected, 0.05);
    let shot = viewer.shot();
    viewer.key("2");
    viewer.wait_for_change("another pose", &shot, 0.05);
    viewer.key("b");
    viewer.key("1");
    viewer.wait_for_picture("the BVH once more", &expected, BELOW_MESSAGE);
    viewer.key("b");
    viewer.wait_for_change("brute force again", &expected, 0.05);
    viewer.quit("q");
    // Closed by the window manager: at once, and during a benchmark.
    Viewer::open(screen, size, &[]).close();
    let mut viewer = Viewer::open(screen, size, &["--benchmark=1000"]);
    viewer.wait_for_title("1 sample");
    viewer.close();
}

fn signals_end_it(screen: &Screen) {
    // While a large picture is traced for a file, and another one for the window.
    let size = [700, 500];
    for (name, signal) in [("TERM", 15), ("HUP", 1), ("INT", 2)] {
        if name == "HUP" && signals::is_nohup() {
            continue;
        }
        let mut viewer = Viewer::open(screen, size, &["--mode=scalar"]);
        viewer.keys(&["s", "s", "s"]);
        viewer.signal(name, signal);
        only_whole_pictures(&viewer);
        assert!(viewer.said("not saved: the window was closed first"), "{name}");
    }
    // While pictures are written.
    let mut viewer = Viewer::open(screen, size, &[]);
    viewer.key("a");
    viewer.keys(&["s", "s", "s", "s"]);
    viewer.wait_for_file("a-1.png");
    viewer.quit("q");
    only_whole_pictures(&viewer);
}

/// The folder holds whole pictures and no half-written ones.
fn only_whole_pictures(viewer: &Viewer) {
    let pictures: Vec<String> = (1..=4).map(|i| format!("a-{i}.png")).collect();
    for name in viewer.files() {
        if pictures.contains(&name) {
            viewer.picture(&name);
        } else {
            assert!(
                ["a.scn", "meshes", "expected.png"].contains(&name.as_str()),
                "{name}"
            );
        }
    }
}

fn benchmarks_are_reported(screen: &Screen) {
    let folder = crate::program::Folder::new();
    let run = screen.run(
        &folder,
        &["view", "a.scn", "--size=64x64", "--benchmark=0.2", "--json=-"],
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
    let no_display = crate::program::Run::new(
        folder
            .command(&["view", "a.scn"])
            .env_remove("DISPLAY")
            .env_remove("WAYLAND_DISPLAY")
            .env_remove("WAYLAND_SOCKET")
            .output()
            .unwrap(),
    );
    no_display.failed(3, "no display");
    // Errors before a window opens.
    let too_large = screen.run(&folder, &["view", "a.scn", "--size=70000x64"]);
    too_large.failed(1, "at most 32767 pixels");
    let missing = screen.run(&folder, &["view", "b.scn"]);
    missing.failed(1, "b.scn: file not found");
}

//! Animated scenes in the window.

use super::{BELOW_MESSAGE, SIZE, Screen, Viewer, difference, meshes, wait_for};
use crate::playback;

/// An instance that rises and a camera that passes, in nine frames.
const RISING: &str = "light 3 -2 5 0.7\nmaterial 1\nsphere 0 0 0.5 0.5\n\
                      camera eye 5 -1 2 target 0 0 0.5\n  at 1\n  at 9 eye 4 3 2\n\
                      material 2\ninstance meshes/t.ply scale 0.4\n  at 1 translate 0 0 0\n  at 9 translate 0 0 1\n";

/// Each frame at rest is what render makes of it; the camera of the scene is followed until the user moves it.
pub fn play_and_step(screen: &Screen) {
    let mut viewer = Viewer::open(screen, SIZE, &["--samples=4"]);
    viewer.keys(&["space", "period", "comma"]);
    let line = viewer.camera_options();
    assert!(!line.contains("--frames"), "{line}");
    viewer.write("meshes/t.ply", &meshes::triangle("0"));
    viewer.write("a.scn", RISING);
    let stands_at = |viewer: &Viewer, frame: u32| {
        let title = wait_for("the frame", || {
            let title = viewer.title();
            let is_there = title.contains(&format!("frame {frame}/9 ")) && title.ends_with("done");
            if is_there { Ok(title) } else { Err(title) }
        });
        let expected = viewer.render(&["--samples=4", &format!("--frames={frame}")]);
        viewer.wait_for_picture(&title, &expected, BELOW_MESSAGE);
        expected
    };
    let first = stands_at(&viewer, 1);
    viewer.keys(&["period", "period"]);
    let third = stands_at(&viewer, 3);
    assert!(difference(&first, &third, 0) > 1000);
    let printed = |viewer: &Viewer| {
        let line = viewer.camera_options();
        let options: Vec<&str> = line.split_whitespace().collect();
        viewer.wait_for_picture(&line, &viewer.render(&options), BELOW_MESSAGE);
        line
    };
    assert!(printed(&viewer).contains("--frames=3"));
    viewer.key("s");
    viewer.wait_for_file("a-1.png");
    assert_eq!(difference(&viewer.picture("a-1.png"), &third, 0), 0);
    // Backwards over the first frame.
    viewer.keys(&["comma", "comma", "comma"]);
    stands_at(&viewer, 9);
    // From now on the camera stays.
    viewer.drag(1, [60, 60], [100, 70]);
    let moved = printed(&viewer).replace(" --frames=9", "");
    viewer.key("comma");
    assert_eq!(printed(&viewer).replace(" --frames=8", ""), moved);
    viewer.key("Home");
    stands_at(&viewer, 8);
    // Playing shows other frames in turn, and stops at one of them.
    viewer.key("space");
    frames_change(&viewer);
    viewer.key("space");
    let line = viewer.camera_options();
    let stopped = line.split_once("--frames=").map_or("1", |(_, frame)| frame);
    stands_at(&viewer, stopped.split(' ').next().unwrap().parse().unwrap());
    viewer.quit("q");
}

fn frames_change(viewer: &Viewer) {
    let frame = || {
        let title = viewer.title();
        let (_, rest) = title.split_once("frame ")?;
        rest.split_once('/')?.0.parse::<u32>().ok()
    };
    for _ in 0..2 {
        let before = frame();
        wait_for("another frame", || match frame() {
            now if now == before => Err(format!("{now:?}")),
            _ => Ok(()),
        });
    }
}

/// A frame that cannot be shown is said, and steps go past it.
pub fn step_past_a_frame(screen: &Screen) {
    let scene = "light 9 -4 10 0.7\nsphere 0 0 0 1\n\
                 camera eye 4 0 0 target 0 0 0\n  at 1\n  at 3 eye -4 0 0\n";
    let mut viewer = Viewer::open_file(screen, "b.scn", scene, SIZE, &["--samples=1"]);
    let stands_at = |frame: u32| {
        wait_for("the frame", || {
            let title = viewer.title();
            let is_there = title.contains(&format!("frame {frame}/3 ")) && title.ends_with("done");
            if is_there { Ok(()) } else { Err(title) }
        });
        let options = ["--samples=1", &format!("--frames={frame}")];
        viewer.wait_for_picture("the frame", &viewer.render(&options), BELOW_MESSAGE);
    };
    stands_at(1);
    viewer.key("period");
    viewer.wait_for_change("why frame 2 fails", &viewer.render(&["--frames=1"]), 0.005);
    assert!(viewer.title().contains("frame 1/3 "), "{}", viewer.title());
    // The picture on the screen can be saved.
    viewer.key("s");
    viewer.wait_for_file("b-1.png");
    let first = viewer.render(&["--samples=1", "--frames=1"]);
    assert_eq!(difference(&viewer.picture("b-1.png"), &first, 0), 0);
    viewer.key("period");
    stands_at(3);
    viewer.quit("q");
}

/// The animation of a mesh is loaded when it is asked for, and each frame is what render makes of it.
pub fn play_a_mesh(screen: &Screen) {
    let options = ["--samples=auto", "--fps=4"];
    let mut viewer = Viewer::open_file(screen, "t.gltf", &playback::swing(), SIZE, &options);
    let still = viewer.render(&[]);
    viewer.wait_for_picture("the pose without animation", &still, BELOW_MESSAGE);
    viewer.key("space");
    frames_change(&viewer);
    viewer.key("period");
    let stopped = |viewer: &Viewer| {
        let line = viewer.camera_options();
        assert!(line.contains("--fps=4") && line.contains("--frames="), "{line}");
        let options: Vec<&str> = line.split_whitespace().collect();
        let expected = viewer.render(&options);
        viewer.wait_for_picture(&line, &expected, BELOW_MESSAGE);
        expected
    };
    let first = stopped(&viewer);
    viewer.keys(&["period", "period", "period"]);
    let second = stopped(&viewer);
    assert!(difference(&first, &second, 0) > 100);
    viewer.key("s");
    viewer.wait_for_file("t-1.png");
    assert_eq!(difference(&viewer.picture("t-1.png"), &second, 0), 0);
    viewer.quit("q");
    // A step loads it, too, and does not play it.
    let mut viewer = Viewer::open_file(screen, "t.gltf", &playback::swing(), SIZE, &options);
    viewer.wait_for_picture("the pose without animation", &still, BELOW_MESSAGE);
    viewer.keys(&["period", "period", "comma", "period"]);
    let stands_at = |frame: &str| {
        wait_for(frame, || {
            let title = viewer.title();
            let is_there = title.contains(&format!("frame {frame} ")) && title.ends_with("done");
            if is_there { Ok(()) } else { Err(title) }
        });
        stopped(&viewer);
        assert!(viewer.title().contains(frame), "{}", viewer.title());
    };
    stands_at("3/8");
    // Another file has other frames. The one that is shown stays, or the last one is shown.
    for (seconds, frame) in [("1", "3/4"), ("0.5", "2/2"), ("3", "2/12")] {
        let length = format!("\"max\":[{seconds}]");
        viewer.write("t.gltf", &playback::swing().replace("\"max\":[2]", &length));
        stands_at(frame);
    }
    viewer.quit("q");
}

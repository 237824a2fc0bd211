//! The window during loading.

use super::{BELOW_MESSAGE, SIZE, Screen, Viewer, keep, wait_for};
use std::{thread, time::Duration};

/// Standard input takes as long as the test wants.
pub fn is_shown(screen: &Screen) {
    let open = || {
        let viewer = Viewer::open_file(screen, "-", "", SIZE, &["--samples=4"]);
        wait_for("a text", || {
            let shot = viewer.shot();
            let of = |color| shot.pixels().filter(|pixel| pixel.0 == color).count();
            let [letters, empty] = [[255; 3], [64; 3]].map(of);
            if letters > 100 && empty > 20_000 {
                Ok(())
            } else {
                Err(format!("{letters} and {empty} pixels"))
            }
        });
        keep(&viewer.shot(), "loading");
        viewer
    };
    let mut viewer = open();
    // Keys that need a scene do nothing.
    viewer.keys(&["c", "s", "space", "question", "f"]);
    viewer.click(4, 1);
    viewer.quit("q");
    open().close();
    let mut viewer = open();
    viewer.feed("sphere 0 0 wide 1\n");
    viewer.ended_with(1);
    let mut viewer = open();
    viewer.resize([120, 90]);
    viewer.feed("light 3 -2 5 0.7\nmaterial 1\nsphere 0 0 0.5 0.9\n");
    viewer.wait_for_title("120x90 - 4 samples - done");
    viewer.quit("q");
    // Where the mouse is by then counts: a drag begins there, and `f` frames what is under it.
    let mut viewer = Viewer::open_file(screen, "-", "", SIZE, &["--view=1", "--samples=1"]);
    viewer.move_mouse([100, 75]);
    viewer.feed("light 3 -2 5 0.7\nmaterial 1\nsphere 0 0 0.5 0.5\nsphere 0 0 9 0.5\n");
    viewer.wait_for_title("1 sample - done");
    let camera_after = |keys: &[&str]| {
        viewer.keys(keys);
        viewer.camera_options()
    };
    let framed = camera_after(&["f"]);
    let start = camera_after(&["Home"]);
    let camera_after_drag_to = |to: [u32; 2]| {
        viewer.button(1, true);
        viewer.move_mouse(to);
        viewer.button(1, false);
        viewer.camera_options()
    };
    let turned = camera_after_drag_to([104, 75]);
    assert_eq!(camera_after(&["Home", "f"]), framed);
    viewer.key("Home");
    assert_eq!(camera_after_drag_to([108, 75]), turned);
    assert!(![framed, turned].contains(&start), "{start}");
    viewer.quit("q");
}

/// A scene that changes while it is loaded is loaded again, and so is a file in a folder that takes another one's place.
pub fn takes_the_last_change(screen: &Screen) {
    // Reading takes a quarter of a second or so; the lights come last.
    let mut scene = String::from("include folder/inc.txt\nmaterial 1\n");
    for i in 0..80_000 {
        scene += &format!(
            "sphere {} {} 0.5 0.01\n",
            f64::from(i % 283) / 140.0 - 1.0,
            f64::from(i / 283) / 140.0 - 1.0
        );
    }
    let mut viewer = Viewer::open(screen, SIZE, &["--view=1", "--samples=1"]);
    let included = |folder: &str, radius: f64| {
        let text = format!("light 3 -2 5 0.7\nmaterial 2\nsphere 0 0 0.5 {radius}\n");
        viewer.write(&format!("{folder}/inc.txt"), &text);
    };
    let shows_the_file = |what: &str| {
        viewer.wait_for_picture(what, &viewer.render(&["--view=1"]), BELOW_MESSAGE);
    };
    for folder in ["folder", "other"] {
        viewer.create_folder(folder);
        included(folder, 0.3);
    }
    viewer.write("a.scn", &scene);
    // The new file is read while its folder is not watched yet.
    for radius in [0.4, 0.5, 0.6, 0.7] {
        thread::sleep(Duration::from_millis(40));
        included("folder", radius);
    }
    shows_the_file("the last change");
    viewer.rename("folder", "old");
    viewer.rename("other", "folder");
    shows_the_file("another folder");
    included("folder", 0.8);
    shows_the_file("a change in another folder");
    viewer.quit("q");
}

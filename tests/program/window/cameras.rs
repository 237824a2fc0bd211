//! Cameras with a lens and orthographic ones in the window.

use super::{BELOW_MESSAGE, SIZE, Screen, Viewer, difference};

/// At rest they are what render makes of them, and when they have moved, what it makes of the printed options.
pub fn have_lenses_and_parallel_rays(screen: &Screen) {
    for options in [
        ["--view=1", "--aperture=0.8", "--focus=4"],
        ["--view=2", "--ortho=3", "--aperture=0.5"],
    ] {
        let options = [&["--samples=4"], &options[..]].concat();
        let mut viewer = Viewer::open(screen, SIZE, &options);
        let start = viewer.render(&options);
        viewer.wait_for_title("4 samples - done");
        viewer.wait_for_picture("the start", &start, 0);
        // Brute force has the same lens.
        viewer.key("b");
        viewer.wait_for_title("4 samples - done");
        viewer.wait_for_picture("brute force", &start, BELOW_MESSAGE);
        viewer.key("b");
        viewer.drag(1, [60, 60], [100, 70]);
        viewer.click(4, 2);
        let line = viewer.camera_options();
        let kept = options[2].split('=').next().unwrap();
        assert!(line.contains(kept) && line.contains("--aperture=0."), "{line}");
        let printed: Vec<&str> = line.split_whitespace().collect();
        let moved = viewer.render(&printed);
        assert!(difference(&moved, &start, 0) > 1000);
        viewer.wait_for_picture(&line, &moved, BELOW_MESSAGE);
        viewer.key("s");
        viewer.wait_for_file("a-1.png");
        assert_eq!(difference(&viewer.picture("a-1.png"), &moved, 0), 0, "{line}");
        // A single sample has a lens, too; normals have none.
        viewer.key("a");
        let line = viewer.camera_options();
        let printed: Vec<&str> = line.split_whitespace().collect();
        viewer.wait_for_picture("one sample", &viewer.render(&printed), BELOW_MESSAGE);
        viewer.key("n");
        viewer.render(&[&printed[..], &["--aov=normal"]].concat());
        let normals = viewer.picture("expected.normal.png");
        viewer.wait_for_picture("normals", &normals, BELOW_MESSAGE);
        viewer.key("n");
        viewer.key("a");
        viewer.key("Home");
        viewer.wait_for_picture("the starting camera", &start, BELOW_MESSAGE);
        viewer.quit("q");
    }
}

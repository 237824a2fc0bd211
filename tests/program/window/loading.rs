//! The window during loading.

use super::{SIZE, Screen, Viewer, keep, wait_for};

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
}

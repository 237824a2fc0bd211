//! Tests of `status`.

use super::*;

#[test]
fn the_title_has_the_figures() {
    let start = Instant::now();
    let mut status = Status::default();
    let mut picture = Picture {
        size: [640, 480],
        traced: [320, 240],
        samples: 1,
        rays: 3_000_000,
        elapsed: Duration::from_millis(10),
        packets: Some(true),
        ..Picture::default()
    };
    for i in 0..50 {
        status.shown(&picture, start + Duration::from_millis(20) * i);
    }
    let title = status.title("a.scn", &picture, start);
    let expected = "octray - a.scn - 50 fps - 300.0 Mrays/s - 640x480 from 320x240 - 1 sample";
    assert_eq!(title.as_deref(), Some(expected));
    assert_eq!(status.title("a.scn", &picture, start), None);
    picture = Picture {
        traced: [640, 480],
        samples: 64,
        full: true,
        last: true,
        ..picture
    };
    status.shown(&picture, start + Duration::from_secs(2));
    let title = status.title("a.scn", &picture, start).unwrap();
    assert!(
        title.ends_with("a.scn - 300.0 Mrays/s - 640x480 - 64 samples - done"),
        "{title}"
    );
    picture.frame = [12, 50];
    assert!(status.line(&picture).starts_with("frame 12/50 - 300.0"));
    picture.adaptive = true;
    assert!(
        status
            .line(&picture)
            .ends_with("640x480 - up to 64 samples - done")
    );
    assert!(status.modes()[0].contains("300.0") && status.modes()[1].contains("press p"));
}

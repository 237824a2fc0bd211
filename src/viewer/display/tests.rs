use super::*;
use std::os::unix::net::UnixListener;

#[test]
fn a_compositor_answers_at_its_socket_only() {
    let folder = tempfile::TempDir::new().unwrap();
    let path = folder.path().join("wayland-0");
    let listener = UnixListener::bind(&path).unwrap();
    assert!(answers("wayland-0".into(), Some(folder.path())));
    assert!(answers(path.clone().into(), None));
    assert!(!answers("wayland-9".into(), Some(folder.path())));
    assert!(!answers("wayland-0".into(), Some(Path::new("relative"))));
    assert!(!answers("wayland-0".into(), None));
    // Left behind by a compositor that has ended.
    drop(listener);
    assert!(path.exists() && !answers("wayland-0".into(), Some(folder.path())));
}

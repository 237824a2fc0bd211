use super::*;
use std::{os::unix::net::UnixListener, time::Instant};

/// A compositor at a socket, which does this with a client.
fn compositor(path: &Path, serve: impl Fn(UnixStream) + Send + 'static) {
    let listener = UnixListener::bind(path).unwrap();
    std::thread::spawn(move || listener.incoming().flatten().for_each(serve));
}

#[test]
fn a_compositor_answers_at_its_socket_only() {
    const SHORT: Duration = Duration::from_millis(200);
    const LONG: Duration = Duration::from_secs(20);
    let folder = tempfile::TempDir::new().unwrap();
    let path = folder.path().join("wayland-0");
    compositor(&path, |mut client| {
        let mut request = [0; 12];
        client.read_exact(&mut request).unwrap();
        let words = [0, 4, 8].map(|at| u32::from_ne_bytes([0, 1, 2, 3].map(|byte| request[at + byte])));
        assert_eq!(words, [1, 12 << 16, 2]);
        // The event `done` of object 2.
        let done = [2, 12 << 16, 7_u32].map(u32::to_ne_bytes);
        client.write_all(done.as_flattened()).unwrap();
    });
    let here = Some(folder.path());
    assert_eq!(answer("wayland-0".into(), here, LONG), Answer::Yes);
    assert_eq!(answer(path.into(), None, LONG), Answer::Yes);
    assert_eq!(answer("wayland-9".into(), here, LONG), Answer::No);
    let relative = Some(Path::new("relative"));
    assert_eq!(answer("wayland-0".into(), relative, LONG), Answer::No);
    assert_eq!(answer("wayland-0".into(), None, LONG), Answer::No);
    // Left behind by a compositor that has ended.
    let path = folder.path().join("wayland-1");
    drop(UnixListener::bind(&path).unwrap());
    assert!(path.exists() && answer("wayland-1".into(), here, LONG) == Answer::No);
    // One that sends every client away.
    compositor(&folder.path().join("wayland-2"), drop);
    assert_eq!(answer("wayland-2".into(), here, LONG), Answer::No);
    // One that takes clients and is silent, and one that does not even take them.
    compositor(&folder.path().join("wayland-3"), std::mem::forget);
    let _deaf = UnixListener::bind(folder.path().join("wayland-4")).unwrap();
    for name in ["wayland-3", "wayland-4"] {
        let start = Instant::now();
        assert_eq!(answer(name.into(), here, SHORT), Answer::None);
        assert!(start.elapsed() < LONG);
    }
}

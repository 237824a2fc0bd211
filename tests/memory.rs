//! How much memory it takes from a file to a picture.

use octray::{
    accel::{BuildQuality, Bvh},
    format::{mesh, ply},
    generate::{Kind, Options, Shape, generate, write_ply},
    render::{ByteFilm, Renderer, Settings},
    scene::SceneBuilder,
};
use std::{
    alloc::{GlobalAlloc, Layout, System},
    fs,
    ops::ControlFlow,
    path::Path,
    sync::atomic::{AtomicUsize, Ordering},
};

/// The system's allocator, and how many bytes were in use at most.
struct Counting;

static IN_USE: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

fn count(layout: Layout) {
    let in_use = IN_USE.fetch_add(layout.size(), Ordering::Relaxed) + layout.size();
    PEAK.fetch_max(in_use, Ordering::Relaxed);
}

// SAFETY: everything goes to the system's allocator as it came. (`realloc` comes as a new piece, a copy and an end.)
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout);
        // SAFETY: the caller's promises are the same.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count(layout);
        // SAFETY: the caller's promises are the same.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        IN_USE.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: the caller's promises are the same.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// How much more is in use at the peak of some work than before it.
fn peak<T>(work: impl FnOnce() -> T) -> usize {
    let before = IN_USE.load(Ordering::Relaxed);
    PEAK.store(before, Ordering::Relaxed);
    drop(work());
    PEAK.load(Ordering::Relaxed) - before
}

/// The most bytes a triangle, besides those of the input.
const BYTES_PER_TRIANGLE: usize = 200;
const TRIANGLES: usize = 200_000;

// One test: another's memory would be counted too.
#[test]
fn from_a_file_to_a_picture() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("terrain.ply");
    let options = Options {
        count: Some(TRIANGLES),
        ..Options::default()
    };
    let terrain = generate(Kind::Terrain, options).expect("a terrain");
    let camera = terrain.view.camera().expect("a view");
    let Some(Shape::Mesh(columns)) = terrain.parts.into_iter().map(|part| part.shape).next() else {
        panic!("a terrain is a mesh");
    };
    let triangles = columns.triangles.len();
    let mut file = Vec::new();
    write_ply(&columns, &mut file).expect("a file");
    fs::write(&path, &file).expect("the file is written");
    drop(columns);

    for quality in [BuildQuality::Fast, BuildQuality::Best] {
        let most = peak(|| {
            let mut builder = SceneBuilder::new();
            let loaded = mesh::load(&path).expect("a mesh");
            loaded.add_to(&mut builder, None).expect("it fits");
            let scene = builder.finish();
            let bvh = Bvh::build_with(&scene, quality);
            let mut film = ByteFilm::black(64, 64);
            let settings = Settings {
                width: 64,
                height: 64,
                threads: Some(2),
                ..Settings::default()
            };
            let rendered = Renderer::new(&scene, &bvh)
                .render(&camera, &settings, &mut film, &|_| ControlFlow::Continue(()));
            rendered.expect("a picture");
        });
        let of_each = most / triangles;
        assert!(
            of_each < BYTES_PER_TRIANGLE,
            "{}: {of_each} bytes a triangle",
            quality.name()
        );
    }

    // A binary file is not kept beside the mesh: half of its vertices' and faces' bytes more would show.
    let columns = peak(|| mesh::load(&path).expect("a mesh"));
    assert!(
        columns < file.len() + (2 << 20),
        "{columns} bytes for a file of {}",
        file.len()
    );

    counts_that_do_not_fit(&path, &file);
}

/// A count that cannot fit into the bytes that follow is refused before anything is allocated for it, and before the rest
/// of a file is read.
fn counts_that_do_not_fit(path: &Path, file: &[u8]) {
    let body = file
        .windows(11)
        .position(|word| word == b"end_header\n")
        .expect("a header");
    let header = String::from_utf8_lossy(&file[..body]);
    for (element, count) in [
        ("vertex", usize::MAX),
        ("vertex", 20_000_000),
        ("face", 1_000_000_000),
    ] {
        let place = header.find(&format!("element {element} ")).expect("an element");
        let end = place + header[place..].find('\n').expect("a line");
        let promise = format!("{}element {element} {count}{}", &header[..place], &header[end..]);
        let broken = [promise.as_bytes(), &file[body..]].concat();
        fs::write(path, &broken).expect("the file is written");
        let parsed = peak(|| ply::parse(&broken, path).expect_err("it is refused"));
        let loaded = peak(|| mesh::load(path).expect_err("it is refused"));
        assert!(
            parsed.max(loaded) < 100_000,
            "{count} of {element}: {parsed} and {loaded} bytes"
        );
    }
}

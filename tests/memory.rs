//! How often octray allocates and how much: nothing per frame, a bounded number of bytes per triangle.
//!
//! A test program of its own with a single test, because the allocator counts for the whole process.

use octray::{
    accel::{BuildQuality, Bvh},
    format::{self, mesh, ply},
    generate::{Kind, Options, Shape, generate, write_ply},
    render::{ByteFilm, Pattern, Renderer, Settings},
    scene::{Camera, SceneBuilder},
};
use std::{
    alloc::{GlobalAlloc, Layout, System},
    collections::HashSet,
    fs,
    ops::ControlFlow,
    path::Path,
    sync::{
        Mutex,
        atomic::{AtomicUsize, Ordering},
    },
    thread::{self, ThreadId},
    time::{Duration, Instant},
};

/// The system's allocator. It counts allocations, the bytes in use and their peak.
struct Counting;

static ALLOCATIONS: AtomicUsize = AtomicUsize::new(0);
static IN_USE: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

fn count(layout: Layout) {
    ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
    let in_use = IN_USE.fetch_add(layout.size(), Ordering::Relaxed) + layout.size();
    PEAK.fetch_max(in_use, Ordering::Relaxed);
}

// SAFETY: every call goes to the system's allocator unchanged. (The default `realloc` calls `alloc` and `dealloc`.)
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

/// One test, so that nothing else allocates while it measures.
#[test]
fn memory_is_bounded() {
    frames_allocate_nothing();
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("terrain.ply");
    let file = from_a_file_to_a_picture(&path);
    impossible_counts_are_refused(&path, &file);
    the_first_reading_is_freed(&folder.path().join("map.obj"));
}

/// Frames that are counted.
const FRAMES: usize = 24;
/// Seven bands of tiles in the first frame, four in the last.
const HEIGHT: u32 = 97;
/// Rayon's injector queue allocates a block for every 63 jobs; on a busy machine, where its threads sleep and wake more
/// often, up to six were seen. One allocation per tile would be 1,000.
const RAYON_ALLOCATIONS: usize = 8;
/// Each frame has a lock, which allocates on some systems.
const LOCK_ALLOCATIONS: usize = if cfg!(target_vendor = "apple") { FRAMES } else { 0 };

/// After the first frame a renderer's threads have their buffers.
fn frames_allocate_nothing() {
    let scenes = [
        ("reflections", 1),
        ("reflections", 2),
        ("hall_of_mirrors", 2),
        ("soft", 2),
        ("garden", 2),
    ];
    for (name, threads) in scenes {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenes/{name}.scn"));
        let scene = format::load(&path).unwrap_or_else(|error| panic!("{error}"));
        let bvh = Bvh::build(&scene);
        let mut settings = Settings {
            width: 333,
            height: HEIGHT,
            threads: Some(threads),
            max_depth: 6,
            ..Settings::default()
        };
        let cameras: Vec<Camera> = (1..=6).filter_map(Camera::classic_view).collect();
        let mut renderer = Renderer::new(&scene, &bvh);
        let mut film = ByteFilm::black(settings.width, settings.height);

        // In the first frame each thread waits for the others, so that every one of them allocates its buffers.
        let seen: Mutex<HashSet<ThreadId>> = Mutex::default();
        let start = Instant::now();
        let wait_for_all = |_| {
            seen.lock().unwrap().insert(thread::current().id());
            while seen.lock().unwrap().len() < threads && start.elapsed() < Duration::from_secs(20) {
                thread::yield_now();
            }
            ControlFlow::Continue(())
        };
        let first = renderer.render(&cameras[0], &settings, &mut film, &wait_for_all);
        first.unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(
            seen.lock().unwrap().len(),
            threads,
            "{name}: threads that rendered"
        );

        let before = ALLOCATIONS.load(Ordering::Relaxed);
        for frame_i in 0..FRAMES {
            // Other views, with and without shadows, several samples, adaptive ones, smaller pictures.
            settings.shadows = frame_i % 4 != 1;
            settings.adaptive = frame_i % 8 == 5;
            (settings.pattern, settings.samples) = if settings.adaptive {
                (Pattern::Sobol, 16)
            } else {
                (Pattern::Grid, 1 + 3 * u32::from(frame_i % 8 == 2))
            };
            settings.height = HEIGHT - frame_i as u32;
            let camera = &cameras[frame_i % cameras.len()];
            let frame = renderer.render(camera, &settings, &mut film, &|_| ControlFlow::Continue(()));
            frame.unwrap_or_else(|error| panic!("{name}: {error}"));
        }
        let allocations = ALLOCATIONS.load(Ordering::Relaxed) - before;
        assert!(
            allocations <= RAYON_ALLOCATIONS + LOCK_ALLOCATIONS,
            "{name}, {threads} threads: {allocations} allocations in {FRAMES} frames"
        );
    }
}

/// Bytes that `work` uses at its peak, beyond those in use before it.
fn peak<T>(work: impl FnOnce() -> T) -> usize {
    let before = IN_USE.load(Ordering::Relaxed);
    PEAK.store(before, Ordering::Relaxed);
    drop(work());
    PEAK.load(Ordering::Relaxed) - before
}

/// The limit for a triangle, the mesh file included.
const BYTES_PER_TRIANGLE: usize = 200;
const TRIANGLES: usize = 200_000;

/// Writes a mesh to `path`, loads and renders it. Returns the file's bytes.
fn from_a_file_to_a_picture(path: &Path) -> Vec<u8> {
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
    fs::write(path, &file).expect("the file is written");
    drop(columns);

    for quality in [BuildQuality::Fast, BuildQuality::Best] {
        let most = peak(|| {
            let mut builder = SceneBuilder::new();
            let loaded = mesh::load(path).expect("a mesh");
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
        let per_triangle = most / triangles;
        assert!(
            per_triangle < BYTES_PER_TRIANGLE,
            "{}: {per_triangle} bytes per triangle",
            quality.name()
        );
    }

    // A binary file is never in memory as a whole beside its mesh, which is as large.
    let loading = peak(|| mesh::load(path).expect("a mesh"));
    assert!(
        loading < file.len() + (2 << 20),
        "{loading} bytes for a file of {}",
        file.len()
    );
    file
}

/// A mesh in map coordinates is read twice, but not both at a time.
fn the_first_reading_is_freed(path: &Path) {
    let load = |at: f64| {
        let line = |i: u32| {
            format!(
                "v {} {} 0\n",
                at + f64::from(i % 300) * 0.001,
                f64::from(i / 300) * 0.001
            )
        };
        let vertices: String = (0..90_000).map(line).collect();
        let faces: String = (1..89_000)
            .map(|i| format!("f {i} {} {}\n", i + 1, i + 300))
            .collect();
        let text = vertices + &faces;
        fs::write(path, &text).expect("the file is written");
        peak(|| {
            let mesh = mesh::load(path).expect("a mesh");
            assert_eq!(mesh.offset.x != 0.0, at != 0.0);
            mesh
        })
        .saturating_sub(text.len())
    };
    let (near, far) = (load(0.0), load(500_000.0));
    assert!(
        far < near + near / 20,
        "{far} bytes far from 0, {near} bytes near it"
    );
}

/// A count that cannot fit into the rest of the file is refused before memory is allocated for it and before the rest
/// is read.
fn impossible_counts_are_refused(path: &Path, file: &[u8]) {
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
        let start = header.find(&format!("element {element} ")).expect("an element");
        let end = start + header[start..].find('\n').expect("a line");
        let changed = format!("{}element {element} {count}{}", &header[..start], &header[end..]);
        let broken = [changed.as_bytes(), &file[body..]].concat();
        fs::write(path, &broken).expect("the file is written");
        let parsed = peak(|| ply::parse(&broken, path).expect_err("it is refused"));
        let loaded = peak(|| mesh::load(path).expect_err("it is refused"));
        assert!(
            parsed.max(loaded) < 100_000,
            "{element} {count}: {parsed} and {loaded} bytes"
        );
    }
}

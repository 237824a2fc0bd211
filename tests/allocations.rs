//! Once the threads of a renderer have their memory, frames allocate nothing.

use octray::{
    accel::Bvh,
    format,
    render::{ByteFilm, Renderer, Settings},
    scene::Camera,
};
use std::{
    alloc::{GlobalAlloc, Layout, System},
    collections::HashSet,
    ops::ControlFlow,
    path::Path,
    sync::{
        Mutex,
        atomic::{AtomicUsize, Ordering},
    },
    thread::{self, ThreadId},
    time::{Duration, Instant},
};

/// The system's allocator, and how often it was asked for memory.
struct Counting;

static ALLOCATIONS: AtomicUsize = AtomicUsize::new(0);

// SAFETY: everything goes to the system's allocator as it came.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller's promises are the same.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller's promises are the same.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller's promises are the same.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Frames that are counted.
const FRAMES: usize = 40;
/// What rayon may take for itself: its queue for work from outside takes a block of memory once in 63 pieces of work,
/// and on a busy machine its threads, woken and put to sleep more often, have been seen to take up to six. One allocation
/// a tile would be 3,000.
const BLOCKS_OF_RAYON: usize = 8;

/// A frame has a lock, which takes memory on some systems.
const BLOCKS_OF_LOCKS: usize = if cfg!(target_vendor = "apple") { FRAMES } else { 0 };

// One test: another's allocations would be counted too.
#[test]
fn frames_allocate_nothing_once_threads_have_their_memory() {
    for (name, threads) in [("reflections", 1), ("reflections", 2), ("hall_of_mirrors", 2)] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenes/{name}.scn"));
        let scene = format::load(&path).unwrap_or_else(|error| panic!("{error}"));
        let bvh = Bvh::build(&scene);
        let mut settings = Settings {
            width: 333,
            height: 217,
            threads: Some(threads),
            max_depth: 6,
            ..Settings::default()
        };
        let cameras: Vec<Camera> = (1..=6).filter_map(Camera::classic_view).collect();
        let mut renderer = Renderer::new(&scene, &bvh);
        let mut film = ByteFilm::black(settings.width, settings.height);

        // In the first frame each thread waits for the others, so that all get their memory.
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
        assert_eq!(seen.lock().unwrap().len(), threads, "{name}: all threads came");

        let before = ALLOCATIONS.load(Ordering::Relaxed);
        for frame_i in 0..FRAMES {
            // Other views, with and without shadows, several samples, and smaller pictures.
            settings.shadows = frame_i % 4 != 1;
            settings.samples = 1 + 3 * u32::from(frame_i % 8 == 2);
            settings.height = 217 - frame_i as u32;
            let camera = &cameras[frame_i % cameras.len()];
            let frame = renderer.render(camera, &settings, &mut film, &|_| ControlFlow::Continue(()));
            frame.unwrap_or_else(|error| panic!("{name}: {error}"));
        }
        let allocations = ALLOCATIONS.load(Ordering::Relaxed) - before;
        assert!(
            allocations <= BLOCKS_OF_RAYON + BLOCKS_OF_LOCKS,
            "{name}, {threads} threads: {allocations} allocations in {FRAMES} frames"
        );
    }
}

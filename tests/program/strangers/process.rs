//! The process: signals at any time, and memory with any input.
//!
//! `OCTRAY_LONG=1` takes a larger mesh and many more limits on memory.

use super::Call;
use crate::{
    long::{is_long, rounds},
    program::{Folder, send_signal},
};
use std::{
    fmt::Write as _,
    fs::{self, File},
    time::{Duration, Instant},
};

/// A signal is handled within half a second; a busy machine may take longer to end the process.
const MOST_WAIT: Duration = Duration::from_millis(1500);

/// Spheres that mirror each other under many lights.
fn endless(folder: &Folder, name: &str) {
    let mut text = String::new();
    for i in 0..1000 {
        let _ = writeln!(text, "light {} 9 {} 0.001", i % 37, i / 37 + 5);
    }
    text.push_str("material reflection mix 0.99\n");
    for i in 0..200 {
        let _ = writeln!(text, "sphere {} {} {} 0.6", i % 6, i / 6 % 6, i / 36);
    }
    folder.write(name, &text);
}

/// Triangles in all directions, as OBJ, with polygons.
fn large(folder: &Folder, name: &str, vertices: u64) {
    let mut text = String::new();
    for i in 0..vertices {
        let [x, y, z] = [1009, 1013, 1019].map(|prime| i * 7919 % prime);
        let _ = writeln!(text, "v {x} {y} {z}");
    }
    for i in 0..vertices - 10 {
        let _ = writeln!(
            text,
            "f {} {} {} {} {} {}",
            i + 1,
            i + 2,
            i + 4,
            i + 3,
            i + 6,
            i + 5
        );
    }
    folder.write(name, &text);
}

#[test]
fn signals_are_heard_whatever_is_in_hand() {
    let folder = Folder::new();
    endless(&folder, "endless.scn");
    large(&folder, "large.obj", 150_000);
    let hang_up = if crate::signals::is_nohup() {
        "-INT"
    } else {
        "-HUP"
    };
    for (arguments, signal) in [
        (
            "endless.scn --samples 1048576 --size 8x8 --max-depth 1000",
            "-INT",
        ),
        ("endless.scn --size 4096x4096 --mode scalar", "-TERM"),
        ("endless.scn --samples 4194304 --size 1x1", hang_up),
        ("large.obj --smooth-angle 180", "-INT"),
        ("large.obj --smooth-angle 180 --size 8192x8192 -o a.exr", "-TERM"),
        ("info large.obj", "-INT"),
    ] {
        for milliseconds in [60, 200] {
            let arguments: Vec<&str> = arguments.split(' ').collect();
            let mut child = folder.command(&arguments).spawn().unwrap();
            std::thread::sleep(Duration::from_millis(milliseconds));
            send_signal(&child, signal);
            let start = Instant::now();
            let status = child.wait().unwrap();
            let waited = start.elapsed();
            assert!(waited < MOST_WAIT, "{arguments:?} {milliseconds}: {waited:?}");
            // Quick commands may have ended before.
            assert!(matches!(status.code(), None | Some(0)), "{arguments:?}: {status}");
        }
    }
    let mut names = folder.names();
    names.retain(|name| !matches!(name.as_str(), "large.png" | "a.exr"));
    assert_eq!(names, ["a.scn", "endless.scn", "large.obj"]);
}

/// Allocations that no count foresaw end with one sentence at the allocator.
#[test]
fn memory_that_nothing_counted_refused_by_the_allocator() {
    let folder = Folder::new();
    large(&folder, "large.obj", 150_000);
    Call::new(&folder, &["large.obj", "--smooth-angle", "180", "--size", "8x8"])
        .within(20)
        .refused("error: large.obj: ");
    // Standard input without an end.
    let zeros = File::open("/dev/zero").unwrap();
    let endless = Call::new(&folder, &["-"]).within(50).with_input(zeros);
    endless.refused("error: ");
    assert_eq!(folder.names(), ["a.scn", "large.obj"]);
}

/// Under any limit on the address space, every command and format ends with exit code 0 or 1 and at most one sentence.
/// `limits` are in KiB.
fn in_any_address_space(folder: &Folder, limits: [u32; 4], commands: &[&str]) {
    let long = (100_000..=2_000_000).step_by(20_000);
    let limits: Vec<u32> = if is_long() {
        long.collect()
    } else {
        limits.to_vec()
    };
    for arguments in commands {
        for kibibytes in &limits {
            let run = folder.shell(&format!("ulimit -v {kibibytes}; exec \"$0\" {arguments}"));
            let name = format!("{arguments}, {kibibytes} KiB: {:?} {}", run.code, run.stderr);
            match run.code {
                Some(0) => {}
                Some(1) => {
                    let errors = run.stderr.lines().filter(|line| line.starts_with("error: "));
                    assert_eq!(errors.count(), 1, "{name}");
                    assert!(!run.stderr.contains("panicked"), "{name}");
                }
                _ => panic!("{name}"),
            }
            let half = folder
                .names()
                .into_iter()
                .find(|name| name.starts_with(".octray"));
            assert_eq!(half, None, "{name}");
        }
    }
}

// Two tests, so that two cores share them.
#[test]
fn any_address_space_with_any_command() {
    let folder = Folder::new();
    large(&folder, "large.obj", rounds(20_000, 150_000));
    folder.write("mesh.scn", "light 1 2 3 1\nmesh large.obj\n");
    // Loading the mesh is refused, then building its BVH; then an allocation fails; then all is well.
    let limits = [69_000, 75_000, 180_000, 600_000];
    in_any_address_space(
        &folder,
        limits,
        &[
            // Plain: soft light among polygons that all overlap takes a minute without optimisation, and no more memory.
            "large.obj --size 64x64 --quiet --style plain",
            "mesh.scn --size 64x64 --quiet --stats",
            "a.scn --size 64x64 --quiet --turntable 3 -o t#.png",
            "info large.obj",
            "info mesh.scn --json -",
            "verify --rays 1000",
            "bench a.scn --size 64x64 --repeat 1",
            "generate flake -o made --force",
            "man",
        ],
    );
}

#[test]
fn any_address_space_with_any_format() {
    let folder = Folder::new();
    let limits = [100_000, 180_000, 320_000, 600_000];
    in_any_address_space(
        &folder,
        limits,
        &[
            "a.scn --size 2048x2048 --quiet -o a.exr",
            "a.scn --size 2048x2048 --quiet -o a.exr --aov depth,normal",
            "a.scn --size 2048x2048 --quiet -o a.png --aov depth",
            "a.scn --size 2048x2048 --quiet -o a.tiff",
            "a.scn --size 1024x1024 --quiet -o a.jpg",
        ],
    );
    assert!(fs::metadata(folder.path("a.exr")).is_ok());
}

//! Injected faults: full, read-only and vanished disks, readers that go away, files that change while they are
//! read. A picture is complete or not there at all.
//!
//! `OCTRAY_LONG=1` changes a larger mesh at more times.
#![cfg(unix)]

use crate::{
    long::rounds,
    program::{Folder, Run},
};
use std::{
    fs::{self, OpenOptions},
    io::{Read, Write},
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    thread::sleep,
    time::{Duration, Instant},
};

/// Longer than any step takes on a busy machine.
const PATIENCE: Duration = Duration::from_mins(1);

const SCENE: &str = "light 3 -2 5 0.7\nmaterial 1\nsphere 0 0 0.5 0.5\nmaterial 3\nsphere 0.6 0.4 0.2 0.2\n";

/// A file system of `size` bytes in memory; unmounted when dropped.
struct Mount(PathBuf);

impl Mount {
    /// `None` if this user may not mount.
    fn new(folder: &Folder, size: usize) -> Option<Self> {
        let place = folder.path("disk");
        fs::create_dir(&place).unwrap();
        let mount = Self(place);
        if mount.run(&["mount", "-t", "tmpfs", "-o", &format!("size={size}"), "octray"]) {
            Some(mount)
        } else {
            println!("skipped: this user may not mount a file system");
            std::mem::forget(mount);
            None
        }
    }

    /// Runs a command on the mount point. Returns whether it succeeded.
    fn run(&self, command: &[&str]) -> bool {
        let output = Command::new(command[0]).args(&command[1..]).arg(&self.0).output();
        output.is_ok_and(|output| output.status.success())
    }
}

impl Drop for Mount {
    fn drop(&mut self) {
        self.run(&["umount"]);
    }
}

#[test]
fn a_full_disk() {
    let folder = Folder::new();
    let Some(mount) = Mount::new(&folder, 1 << 18) else {
        return;
    };
    fs::write(mount.0.join("a.bmp"), "old").unwrap();
    let left = ["a.bmp"];
    for arguments in [
        &["a.scn", "-o", "disk/a.bmp"][..],
        &["a.scn", "-o", "disk/new.ppm"],
        &["a.scn", "-o", "disk/new.exr", "--aov", "normal,depth"],
        &["a.scn", "-o", "disk/new.bmp", "--aov", "normal"],
        &["generate", "terrain", "-o", "disk", "--count", "20000"],
    ] {
        let run = folder.run(arguments);
        run.failed(1, "cannot write disk/");
        assert!(run.stderr.contains("no space left on the device"), "{run:?}");
        assert_eq!(crate::program::names_in(&mount.0), left, "{arguments:?}");
    }
    assert_eq!(fs::read_to_string(mount.0.join("a.bmp")).unwrap(), "old");
    // Not one byte is free.
    fs::write(mount.0.join("fill"), vec![0; 1 << 18]).unwrap_err();
    folder
        .run(&["a.scn", "-o", "disk/a.bmp", "--size", "9x9"])
        .failed(1, "no space left on the device");
}

#[test]
fn a_read_only_disk() {
    let folder = Folder::new();
    let Some(mount) = Mount::new(&folder, 1 << 20) else {
        return;
    };
    fs::write(mount.0.join("a.png"), "old").unwrap();
    assert!(mount.run(&["mount", "-o", "remount,ro"]));
    // Billions of rays: the error comes before they are traced.
    for name in ["disk/a.png", "disk/new.png"] {
        folder
            .run(&["a.scn", "-o", name, "--size", "3000x3000", "--samples", "400"])
            .failed(1, &format!("cannot write {name}: the file system is read-only"));
    }
    let run = folder.run(&["generate", "terrain", "-o", "disk", "--count", "2000"]);
    run.failed(1, "the file system is read-only");
}

#[test]
fn an_immutable_folder() {
    let folder = Folder::new();
    fs::create_dir(folder.path("locked")).unwrap();
    let chattr = |flag: &str| {
        let run = folder.any_command("chattr", &[flag, "locked"]).output();
        run.is_ok_and(|output| output.status.success())
    };
    if !chattr("+i") {
        println!("skipped: this user or file system cannot make a folder immutable");
        return;
    }
    let run = folder.run(&["a.scn", "-o", "locked/a.png"]);
    chattr("-i");
    run.failed(1, "cannot write locked/a.png: ");
}

/// Starts rendering a scene from standard input, and waits until the program has checked its output and waits for the
/// scene.
#[cfg(target_os = "linux")]
fn started(folder: &Folder, arguments: &[&str]) -> Child {
    let mut command = folder.command(arguments);
    let child = command.stdin(Stdio::piped()).spawn().unwrap();
    let start = Instant::now();
    let mut asleep = 0;
    while asleep < 20 {
        let stat = fs::read_to_string(format!("/proc/{}/stat", child.id())).unwrap_or_default();
        let sleeps = stat.rsplit(") ").next().is_some_and(|rest| rest.starts_with('S'));
        // It also sleeps for a moment while its threads start.
        asleep = if sleeps { asleep + 1 } else { 0 };
        assert!(
            start.elapsed() < PATIENCE,
            "{arguments:?} does not wait for its scene"
        );
        sleep(Duration::from_millis(5));
    }
    child
}

/// Sends the scene and waits for the end of the program.
fn finish(mut child: Child, scene: &str) -> Run {
    // The program may have ended already.
    let _ = child.stdin.take().unwrap().write_all(scene.as_bytes());
    Run::new(child.wait_with_output().unwrap())
}

#[test]
#[cfg(target_os = "linux")]
fn a_folder_that_vanishes_during_rendering() {
    let folder = Folder::new();
    fs::create_dir(folder.path("out")).unwrap();
    let child = started(&folder, &["-", "-o", "out/a.png"]);
    fs::remove_dir(folder.path("out")).unwrap();
    finish(child, SCENE).failed(1, "cannot write out/a.png: ");

    fs::create_dir(folder.path("out")).unwrap();
    let child = started(&folder, &["-", "-o", "out/a.png"]);
    fs::remove_dir(folder.path("out")).unwrap();
    fs::write(folder.path("out"), "a file now").unwrap();
    finish(child, SCENE).failed(1, "cannot write out/a.png: ");

    // A folder takes the place of the picture.
    let child = started(&folder, &["-", "-o", "b.png"]);
    fs::create_dir(folder.path("b.png")).unwrap();
    finish(child, SCENE).failed(1, "cannot write b.png: it is a directory");
    assert_eq!(folder.names(), ["a.scn", "b.png", "out"]);
}

#[test]
fn a_named_pipe_whose_reader_goes_away() {
    let folder = Folder::new();
    if !folder.make_pipe("pipe.ppm") {
        return;
    }
    // Far more than a pipe holds.
    let child = folder
        .command(&["a.scn", "-o", "pipe.ppm", "--size", "2000x2000"])
        .spawn()
        .unwrap();
    let mut start = [0; 2];
    fs::File::open(folder.path("pipe.ppm"))
        .unwrap()
        .read_exact(&mut start)
        .unwrap();
    let run = Run::new(child.wait_with_output().unwrap());
    assert_eq!((&start, run.code, run.stderr.as_str()), (b"P6", Some(1), ""));

    let run = folder.shell("{ \"$0\" a.scn -o - --size 2000x2000; echo $? > code; } | head -c 10 | wc -c");
    assert_eq!((run.text().trim(), run.stderr.as_str()), ("10", ""));
    // The compressed picture may have fitted into the pipe.
    let code = fs::read_to_string(folder.path("code")).unwrap();
    assert!(["0", "1"].contains(&code.trim()), "{code}");
    assert_eq!(folder.names(), ["a.scn", "code", "pipe.ppm"]);
}

#[test]
fn a_killed_program_leaves_no_partial_picture() {
    let folder = Folder::new();
    let arguments = ["a.scn", "-o", "a.bmp", "--size", "1000x1000", "--quiet"];
    let start = Instant::now();
    folder.run(&arguments).succeeded();
    let whole = start.elapsed();
    let expected = fs::read(folder.path("a.bmp")).unwrap();
    let mut random = fastrand::Rng::with_seed(1);
    let (mut complete, mut left) = (0, 0);
    for _ in 0..24 {
        fs::remove_file(folder.path("a.bmp")).unwrap_or_default();
        let mut child = folder.command(&arguments).spawn().unwrap();
        sleep(whole.mul_f32(random.f32() * 1.2));
        child.kill().unwrap();
        child.wait().unwrap();
        let names = folder.names();
        if names.iter().any(|name| name == "a.bmp") {
            complete += 1;
            assert!(
                fs::read(folder.path("a.bmp")).unwrap() == expected,
                "a partial picture"
            );
        }
        let temporary = names.iter().filter(|name| name.starts_with(".octray-")).count();
        assert!(temporary <= 1, "{names:?}");
        left += temporary;
    }
    println!("{complete} of 24 pictures were complete, {left} left a temporary file");
    folder.run(&arguments).succeeded();
    assert_eq!(folder.names(), ["a.bmp", "a.scn"]);
}

#[test]
fn the_temporary_file_of_a_killed_program_is_reused() {
    let folder = Folder::new();
    folder.run(&["a.scn", "-o", "a.bmp"]).succeeded();
    // The name of a temporary file, as a killed program leaves it: nobody locks it.
    let child = folder
        .command(&["a.scn", "-o", "a.bmp", "--size", "4000x4000"])
        .spawn()
        .unwrap();
    let start = Instant::now();
    let temporary = loop {
        let names = folder.names();
        if let Some(name) = names.iter().find(|name| name.starts_with(".octray-")) {
            break name.clone();
        }
        assert!(start.elapsed() < PATIENCE);
    };
    drop(Run::new(child.wait_with_output().unwrap()));
    fs::write(folder.path(&temporary), "half a picture").unwrap();
    folder.run(&["a.scn", "-o", "a.bmp"]).succeeded();
    assert_eq!(folder.names(), ["a.bmp", "a.scn"]);
}

fn write_mesh(path: &Path, triangles: usize) {
    let vertices = triangles * 3;
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\n\
         property float z\nelement face {triangles}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    .into_bytes();
    for i in 0..vertices {
        let (a, b) = ((i % 3) as f32, (i / 3) as f32 * 1e-4);
        for value in [a, b, a * a] {
            bytes.extend(value.to_le_bytes());
        }
    }
    for i in 0..triangles as u32 {
        bytes.push(3);
        for corner in 0..3 {
            bytes.extend((3 * i + corner).to_le_bytes());
        }
    }
    fs::write(path, bytes).unwrap();
}

#[test]
fn a_mesh_that_changes_while_it_is_read() {
    let folder = Folder::new();
    let path = folder.path("mesh.ply");
    folder.write("mesh.scn", "light 1 2 3 1\nply_file mesh.ply\n");
    // At least 5 MiB, which several threads read.
    write_mesh(&path, rounds(110_000, 200_000));
    let arguments = ["mesh.scn", "--size", "16x16"];
    let start = Instant::now();
    folder.run(&arguments).succeeded();
    let whole = start.elapsed();
    let good = fs::read(&path).unwrap();
    let mut random = fastrand::Rng::with_seed(2);
    let rounds = rounds(9, 60);
    let mut refused = 0;
    for round in 0..rounds {
        fs::write(&path, &good).unwrap();
        let child = folder.command(&arguments).spawn().unwrap();
        sleep(whole.mul_f32(random.f32()));
        match round % 3 {
            0 => OpenOptions::new()
                .write(true)
                .open(&path)
                .unwrap()
                .set_len(good.len() as u64 / 2)
                .unwrap(),
            1 => OpenOptions::new()
                .append(true)
                .open(&path)
                .unwrap()
                .write_all(&[1; 100_000])
                .unwrap(),
            _ => fs::remove_file(&path).unwrap(),
        }
        let run = Run::new(child.wait_with_output().unwrap());
        if run.code == Some(0) {
            run.succeeded();
        } else {
            refused += 1;
            assert!(run.stderr.starts_with("error: mesh.scn:2:10: "), "{run:?}");
            assert_eq!(run.code, Some(1), "{run:?}");
        }
    }
    println!("{refused} of {rounds} changed meshes were refused");
}

/// Compiles a library for `LD_PRELOAD`. Returns whether there is a compiler.
#[cfg(target_os = "linux")]
fn preload(folder: &Folder, source: &str) -> bool {
    folder.write("preload.c", source);
    let compiler = folder
        .any_command("cc", &["-shared", "-fPIC", "-o", "preload.so", "preload.c"])
        .status();
    let compiled = compiler.is_ok_and(|status| status.success());
    if !compiled {
        println!("skipped: this needs a C compiler, `cc`");
    }
    compiled
}

/// Runs the program with the library.
#[cfg(target_os = "linux")]
fn preloaded(folder: &Folder, arguments: &[&str]) -> Run {
    let mut command = folder.command(arguments);
    command.env("LD_PRELOAD", folder.path("preload.so"));
    Run::new(command.output().unwrap())
}

/// A network file system may report a full disk only on sync, so files that `--skip-existing` will trust are synced.
#[test]
#[cfg(target_os = "linux")]
fn a_disk_that_is_full_in_the_end() {
    let folder = Folder::new();
    let full = "#include <errno.h>\nint fsync(int file) { (void)file; errno = ENOSPC; return -1; }\n";
    if !preload(&folder, full) {
        return;
    }
    let left = folder.names();
    let arguments = ["a.scn", "-o", "a.png", "--aov", "depth", "--size", "9x9"];
    let run = preloaded(&folder, &[&arguments[..], &["--skip-existing"]].concat());
    run.failed(1, "cannot write a.depth.png: no space left on the device");
    assert_eq!(folder.names(), left);
    preloaded(&folder, &arguments).succeeded();
}

/// A library for `LD_PRELOAD` in which the time of day jumps by hours and years. The monotonic clock keeps its promise
/// never to jump.
const JUMPING_CLOCKS: &str = r"
#define _GNU_SOURCE
#include <sys/syscall.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>
static long jump(void) {
    static unsigned calls;
    static const long by[] = {0, 7200, -7200, 400000000, -300000000, 1, -86400};
    return 1000000000 + by[__atomic_fetch_add(&calls, 1, __ATOMIC_RELAXED) % 7];
}
int clock_gettime(clockid_t clock, struct timespec *now) {
    if (clock != CLOCK_REALTIME && clock != CLOCK_REALTIME_COARSE)
        return (int)syscall(SYS_clock_gettime, clock, now);
    now->tv_sec = jump();
    now->tv_nsec = 5;
    return 0;
}
int gettimeofday(struct timeval *restrict now, void *restrict zone) {
    (void)zone;
    now->tv_sec = jump();
    now->tv_usec = 5;
    return 0;
}
time_t time(time_t *now) {
    time_t then = jump();
    if (now) *now = then;
    return then;
}
";

#[test]
#[cfg(target_os = "linux")]
fn the_time_of_day_may_jump() {
    let folder = Folder::new();
    if !preload(&folder, JUMPING_CLOCKS) {
        return;
    }
    let jumping = |arguments: &[&str]| preloaded(&folder, arguments);
    let picture = ["a.scn", "--size", "100x100", "-o"];
    folder.run(&[&picture[..], &["a.png"]].concat()).succeeded();
    jumping(&[&picture[..], &["b.png"]].concat()).succeeded();
    let [a, b] = ["a.png", "b.png"].map(|name| fs::read(folder.path(name)).unwrap());
    assert!(a == b, "the picture changed");
    // The commands that read the clock most often.
    for arguments in [
        &["a.scn", "--size", "100x100", "--stats", "-o", "c.png"][..],
        &["verify", "--rays", "20000"],
        &["verify", "--seconds", "1"],
        &["bench", "a.scn", "--frames", "2", "--size", "64x64"],
    ] {
        let run = jumping(arguments);
        assert_eq!(run.code, Some(0), "{arguments:?}: {run:?}");
        assert!(!run.stderr.contains("panicked"), "{arguments:?}: {run:?}");
    }
}

/// Durations come from the monotonic clock; nothing reads the time of day.
#[test]
fn the_time_of_day_is_never_read() {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut folders = vec![package.join("src"), package.join("engine/src")];
    let mut files = 0;
    while let Some(folder) = folders.pop() {
        // A package holds no engine: that is a package of its own.
        for entry in fs::read_dir(folder).into_iter().flatten() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            files += 1;
            let text = fs::read_to_string(&path).unwrap_or_default();
            for clock in ["SystemTime", "UNIX_EPOCH", "CLOCK_REALTIME"] {
                assert!(!text.contains(clock), "{}: {clock}", path.display());
            }
        }
    }
    assert!(files > 100);
}

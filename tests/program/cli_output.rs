//! Outputs of pictures: files, folders, devices, pipes; nothing is left behind after a failure.
#![cfg(unix)]

use crate::{
    program::{Folder, PROGRAM, Run, on_a_terminal, send_signal},
    signals,
};
use std::{
    fs,
    io::Read,
    os::unix::fs::{FileTypeExt, PermissionsExt, symlink},
    thread::sleep,
    time::Duration,
};

fn mode(folder: &Folder, name: &str) -> u32 {
    fs::metadata(folder.path(name)).unwrap().permissions().mode() & 0o777
}

#[test]
fn the_extension_chooses_the_format() {
    let folder = Folder::new();
    let picture = |name: &str| {
        folder
            .run(&["a.scn", "--size", "37x23", "--view", "2", "-o", name])
            .succeeded();
        let picture = image::ImageReader::open(folder.path(name))
            .unwrap()
            .with_guessed_format()
            .unwrap();
        let format = picture.format().unwrap();
        (format, picture.decode().unwrap())
    };
    use image::ImageFormat as Format;
    let (format, png) = picture("a.png");
    assert_eq!((format, png.width(), png.height()), (Format::Png, 37, 23));
    for (name, expected) in [
        ("a.ppm", Format::Pnm),
        ("a.qoi", Format::Qoi),
        ("a.bmp", Format::Bmp),
        ("a.tiff", Format::Tiff),
        ("a.tif", Format::Tiff),
        ("UPPER.PNG", Format::Png),
    ] {
        let (format, lossless) = picture(name);
        assert_eq!(format, expected, "{name}");
        assert_eq!(lossless.to_rgb8(), png.to_rgb8(), "{name}");
    }
    for name in ["a.jpg", "a.jpeg"] {
        let (format, lossy) = picture(name);
        assert_eq!((format, lossy.width(), lossy.height()), (Format::Jpeg, 37, 23));
    }
    let (format, exr) = picture("a.exr");
    assert_eq!(format, Format::OpenExr);
    let (floats, bytes) = (exr.to_rgb32f(), png.to_rgb8());
    for (&float, &byte) in floats.iter().zip(bytes.iter()) {
        assert_eq!((float.clamp(0.0, 1.0) * 255.0) as u8, byte);
    }
}

#[test]
#[cfg(target_os = "linux")]
fn closed_standard_streams_are_failures() {
    let folder = Folder::new();
    let small = "--size=8x8";
    for arguments in [
        format!("a.scn {small} -o -"),
        format!("a.scn {small} --json -"),
        "info a.scn".into(),
        "info a.scn --json -".into(),
        format!("bench a.scn {small} --repeat 1"),
        "verify --rays 10".into(),
        "generate spheres --count 1000 -o made".into(),
        "generate spheres --count 1000 -o made --json -".into(),
        "completions bash".into(),
        "man".into(),
        "--help".into(),
        "--version".into(),
    ] {
        for closed in [">&-", ">/dev/full", "> /dev/null 1< /dev/null"] {
            let run = folder.shell(&format!("\"$0\" {arguments} {closed}"));
            run.failed(1, "cannot write standard output: ");
        }
        let run = folder.shell(&format!("\"$0\" {arguments} > /dev/null"));
        run.succeeded();
    }
    // A call that writes nothing there succeeds.
    folder.shell("\"$0\" a.scn -s 8x8 <&- >&-").succeeded();
    for input in ["<&-", "< /dev/null", "<&- >&-"] {
        for command in ["", "info "] {
            let run = folder.shell(&format!("\"$0\" {command}- {input}"));
            run.failed(1, "standard input: the input is empty");
        }
    }
    assert_eq!(folder.shell("\"$0\" --help 2>&1 | true").code, Some(0));
}

#[test]
fn standard_output_receives_a_png() {
    let folder = Folder::new();
    let run = folder.run(&["a.scn", "-o", "-", "--size", "5x3"]);
    let picture = image::load_from_memory(&run.succeeded().stdout).unwrap();
    assert_eq!((picture.width(), picture.height()), (5, 3));
    assert_eq!(folder.names(), ["a.scn"]);
}

#[test]
fn a_new_file_has_default_permissions() {
    let folder = Folder::new();
    folder.shell("umask 027; exec \"$0\" a.scn").succeeded();
    assert_eq!(mode(&folder, "a.png"), 0o640);
}

#[test]
fn permissions_and_links_are_kept() {
    let folder = Folder::new();
    folder.write("old.png", "old");
    fs::set_permissions(folder.path("old.png"), fs::Permissions::from_mode(0o604)).unwrap();
    symlink("old.png", folder.path("link.png")).unwrap();
    symlink("new.png", folder.path("dangling.png")).unwrap();
    folder.run(&["a.scn", "-o", "link.png"]).succeeded();
    folder.run(&["a.scn", "-o", "dangling.png"]).succeeded();
    // So it is with every kind of output.
    fs::create_dir(folder.path("there")).unwrap();
    for name in ["a.gif", "a.exr", "a.json", "poses.json"] {
        symlink(format!("there/{name}"), folder.path(name)).unwrap();
    }
    folder
        .run_line("a.scn --size=8x8 --turntable=2 -o a.gif")
        .succeeded();
    folder
        .run_line("a.scn --size=8x8 -o a.exr --json a.json --save-poses poses.json")
        .succeeded();
    for name in ["a.gif", "a.exr", "a.json", "poses.json"] {
        assert!(folder.path("there").join(name).is_file(), "{name}");
        assert!(fs::symlink_metadata(folder.path(name)).unwrap().is_symlink());
        fs::remove_file(folder.path(name)).unwrap();
    }
    fs::remove_dir_all(folder.path("there")).unwrap();
    assert_eq!(mode(&folder, "old.png"), 0o604);
    for name in ["link.png", "dangling.png"] {
        assert!(fs::symlink_metadata(folder.path(name)).unwrap().is_symlink());
    }
    image::open(folder.path("old.png")).unwrap();
    image::open(folder.path("new.png")).unwrap();
    assert_eq!(
        folder.names(),
        ["a.scn", "dangling.png", "link.png", "new.png", "old.png"]
    );
}

#[test]
fn unwritable_outputs_are_refused_before_rendering() {
    let folder = Folder::new();
    fs::create_dir(folder.path("folder.png")).unwrap();
    symlink("loop.png", folder.path("loop.png")).unwrap();
    folder.fails(&["a.scn", "-o", "folder.png"], 1, "it is a directory");
    folder.fails(&["a.scn", "-o", "."], 1, "it is a directory");
    folder.fails(&["a.scn", "-o", "new/"], 1, "such as new/{stem}.png");
    folder.fails(
        &["a.scn", "-o", "no/such/a.png"],
        1,
        "directory `no/such` does not exist",
    );
    if cfg!(target_os = "linux") {
        folder.fails(
            &["a.scn", "-o", "/proc/a.png"],
            1,
            "its directory does not accept new files",
        );
    }
    folder.fails(
        &["a.scn", "-o", "a.scn/a.png"],
        1,
        "`a.scn` is a file, expected a directory",
    );
    folder.fails(&["a.scn", "-o", "loop.png"], 1, "symbolic links");
    folder.fails(
        &["a.scn", "-o", &format!("{}.png", "n".repeat(300))],
        1,
        "too long",
    );
    folder.fails(&["a.scn", "-o", ""], 2, "");
}

#[test]
fn the_scene_is_not_overwritten() {
    let folder = Folder::new();
    for name in ["scene.png", "scene.ppm"] {
        folder.write(name, "sphere 0 0 0.5 0.5\n");
    }
    folder.fails(&["./scene.ppm", "-o", "scene.ppm"], 2, "would replace the scene");
    // The name of a picture is refused as a scene, whatever the file holds.
    folder.fails(&["scene.png"], 1, "unknown file type");
    for name in ["scene.png", "scene.ppm"] {
        assert_eq!(
            fs::read_to_string(folder.path(name)).unwrap(),
            "sphere 0 0 0.5 0.5\n"
        );
    }
}

#[test]
fn read_only_folders_and_files() {
    let folder = Folder::new();
    fs::create_dir(folder.path("locked")).unwrap();
    folder.write("locked.png", "old");
    for name in ["locked", "locked.png"] {
        fs::set_permissions(folder.path(name), fs::Permissions::from_mode(0o555)).unwrap();
    }
    if fs::write(folder.path("locked/probe"), "").is_ok() {
        println!("skipped: this user may write to read-only folders");
        return;
    }
    folder.fails(&["a.scn", "-o", "locked/a.png"], 1, "permission denied");
    folder.fails(&["a.scn", "-o", "locked.png"], 1, "permission denied");
    assert_eq!(fs::read_to_string(folder.path("locked.png")).unwrap(), "old");
}

#[test]
fn a_failed_write_leaves_the_old_file() {
    let folder = Folder::new();
    folder.write("a.bmp", "old");
    // At most 8 blocks per file; the picture needs many more.
    let run = folder.shell("ulimit -f 8; exec \"$0\" a.scn -o a.bmp");
    run.failed(1, "cannot write a.bmp: the file would be too large");
    assert_eq!(folder.names(), ["a.bmp", "a.scn"]);
    assert_eq!(fs::read_to_string(folder.path("a.bmp")).unwrap(), "old");
}

#[test]
#[cfg(target_os = "linux")]
fn devices_are_written_through() {
    let folder = Folder::new();
    folder.run(&["a.scn", "-o", "/dev/null"]).succeeded();
    assert!(fs::metadata("/dev/null").unwrap().file_type().is_char_device());
    folder.fails(&["a.scn", "-o", "/dev/full"], 1, "no space left");
    assert!(fs::metadata("/dev/full").unwrap().file_type().is_char_device());
    let piped = folder.shell("\"$0\" a.scn --size 5x3 -o /dev/stdout | cat");
    assert!(piped.succeeded().stdout.starts_with(b"\x89PNG"));
    folder
        .shell("\"$0\" a.scn -o - > /dev/full")
        .failed(1, "cannot write standard output: no space");
    folder
        .shell("\"$0\" info a.scn > /dev/full")
        .failed(1, "cannot write standard output: no space");
}

#[test]
fn a_named_pipe_is_written_through() {
    let folder = Folder::new();
    if !folder.make_pipe("pipe.ppm") {
        return;
    }
    let child = folder
        .command(&["a.scn", "-o", "pipe.ppm", "--size", "5x3"])
        .spawn()
        .unwrap();
    let mut bytes = Vec::new();
    fs::File::open(folder.path("pipe.ppm"))
        .unwrap()
        .read_to_end(&mut bytes)
        .unwrap();
    Run::new(child.wait_with_output().unwrap()).succeeded();
    assert!(bytes.starts_with(b"P6"));
    assert!(
        fs::metadata(folder.path("pipe.ppm"))
            .unwrap()
            .file_type()
            .is_fifo()
    );
}

#[test]
fn a_closed_pipe_is_no_error_message() {
    let folder = Folder::new();
    // More bytes than a pipe holds, so that the program notices.
    let mut child = folder
        .command(&["a.scn", "-o", "-", "--size", "2000x2000"])
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let run = Run::new(child.wait_with_output().unwrap());
    assert_eq!((run.code, run.stderr.as_str()), (Some(1), ""));
    for arguments in ["--help", "info a.scn", "info a.scn --json -", "--version"] {
        let run = folder.shell(&format!("(sleep 0.2; \"$0\" {arguments}) | true"));
        assert_eq!(run.stderr, "", "{arguments}");
    }
}

#[test]
fn a_signal_ends_a_program_that_waits_for_a_reader() {
    let folder = Folder::new();
    if !folder.make_pipe("pipe.png") {
        return;
    }
    for signal in signals::ending() {
        let child = folder.command(&["a.scn", "-o", "pipe.png"]).spawn().unwrap();
        sleep(Duration::from_millis(500));
        send_signal(&child, signal);
        let run = Run::new(child.wait_with_output().unwrap());
        run.died_of(signal);
    }
}

/// A terminal shows that octray waits for a pipe, also before the pipe gives anything.
#[test]
fn a_terminal_shows_that_a_pipe_is_read() {
    let folder = Folder::new();
    folder.write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let call = format!("--version > /dev/null; (sleep 0.7; cat m.obj) | {PROGRAM} - -s 8 -o m.png");
    let Some(run) = on_a_terminal(&folder, &call) else {
        return;
    };
    let text = run.succeeded().text();
    assert!(text.contains("loading standard input  0 s"), "{text:?}");
    assert!(text.contains("wrote m.png"), "{text:?}");
    let run = on_a_terminal(&folder, &format!("{call} --quiet")).expect("script is installed");
    assert_eq!(run.succeeded().text(), "");
}

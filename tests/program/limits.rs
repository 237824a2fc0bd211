//! Limits: a picture or scene that is too large is refused in one sentence, before the work begins.
//!
//! `OCTRAY_LONG=1` adds the limit of placed meshes, and doubles the depth of hierarchies.
#![cfg(unix)]

use crate::{
    long::{is_long, rounds},
    program::{Folder, Run},
};
use std::{fs, io::Write};

/// Limits the address space, in KiB, in case a check fails.
const ULIMIT: &str = "ulimit -v 4000000";

/// A mesh that repeats one triangle.
fn write_mesh(folder: &Folder, name: &str, triangles: usize) {
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
         element face {triangles}\nproperty list uchar uchar vertex_indices\nend_header\n"
    )
    .into_bytes();
    for value in [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.5] {
        bytes.extend(value.to_le_bytes());
    }
    bytes.extend([3, 0, 1, 2].repeat(triangles));
    fs::write(folder.path(name), bytes).unwrap();
}

/// A sparse file of this length.
fn write_sparse(folder: &Folder, name: &str, length: u64) {
    fs::File::create(folder.path(name))
        .unwrap()
        .set_len(length)
        .unwrap();
}

fn refused(folder: &Folder, script: &str, words: &[&str]) {
    let before = folder.names();
    let run = folder.shell(&format!("{ULIMIT}; {script}"));
    assert_eq!(run.code, Some(1), "{script}: {run:?}");
    for word in words {
        assert!(run.stderr.contains(word), "{script}: expected {word:?}: {run:?}");
    }
    assert_eq!(run.stderr.matches("error:").count(), 1, "{script}: {run:?}");
    assert_eq!(folder.names(), before, "{script}");
}

#[test]
fn too_large_inputs_are_refused_before_the_work() {
    let folder = Folder::new();
    write_mesh(&folder, "mesh.ply", 500_000);
    write_mesh(&folder, "more.ply", 1_000_000);
    write_sparse(&folder, "large.ply", 1 << 30);
    write_sparse(&folder, "facets.stl", 84 + 50 * 20_000_000);
    let stl = fs::OpenOptions::new().write(true).open(folder.path("facets.stl"));
    let header = [[0; 80].as_slice(), &20_000_000_u32.to_le_bytes()].concat();
    stl.unwrap().write_all(&header).unwrap();
    folder.write("mesh.scn", "light 1 2 3 1\nply_file mesh.ply\n");
    for (script, words) in [
        // Pictures of several formats.
        (
            "\"$0\" a.scn --size 16384x16384 --max-memory 1G",
            &["a picture of 16384x16384 needs about", "1.0 GiB"][..],
        ),
        (
            "\"$0\" a.scn --size 16384x16384 -o a.exr --aov depth",
            &["a picture of 16384x16384 needs about"],
        ),
        (
            "\"$0\" a.scn --size 9000x9000 -o a.exr --max-memory 1500M",
            &["a picture of 9000x9000 needs about"],
        ),
        // A mesh in a scene and by itself.
        (
            "\"$0\" mesh.scn --max-memory 32M",
            &["mesh.scn:2:10: cannot load mesh.ply", "the scene takes about"],
        ),
        (
            "\"$0\" mesh.ply --max-memory 32M",
            &["error: mesh.ply: the scene takes about", "or more, BVH included"],
        ),
        (
            "\"$0\" info mesh.ply --max-memory 32M",
            &["error: mesh.ply: the scene takes about"],
        ),
        // The process's own limit counts, too, and --max-memory does not raise it.
        (
            "ulimit -v 200000; \"$0\" more.ply",
            &["error: more.ply: the scene takes about"],
        ),
        (
            "ulimit -v 200000; \"$0\" more.ply --max-memory 100G",
            &["error: more.ply: the scene takes about"],
        ),
        // By the file's length, before it is read.
        (
            "\"$0\" large.ply --max-memory 512M",
            &["large.ply: the file has 1.0 GiB, above the memory limit of"],
        ),
        // By the counts in the file's header, before the rest is read.
        (
            "\"$0\" facets.stl --max-memory 2G",
            &["facets.stl: the scene takes about 2.8 GiB"],
        ),
    ] {
        refused(&folder, script, words);
    }
    folder
        .run(&["mesh.scn", "--max-memory", "512M", "--quiet"])
        .succeeded();
}

/// Under any limit on the address space there is a picture or one sentence.
#[test]
fn any_limit_on_the_address_space() {
    let folder = Folder::new();
    write_mesh(&folder, "mesh.ply", 300_000);
    folder.write("mesh.scn", "light 1 2 3 1\nply_file mesh.ply\n");
    let (mut made, mut said) = (0, 0);
    for kibibytes in (100_000..=500_000).step_by(rounds(80_000, 40_000)) {
        let script = format!("ulimit -v {kibibytes}; exec \"$0\" mesh.scn --size 64x64 --quiet");
        let run = folder.shell(&script);
        match run.code {
            Some(0) => made += 1,
            Some(1) if run.stderr.starts_with("error: ") => said += 1,
            _ => panic!("{kibibytes}: {run:?}"),
        }
    }
    assert!(made > 0 && said > 0, "{made} pictures, {said} refusals");
}

#[test]
fn huge_values_are_refused_by_name() {
    let folder = Folder::new();
    for (arguments, code, words) in [
        (
            "--size 31623x31623",
            1,
            "a picture of 31623x31623 has more than 268435456 pixels",
        ),
        (
            "--size 10000000x1",
            1,
            "a picture of 10000000x1: expected at most 8388608 pixels along a side",
        ),
        ("--samples 1000000000", 1, "1000000000 samples for each pixel"),
        ("--max-depth 1000000000", 2, "--max-depth"),
        ("--turntable 1000000000", 2, "--turntable"),
        ("--threads 1000000000", 2, "--threads"),
        ("--max-memory 0", 2, "--max-memory"),
    ] {
        let mut all = vec!["a.scn"];
        all.extend(arguments.split(' '));
        folder.fails(&all, code, words);
    }
}

#[test]
fn scenes_have_documented_limits() {
    let folder = Folder::new();
    let lights = |count: usize| "light 1 2 3 0.001\n".repeat(count) + "sphere 0 0 0.5 0.5\n";
    folder.write("lights.scn", &lights(1024));
    folder.run(&["lights.scn", "--size", "4x4"]).succeeded();
    folder.write("lights.scn", &lights(1025));
    refused(
        &folder,
        "\"$0\" lights.scn",
        &["lights.scn:1025:1: more than 1024 lights"],
    );

    folder.write("included.scn", "");
    folder.write("includes.scn", &"include included.scn\n".repeat(1025));
    refused(
        &folder,
        "\"$0\" includes.scn",
        &["includes.scn:1025:9: more than 1024 includes in one scene"],
    );

    for depth in 0..=17 {
        folder.write(
            &format!("deep{depth}.scn"),
            &format!("include deep{}.scn\n", depth + 1),
        );
    }
    refused(&folder, "\"$0\" deep0.scn", &["includes nest more than 16 deep"]);

    folder.write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder.write("again.scn", &"mesh m.obj\n".repeat(65_537));
    refused(
        &folder,
        "\"$0\" again.scn",
        &["again.scn:65537:6: more than 65536 placed meshes"],
    );
    if !is_long() {
        println!("skipped: OCTRAY_LONG tests the limit of placed meshes, each of which is read");
        return;
    }
    let copies: String = (0..=1 << 16)
        .map(|i| format!("mesh m.obj translate {i} 0 0\n"))
        .collect();
    folder.write("meshes.scn", &copies);
    refused(
        &folder,
        "\"$0\" meshes.scn",
        &["meshes.scn:65537:6: more than 65536 placed meshes"],
    );
}

/// Nested shapes make the deepest trees, and rays that meet all of them the fullest traversal stacks.
#[test]
fn deep_hierarchies_do_not_overflow_stacks() {
    let folder = Folder::new();
    let mut file = fs::File::create(folder.path("deep.scn")).unwrap();
    writeln!(file, "light 3 -2 5 0.7\nmaterial 1").unwrap();
    let count = rounds(6_000, 20_000);
    for i in 0..count {
        let size = 1e-8 * 1.0018_f64.powi(i * 20_000 / count);
        writeln!(file, "triangle 0 0 0 {size:e} 0 {size:e} 0 {size:e} {size:e}").unwrap();
    }
    drop(file);
    // Threads with small stacks. (The main thread's is larger, since clap's unoptimised code fills 256 KiB.)
    let script = format!("{ULIMIT}; ulimit -s 512; RUST_MIN_STACK=262144 exec \"$0\" deep.scn --size 4x4");
    for mode in ["packet", "scalar"] {
        let run: Run = folder.shell(&format!("{script} --mode {mode} -o {mode}.png"));
        run.succeeded();
    }
    assert!(fs::read(folder.path("packet.png")).unwrap() == fs::read(folder.path("scalar.png")).unwrap());
}

/// A process that may not start threads says so.
#[test]
#[cfg(target_os = "linux")]
fn no_threads() {
    let folder = Folder::new();
    fs::set_permissions(
        folder.path("."),
        std::os::unix::fs::PermissionsExt::from_mode(0o777),
    )
    .unwrap();
    // The limit does not apply to the super-user.
    let script = "command -v setpriv >/dev/null || exit 77
        setpriv --reuid 65534 --regid 65534 --clear-groups bash -c 'ulimit -u 1 && exec \"$0\" a.scn' \"$0\"";
    let run = folder.shell(script);
    if run.stderr.contains("cannot start threads") {
        run.failed(1, "cannot start threads: ");
    } else {
        assert!(!run.stderr.contains("panicked"), "{run:?}");
        println!("skipped: this user cannot forbid threads: {run:?}");
    }
}

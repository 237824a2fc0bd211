//! Runs the fuzz targets on a stable compiler, on all seeds and on every input that once failed.

use crate::long::rounds;
use std::{fs, path::Path};

/// Runs every file of `folder/TARGET/` through TARGET.
fn replay(folder: &str) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let Ok(entries) = fs::read_dir(&folder) else {
        println!("skipped: {} is not there", folder.display());
        return;
    };
    for entry in entries {
        let entry = entry.expect("a readable folder");
        let name = entry.file_name();
        // A README may be beside the folders.
        if !entry.path().is_dir() {
            continue;
        }
        if name == "arguments" && cfg!(not(feature = "cli")) {
            continue;
        }
        let target = crate::targets::by_name(&name.to_string_lossy())
            .unwrap_or_else(|| panic!("{} names no target", entry.path().display()));
        for input in fs::read_dir(entry.path()).expect("a readable folder") {
            let path = input.expect("a readable folder").path();
            println!("{}", path.display());
            target(&fs::read(&path).expect("a readable file"));
        }
    }
}

#[test]
fn seeds() {
    replay("fuzz/seeds");
}

#[test]
fn regressions() {
    replay("tests/regressions");
}

/// `OCTRAY_SEEDS=1 cargo test replay` writes the generated seeds.
#[test]
fn generated_seeds_are_current() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds");
    if !folder.exists() {
        println!("skipped: {} is not there", folder.display());
        return;
    }
    for (target, name, bytes) in crate::seeds::all() {
        let path = folder.join(target).join(&name);
        if std::env::var_os("OCTRAY_SEEDS").is_some() {
            fs::create_dir_all(folder.join(target)).expect("a folder");
            fs::write(&path, &bytes).expect("written");
        }
        let found = fs::read(&path).unwrap_or_default();
        assert!(
            found == bytes,
            "{} differs from tests/library/seeds.rs: OCTRAY_SEEDS=1 writes it",
            path.display()
        );
    }
}

/// Random inputs for the targets that read bytes as choices; `OCTRAY_LONG=1` tries many more.
#[test]
fn random_bytes() {
    let mut random = fastrand::Rng::with_seed(7);
    for name in ["scn_grammar", "ply_grammar", "picture", "mesh_grammar"] {
        let target = crate::targets::by_name(name).expect("a target");
        for round in 0..rounds(100, 50_000) {
            let bytes: Vec<u8> = (0..random.usize(1..600)).map(|_| random.u8(..)).collect();
            println!("{name}, round {round}");
            target(&bytes);
        }
    }
}

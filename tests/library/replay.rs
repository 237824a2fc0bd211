//! The fuzz targets on a stable compiler: all seeds, and every input that once failed.

use std::{fs, path::Path};

/// Runs every file of `folder/TARGET/` through its target.
fn replay(folder: &str) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let Ok(entries) = fs::read_dir(&folder) else {
        println!("skipped: {} is not there", folder.display());
        return;
    };
    for entry in entries {
        let entry = entry.expect("a readable folder");
        let name = entry.file_name();
        // Beside the folders there may be a README.
        if !entry.path().is_dir() {
            continue;
        }
        if name == "arguments" && cfg!(not(feature = "cli")) {
            continue;
        }
        let target = crate::targets::by_name(&name.to_string_lossy())
            .unwrap_or_else(|| panic!("{} belongs to no target", entry.path().display()));
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

/// `OCTRAY_SEEDS=1 cargo test --test replay` writes what `tests/seeds` makes; else it must be there already.
#[test]
fn seeds_are_what_the_program_makes() {
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
        assert!(found == bytes, "{} is not what tests/seeds makes", path.display());
    }
}

/// Random bytes, so that a target that always fails is noticed without a fuzzer; `OCTRAY_LONG=1` makes many more.
#[test]
fn random_bytes() {
    let mut random = fastrand::Rng::with_seed(7);
    let rounds = if std::env::var_os("OCTRAY_LONG").is_some() {
        50_000
    } else {
        300
    };
    for name in ["scn_grammar", "ply_grammar", "picture"] {
        let target = crate::targets::by_name(name).expect("a target");
        for round in 0..rounds {
            let bytes: Vec<u8> = (0..random.usize(1..600)).map(|_| random.u8(..)).collect();
            println!("{name}, round {round}");
            target(&bytes);
        }
    }
}

//! The fuzz targets on a stable compiler: all seeds, and every input that once failed.

mod targets;

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
        let target = targets::by_name(&name.to_string_lossy())
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

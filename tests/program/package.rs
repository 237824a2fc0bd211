//! What `cargo package` would ship, and what octray's dependencies ask for. (Licences and duplicates: `deny.toml`.)

use serde_json::Value;
use std::{fs, path::Path, process::Command};

/// A whole package is at most so many bytes, and a file of it.
const MOST_BYTES: u64 = 5_000_000;
const MOST_FILE_BYTES: u64 = 400_000;

fn package() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// What cargo prints, in the package's folder and without a network.
fn cargo(arguments: &[&str]) -> String {
    let mut command = Command::new(env!("CARGO"));
    let output = command
        .args(arguments)
        .args(["--offline", "--locked"])
        .current_dir(package())
        .output();
    let output = output.expect("cargo runs");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "cargo {arguments:?}: {stderr}");
    String::from_utf8(output.stdout).expect("UTF-8")
}

#[test]
fn the_package_holds_what_it_should() {
    if !package().join(".ci").exists() {
        println!("skipped: this is a package itself, not a checkout");
        return;
    }
    let list = cargo(&["package", "--list", "--allow-dirty"]);
    let files: Vec<&str> = list.lines().collect();
    for needed in [
        "Cargo.toml",
        "Cargo.lock",
        "README.md",
        "LICENSE-MIT",
        "LICENSE-APACHE",
        "src/lib.rs",
        "src/main.rs",
    ] {
        assert!(files.contains(&needed), "{needed} is missing");
    }
    let mut total = 0;
    for file in files {
        let unwanted = ["fuzz/", ".ci/", "target/", "tests/regressions/crash"];
        assert!(
            !unwanted.iter().any(|start| file.starts_with(start)),
            "{file} is no part of the package"
        );
        // Files that cargo makes up are not there.
        let bytes = fs::metadata(package().join(file)).map_or(0, |file| file.len());
        assert!(bytes <= MOST_FILE_BYTES, "{file}: {bytes} bytes");
        total += bytes;
    }
    assert!(total <= MOST_BYTES, "{total} bytes");
}

/// "1.95" and "1.95.0" as numbers.
fn version(text: &str) -> Vec<u32> {
    let mut parts: Vec<u32> = text
        .split('.')
        .map(|part| part.parse().expect("a number"))
        .collect();
    parts.resize(3, 0);
    parts
}

#[test]
fn dependencies_come_from_the_registry() {
    let lock = fs::read_to_string(package().join("Cargo.lock")).expect("Cargo.lock is read");
    let lock: toml::Table = lock.parse().expect("TOML");
    let packages = lock["package"].as_array().expect("packages");
    assert!(packages.len() > 100);
    for dependency in packages {
        let name = dependency["name"].as_str().expect("a name");
        if name != "octray" {
            let source = dependency
                .get("source")
                .and_then(toml::Value::as_str)
                .unwrap_or("a folder");
            assert_eq!(
                source, "registry+https://github.com/rust-lang/crates.io-index",
                "{name}"
            );
        }
    }
}

/// Those that this test was built with: others may not have been downloaded.
#[test]
fn dependencies_ask_for_no_newer_rust() {
    let about = Command::new(env!("CARGO"))
        .arg("-vV")
        .output()
        .expect("cargo runs");
    let about = String::from_utf8(about.stdout).expect("UTF-8");
    let host = about.lines().find_map(|line| line.strip_prefix("host: "));
    let host = host.expect("cargo tells its host");
    let metadata = cargo(&["metadata", "--format-version", "1", "--filter-platform", host]);
    let metadata: Value = serde_json::from_str(&metadata).expect("JSON");
    let ours = version(env!("CARGO_PKG_RUST_VERSION"));
    let packages = metadata["packages"].as_array().expect("packages");
    assert!(packages.len() > 100);
    for dependency in packages {
        if let Some(theirs) = dependency["rust_version"].as_str() {
            let name = &dependency["name"];
            assert!(version(theirs) <= ours, "{name} needs Rust {theirs}");
        }
    }
}

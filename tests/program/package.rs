//! What `cargo package` ships and what the dependencies need. (Licences and duplicates: `deny.toml`.)

use serde_json::Value;
use std::{collections::BTreeSet, fs, path::Path, process::Command};

/// Limits for both packages together, nearly all of it source, and for one file.
const MAX_BYTES: u64 = 3_950_000;
const MAX_FILE_BYTES: u64 = 100_000;

fn package() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Standard output of a command that runs in the package's folder, or what it says on failure.
fn output(program: &str, arguments: &[&str]) -> Result<String, String> {
    let output = Command::new(program)
        .args(arguments)
        .current_dir(package())
        .output()
        .map_err(|error| error.to_string())?;
    if output.status.success() {
        String::from_utf8(output.stdout).map_err(|error| error.to_string())
    } else {
        Err(String::from_utf8_lossy(&output.stderr).into_owned())
    }
}

fn cargo(arguments: &[&str]) -> String {
    let arguments = [arguments, &["--offline", "--locked"]].concat();
    output(env!("CARGO"), &arguments).unwrap_or_else(|error| panic!("cargo {arguments:?}: {error}"))
}

/// Files of the packages `octray` and `octray-engine`, the latter's in `engine/`. Those that a user rendered or generated in
/// the checkout are not git's and do not count.
fn packaged_files() -> BTreeSet<String> {
    let tracked = output("git", &["ls-files"]).ok();
    let tracked: Option<BTreeSet<&str>> = tracked.as_ref().map(|list| list.lines().collect());
    let list = |name| cargo(&["package", "--list", "--allow-dirty", "-p", name]);
    let engine = list("octray-engine");
    let engine = engine.lines().map(|file| format!("engine/{file}"));
    list("octray")
        .lines()
        .map(str::to_owned)
        .chain(engine)
        .filter(|file| {
            tracked
                .as_ref()
                .is_none_or(|tracked| tracked.contains(file.as_str()))
        })
        .collect()
}

/// Files of this package that a Markdown text shows as pictures.
fn pictures(text: &str) -> BTreeSet<String> {
    let links = text
        .split("](")
        .skip(1)
        .filter_map(|rest| rest.split_once(')'))
        .map(|(link, _)| link);
    let sources = text
        .split("src=\"")
        .skip(1)
        .filter_map(|rest| rest.split_once('"'))
        .map(|(link, _)| link);
    links
        .chain(sources)
        .filter(|link| {
            let extension = Path::new(link)
                .extension()
                .and_then(|extension| extension.to_str());
            matches!(extension, Some("png" | "jpg")) && !link.contains("://")
        })
        .map(str::to_owned)
        .collect()
}

#[test]
fn the_package_holds_what_its_users_need() {
    if !package().join(".ci").exists() {
        println!("skipped: this is a package itself, not a checkout");
        return;
    }
    let files = packaged_files();
    for needed in [
        "Cargo.toml",
        "Cargo.lock",
        "README.md",
        "CHANGELOG.md",
        "LICENSE-MIT",
        "LICENSE-APACHE",
        "src/lib.rs",
        "src/main.rs",
        "engine/Cargo.toml",
        "engine/src/lib.rs",
        "docs/scene-language.md",
        // The crate's first example loads it.
        "scenes/reflections.scn",
        "scenes/parts/pines.txt",
    ] {
        assert!(files.contains(needed), "{needed} is missing");
    }
    let readme = fs::read_to_string(package().join("README.md")).expect("README.md");
    let shown = pictures(&readme);
    assert!(!shown.is_empty(), "README.md shows no pictures");
    for picture in shown {
        assert!(
            files.contains(&picture),
            "README.md shows {picture}, which is missing"
        );
    }
    let mut total = 0;
    for file in &files {
        for folder in [".ci/", "benches/", "fuzz/", "target/", "tests/"] {
            assert!(!file.starts_with(folder), "{file} does not belong in the package");
        }
        let bytes = fs::metadata(package().join(file)).map_or(0, |file| file.len());
        assert!(bytes <= MAX_FILE_BYTES, "{file}: {bytes} bytes");
        total += bytes;
    }
    assert!(total <= MAX_BYTES, "{total} bytes");
}

#[test]
fn dependencies_come_from_a_registry() {
    let lock = fs::read_to_string(package().join("Cargo.lock")).expect("Cargo.lock");
    let lock: toml::Table = lock.parse().expect("TOML");
    let packages = lock["package"].as_array().expect("packages");
    assert!(packages.len() > 100);
    for dependency in packages {
        let name = dependency["name"].as_str().expect("a name");
        // A dependency from a folder has no source, one from git begins with `git+`.
        let source = dependency.get("source").and_then(toml::Value::as_str);
        assert!(
            ["octray", "octray-engine"].contains(&name)
                || source.is_some_and(|source| source.starts_with("registry+")),
            "{name}: {source:?}"
        );
    }
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

/// Only this system's dependencies: others may not have been downloaded.
#[test]
fn dependencies_need_no_newer_rust() {
    let about = output(env!("CARGO"), &["-vV"]).expect("cargo's version");
    let host = about.lines().find_map(|line| line.strip_prefix("host: "));
    let host = host.expect("a host");
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

//! The documents' links lead somewhere, and each document keeps the size that suits its readers.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

fn package() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// All files with that extension in these folders, and folders below.
fn files(folders: &[&str], extension: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut todo: Vec<PathBuf> = folders.iter().map(|folder| package().join(folder)).collect();
    while let Some(folder) = todo.pop() {
        for entry in fs::read_dir(&folder).into_iter().flatten() {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                todo.push(path);
            } else if path.extension().is_some_and(|found| found == extension) {
                found.push(path);
            }
        }
    }
    found
}

fn documents() -> Vec<PathBuf> {
    let top = [
        "README.md",
        "ARCHITECTURE.md",
        "CHANGELOG.md",
        "CONTRIBUTING.md",
        "SECURITY.md",
    ];
    let top = top.iter().map(|name| package().join(name));
    let mut all = files(&["docs", "benches"], "md");
    all.extend(top.filter(|path| path.exists()));
    all
}

/// GitHub's anchor of a heading.
fn anchor(heading: &str) -> String {
    let kept = heading.to_lowercase();
    kept.chars()
        .filter(|&c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'))
        .map(|c| if c == ' ' { '-' } else { c })
        .collect()
}

fn anchors(document: &Path) -> BTreeSet<String> {
    let text = fs::read_to_string(document).expect("a document");
    let headings = text.lines().filter(|line| line.starts_with('#'));
    headings
        .map(|line| anchor(line.trim_start_matches('#').trim()))
        .collect()
}

#[test]
fn links_lead_somewhere() {
    for document in documents() {
        let text = fs::read_to_string(&document).expect("a document");
        for link in text.split("](").skip(1) {
            let link = link.split(')').next().unwrap_or_default();
            if link.contains("://") {
                continue;
            }
            let (path, part) = link.split_once('#').unwrap_or((link, ""));
            let target = if path.is_empty() {
                document.clone()
            } else {
                document.parent().expect("a folder").join(path)
            };
            // A package holds no tests and no benches.
            let is_package = !package().join("fuzz").exists();
            assert!(target.exists() || is_package, "{}: {link}", document.display());
            if !part.is_empty() && target.exists() {
                assert!(anchors(&target).contains(part), "{}: {link}", document.display());
            }
        }
    }
}

#[test]
fn code_names_lab_notes_that_exist() {
    let notes = anchors(&package().join("docs/lab-notes.md"));
    for file in files(&["src", "engine/src", "benches"], "rs") {
        let text = fs::read_to_string(&file).expect("a source");
        for name in text.split("docs/lab-notes.md#").skip(1) {
            let name: String = name
                .chars()
                .take_while(|&c| c.is_ascii_alphanumeric() || c == '-')
                .collect();
            assert!(notes.contains(&name), "{}: {name}", file.display());
        }
    }
}

#[test]
fn documents_are_as_long_as_their_readers_are_patient() {
    for (name, most) in [("README.md", 200), ("ARCHITECTURE.md", 300)] {
        let text = fs::read_to_string(package().join(name)).expect("a document");
        assert!(text.lines().count() <= most, "{name}");
    }
}

//! Error reports, word for word: every case of `tests/errors/*.txt` is a scene or a mesh and the report that refuses it.
//! `OCTRAY_BLESS=1 cargo test --test library errors::` rewrites the reports; read the difference before you commit it.
//!
//! A case is a name, the files and the report:
//! ```text
//! ==== a radius of zero
//! sphere 0 0 0 0
//! ---- mesh.ply          (a mesh or a part that the case names)
//! ...
//! ---- report
//! case.scn:1:14: radius is 0, expected a number above 0
//! ...
//! ```
//! `\xNN` stands for a byte. Cases of `formats.txt` have no scene: the first file is a mesh, and files that it names
//! follow. If `a.3mf` is empty, the others are its parts.

use crate::targets::archive;
use octray::format::{load_from_bytes, mesh};
use std::{collections::HashMap, env, fs, io, path::Path};

/// The lines of a case before its report, and the report.
struct Case {
    head: String,
    report: String,
}

fn cases(text: &str) -> Vec<Case> {
    text.split("==== ")
        .skip(1)
        .map(|case| {
            let (head, report) = case.split_once("---- report\n").unwrap_or((case, ""));
            Case {
                head: head.to_owned(),
                report: report.trim_end().to_owned(),
            }
        })
        .collect()
}

/// Turns `\xNN` into bytes.
fn bytes(text: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut parts = text.split("\\x");
    bytes.extend(parts.next().unwrap_or_default().bytes());
    for part in parts {
        let (hex, rest) = part.split_at(2);
        bytes.push(u8::from_str_radix(hex, 16).expect("two hexadecimal digits"));
        bytes.extend(rest.bytes());
    }
    bytes
}

fn report(head: &str) -> String {
    let (_name, files) = head.split_once('\n').expect("a name and a scene");
    let mut parts = files.split("---- ");
    let scene = parts.next().unwrap_or_default();
    let files: Vec<(&str, &str)> = parts
        .map(|part| part.split_once('\n').expect("a file's name and its lines"))
        .collect();
    let open = &mut |path: &Path| {
        let given = files.iter().find(|(name, _)| path.to_str() == Some(name));
        match given {
            Some((_, text)) => Ok(bytes(text)),
            None if path == Path::new("locked.ply") => Err(io::ErrorKind::PermissionDenied.into()),
            None => Err(io::ErrorKind::NotFound.into()),
        }
    };
    match load_from_bytes(&bytes(scene), Path::new("case.scn"), open) {
        Ok(_) => "loaded without an error".to_owned(),
        Err(error) => error.report(),
    }
}

/// The report of a mesh and the files that it names.
fn mesh_report(head: &str) -> String {
    let files: Vec<(&str, Vec<u8>)> = head
        .split("---- ")
        .skip(1)
        .map(|file| {
            let (name, text) = file.split_once('\n').expect("a name and a file");
            (name, bytes(text.trim_end()))
        })
        .collect();
    let (name, mut first) = files.first().expect("a mesh").clone();
    if name == "a.3mf" && first.is_empty() {
        // The others are its parts.
        first = archive::stored(files.iter().skip(1).map(|(name, part)| (*name, &part[..])));
    }
    let mut others: HashMap<&str, Vec<u8>> = files.into_iter().collect();
    let open = &mut |path: &Path| {
        let found = path.to_str().and_then(|name| others.remove(name));
        found.ok_or_else(|| io::ErrorKind::NotFound.into())
    };
    match mesh::parse(first, Path::new(name), open) {
        Ok(_) => "loaded without an error".to_owned(),
        Err(error) => error.report(),
    }
}

#[test]
fn reports_are_as_agreed() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/errors");
    let bless = env::var_os("OCTRAY_BLESS").is_some();
    let mut differences = 0;
    for file in [
        "scene.txt",
        "language.txt",
        "mesh.txt",
        "instances.txt",
        "motion.txt",
        "formats.txt",
    ] {
        let path = folder.join(file);
        let text = fs::read_to_string(&path).expect("a readable file");
        let mut blessed = String::new();
        for Case {
            head,
            report: expected,
        } in cases(&text)
        {
            let found = if file == "formats.txt" {
                mesh_report(&head)
            } else {
                report(&head)
            };
            if found != expected {
                println!("{file}: {head}expected:\n{expected}\nfound:\n{found}\n");
                differences += 1;
            }
            assert_ne!(found, "loaded without an error", "{file}: {head}");
            blessed += &format!("==== {head}---- report\n{found}\n\n");
        }
        if bless {
            fs::write(&path, blessed).expect("a writable file");
        }
    }
    assert!(bless || differences == 0, "{differences} reports differ");
}

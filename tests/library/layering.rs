//! Layers: which module of `src/` and `engine/src/` may use which, and what each must not contain; `ARCHITECTURE.md` has the picture.
//! Sources are read as tokens, so that comments, strings and doc examples do not count; neither do items under
//! `#[cfg(test)]`.

mod facts;

use facts::Facts;
use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

/// What each module may use, besides itself. `None`: everything.
const MODULES: [(&str, Option<&str>); 26] = [
    ("error", Some("")),
    ("math", Some("")),
    // Files that appear whole or not at all.
    ("whole_file", Some("")),
    ("classic", Some("")),
    // Numbers side by side in memory.
    ("lanes", Some("")),
    ("simd", Some("lanes math")),
    ("ray", Some("lanes")),
    ("geometry", Some("ray simd lanes math")),
    // Costs as colours.
    ("heat", Some("")),
    // Sample points.
    ("sobol", Some("")),
    ("scene", Some("classic ray math simd lanes error")),
    ("format", Some("scene math error")),
    ("generate", Some("scene format math classic error")),
    ("accel", Some("scene geometry classic ray simd lanes math error")),
    (
        "trace",
        Some("accel scene geometry classic ray simd lanes math error"),
    ),
    (
        "shade",
        Some("trace accel scene geometry classic ray simd sobol lanes math error"),
    ),
    (
        "query",
        Some("trace accel scene geometry classic ray simd lanes math error"),
    ),
    ("reference", Some("scene classic ray simd sobol math")),
    (
        "render",
        Some("shade reference trace accel scene geometry classic ray simd sobol lanes math error"),
    ),
    (
        "bench",
        Some(
            "render generate shade reference trace accel scene geometry classic ray simd sobol lanes math error",
        ),
    ),
    (
        "verify",
        Some("generate reference trace accel scene geometry classic ray simd lanes math error"),
    ),
    (
        "viewer",
        Some(
            "render shade reference trace accel format scene geometry classic heat ray simd lanes math error",
        ),
    ),
    ("cli", None),
    // The program uses the library as any other user does.
    ("main", Some("allocator streams")),
    ("allocator", Some("")),
    ("streams", Some("")),
];

/// Files that may use more than their module.
const EXTRA: [(&str, &str); 3] = [
    ("render/png.rs", "whole_file"),
    ("reference/bvh.rs", "accel"),
    ("reference/cost.rs", "accel"),
];

/// Crates that only one module names.
const ONLY_IN: [(&str, &str); 3] = [
    ("wide", "simd/portable.rs"),
    ("obvhs", "accel/"),
    // Others name its modules as if they were octray's.
    ("octray_engine", "lib.rs"),
];

/// Modules that may print text of their own with macros, and end the program.
const PRINTING: [&str; 1] = ["main"];

/// Files that may use the standard streams: everything that is printed goes through one place, which escapes it.
/// Progress bars print numbers, a process without memory a sentence of its own; clap prints usage errors and help, of arguments that were made safe before.
const STREAMS: [(&str, &str); 5] = [
    ("cli/process/memory.rs", "stderr()"),
    ("cli/report/message.rs", "stdout()"),
    ("cli/report/message.rs", "stderr()"),
    ("cli/report/progress.rs", "stderr()"),
    ("cli/args/mod.rs", ".print()"),
];

/// Modules without `unsafe`.
const SAFE: [&str; 6] = ["format", "scene", "shade", "verify", "viewer", "cli"];

/// Of the command line, the places that may name clap: the arguments, and what is printed from their definition.
const NAMES_CLAP: [&str; 2] = ["cli/args/", "cli/commands/shell.rs"];

const MOST_LINES: usize = 500;

/// Modules whose files are shorter: what is hard to read is read in parts.
const SHORT: [&str; 3] = ["trace", "simd", "geometry"];
const MOST_LINES_OF_SHORT: usize = 400;
const MOST_LINES_OF_FUNCTION: usize = 80;

fn module(path: &str) -> &str {
    path.trim_end_matches(".rs").split('/').next().unwrap_or(path)
}

/// What is wrong with a file of `src/` or `engine/src/`; `path` is relative to that, with `/`.
fn complaints(path: &str, source: &str) -> Vec<String> {
    let facts = Facts::of(source, path);
    let module = module(path);
    let mut found = Vec::new();
    let lines = source.lines().count();
    let most = if SHORT.contains(&module) {
        MOST_LINES_OF_SHORT
    } else {
        MOST_LINES
    };
    if lines > most {
        found.push(format!("{path}: {lines} lines, at most {most} are allowed"));
    }
    if SHORT.contains(&module) {
        for (name, lines) in functions(source) {
            if lines > MOST_LINES_OF_FUNCTION {
                found.push(format!("{path}: `{name}` has {lines} lines"));
            }
        }
    }
    for (name, place) in ONLY_IN {
        if facts.crates.contains(name) && !path.starts_with(place) {
            found.push(format!("{path}: names `{name}`, which only {place} may"));
        }
    }
    if facts.crates.contains("clap") && !NAMES_CLAP.iter().any(|place| path.starts_with(place)) {
        found.push(format!("{path}: names `clap`, which only {NAMES_CLAP:?} may"));
    }
    if !PRINTING.contains(&module) {
        for what in facts
            .output
            .iter()
            .filter(|what| module != "cli" || *what != "process::exit")
        {
            found.push(format!(
                "{path}: {what}, but the library never prints and never exits"
            ));
        }
    }
    for what in &facts.streams {
        if !STREAMS.contains(&(path, what)) && !PRINTING.contains(&module) {
            found.push(format!(
                "{path}: {what}, but all output goes through cli/report/message.rs"
            ));
        }
    }
    if facts.shows_paths && module == "cli" {
        found.push(format!(
            "{path}: `display()` shows a path as it is; `clip_path` makes it safe"
        ));
    }
    if facts.has_unsafe && SAFE.contains(&module) {
        found.push(format!("{path}: `unsafe`, which {module} does without"));
    }
    // The crate's root names its modules.
    if module == "lib" {
        return found;
    }
    let Some((_, allowed)) = MODULES.iter().find(|(name, _)| *name == module) else {
        found.push(format!(
            "{path}: module `{module}` is not in the table of tests/library/layering.rs"
        ));
        return found;
    };
    let Some(allowed) = allowed else { return found };
    let extra = EXTRA
        .iter()
        .filter(|(file, _)| *file == path)
        .map(|(_, module)| *module);
    let allowed: BTreeSet<&str> = allowed
        .split_whitespace()
        .chain(extra)
        .chain([module, "self"])
        .collect();
    for used in &facts.uses {
        if !allowed.contains(used.as_str()) {
            found.push(format!("{path}: uses `{used}`, which {module} may not"));
        }
    }
    found
}

/// The functions of formatted source and their lines, without those of an inner module of tests.
fn functions(source: &str) -> Vec<(&str, usize)> {
    let source = source.split("#[cfg(test)]\nmod tests {").next().unwrap_or(source);
    let lines: Vec<&str> = source.lines().collect();
    let mut found = Vec::new();
    for (start, line) in lines.iter().enumerate() {
        let code = line.trim_start();
        let Some((before, after)) = code.split_once("fn ") else {
            continue;
        };
        let is_qualifier = |word: &str| word.starts_with("pub") || matches!(word, "const" | "unsafe");
        if !before.split_whitespace().all(is_qualifier) {
            continue;
        }
        let name = after.split(|c: char| !c.is_alphanumeric() && c != '_').next();
        let end = format!("{}}}", &line[..line.len() - code.len()]);
        let length = lines[start..].iter().position(|line| **line == end);
        // A function without a body ends on its first lines.
        let body = lines[start..]
            .iter()
            .position(|line| line.ends_with('{') || line.ends_with(';'));
        if let (Some(name), Some(length), Some(body)) = (name, length, body)
            && lines[start + body].ends_with('{')
        {
            found.push((name, length + 1));
        }
    }
    found
}

fn source_files() -> Vec<(String, String)> {
    fn walk(folder: &Path, files: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).expect("a folder of src") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                walk(&path, files);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                files.push(path);
            }
        }
    }
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut all = Vec::new();
    for src in [package.join("src"), package.join("engine/src")] {
        let mut files = Vec::new();
        walk(&src, &mut files);
        files.sort();
        all.extend(files.into_iter().map(|file| {
            let text = fs::read_to_string(&file).expect("UTF-8");
            let relative = file.strip_prefix(&src).expect("a file of src");
            (relative.to_string_lossy().replace('\\', "/"), text)
        }));
    }
    all
}

/// Files that only tests compile: declared by `#[cfg(test)] mod name;`.
fn test_only(files: &[(String, String)]) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for (path, source) in files {
        let stem = path.trim_end_matches(".rs");
        let folder = match stem.rsplit_once('/') {
            Some((folder, "mod")) => format!("{folder}/"),
            None if matches!(stem, "lib" | "main") => String::new(),
            _ => format!("{stem}/"),
        };
        for module in Facts::of(source, path).test_modules {
            found.insert(format!("{folder}{module}.rs"));
            found.insert(format!("{folder}{module}/mod.rs"));
        }
    }
    found
}

#[test]
fn every_module_keeps_to_its_layer() {
    let files = source_files();
    assert!(files.len() > 300, "sources were not found");
    let test_only = test_only(&files);
    let found: Vec<String> = files
        .iter()
        .filter(|(path, _)| !test_only.contains(path))
        .flat_map(|(path, source)| complaints(path, source))
        .collect();
    assert!(found.is_empty(), "\n{}", found.join("\n"));
}

#[test]
fn the_table_has_no_circle() {
    // Each module's list names only modules above it in the table.
    for (i, (module, allowed)) in MODULES
        .iter()
        .enumerate()
        .filter(|(_, (module, _))| *module != "main")
    {
        for used in allowed.unwrap_or("").split_whitespace() {
            let above = MODULES[..i].iter().any(|(name, _)| *name == used);
            assert!(above, "{module} uses {used}, which does not stand above it");
        }
    }
}

#[test]
fn offenders_are_caught() {
    let caught = |path: &str, source: &str| {
        let found = complaints(path, source);
        assert_eq!(found.len(), 1, "{path}: {source}: {found:?}");
    };
    caught("scene/mod.rs", "use crate::accel::Bvh;");
    caught("scene/mod.rs", "use crate::{classic, render::{Film, render}};");
    caught("scene/camera.rs", "use super::super::render;");
    caught("simd/mod.rs", "fn f() { super::scene::g(); }");
    caught("math.rs", "fn f() { vec![crate::ray::T_MAX]; }");
    caught("reference/brute.rs", "use crate::accel::Bvh;");
    caught("trace/mod.rs", "use wide::f32x8;");
    caught("shade/mod.rs", "fn f(x: wide::f32x8) {}");
    caught("scene/mod.rs", "use obvhs::cwbvh;");
    caught("accel/mod.rs", "fn f() { println!(\"x\"); }");
    caught("render/mod.rs", "fn f() { std::process::exit(1); }");
    caught("format/ply.rs", "fn f() { unsafe { g() } }");
    caught("cli/output.rs", "unsafe fn f() {}");
    caught("cli/plan/mod.rs", "use clap::Args;");
    caught("cli/load/mod.rs", "fn f(x: clap::ArgMatches) {}");
    caught(
        "cli/write/output.rs",
        "fn f() { io::stdout().write_all(b\"x\"); }",
    );
    caught("cli/report/stats.rs", "fn f() { std::io::stderr().lock(); }");
    caught("cli/commands/info.rs", "fn f() { println!(\"x\"); }");
    caught("cli/commands/info.rs", "fn f(error: E) { error.print(); }");
    caught("cli/commands/info.rs", "fn f(path: &Path) { g(path.display()); }");
    caught("viewer/mod.rs", "fn f() { io::stdout(); }");
    caught("attic/mod.rs", "fn f() {}");
    caught("math.rs", &"\n".repeat(MOST_LINES + 1));
    caught("trace/leaf.rs", &"\n".repeat(MOST_LINES_OF_SHORT + 1));
    caught("math.rs", "mod inner { use super::super::simd; }");
    let long = format!(
        "impl S {{\n    fn f() {{\n{}    }}\n}}\n",
        "        g();\n".repeat(79)
    );
    caught("trace/mod.rs", &long);
}

#[test]
fn the_innocent_are_left_alone() {
    for (path, source) in [
        (
            "scene/mod.rs",
            "//! See crate::render.\n/// `println!`\nfn f() { g(\"unsafe wide::f32x8\"); }",
        ),
        (
            "scene/mod.rs",
            "use crate::{classic, scene::Camera, math::Aabb}; use super::scene as s;",
        ),
        (
            "scene/camera.rs",
            "use super::builder; use crate::error::SceneError;",
        ),
        (
            "math.rs",
            "#[cfg(test)]\nmod tests { use crate::render::render; fn f() { println!(); } }",
        ),
        ("math.rs", "#[cfg(test)] mod tests;"),
        ("reference/bvh.rs", "use crate::accel::Bvh;"),
        ("simd/portable.rs", "use wide::f32x8; use crate::math;"),
        (
            "accel/build.rs",
            "use obvhs::ploc; fn f() { let wide = 1; g(wide); }",
        ),
        ("streams.rs", "fn f() { unsafe { g() } }"),
        (
            "main.rs",
            "mod streams; fn main() { octray::cli::main(); crate::streams::check(); }",
        ),
        ("cli/args/mod.rs", "use clap::Args; fn f(e: E) { e.print(); }"),
        ("cli/report/message.rs", "fn f() { io::stdout(); io::stderr(); }"),
        (
            "cli/commands/bench.rs",
            "fn f() { self.print(1); Self::stdout(); }",
        ),
        ("cli/commands/shell.rs", "use clap::Command;"),
        ("lib.rs", "pub mod render; pub use crate::render::render;"),
    ] {
        assert!(
            complaints(path, source).is_empty(),
            "{path}: {source}: {:?}",
            complaints(path, source)
        );
    }
}

#[test]
fn files_of_test_modules_are_known() {
    let files = [
        (
            "generate/mod.rs".to_string(),
            "#[cfg(test)] mod tests;".to_string(),
        ),
        ("math.rs".to_string(), "#[cfg(test)]\nmod checks;".to_string()),
    ];
    let found = test_only(&files);
    assert!(found.contains("generate/tests.rs") && found.contains("math/checks.rs"));
}

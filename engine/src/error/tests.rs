//! Tests of `error`.

use super::*;

fn mesh_error() -> LoadError {
    let at = |file: &str, line, column| SourcePos {
        file: Arc::new(PathBuf::from(file)),
        line,
        column,
    };
    let cause = LoadError::new(
        at("meshes/cow.ply", 812, 1),
        "vertex index 9001, but the file has only 2904 vertices",
    );
    LoadError::new(at("scenes/cow.scn", 4, 10), "cannot load meshes/cow.ply")
        .with_line(b"ply_file meshes/cow.ply", 9..23)
        .caused_by(cause.with_line(b"3 0 1 9001", 0..10))
}

#[test]
fn display_names_both_places() {
    assert_eq!(
        mesh_error().to_string(),
        "scenes/cow.scn:4:10: cannot load meshes/cow.ply\n  \
             caused by: meshes/cow.ply:812:1: vertex index 9001, but the file has only 2904 vertices"
    );
}

#[test]
fn report_shows_both_lines() {
    let expected = "\
scenes/cow.scn:4:10: cannot load meshes/cow.ply
  |
4 | ply_file meshes/cow.ply
  |          ^^^^^^^^^^^^^^
  caused by: meshes/cow.ply:812:1: vertex index 9001, but the file has only 2904 vertices
      |
  812 | 3 0 1 9001
      | ^^^^^^^^^^";
    assert_eq!(mesh_error().report(), expected);
}

#[test]
fn causes_are_shown_once() {
    use std::error::Error as _;
    let error = mesh_error();
    assert!(error.to_string().contains("caused by: meshes/cow.ply:812:1: "));
    assert!(error.source().is_none());
}

#[test]
fn places_in_a_text() {
    let text = b"ab\ncd\n\nef";
    let at = |offset| SourcePos::in_text(Path::new("a"), text, offset).to_string();
    assert_eq!(
        [0, 2, 3, 6, 7, 9, 99].map(at),
        ["a:1:1", "a:1:3", "a:2:1", "a:3:1", "a:4:1", "a:4:3", "a:4:3"]
    );
    let error = LoadError::in_text(Path::new("a"), text, 4..9, "odd");
    assert_eq!(error.report(), "a:2:2: odd\n  |\n2 | cd\n  |  ^");
}

#[test]
fn nothing_in_an_error_acts_on_a_terminal() {
    let error = LoadError::whole_file(Path::new("a\x1b[2J.scn"), "found \u{7}");
    assert_eq!(error.to_string(), "a\\u{1b}[2J.scn: found \\u{7}");
}

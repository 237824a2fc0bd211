use super::*;

fn message(path: &str) -> String {
    let path = Path::new(path);
    read(path, &Budget::unlimited()).map_or_else(
        |error| load_error(path, &error).to_string(),
        |_| "read".to_owned(),
    )
}

/// Where names differ in case at all.
#[cfg(target_os = "linux")]
#[test]
fn names_in_another_case_are_taken_if_there_is_one() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("Wood.PNG"), "wood").unwrap();
    let (mut asked, budget) = (Vec::new(), Budget::unlimited());
    let mut companions = Companions::new(&mut asked);
    assert_eq!(companions.note(&at("a.obj")), None);
    assert_eq!(companions.read(&at("wood.png"), &budget).unwrap(), b"wood");
    let note = companions.note(Path::new("a.obj")).unwrap();
    let name = at("Wood.PNG");
    let expected = format!(
        "a.obj: a file differs in upper and lower case from the name in the mesh (`{}`)",
        name.display()
    );
    assert_eq!(note, expected);
    fs::write(at("WOOD.png"), "another").unwrap();
    let error = companions.read(&at("wood.png"), &budget).unwrap_err();
    assert_eq!(error.kind(), io::ErrorKind::NotFound);
    assert_eq!(asked, [at("wood.png"), name, at("wood.png")]);
}

#[test]
fn only_files_are_read() {
    assert_eq!(
        message("/no/such.scn"),
        "/no/such.scn: file not found; directory `/no` does not exist"
    );
    assert_eq!(message("no_such_file.scn"), "no_such_file.scn: file not found");
    assert_eq!(message("."), ".: this is a directory, expected a file");
    if cfg!(unix) {
        assert_eq!(
            message("/dev/zero"),
            "/dev/zero: this is a pipe or a device, expected a file"
        );
    }
    assert!(message("a\0b").starts_with("a\\u{0}b: "));
}

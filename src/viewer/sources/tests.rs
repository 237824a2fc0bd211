//! Tests of `sources`.

use super::*;
use tempfile::TempDir;

#[test]
fn a_file_that_changed_since_it_was_noted_is_noticed() {
    let folder = TempDir::new().unwrap();
    let [one, two] = ["one", "two"].map(|name| folder.path().join(name));
    fs::write(&one, "1").unwrap();
    let states = States::default();
    states.note(&one);
    states.note(&two);
    assert!(!states.have_changed());
    // Written again.
    fs::write(&one, "12").unwrap();
    assert!(states.have_changed());
    // The first state counts.
    states.note(&one);
    assert!(states.have_changed());

    let states = States::default();
    states.note(&one);
    states.note(&two);
    assert!(!states.have_changed());
    // A missing one appears.
    fs::copy(&one, &two).unwrap();
    assert!(states.have_changed());

    let states = States::default();
    states.note(&one);
    let time = fs::metadata(&one).and_then(|file| file.modified()).unwrap();
    fs::File::open(&two)
        .and_then(|file| file.set_modified(time))
        .unwrap();
    // Another file of the same size and time takes its place.
    fs::rename(&two, &one).unwrap();
    assert_eq!(states.have_changed(), cfg!(unix));

    let states = States::default();
    states.note(&one);
    fs::remove_file(&one).unwrap();
    assert!(states.have_changed());
}

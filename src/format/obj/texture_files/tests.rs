//! Tests of `texture_files`.

use super::*;

fn read(statement: &str) -> (String, Options) {
    let bytes = statement.as_bytes();
    let file = texture_file(Words::new(bytes, 0..bytes.len()));
    (file.name().into_owned(), file.options)
}

/// Programs write options on either side of the name.
#[test]
fn options_may_follow_the_name() {
    for (statement, name, strength, scale) in [
        ("a.png -bm 2", "a.png", 2.0, [1.0; 2]),
        ("a.png -s 2 3 1 -bm 0.5 # grey", "a.png", 0.5, [2.0, 3.0]),
        ("-bm 2 my file.png  -s 2 3", "my file.png", 2.0, [2.0, 3.0]),
        (
            "\"my file.png\" -mm 0 1 -imfchan r -cc on -s 4",
            "my file.png",
            1.0,
            [4.0, 1.0],
        ),
        ("my file.png", "my file.png", 1.0, [1.0; 2]),
        // These belong to the name.
        ("wood -s 2.png", "wood -s 2.png", 1.0, [1.0; 2]),
        ("wood -bm 2 old.png -s 2", "wood -bm 2 old.png", 1.0, [2.0, 1.0]),
        ("wood -new -bm 2", "wood -new", 2.0, [1.0; 2]),
        ("wood - old.png", "wood - old.png", 1.0, [1.0; 2]),
        ("\"wood -s 2\"", "wood -s 2", 1.0, [1.0; 2]),
        ("-s 2 2", "", 1.0, [2.0; 2]),
    ] {
        let (found, options) = read(statement);
        assert_eq!(found, name, "{statement}");
        assert_eq!(
            (options.strength, options.shift.scale),
            (strength, scale),
            "{statement}"
        );
    }
    let (name, options) = read("a.png -clamp on -t 0 1");
    assert!(name == "a.png" && options.wrap == Wrap::Clamp && options.is_turbulent);
}

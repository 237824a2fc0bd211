//! Tests of `default_command`.

use super::*;

#[test]
fn negative_values_and_widths_belong_to_their_options() {
    let joined = |line: &str| {
        let words = line.split(' ').map(OsString::from).collect();
        with_joined_values(words)
            .join(OsStr::new(" "))
            .into_string()
            .unwrap()
    };
    for (line, expected) in [
        (
            "octray a --crop -1,2,3,4 -s -1x4",
            "octray a --crop=-1,2,3,4 -s=-1x4",
        ),
        ("octray --eye -.5,1,2 -q", "octray --eye=-.5,1,2 -q"),
        ("octray --eye=1,2,3 -4", "octray --eye=1,2,3 -4"),
        ("octray - -1 -- -o -2", "octray - -1 -- -o -2"),
        ("octray --up -x --eye 3 -4 2", "octray --up -x --eye 3 -4 2"),
        ("octray --edges 2.5 a.stl", "octray --edges=2.5 a.stl"),
        ("octray --edges 2.stl --edges", "octray --edges 2.stl --edges"),
        (
            "octray --edges=2 3 -- --edges 4",
            "octray --edges=2 3 -- --edges 4",
        ),
    ] {
        assert_eq!(joined(line), expected);
    }
}

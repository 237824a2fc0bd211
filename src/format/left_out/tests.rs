//! Tests of `left_out`.

use super::*;

#[test]
fn one_note_names_all() {
    let mut left_out = LeftOut::default();
    assert_eq!(left_out.note(Path::new("a.ply")), None);
    left_out.count(0, "light", "lights");
    left_out.count(1, "camera", "cameras");
    left_out.count(3, "light", "lights");
    left_out.add("vertex colours");
    left_out.add("vertex colours");
    left_out.names("properties", ["a", "b", "a"]);
    left_out.names("elements", ["a", "b", "c", "d", "e", "f"]);
    assert_eq!(
        left_out.note(Path::new("a.ply")).as_deref(),
        Some(
            "a.ply: left out: 1 camera, 3 lights, vertex colours, properties `a`, `b`, elements `a`, `b`, `c`, `d`, ..."
        )
    );
}

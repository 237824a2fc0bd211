//! Vertices whose coordinates are NaN or too large.

use super::*;
use crate::format::offset::Offset;
use glam::DVec3;

/// A square of two triangles and its last vertex, built at `transform`.
fn with_corner(x: &str, transform: &str) -> String {
    format!(
        "<resources><object id=\"1\"><mesh><vertices><vertex x=\"500000.25\" y=\"0\" z=\"0\"/><vertex x=\"500001\" y=\"0\" \
         z=\"0\"/><vertex x=\"500001\" y=\"1\" z=\"0\"/><vertex x=\"{x}\" y=\"1\" z=\"0\"/></vertices><triangles>\
         <triangle v1=\"0\" v2=\"1\" v3=\"2\"/><triangle v1=\"0\" v2=\"2\" v3=\"3\"/></triangles></mesh></object></resources>\
         <build><item objectid=\"1\" {transform}/></build>"
    )
}

const NOTE: &str = "a.3mf: left out: 1 vertex that is NaN or too large, 1 triangle that uses it";

#[test]
fn triangles_with_unusable_corners_are_left_out() {
    for x in ["nan", "-inf", "3e38", "2e9"] {
        let mesh = loaded(&with_corner(x, ""));
        assert_eq!(mesh.columns.triangles, [[0, 1, 2]], "{x}");
        assert_eq!(mesh.notes, [NOTE], "{x}");
    }
    // A vertex that nothing builds is not counted.
    let more = "<resources><object id=\"7\"><mesh><vertices><vertex x=\"nan\" y=\"0\" z=\"0\"/></vertices></mesh></object>";
    let mesh = loaded(&with_corner("500000", "").replacen("<resources>", more, 1));
    assert_eq!(mesh.columns.triangles.len(), 2);
    assert_eq!(mesh.notes, ["a.3mf: left out: 1 object that is not built"]);
    // The item moves them too far.
    let far = with_corner("0", "transform=\"1 0 0 0 1 0 0 0 1 999999999 0 0\"");
    assert_eq!(
        load(&far).expect_err("nothing is left"),
        "a.3mf/3D/3dmodel.model:1:327: vertex 0 of object 1: x is 1.0005e9, but numbers above 1e9 are not supported"
    );
}

/// The first vertex that is usable is what the others are relative to.
#[test]
fn offsets_are_usable() {
    let budget = Budget::unlimited();
    budget.set_offset(Offset::new(DVec3::new(500_000.0, 0.0, 0.0)));
    let model = with_corner("500001", "").replacen("500000.25", "nan", 1);
    let content = model.replacen("v1=\"0\" v2=\"2\" v3=\"3\"", "v1=\"1\" v2=\"2\" v3=\"3\"", 1);
    let model = format!("<model unit=\"millimeter\">{content}</model>");
    let parts = [
        ("_rels/.rels", RELS.as_bytes()),
        ("3D/3dmodel.model", model.as_bytes()),
    ];
    let mesh = read(&archive(parts), &budget).expect("a mesh");
    assert_eq!(mesh.columns.x[1..], [1.0; 3]);
    assert_eq!(mesh.notes, [NOTE]);
}

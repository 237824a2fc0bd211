//! What programs write that is easily read wrongly.

use super::*;

/// Cells of the points of two boxes.
fn cells(cells: Vec<(u8, Vec<u32>)>, of_cells: Vec<Values>) -> LoadedMesh {
    let grid = Grid {
        cells,
        of_cells,
        ..boxes()
    };
    load(&grid.write(forms()[0]))
}

#[test]
fn names_of_components_may_be_empty() {
    for names in ["x\n\n\n", "\ny\n\n", "\n\nz\n"] {
        let text = format!(
            "POLYDATA\n{SQUARE}POLYGONS 1 4 3 0 1 2\nPOINT_DATA 4\nFIELD f 2\nv 3 4 float\n0 0 0 0 0 0 0 0 0 0 0 0\n\
             METADATA\nCOMPONENT_NAMES\n{names}INFORMATION 1\nNAME a LOCATION b\nDATA 2 0 1\n\n\
             n 1 4 variant\n6 0\n6 1\n6 two words\n6 3\nNORMALS m float\n0 0 1 0 0 1 0 0 1 0 0 1\n"
        );
        let mesh = load(&legacy(&text));
        assert_eq!(mesh.columns.normals.len(), 3, "{names:?}");
        assert_eq!(mesh.notes, ["a.vtk: left out: arrays of points `v`"]);
    }
    // As many names as nobody has.
    let text = format!(
        "POLYDATA\n{SQUARE}FIELD f 1\nv {} 0 float\nMETADATA\nCOMPONENT_NAMES\n",
        u64::MAX
    );
    assert!(load(&legacy(&text)).cloud.is_some());
}

/// The face beside a hidden cell is an outer one; a copy of a cell that another piece shows hides it.
#[test]
fn hidden_cells() {
    for (mark, triangles) in [(0.0, 20), (1.0, 10), (32.0, 12), (33.0, 12)] {
        let ghosts = Values {
            name: "vtkGhostType",
            kind: "UInt8",
            components: 1,
            values: vec![mark, 0.0],
        };
        let mesh = cells(boxes().cells, vec![ghosts]).columns;
        assert_eq!(mesh.triangles.len(), triangles, "{mark}");
        assert!(mark < 32.0 || (volume(&mesh) - 1.5).abs() < 1e-6);
    }
}

/// A hexahedron that is a wedge, beside a true wedge, and one that is a tetrahedron.
#[test]
fn collapsed_bodies() {
    let wedge = vec![0, 1, 4, 4, 6, 7, 10, 10];
    let mesh = cells(vec![(12, wedge.clone())], Vec::new()).columns;
    assert_eq!(mesh.triangles.len(), 8);
    assert!((volume(&mesh) - 0.5).abs() < 1e-6);
    // They share a side.
    let mesh = cells(vec![(12, wedge), (13, vec![0, 4, 3, 6, 10, 9])], Vec::new()).columns;
    assert_eq!(mesh.triangles.len(), 12);
    assert!((volume(&mesh) - 1.0).abs() < 1e-6);
    let mesh = cells(vec![(12, vec![0, 1, 3, 3, 6, 6, 6, 6])], Vec::new()).columns;
    assert_eq!(mesh.triangles.len(), 4);
    assert!((volume(&mesh) - 1.0 / 6.0).abs() < 1e-6);
}

#[test]
fn normals_of_cells_are_numbers() {
    let text = format!("POLYDATA\n{SQUARE}POLYGONS 1 4 3 0 1 2\nCELL_DATA 1\nNORMALS n float\n0 0.5 2");
    let listed = read(&legacy(&text), Wanted::Ranges)
        .expect("a mesh")
        .scalars
        .listed;
    assert_eq!(listed.len(), 4);
    assert_eq!((listed[2].name.as_str(), listed[2].of), ("n.z", Owner::Faces));
    let mesh = read(&legacy(&text), named("n.y")).expect("numbers");
    assert_eq!(mesh.scalars.of_faces, [0.5]);
}

/// Text repeats the pieces for each step, and appended data the arrays. Neither needs the attribute `format`.
#[test]
fn time_steps() {
    let array = |name: &str, step: &str, kind: &str, values: &str| {
        let components = if name == "p" { 3 } else { 1 };
        format!(
            "<DataArray type='{kind}' Name='{name}' NumberOfComponents='{components}' {step}>{values}</DataArray>"
        )
    };
    let points = |step: &str, x: &str| array("p", step, "Float32", &format!("{x} 0 0 1 0 0 1 1 0"));
    let numbers = |step: &str, x: &str| array("t", step, "Float32", &format!("{x} {x} {x}"));
    let polys =
        |step: &str| array("connectivity", step, "Int32", "0 1 2") + &array("offsets", step, "Int32", "3");
    let piece = |[points, numbers, polys]: [String; 3]| {
        format!(
            "<Piece NumberOfPoints='3' NumberOfPolys='1'><PointData>{numbers}</PointData><Points>{points}</Points>\
             <Polys>{polys}</Polys></Piece>"
        )
    };
    let file = |times: &str, pieces: &[String]| {
        format!(
            "<VTKFile type='PolyData'><PolyData {times}>{}</PolyData></VTKFile>",
            pieces.concat()
        )
    };
    let at = |step: &str, x: &str| [points(step, x), numbers(step, x), polys(step)];
    let [first, later] = [at("TimeStep='0'", "0"), at("TimeStep='1'", "5")];
    let times = "TimeValues='\n0\n0.5\n'";
    let of_text = file(times, &["0", "5"].map(|x| piece(at("TimeStep='0'", x))));
    let mixed: [String; 3] = std::array::from_fn(|i| first[i].clone() + &later[i]);
    for text in [
        of_text,
        file(times, &[piece(mixed.clone())]),
        file("", &[piece(mixed)]),
    ] {
        let mesh = read(text.as_bytes(), named("t")).expect("numbers");
        assert_eq!(mesh.columns.x, [0.0, 1.0, 1.0]);
        assert_eq!(value_of(mesh.columns.colors[0]), 0.0);
        assert_eq!(mesh.notes, ["a.vtk: left out: time steps after the first"]);
    }
    for (times, pieces) in [
        ("TimeValues='2'", vec![piece(first)]),
        (times, vec![piece(at("", "0"))]),
    ] {
        let mesh = read(file(times, &pieces).as_bytes(), named("t")).expect("numbers");
        assert!(mesh.notes.is_empty() && mesh.columns.triangles.len() == 1);
    }
}

#[test]
fn no_lines() {
    let polygons = "POLYGONS 2 3\nOFFSETS vtktypeint64\n0 3\nCONNECTIVITY vtktypeint64\n0 1 2";
    let empty = "OFFSETS vtktypeint64\nCONNECTIVITY vtktypeint64\n";
    for lines in [
        "LINES 0 0\n".to_owned(),
        format!("LINES 0 0\n{empty}"),
        format!("LINES 1 0\n{}", empty.replace("64\nC", "64\n0\nC")),
    ] {
        let text = format!("POLYDATA\n{SQUARE}{lines}{polygons}");
        let text = String::from_utf8(legacy(&text)).expect("text");
        let mesh = load(text.replace("Version 3.0", "Version 5.1").as_bytes());
        assert_eq!(mesh.columns.triangles, [[0, 1, 2]], "{lines}");
    }
}

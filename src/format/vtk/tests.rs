use super::*;
use crate::{
    format::mesh::{Owner, Range, value_of},
    scene::TriangleMesh,
};
use files::{Array as Values, Binary, Form, Grid, document, forms};

mod files;
mod hostile;
mod writers;

/// Two hexahedra that share a face, with numbers and colours.
fn boxes() -> Grid {
    let mut points = Vec::new();
    for [y, z] in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]] {
        points.extend([0.0, 1.0, 2.5].map(|x| [x, y, z]));
    }
    let velocity = (0..12).flat_map(|i| [3.0 * f64::from(i), 4.0 * f64::from(i), 0.0]);
    let array = |name, kind, components, values| Values {
        name,
        kind,
        components,
        values,
    };
    Grid {
        points,
        cells: vec![
            (12, vec![0, 1, 4, 3, 6, 7, 10, 9]),
            (12, vec![1, 2, 5, 4, 7, 8, 11, 10]),
        ],
        of_points: vec![
            array(
                "pressure",
                "Float64",
                1,
                (0..12).map(|i| f64::from(i) - 0.5).collect(),
            ),
            array("velocity", "Float32", 3, velocity.collect()),
        ],
        of_cells: vec![
            array("id", "Int32", 1, vec![7.0, 9.0]),
            array("RGB", "UInt8", 3, vec![255.0, 0.0, 0.0, 0.0, 0.0, 255.0]),
        ],
    }
}

fn read(bytes: &[u8], wanted: Wanted) -> Result<LoadedMesh, String> {
    let budget = Budget::new(1 << 30).with_scalars(wanted);
    let mesh = parse(bytes, Path::new("a.vtk"), &budget);
    mesh.map_err(|error| error.to_string())
}

fn load(bytes: &[u8]) -> LoadedMesh {
    read(bytes, Wanted::Nothing).expect("a mesh")
}

fn named(name: &str) -> Wanted {
    Wanted::Named(name.to_owned())
}

/// The outward normal times the area, of all triangles.
fn volume(mesh: &TriangleMesh) -> f64 {
    let point = |i: u32| {
        let i = i as usize;
        glam::DVec3::new(mesh.x[i].into(), mesh.y[i].into(), mesh.z[i].into())
    };
    let parts = mesh.triangles.iter().map(|corners| {
        let [a, b, c] = corners.map(point);
        a.dot(b.cross(c)) / 6.0
    });
    parts.sum()
}

/// The text of legacy files with these sections.
fn legacy(sections: &str) -> Vec<u8> {
    format!("# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET {sections}\n").into_bytes()
}

const SQUARE: &str = "POINTS 4 float\n0 0 0 1 0 0 1 1 0 0 1 0\n";

/// The numbers of a mesh's points.
fn numbers(mesh: &LoadedMesh) -> Vec<f64> {
    mesh.columns.colors.iter().map(|&color| value_of(color)).collect()
}

#[test]
fn every_form_gives_the_same_mesh() {
    let grid = boxes();
    let first = load(&grid.write(Form::Xml("ascii", Binary::default())));
    assert_eq!(first.columns.triangles.len(), 20);
    assert!((volume(&first.columns) - 2.5).abs() < 1e-6);
    assert_eq!((first.surfaces.len(), first.surface_of.len()), (2, 20));
    assert_eq!(
        first.notes,
        ["a.vtk: left out: arrays of points `pressure`, `velocity`, arrays of cells `id`"]
    );
    for form in forms() {
        let bytes = grid.write(form);
        let mesh = load(&bytes);
        assert_eq!(mesh.columns.triangles, first.columns.triangles, "{form:?}");
        assert_eq!(
            [&mesh.columns.x, &mesh.columns.y, &mesh.columns.z],
            [&first.columns.x, &first.columns.y, &first.columns.z]
        );
        assert_eq!(mesh.surfaces, first.surfaces);
        let colored = read(&bytes, named("velocity.magnitude")).expect("numbers");
        assert_eq!(
            numbers(&colored),
            (0..12).map(|i| 5.0 * f64::from(i)).collect::<Vec<_>>()
        );
        let colored = read(&bytes, named("id")).expect("numbers");
        assert_eq!(colored.scalars.of_faces, [[7.0; 10], [9.0; 10]].concat());
        assert!(colored.surfaces.is_empty() && colored.notes.is_empty());
    }
}

/// PLY is read by other code.
#[test]
fn surfaces_are_those_of_ply() {
    let points = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n0.5 0.2 0\n0.1 0.3 1\n";
    let faces = "4 0 1 2 3\n5 0 1 2 4 3\n3 5 1 0\n";
    let ply = format!(
        "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\n\
         property float nx\nproperty float ny\nproperty float nz\nelement face 3\n\
         property list uchar int vertex_indices\nend_header\n{}{faces}",
        points.replace('\n', " 0 0 1\n")
    );
    let vtk = legacy(&format!(
        "POLYDATA\nPOINTS 6 double\n{points}POLYGONS 3 15\n{faces}POINT_DATA 6\nNORMALS n float\n{}",
        "0 0 1 ".repeat(6)
    ));
    let open = &mut |_: &Path| Err(std::io::ErrorKind::NotFound.into());
    let ply = super::super::mesh::parse(ply.into_bytes(), Path::new("a.ply"), open).expect("a mesh");
    let vtk = load(&vtk);
    assert_eq!(vtk.columns.triangles, ply.columns.triangles);
    assert_eq!(vtk.columns.normals, ply.columns.normals);
    assert_eq!([vtk.columns.x, vtk.columns.y], [ply.columns.x, ply.columns.y]);
    assert!(vtk.up == UpAxis::Z && vtk.notes.is_empty() && vtk.cloud.is_none());
}

/// Bodies of each type have the volume that they should, whichever way round their corners are.
#[test]
fn bodies_are_turned_outwards() {
    let corner = |i: u32| [f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)];
    let unit: Vec<[f64; 3]> = (0..8).map(corner).collect();
    let polyhedron = vec![4, 3, 0, 1, 2, 3, 0, 1, 4, 3, 1, 2, 4, 3, 2, 0, 4];
    for (cell, points, volume_of_it, triangles) in [
        (10, vec![0, 1, 2, 4], 1.0 / 6.0, 4),
        (10, vec![0, 2, 1, 4], 1.0 / 6.0, 4),
        (11, (0..8).collect(), 1.0, 12),
        (12, vec![0, 1, 3, 2, 4, 5, 7, 6], 1.0, 12),
        (13, vec![0, 1, 2, 4, 5, 6], 0.5, 8),
        (13, vec![4, 5, 6, 0, 1, 2], 0.5, 8),
        (14, vec![0, 1, 3, 2, 4], 1.0 / 3.0, 6),
        (42, polyhedron, 1.0 / 6.0, 4),
    ] {
        let grid = Grid {
            points: unit.clone(),
            cells: vec![(cell, points)],
            ..Grid::default()
        };
        let form = Form::Legacy {
            version: "4.2",
            is_binary: true,
        };
        let mesh = load(&grid.write(form)).columns;
        assert_eq!(mesh.triangles.len(), triangles, "{cell}");
        assert!(
            (volume(&mesh) - volume_of_it).abs() < 1e-6,
            "{cell}: {}",
            volume(&mesh)
        );
    }
}

/// A quadratic tetrahedron whose edges bulge, and a quadratic triangle.
#[test]
fn points_between_corners_are_shown() {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut points = corners.to_vec();
    for [a, b] in [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]] {
        points.push([0, 1, 2].map(|i: usize| f64::midpoint(corners[a][i], corners[b][i])));
    }
    let mut grid = Grid {
        points,
        cells: vec![(24, (0..10).collect())],
        ..Grid::default()
    };
    let mesh = load(&grid.write(forms()[0])).columns;
    assert_eq!((mesh.triangles.len(), mesh.x.len()), (16, 10));
    assert!((volume(&mesh) - 1.0 / 6.0).abs() < 1e-6);
    grid.cells[0].1.swap(0, 1);
    grid.cells[0].1.swap(5, 6);
    grid.cells[0].1.swap(7, 8);
    assert!((volume(&load(&grid.write(forms()[0])).columns) - 1.0 / 6.0).abs() < 1e-6);
    grid.cells = vec![(22, vec![0, 1, 2, 4, 5, 6]), (22, vec![0, 1])];
    let mesh = load(&grid.write(forms()[0]));
    assert_eq!(mesh.columns.triangles.len(), 4);
    assert_eq!(mesh.notes, ["a.vtk: left out: 1 cell with too few points"]);
}

#[test]
fn pieces_and_ghosts() {
    let mut grids = [boxes(), boxes()];
    grids[1].of_cells.push(Values {
        name: "vtkGhostType",
        kind: "UInt8",
        components: 1,
        values: vec![1.0, 0.0],
    });
    for format in ["ascii", "raw"] {
        let bytes = document(&[&grids[0], &grids[1]], format, Binary::default());
        // The ghost hides the face that it shares.
        assert_eq!(load(&bytes).columns.triangles.len(), 30);
        let listed = read(&bytes, Wanted::Ranges).expect("a mesh").scalars.listed;
        let found: Vec<_> = listed
            .iter()
            .map(|scalar| (&scalar.name[..], scalar.of, scalar.range.0))
            .collect();
        assert_eq!(
            found,
            [
                ("pressure", Owner::Vertices, Some([-0.5, 10.5])),
                ("velocity.x", Owner::Vertices, Some([0.0, 33.0])),
                ("velocity.y", Owner::Vertices, Some([0.0, 44.0])),
                ("velocity.z", Owner::Vertices, Some([0.0, 0.0])),
                ("velocity.magnitude", Owner::Vertices, Some([0.0, 55.0])),
                ("id", Owner::Faces, Some([7.0, 9.0])),
            ]
        );
    }
}

#[test]
fn names_that_are_not_there() {
    let bytes = boxes().write(forms()[0]);
    let refused = |name: &str| read(&bytes, named(name)).expect_err("no such numbers");
    assert_eq!(
        refused("presure"),
        "a.vtk: no scalar property `presure`: the file has `pressure`, `velocity.x`, `velocity.y`, `velocity.z`, \
         `velocity.magnitude` of vertices and `id` of faces; x, y and z are the coordinates"
    );
    assert_eq!(
        refused("velocity"),
        "a.vtk: `velocity` of vertices has 3 numbers for each, expected one of them, such as `velocity.magnitude`"
    );
}

#[test]
fn points_and_lines() {
    let points = load(&legacy("POLYDATA\nPOINTS 2 float\n0 0 0 1 1 1"));
    assert!(points.cloud.is_some() && points.columns.x.len() == 2);
    let lines =
        format!("POLYDATA\n{SQUARE}LINES 1 4\n3 0 1 2\nCELL_DATA 1\nSCALARS a int\nLOOKUP_TABLE default\n5");
    let mesh = read(&legacy(&lines), named("a")).expect("lines");
    assert_eq!(mesh.cloud.as_ref().expect("lines").lines, [[0, 1], [1, 2]]);
    assert_eq!(numbers(&mesh), [5.0; 3]);
    let dots = load(&legacy(&format!("POLYDATA\n{SQUARE}VERTICES 1 3\n2 3 1")));
    assert_eq!(dots.columns.x, [1.0, 0.0]);
    let faces = load(&legacy(&format!(
        "POLYDATA\n{SQUARE}LINES 1 3\n2 0 1\nTRIANGLE_STRIPS 1 5\n4 0 1 3 2"
    )));
    assert_eq!(faces.columns.triangles, [[0, 1, 3], [3, 1, 2]]);
    assert_eq!(faces.notes, ["a.vtk: left out: 1 line beside faces"]);
}

#[test]
fn attributes_of_legacy_files() {
    let text = format!(
        "POLYDATA\nFIELD FieldData 1\nTIME 1 1 double\n0.5\n{SQUARE}METADATA\nINFORMATION 1\nNAME a LOCATION b\n\nPOLYGONS 1 5 4 0 1 2 3\n\
         POINT_DATA 4\nCOLOR_SCALARS shade 3 1 0 0 0 1 0 0 0 1 0.5 0.5 0.5\n\
         FIELD f 2\nnames 1 2 string\nfirst one\nsecond\na%20b 1 4 float 1 2 3 4\nMETADATA\nCOMPONENT_NAMES\nx\n\n\
         VECTORS v float 1 2 3 1 2 3 1 2 3 1 2 3\nLOOKUP_TABLE t 1\n0 0 0 1\n"
    );
    let mesh = read(&legacy(&text), Wanted::Ranges).expect("a mesh");
    assert_eq!(mesh.columns.colors[3], [0.5; 3]);
    let ranges: Vec<Range> = mesh.scalars.listed.iter().map(|scalar| scalar.range).collect();
    assert_eq!(ranges[0], Range(Some([1.0, 4.0])));
    assert_eq!((mesh.scalars.listed[0].name.as_str(), ranges.len()), ("a b", 5));
    let mesh = read(&legacy(&text), named("v.z")).expect("numbers");
    assert_eq!(numbers(&mesh), [3.0; 4]);
}

#[test]
fn unusable_points_and_other_cells() {
    let text = format!(
        "UNSTRUCTURED_GRID\n{}CELLS 3 12\n3 0 1 2 3 0 2 3 3 0 1 3\nCELL_TYPES 3\n5 5 41",
        SQUARE.replace("0 1 0\n", "nan 1 0\n")
    );
    let mesh = load(&legacy(&text));
    assert_eq!(mesh.columns.triangles, [[0, 1, 2]]);
    assert_eq!(
        mesh.notes,
        [
            "a.vtk: left out: 1 cell of type 41 (convex point sets), 1 vertex that is NaN or too large, 1 triangle that uses it"
        ]
    );
    let error = read(&legacy("POLYDATA\nPOINTS 1 float\n0 inf 0"), Wanted::Nothing);
    assert!(error.expect_err("no point").starts_with("a.vtk:6:"));
}

/// Coordinates far from 0 keep their digits.
#[test]
fn map_coordinates() {
    let text = "POLYDATA\nPOINTS 3 double\n500000.125 4000000 1 500001 4000000 1 500000.125 4000001.5 1\nPOLYGONS 1 4\n3 0 1 2";
    let open = &mut |_: &Path| Err(std::io::ErrorKind::NotFound.into());
    let mesh = super::super::mesh::parse(legacy(text), Path::new("a.vtk"), open).expect("a mesh");
    let x = |i: usize| f64::from(mesh.columns.x[i]) + mesh.offset.x;
    assert_eq!([x(0), x(1)], [500_000.125, 500_001.0]);
}

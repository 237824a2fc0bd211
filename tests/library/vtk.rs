//! VTK files: seeds of the fuzz target, and files that are cut, flipped, and repeat parts of themselves.

use crate::seeds::Seed;

#[path = "../../src/format/vtk/tests/files.rs"]
mod files;

use files::{Array, Form, Grid, document, forms};

/// Cells of all kinds, in each form that is read in another way.
pub fn seeds() -> Vec<Seed> {
    let corner = |i: u32| [f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)];
    let array = |name, kind, components: usize, count: usize| Array {
        name,
        kind,
        components,
        values: (0..components * count).map(|i| i as f64).collect(),
    };
    let grid = Grid {
        points: (0..8).map(corner).collect(),
        cells: vec![
            (12, vec![0, 1, 3, 2, 4, 5, 7, 6]),
            (11, (0..8).collect()),
            (13, vec![0, 1, 2, 4, 5, 6]),
            (14, vec![0, 1, 3, 2, 4]),
            (24, vec![0, 1, 2, 4, 3, 5, 6, 7, 0, 1]),
            (22, vec![0, 1, 2, 3, 4, 5]),
            (6, vec![0, 1, 2, 3]),
            (8, vec![4, 5, 6, 7]),
            (4, vec![0, 7, 3]),
            (1, vec![5]),
            (41, vec![0, 1, 2, 4]),
        ],
        of_points: vec![array("RGB", "UInt8", 3, 8), array("Normals", "Float32", 3, 8)],
        of_cells: vec![array("id", "Int32", 1, 11), array("vtkGhostType", "UInt8", 1, 11)],
    };
    let mut seeds = Vec::new();
    for (i, form) in forms().into_iter().enumerate() {
        let is_seed = match form {
            Form::Xml(_, binary) => binary.is_big != binary.is_wide,
            Form::Legacy { .. } => true,
        };
        if is_seed || i == 0 {
            seeds.push(("vtk", format!("made-{i}.vtk"), grid.write(form)));
        }
    }
    let lines = "# vtk DataFile Version 4.2\nt\nASCII\nDATASET POLYDATA\nPOINTS 3 double\n0 0 0 1 0 0 0 1 0\n\
        METADATA\nINFORMATION 0\n\nVERTICES 1 2\n1 2\nLINES 1 4\n3 0 1 2\nPOLYGONS 1 4\n3 0 1 2\nTRIANGLE_STRIPS 1 4\n3 0 1 2\n\
        POINT_DATA 3\nSCALARS a float 1\nLOOKUP_TABLE default\n1 2 3\nCOLOR_SCALARS c 3\n1 0 0 0 1 0 0 0 1\n\
        NORMALS n float\n0 0 1 0 0 1 0 0 1\nFIELD f 1\ns 1 2 string\na\nb\nCELL_DATA 4\nVECTORS v int\n1 2 3 4 5 6 7 8 9 0 1 2\n";
    seeds.push(("vtk", "made-lines.vtk".to_owned(), lines.into()));
    let pieces = document(&[&grid, &grid], "ascii", files::Binary::default());
    seeds.push(("vtk", "made-pieces.vtk".to_owned(), pieces));
    seeds
}

#[test]
fn broken_files() {
    let mut random = fastrand::Rng::with_seed(7);
    for (_, name, seed) in seeds() {
        for round in 0..300 {
            let bytes = crate::seeds::broken(&seed, &mut random);
            println!("{name}, round {round}");
            crate::targets::vtk(&bytes);
        }
    }
}

//! Files that are wrong: each is refused with one sentence, soon and within its memory.

use super::*;
use std::time::{Duration, Instant};

fn refused(bytes: &[u8]) -> String {
    let start = Instant::now();
    let error = read(bytes, Wanted::Nothing).expect_err("a wrong file");
    assert!(start.elapsed() < Duration::from_secs(5), "{error}");
    error
}

#[test]
fn legacy_files() {
    let grid = |rest: &str| legacy(&format!("UNSTRUCTURED_GRID\n{SQUARE}{rest}"));
    for (bytes, expected) in [
        (
            grid("CELLS 1 4\n3 0 1 9\nCELL_TYPES 1\n5"),
            "a.vtk:8:7: vertex 9 in `CELLS`, expected 0 to 3",
        ),
        (
            grid("CELLS 1 4\n3 0 1 x\nCELL_TYPES 1\n5"),
            "a.vtk:8:7: found `x` in `CELLS`, expected a whole number",
        ),
        (
            grid("CELLS 1 4\n3 0 1 -1\nCELL_TYPES 1\n5"),
            "a.vtk:8:7: vertex -1 in `CELLS`, expected 0 to 3",
        ),
        (
            grid("CELLS 1 4\n7 0 1 2\nCELL_TYPES 1\n5"),
            "a.vtk:8:7: `CELLS` ends too early, expected more numbers",
        ),
        (
            grid("CELLS 1 4\n3 0 1 2"),
            "a.vtk: the file has `CELLS`, but no `CELL_TYPES`",
        ),
        (
            grid("CELLS 1000000000000000000 4\n3 0 1 2\nCELL_TYPES 1\n5"),
            "a.vtk:9:1: `CELL_TYPES` has at most 1 numbers, expected 10",
        ),
        (
            grid("CELLS 1 1000000000000000000\n3 0 1 2"),
            "a.vtk:7:1: the file ends before the 1000000000000000000 numbers",
        ),
        (
            legacy("POLYDATA\nPOINTS 18446744073709551615 float\n0"),
            "a.vtk:5:1: the file ends before",
        ),
        (
            legacy("POLYDATA\nPOINTS 1 flaot\n0 0 0"),
            "a.vtk:5:1: `flaot` is not a type that octray reads",
        ),
        (
            legacy("POLYDATA\nPOINT 1 float\n0 0 0"),
            "a.vtk:5:1: found `POINT`, expected a section such as `POINTS`",
        ),
        (
            legacy("STRUCTURED_POINTS\nDIMENSIONS 1 1 1"),
            "a.vtk:4:9: this is a VTK file of the type `STRUCTURED_POINTS`, which octray does not read; convert it to .vtp",
        ),
        (
            b"# vtk DataFile Version 3.0\n".to_vec(),
            "a.vtk:2:1: the file ends before `ASCII` or `BINARY`",
        ),
        (b"".to_vec(), "a.vtk: the file is empty, expected a VTK mesh"),
        (
            b"# vtk DataFile Version 3.0\nt\nBINARY\nDATASET POLYDATA\nPOINTS 400 float\n0000".to_vec(),
            "a.vtk: the file ends before the 4800 bytes of `POINTS`",
        ),
    ] {
        let error = refused(&bytes);
        assert!(error.starts_with(expected), "{error}\nexpected {expected}");
    }
}

#[test]
fn xml_files() {
    let text = String::from_utf8(boxes().write(Form::Xml("binary", Binary::default()))).expect("text");
    let changed = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        refused(text.replacen(from, to, 1).as_bytes())
    };
    for (from, to, expected) in [
        (
            "\"UnstructuredGrid\"",
            "\"ImageData\"",
            "a.vtk:2:16: this is a VTK file of the type `ImageData`, which octray",
        ),
        (
            "header_type=\"UInt32\"",
            "header_type=\"UInt16\"",
            "a.vtk:2:87: found `UInt16`, expected `UInt32` or",
        ),
        (
            "UInt32\">",
            "UInt32\" compressor=\"vtkLZ4DataCompressor\">",
            "a.vtk:2:107: compressed by `vtkLZ4DataCompressor`, which octray",
        ),
        (
            "NumberOfPoints=\"12\"",
            "NumberOfPoints=\"1000000000000000000\"",
            "a.vtk:",
        ),
        ("NumberOfCells=\"2\"", "NumberOfCells=\"3\"", "a.vtk:"),
        (
            "Name=\"offsets\"",
            "Name=\"offset\"",
            "a.vtk:4:1: the piece has cells, but no array `offsets`",
        ),
        ("format=\"binary\"", "format=\"zip\"", "a.vtk:"),
        ("</Piece>", "", "a.vtk:"),
        (
            "=\"Points\" NumberOfComponents=\"3\"",
            "=\"Points\" NumberOfComponents=\"2\"",
            "a.vtk:",
        ),
    ] {
        let error = changed(from, to);
        assert!(error.starts_with(expected), "{error}\nexpected {expected}");
    }
    let deep = "<a>".repeat(100_000);
    assert!(
        refused(format!("<VTKFile type=\"PolyData\">{deep}").as_bytes()).contains("nest more than 64 deep")
    );
}

/// Offsets beyond the data, blocks that do not exist, and arrays that inflate to more than memory.
#[test]
fn binary_data() {
    let compressed = Binary {
        is_compressed: true,
        is_wide: true,
        ..Binary::default()
    };
    let bytes = boxes().write(Form::Xml("raw", compressed));
    let at = bytes
        .windows(2)
        .position(|part| part == b"\n_")
        .expect("appended data")
        + 2;
    let put = |offset: usize, number: u64| {
        let mut bytes = bytes.clone();
        bytes[at + offset..][..8].copy_from_slice(&number.to_le_bytes());
        read(&bytes, named("pressure"))
    };
    for number in [1 << 20, 1 << 40, 1 << 60, u64::MAX] {
        for offset in [0, 8, 16, 24, 32] {
            let error = put(offset, number).expect_err("a wrong header");
            assert!(error.contains("the data of `pressure`: "), "{error}");
        }
    }
    let text = boxes().write(Form::Xml("base64", Binary::default()));
    let text = String::from_utf8(text).expect("text");
    let offset = text.replacen("offset=\"0\"", "offset=\"99999\"", 1);
    let error = read(offset.as_bytes(), named("pressure")).expect_err("no data");
    assert!(
        error.contains("begin at byte 99999 of the appended data, beyond its end"),
        "{error}"
    );
    // Zeros of 16 MB in 16 kB.
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    let size = 16_u64 << 20;
    std::io::copy(&mut std::io::Read::take(std::io::repeat(0), size), &mut encoder).expect("memory");
    let block = encoder.finish().expect("memory");
    let mut bomb = b"<VTKFile type=\"PolyData\" header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\"><PolyData>\
        <Piece NumberOfPoints=\"9\"><Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"appended\" offset=\"0\"/>\
        </Points></Piece></PolyData><AppendedData encoding=\"raw\">_"
        .to_vec();
    for number in [1, size, 0, block.len() as u64] {
        bomb.extend(number.to_le_bytes());
    }
    bomb.extend(block);
    let budget = Budget::new(8 << 20);
    let error = parse(&bomb, Path::new("a.vtp"), &budget)
        .expect_err("too large")
        .to_string();
    assert!(error.contains("above the memory limit"), "{error}");
    assert_eq!(read(&bomb, Wanted::Nothing).expect("points").columns.x.len(), 9);
}

/// Every cut of a file is refused or loaded.
#[test]
fn cut_files() {
    for form in forms() {
        let bytes = boxes().write(form);
        for end in (0..bytes.len()).step_by(29) {
            let cut = bytes.get(..end).unwrap_or_default();
            if cut.len() > 64 {
                drop(read(cut, Wanted::Ranges));
                drop(read(cut, named("velocity.x")));
            }
        }
    }
}

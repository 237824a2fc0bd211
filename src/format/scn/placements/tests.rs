use super::*;

fn all(bytes: &[u8]) -> Result<Vec<Rows>, String> {
    let mut all = Vec::new();
    let take = |rows| {
        all.push(rows);
        Ok(())
    };
    let outcome = read(bytes, Path::new("p.txt"), &Budget::unlimited(), take);
    outcome
        .map(|count| {
            assert_eq!(count, all.len());
            all
        })
        .map_err(|error| error.to_string())
}

fn numpy(header: &str, data: &[u8]) -> Vec<u8> {
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(data);
    bytes
}

#[test]
fn text_has_positions_and_matrices() {
    let found =
        all(b"# trees\n1 2 3\n\n0 -1 0 4  1 0 0 5  0 0 1 6 // turned\n1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1");
    let found = found.unwrap();
    assert_eq!(
        found[0],
        [[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 2.0], [0.0, 0.0, 1.0, 3.0]]
    );
    assert_eq!(
        found[1],
        [[0.0, -1.0, 0.0, 4.0], [1.0, 0.0, 0.0, 5.0], [0.0, 0.0, 1.0, 6.0]]
    );
    assert_eq!(found.len(), 3);
}

#[test]
fn arrays_have_the_same() {
    let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }          \n";
    let numbers: Vec<u8> = [1.0_f32, 2.0, 3.0, 4.0, 5.0, 6.0]
        .iter()
        .flat_map(|n| n.to_le_bytes())
        .collect();
    let found = all(&numpy(header, &numbers)).unwrap();
    assert_eq!(
        found.iter().map(|rows| rows[1][3]).collect::<Vec<_>>(),
        [2.0, 5.0]
    );
    let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (1, 4, 4), }\n";
    let mut matrix = [0.0_f64; 16];
    for i in [0, 5, 10, 15] {
        matrix[i] = 1.0;
    }
    let numbers: Vec<u8> = matrix.iter().flat_map(|n| n.to_le_bytes()).collect();
    assert_eq!(all(&numpy(header, &numbers)).unwrap()[0][2], [0.0, 0.0, 1.0, 0.0]);
}

#[test]
fn faults_are_told() {
    let shape = |shape: &str, data: &[u8]| {
        let header = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}");
        all(&numpy(&header, data)).unwrap_err()
    };
    assert!(shape("(2, 5)", &[]).contains("another shape"));
    assert!(shape("(2, 3)", &[0; 23]).contains("23 bytes"));
    assert!(shape("(18446744073709551615, 3)", &[]).contains("bytes"));
    assert!(all(b"\x93NUMPY\x01\x00\xff\xff{").unwrap_err().contains("header"));
    assert!(
        all(b"1 2 3\n1 2")
            .unwrap_err()
            .starts_with("p.txt:2:1: a placement of 2 numbers")
    );
    assert!(
        all(b"1 x 3")
            .unwrap_err()
            .starts_with("p.txt:1:3: found `x`, expected a number")
    );
    assert!(all(b"nan 0 0").unwrap_err().contains("up to 1e9"));
    assert!(all(&b"1 ".repeat(20)).unwrap_err().contains("20 numbers"));
}

/// Files of other kinds are named, without their bytes.
#[test]
fn other_files_are_named() {
    for (bytes, expected) in [
        (
            &b"PK\x03\x04\x14\x00arr_0.npy"[..],
            "p.txt: this is a ZIP archive",
        ),
        (b"\xff\xfe1\0 \x002\0 \x003\0", "p.txt: this is UTF-16"),
        (b"\x00\x00\x80\x3f", "p.txt: this is binary data"),
        (b"\xcd\xcc\xcc\x3d\xcd\xcc\xcc\x3d", "p.txt: this is binary data"),
        (b"1 2 3\r4 5 6\r7 8 9\r1 2 3\r", "p.txt: its lines end in CR only"),
        (
            b"version https://git-lfs.github.com/spec/v1\n",
            "p.txt: a Git LFS pointer",
        ),
    ] {
        let error = all(bytes).expect_err("another file");
        assert!(error.starts_with(expected), "{error}");
    }
    // An aborted numpy.save.
    let empty = |name: &str| {
        read(b"", Path::new(name), &Budget::unlimited(), |_| Ok(())).map_err(|error| error.to_string())
    };
    let expected = "p.npy: the file is empty, expected a numpy array".to_owned();
    assert_eq!([empty("p.npy"), empty("p.txt")], [Err(expected), Ok(0)]);
}

#[test]
fn words_that_are_no_numbers() {
    for (text, expected) in [
        (
            "1,2,3",
            "`1,2,3`, expected a number, with spaces instead of commas",
        ),
        (
            "1, 2, 3",
            "`1,`, expected a number, with spaces instead of commas",
        ),
        ("1,x", "`1,x`, expected a number"),
        (
            "-1,5 2,0 3,0",
            "`-1,5`, expected a number with a decimal point instead of the comma",
        ),
        (
            "1 2,5e3 0",
            "`2,5e3`, expected a number with a decimal point instead of the comma",
        ),
        ("1,+5", "`1,+5`, expected a number, with spaces instead of commas"),
        (
            "1.5,2",
            "`1.5,2`, expected a number, with spaces instead of commas",
        ),
        (
            "inf,5",
            "`inf,5`, expected a number, with spaces instead of commas",
        ),
        (
            "\u{feff}1, 2 3",
            "1:1: found `1,`, expected a number, with spaces instead of commas",
        ),
    ] {
        let error = all(text.as_bytes()).expect_err(text);
        assert!(error.ends_with(expected), "{error}");
    }
    assert_eq!(all(b"\xef\xbb\xbf1 2 3\n# caf\xe9\n").map(|all| all.len()), Ok(1));
}

#[test]
fn faults_of_arrays_have_their_index() {
    let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }";
    let mut data = [0; 24];
    data[12..16].copy_from_slice(&f32::NAN.to_le_bytes());
    let error = all(&numpy(header, &data)).expect_err("a NaN");
    assert!(error.contains("array[1]: a placement with NaN"), "{error}");
}

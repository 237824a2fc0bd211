use super::*;

fn all(bytes: &[u8]) -> Result<Vec<Rows>, String> {
    let mut all = Vec::new();
    let take = |rows| {
        all.push(rows);
        Ok(())
    };
    let outcome = read(bytes, Path::new("p.txt"), take);
    outcome.map(|()| all).map_err(|error| error.to_string())
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

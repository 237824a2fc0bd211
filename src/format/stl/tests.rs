use super::*;
use crate::format::mesh::Surface;

fn binary_file(name: &[u8], facets: &[[f32; 9]]) -> Vec<u8> {
    let mut bytes = name.to_vec();
    bytes.resize(80, b' ');
    bytes.extend((facets.len() as u32).to_le_bytes());
    for facet in facets {
        bytes.extend([0; 12]);
        bytes.extend(facet.iter().flat_map(|value| value.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

fn load(bytes: &[u8]) -> Result<TriangleMesh, String> {
    let mesh = parse(bytes, Path::new("a.stl"), &Budget::unlimited());
    mesh.map(|mesh| mesh.columns)
        .map_err(|error| error.to_string().trim_start_matches("a.stl:").to_owned())
}

const FACETS: [[f32; 9]; 2] = [
    [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.5],
    [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.5],
];

const TEXT: &str = "solid\nfacet normal nan 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0.5\nendloop\nendfacet\n\
    endsolid\nSOLID the second\n FACET NORMAL 0 0 1 OUTER LOOP VERTEX 1 2 3 VERTEX 4 5 6 VERTEX 7 8 9.5 ENDLOOP ENDFACET\n\
    ENDSOLID solid facet\n";

#[test]
fn text_and_binary_are_the_same_mesh() {
    let text = load(TEXT.as_bytes()).expect("text");
    // A binary file may begin with `solid`.
    for name in [&b"solid gear"[..], b"made by something", b"\0"] {
        let binary = load(&binary_file(name, &FACETS)).expect("binary");
        assert_eq!((&binary.x, &binary.y, &binary.z), (&text.x, &text.y, &text.z));
        assert_eq!(binary.triangles, text.triangles);
    }
    assert_eq!(text.triangles, [[0, 1, 2], [3, 4, 5]]);
    assert_eq!(text.z, [0.0, 0.0, 0.5, 3.0, 6.0, 9.5]);
}

#[test]
fn odd_but_fine() {
    assert!(load(&binary_file(b"", &[])).expect("empty").triangles.is_empty());
    assert!(
        load(b"solid nothing\nendsolid nothing")
            .expect("empty")
            .x
            .is_empty()
    );
    for count in [3, 2000] {
        let nul = [TEXT.as_bytes(), &vec![0; count]].concat();
        assert_eq!(load(&nul).expect("text").triangles.len(), 2);
    }
    let mut longer = binary_file(b"trailing bytes", &FACETS);
    longer.extend(b"more");
    assert_eq!(load(&longer).expect("longer").triangles.len(), 2);
    let square = "solid\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid";
    assert_eq!(
        load(square.as_bytes()).expect("a square").triangles,
        [[0, 1, 2], [0, 2, 3]]
    );
}

#[test]
fn counts_that_are_too_small() {
    let with_count = |count: u8| {
        let mut bytes = binary_file(b"", &FACETS);
        bytes[HEADER - 4] = count;
        bytes
    };
    let refused = load(&with_count(0)).expect_err("no facets");
    assert_eq!(refused, " the header promises 0 facets, but 100 bytes follow");
    let mesh = parse(&with_count(1), Path::new("a.stl"), &Budget::unlimited()).expect("a facet");
    assert_eq!(mesh.columns.triangles.len(), 1);
    assert_eq!(
        mesh.notes,
        ["a.stl: left out: 50 bytes after the 1 facet that the header promises"]
    );
}

#[test]
fn faults() {
    let refused = |bytes: &[u8]| load(bytes).expect_err("it is refused");
    assert_eq!(refused(b""), " the file is empty, expected an STL mesh");
    assert!(refused(b"hello").starts_with(" not an STL mesh: text begins with `solid`"));
    let mut cut = binary_file(b"", &FACETS);
    cut.truncate(150);
    assert!(refused(&cut).starts_with(" 2 facets need 100 bytes, but only 66 follow the header"));
    let mut huge = binary_file(b"", &[]);
    huge[80..].fill(0xff);
    assert!(refused(&huge).starts_with(" 4294967295 facets need 214748364750 bytes, but only 0 follow"));
    let mut facets = FACETS;
    (facets[0][4], facets[1][0]) = (f32::NAN, f32::INFINITY);
    assert_eq!(
        refused(&binary_file(b"", &facets)),
        " facet 1 of 2, corner 2: y is NaN, expected a finite number (the facet starts at byte 84)"
    );
    let text = |from: &str, to: &str| refused(TEXT.replacen(from, to, 1).as_bytes());
    assert_eq!(
        text("vertex 1 0 0", "vertex 1 0 x"),
        "5:12: `z` is `x`, expected a number"
    );
    let second = TEXT.find("endsolid").expect("the end of a solid") + "endsolid".len();
    let far = TEXT[..second].replace("vertex 1 0 0", "vertex 1 1e99 0");
    assert_eq!(
        refused(far.as_bytes()),
        "5:10: y is inf, expected a finite number"
    );
    assert_eq!(text("outer", "inner"), "3:1: found `inner`, expected `outer`");
    assert_eq!(
        text("facet normal", "facets normal"),
        "2:1: found `facets`, expected `facet` or `endsolid`"
    );
    assert_eq!(
        text("endsolid", "end"),
        "9:1: found `end`, expected `facet` or `endsolid`"
    );
    assert_eq!(
        text("ENDSOLID solid facet", ""),
        "11:89: the file ends here, expected `endsolid`"
    );
    assert_eq!(
        refused(&TEXT.as_bytes()[..60]),
        "5:9: the file ends here, expected a number"
    );
}

/// The colours of the facets, and the notes, of a file whose facets have these attributes.
fn colors(header: &[u8], attributes: &[u16]) -> (Vec<[f32; 3]>, Vec<String>) {
    let facets: Vec<[f32; 9]> = attributes.iter().map(|_| FACETS[0]).collect();
    let mut bytes = binary_file(header, &facets);
    for (facet, attributes) in bytes[HEADER..].chunks_exact_mut(FACET).zip(attributes) {
        facet[FACET - 2..].copy_from_slice(&attributes.to_le_bytes());
    }
    let mesh = parse(&bytes, Path::new("a.stl"), &Budget::unlimited()).expect("a mesh");
    let color = |&surface: &u32| mesh.surfaces[surface as usize].diffuse;
    (mesh.surface_of.iter().map(color).collect(), mesh.notes)
}

const NEUTRAL: [f32; 3] = Surface::NEUTRAL.diffuse;
const RED: [f32; 3] = [1.0, 0.0, 0.0];
const BLUE: [f32; 3] = [0.0, 0.0, 1.0];

#[test]
fn colours_of_facets() {
    // VisCAM and SolidView: bit 15 says that there is one, and red is the highest.
    let (found, notes) = colors(
        b"made by something",
        &[0x8000 | 31 << 10, 0x1f, 0x8000 | 31, 0x8000 | 31 << 10],
    );
    assert_eq!(found, [RED, NEUTRAL, BLUE, RED]);
    assert!(notes.is_empty(), "{notes:?}");
    // One colour for all.
    assert_eq!(colors(b"", &[0x801f; 3]).0, [BLUE; 3]);
    // The first colour may come late.
    let mut late = [0; 2 * PIECE + 1];
    late[2 * PIECE] = 0x801f;
    let (found, notes) = colors(b"", &late);
    assert_eq!((found[0], found[2 * PIECE]), (NEUTRAL, BLUE));
    assert!(notes.is_empty(), "{notes:?}");
    // Magics: bit 15 means the default, and red is in the lowest bits.
    let magics = b"Magics COLOR=\x00\xff\x33\xff,MATERIAL=";
    let (found, notes) = colors(magics, &[31, 0x8000, 31 << 10, 0xffff]);
    assert_eq!(found, [RED, [0.0, 1.0, 0.2], BLUE, [0.0, 1.0, 0.2]]);
    assert!(notes.is_empty(), "{notes:?}");
    // Only the header's colour is meant.
    assert_eq!(colors(magics, &[0; 2]).0, [[0.0, 1.0, 0.2]; 2]);
    // Whatever its alpha is, it is opaque.
    assert_eq!(colors(b"COLOR=\x00\xff\x33\x00", &[0; 2]).0, [[0.0, 1.0, 0.2]; 2]);
    // MeshLab writes that header, but bit 15 means a colour, red in the lowest bits.
    let grey = [0x7f as f32 / 255.0; 3];
    for header in [
        &b"COLOR=\x7f\x7f\x7f MATERIAL=\x7f\x7f\x7f "[..],
        b"COLOR=\x7f\x7f\x7f\xff",
    ] {
        assert_eq!(colors(header, &[0x801f, 0xfc00]).0, [RED, BLUE]);
    }
    let meshlab = b"COLOR=\x7f\x7f\x7f MATERIAL=";
    assert_eq!(colors(meshlab, &[0x801f; 2]).0, [RED; 2]);
    assert_eq!(colors(b"COLOR=\x7f\x7f\x7f\xff", &[0x801f; 2]).0, [grey; 2]);
    // A colour belongs to its facet, also if another one is left out.
    let mut bytes = binary_file(b"", &[FACETS[0], FACETS[0]]);
    bytes[HEADER + 12..][..4].copy_from_slice(&f32::NAN.to_le_bytes());
    for (at, attributes) in [(FACET, 0xfc00_u16), (2 * FACET, 0x801f)] {
        bytes[HEADER + at - 2..][..2].copy_from_slice(&attributes.to_le_bytes());
    }
    let mesh = parse(&bytes, Path::new("a.stl"), &Budget::unlimited()).expect("a mesh");
    assert_eq!(mesh.surface_of.len(), 1);
    assert_eq!(mesh.surfaces[mesh.surface_of[0] as usize].diffuse, BLUE);
}

#[test]
fn attributes_that_are_no_colours() {
    // Nothing, and padding.
    for attributes in [0, 0x2020, 0xffff] {
        assert_eq!(colors(b"made by something", &[attributes; 2]), (vec![], vec![]));
    }
    // A header that ends within its colour.
    let mut header = [b' '; 80];
    header[72..].copy_from_slice(b"COLOR=ab");
    assert_eq!(colors(&header, &[0; 2]), (vec![], vec![]));
    let (found, notes) = colors(b"", &[1, 2]);
    assert_eq!(
        (found.len(), notes),
        (0, vec!["a.stl: left out: attribute bytes of facets".to_owned()])
    );
}

#[test]
fn colours_beyond_the_first_piece() {
    let mut attributes = vec![0x801f; PIECE + 1];
    attributes.push(0xfc00);
    let (found, _) = colors(b"", &attributes);
    assert_eq!((found[PIECE], found[PIECE + 1]), (BLUE, RED));
}

#[test]
fn carriage_returns_alone_end_lines() {
    let text = TEXT
        .replace('\n', "\r")
        .replace("solid\r", "solid of some name\r");
    assert_eq!(
        load(text.as_bytes()).expect("text").triangles,
        [[0, 1, 2], [3, 4, 5]]
    );
}

#[test]
fn concave_polygons_are_filled() {
    let text = "solid\nfacet normal 0 0 1\nouter loop\nvertex -1 0 0\nvertex 0 1 0\nvertex 1 0 0\nvertex 0 2 0\n\
        endloop\nendfacet\nendsolid\n";
    let triangles = load(text.as_bytes()).expect("a mesh").triangles;
    // The side between the notch and the tip, whichever comes first.
    assert_eq!(triangles.len(), 2);
    assert!(
        triangles.iter().all(|t| t.contains(&1) && t.contains(&3)),
        "{triangles:?}"
    );
}

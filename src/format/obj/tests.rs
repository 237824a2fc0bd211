use super::*;
use std::io;

fn load(text: &str, mtl: &str) -> Result<LoadedMesh, LoadError> {
    parse(
        text.as_bytes(),
        Path::new("folder/a.obj"),
        &mut |path| match path.to_str() {
            Some("folder/a b.mtl") => Ok(mtl.into()),
            _ => Err(io::ErrorKind::NotFound.into()),
        },
        &Budget::unlimited(),
    )
}

fn mesh(text: &str) -> LoadedMesh {
    load(text, "").unwrap_or_else(|error| panic!("{error}"))
}

fn fault(text: &str) -> String {
    let error = load(text, "").expect_err("it is refused").to_string();
    error.trim_start_matches("folder/a.obj:").to_owned()
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

#[test]
fn polygons_become_fans_and_indices_count_from_either_end() {
    let expected = [[0, 1, 2], [0, 2, 3]];
    for face in [
        "f 1 2 3 4",
        "f -4 -3 -2 -1",
        "f 1/1 2/1 3/1 4/1 # a square",
        "f 1 2 \\\n 3 4",
        "f\t+1 2 3 4\r",
    ] {
        let mesh = mesh(&format!("# x\r\n{SQUARE}vt 0\n{face}\nf -4 -3 -1"));
        assert_eq!(mesh.columns.triangles[..2], expected, "{face}");
        assert_eq!(mesh.columns.triangles[2..], [[0, 1, 3]]);
        assert_eq!(mesh.columns.x, [0.0, 1.0, 1.0, 0.0]);
        assert!(mesh.columns.normals.is_empty() && mesh.surfaces.is_empty() && mesh.surface_of.is_empty());
    }
    // An index may point ahead.
    assert_eq!(mesh(&format!("f 1 2 3\n{SQUARE}")).columns.triangles, [[0, 1, 2]]);
}

#[test]
fn a_position_with_two_normals_becomes_two_vertices() {
    let text = format!("{SQUARE}vn 0 0 1\nvn 1 0 0\nf 1//1 2//1 3//1\nf 1//2 3//1 4//-1\nf 1 2 3\n");
    let mesh = mesh(&text).columns;
    assert_eq!(mesh.triangles, [[0, 1, 2], [4, 2, 3], [5, 6, 7]]);
    assert_eq!(mesh.x, [0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0]);
    let (z, x, none) = (glam::Vec3::Z, glam::Vec3::X, glam::Vec3::ZERO);
    assert_eq!(mesh.normals, [z, z, z, x, x, none, none, none]);
}

#[test]
fn a_library_may_come_after_its_names() {
    let text =
        format!("{SQUARE}usemtl red\nf 1 2 3\nusemtl no\nf 1 2 3\nmtllib a b.mtl\nusemtl red\nf 1 2 4\n");
    let mesh = load(&text, "newmtl blue\nKd 0 0 1\nnewmtl red\nKd 1 0 0\n").expect("a mesh");
    assert_eq!(mesh.surface_of, [1, 2, 1]);
    assert_eq!(mesh.surfaces[1].diffuse, [1.0, 0.0, 0.0]);
    assert_eq!(
        mesh.notes,
        ["folder/a.obj: no material library has `no`: shown in grey"]
    );
}

#[test]
fn materials() {
    let mtl = "Kd 9 9 9\nnewmtl a\nKd 0.5\nnewmtl two words\nKd 0 1.5 0.25 # c\nKs 0.5 0.5 0.5\nNs 80.5\n\
        newmtl dull\nKD 1 0 0\nKs 1 1 1\nNs 0\nnewmtl odd\nKd spectral x.rfl\nmap_Kd x.png\n";
    let text = format!(
        "mtllib a b.mtl\n{SQUARE}f 1 2 3\nusemtl two words\nf 1 2 3 4\nusemtl dull\nf 1 2 3\nusemtl no\nf 1 2 3"
    );
    let mesh = load(&text, mtl).expect("a mesh");
    assert_eq!(mesh.surfaces.len(), 5);
    assert_eq!(mesh.surface_of, [4, 1, 1, 2, 4]);
    assert_eq!(mesh.surfaces[0].diffuse, [0.5; 3]);
    let expected = Surface {
        diffuse: [0.0, 1.0, 0.25],
        specular: [0.5; 3],
        alpha: 80,
        ..Surface::NEUTRAL
    };
    assert_eq!(mesh.surfaces[1], expected);
    assert_eq!(mesh.surfaces[2].specular, [0.0; 3]);
    for (exponent, specular) in [(1.0, 0.0), (5.5, 0.25), (10.0, 0.5), (900.0, 0.5)] {
        let mtl = format!("newmtl a\nKs 0.5\nNs {exponent}\n");
        let mesh = load(&format!("mtllib a b.mtl\n{SQUARE}usemtl a\nf 1 2 3"), &mtl).expect("a mesh");
        assert_eq!(mesh.surfaces[0].specular, [specular; 3], "Ns {exponent}");
    }
    assert_eq!(mesh.surfaces[4], Surface::NEUTRAL);
    assert_eq!(
        mesh.notes,
        [
            "folder/a b.mtl:5:1: `Kd` above 1, taken as 1",
            "folder/a b.mtl:13:1: `Kd` without valid numbers, ignored",
            "folder/a.obj: no material library has `no`: shown in grey"
        ]
    );
    let missing = load(&format!("mtllib no.mtl\nusemtl a\n{SQUARE}f 1 2 3"), "").expect("a mesh");
    assert_eq!(
        missing.notes,
        ["folder/no.mtl: file not found; its materials are missing"]
    );
}

#[test]
fn normals_that_are_missing_are_not_used() {
    let found = mesh(&format!("{SQUARE}f 1//1 2//2 3//9"));
    assert!(found.columns.normals.is_empty());
    assert_eq!(
        found.notes,
        ["folder/a.obj: left out: indices of normals, since there are no normals"]
    );
    assert_eq!(found.columns.triangles, [[0, 1, 2]]);
}

#[test]
fn what_is_not_read_is_said() {
    let text = format!(
        "{SQUARE}vt 0 0\nvt 1 1\nf 1 2 3\nl 1 2\nl 2 3 4\np 1\ng a\ns 1\ncstype bezier\ncurv 0 1 1 2\n# end\n"
    );
    assert_eq!(
        mesh(&text).notes,
        [
            "folder/a.obj: left out: 2 line elements, 1 point element, smoothing groups, 2 unknown \
             lines (first: `cstype` in line 13)"
        ]
    );
    assert!(
        mesh(&format!("{SQUARE}s off\nvn 0 0 1\ns 1\nf 1//1 2//1 3//1"))
            .notes
            .is_empty()
    );

    let mtl = "newmtl glass\nd 0.5\nillum 6\nKe 0 0 0\nnewmtl lamp\nTr 0\nd -halo 1\nKe 1 1 0.5\nmap_Ke a.png\n\
        newmtl leaf\nmap_d b.png\nmap_Ns c.png\ndisp d.png\nTr 0.25\nKa 1 1 1\nTf 1 1 1\nPr 0.5\nPm 0\n";
    let mesh = load(&format!("mtllib a b.mtl\n{SQUARE}f 1 2 3"), mtl).expect("a mesh");
    assert_eq!(
        mesh.notes,
        [
            "folder/a b.mtl: left out: textures `map_Ns`, `disp`, reflection or refraction of 1 material, statements `Pr`"
        ]
    );
    let opacity = |surface: &Surface| surface.textures.opacity.map(|opacity| opacity.factor);
    let found: Vec<_> = mesh.surfaces[..3].iter().map(opacity).collect();
    assert_eq!(found, [Some(0.5), None, Some(0.75)]);
    // `d` counts, and nothing is invisible.
    let mtl = "newmtl a\nTr 1\nnewmtl b\nd 0\nnewmtl c\nd 1\nTr 1\nnewmtl d\nTr 1\nd 0.5\n";
    let mesh = load(&format!("mtllib a b.mtl\n{SQUARE}f 1 2 3"), mtl).expect("a mesh");
    let found: Vec<_> = mesh.surfaces[..4].iter().map(opacity).collect();
    assert_eq!(found, [None, None, None, Some(0.5)]);
    assert_eq!(
        mesh.notes,
        ["folder/a b.mtl: left out: full transparency of 2 materials"]
    );
}

#[test]
fn faults_have_places() {
    assert_eq!(fault(""), "1:1: the file is empty, expected an OBJ mesh");
    assert_eq!(
        fault("v 0 0"),
        "1:1: the line ends before `z`, expected three numbers"
    );
    assert_eq!(fault("v 0 x 0"), "1:5: `y` is `x`, expected a number");
    assert_eq!(fault("\n v 0 0 nan"), "2:8: z is NaN, expected a finite number");
    assert_eq!(
        fault("v 0 0 0 1 nan inf"),
        "1:11: green is NaN, expected a finite number"
    );
    for weight in ["nan", "inf 1", "nan # 1 1"] {
        let mesh = mesh(&format!("v 0 0 0 {weight}\n"));
        assert!(mesh.columns.colors.is_empty(), "{weight}");
    }
    assert_eq!(fault("vn 0 0 x"), "1:8: `nz` is `x`, expected a number");
    let with = |line: &str| fault(&format!("{SQUARE}{line}\n"));
    assert_eq!(
        with("f 1 2 0"),
        "5:7: vertex index 0, expected 1 for the first, or a negative index"
    );
    assert_eq!(
        with("f 1 2 -5"),
        "5:7: vertex index -5, but there are only 4 vertices"
    );
    assert_eq!(
        with("f 1 2 5"),
        "5:7: vertex index 5, but there are only 4 vertices"
    );
    assert_eq!(
        with("f 1//-1 2 3"),
        "5:3: normal index -1, but there are no normals"
    );
    assert_eq!(
        with("vn 0 0 1\nf 1//-2 2 3"),
        "6:3: normal index -2, but there is only 1 normal"
    );
    for word in ["a", "1/", "1/x", "1//", "1/2/3/4", "", "99999999999999999999"] {
        if !["1/", "1//", ""].contains(&word) {
            assert!(
                with(&format!("f {word} 2 3")).starts_with("5:3: corner `"),
                "{word}"
            );
        }
    }
    assert!(fault("what is this\n").starts_with("1:1: found `what` and no vertices, expected an OBJ mesh"));
    assert!(fault("v 0 0 0\n\0").starts_with("2:1: found a NUL byte: this is binary data"));
}

#[test]
fn concave_polygons_are_filled_and_keep_their_normals() {
    // An arrowhead whose fan around the first corner would lie outside of it.
    let arrow = "v 0 2 0\nv -1 0 0\nv 0 1 0\nv 1 0 0\n";
    let plain = mesh(&format!("{arrow}f 2 3 4 1\n")).columns;
    let area = |t: &[u32; 3], columns: &TriangleMesh| {
        let at = |i: u32| glam::DVec2::new(columns.x[i as usize].into(), columns.y[i as usize].into());
        (at(t[1]) - at(t[0])).perp_dot(at(t[2]) - at(t[0])) * 0.5
    };
    let areas: Vec<f64> = plain.triangles.iter().map(|t| area(t, &plain)).collect();
    assert!(
        areas.len() == 2 && areas.iter().all(|&area| (area - 0.5).abs() < 1e-6),
        "{areas:?}"
    );
    let normals = "vn 0 0 1\nvn 0 0 2\nvn 0 0 3\nvn 0 0 4\n";
    let smooth = mesh(&format!("{arrow}{normals}f 1 2 3\nf 2//2 3//3 4//4 1//1\n")).columns;
    for triangle in &smooth.triangles[1..] {
        for &i in triangle {
            let i = i as usize;
            let expected = [2.0, 0.0, 1.0].map(|y| smooth.y[i] == y);
            let normal = match expected {
                [true, ..] => 1.0,
                [_, _, true] => 3.0,
                _ if smooth.x[i] < 0.0 => 2.0,
                _ => 4.0,
            };
            assert_eq!(smooth.normals[i].z, normal);
        }
    }
}

#[test]
fn what_other_programs_write() {
    // Line ends of old Macs, colours after coordinates.
    let mac = mesh("# one\rv 0 0 0 1 0 0\rv 1 0 0 1 0 0\rv 0 1 0 1 0 0\rf 1 2 3\r");
    assert_eq!(mac.columns.triangles, [[0, 1, 2]]);
    assert!(mac.notes.is_empty());
    assert_eq!(mac.columns.colors, [[1.0, 0.0, 0.0]; 3]);
    let weights = mesh("v 0 0 0 1\nv 1 0 0 1.0\nv 0 1 0 # not a colour\nf 1 2 3\n");
    assert!(weights.notes.is_empty());
    for bytes in [&b"\xff\xfev\0 \0"[..], b"\xfe\xff\0v\0 "] {
        let open = &mut |_: &Path| Err(io::ErrorKind::NotFound.into());
        let error = parse(bytes, Path::new("a.obj"), open, &Budget::unlimited())
            .expect_err("UTF-16")
            .to_string();
        assert_eq!(
            error,
            "a.obj:1:1: this is UTF-16, expected the text of an OBJ mesh in UTF-8 or ASCII"
        );
    }
}

#[test]
fn a_byte_order_mark_is_not_part_of_the_first_word() {
    let text = "v 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 2 3 4\nf 1 2 3\n";
    let marked = mesh(&format!("\u{feff}{text}"));
    assert_eq!(marked.columns.x, mesh(text).columns.x);
    assert_eq!(marked.columns.triangles, [[1, 2, 3], [0, 1, 2]]);
    assert!(marked.notes.is_empty());
}

/// Each path is kept once, and counted.
#[test]
fn names_of_images_take_memory() {
    let material = |i: usize| {
        format!(
            "newmtl m{i}\nmap_Kd {}{i}.png\nmap_Ke {0}{i}.png\n",
            "x".repeat(1000)
        )
    };
    let library: String = (0..1000).map(material).collect();
    let read = |memory: u64| {
        let open = &mut |_: &Path| Ok(library.clone().into_bytes());
        parse(
            b"mtllib a.mtl\nv 0 0 0\n",
            Path::new("a.obj"),
            open,
            &Budget::new(memory),
        )
        .map(|_| ())
    };
    assert_eq!(read(2 << 20), Ok(()));
    let error = read(1 << 20).expect_err("they take more").to_string();
    assert!(error.starts_with("a.obj:1:1: loading takes"), "{error}");
}

#[test]
fn libraries_of_other_machines_lie_beside_the_mesh() {
    for name in ["C:\\my models\\a b.mtl", "/no such folder/a b.mtl"] {
        let text = format!("mtllib {name}\nusemtl m\n{SQUARE}f 1 2 3\n");
        let mesh = load(&text, "newmtl m\nKd 1 0 0\n").expect("a mesh");
        let expected = format!(
            "folder/a.obj: the material library has an absolute path of another machine (`{name}`): taken from beside the mesh"
        );
        assert_eq!(mesh.notes, [expected]);
        assert_eq!(mesh.surfaces[0].diffuse, [1.0, 0.0, 0.0]);
    }
}

/// Programs write a colour both ways for the same purpose.
#[test]
fn colours_of_material_and_vertices_count_once() {
    let library = "newmtl m\nKd 0.5 0.2 0.2\nnewmtl n\nKd 0.5 0.2 0.2\n";
    let text = |last: &str, faces: &str| {
        format!(
            "mtllib a b.mtl\nv 0 0 0 0.5 0.2 0.2\nv 1 0 0 0.501961 0.2 0.2\nv 0 1 0 0.4980392 0.2 0.2\nv 1 1 0 {last}\n{faces}"
        )
    };
    let diffuse = |last: &str, faces: &str| {
        let mesh = load(&text(last, faces), library).expect("a mesh");
        assert!(mesh.notes.is_empty(), "{:?}", mesh.notes);
        assert_eq!(mesh.columns.colors[0], [0.5, 0.2, 0.2]);
        mesh.surfaces
            .iter()
            .map(|surface| surface.diffuse)
            .collect::<Vec<_>>()
    };
    let (own, white) = ([0.5, 0.2, 0.2], [1.0; 3]);
    let faces = "usemtl m\nf 1 2 3\nusemtl n\nf 1 2 3\nf 2 3 4\n";
    assert_eq!(diffuse("0.5 0.2 0.2", faces), [white, white]);
    // Another colour at one corner: it may be a shade.
    assert_eq!(diffuse("0.5 0.21 0.2", faces), [white, own]);
    // A vertex without a colour is white.
    assert_eq!(diffuse("", faces), [white, own]);
    assert_eq!(
        diffuse("0.5 0.2 0.2", "f 1 2 3\nusemtl m\nf 1 2 3\n"),
        [white, own, white]
    );
}

#[test]
fn colours_from_0_to_255() {
    let note = "folder/a.obj: the vertex colours are from 0 to 255: divided by 255";
    let colors = |text: &str| {
        let mesh = mesh(&format!("{text}f 1 2 3\n"));
        (mesh.columns.colors, mesh.notes)
    };
    let (white, red) = ([1.0; 3], [1.0, 0.0, 0.0]);
    let bytes = colors("v 0 0 0 255 0 0\nv 1 0 0\nv 0 1 0 51 1 0\n");
    assert_eq!(
        bytes,
        (vec![red, white, [0.2, 1.0 / 255.0, 0.0]], vec![note.to_owned()])
    );
    let plain = colors("v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 0 1 0 1 1 1\n");
    assert_eq!(plain, (vec![red, red, white], Vec::new()));
    // These are no bytes.
    for odd in ["0.5 0 0", "256 0 0", "-1 0 0"] {
        let (colors, notes) = colors(&format!("v 0 0 0 255 0 0\nv 1 0 0\nv 0 1 0 {odd}\n"));
        assert_eq!(colors[..2], [red, white]);
        assert!(notes[0].ends_with("not from 0 to 1: clamped"), "{notes:?}");
    }
    // The base colour is compared with what is shown.
    let text = "mtllib a b.mtl\nusemtl m\nv 0 0 0 128 51 51\nv 1 0 0 128 51 51\nv 0 1 0 128 51 51\nf 1 2 3\n";
    let mesh = load(text, "newmtl m\nKd 0.5 0.2 0.2\n").expect("a mesh");
    assert_eq!(mesh.surfaces[0].diffuse, white);
}

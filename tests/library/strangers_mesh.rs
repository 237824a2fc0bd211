//! Hostile meshes that would take long or much memory: each is read, or refused with one sentence, in a few seconds.

use octray::{
    format::mesh::{LoadedMesh, load_within, parse},
    scene::SceneBuilder,
};
use std::{
    cell::Cell,
    fmt::Write,
    fs, io,
    path::Path,
    time::{Duration, Instant},
};

/// None of these takes longer, also on a slow machine and without optimisation.
const MOST_TIME: Duration = Duration::from_secs(10);

/// Does something in time.
fn soon<T>(what: &str, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let result = work();
    assert!(start.elapsed() < MOST_TIME, "{what}: {:?}", start.elapsed());
    result
}

/// Reads an OBJ whose libraries all have this content.
fn obj(text: &str, library: Option<&str>) -> Result<LoadedMesh, String> {
    let open = &mut |_: &Path| library.map_or(Err(io::ErrorKind::NotFound.into()), |text| Ok(text.into()));
    soon("an OBJ", || parse(text.into(), Path::new("a.obj"), open)).map_err(|error| error.to_string())
}

/// `count` points on a grid of 100 x 100.
fn vertices(count: usize) -> String {
    let mut random = fastrand::Rng::with_seed(1);
    let points = (0..count).map(|_| format!("v {} {} 0\n", random.u32(..100), random.u32(..100)));
    points.collect()
}

/// A cone of `count` faces.
fn cone(count: usize) -> LoadedMesh {
    let mut text = "v 0 0 1\n".to_owned();
    for i in 0..count {
        let angle = std::f64::consts::TAU * i as f64 / count as f64;
        let _ = writeln!(text, "v {} {} 0", angle.cos(), angle.sin());
    }
    for i in 0..count {
        let _ = writeln!(text, "f 1 {} {}", i + 2, (i + 1) % count + 2);
    }
    obj(&text, None).expect("a mesh")
}

#[test]
fn normals_at_a_hub() {
    let mut cone = cone(50_000);
    soon("a cone", || cone.columns.smooth_normals(30.0)).expect("little memory");
    let tip = cone.columns.triangles[0][0] as usize;
    assert!((cone.columns.normals[tip].z - 1.0).abs() < 1e-3);
    assert_eq!(cone.columns.x.len(), 50_001);

    // Faces that cancel out: each keeps its own normal. Four vertices have all faces in common.
    let tetrahedron = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n".to_owned();
    let sides = "f 1 2 3\nf 1 3 2\nf 1 2 4\nf 1 4 2\nf 1 3 4\nf 1 4 3\n".repeat(2000);
    let mut mesh = obj(&(tetrahedron + &sides), None).expect("a mesh");
    soon("both sides", || mesh.columns.smooth_normals(30.0)).expect("little memory");

    // As many faces around each vertex as are compared with each other.
    let mut random = fastrand::Rng::with_seed(2);
    let mut text = vertices(150);
    for _ in 0..25_000 {
        let [a, b, c] = [(); 3].map(|()| random.u32(1..=150));
        let _ = writeln!(text, "f {a} {b} {c}");
    }
    let mut mesh = obj(&text, None).expect("a mesh");
    soon("many creases", || mesh.columns.smooth_normals(30.0)).expect("little memory");
}

#[test]
fn many_normals_at_a_vertex() {
    let mut text = vertices(3) + &"vn 0 0 1\n".repeat(100_000);
    for i in 1..=100_000 {
        let _ = writeln!(text, "f 1//{i} 2//1 3//1");
    }
    // Each a second time.
    for i in (1..=100_000).step_by(7) {
        let _ = writeln!(text, "f 1//{i} 2//1 3//1");
    }
    let mesh = obj(&text, None).expect("a mesh").columns;
    assert_eq!(mesh.x.len(), 3 + 99_999);
    let corner = |triangle: usize| mesh.triangles[triangle][0];
    assert_eq!((corner(0), corner(1), corner(99_999)), (0, 3, 100_001));
    assert!(
        (0..100_000)
            .step_by(7)
            .zip(100_000..)
            .all(|(first, again)| corner(first) == corner(again))
    );
}

#[test]
fn polygons_that_cross_themselves() {
    for corners in [64, 65, 300, 1024] {
        let mut random = fastrand::Rng::with_seed(3);
        let mut text = vertices(corners);
        while text.len() < 100_000 {
            let mut order: Vec<usize> = (1..=corners).collect();
            random.shuffle(&mut order);
            let words: String = order.iter().map(|corner| format!(" {corner}")).collect();
            let _ = writeln!(text, "f{words}");
        }
        let mesh = obj(&text, None).expect("a mesh").columns;
        assert_eq!(mesh.triangles.len() % (corners - 2), 0);
    }
    // Combs, thin ones too.
    for depth in [1, 1_000_000] {
        let mut text = "v 0 -1 0\nv 1021 -1 0\n".to_owned();
        for i in 0..1022 {
            let _ = writeln!(text, "v {} {} 0", 1021 - i, if i % 2 == 0 { depth } else { 0 });
        }
        let words: String = (1..=1024).map(|corner| format!(" {corner}")).collect();
        text += &format!("f{words}\n").repeat(24);
        obj(&text, None).expect("a mesh");
    }
}

#[test]
fn libraries_are_read_once() {
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n";
    let library = "newmtl m\nKd 1 0 0\nillum 6\n".to_owned() + &"newmtl n\n".repeat(10_000);
    let reads = Cell::new(0);
    let read = |lines: &str| {
        reads.set(0);
        let open = &mut |_: &Path| {
            reads.set(reads.get() + 1);
            Ok(library.clone().into())
        };
        let text = lines.to_owned() + triangle;
        let mesh = soon("libraries", || parse(text.into(), Path::new("a.obj"), open));
        mesh.map_err(|error| error.to_string())
    };
    // All names in a line, as lines, and written differently.
    let names = " a.mtl".repeat(5000);
    let spellings: String = (0..2000)
        .map(|i| format!("mtllib {}a.mtl\n", "./".repeat(i % 900)))
        .collect();
    for (lines, expected) in [
        (format!("mtllib{names}\n"), 1),
        ("mtllib a.mtl\n".repeat(5000), 1),
        (spellings, 1),
        ("mtllib a.mtl b.mtl\nmtllib b.mtl\n".to_owned(), 2),
    ] {
        let mesh = read(&lines).expect("a mesh");
        // The whole line may be one name, if it is not too long.
        assert!(reads.get() <= expected, "{} times: {}", reads.get(), lines.len());
        assert_eq!(mesh.notes.len(), reads.get(), "{:?}", mesh.notes);
    }
    let many: String = (0..2000).map(|i| format!("mtllib {i}.mtl\n")).collect();
    // Notes of a few are enough.
    assert_eq!(read(&many).expect("a mesh").notes.len(), 21);
    assert_eq!(reads.get(), 21);
}

#[test]
fn libraries_have_limits() {
    let many: String = (0..2000).map(|i| format!("mtllib {i}.mtl\n")).collect();
    let error = obj(&many, Some("newmtl m\n")).expect_err("too many");
    assert_eq!(error, "a.obj:1025:1: more than 1024 material libraries");
    let error = obj("mtllib a.mtl\n", Some(&"newmtl m\n".repeat((1 << 20) + 1))).expect_err("too many");
    assert_eq!(error, "a.obj:1:1: more than 1048576 materials");
    // Without any of the three the others are within the limit.
    let open = &mut |path: &Path| {
        let is_last = path.ends_with("c");
        Ok(if is_last {
            vec![0; 255 << 20]
        } else {
            vec![b'#'; 1 << 20]
        })
    };
    let lines = b"mtllib a\nmtllib b\nmtllib c\n".to_vec();
    let error = soon("large libraries", || parse(lines, Path::new("a.obj"), open)).expect_err("too large");
    assert_eq!(
        error.to_string(),
        "a.obj:3:1: the material libraries have more than 256.0 MiB"
    );
    // Missing ones: a few notes, however they are named.
    let lines: String = (0..10_000).map(|i| format!("mtllib {i}.mtl\n")).collect();
    assert_eq!(obj(&lines, None).expect("a mesh").notes.len(), 21);
    let words: String = (0..1000).map(|i| format!(" {i}.mtl")).collect();
    assert_eq!(
        obj(&format!("mtllib{words}\n"), None)
            .expect("a mesh")
            .notes
            .len(),
        1
    );
    let long = format!("mtllib {}\nv 0 0 0\n", "x".repeat(1 << 20));
    let notes = obj(&long, None).expect("a mesh").notes;
    assert_eq!(
        notes,
        ["a.obj: the name of a material library is longer than 4096 bytes; its materials are missing"]
    );
}

/// What is said about a file of this name that may take so much memory.
fn within(name: &str, bytes: &[u8], memory: u64) -> String {
    let folder = tempfile::TempDir::new().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    match soon(name, || load_within(&path, &mut Vec::new(), memory)) {
        Ok(mesh) => {
            let builder = &mut SceneBuilder::within(memory);
            mesh.add_to(builder, None)
                .map_or_else(|error| error.to_string(), |()| "fits".to_owned())
        }
        Err(error) => error
            .to_string()
            .rsplit('/')
            .next()
            .unwrap_or_default()
            .to_owned(),
    }
}

#[test]
fn memory_is_counted_before_it_is_taken() {
    let ply = |faces: &str| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
             {faces}end_header\n0 0 0\n1 0 0\n0 1 0\n"
        )
    };
    let list = "element face 1\nproperty list uint uchar vertex_indices\n";
    let strip = list.replace("face", "tristrips");
    let large = "0 1 2 ".repeat(125_000);
    let texts = [
        ("face.ply", ply(list) + "375000 " + &large + "\n"),
        ("strip.ply", ply(&strip) + "375000 " + &large + "\n"),
        // On two lines: not for the fast path.
        ("lines.ply", ply(list) + "375000\n" + &large + "\n"),
        (
            "face.obj",
            "v 0 0 0\n".repeat(2) + "f" + &" 1 2".repeat(187_500) + "\n",
        ),
        (
            "normals.obj",
            vertices(3) + &"vn 0 0 1\n".repeat(9) + "f" + &" 1//1 2//5".repeat(93_750),
        ),
        ("faces.obj", vertices(3) + &"f 1 2 3 1\n".repeat(93_750)),
        (
            "facet.stl",
            "solid\nfacet normal 0 0 1 outer loop\n".to_owned() + &"vertex 0 1 2\n".repeat(100_000),
        ),
    ];
    for (name, text) in texts {
        let said = within(name, text.as_bytes(), 5 << 19);
        assert!(
            said.starts_with(&format!("{name}: loading takes"))
                && said.ends_with("above the memory limit of 2.5 MiB"),
            "{name}: {said}"
        );
        let said = within(name, text.as_bytes(), 1 << 30);
        assert!(said == "fits" || name == "facet.stl", "{name}: {said}");
    }
    let chain: String = (1..=25_000)
        .map(|i| format!("vn 1 0 0\nf 1//{i} 2//{i} 3//{i}\n"))
        .collect();
    let said = within("chain.obj", (vertices(3) + &chain).as_bytes(), 25 << 18);
    assert!(said.starts_with("chain.obj: loading takes"), "{said}");
}

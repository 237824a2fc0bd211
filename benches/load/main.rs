//! Loading a mesh, against a lower bound: reading the file, and two plain loops that put its numbers into arrays.
//!
//! `cargo bench --bench load -- [TRIANGLES]` makes a grid of that many triangles (2 million by default) as binary and
//! as ASCII PLY, as binary STL and as OBJ in a temporary folder, and prints the best of several runs of each step.
//!
//! The plain loops run on one thread, check nothing and know the layout; octray runs on all threads of the pool
//! (`RAYON_NUM_THREADS=1` for one) and checks every number. "Parse" is from bytes in memory to a mesh, "load" from a file
//! to a mesh. Freeing memory is not counted.

use octray::{
    format::{mesh, ply},
    generate::write_ply,
    scene::{SceneBuilder, TriangleMesh},
};
use std::{
    fmt::Write as _,
    fs,
    hint::black_box,
    io::{BufWriter, Write as _},
    time::{Duration, Instant},
};

/// The program's allocator: page faults are a large part of the time.
#[path = "../../src/allocator.rs"]
mod allocator;

#[global_allocator]
static ALLOCATOR: allocator::Limited = allocator::Limited::new();

#[cfg(target_os = "linux")]
mod map;

const RUNS: usize = 7;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let count = std::env::args().skip(1).find_map(|word| word.parse().ok());
    let mesh = grid(count.unwrap_or(2_000_000));
    println!(
        "{} triangles, {} vertices, best of {RUNS}\n",
        mesh.triangles.len(),
        mesh.x.len()
    );
    let folder = tempfile::tempdir()?;

    let ply = folder.path().join("binary.ply");
    let mut out = BufWriter::new(fs::File::create(&ply)?);
    write_ply(&mesh, &mut out)?;
    out.flush()?;
    let bytes = fs::read(&ply)?;
    let body = bytes.len() - 12 * mesh.x.len() - 13 * mesh.triangles.len();
    let loops = best("two plain loops", || plain_loops(&bytes[body..], mesh.x.len()));
    let parse = best("parse the bytes", || ply::parse(&bytes, &ply).unwrap());
    ratio(parse, loops);
    drop(bytes);
    let read = best("read the file, two plain loops", || {
        plain_loops(&fs::read(&ply).unwrap()[body..], mesh.x.len())
    });
    #[cfg(target_os = "linux")]
    best("map the file, two plain loops", || {
        let map = map::Map::of(&ply);
        plain_loops(&map.bytes()[body..], mesh.x.len())
    });
    let load = best("load, binary PLY", || mesh::load(&ply).unwrap());
    ratio(load, read);
    best("load and finish the scene", || {
        let mut builder = SceneBuilder::new();
        mesh::load(&ply).unwrap().add_to(&mut builder, None).unwrap();
        builder.finish()
    });

    let text = folder.path().join("ascii.ply");
    fs::write(&text, ascii(&mesh))?;
    let bytes = fs::read(&text)?;
    let loops = best("two plain loops, ASCII", || {
        plain_text_loops(&bytes, mesh.x.len())
    });
    let parse = best("parse the bytes, ASCII", || ply::parse(&bytes, &text).unwrap());
    ratio(parse, loops);
    drop(bytes);
    best("load, ASCII PLY", || mesh::load(&text).unwrap());
    let stl = folder.path().join("binary.stl");
    fs::write(&stl, binary_stl(&mesh))?;
    best("load, binary STL", || mesh::load(&stl).unwrap());
    let obj = folder.path().join("a.obj");
    fs::write(&obj, wavefront(&mesh))?;
    best("load, OBJ", || mesh::load(&obj).unwrap());
    Ok(())
}

fn ms(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

fn ratio(ours: Duration, theirs: Duration) {
    println!("{:>41.2} x that\n", ms(ours) / ms(theirs));
}

fn best<T>(what: &str, work: impl Fn() -> T) -> Duration {
    let time = || {
        let start = Instant::now();
        let result = black_box(work());
        let time = start.elapsed();
        drop(result);
        time
    };
    let best = (0..RUNS).map(|_| time()).min().unwrap_or_default();
    println!("{what:32} {:8.1} ms", ms(best));
    best
}

/// Vertices of three floats, faces of a byte and three whole numbers; nothing is checked.
fn plain_loops(body: &[u8], vertices: usize) -> TriangleMesh {
    let (positions, faces) = body.split_at(12 * vertices);
    let mut mesh = TriangleMesh::default();
    let float = |bytes: &[u8]| f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
    let whole = |bytes: &[u8]| u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
    for column in [&mut mesh.x, &mut mesh.y, &mut mesh.z] {
        column.reserve_exact(vertices);
    }
    mesh.triangles.reserve_exact(faces.len() / 13);
    for vertex in positions.chunks_exact(12) {
        mesh.x.push(float(&vertex[0..4]));
        mesh.y.push(float(&vertex[4..8]));
        mesh.z.push(float(&vertex[8..12]));
    }
    for face in faces.chunks_exact(13) {
        mesh.triangles
            .push([whole(&face[1..5]), whole(&face[5..9]), whole(&face[9..13])]);
    }
    mesh
}

/// The same for text; skips the header's lines.
fn plain_text_loops(text: &[u8], vertices: usize) -> TriangleMesh {
    fn float(line: &mut &[u8]) -> f32 {
        *line = line.trim_ascii_start();
        let (value, length) = fast_float2::parse_partial(*line).unwrap();
        *line = &line[length..];
        value
    }
    fn whole(line: &mut &[u8]) -> u32 {
        *line = line.trim_ascii_start();
        let mut value = 0;
        while let [digit @ b'0'..=b'9', rest @ ..] = line {
            value = value * 10 + u32::from(digit - b'0');
            *line = rest;
        }
        value
    }
    let mut mesh = TriangleMesh::default();
    for column in [&mut mesh.x, &mut mesh.y, &mut mesh.z] {
        column.reserve_exact(vertices);
    }
    let mut lines = text.split(|&byte| byte == b'\n').skip(9);
    for mut line in lines.by_ref().take(vertices) {
        mesh.x.push(float(&mut line));
        mesh.y.push(float(&mut line));
        mesh.z.push(float(&mut line));
    }
    for mut line in lines.filter(|line| !line.is_empty()) {
        whole(&mut line);
        let corners = [whole(&mut line), whole(&mut line), whole(&mut line)];
        mesh.triangles.push(corners);
    }
    mesh
}

/// A wavy square.
fn grid(triangles: usize) -> TriangleMesh {
    let side = ((triangles / 2) as f64).sqrt().ceil() as u32;
    let mut mesh = TriangleMesh::default();
    for i in 0..=side {
        for j in 0..=side {
            let (u, v) = (f64::from(i) / f64::from(side), f64::from(j) / f64::from(side));
            mesh.x.push(u as f32);
            mesh.y.push(v as f32);
            mesh.z.push((0.05 * (37.0 * u).sin() * (29.0 * v).cos()) as f32);
        }
    }
    let at = |i: u32, j: u32| i * (side + 1) + j;
    for i in 0..side {
        for j in 0..side {
            mesh.triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            mesh.triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    mesh
}

fn ascii(mesh: &TriangleMesh) -> String {
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.x.len(),
        mesh.triangles.len()
    );
    for ((x, y), z) in mesh.x.iter().zip(&mesh.y).zip(&mesh.z) {
        let _ = writeln!(text, "{x} {y} {z}");
    }
    for [a, b, c] in &mesh.triangles {
        let _ = writeln!(text, "3 {a} {b} {c}");
    }
    text
}

fn wavefront(mesh: &TriangleMesh) -> String {
    let mut text = String::new();
    for ((x, y), z) in mesh.x.iter().zip(&mesh.y).zip(&mesh.z) {
        let _ = writeln!(text, "v {x} {y} {z}");
    }
    for [a, b, c] in &mesh.triangles {
        let _ = writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1);
    }
    text
}

fn binary_stl(mesh: &TriangleMesh) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend((mesh.triangles.len() as u32).to_le_bytes());
    for corners in &mesh.triangles {
        bytes.extend([0; 12]);
        for i in corners.map(|i| i as usize) {
            for value in [mesh.x[i], mesh.y[i], mesh.z[i]] {
                bytes.extend(value.to_le_bytes());
            }
        }
        bytes.extend([0; 2]);
    }
    bytes
}

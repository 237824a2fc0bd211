//! Meshes whose parts are few and often used again: hubs, combs, shared buffers, libraries with many names. Such files
//! take long or much memory where work is done for each use instead of each part.

use arbitrary::{Result, Unstructured};
use std::fmt::Write as _;

type Source<'a, 'b> = &'a mut Unstructured<'b>;

/// No file is much longer, bytes.
const MOST_TEXT: usize = 100_000;

/// Names of files, some of them devices or one file by several names.
const NAMES: [&str; 10] = [
    "a.bin",
    "./a.bin",
    "././/a.bin",
    "../a.bin",
    "a b.bin",
    "/dev/zero",
    "/dev/stdin",
    "/proc/self/pagemap",
    "no",
    "\u{1b}[2J",
];

/// The name of a file and its content: an OBJ or a glTF mesh.
pub fn mesh(bytes: &[u8]) -> (&'static str, String) {
    let mut u = Unstructured::new(bytes);
    let mut text = String::new();
    if u.ratio(1, 2).unwrap_or_default() {
        // The bytes may end anywhere.
        while text.len() < MOST_TEXT && !u.is_empty() && lines(&mut u, &mut text).is_ok() {}
        return ("fuzz.obj", text);
    }
    let _ = gltf(&mut u, &mut text);
    ("fuzz.gltf", text)
}

/// Some lines of an OBJ.
fn lines(u: Source<'_, '_>, out: &mut String) -> Result<()> {
    let count = u.int_in_range(1..=1200)?;
    let among = u.int_in_range(1..=count.min(300))?;
    let step = u.int_in_range(1..=9)?;
    let corner = |i: usize| i * step % among + 1;
    match u.int_in_range(0..=8)? {
        0 | 1 => {
            for _ in 0..among {
                let [x, y, z]: [i8; 3] = u.arbitrary()?;
                let _ = writeln!(out, "v {x} {y} {}", z / 64);
            }
        }
        2 => out.push_str(&"vn 0 0 1\n".repeat(count)),
        // A hub.
        3 => (0..count).for_each(|i| _ = writeln!(out, "f 1 {} {}", corner(i), corner(i + 1))),
        // Many normals at one vertex.
        4 => (1..=count).for_each(|i| _ = writeln!(out, "f 1//{i} 2//1 3//{}", corner(i))),
        // A comb, or a polygon that crosses itself.
        5 => {
            let words: String = (0..count).map(|i| format!(" {}", corner(i))).collect();
            let _ = writeln!(out, "f{words}");
        }
        6 => {
            let name = u.choose(&NAMES)?;
            let between = u.choose(&[" ", "\nmtllib ", " ./"])?;
            let _ = writeln!(out, "mtllib {}", vec![*name; count].join(between));
        }
        7 => (0..count).for_each(|i| _ = writeln!(out, "usemtl {}\nf 1 2 3", corner(i))),
        _ => (0..count).for_each(|i| _ = writeln!(out, "mtllib {i}.mtl")),
    }
    Ok(())
}

/// `count` copies of a part, with a comma between.
fn copies(part: &str, count: usize) -> String {
    vec![part; count].join(",")
}

/// A glTF file: few accessors, and many buffers, primitives, nodes or numbers of a sparse accessor.
fn gltf(u: Source<'_, '_>, out: &mut String) -> Result<()> {
    let many = |u: Source<'_, '_>| {
        let most = if u.ratio(1, 4)? { 1000 } else { 3 };
        u.int_in_range(1..=most)
    };
    let (buffers, primitives, nodes) = (many(u)?, many(u)?, many(u)?);
    let name = u.choose(&NAMES)?.replace('\u{1b}', "\\u001b");
    let count = *u.choose(&[3, 5, 1000, 4_294_967_295_u32])?;
    let sparse =
        r#","sparse":{"count":1,"indices":{"bufferView":0,"componentType":5125},"values":{"bufferView":0}}"#;
    let sparse = if u.arbitrary()? { sparse } else { "" };
    let view = u.choose(&["", r#","bufferView":0"#])?;
    let size = u.choose(&["64", "63", "1e9", "18446744073709551615"])?;
    let length = u.int_in_range(1..=5)?;
    let buffer = format!(r#"{{"byteLength":{size},"uri":"{name}"}}"#);
    let children = *u.choose(&["", r#","children":[1]"#, r#","children":[0,1,1]"#])?;
    let joints = *u.choose(&["", r#","JOINTS_0":2,"WEIGHTS_0":2"#])?;
    let targets = u.int_in_range(0..=3)?;
    let targets = copies(r#"{"POSITION":0,"NORMAL":0}"#, targets);
    let primitive =
        format!(r#"{{"attributes":{{"POSITION":0,"NORMAL":0{joints}}},"targets":[{targets}],"indices":1}}"#);
    let pose = *u.choose(&["", r#","skin":0"#, r#","weights":[1,0.5]"#])?;
    let node = format!(r#"{{"mesh":0{pose}{children}}}"#);
    let roots: Vec<String> = (0..nodes).map(|i| i.to_string()).collect();
    let _ = write!(
        out,
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[{}]}}],"nodes":[{}],
"skins":[{{"joints":[0]}}],"meshes":[{{"primitives":[{}]}}],"buffers":[{}],"bufferViews":[{{"buffer":{},"byteLength":60}}],
"accessors":[{{"componentType":5126,"type":"VEC3","count":{count}{view}{sparse}}},
{{"componentType":5121,"type":"SCALAR","count":{length},"bufferView":0}},
{{"componentType":5121,"type":"VEC4","count":{count}{view}}}]}}"#,
        roots.join(","),
        copies(&node, nodes),
        copies(&primitive, primitives),
        copies(&buffer, buffers),
        buffers - 1,
    );
    Ok(())
}

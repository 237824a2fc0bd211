//! Bytes as choices in a grammar: text that is almost a scene, files that are almost PLY. A fuzzer that changes a byte
//! changes a statement instead of a letter.

use arbitrary::{Result, Unstructured};

type Source<'a, 'b> = &'a mut Unstructured<'b>;

/// Numbers that are hard for parsers and shapes.
const ODD: [&str; 24] = [
    "0",
    "-0",
    "1",
    "-1",
    ".5",
    "1e-3",
    "1e-9",
    "1e-45",
    "1e9",
    "-1e9",
    "1.0000001e9",
    "1e38",
    "1e999",
    "nan",
    "inf",
    "-inf",
    "0x1",
    "1_0",
    "--1",
    "1e",
    "٣",
    "4294967296",
    "18446744073709551616",
    "0.1000000000000000055511151231257827",
];

/// Separators, mostly a space.
const GAPS: [&str; 8] = [" ", " ", " ", " ", "\t", "  ", "\u{a0}", "\r"];

fn number(u: Source<'_, '_>, out: &mut String) -> Result<()> {
    match u.int_in_range(0..=7)? {
        0 => out.push_str(u.choose(&ODD)?),
        1 => out.push_str(&f32::from_bits(u.arbitrary()?).to_string()),
        2 => out.push_str(&format!("{:e}", f64::from_bits(u.arbitrary()?))),
        _ => out.push_str(&(f32::from(u.arbitrary::<i8>()?) / 32.0).to_string()),
    }
    Ok(())
}

fn words(u: Source<'_, '_>, out: &mut String, count: usize) -> Result<()> {
    // Sometimes one too many or too few.
    let count = match u.int_in_range(0..=30)? {
        0 => count + 1,
        1 => count.saturating_sub(1),
        _ => count,
    };
    for _ in 0..count {
        out.push_str(u.choose(&GAPS)?);
        number(u, out)?;
    }
    Ok(())
}

fn path(u: Source<'_, '_>, out: &mut String) -> Result<()> {
    let paths = [
        "a.ply",
        "\"b c.ply\"",
        "no.ply",
        "part.scn",
        "loop.scn",
        "x/deep.scn",
        "../a.ply",
        "./././a.ply",
        "\"\"",
        "\"open",
        "a.obj",
        "a.stl",
        "a.gltf",
        ".",
        "/",
        "ä.ply",
        "a.ply\u{0}",
        "fuzz.scn",
    ];
    out.push_str(u.choose(&GAPS)?);
    out.push_str(u.choose(&paths)?);
    Ok(())
}

/// Up to four keys, each with its numbers.
fn keys(u: Source<'_, '_>, out: &mut String, keys: &[(&str, usize)]) -> Result<()> {
    for _ in 0..u.int_in_range(0..=4)? {
        let (key, count) = u.choose(keys)?;
        out.push(' ');
        out.push_str(key);
        words(u, out, *count)?;
    }
    Ok(())
}

/// Keyframes at times that ascend, or nearly; half of them with the same keys.
fn keyframes(u: Source<'_, '_>, out: &mut String, all: &[(&str, usize)]) -> Result<()> {
    let chosen = u.choose(all)?;
    for i in 0..u.int_in_range(0..=4)? {
        out.push_str("\n at");
        if u.ratio(1, 8)? {
            words(u, out, 1)?;
        } else {
            out.push_str(&format!(" {}", 3 * i));
        }
        if u.arbitrary()? {
            out.push(' ');
            out.push_str(chosen.0);
            words(u, out, chosen.1)?;
        } else {
            keys(u, out, all)?;
        }
    }
    Ok(())
}

#[expect(clippy::too_many_lines, reason = "one arm a statement")]
fn statement(u: Source<'_, '_>, out: &mut String) -> Result<()> {
    const COLORS: &[(&str, usize)] = &[
        ("color", 3),
        ("cd", 3),
        ("cs", 3),
        ("kd", 1),
        ("ks", 1),
        ("alpha", 1),
        ("mix", 1),
        ("checker", 3),
        ("size", 1),
    ];
    match u.int_in_range(0..=16)? {
        16 => {
            out.push_str("plane");
            words(u, out, 3)?;
            keys(u, out, &[("normal", 3)])?;
        }
        14 => {
            out.push_str("directional_light");
            words(u, out, 4)?;
            keys(u, out, &[("color", 3), ("angle", 1)])?;
        }
        15 => {
            out.push_str("environment");
            if u.arbitrary()? {
                path(u, out)?;
            }
            keys(
                u,
                out,
                &[("bottom", 3), ("top", 3), ("rotate", 1), ("intensity", 1)],
            )?;
        }
        0 | 1 => {
            out.push_str("light");
            words(u, out, 4)?;
            let all = [
                ("color", 3),
                ("radius", 1),
                ("rectangle", 6),
                ("falloff", 1),
                ("spot", 5),
            ];
            keys(u, out, &all)?;
        }
        2 | 3 => {
            out.push_str("sphere");
            words(u, out, 4)?;
        }
        4 => {
            out.push_str("triangle");
            words(u, out, 9)?;
        }
        5 => {
            // Without bytes of their own, so that old inputs keep their meaning.
            let (is_instance, is_placed) = (out.len().is_multiple_of(2), out.len().is_multiple_of(3));
            out.push_str(if is_instance { "instance" } else { "mesh" });
            path(u, out)?;
            if is_instance && is_placed {
                out.push_str(" placements a.txt");
            }
            keys(
                u,
                out,
                &[("scale", 1), ("scale", 3), ("rotate", 4), ("translate", 3)],
            )?;
            if !is_instance && is_placed {
                out.push_str(" lights 0.5");
            }
            if out.len().is_multiple_of(3) {
                let steps = &[("scale", 1), ("rotate", 4), ("translate", 3)];
                keyframes(u, out, steps)?;
            }
        }
        6 => {
            out.push_str("ply_file");
            path(u, out)?;
        }
        7 => {
            out.push_str("material");
            words(u, out, 1)?;
        }
        8 | 9 => {
            out.push_str("material ");
            out.push_str(u.choose(&[
                "silhouette",
                "matte",
                "blinn_phong",
                "reflection",
                "own",
                "matt",
                "4",
            ])?);
            keys(u, out, COLORS)?;
            if out.len().is_multiple_of(5) {
                out.push_str(" opacity 0.4 tinted");
            }
        }
        10 => {
            out.push_str("camera");
            out.push_str(u.choose(&["", " a", " \"a b\"", " \"", " eye", " \u{1b}[2J"])?);
            keys(
                u,
                out,
                &[
                    ("eye", 3),
                    ("target", 3),
                    ("up", 3),
                    ("fov", 1),
                    ("ortho", 1),
                    ("aperture", 1),
                    ("focus", 1),
                ],
            )?;
            if out.len().is_multiple_of(2) {
                keyframes(u, out, &[("eye", 3), ("target", 3), ("fov", 1)])?;
            }
        }
        11 => {
            out.push_str("background");
            match u.int_in_range(0..=1)? {
                0 => words(u, out, 3)?,
                _ => keys(u, out, &[("bottom", 3), ("top", 3)])?,
            }
        }
        12 => {
            out.push_str("ambient");
            words(u, out, 1)?;
        }
        _ => {
            out.push_str("include");
            path(u, out)?;
        }
    }
    out.push_str(u.choose(&["\n", "\n", "\n", "\r\n", " // a comment\n", "\r", "//\n", ""])?);
    Ok(())
}

/// Text that is almost a scene.
pub fn scene(bytes: &[u8]) -> String {
    let mut u = Unstructured::new(bytes);
    let mut text = String::new();
    while !u.is_empty() && statement(&mut u, &mut text).is_ok() {}
    text
}

/// A file that is almost PLY: elements and properties of all types, and a body of any length.
pub fn ply(bytes: &[u8]) -> Vec<u8> {
    let mut u = Unstructured::new(bytes);
    let mut file = b"ply\n".to_vec();
    // The remaining bytes are the body.
    let _ = ply_header(&mut u, &mut file);
    file.extend_from_slice(u.take_rest());
    file
}

fn ply_header(u: Source<'_, '_>, file: &mut Vec<u8>) -> Result<()> {
    const TYPES: [&str; 16] = [
        "float", "float", "float32", "double", "float64", "uchar", "uint8", "char", "int8", "short",
        "ushort", "int", "uint", "int32", "uint32", "uint16",
    ];
    const NAMES: [&str; 14] = [
        "x",
        "y",
        "z",
        "nx",
        "ny",
        "nz",
        "red",
        "green",
        "blue",
        "s",
        "t",
        "texcoord",
        "texnumber",
        "vertex_indices",
    ];
    let mut text = format!(
        "format {} 1.0\n",
        u.choose(&["ascii", "binary_little_endian", "binary_big_endian"])?
    );
    for _ in 0..u.int_in_range(0..=2)? {
        text.push_str("comment TextureFile a.bmp\n");
    }
    for _ in 0..u.int_in_range(1..=3)? {
        let name = *u.choose(&["vertex", "vertex", "face", "edge"])?;
        let count = match u.int_in_range(0..=7)? {
            0 => *u.choose(&["0", "-1", "4294967296", "18446744073709551615", "1e3", "99999"])?,
            _ => *u.choose(&["1", "2", "3", "4", "5", "9"])?,
        };
        text.push_str(&format!("element {name} {count}\n"));
        if name == "vertex" && u.ratio(3, 4)? {
            let kind = u.choose(&TYPES)?;
            for axis in ["x", "y", "z"] {
                text.push_str(&format!("property {kind} {axis}\n"));
            }
        }
        if name == "face" && u.ratio(3, 4)? {
            let indices = u.choose(&["vertex_indices", "vertex_index"])?;
            text.push_str(&format!(
                "property list {} {} {indices}\n",
                u.choose(&TYPES)?,
                u.choose(&TYPES)?
            ));
            if u.ratio(1, 2)? {
                let kind = u.choose(&TYPES)?;
                text.push_str(&format!("property list uchar {kind} texcoord\n"));
            }
        }
        for _ in 0..u.int_in_range(0..=3)? {
            let list = match u.int_in_range(0..=3)? {
                0 => format!("list {} ", u.choose(&TYPES)?),
                _ => String::new(),
            };
            text.push_str(&format!(
                "property {list}{} {}\n",
                u.choose(&TYPES)?,
                u.choose(&NAMES)?
            ));
        }
    }
    text.push_str(u.choose(&["", "", "comment a\n", "obj_info b\n"])?);
    text.push_str("end_header\n");
    if u.ratio(1, 8)? {
        text = text.replace('\n', "\r\n");
    }
    file.extend_from_slice(text.as_bytes());
    Ok(())
}

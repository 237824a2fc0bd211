use super::*;
use crate::scene::Wrap;
use rawzip::{CompressionMethod, ZipArchiveWriter, path::EntryPath};
use std::io::Write;

mod inflated;
mod unusable;

const RELS: &str = r#"<Relationships><Relationship Id="a" Target="/3D/3dmodel.model" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>"#;

/// Four corners of a square.
const SQUARE: &str = r#"<vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/><vertex x="1" y="1" z="0"/><vertex x="0" y="1" z="0"/></vertices>"#;

/// Its triangles.
const TWO: &str =
    r#"<triangles><triangle v1="0" v2="1" v3="2"/><triangle v1="0" v2="2" v3="3"/></triangles>"#;

/// A ZIP archive with these parts, compressed if they are long.
pub(super) fn archive<'a>(parts: impl IntoIterator<Item = (&'a str, &'a [u8])>) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut writer = ZipArchiveWriter::new(&mut bytes);
    for (name, part) in parts {
        let method = if part.len() > 2000 {
            CompressionMethod::DEFLATE
        } else {
            CompressionMethod::STORE
        };
        let (mut entry, config) = writer
            .new_file(EntryPath::verbatim(name.as_bytes()))
            .compression_method(method)
            .start()
            .expect("a new part");
        let finished = if method == CompressionMethod::STORE {
            let mut data = config.wrap(&mut entry);
            data.write_all(part).expect("there is memory");
            data.finish().expect("there is memory").1
        } else {
            let encoder = flate2::write::DeflateEncoder::new(&mut entry, flate2::Compression::default());
            let mut data = config.wrap(encoder);
            data.write_all(part).expect("there is memory");
            let (encoder, finished) = data.finish().expect("there is memory");
            encoder.finish().expect("there is memory");
            finished
        };
        entry.finish(finished).expect("there is memory");
    }
    writer.finish().expect("there is memory");
    bytes
}

fn read(bytes: &[u8], budget: &Budget) -> Result<LoadedMesh, String> {
    parse(bytes, Path::new("a.3mf"), budget).map_err(|error| error.to_string())
}

/// Loads a file with one model part, whose content this is.
fn load(content: &str) -> Result<LoadedMesh, String> {
    let model = format!("<model unit=\"millimeter\">{content}</model>");
    let parts = [
        ("_rels/.rels", RELS.as_bytes()),
        ("3D/3dmodel.model", model.as_bytes()),
    ];
    read(&archive(parts), &Budget::unlimited())
}

fn loaded(content: &str) -> LoadedMesh {
    load(content).expect("it loads")
}

/// A model with `resources`, then a square as object 9 with `triangles`, which is built once.
fn square(resources: &str, attributes: &str, triangles: &str) -> String {
    format!(
        "<resources>{resources}<object id=\"9\" {attributes}><mesh>{SQUARE}{triangles}</mesh></object></resources>\
         <build><item objectid=\"9\"/></build>"
    )
}

#[test]
fn a_square() {
    let mesh = loaded(&square("", "", TWO));
    assert_eq!(mesh.columns.x, [0.0, 1.0, 1.0, 0.0]);
    assert_eq!(mesh.columns.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert!(mesh.surfaces.is_empty() && mesh.surface_of.is_empty() && mesh.columns.colors.is_empty());
    assert_eq!((mesh.up, mesh.up_source), (UpAxis::Z, UpSource::Stated));
    assert!(mesh.notes.is_empty(), "{:?}", mesh.notes);
}

#[test]
fn components_and_items_are_placed() {
    let content = format!(
        r#"<resources>
        <object id="1"><mesh>{SQUARE}{TWO}</mesh></object>
        <object id="2"><components>
            <component objectid="1" transform="0 1 0 -1 0 0 0 0 1 10 0 0"/><component objectid="1"/>
            <component objectid="4"/>
        </components></object>
        <object id="3"><mesh>{SQUARE}{TWO}</mesh></object>
        <object id="4" type="other"><mesh>{SQUARE}{TWO}</mesh></object>
        <object id="5" type="support"><mesh>{SQUARE}{TWO}</mesh></object>
        </resources><build>
        <item objectid="2" transform="2 0 0 0 2 0 0 0 2 0 0 5"/><item objectid="5" printable="1"/>
        <item objectid="5" printable="0"/>
        </build>"#
    );
    let mesh = loaded(&content);
    let point = |i: usize| [mesh.columns.x[i], mesh.columns.y[i], mesh.columns.z[i]];
    assert_eq!(mesh.columns.triangles.len(), 6);
    // Turned by a quarter, moved, then scaled and moved.
    assert_eq!(
        [0, 1, 2].map(point),
        [[20.0, 0.0, 5.0], [20.0, 2.0, 5.0], [18.0, 2.0, 5.0]]
    );
    assert_eq!(
        [4, 5, 8, 9].map(point),
        [[0.0, 0.0, 5.0], [2.0, 0.0, 5.0], [0.0; 3], [1.0, 0.0, 0.0]]
    );
    assert_eq!(
        mesh.notes,
        [
            "a.3mf: left out: 1 item that is not to be printed, 1 object of the type `other`, 1 object that is not built"
        ]
    );
}

#[test]
fn mirrored_triangles_keep_their_front() {
    let resources = r##"<colorgroup id="5"><color color="#FF0000"/><color color="#00FF00"/></colorgroup>"##;
    let triangles = r#"<triangles><triangle v1="0" v2="1" v3="2" pid="5" p1="0" p2="0" p3="1"/></triangles>"#;
    let content = square(resources, "", triangles).replace(
        "</resources><build>",
        r#"<object id="10"><components><component objectid="9" transform="1 0 0 0 1 0 0 0 -1 0 0 0"/></components></object></resources><build>
        <item objectid="9" transform="-1 0 0 0 1 0 0 0 1 0 0 0"/><item objectid="10" transform="-1 0 0 0 1 0 0 0 1 0 0 0"/>"#,
    );
    let mesh = loaded(&content).columns;
    let [x, y] = [&mesh.x, &mesh.y].map(|column| move |i: u32| column[i as usize]);
    // Counter-clockwise from the front, but for the second: mirrored twice, that is half a turn about y.
    for (corners, front) in mesh.triangles.iter().zip([1.0, -1.0, 1.0]) {
        let [a, b, c] = *corners;
        let area = (x(b) - x(a)) * (y(c) - y(a)) - (y(b) - y(a)) * (x(c) - x(a));
        assert_eq!(area, front);
        let green = corners.map(|corner| mesh.colors[corner as usize][1]);
        let of = |corner: u32| if y(corner) == 1.0 { 1.0 } else { 0.0 };
        assert_eq!(green, corners.map(of));
    }
    assert_eq!(mesh.triangles.len(), 3);
}

#[test]
fn materials_are_surfaces() {
    let materials = r##"<basematerials id="1"><base name="a" displaycolor="#FF0000"/><base name="b" displaycolor="#00FF0066"/>
        <base name="d" displaycolor="#00FF0000"/><base name="c" displaycolor="#ff0000"/></basematerials>
        <m:compositematerials id="2" matid="1" matindices="0 1"><m:composite values="0.25 0.75"/><m:composite values="0 0"/>
        <m:composite values="1"/></m:compositematerials>"##;
    let triangles = r#"<triangles><triangle v1="0" v2="1" v3="2" pid="1" p1="1"/><triangle v1="0" v2="2" v3="3"/>
        <triangle v1="0" v2="2" v3="3" p1="3"/><triangle v1="0" v2="2" v3="3" pid="2" p1="0"/>
        <triangle v1="0" v2="2" v3="3" pid="2" p1="1"/><triangle v1="0" v2="2" v3="3" pid="2" p1="2"/></triangles>"#;
    let mesh = loaded(&square(materials, r#"pid="1" pindex="0""#, triangles));
    let colors: Vec<[f32; 3]> = mesh
        .surface_of
        .iter()
        .map(|&i| mesh.surfaces[i as usize].diffuse.map(|c| (c * 255.0).round()))
        .collect();
    let red = [255.0, 0.0, 0.0];
    assert_eq!(
        colors,
        [
            [0.0, 255.0, 0.0],
            red,
            red,
            [64.0, 191.0, 0.0],
            [128.0, 128.0, 0.0],
            red
        ]
    );
    let opacity = mesh.surfaces[mesh.surface_of[0] as usize].textures.opacity;
    assert_eq!(opacity.map(|opacity| opacity.factor), Some(0.4));
    let expected = "a.3mf: left out: full transparency, transparency of mixtures";
    assert_eq!(mesh.notes, [expected]);
    assert_eq!(mesh.columns.x.len(), 4);
    assert!(mesh.columns.colors.is_empty());
}

#[test]
fn colors_are_of_corners() {
    let colors =
        r##"<m:colorgroup id="1"><m:color color="#FF0000"/><m:color color="#0000FF80"/></m:colorgroup>"##;
    let triangles = r#"<triangles><triangle v1="0" v2="1" v3="2"/>
        <triangle v1="0" v2="2" v3="3" pid="1" p1="0" p2="1" p3="0"/><triangle v1="0" v2="2" v3="3" pid="1" p1="1"/>
        </triangles>"#;
    let mesh = loaded(&square(colors, "", triangles));
    let of =
        |triangle: usize| mesh.columns.triangles[triangle].map(|corner| mesh.columns.colors[corner as usize]);
    let (red, blue, white) = ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0; 3]);
    assert_eq!(of(0), [white; 3]);
    assert_eq!(of(1), [red, blue, red]);
    assert_eq!(of(2), [blue; 3]);
    let surface = |triangle: usize| mesh.surfaces[mesh.surface_of[triangle] as usize];
    assert_eq!(
        [0, 1, 2].map(surface),
        [Surface::NEUTRAL, Surface::WHITE, Surface::WHITE]
    );
    assert_eq!(mesh.columns.x.len(), mesh.columns.colors.len());
    assert_eq!(mesh.notes, ["a.3mf: left out: transparency of vertex colours"]);
    // Colours alone need no surface.
    let all = loaded(&square(colors, r#"pid="1" pindex="1""#, TWO));
    assert!(all.surfaces.is_empty() && all.columns.colors == [blue; 4]);
    let painted = TWO.replace("/>", " paint_color=\"4C\"/>");
    assert_eq!(
        loaded(&square("", "", &painted)).notes,
        ["a.3mf: left out: colours painted in a slicer"]
    );
}

#[test]
fn textures_are_parts() {
    let model = format!(
        "<model>{}</model>",
        square(
            r##"<m:texture2d id="1" path="/3D/Textures/a%20b.png" contenttype="image/png" tilestyleu="mirror" tilestylev="clamp"/>
            <m:texture2dgroup id="2" texid="1"><m:tex2coord u="0" v="0"/><m:tex2coord u="2" v="0.25"/><m:tex2coord u="nan" v="1"/></m:texture2dgroup>
            <m:colorgroup id="3"><m:color color="#FF0000"/></m:colorgroup>
            <m:multiproperties id="4" pids="3 2"><m:multi pindices="0 1"/><m:multi pindices="0"/></m:multiproperties>"##,
            "",
            r#"<triangles><triangle v1="0" v2="1" v3="2" pid="2" p1="0" p2="1" p3="2"/>
            <triangle v1="0" v2="2" v3="3" pid="4" p1="0" p2="1" p3="0"/></triangles>"#
        )
    );
    // A PNG of one red pixel.
    let png = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x01\0\0\0\x01\x08\x02\0\0\0\x90wS\xde\0\0\0\x0cIDATx\x9cc\xf8\xcf\xc0\0\0\x03\x01\x01\0\xc9\xfe\x92\xef\0\0\0\0IEND\xaeB`\x82";
    let parts: [(&str, &[u8]); 3] = [
        ("3d/model.model", model.as_bytes()),
        ("3D/Textures/a b.png", png),
        ("Metadata/plate_1.png", b""),
    ];
    let mesh = read(&archive(parts), &Budget::unlimited()).expect("it loads");
    let of =
        |triangle: usize| mesh.columns.triangles[triangle].map(|corner| mesh.columns.uvs[corner as usize]);
    assert_eq!(of(0), [[0.0, 1.0], [2.0, 0.75], [0.0, 0.0]]);
    assert_eq!(of(1), [[2.0, 0.75], [0.0, 1.0], [2.0, 0.75]]);
    let base = mesh.surfaces[mesh.surface_of[1] as usize]
        .textures
        .base
        .expect("there is a texture");
    assert_eq!((base.image, base.wrap), (0, [Wrap::Mirror, Wrap::Clamp]));
    assert_eq!(mesh.images.len(), 1);
    assert_eq!(
        mesh.notes,
        ["a.3mf: left out: lower layers of properties, 1 texture coordinate that is NaN or too large"]
    );
    let missing = read(&archive(parts.into_iter().take(1)), &Budget::unlimited()).expect("it loads");
    assert_eq!(
        missing.notes[1],
        "a.3mf: texture /3D/Textures/a%20b.png is not shown: the archive has no such part"
    );
    assert!(missing.images.is_empty() && missing.columns.uvs.is_empty());
}

#[test]
fn models_of_other_parts() {
    let root = r#"<model requiredextensions="p" xmlns:p="http://schemas.microsoft.com/3dmanufacturing/production/2015/06">
        <resources><object id="1"><components><component p:path="/3D/Objects/b.model" objectid="9"/>
        <component p:path="\3D\OBJECTS\b.model" objectid="9"/></components></object></resources>
        <build><item objectid="1"/></build></model>"#;
    let other = format!("<model>{}</model>", square("", "", TWO));
    let parts = |name| {
        [
            ("_rels/.rels", RELS.as_bytes()),
            ("3D/3dmodel.model", root.as_bytes()),
            (name, other.as_bytes()),
        ]
    };
    let mesh = read(&archive(parts("3D/Objects/b.model")), &Budget::unlimited()).expect("it loads");
    assert_eq!(mesh.columns.triangles.len(), 4);
    let fault = |name| read(&archive(parts(name)), &Budget::unlimited()).expect_err("a part is missing");
    assert_eq!(
        fault("3D/Objects/c.model"),
        "a.3mf/3D/3dmodel.model:2:47: the archive has no part `/3D/Objects/b.model`"
    );
    assert_eq!(fault("../3D/Objects/b.model"), fault("c"));
}

#[test]
fn faults_have_places() {
    let fault = |content: &str| load(content).expect_err("there is a fault");
    let at = |message: &str| format!("a.3mf/3D/3dmodel.model:{message}");
    let triangles = |triangle: &str| square("", "", &format!("\n<triangles>\n{triangle}</triangles>"));
    assert_eq!(
        fault(&triangles(r#"<triangle v1="0" v2="1" v3="7"/>"#)),
        at("3:29: vertex index 7, but the mesh has only 4 vertices")
    );
    assert_eq!(
        fault(&triangles(r#"<triangle v1="0" v2="1"/>"#)),
        at("3:1: `triangle` has no attribute `v3`")
    );
    assert_eq!(
        fault(&triangles(r#"<triangle v1="0" v2="1" v3="-1"/>"#)),
        at("3:29: `v3` is `-1`, expected a whole number")
    );
    assert_eq!(
        fault(&triangles(r#"<triangle v1="0" v2="1" v3="2" pid="3" p1="0"/>"#)),
        at("3:37: there is no property group 3 before this")
    );
    let colors = r##"<m:colorgroup id="1"><m:color color="#FF0000"/></m:colorgroup>"##;
    let beyond = r#"<triangles>
        <triangle v1="0" v2="1" v3="2" pid="1" p1="0" p2="1"/></triangles>"#;
    assert_eq!(
        fault(&square(colors, "", beyond)),
        at("2:9: property 1, but group 1 has only 1")
    );
    assert_eq!(
        fault("\n<resources><m:colorgroup id=\"1\"><m:color color=\"red\"/>"),
        at("2:49: found `red`, expected a colour such as `#FF8000`")
    );
    assert_eq!(
        fault(
            "\n<resources><object id=\"1\"><mesh><vertices><vertex x=\"0\" y=\"nan\" z=\"0\"/></vertices><triangles>\
             <triangle v1=\"0\" v2=\"0\" v3=\"0\"/></triangles></mesh></object></resources><build><item objectid=\"1\"/></build>"
        ),
        at("2:60: y is NaN, expected a finite number")
    );
    assert_eq!(
        fault("\n<build><item objectid=\"4\" transform=\"1 0 0 0 x\"/></build>"),
        at("2:46: found `x`, expected a number of a transform")
    );
    assert_eq!(
        fault("\n<build><item objectid=\"4\" transform=\"1 0 0\"/></build>"),
        at("2:38: a transform of fewer than 12 numbers")
    );
    assert_eq!(
        fault("\n<build><item objectid=\"4\"/></build>"),
        at("2:8: there is no object 4")
    );
    let far = square("", "", TWO).replace("<item", "\n<item transform=\"1 0 0 0 1 0 0 0 1 1e9 0 0\"");
    let far = far.replace("x=\"1\"", "x=\"1e9\"");
    assert_eq!(
        fault(&far),
        at("2:1: vertex 1 of object 9: x is 2e9, but numbers above 1e9 are not supported")
    );
}

#[test]
fn extensions_that_matter_are_refused() {
    let load = |namespace: &str| {
        let model = format!("<model xmlns:a=\"{namespace}\" requiredextensions=\"a\"></model>");
        read(
            &archive([("3D/3dmodel.model", model.as_bytes())]),
            &Budget::unlimited(),
        )
        .map(|mesh| mesh.columns.triangles.len())
    };
    let schema = |name: &str| format!("http://schemas.microsoft.com/3dmanufacturing/{name}");
    assert_eq!(load(&schema("material/2015/02")), Ok(0));
    assert_eq!(
        load(&schema("beamlattice/2017/02")),
        Err(
            "a.3mf/3D/3dmodel.model:1:103: the file requires beam lattices, which octray does not support"
                .into()
        )
    );
    let error = load(&schema("securecontent/2019/04")).expect_err("it is encrypted");
    assert!(
        error.ends_with("the file requires encryption, which octray does not support"),
        "{error}"
    );
    let error = load("urn:x").expect_err("it is unknown");
    assert!(
        error.ends_with("the file requires the extension `urn:x`, which octray does not support"),
        "{error}"
    );
    let lattice = square(
        "",
        "",
        &format!("{TWO}<b:beamlattice><b:beams/></b:beamlattice><x:y/>"),
    );
    assert_eq!(
        loaded(&lattice).notes,
        ["a.3mf: left out: beam lattices, elements `y`"]
    );
}

#[test]
fn components_that_multiply_are_refused() {
    let objects = |count: usize, of_each: &str, first: &str| -> String {
        let object = |i: usize| {
            let component = format!("<component objectid=\"{}\"/>", i - 1);
            format!(
                "\n<object id=\"{i}\"><components>{}</components></object>",
                of_each.replace('x', &component)
            )
        };
        let all: String = (2..=count).map(object).collect();
        let square = format!("<object id=\"1\">{first}</object>");
        format!("<resources>{square}{all}</resources><build>\n<item objectid=\"{count}\"/></build>")
    };
    let square = format!("<mesh>{SQUARE}{TWO}</mesh>");
    assert_eq!(loaded(&objects(20, "x", &square)).columns.triangles.len(), 2);
    assert_eq!(loaded(&objects(10, "xx", &square)).columns.triangles.len(), 1024);
    let fault = |content: &str| load(content).expect_err("it is too much");
    let bomb = fault(&objects(60, "xxxxxxxx", &square));
    assert!(
        bomb.starts_with(
            "a.3mf: 18446744073709551615 triangles, counted once for each component that places them, expected at most"
        ),
        "{bomb}"
    );
    assert_eq!(
        fault(&objects(30, "xx", "<mesh></mesh>")),
        "a.3mf: 1073741823 objects and components, expected at most 1048576"
    );
    assert_eq!(
        fault(&objects(100, "x", &square)),
        "a.3mf/3D/3dmodel.model:37:29: components nest more than 64 deep"
    );
    // Each is counted before the next.
    let upward = objects(100, "x", &square).replace("<build>\n", &{
        let items: String = (1..100).map(|i| format!("<item objectid=\"{i}\"/>")).collect();
        format!("<build>\n{items}\n")
    });
    assert!(fault(&upward).ends_with("components nest more than 64 deep"));
    let circle = "<resources><object id=\"1\"><components>\n<component objectid=\"2\"/></components></object>\
                  <object id=\"2\"><components>\n<component objectid=\"1\"/></components></object></resources>\
                  <build><item objectid=\"1\"/></build>";
    assert_eq!(
        fault(circle),
        "a.3mf/3D/3dmodel.model:3:1: object 1 contains itself"
    );
}

#[test]
fn broken_archives() {
    let read = |bytes: &[u8]| read(bytes, &Budget::unlimited()).expect_err("it is broken");
    assert_eq!(read(b""), "a.3mf: the file is empty, expected a 3MF mesh");
    assert_eq!(
        read(b"solid"),
        "a.3mf: this is not a ZIP archive, expected a 3MF mesh"
    );
    let good = archive([(
        "3D/3dmodel.model",
        format!("<model>{}</model>", square("", "", TWO)).as_bytes(),
    )]);
    assert_eq!(
        read(&good[..good.len() / 2]),
        "a.3mf: the ZIP archive has no end: the file is cut short or broken"
    );
    assert_eq!(
        read(&archive([("a.txt", &b"text"[..])])),
        "a.3mf: this is a ZIP archive, not a 3MF mesh; unpack it first"
    );
    assert_eq!(
        read(&archive([("_rels/.rels", RELS.as_bytes())])),
        "a.3mf/_rels/.rels:1:45: the archive has no part `/3D/3dmodel.model`"
    );
    assert_eq!(
        read(&archive([("3D/3dmodel.model", &b"\xff\xfe<\0m\0"[..])])),
        "a.3mf/3D/3dmodel.model:1:1: this is UTF-16, expected XML in UTF-8 or ASCII"
    );
    assert_eq!(
        read(&archive([("3D/3dmodel.model", &b"<html/>"[..])])),
        "a.3mf/3D/3dmodel.model:1:1: found the element `html`, expected `model`"
    );
    // One byte of the part differs from its checksum.
    let mut wrong = good.clone();
    let at = wrong
        .windows(6)
        .position(|window| window == b"<model")
        .expect("it is stored");
    wrong[at + 1] = b'M';
    assert!(read(&wrong).starts_with("a.3mf/3D/3dmodel.model: the part is broken: invalid checksum"));
    let set = |which: &[u8], offset: usize, value: u8| {
        let mut bytes = good.clone();
        let headers = (0..bytes.len()).filter(|&i| bytes[i..].starts_with(which));
        for at in headers.collect::<Vec<_>>() {
            bytes[at + offset] = value;
        }
        bytes
    };
    assert_eq!(
        read(&set(b"PK\x01\x02", 8, 1)),
        "a.3mf/3D/3dmodel.model: the part is encrypted, which octray does not read"
    );
    assert_eq!(
        read(&set(b"PK\x01\x02", 10, 12)),
        "a.3mf/3D/3dmodel.model: the part is compressed by BZIP2, expected DEFLATE"
    );
    // Shorter than the part: the checksum is that of all its bytes.
    let stated = read(&set(b"PK\x01\x02", 24, 0));
    assert!(
        stated.starts_with("a.3mf/3D/3dmodel.model: the part is broken: invalid checksum"),
        "{stated}"
    );
    let stated = read(&set(b"PK\x01\x02", 27, 0x7f));
    assert!(stated.ends_with("bytes do not inflate to 2.0 GiB"), "{stated}");
}

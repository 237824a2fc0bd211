//! Pictures of `--crop` joined together equal the whole picture, byte for byte, with every option of `octray render` that
//! changes pixels.
//!
//! `OCTRAY_LONG=1` cuts every picture in six, not in four.

use crate::{
    long::rounds,
    program::{Folder, PLANE, shipped_mesh},
};
use exr::prelude::{FlatSamples, read_first_flat_layer_from_file};
use std::{collections::BTreeMap, path::Path};

/// Size of the whole picture.
const SIZE: [usize; 2] = [61, 43];
/// Where the picture is cut.
const COLUMNS: [usize; 4] = [0, 1, 30, 61];
/// Where one picture is cut and the next one, if each has four parts.
const COLUMNS_IN_TURN: [[usize; 3]; 2] = [[0, 1, 61], [0, 30, 61]];
const ROWS: [usize; 3] = [0, 19, 43];

const SCENE: &str = "\
camera eye 3 -3 1.5 target 0 0 0.4 fov 40
camera near eye 2 -1 1 target 0 0 0.4
ambient 0.1 reach 0.5
light 3 -2 5 0.7 color 1 0.8 0.6 radius 1
light -4 -6 3 0.4
material matte cd 0.9 0.9 0.7
triangle -5 -5 0  5 -5 0  0 5 0
material reflection mix 0.6
sphere 0 0 0.5 0.5
material blinn_phong cd 0.2 0.5 0.9
sphere 0.8 -0.4 0.3 0.3
";

const GLASS: &str = "\
camera eye 3 -3 1.5 target 0 0 0.4 fov 40
camera inside eye 0.1 -0.2 0.6 target 0.8 -0.4 0.1
light 3 -2 5 0.3 radius 1
directional_light 1 -1 2 0.2 angle 5
light -1 -1 3 0.5 rectangle 1 0 0 0 -1 0 falloff 2 spot 0 0 -1 20 60
environment bottom 0.3 0.25 0.2 top 0.1 0.3 0.7
material matte cd 0.9 0.9 0.7
triangle -5 -5 0  5 -5 0  0 5 0
material glass tint 0.5 0.9 0.7
sphere 0 0 0.5 0.5
material glass ior 2.4
sphere 0.8 -0.4 0.3 0.3
material reflection mix 0.6 opacity 0.7
sphere 0.1 0.1 0.6 0.2
material matte cd 0.4 0.6 0.9 opacity 0.4
triangle 1 -2 0  2 0 0  1.5 -1 2
";

/// To be lit by an environment map with a sun.
const SKY: &str = "\
camera eye 3 -3 1.5 target 0 0 0.4 fov 40
material matte
triangle -5 -5 0  5 -5 0  0 5 0
material glass tint 0.5 0.9 0.7
sphere 0 0 0.5 0.5
material reflection mix 0.6
sphere 0.8 -0.4 0.3 0.3
";

/// Meshes and a point cloud, each stored once.
const INSTANCES: &str = "\
camera eye 3 -3 1.5 target 0 0 0.4 fov 40
ambient 0.1 reach 0.5
smooth_shadows
ambient_specular
light 3 -2 5 0.7 radius 1
instance colors.obj scale 0.6 translate 0.3 0 0.2
instance points.obj scale 0.4 placements placed.txt point_size 0.2
material reflection mix 0.6
instance colors.obj scale 1 -0.7 1 rotate 0 0 1 30 translate -0.5 0.5 0
material matte
triangle -5 -5 0  5 -5 0  0 5 0
";

/// A mesh and a camera that move.
const MOVING: &str = "\
camera eye 3 -3 1.5 target 0 0 0.4 fov 40
  at 1
  at 4 eye 3 1 2.5
light 3 -2 5 0.7 radius 1
instance colors.obj scale 0.6
  at 0 rotate 0 0 1 0
  at 3 rotate 1 0 1 200
material matte
triangle -5 -5 0  5 -5 0  0 5 0
";

/// A fisheye lens whose circle is in the picture.
const FISHEYE: &str = r#"{"camera_model":"OPENCV_FISHEYE","fl_x":11,"fl_y":10,"w":61,"h":43,"cx":28,"cy":22,"k1":0.03,"k2":-0.02,
"frames":[{"transform_matrix":[[0.7071,-0.1775,0.6845,3],[0.7071,0.1775,-0.6845,-3],[0,0.968,0.251,1.5]]}]}"#;

const ALL: &str = "--aov depth,normal,albedo,id,heat,mask,z,instance";

/// Scene or mesh, format, options. Each option that changes pixels is in at least one case.
const CASES: [(&str, &str, &str); 55] = [
    ("instances.scn", "exr", ALL),
    (
        "instances.scn",
        "png",
        "--samples 9 --pattern sobol --background transparent",
    ),
    (
        "instances.scn",
        "png",
        "--sphere 9 --frames 2-2 --target 0.1,0,0.3 --aov mask,z,instance --z-step 0.002",
    ),
    ("a.scn", "png", ""),
    ("b.scn", "png", ALL),
    (
        "b.scn",
        "png",
        "--samples 4 --filter tent --mode scalar --srgb --aov albedo,depth",
    ),
    (
        "b.scn",
        "png",
        "--samples 9 --pattern sobol --filter blackman-harris --background transparent",
    ),
    (
        "b.scn",
        "png",
        "--samples 4 --pattern stratified --background transparent --srgb --aov id,heat,normal",
    ),
    (
        "glass.scn",
        "png",
        "--samples 4 --max-depth 7 --aov albedo,normal",
    ),
    (
        "glass.scn",
        "exr",
        "--mode scalar --camera inside --max-depth 5 --background transparent",
    ),
    ("sky.scn", "exr", "--samples 4"),
    ("sky.scn", "png", "--samples auto:9 --mode scalar --srgb"),
    ("b.scn", "png", "--samples 5 --filter tent --linear --threads 1"),
    (
        "b.scn",
        "qoi",
        "--camera near --samples 4 --background transparent --no-shadows",
    ),
    (
        "b.scn",
        "tiff",
        "--view 3 --fov 60 --max-depth 1 --background scene",
    ),
    (
        "b.scn",
        "ppm",
        "--eye 2,-3,1 --target 0,0,0.3 --up 0.1,0,1 --build fast",
    ),
    (
        "b.scn",
        "bmp",
        "--turntable 5 --frames 3 --samples 4 --filter blackman-harris",
    ),
    ("b.scn", "exr", "--samples 4 --pattern stratified --filter tent"),
    (
        "b.scn",
        "exr",
        "--background transparent --samples 3 --pattern sobol --aov depth,normal,albedo,id,heat",
    ),
    (
        "vase.obj",
        "png",
        "--ground --smooth-angle 40 --lit-from=1,-2,3 --samples 4 --aov depth,normal,albedo,id,heat",
    ),
    (
        "vase.obj",
        "png",
        "--up-axis z --fov 20 --filter tent --samples 4 --mode scalar",
    ),
    (
        "gear.stl",
        "exr",
        "--ground --turntable 4 --frames 2-2 --aov heat,depth --background transparent",
    ),
    (
        "house.stl",
        "tif",
        "--eye 5,4,3 --samples 4 --background transparent --build best",
    ),
    ("house.stl", "png", "--from -60,30 --ortho fit --samples 4"),
    ("mobile.gltf", "png", "--camera front --ground --srgb --samples 4"),
    ("mobile.gltf", "png", "--style studio --ground --samples 5"),
    ("stairs.3mf", "png", "--style studio --samples 5 --aov albedo"),
    ("mobile.gltf", "png", "--style clay --ground --aov id"),
    (
        "vase.obj",
        "png",
        "--environment sky.hdr --environment-rotate 40 --ground --samples auto:9",
    ),
    ("b.scn", "png", "--samples auto --background transparent"),
    ("b.scn", "png", "--samples auto --background 336699"),
    ("b.scn", "exr", "--samples auto:7 --filter tent --mode scalar"),
    ("b.scn", "png", "--samples auto:64"),
    (
        "tetrahedron.ply",
        "png",
        "--target 0.2,0,0 --up 0,0.2,1 --aov normal",
    ),
    ("garden.obj", "png", "--samples 4 --aov albedo,id,depth"),
    (
        "garden.obj",
        "png",
        "--style studio --samples 5 --mode scalar --aov albedo",
    ),
    ("colors.obj", "png", "--samples 4 --aov albedo,depth"),
    (
        "colors.obj",
        "exr",
        "--mode scalar --ground --smooth-angle 30 --aov albedo",
    ),
    ("points.obj", "png", "--ground --samples 4 --aov albedo,normal"),
    ("b.scn", "exr", "--ortho 3 --samples auto:9 --aov depth,normal"),
    (
        "garden.obj",
        "png",
        "--ortho 4 --samples 4 --mode scalar --aov depth",
    ),
    ("b.scn", "png", "--aperture 0.4 --focus 3 --samples 4 --aov depth"),
    (
        "b.scn",
        "png",
        "--poses fisheye.json --samples auto:9 --filter tent --aov z,mask,normal",
    ),
    ("glass.scn", "exr", "--aperture 0.2 --samples auto:9"),
    ("gear.stl", "png", "--edges --ground --samples auto:9"),
    (
        "glass.scn",
        "exr",
        "--edges=2.5 --samples 4 --background transparent",
    ),
    (
        "instances.scn",
        "png",
        "--edges=3 --edge-color ff8000 --ortho 3 --mode scalar",
    ),
    (
        "instances.scn",
        "png",
        "--edges=1.5 --poses fisheye.json --samples auto:9 --filter tent",
    ),
    ("plane.scn", "exr", ALL),
    ("moving.scn", "exr", "--frames 2-2 --samples 4 --aov depth,heat"),
    ("plane.scn", "png", "--samples auto:9 --filter tent"),
    ("points.obj", "png", "--point-size 0.3 --mode scalar --aov id"),
    (
        "vase.obj",
        "png",
        "--color-by y --color-map turbo --color-range 0.2,1 --samples auto:9 --aov albedo",
    ),
    (
        "points.obj",
        "exr",
        "--color-by x --style plain --mode scalar --samples 4",
    ),
    (
        "swing.gltf",
        "png",
        "--animation swing --animation-time 0.7 --samples 4",
    ),
];

/// A triangle that turns.
pub const SWING: &str = r#"{"asset":{"version":"2.0"},"nodes":[{"mesh":0}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
"animations":[{"name":"swing","channels":[{"sampler":0,"target":{"node":0,"path":"rotation"}}],
"samplers":[{"input":1,"output":2}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},
{"bufferView":0,"byteOffset":36,"componentType":5126,"count":2,"type":"SCALAR"},
{"bufferView":0,"byteOffset":44,"componentType":5126,"count":2,"type":"VEC4"}],
"bufferViews":[{"buffer":0,"byteLength":76}],
"buffers":[{"byteLength":76,"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAA/AAAAAAAAAEAAAAAAAAAAAAAAAAAAAIA/AAAAAJqZGT8AAAAAzcxMPw=="}]}"#;

/// A pyramid with a colour at each corner.
const COLORS: &str = "\
v 0 0 0 1 0 0
v 1 0 0 0 1 0
v 1 0 1 0 0 1
v 0 0 1 1 1 0
v 0.5 1 0.5 1 1 1
vn -1 -1 -1
vn 1 -1 -1
vn 1 -1 1
vn -1 -1 1
vn 0 1 0
f 1//1 2//2 3//3 4//4
f 1//1 5//5 2//2
f 2//2 5//5 3//3
f 3//3 5//5 4//4
f 4//4 5//5 1//1
";

/// A helix of coloured points.
fn points() -> String {
    let point = |i: i32| {
        let (turn, height) = (f64::from(i) * 0.3, f64::from(i) / 80.0);
        format!(
            "v {} {height} {} {height} {} 0.5\n",
            turn.cos(),
            turn.sin(),
            1.0 - height
        )
    };
    (0..80).map(point).collect()
}

/// Every channel of a picture: its name, and the bits of its values row by row.
type Channels = BTreeMap<String, Vec<u32>>;

fn channels(path: &Path) -> Channels {
    if path.extension().is_some_and(|extension| extension == "exr") {
        let file = read_first_flat_layer_from_file(path).expect("an EXR file");
        let list = file.layer_data.channel_data.list;
        let bits = list.into_iter().map(|channel| {
            let bits = match channel.sample_data {
                FlatSamples::F32(values) => values.into_iter().map(f32::to_bits).collect(),
                FlatSamples::U32(values) => values,
                FlatSamples::F16(_) => panic!("half floats lose precision"),
            };
            (channel.name.to_string(), bits)
        });
        return bits.collect();
    }
    let picture = image::open(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    // Each byte of a channel of 16 bits is one.
    let depth = usize::from(picture.color().bytes_per_pixel());
    let channel = |i| {
        let values = picture.as_bytes().iter().skip(i).step_by(depth);
        (i.to_string(), values.map(|&byte| byte.into()).collect())
    };
    (0..depth).map(channel).collect()
}

/// A folder with the inputs of all cases that are not shipped.
fn folder_of_inputs() -> Folder {
    let folder = Folder::new();
    folder.write("b.scn", SCENE);
    folder.write("glass.scn", GLASS);
    let map = shipped_mesh("../skies/evening.hdr");
    std::fs::copy(&map, folder.path("sky.hdr")).expect("the map is shipped");
    folder.write("sky.scn", &format!("{SKY}environment \"{map}\" rotate 20\n"));
    folder.write("plane.scn", PLANE);
    folder.write("instances.scn", INSTANCES);
    folder.write("moving.scn", MOVING);
    folder.write("fisheye.json", FISHEYE);
    folder.write("placed.txt", "0 0 0.5\n0 -1 0 0.7  1 0 0 -0.6  0 0.2 1 0.3\n");
    folder.write("colors.obj", COLORS);
    folder.write("swing.gltf", SWING);
    folder.write("points.obj", &points());
    folder
}

/// Renders, removes and returns the channels of each written file, by its name.
fn render(
    folder: &Folder,
    input: &str,
    format: &str,
    options: &str,
    crop: &str,
) -> BTreeMap<String, Channels> {
    let input = if folder.path(input).exists() {
        input.to_owned()
    } else {
        shipped_mesh(input)
    };
    let size = format!("{}x{}", SIZE[0], SIZE[1]);
    let output = format!("made.{format}");
    let mut arguments = vec!["render", &input, "--size", &size, "-o", &output, "--quiet"];
    arguments.extend(options.split_whitespace().chain(crop.split_whitespace()));
    folder.run(&arguments).succeeded();
    let made = folder.names().into_iter().filter(|name| name.starts_with("made"));
    let files: BTreeMap<String, Channels> = made
        .map(|name| {
            let path = folder.path(&name);
            let channels = channels(&path);
            std::fs::remove_file(path).expect("removed");
            (name, channels)
        })
        .collect();
    assert!(!files.is_empty(), "{arguments:?}");
    files
}

/// Copies a crop's values to their place in the whole picture.
fn put(whole: &mut Channels, crop: Channels, [x0, y0, x1, y1]: [usize; 4]) {
    for (name, values) in crop {
        let channel = whole.entry(name).or_insert_with(|| vec![0; SIZE[0] * SIZE[1]]);
        assert_eq!(values.len(), (x1 - x0) * (y1 - y0));
        for (row, values) in values.chunks(x1 - x0).enumerate() {
            let start = (y0 + row) * SIZE[0] + x0;
            channel[start..start + values.len()].copy_from_slice(values);
        }
    }
}

#[test]
fn crops_equal_the_picture_with_every_option() {
    let folder = folder_of_inputs();
    for (i, (input, format, options)) in CASES.into_iter().enumerate() {
        let columns: &[usize] = rounds(&COLUMNS_IN_TURN[i % 2], &COLUMNS);
        let whole = render(&folder, input, format, options, "");
        let mut together: BTreeMap<String, Channels> = BTreeMap::new();
        for y in ROWS.windows(2) {
            for x in columns.windows(2) {
                let place = [x[0], y[0], x[1], y[1]];
                let crop = format!("--crop {},{},{},{}", x[0], y[0], x[1], y[1]);
                for (name, crop) in render(&folder, input, format, options, &crop) {
                    put(together.entry(name).or_default(), crop, place);
                }
            }
        }
        for (name, channels) in &whole {
            let shown = channels
                .values()
                .any(|values| values.iter().any(|value| *value != values[0]));
            assert!(shown, "{input} {options}: {name} has one value");
        }
        assert!(
            together == whole,
            "{input} {options}: the crops differ from the picture"
        );
    }
}

/// Each option is in [`CASES`] or, if it changes no pixels, in this list.
#[test]
fn every_option_that_changes_pixels_has_a_case() {
    const NO_PIXELS: [&str; 22] = [
        // It needs larger pictures: see colors/bar.rs.
        "--color-bar",
        "--output",
        "--force",
        "--size",
        "--crop",
        "--stats",
        "--json",
        "--quiet",
        "--skip-existing",
        "--fps",
        "--sheet",
        "--keep-going",
        "--save-poses",
        "--compare",
        "--tolerance",
        "--allow-pixels",
        "--difference",
        "--config",
        "--no-config",
        "--max-memory",
        "--help",
        "--version",
    ];
    let help = Folder::new().run(&["render", "--help"]);
    // Only descriptions are indented this far.
    let options: Vec<&str> = help
        .succeeded()
        .text()
        .lines()
        .filter(|line| !line.starts_with("       "))
        .filter_map(|line| line.split([' ', '=', '[']).find(|word| word.starts_with("--")))
        .collect();
    assert!(options.len() > 25, "{options:?}");
    for option in options {
        let tried = CASES
            .iter()
            .any(|(_, _, words)| words.split([' ', '=']).any(|word| word == option));
        assert!(tried || NO_PIXELS.contains(&option), "{option}");
    }
    for what in ["grid", "stratified", "sobol", "box", "tent", "blackman-harris"] {
        let tried = CASES
            .iter()
            .any(|(_, _, words)| words.split(' ').any(|word| word == what));
        assert!(tried || ["grid", "box"].contains(&what), "{what}");
    }
}

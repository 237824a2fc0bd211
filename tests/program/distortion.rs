//! Cameras of data sets whose lenses have distortion.

use crate::{poses::spot, program::Folder};
use std::fs;

/// Points, small spheres around them, seen by a camera at (0, -5, 0) that looks along y.
const POINTS: [[f64; 3]; 4] = [
    [0.0, 0.0, 0.0],
    [1.6, -3.0, -0.5],
    [-1.3, -3.2, 0.9],
    [0.4, -3.5, 0.7],
];

/// A camera of COLMAP in a picture of 320x240, and where `pycolmap.Camera.img_from_cam` of pycolmap 4.2.1 has [`POINTS`].
const CAMERAS: [(&str, [[f64; 2]; 4]); 8] = [
    (
        "SIMPLE_RADIAL 320 240 150 150 110 -0.15",
        [
            [150.000000, 110.000000],
            [257.355000, 143.548438],
            [54.205247, 43.680556],
            [188.266667, 43.033333],
        ],
    ),
    (
        "RADIAL 320 240 150 150 110 -0.2 0.05",
        [
            [150.000000, 110.000000],
            [256.101038, 143.156574],
            [55.159830, 44.341421],
            [187.855802, 43.752346],
        ],
    ),
    (
        "OPENCV 320 240 170 150 150 101.5 -0.2 0.05 0.01 -0.02",
        [
            [150.000000, 101.500000],
            [264.187342, 134.697824],
            [37.571882, 35.582162],
            [191.014354, 37.085679],
        ],
    ),
    (
        "FULL_OPENCV 320 240 170 150 150 101.5 0.4 -0.1 0.01 -0.02 0.02 0.55 0.03 0.004",
        [
            [150.000000, 101.500000],
            [264.038799, 134.656866],
            [38.075671, 35.889906],
            [191.344730, 36.575540],
        ],
    ),
    (
        "SIMPLE_FISHEYE 320 240 150 150 110",
        [
            [150.000000, 110.000000],
            [249.873317, 141.210412],
            [61.109720, 48.460575],
            [186.703103, 45.769570],
        ],
    ),
    (
        "SIMPLE_RADIAL_FISHEYE 320 240 150 150 110 -0.05",
        [
            [150.000000, 110.000000],
            [247.443339, 140.451044],
            [63.418612, 50.059039],
            [186.256739, 46.550707],
        ],
    ),
    (
        "RADIAL_FISHEYE 320 240 150 150 110 0.05 -0.04",
        [
            [150.000000, 110.000000],
            [251.357330, 141.674165],
            [59.760390, 47.526424],
            [187.062612, 45.140429],
        ],
    ),
    (
        "OPENCV_FISHEYE 320 240 170 150 150 101.5 0.05 -0.04 0.03 -0.01",
        [
            [150.000000, 101.500000],
            [265.199445, 133.264553],
            [47.378101, 38.812415],
            [192.020794, 36.614950],
        ],
    ),
];

fn read(folder: &Folder, name: &str) -> Vec<u8> {
    fs::read(folder.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

fn json(folder: &Folder, name: &str) -> serde_json::Value {
    serde_json::from_slice(&read(folder, name)).expect("JSON")
}

/// The radius of the sphere around a point: 1.5 pixels, or less where the picture is compressed.
fn radius(y: f64) -> f64 {
    0.01 * (y + 5.0)
}

/// A folder with a scene of [`POINTS`], and one of shaded things, for a camera of COLMAP.
fn folder_of(camera: &str) -> Folder {
    let folder = Folder::new();
    let spheres = POINTS
        .map(|[x, y, z]| format!("sphere {x} {y} {z} {}\n", radius(y)))
        .concat();
    let scene = "camera eye 0 -5 0 target 0 0 0\nbackground 0 0 0\nambient 1\nmaterial matte cd 1 1 1\n";
    folder.write("p.scn", &format!("{scene}{spheres}"));
    folder.write(
        "t.scn",
        "light 3 -6 5 0.6\nambient 0.1\nmaterial matte cd 0.7 0.6 0.5\nsphere 0 -2 0 0.7\nsphere 1 -7 1 0.5\n\
         material reflection mix 0.5\nsphere -2 -3 0 0.6\nmaterial matte\ntriangle -9 -9 -0.6  9 -9 -0.6  0 12 -0.6\n",
    );
    fs::create_dir(folder.path("sparse")).expect("a folder");
    folder.write("sparse/cameras.txt", &format!("1 {camera}\n"));
    // A turn by 90 degrees about x: y of the scene is z of the camera, and z is up.
    let half = 0.5_f64.sqrt();
    folder.write(
        "sparse/images.txt",
        &format!("1 {half} {half} 0 0 0 0 5 1 c.png\n\n2 0.7 0.68 0.1 -0.2 0.3 -0.1 5 1 d.png\n\n"),
    );
    folder
}

/// Without a warning, at the file's size and, for two of the models, twice as large. Depth is along the optical axis and along the ray.
/// Adaptive pictures have all samples at the outlines of the spheres; two of the pictures have them everywhere.
#[test]
fn points_are_where_colmap_projects_them() {
    for (camera, pixels) in CAMERAS {
        let folder = folder_of(camera);
        let sizes = [("", 1.0), ("--size 640x480", 2.0)];
        let is_scaled = camera.starts_with("FULL_OPENCV") || camera.starts_with("OPENCV_FISHEYE");
        for (options, scale) in &sizes[..if is_scaled { 2 } else { 1 }] {
            let samples = if is_scaled && options.is_empty() {
                "36"
            } else {
                "auto:36"
            };
            let line = format!(
                "p.scn --poses sparse --frames 1-1 -o c.png --samples {samples} --aov z,mask {options}"
            );
            let run = folder.run_line(&line);
            assert_eq!((run.code, &run.stderr[..]), (Some(0), ""), "{camera}");
            let picture = image::open(folder.path("c.png")).expect("a picture").into_rgb8();
            let depth = image::open(folder.path("c.z.png")).expect("a picture");
            for ([x, y, z], pixel) in POINTS.into_iter().zip(pixels) {
                let expected = pixel.map(|at| at * scale);
                let found = spot(&picture, expected);
                let off = (found[0] - expected[0]).hypot(found[1] - expected[1]);
                assert!(off < 0.05 * scale, "{camera}: {expected:?} {found:?}");
                let steps = depth.as_luma16().expect("16 bits");
                let steps = steps.get_pixel(expected[0] as u32, expected[1] as u32).0[0];
                // The sphere's surface is at most its radius nearer.
                let nearer = y + 5.0 - f64::from(steps) * 0.001;
                assert!(
                    (-0.012..radius(y) + 0.001).contains(&nearer),
                    "{camera}: {x} {z}: {nearer}"
                );
            }
        }
    }
}

/// Crops put together and every mode have the pixels of the whole, in pictures with pixels that see nothing, too.
#[test]
fn distorted_cameras_have_the_same_pixels_everywhere() {
    for (camera, options) in [
        (
            "OPENCV 160 120 95 90 75 50.75 -0.3 0.06 0.01 -0.02",
            "--samples 4 --filter tent",
        ),
        (
            "OPENCV_FISHEYE 160 120 30 30 75 55 0.02 -0.01 0.003 0",
            "--samples 4",
        ),
        (
            "SIMPLE_RADIAL 160 120 75 75 55 -0.4",
            "--samples auto:16 --background transparent",
        ),
    ] {
        let folder = folder_of(camera);
        let scene = format!("t.scn --poses sparse --frames 2-2 {options} --aov z,mask,depth,normal");
        for (name, more) in [
            ("whole", ""),
            ("scalar", "--mode scalar"),
            ("one", "--threads 1"),
            ("a", "--crop 0,0,59,120"),
            ("b", "--crop 59,0,160,66"),
            ("c", "--crop 59,66,160,120"),
        ] {
            folder
                .run_line(&format!("{scene} {more} -o {name}.png"))
                .succeeded();
        }
        for aov in ["", ".z", ".mask", ".depth", ".normal"] {
            let [a, b, c] = ["a", "b", "c"].map(|name| format!("{name}{aov}.png"));
            folder
                .run_line(&format!("merge {a} {b} {c} -o merged{aov}.png"))
                .succeeded();
            for name in ["scalar", "one", "merged"] {
                let same =
                    read(&folder, &format!("{name}{aov}.png")) == read(&folder, &format!("whole{aov}.png"));
                assert!(same, "{camera}: {name}{aov}");
            }
        }
    }
}

/// A fisheye lens sees what is beside and behind the camera, and nothing outside of its circle.
#[test]
fn a_fisheye_lens_sees_behind_itself() {
    let folder = folder_of("SIMPLE_FISHEYE 320 240 30 160 120");
    folder.write(
        "round.scn",
        "background 0 0 1\nambient 1\nmaterial matte cd 1 0 0\nsphere 1 -5.5 0 0.2\nmaterial matte cd 0 1 0\nsphere 0 0 0 0.5\n",
    );
    folder
        .run_line("round.scn --poses sparse --frames 1-1 -o r.png --aov z,mask")
        .succeeded();
    let picture = image::open(folder.path("r.png")).expect("a picture").into_rgb8();
    // 116.6 degrees to the right are 61 pixels.
    assert_eq!(picture.get_pixel(221, 120).0, [255, 0, 0]);
    assert_eq!(picture.get_pixel(160, 120).0, [0, 255, 0]);
    // The circle has a radius of 94.2 pixels.
    assert_eq!(picture.get_pixel(260, 120).0, [0, 0, 255]);
    let gray = |name: &str, x| {
        let picture = image::open(folder.path(name)).expect("a picture").into_luma16();
        picture.get_pixel(x, 120).0[0]
    };
    assert_eq!(["r.mask.png"; 3].map(|name| gray(name, 221)), [65535; 3]);
    assert_eq!((gray("r.mask.png", 160), gray("r.mask.png", 260)), (65535, 0));
    assert_eq!((gray("r.z.png", 221), gray("r.z.png", 260)), (0, 0));
    assert!((4499..4530).contains(&gray("r.z.png", 160)));
    // Outside, the background is as along the view, or transparent.
    folder
        .run_line("round.scn --poses sparse --frames 1-1 -o r.png --background transparent")
        .succeeded();
    let picture = image::open(folder.path("r.png")).expect("a picture").into_rgba8();
    assert_eq!(picture.get_pixel(260, 120).0, [0; 4]);
    assert_eq!(picture.get_pixel(221, 120).0, [255, 0, 0, 255]);
    folder
        .run_line("round.scn --poses sparse --frames 1-1 -o r.exr --aov z,depth")
        .succeeded();
    let depth = |name: &str, x: usize| {
        let image = exr::prelude::read_all_flat_layers_from_file(folder.path("r.exr")).expect("a picture");
        let mut channels = image.layer_data.iter().flat_map(|layer| &layer.channel_data.list);
        let channel = channels.find(|channel| channel.name.to_string().ends_with(name));
        let channel = channel.unwrap_or_else(|| panic!("no {name}"));
        channel.sample_data.value_by_flat_index(120 * 320 + x).to_f32()
    };
    let (z, along) = (depth("z.Z", 221), depth("depth.Z", 221));
    assert!(
        (-0.56..-0.3).contains(&z) && (0.9..1.0).contains(&along),
        "{z} {along}"
    );
    assert_eq!(
        (depth("z.Z", 260), depth("depth.Z", 260)),
        (f32::INFINITY, f32::INFINITY)
    );
}

/// What was read, rendered and saved is read again as it was.
#[test]
fn saved_distortions_make_the_same_pictures() {
    for (camera, _) in CAMERAS {
        let folder = folder_of(camera);
        let first = "t.scn --poses sparse --size 320x240 --samples 4 --save-poses t.json -o {pose}.png";
        folder.run_line(first).succeeded();
        let run = folder.run_line("t.scn --poses t.json --samples 4 --save-poses u.json -o again-{pose}.png");
        assert_eq!((run.code, &run.stderr[..]), (Some(0), ""), "{camera}");
        for name in ["c.png", "d.png"] {
            let again = read(&folder, &format!("again-{name}"));
            assert!(read(&folder, name) == again, "{camera}: {name}");
        }
        let (t, u) = (json(&folder, "t.json"), json(&folder, "u.json"));
        for key in [
            "camera_model",
            "is_fisheye",
            "k1",
            "k2",
            "k3",
            "k4",
            "k5",
            "k6",
            "p1",
            "p2",
        ] {
            assert_eq!(t[key], u[key], "{camera}");
        }
        assert_eq!(
            t["camera_model"].as_str().expect("a model").contains("FISHEYE"),
            camera.contains("FISHEYE")
        );
    }
}

#[test]
fn other_models_are_warned_of() {
    for camera in [
        "FOV 320 240 190 190 160 120 0.5",
        "THIN_PRISM_FISHEYE 320 240 190 190 160 120 0 0 0 0 0 0 0 0",
        "EUCM 320 240 190 190 160 120 0.5 1",
    ] {
        let folder = folder_of(camera);
        let run = folder.run_line("p.scn --poses sparse --size 32x24 -o {pose}.png");
        assert_eq!(run.code, Some(0), "{run:?}");
        assert!(
            run.stderr.contains("left out: lens distortion of a model"),
            "{run:?}"
        );
    }
}

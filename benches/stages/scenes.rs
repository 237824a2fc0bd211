//! The scenes: the shipped ones and a generated one, as files in memory and loaded.

use crate::view;
use octray::{
    accel::Bvh,
    bench::Workload,
    format::load_from_bytes,
    generate::{Kind, Options, Shape, generate, write_ply},
    scene::{Camera, Scene},
};
use std::{
    collections::HashMap,
    fs, io,
    path::{Path, PathBuf},
    sync::LazyLock,
};

/// Pixels along a side of the rays' picture.
const SIZE: u32 = 512;

/// The names, for divan's arguments.
pub const NAMES: [&str; 6] = [
    "silhouette",
    "matte",
    "blinn_phong",
    "reflections",
    "hall_of_mirrors",
    "figure",
];

/// A scene file and its meshes.
pub struct Files {
    text: Vec<u8>,
    meshes: HashMap<PathBuf, Vec<u8>>,
}

/// A scene, ready to be traced.
pub struct Ready {
    pub files: Files,
    pub scene: Scene,
    pub bvh: Bvh,
    pub camera: Camera,
    pub workload: Workload,
}

static ALL: LazyLock<Vec<Ready>> = LazyLock::new(|| NAMES.map(Ready::new).into());

/// The scene of that name.
pub fn ready(name: &str) -> &'static Ready {
    let i = NAMES.iter().position(|n| *n == name);
    &ALL[i.expect("divan's arguments are from the list")]
}

impl Files {
    fn shipped(name: &str) -> Self {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
        let text = fs::read(folder.join(name).with_extension("scn")).expect("scenes/ has it");
        let mut meshes = HashMap::new();
        for file in fs::read_dir(folder.join("meshes")).expect("scenes/ has meshes") {
            let path = file.expect("scenes/meshes can be read").path();
            let name = Path::new("meshes").join(path.file_name().unwrap_or_default());
            meshes.insert(name, fs::read(path).expect("scenes/meshes can be read"));
        }
        Self { text, meshes }
    }

    fn generated(kind: Kind) -> Self {
        let generated = generate(kind, Options::default()).expect("its own count is in its limits");
        let mut files = Self {
            text: Vec::new(),
            meshes: HashMap::new(),
        };
        generated
            .write_scn(&mut files.text)
            .expect("memory takes everything");
        for part in &generated.parts {
            if let (Shape::Mesh(mesh), Some(name)) = (&part.shape, generated.mesh_file_name(part)) {
                let mut bytes = Vec::new();
                write_ply(mesh, &mut bytes).expect("memory takes everything");
                files.meshes.insert(name.into(), bytes);
            }
        }
        files
    }

    /// Bytes of the scene file and all meshes at hand.
    pub fn bytes(&self) -> usize {
        self.text.len() + self.meshes.values().map(Vec::len).sum::<usize>()
    }

    /// Loads the scene, without the disk.
    pub fn load(&self) -> Scene {
        let mut open = |path: &Path| match self.meshes.get(path) {
            Some(bytes) => Ok(bytes.clone()),
            None => Err(io::ErrorKind::NotFound.into()),
        };
        load_from_bytes(&self.text, Path::new("scene.scn"), &mut open)
            .unwrap_or_else(|error| panic!("{}", error.report()))
    }
}

impl Ready {
    fn new(name: &str) -> Self {
        let files = match name {
            "figure" => Files::generated(Kind::Figure),
            _ => Files::shipped(name),
        };
        let scene = files.load();
        let bvh = Bvh::build(&scene);
        let told = view::told_in(&String::from_utf8_lossy(&files.text));
        let camera = told
            .or_else(|| Camera::classic_view(1))
            .expect("there is a view 1");
        let workload = Workload::new(&scene, &bvh, &camera, SIZE, SIZE);
        // The scalar tree is built at its first use: before the clock runs.
        bvh.binary(&scene);
        Self {
            files,
            scene,
            bvh,
            camera,
            workload,
        }
    }
}

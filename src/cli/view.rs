//! `octray view`: the live window.

use super::{
    CliError,
    args::ViewArgs,
    camera_args::{MeshArgs, UpArg},
    encode::Format,
    generate::quoted,
    input::{self, Input},
    interrupt::Interrupt,
    picture::Pixels,
    whole_file,
};
use crate::{
    error::escape,
    render::ByteFilm,
    scene::{Scene, View},
    viewer::{Display, Host, MAX_SIDE, Options, ViewError, orbit::Pose},
};
use clap::ValueEnum;
use glam::{DMat3, DVec3};
use std::{
    io::{self, Write},
    path::{Path, PathBuf},
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    time::Duration,
};

/// Pictures of one name that are saved at most.
const MOST_PICTURES: u32 = 99_999;

/// Opens the window, and returns when it is closed.
///
/// # Errors
/// [`CliError`].
pub fn run(args: &ViewArgs) -> Result<(), CliError> {
    let settings = args.trace.settings(args.size)?;
    let (width, height) = (settings.width, settings.height);
    if width.max(height) > MAX_SIDE {
        let why = format!("a window of {width}x{height}: no side can have more than {MAX_SIDE} pixels");
        return Err(CliError::Failed(why));
    }
    let interrupt = Arc::new(Interrupt::install_for_window()?);
    let display = Display::connect()?;
    let aspect = f64::from(width) / f64::from(height);
    let memory = args.memory.limit();
    let program = Program {
        path: args.scene.clone(),
        mesh: Mutex::new(args.mesh.clone()),
        lit_from: Mutex::default(),
        interrupt: Arc::clone(&interrupt),
        load: {
            let (path, camera) = (args.scene.clone(), args.camera.clone());
            Box::new(move |mesh, files| input::load_and_list(&path, &camera, mesh, aspect, memory, files))
        },
    };
    let mut files = Vec::new();
    let Input {
        scene,
        camera,
        lit_from,
        notes,
        rig: _,
    } = (program.load)(&args.mesh, &mut files)?;
    *program.lit_from() = lit_from;
    for note in notes {
        // That nobody reads standard error is no failure.
        let _ = writeln!(io::stderr(), "octray: warning: {}", escape(&note));
    }
    let View {
        eye,
        target,
        up,
        fov_degrees,
    } = camera.view();
    let pose = Pose {
        eye,
        target,
        up,
        fov_degrees,
    };
    // A window asks for rays without end.
    let quality = args.trace.build.quality(f64::INFINITY, scene.primitive_count());
    let host = Arc::new(program);
    let options = Options {
        name: args.scene.file_name().map_or_else(
            || args.scene.display().to_string(),
            |name| name.to_string_lossy().into_owned(),
        ),
        is_mesh: lit_from.is_some(),
        pose,
        settings,
        quality,
        budget: Duration::from_millis(u64::from(args.budget)),
        benchmark: args.benchmark.map(Duration::from_secs_f64),
    };
    let Some(report) = display.show(options, scene, files, host)? else {
        if args.benchmark.is_some() {
            let _ = writeln!(
                io::stderr(),
                "octray: warning: the window was closed before there were figures"
            );
        }
        return Ok(());
    };
    // A plain struct of numbers always serializes.
    let json = serde_json::to_string(&report).unwrap_or_default() + "\n";
    match &args.json {
        Some(path) if path.as_os_str() != "-" => {
            let write =
                || whole_file::write(path, &Interrupt::default(), |out| out.write_all(json.as_bytes()));
            (interrupt.hold_during(write))
                .map_err(|error| CliError::writing(&path.display().to_string(), &error))
        }
        Some(_) => super::print(&json),
        None => super::print(&format!(
            "{:.1} frames a second; a frame {:.1} ms (median), {:.1} ms (99 of 100); {:.0} % of the frames at full \
             quality; {:.1} million rays/s\n",
            report.fps,
            report.frame_ms_p50,
            report.frame_ms_p99,
            report.full_quality_share * 100.0,
            report.mrays_per_s
        )),
    }
}

/// What the window asks of the program.
struct Program {
    path: PathBuf,
    /// Keys turn the mesh.
    mesh: Mutex<MeshArgs>,
    load: Box<LoadScene>,
    /// Of what was loaded last.
    lit_from: Mutex<Option<DVec3>>,
    interrupt: Arc<Interrupt>,
}

impl Program {
    fn lit_from(&self) -> MutexGuard<'_, Option<DVec3>> {
        self.lit_from.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn mesh(&self) -> MutexGuard<'_, MeshArgs> {
        self.mesh.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What `octray render` must be told of a mesh besides the camera.
    fn mesh_options(&self) -> String {
        let mesh = self.mesh();
        let mut options = String::new();
        if let Some(axis) = mesh.up_axis.and_then(|axis| axis.to_possible_value()) {
            options += &format!(" --up-axis={}", axis.get_name());
        }
        if mesh.ground {
            options += " --ground";
        }
        if let Some(degrees) = mesh.smooth_angle {
            options += &format!(" --smooth-angle={degrees}");
        }
        if let Some(DVec3 { x, y, z }) = *self.lit_from() {
            options += &format!(" --lit-from={x},{y},{z}");
        }
        options
    }
}

/// Loads the scene, and lists its files.
type LoadScene = dyn Fn(&MeshArgs, &mut Vec<PathBuf>) -> Result<Input, CliError> + Send + Sync;

impl Host for Program {
    fn load(&self) -> (Result<Scene, String>, Vec<PathBuf>) {
        let mut files = Vec::new();
        let mesh = self.mesh().clone();
        let scene = (self.load)(&mesh, &mut files).map(|input| {
            *self.lit_from() = input.lit_from;
            input.scene
        });
        (scene.map_err(|error| error.text().unwrap_or_default()), files)
    }

    fn turn_up(&self, axis: &str, rotation: DMat3) -> bool {
        let Ok(up) = UpArg::from_str(axis, false) else {
            return false;
        };
        let mut mesh = self.mesh();
        let lit_from = mesh.lit_from.or(*self.lit_from());
        (mesh.up_axis, mesh.lit_from) = (Some(up), lit_from.map(|from| rotation * from));
        true
    }

    fn save(&self, film: &ByteFilm) -> Result<String, String> {
        let stem = self
            .path
            .file_stem()
            .unwrap_or("octray".as_ref())
            .to_string_lossy();
        let name = (1..=MOST_PICTURES)
            .map(|number| format!("{stem}-{number}.png"))
            .find(|name| !Path::new(name).exists())
            .ok_or_else(|| format!("there are {MOST_PICTURES} pictures of this name already"))?;
        let text = |error: CliError| error.text().unwrap_or_default();
        let bytes = Format::Png
            .encode(&Pixels::Bytes(film.clone()).into())
            .map_err(text)?;
        let write = || {
            whole_file::write(Path::new(&name), &Interrupt::default(), |out| {
                out.write_all(&bytes)
            })
        };
        (self.interrupt.hold_during(write)).map_err(|error| text(CliError::writing(&name, &error)))?;
        Ok(name)
    }

    fn say(&self, line: &str) {
        let scene = quoted(&self.path);
        // A closed pipe is no reason to close the window.
        let _ = super::print(&format!("octray render {scene} {line}{}\n", self.mesh_options()));
    }
}

impl From<ViewError> for CliError {
    fn from(error: ViewError) -> Self {
        match error {
            ViewError::NoDisplay(_) => Self::NoDisplay(error.to_string()),
            ViewError::Failed(why) => Self::Failed(why),
        }
    }
}

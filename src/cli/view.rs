//! `octray view`: the live window.

use super::{
    CliError,
    args::{CameraArgs, ViewArgs},
    encode::Format,
    picture::Picture,
    whole_file,
};
use crate::{
    course, format,
    render::ByteFilm,
    scene::Scene,
    viewer::{Display, Host, Options, ViewError, orbit::Pose},
};
use glam::DVec3;
use std::{
    io::Write,
    path::{Path, PathBuf},
    sync::Arc,
    time::Duration,
};

/// Pictures of one name that are saved at most.
const MOST_PICTURES: u32 = 99_999;

/// Opens the window, and returns when it is closed.
///
/// # Errors
/// [`CliError`].
pub fn run(args: &ViewArgs) -> Result<(), CliError> {
    let pose = pose(&args.camera);
    pose.camera()?;
    let settings = args.trace.settings(args.size, 1)?;
    let display = Display::connect()?;
    let mut files = Vec::new();
    let scene = format::load_and_list(&args.scene, &mut files)?;
    let host = Arc::new(Program {
        scene: args.scene.clone(),
    });
    let options = Options {
        name: args.scene.file_name().map_or_else(
            || args.scene.display().to_string(),
            |name| name.to_string_lossy().into_owned(),
        ),
        pose,
        settings,
        budget: Duration::from_millis(u64::from(args.budget)),
        benchmark: args.benchmark.map(Duration::from_secs_f64),
    };
    let Some(report) = display.show(options, scene, files, host)? else {
        return match args.benchmark {
            Some(_) => Err(CliError::Failed(
                "the window was closed before the benchmark's end".into(),
            )),
            None => Ok(()),
        };
    };
    // A plain struct of numbers always serializes.
    let json = serde_json::to_string(&report).unwrap_or_default() + "\n";
    match &args.json {
        Some(path) if path.as_os_str() != "-" => {
            whole_file::write(path, |out| out.write_all(json.as_bytes()))
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

fn pose(camera: &CameraArgs) -> Pose {
    Pose {
        eye: camera
            .eye
            .or_else(|| course::viewpoint(camera.view))
            .unwrap_or(DVec3::ZERO),
        target: camera.target.unwrap_or(course::TARGET),
        up: camera.up.unwrap_or(course::UP),
        fov_degrees: camera.fov,
    }
}

/// What the window asks of the program.
struct Program {
    scene: PathBuf,
}

impl Host for Program {
    fn load(&self) -> (Result<Scene, String>, Vec<PathBuf>) {
        let mut files = Vec::new();
        let scene = format::load_and_list(&self.scene, &mut files);
        (scene.map_err(|error| error.report()), files)
    }

    fn save(&self, film: &ByteFilm) -> Result<String, String> {
        let stem = self
            .scene
            .file_stem()
            .unwrap_or("octray".as_ref())
            .to_string_lossy();
        let name = (1..=MOST_PICTURES)
            .map(|number| format!("{stem}-{number}.png"))
            .find(|name| !Path::new(name).exists())
            .ok_or_else(|| format!("there are {MOST_PICTURES} pictures of this name already"))?;
        let text = |error: CliError| error.text().unwrap_or_default();
        let bytes = Format::Png.encode(&Picture::Bytes(film.clone())).map_err(text)?;
        whole_file::write(Path::new(&name), |out| out.write_all(&bytes))
            .map_err(|error| text(CliError::writing(&name, &error)))?;
        Ok(name)
    }

    fn say(&self, line: &str) {
        let scene = self.scene.display();
        // A closed pipe is no reason to close the window.
        let _ = super::print(&format!("octray render {scene} {line}\n"));
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

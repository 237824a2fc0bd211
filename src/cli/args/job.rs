//! Arguments of `octray job`: those of `octray render`, and what becomes of them.

use super::{definition, render::RenderArgs, values};
use crate::cli::{
    CliError,
    plan::{Engine, JobPlan, is_standard_stream},
};
use clap::{ArgAction, ArgMatches, Args, parser::ValueSource};
use std::path::{Path, PathBuf};

/// Options of `octray render` that tasks have of their own, or do not need.
const LEFT_OUT: [&str; 10] = [
    "output",
    "frames",
    "fps",
    "skip_existing",
    "save_poses",
    "quiet",
    "config",
    "no_config",
    "help",
    "version",
];

/// Options of `octray render` that a job refuses, and those that need them: a default for calls is not meant for jobs.
pub(super) const IGNORED_DEFAULTS: [&str; 8] = [
    "crop",
    "sheet",
    "compare",
    "tolerance",
    "allow_pixels",
    "difference",
    "stats",
    "json",
];

/// Help on arguments of `octray render` that have no streams and animations in a job.
pub(super) const HELP: [(&str, &str); 4] = [
    (
        "scenes",
        "Scenes (.scn) or meshes (.ply, .obj, .off, .stl, .gltf, .glb, .3mf, .vtk, .vtp, .vtu)",
    ),
    (
        "output",
        "The picture: .png, .ppm, .qoi, .jpg, .bmp, .tiff or .exr (linear floats). {stem} stands for the scene's name, \
         {folder} for its folder's, and a run of # for the frame's number. A symbolic link is followed: its target is \
         replaced [default: {stem}.png, or {stem}-####.png for --turntable, --poses and --sphere, in the current directory]",
    ),
    (
        "turntable",
        "Render N frames of a turn around the camera's target. In -o, a run of # stands for the number, from 1",
    ),
    (
        "poses",
        "Render the scene from every camera of a NeRF transforms.json or of a COLMAP reconstruction (its folder, images.txt \
         or images.bin). In -o, a run of # stands for the number, {pose} for the name in the file",
    ),
];

/// Arguments of `octray job`.
#[derive(Args, Debug)]
pub struct JobArgs {
    /// Engine that runs the tasks
    #[arg(long = "for", value_name = "ENGINE", value_enum, help_heading = "Job")]
    pub engine: Engine,

    /// Directory for the job's files and tiles; must be empty, created if missing
    #[arg(long, value_name = "FOLDER", help_heading = "Job")]
    pub into: PathBuf,

    /// Divide each picture into tiles, which are merged at the end [default: 4x4 for a single picture, none for several]
    #[arg(long, value_name = "COLUMNSxROWS", value_parser = values::grid, help_heading = "Job")]
    pub tiles: Option<[u32; 2]>,

    /// Frames or tiles per task
    #[arg(long, value_name = "N", value_parser = values::whole::<{ values::MOST_FRAMES }>, default_value = "1", help_heading = "Job")]
    pub chunk: u32,

    #[command(flatten)]
    pub render: RenderArgs,
}

impl JobArgs {
    /// Checks the arguments. `matches` are the same as clap found them.
    ///
    /// # Errors
    /// [`CliError`], as for `octray render`, and for options that do not go with a job.
    pub fn plan(&self, matches: &ArgMatches) -> Result<JobPlan, CliError> {
        let render = &self.render;
        let refused = [
            ("--crop", render.picture.crop.is_some()),
            ("--sheet", render.series.sheet.is_some()),
            ("--compare", render.comparison.compare.is_some()),
            ("--stats", render.stats),
            ("--json", render.json.is_some()),
        ];
        if let Some((option, _)) = refused.iter().find(|(_, is_given)| *is_given) {
            return Err(CliError::Usage(format!(
                "{option} cannot be used with octray job: it renders nothing itself, and each task renders a part"
            )));
        }
        let inputs = render.scenes.iter().chain(&render.output);
        if inputs.into_iter().any(|path| is_standard_stream(path)) {
            let why = "tasks have no standard input and output: name files instead of -";
            return Err(CliError::Usage(why.into()));
        }
        let output = render.output.as_deref().map(text).transpose()?;
        Ok(JobPlan {
            options: spelled(matches)?,
            output: output.map(str::to_owned),
            engine: self.engine,
            folder: self.into.clone(),
            tiles: self.tiles,
            chunk: self.chunk,
            quiet: render.quiet,
            render: render.plan()?,
        })
    }
}

/// The options of `octray render` that were given, in the long form and with their values.
fn spelled(matches: &ArgMatches) -> Result<Vec<String>, CliError> {
    let all = definition();
    let render = all.find_subcommand("render");
    let mut options = Vec::new();
    for option in render.into_iter().flat_map(clap::Command::get_arguments) {
        let id = option.get_id().as_str();
        let is_given = !LEFT_OUT.contains(&id) && matches.value_source(id) == Some(ValueSource::CommandLine);
        let Some(long) = option.get_long().filter(|_| is_given) else {
            continue;
        };
        if matches!(option.get_action(), ArgAction::SetTrue) {
            options.push(format!("--{long}"));
            continue;
        }
        for values in matches.get_raw_occurrences(id).into_iter().flatten() {
            let values: Vec<&str> = values
                .map(|value| text(Path::new(value)))
                .collect::<Result<_, _>>()?;
            options.push(format!("--{long}={}", values.join(",")));
        }
    }
    Ok(options)
}

fn text(path: &Path) -> Result<&str, CliError> {
    path.to_str()
        .ok_or_else(|| CliError::Usage("a name that is not UTF-8 cannot be written into a job".into()))
}

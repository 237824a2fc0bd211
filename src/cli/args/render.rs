//! Arguments of `octray render`.

use super::{
    camera::{CameraArgs, MeshArgs},
    config::ConfigArgs,
    limits::MemoryArgs,
    picture::{PictureArgs, SampleArgs, StyleArgs, usual_samples},
    series::{CompareArgs, FRAMES_OF_STANDARD_INPUT, SeriesArgs},
    trace::TraceArgs,
    values::{self, Size},
};
use crate::{
    cli::{
        CliError, load,
        plan::{
            ANIMATION, CameraOptions, ConfigDefault, FIT, FOCUS, FOR_MESHES, Job, JsonTarget, ListedPicture,
            Look, Looks, MeshOptions, PictureOptions, Pictures, Planned, Playing, PoseFile, RenderPlan,
            StartView, check_inputs, check_pattern, explained, has_number, is_standard_stream, name,
        },
        write::{AovKind, Output, SMALLEST_WITH_BAR, is_animation, is_foreign},
    },
    error::clip_path,
    render::Settings,
    whole_file::follow_links,
};
use clap::Args;
use std::path::{Path, PathBuf};

/// Arguments of `octray render`.
#[derive(Args, Debug)]
pub struct RenderArgs {
    /// Scenes (.scn) or meshes (.ply, .obj, .off, .stl, .gltf, .glb, .3mf, .vtk, .vtp, .vtu); - reads one from standard input
    #[arg(required = true, value_name = "SCENE")]
    pub scenes: Vec<PathBuf>,

    /// The picture: .png, .ppm, .qoi, .jpg, .bmp, .tiff or .exr (linear floats); - writes a PNG to standard output.
    /// {stem} stands for the scene's name, {folder} for its folder's, and a run of # for the frame's number. A symbolic link
    /// is followed: its target is replaced [default: {stem}.png, or {stem}-####.png for --turntable, --poses and --sphere, in
    /// the current directory]
    #[arg(short, long, value_name = "FILE", help_heading = "Picture")]
    pub output: Option<PathBuf>,

    /// Also replace files that octray did not write, if their names come from a default, the config file, {stem}, {folder} or #
    #[arg(long, help_heading = "Picture")]
    pub force: bool,

    /// Width and height, pixels; one number for a square [default: that of the pictures of --poses, or 512x512]
    #[arg(short, long, value_name = "WxH", value_parser = values::size, help_heading = "Picture")]
    pub size: Option<Size>,

    #[command(flatten)]
    pub picture: PictureArgs,

    #[command(flatten)]
    pub sampling: SampleArgs,

    #[command(flatten)]
    pub camera: CameraArgs,

    #[command(flatten)]
    pub mesh: MeshArgs,

    #[command(flatten)]
    pub style: StyleArgs,

    #[command(flatten)]
    pub trace: TraceArgs,

    #[command(flatten)]
    pub series: SeriesArgs,

    #[command(flatten)]
    pub comparison: CompareArgs,

    /// Print rays, times and memory to standard error
    #[arg(long, help_heading = "Messages")]
    pub stats: bool,

    /// Write rays, times and memory as JSON to a file, or to standard output (-): one line for each picture
    /// that is rendered, none for what is skipped
    #[arg(long, value_name = "FILE", help_heading = "Messages")]
    pub json: Option<PathBuf>,

    /// Print no progress bar, no closing line and no warnings
    #[arg(short, long, help_heading = "Messages")]
    pub quiet: bool,

    #[command(flatten)]
    pub memory: MemoryArgs,

    #[command(flatten)]
    pub config: ConfigArgs,

    /// The options that come from the config file
    #[arg(skip)]
    pub defaults: Vec<ConfigDefault>,
}

impl RenderArgs {
    /// Whether an option's value comes from the config file.
    fn is_default(&self, option: &str) -> bool {
        self.defaults.iter().any(|default| default.id == option)
    }

    /// How pictures are made: of scenes and plain meshes, or of meshes in a soft style.
    fn look(&self, size: Size, is_soft: bool) -> Result<Look, CliError> {
        let mut settings = self.trace.settings(size)?;
        self.picture.apply(&mut settings)?;
        self.sampling
            .apply(&mut settings, is_soft, usual_samples(is_soft))?;
        let is_exr = self.output.as_deref().and_then(Path::extension);
        let is_exr = is_exr.is_some_and(|extension| extension.eq_ignore_ascii_case("exr"));
        let mut picture = self.picture.options(is_soft, is_exr);
        self.check_color_bar(&settings, &mut picture)?;
        settings.edges = self.picture.edges.edges(picture.byte_transfer);
        settings.validate()?;
        Ok(Look { settings, picture })
    }

    /// Leaves out the bar of the config file if the picture has no room for it.
    ///
    /// # Errors
    /// [`CliError::Usage`] if the command line asks for it.
    fn check_color_bar(&self, settings: &Settings, picture: &mut PictureOptions) -> Result<(), CliError> {
        let [width, height] = SMALLEST_WITH_BAR;
        if settings.width >= width && settings.height >= height {
            return Ok(());
        }
        if picture.has_color_bar && !self.is_default("color_bar") {
            return Err(CliError::Usage(format!(
                "--color-bar needs a picture of at least {width}x{height} pixels, found {}x{}",
                settings.width, settings.height
            )));
        }
        picture.has_color_bar = false;
        Ok(())
    }

    /// How pictures of that size are made.
    ///
    /// # Errors
    /// [`CliError`].
    pub fn looks(&self, size: Size) -> Result<Looks, CliError> {
        Ok(Looks {
            scene: self.look(size, false)?,
            mesh: self.look(size, self.style.style().is_soft())?,
        })
    }

    /// Options that come from the config file and do not apply to every scene.
    fn mesh_defaults(&self) -> Vec<&'static str> {
        let id = |name: &str| name.trim_start_matches('-').replace('-', "_");
        let is_default = |name: &&str| self.is_default(&id(name));
        let mut defaults: Vec<_> = FOR_MESHES.into_iter().filter(is_default).collect();
        if self.is_default("ortho") {
            defaults.push(FIT);
        }
        if self.is_default("focus") {
            defaults.push(FOCUS);
        }
        let is_given = [self.mesh.animation.is_some(), self.mesh.animation_time.is_some()];
        let is_typed = |&(name, is_given): &(&str, bool)| is_given && !self.is_default(&id(name));
        let pose = ANIMATION.into_iter().zip(is_given);
        defaults.extend(pose.filter(|option| !is_typed(option)).map(|(name, _)| name));
        defaults
    }

    fn camera_options(&self) -> CameraOptions {
        let mut camera = self.camera.options();
        if self.is_default("ortho") && !matches!(camera.start, StartView::Default | StartView::Side(_)) {
            camera.fits_ortho = false;
        }
        camera.defaults = self.mesh_defaults();
        camera
    }

    fn mesh_options(&self) -> MeshOptions {
        let mut mesh = MeshOptions {
            style: self.style.style(),
            is_style_given: self.style.style.is_some(),
            defaults: self.mesh_defaults(),
            ..self.mesh.options(self.series.orbit())
        };
        if self.is_default("environment") && !mesh.style.is_soft() {
            mesh.environment = None;
        }
        mesh
    }

    /// How meshes are played if frames are asked for; not if the command line has the time of one pose.
    fn playing(&self) -> Option<Playing<'_>> {
        let is_pose = self.mesh.animation_time.is_some() && !self.is_default("animation_time");
        (!is_pose).then_some(Playing {
            animation: self.mesh.animation.as_deref(),
            is_default: self.is_default("animation"),
            fps: self.series.fps(),
            memory: self.memory.limit(),
        })
    }

    /// The size of the pictures.
    pub fn size(&self, poses: Option<&PoseFile>) -> Size {
        let of_poses = || poses?.size().map(|[width, height]| Size { width, height });
        self.size.or_else(of_poses).unwrap_or(Size::DEFAULT)
    }

    /// Where the cameras of all pictures go. Refuses the files of the jobs' pictures.
    fn save_poses(&self, jobs: &[Job], json: Option<&JsonTarget>) -> Result<Option<PathBuf>, CliError> {
        let Some(path) = &self.series.save_poses else {
            return Ok(None);
        };
        let listed = || jobs.iter().flat_map(|job| &job.listed);
        let why = if self.scenes.len() > 1 {
            "--save-poses needs one scene".to_owned()
        } else if is_standard_stream(path) {
            "--save-poses needs a file".to_owned()
        } else if let Some(picture) =
            listed().find(|picture| is_animation(&picture.path) || is_standard_stream(&picture.path))
        {
            format!(
                "--save-poses needs a file for each picture: write to files such as a-##.png instead of {}",
                clip_path(name(&picture.path))
            )
        } else if let Some(JsonTarget::File(json)) = json
            && follow_links(json).ok() == follow_links(path).ok()
        {
            format!(
                "both the poses and the JSON would be written to {}",
                clip_path(path)
            )
        } else {
            let target = JsonTarget::new(path)?;
            let place = follow_links(path).ok();
            let is_picture = jobs
                .iter()
                .flat_map(Job::outputs)
                .any(|output| target.is_file_of(output))
                || listed()
                    .flat_map(ListedPicture::files)
                    .any(|file| place.is_some() && follow_links(file).ok() == place);
            if !is_picture {
                return Ok(Some(path.clone()));
            }
            format!(
                "both a picture and the poses would be written to {}",
                clip_path(path)
            )
        };
        Err(CliError::Usage(why))
    }

    /// Refuses a placeholder of another program in the name of the output, {pose} without poses, and a # if there are no
    /// frames.
    fn check_placeholders(&self, has_frames: bool) -> Result<(), CliError> {
        if let Some(output) = self.output.as_deref() {
            check_pattern(output, self.series.poses.is_some()).map_err(CliError::Usage)?;
        }
        let is_typed = !self.is_default("output") && self.series.sheet.is_none();
        match self.output.as_deref().filter(|output| has_number(output)) {
            Some(output) if is_typed && !has_frames && !self.series.keep_going => {
                let why = if self.scenes.iter().any(|scene| is_standard_stream(scene)) {
                    format!("# stands for the number of a frame, and {FRAMES_OF_STANDARD_INPUT}")
                } else {
                    "# stands for the number of a frame, and there are no frames; leave it out, or ask for frames with \
                     --turntable, --sphere, --poses, a scene with keyframes (`at`) or a glTF animation"
                        .to_owned()
                };
                Err(CliError::Usage(format!("{}: {why}", clip_path(output))))
            }
            _ => Ok(()),
        }
    }

    /// Refuses a step of depth without a file of it; in the config file it is a default.
    fn check_z_step(&self) -> Result<(), CliError> {
        let is_typed = self.picture.z_step.is_some() && !self.is_default("z_step");
        if is_typed && !self.picture.aovs.contains(&AovKind::Z) {
            return Err(CliError::Usage("--z-step needs --aov z".into()));
        }
        Ok(())
    }

    /// Checks the arguments, and names and checks every picture.
    ///
    /// # Errors
    /// [`CliError`].
    pub fn plan(&self) -> Result<RenderPlan, CliError> {
        let pose_file = self.series.poses.as_deref().map(PoseFile::read).transpose()?;
        let size = self.size(pose_file.as_ref());
        let looks = self.looks(size)?;
        let poses = pose_file
            .as_ref()
            .map(|file| file.poses([size.width, size.height], self.size.is_some()));
        let poses = poses.transpose()?;
        let turntable = self.series.turntable(poses.as_ref());
        self.check_z_step()?;
        let keyframes = match turntable {
            Some(_) => Vec::new(),
            None => self.series.keyframes(
                &self.scenes,
                self.output.as_deref(),
                &|option| !self.is_default(option),
                self.playing(),
            )?,
        };
        self.check_placeholders(turntable.is_some() || !keyframes.is_empty())?;
        let pictures = Pictures {
            look: &looks.mesh,
            output: self.output.as_deref(),
            is_typed: !self.is_default("output"),
            turntable,
            keyframes,
            poses: poses.as_ref(),
            skip_existing: self.series.skip_existing,
            saves_poses: self.series.save_poses.is_some(),
            sheet: self.series.sheet,
            keep_going: self.series.keep_going,
            force: self.force,
            comparison: self.comparison.options(!self.is_default("difference")),
        };
        let (camera, mesh) = (self.camera_options(), self.mesh_options());
        let memory = self.memory.limit();
        let Planned { jobs, sheet, skipped } = pictures.jobs(&self.scenes, &camera, &mesh, memory)?;
        let explain = |(path, error)| (path, explained(error, &self.defaults));
        let mut inputs = check_inputs(&jobs, self.config.path().as_deref())?;
        for file in pose_file.iter().flat_map(PoseFile::files) {
            inputs.add(&file, "the poses");
        }
        load::memory::check_threads(self.trace.threads.count())?;
        let json = self.json_target(&jobs)?;
        let mut notes = poses.as_ref().map_or(Vec::new(), |poses| poses.notes.clone());
        notes.extend(self.fps_note(&jobs));
        Ok(RenderPlan {
            notes,
            looks,
            build: self.trace.build,
            fps: self.series.fps(),
            save_poses: self.save_poses(&jobs, json.as_ref())?,
            defaults: self.defaults.clone(),
            poses,
            orbit: self.series.orbit(),
            jobs,
            sheet,
            keep_going: self.series.keep_going,
            skipped: skipped.into_iter().map(explain).collect(),
            memory,
            inputs,
            stats: self.stats,
            json,
            quiet: self.quiet,
        })
    }

    /// The warning about `--fps` that nothing heeds.
    fn fps_note(&self, jobs: &[Job]) -> Option<String> {
        let is_typed = self.series.fps.is_some() && !self.is_default("fps") && !jobs.is_empty();
        let heeds = |job: &Job| job.input.mesh.playback.is_some() || job.outputs().any(Output::is_animation);
        (is_typed && !jobs.iter().any(heeds))
            .then(|| "no animation is written or played, so --fps has no effect".to_owned())
    }

    /// Where the JSON goes. Refuses the files of the jobs' pictures.
    fn json_target(&self, jobs: &[Job]) -> Result<Option<JsonTarget>, CliError> {
        let Some(json) = self.json.as_deref().map(JsonTarget::new).transpose()? else {
            return Ok(None);
        };
        if let JsonTarget::File(path) = &json
            && self.is_default("json")
            && !self.force
            && is_foreign(path)
        {
            return Err(CliError::Failed(format!(
                "{} of the config file exists and was not written by octray; name another file with --json or replace it \
                 with --force",
                clip_path(path)
            )));
        }
        if json == JsonTarget::Stdout && self.output.as_deref().is_some_and(is_standard_stream) {
            return Err(CliError::Usage(JsonTarget::BESIDE_PICTURE.into()));
        }
        let mut outputs = jobs.iter().flat_map(Job::outputs);
        if let Some(output) = outputs.find(|output| json.is_file_of(output)) {
            let why = format!(
                "both the picture and the JSON would be written to {}",
                output.name()
            );
            return Err(CliError::Usage(why));
        }
        Ok(Some(json))
    }
}

//! What `octray render` does: for each scene one picture, or a series of frames.

use super::{
    Build, CameraOptions, ConfigDefault, InputPlan, JsonTarget, Keyframes, ListedPicture, Look, Looks,
    MeshOptions, Orbit, Poses, Turn, Turntable, misplaced,
    names::{self, Origin, PicturePath},
    places::Places,
};
use crate::{
    cli::{
        CliError,
        load::memory::{self, PixelBytes},
        write::{AovFiles, Comparison, Inputs, Output, sheet_size},
    },
    error::clip_path,
    render::Transfer,
};
use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

/// What `octray render` does.
#[derive(Debug)]
pub struct RenderPlan {
    pub looks: Looks,
    pub build: Build,
    /// How the camera goes around its target from frame to frame, if it does.
    pub orbit: Option<Orbit>,
    /// Frames per second of an animation.
    pub fps: u32,
    /// The cameras of the frames, if they come from a file.
    pub poses: Option<Poses>,
    /// Where the cameras of all pictures go.
    pub save_poses: Option<PathBuf>,
    /// The options that come from the config file.
    pub defaults: Vec<ConfigDefault>,
    pub jobs: Vec<Job>,
    /// The picture that all others go into.
    pub sheet: Option<SheetPlan>,
    /// Go on with the next scene if one cannot be loaded.
    pub keep_going: bool,
    /// Warnings about the command line and its poses.
    pub notes: Vec<String>,
    /// Scenes that were skipped so far, and why.
    pub skipped: Vec<(PathBuf, CliError)>,
    /// Memory that the call may take, bytes.
    pub memory: u64,
    /// Files that are read, as far as the command line names them.
    pub inputs: Inputs,
    /// Print the figures of each picture as text.
    pub stats: bool,
    /// Where the figures of all pictures go as JSON.
    pub json: Option<JsonTarget>,
    pub quiet: bool,
}

/// The pictures of one scene.
#[derive(Debug)]
pub struct Job {
    pub input: InputPlan,
    /// Those to render. None if all pictures exist and only their cameras are wanted.
    pub frames: Vec<Frame>,
    /// The pictures of the file of poses; none without one.
    pub listed: Vec<ListedPicture>,
    /// Number of frames of the whole series; `frames` may be a part of it. 1 for a single picture.
    pub whole: u32,
    /// Memory that the scene may take beside a picture, bytes.
    pub scene_memory: u64,
}

impl Job {
    /// Everything that will be written.
    pub fn outputs(&self) -> impl Iterator<Item = &Output> {
        self.frames.iter().flat_map(|frame| {
            let difference = frame.comparison.as_ref().map(|comparison| &comparison.output);
            [&*frame.output]
                .into_iter()
                .chain(frame.aovs.files())
                .chain(difference)
        })
    }
}

/// A contact sheet.
#[derive(Debug)]
pub struct SheetPlan {
    pub output: Arc<Output>,
    pub columns: u32,
    /// How many pictures it shows.
    pub count: u32,
}

/// The reason if a job would replace one of the inputs.
pub fn objection(jobs: &[Job], inputs: &Inputs) -> Option<String> {
    jobs.iter()
        .flat_map(Job::outputs)
        .find_map(|output| inputs.objection(output.name(), output.replaced()?))
}

/// The files that the command line names. No picture may replace them.
///
/// # Errors
/// [`CliError::Usage`] if a picture would replace one, [`CliError::Failed`] if it would replace a file that octray
/// did not write.
pub fn check_inputs(jobs: &[Job], config: Option<&Path>) -> Result<Inputs, CliError> {
    let mut inputs = Inputs::default();
    for job in jobs {
        inputs.add(&job.input.path, "the scene");
        for comparison in job.frames.iter().filter_map(|frame| frame.comparison.as_ref()) {
            inputs.add(comparison.reference(), "the reference");
        }
    }
    if let Some(config) = config {
        inputs.add(config, "the config file");
    }
    if let Some(objection) = objection(jobs, &inputs) {
        return Err(CliError::Usage(objection));
    }
    for output in jobs.iter().flat_map(Job::outputs) {
        output.check_foreign()?;
    }
    Ok(inputs)
}

/// One picture.
#[derive(Debug)]
pub struct Frame {
    /// All frames of an animation share it.
    pub output: Arc<Output>,
    pub aovs: AovFiles,
    pub turn: Option<Turn>,
    pub comparison: Option<Comparison>,
}

impl Frame {
    /// Whether the picture and its AOVs exist.
    pub fn exists(&self) -> bool {
        self.output.exists() && self.aovs.files().iter().all(Output::exists)
    }
}

/// The most pictures of a call: all of their places are checked before the first is rendered.
pub(super) const MOST_PICTURES: u64 = 100_000;

/// The pictures of a call before they have names.
#[derive(Debug)]
pub struct Pictures<'a> {
    /// That of meshes.
    pub look: &'a Look,
    /// The pattern of `--output`.
    pub output: Option<&'a Path>,
    /// Whether it is on the command line, and not in a config file.
    pub is_typed: bool,
    /// That of poses counts them.
    pub turntable: Option<Turntable>,
    /// Without a turntable: the frames of each scene, if one of them moves.
    pub keyframes: Vec<Keyframes>,
    pub poses: Option<&'a Poses>,
    pub skip_existing: bool,
    /// Whether a file lists the cameras of all pictures.
    pub saves_poses: bool,
    /// Columns of a sheet for all pictures.
    pub sheet: Option<u32>,
    pub keep_going: bool,
    /// Replace files that octray did not write.
    pub force: bool,
    pub comparison: Option<CompareOptions<'a>>,
}

/// The checked pictures of a call.
#[derive(Debug)]
pub struct Planned {
    pub jobs: Vec<Job>,
    pub sheet: Option<SheetPlan>,
    /// Scenes that cannot be rendered, and why.
    pub skipped: Vec<(PathBuf, CliError)>,
}

/// What pictures are compared with.
#[derive(Debug)]
pub struct CompareOptions<'a> {
    /// The pattern of `--compare`.
    pub reference: &'a Path,
    /// The pattern of `--difference`.
    pub difference: Option<&'a Path>,
    /// Whether it is on the command line, and not in a config file.
    pub is_typed: bool,
    /// Levels of 255.
    pub tolerance: f32,
    /// Share of all pixels that may differ.
    pub allow_pixels: f64,
}

impl Pictures<'_> {
    /// Names and checks every picture, then every scene. Leaves out pictures that `--skip-existing` skips, and scenes without
    /// any other pictures unless their cameras are listed.
    ///
    /// # Errors
    /// [`CliError`]: a place that cannot be written, two pictures for one place, a scene that cannot be read, a picture
    /// that needs more than `memory` bytes.
    pub fn jobs(
        &self,
        scenes: &[PathBuf],
        camera: &CameraOptions,
        mesh: &MeshOptions,
        memory: u64,
    ) -> Result<Planned, CliError> {
        let of_one = |i| self.series(i).map_or(1, Turntable::frames_to_render);
        let pictures = (0..scenes.len()).map(of_one).sum::<u64>();
        if pictures > MOST_PICTURES {
            return Err(CliError::Usage(format!(
                "{pictures} pictures in one call, expected at most {MOST_PICTURES}: render them in several calls"
            )));
        }
        // References are looked into before the formats are known.
        let least = PixelBytes {
            film: 3,
            compared: self.comparison.is_some(),
            ..PixelBytes::default()
        };
        memory::beside_picture(memory, self.size(), least)?;
        let mut places = Places::new(self.poses);
        if !self.keep_going {
            let is_named = self.output.is_some() && self.is_typed;
            misplaced::check(scenes, is_named)?;
        }
        let sheet = self.sheet_output(scenes)?;
        let mut named = Vec::new();
        for (i, scene) in scenes.iter().enumerate() {
            let series = self.series(i);
            let mesh = self.playing(i, mesh);
            let frames = match &sheet {
                Some(output) => self.frames_of_sheet(output, scene, series)?,
                None => self.frames(scene, series, &mut places)?,
            };
            let listed = self.listed(scene, series)?;
            if !(frames.is_empty() && listed.is_empty()) {
                named.push((scene, mesh, series, frames, listed));
            }
        }
        let aspect = f64::from(self.look.settings.width) / f64::from(self.look.settings.height);
        let (mut jobs, mut skipped) = (Vec::new(), Vec::new());
        for (scene, mesh, series, frames, listed) in named {
            let mesh = mesh.without_stray_animation(scene, memory);
            match InputPlan::new(scene, camera.clone(), mesh, aspect) {
                Ok(input) => jobs.push(Job {
                    input,
                    whole: series.map_or(1, |series| series.count),
                    scene_memory: 0,
                    frames,
                    listed,
                }),
                Err(error) if self.keep_going => skipped.push((scene.clone(), error)),
                Err(error) => return Err(error),
            }
        }
        let count = jobs.iter().map(|job| job.frames.len()).sum::<usize>() as u32;
        let sheet = sheet.zip(self.sheet).map(|(output, columns)| SheetPlan {
            output,
            columns,
            count,
        });
        let memory = match &sheet {
            Some(sheet) => self.beside_sheet(memory, sheet)?,
            None => memory,
        };
        for job in &mut jobs {
            job.scene_memory = memory::beside_picture(memory, self.size(), self.pixel_bytes(&job.frames))?;
        }
        Ok(Planned { jobs, sheet, skipped })
    }

    /// The frames of a scene to render.
    pub(super) fn turns(
        &self,
        scene: &Path,
        series: Option<Turntable>,
    ) -> Result<Vec<Option<Turn>>, CliError> {
        let of = match self.keyframes.len() {
            0 | 1 => String::new(),
            _ => format!(" of {}", clip_path(scene)),
        };
        Ok(match series {
            None => vec![None],
            Some(series) => series.turns(&of)?.map(Some).collect(),
        })
    }

    /// The frames of a scene, by its index.
    fn series(&self, scene: usize) -> Option<Turntable> {
        let own = self.keyframes.get(scene).map(|keyframes| keyframes.frames);
        self.turntable.or(own)
    }

    /// The options of a scene's mesh, by its index, with its animation if it is played.
    fn playing(&self, scene: usize, mesh: &MeshOptions) -> MeshOptions {
        let mut mesh = mesh.clone();
        let own = self.keyframes.get(scene);
        if let Some(playback) = own.and_then(|keyframes| keyframes.playback.as_ref()) {
            mesh.moment = Some(playback.moment(1));
            mesh.playback = Some(playback.clone());
        }
        mesh
    }

    /// The checked place of a sheet; `None` without one.
    fn sheet_output(&self, scenes: &[PathBuf]) -> Result<Option<Arc<Output>>, CliError> {
        if self.sheet.is_none() {
            return Ok(None);
        }
        let pattern = self.output.unwrap_or(Path::new("sheet.png"));
        let scene = scenes.first().map_or(Path::new("octray"), PathBuf::as_path);
        let origin = if self.output.is_some() {
            Origin::Typed
        } else {
            Origin::Derived
        };
        let path = PicturePath {
            path: pattern.to_owned(),
            origin,
        };
        let output = Output::prepare(&path.typed_if(self.is_typed), self.size(), self.force)?
            .synced_if(self.skip_existing);
        let pose = self.pose(Some(Turn { number: 1, count: 1 }));
        let why = if names::expand(pattern, scene, Some(1), pose) != pattern {
            "a sheet is one picture; leave out {stem}, {folder}, {pose} and #"
        } else if output.is_animation() {
            "a sheet is one picture, not an animation; name a picture such as sheet.png"
        } else if output.is_exr() {
            "a sheet has 8 bits per channel; name a picture such as sheet.png"
        } else if self.look.picture.backdrop.is_transparent() {
            "a sheet has no transparent background"
        } else if !self.look.picture.aovs.is_empty() {
            "a sheet has no AOVs"
        } else if self.comparison.is_some() {
            "sheets are not compared"
        } else {
            output.check(&self.look.picture)?;
            return Ok(Some(Arc::new(output)));
        };
        Err(CliError::Usage(format!("{}: {why}", output.name())))
    }

    /// The pictures of a scene on a sheet.
    fn frames_of_sheet(
        &self,
        output: &Arc<Output>,
        scene: &Path,
        series: Option<Turntable>,
    ) -> Result<Vec<Frame>, CliError> {
        if self.skip_existing && output.exists() {
            return Ok(Vec::new());
        }
        let turns = self.turns(scene, series)?;
        let frame = |turn| Frame {
            output: Arc::clone(output),
            aovs: AovFiles::none(),
            turn,
            comparison: None,
        };
        Ok(turns.into_iter().map(frame).collect())
    }

    /// The part of `memory` that a sheet and its encoded copy leave.
    fn beside_sheet(&self, memory: u64, sheet: &SheetPlan) -> Result<u64, CliError> {
        let (width, height) = self.size();
        let size = sheet_size([width, height], sheet.columns, sheet.count);
        let [width, height] = size.ok_or_else(|| CliError::Failed("the sheet is too large".into()))?;
        sheet.output.format().check_size(width, height)?;
        let pixel = PixelBytes {
            film: 3,
            ..PixelBytes::default()
        };
        memory::beside_picture(memory, (width, height), pixel)
    }

    fn frames(
        &self,
        scene: &Path,
        series: Option<Turntable>,
        places: &mut Places<'_>,
    ) -> Result<Vec<Frame>, CliError> {
        let turns = self.turns(scene, series)?;
        let mut frames: Vec<Frame> = Vec::new();
        for turn in turns {
            let animation = frames.first().filter(|frame| frame.output.is_animation());
            let frame = match animation {
                Some(first) => Frame {
                    output: Arc::clone(&first.output),
                    aovs: AovFiles::none(),
                    turn,
                    comparison: None,
                },
                None => self.frame(scene, turn, places)?,
            };
            if !(self.skip_existing && frame.exists()) {
                frames.push(frame);
            } else if frame.output.is_animation() {
                break;
            }
        }
        Ok(frames)
    }

    fn frame(&self, scene: &Path, turn: Option<Turn>, places: &mut Places<'_>) -> Result<Frame, CliError> {
        let path = names::picture(self.output, scene, turn, self.pose(turn));
        // A picture that exists is rendered again if its AOVs are missing: it must be octray's own.
        let may_be_skipped = self.skip_existing && !self.look.picture.aovs.is_empty();
        let path = path.typed_if(self.is_typed && !may_be_skipped);
        let output = Output::prepare(&path, self.size(), self.force)?
            .synced_if(self.skip_existing)
            .for_turntable(turn.is_some())?;
        output.check(&self.look.picture)?;
        if output.is_animation() {
            self.check_animation(&output, scene)?;
        }
        let own_turn = turn.filter(|_| !output.is_animation());
        places.claim(&output, scene, own_turn, self.output)?;
        let aovs = AovFiles::prepare(&self.look.picture, &output, &path, self.size(), self.force)?;
        for file in aovs.files() {
            places.claim(file, scene, turn, self.output)?;
        }
        let comparison = match &self.comparison {
            Some(options) => Some(self.comparison(options, &path, &output, scene, turn, places)?),
            None => None,
        };
        Ok(Frame {
            output: Arc::new(output),
            aovs,
            turn,
            comparison,
        })
    }

    /// The name of a frame's pose.
    pub(super) fn pose(&self, turn: Option<Turn>) -> Option<&str> {
        let pose = self.poses?.poses.get(turn?.number as usize - 1)?;
        Some(&pose.name)
    }

    /// Rejects options that animations do not support.
    fn check_animation(&self, output: &Output, scene: &Path) -> Result<(), CliError> {
        let name = output.name();
        let expanded =
            |number, pose| names::expand(self.output.unwrap_or(Path::new("")), scene, Some(number), pose);
        let why = if expanded(1, None) != expanded(2, None) {
            "an animation holds all frames; leave out the #, or name pictures such as a-##.png"
        } else if self.poses.is_some() && expanded(1, Some("a")) != expanded(1, Some("b")) {
            "an animation holds all poses; leave out {pose}, or name pictures such as {pose}.png"
        } else if !self.look.picture.aovs.is_empty() {
            "an animation has no AOVs; name pictures such as a-##.png"
        } else if self.comparison.is_some() {
            "animations are not compared; name pictures such as a-##.png"
        } else {
            return Ok(());
        };
        Err(CliError::Usage(format!("{name}: {why}")))
    }

    fn comparison(
        &self,
        options: &CompareOptions<'_>,
        path: &PicturePath,
        output: &Output,
        scene: &Path,
        turn: Option<Turn>,
        places: &mut Places<'_>,
    ) -> Result<Comparison, CliError> {
        let beside = output.is_file().then_some(path);
        let difference = names::difference(options.difference, beside, scene, turn, self.pose(turn))
            .typed_if(options.is_typed);
        let difference = Output::prepare(&difference, self.size(), self.force)?;
        places.claim(&difference, scene, turn, options.difference.or(self.output))?;
        let reference = names::picture(Some(options.reference), scene, turn, self.pose(turn)).path;
        Comparison::prepare(options, reference, difference, self.size())
    }

    /// Width and height of the pictures.
    fn size(&self) -> (u32, u32) {
        let window = self.look.settings.window();
        (window.width(), window.height())
    }

    /// The memory of a pixel of the largest picture.
    fn pixel_bytes(&self, frames: &[Frame]) -> PixelBytes {
        let exr = frames.iter().any(|frame| frame.output.is_exr());
        let floats = exr || self.look.picture.transfer != Transfer::Linear;
        PixelBytes {
            film: self.look.picture.backdrop.film_bytes(floats),
            exr,
            aovs: !self.look.picture.aovs.is_empty(),
            compared: self.comparison.is_some(),
        }
    }
}

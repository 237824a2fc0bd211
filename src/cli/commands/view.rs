//! `octray view`: the live window.

use super::stages;
use crate::{
    cli::{
        CliError,
        args::spelled,
        load::{self, Input},
        plan::{
            ColorBy, ColorMap, InputKind, InputPlan, Look, MeshOptions, NOT_PLAYED_FROM_STANDARD_INPUT,
            Playing, Style, ViewPlan, is_standard_stream, playback_of, stem,
        },
        process::Interrupt,
        report::{self, quoted, quoted_path},
        write::{Format, Inputs, Pixels, json_line, write_json},
    },
    error::clip,
    format::{Limits, mesh::UpAxis},
    render::{ByteFilm, Settings, Transfer},
    scene::Scene,
    viewer::{
        Closed, Content, Display, Host, Loaded, MAX_SIDE, Options, Start, ViewError,
        benchmark::Report,
        loading::Loading,
        pose::Pose,
        sources::{Sources, States},
        timeline::Frames,
    },
    whole_file,
};
use glam::{DMat3, DVec3};
use std::{
    io::Write,
    path::Path,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

/// The most pictures of one name.
const MOST_PICTURES: u32 = 99_999;

/// Opens the window, and returns when it is closed.
///
/// # Errors
/// [`CliError`].
pub fn run(plan: ViewPlan) -> Result<(), CliError> {
    let Settings { width, height, .. } = plan.looks.scene.settings;
    if width.max(height) > MAX_SIDE {
        let why = format!("a window of {width}x{height} is too large: a side has at most {MAX_SIDE} pixels");
        return Err(CliError::Failed(why));
    }
    let display = Display::connect()?;
    let interrupt = Interrupt::of_window(display.closer())?;
    let path = &plan.input.path;
    let name = path.file_name().unwrap_or(path.as_os_str());
    let start = Start {
        name: clip(&name.to_string_lossy()),
        size: [width, height],
    };
    let (benchmark, json) = (plan.benchmark, plan.json.clone());
    let failure = Arc::new(Mutex::new(None));
    let refused = Arc::clone(&failure);
    let Closed { figures, unsaved } = display.show(start, move |loading| {
        let loaded = load(plan, loading);
        let why = |error| *refused.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
        loaded.map_err(why).ok()
    })?;
    let refused = failure.lock().unwrap_or_else(PoisonError::into_inner).take();
    if let Some(error) = refused {
        return Err(error);
    }
    if unsaved > 0 {
        let what = if unsaved == 1 {
            "picture is"
        } else {
            "pictures are"
        };
        report::warnings([format!("{unsaved} {what} not saved: the window was closed first")]);
    }
    match (figures, json) {
        (Some(figures), Some(target)) => write_json(&target, &json_line(&figures))?,
        (Some(figures), None) => report::print(&text(&figures))?,
        (None, _) if benchmark.is_some() => {
            report::warnings(["the window was closed before the benchmark was done".into()]);
        }
        (None, _) => {}
    }
    interrupt.check()
}

/// Loads within `memory` bytes, reports its progress, and lists the files.
fn load_and_list(input: &InputPlan, memory: u64, loading: &Loading) -> (Result<Input, CliError>, Sources) {
    let stage = Arc::new(loading.stage(stages::reading(input), stages::bytes_of(input)));
    let parsed = Arc::clone(&stage);
    let (mut files, states) = (Vec::new(), States::default());
    let noted = states.clone();
    let limits = Limits {
        memory,
        on_read: Some(Arc::new(move |bytes| stage.add(bytes as u64))),
        on_parsed: Some(Arc::new(move |done, total| {
            // Afterwards the window keeps the last share.
            if total > 0 {
                parsed.show(done as u64, total as u64);
            }
        })),
        on_open: Some(Arc::new(move |path| noted.note(path))),
    };
    if let Some((path, _)) = &input.mesh.environment {
        states.note(path);
    }
    let loaded = load::load_and_list(input, limits, &mut files);
    (loaded, Sources { files, states })
}

/// Loads what the window shows.
fn load(plan: ViewPlan, loading: &Loading) -> Result<Content, CliError> {
    let ViewPlan {
        input,
        looks,
        has_config,
        build,
        budget,
        fps,
        benchmark,
        json,
        memory,
    } = plan;
    let (loaded, sources) = load_and_list(&input, memory, loading);
    let loaded = loaded?;
    let (is_mesh, lit_from) = (loaded.is_mesh(), loaded.is_lit_from());
    let Input {
        scene, camera, notes, ..
    } = loaded;
    let mut inputs = Inputs::default();
    inputs.add(&input.path, "the scene");
    inputs.add_scene(&input.path, &sources.files, Some(&scene));
    inputs.check_json(json.as_ref())?;
    let Look { settings, picture } = looks.of(is_mesh);
    report::warnings(notes.iter().cloned());
    let options = Options {
        is_mesh,
        pose: camera.view().into(),
        settings: *settings,
        transfer: picture.transfer,
        // A window traces an unlimited number of rays.
        quality: build.quality(f64::INFINITY, scene.primitive_count()),
        budget,
        fps,
        benchmark,
    };
    let program = Program {
        style: is_mesh.then_some(input.mesh.style),
        mesh: Mutex::new(input.mesh.clone()),
        input,
        memory,
        fps,
        lit_from: Mutex::new(lit_from),
        told: Mutex::new(notes),
        has_config,
    };
    Ok(Content {
        options,
        scene,
        sources,
        host: Arc::new(program),
    })
}

/// The results of a benchmark as a line of text.
fn text(figures: &Report) -> String {
    format!(
        "{:.1} frames per second; frame time {:.1} ms (median), {:.1} ms (99th percentile); {:.0} % of the frames at full \
         quality; {:.1} million rays/s\n",
        figures.fps,
        figures.frame_ms_p50,
        figures.frame_ms_p99,
        figures.full_quality_share * 100.0,
        figures.mrays_per_s
    )
}

/// The [`Host`] of the window.
struct Program {
    input: InputPlan,
    /// The style of a mesh.
    style: Option<Style>,
    /// The input's options, with later rotations by keys.
    mesh: Mutex<MeshOptions>,
    memory: u64,
    /// Frames per second of an animation.
    fps: u32,
    /// The direction from which the current mesh is lit, unless it has its own lights.
    lit_from: Mutex<Option<DVec3>>,
    /// The warnings of the last load.
    told: Mutex<Vec<String>>,
    /// Whether `octray render` would read a config file.
    has_config: bool,
}

impl Program {
    fn lit_from(&self) -> MutexGuard<'_, Option<DVec3>> {
        self.lit_from.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn mesh(&self) -> MutexGuard<'_, MeshOptions> {
        self.mesh.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Plays the animation of the mesh's file as it is now. Returns false if it has none.
    ///
    /// # Errors
    /// Why it cannot be played.
    fn play(&self) -> Result<bool, String> {
        let moment = self.mesh().moment.clone();
        let animation = moment.and_then(|moment| moment.animation);
        let playing = Playing {
            animation: animation.as_deref(),
            is_default: false,
            fps: self.fps,
            memory: self.memory,
        };
        let playback = playback_of(&self.input.path, playing, None);
        let playback = playback.map_err(|error| error.text().unwrap_or_default())?;
        let (mut mesh, plays) = (self.mesh(), playback.is_some());
        if plays || mesh.playback.is_some() {
            mesh.moment = playback.as_ref().map(|playback| playback.moment(1));
            mesh.playback = playback;
        }
        Ok(plays)
    }

    /// Prints the warnings of a load that the one before did not have.
    fn warn(&self, notes: Vec<String>) {
        let mut told = self.told.lock().unwrap_or_else(PoisonError::into_inner);
        let is_new = |note: &&String| !told.contains(note);
        report::warnings(notes.iter().filter(is_new).cloned());
        *told = notes;
    }

    /// The options of a mesh for `octray render`, at this frame if it is played.
    fn mesh_options(&self, frame: u32) -> String {
        let mesh = self.mesh();
        let mut options = String::new();
        if let Some(axis) = mesh.up_axis {
            options += &format!(" --up-axis={axis}");
        }
        if mesh.ground {
            options += " --ground";
        }
        if let Some(degrees) = mesh.smooth_degrees {
            options += &format!(" --smooth-angle={degrees}");
        }
        if let Some(diameter) = mesh.point_size {
            options += &format!(" --point-size={diameter}");
        }
        options += &color_options(&mesh.color_by);
        if let Some((path, degrees)) = &mesh.environment {
            options += &format!(" --environment={}", quoted(path.as_os_str()));
            if *degrees != 0.0 {
                options += &format!(" --environment-rotate={degrees}");
            }
        }
        if let Some(moment) = &mesh.moment {
            if let Some(animation) = &moment.animation {
                options += &format!(" --animation={}", quoted(animation.as_ref()));
            }
            options += &if mesh.playback.is_some() {
                format!(" --fps={} --frames={frame}", self.fps)
            } else {
                format!(" --animation-time={}", moment.seconds)
            };
        }
        if let Some(DVec3 { x, y, z }) = *self.lit_from() {
            options += &format!(" --lit-from={x},{y},{z}");
        }
        options
    }
}

/// The options that show these numbers as colours.
fn color_options(by: &ColorBy) -> String {
    let Some(name) = by.values.name() else {
        return String::new();
    };
    let mut options = format!(" --color-by={}", quoted(name.as_ref()));
    if by.map != ColorMap::default() {
        options += &format!(" --color-map={}", by.map.name());
    }
    if let Some([low, high]) = by.range {
        options += &format!(" --color-range={low},{high}");
    }
    options
}

const NOT_AGAIN: &str = "standard input cannot be read again";

impl Host for Program {
    fn load(&self, loading: &Loading) -> (Result<Loaded, String>, Sources) {
        if is_standard_stream(&self.input.path) {
            return (Err(NOT_AGAIN.into()), Sources::default());
        }
        if self.mesh().playback.is_some()
            && let Err(why) = self.play()
        {
            return (Err(why), Sources::default());
        }
        let input = InputPlan {
            mesh: self.mesh().clone(),
            ..self.input.clone()
        };
        let (loaded, sources) = load_and_list(&input, self.memory, loading);
        let loaded = loaded.map(|mut loaded| {
            *self.lit_from() = loaded.is_lit_from();
            self.warn(std::mem::take(&mut loaded.notes));
            let playback = input.mesh.playback.clone().zip(loaded.poses);
            let memory = self.memory;
            Loaded {
                scene: loaded.scene,
                pose: loaded.camera.view().into(),
                frames: playback.map(|(playback, poses)| Frames {
                    count: playback.count(),
                    load: Box::new(move |frame| {
                        let loaded = load::load_frame(&input, memory, &poses, frame);
                        loaded
                            .map(|loaded| loaded.scene)
                            .map_err(|error| error.text().unwrap_or_default())
                    }),
                }),
            }
        });
        (loaded.map_err(|error| error.text().unwrap_or_default()), sources)
    }

    fn animate(&self) -> Result<bool, String> {
        if self.style.is_some() && is_standard_stream(&self.input.path) {
            return Err(NOT_PLAYED_FROM_STANDARD_INPUT.into());
        }
        if self.style.is_none() || self.input.kind != InputKind::Mesh {
            return Ok(false);
        }
        self.play()
    }

    fn turn_up(&self, up: UpAxis, rotation: DMat3) -> Result<(), String> {
        if is_standard_stream(&self.input.path) {
            return Err(NOT_AGAIN.into());
        }
        let mut mesh = self.mesh();
        mesh.turned = rotation * mesh.turned;
        mesh.up_axis = Some(up);
        mesh.lit_from = mesh.lit_from.map(|from| rotation * from);
        Ok(())
    }

    fn save(&self, film: &ByteFilm) -> Result<String, String> {
        let stem = stem(&self.input.path).to_string_lossy();
        let name = (1..=MOST_PICTURES)
            .map(|number| format!("{stem}-{number}.png"))
            .find(|name| !Path::new(name).exists())
            .ok_or_else(|| format!("{MOST_PICTURES} pictures of this name exist already"))?;
        let text = |error: CliError| error.text().unwrap_or_default();
        let bytes = Format::Png
            .encode(&mut Pixels::Bytes(film.clone()).into())
            .map_err(text)?;
        whole_file::write(Path::new(&name), |out| out.write_all(&bytes))
            .map_err(|error| text(CliError::writing(&name, &error)))?;
        Ok(name)
    }

    fn camera(&self, scene: &Scene, frame: u32) -> Option<Pose> {
        if !scene.moves() {
            return None;
        }
        let time = frame.into();
        let own = scene.cameras_at(time).ok()?;
        let camera = self.input.camera.at_time(scene, &own, time).ok()?;
        Some(camera.view().into())
    }

    fn say(&self, view: &str, frame: u32, settings: &Settings, transfer: Transfer) {
        let scene = match &self.input.path {
            path if is_standard_stream(path) => "-".into(),
            path => quoted_path(path),
        };
        let Settings { width, height, .. } = settings;
        let mut options = self.mesh_options(frame) + &spelled(settings, transfer, self.style);
        // That is where a scene stands anyway.
        if frame > 1 && self.style.is_none() {
            options += &format!(" --frames={frame}");
        }
        if self.has_config {
            options += " --no-config";
        }
        let line = format!("octray render {scene} --size={width}x{height} {view}{options}\n");
        // A closed pipe does not close the window.
        let _ = report::print(&line);
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

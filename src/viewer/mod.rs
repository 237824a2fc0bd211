//! The live window: an orbit camera around a scene that is traced for every frame.
//!
//! - [`orbit`], [`pose`], [`axis`], [`objects`], [`budget`], [`progressive`] and [`benchmark`] are plain types without a window.
//! - [`worker`] traces on another thread. It gets requests through the [`mailbox`], and pictures from `painter`: those of the
//!   renderer, of camera rays only (`primary`), or denoised ones (`denoise`).
//! - `shell` is the window itself, first with the progress of [`loading`]; `window` and `input` handle events and show finished
//!   pictures.
//! - [`timeline`] is the scene at one of its frames, and [`playback`] chooses the frame.
//! - [`watch`] reloads changed [`sources`].

pub mod axis;
pub mod benchmark;
pub mod boxes;
pub mod budget;
mod denoise;
#[cfg(target_os = "linux")]
mod display;
mod first_hits;
mod input;
pub mod keys;
pub mod loading;
pub mod mailbox;
pub mod objects;
pub mod orbit;
mod overlay;
mod painter;
pub mod playback;
pub mod pose;
mod primary;
mod probe;
pub mod progressive;
pub mod request;
pub mod screen;
mod shell;
pub mod sources;
mod status;
mod surface;
pub mod timeline;
pub mod watch;
mod window;
pub mod worker;

use crate::{
    accel::BuildQuality,
    format::mesh::UpAxis,
    render::{ByteFilm, Settings, Transfer},
    scene::Scene,
};
use benchmark::Report;
use glam::DMat3;
use loading::Loading;
use pose::Pose;
use shell::{Event, Shell};
use sources::Sources;
use std::{fmt, sync::Arc, thread, time::Duration};
use timeline::Frames;
use winit::event_loop::{ControlFlow, EventLoop};

/// Runs `work` on another thread.
///
/// # Errors
/// Why the system refuses the thread.
fn on_thread(work: impl FnOnce() + Send + 'static) -> Result<(), String> {
    let started = thread::Builder::new().spawn(work);
    started
        .map(drop)
        .map_err(|error| format!("cannot start a thread: {error}"))
}

/// The largest side of a window, pixels: window systems use signed 16-bit numbers.
pub const MAX_SIDE: u32 = 32_767;

/// The services that the program provides to its window.
pub trait Host: Send + Sync {
    /// Loads the scene, with progress. Returns it or an error, and all files that belong to it, to be watched.
    fn load(&self, loading: &Loading) -> (Result<Loaded, String>, Sources);

    /// Plays the animation of a mesh from the next load on. Returns false if it has none.
    ///
    /// # Errors
    /// Why it cannot be played.
    fn animate(&self) -> Result<bool, String>;

    /// Writes a picture to a new file and returns its name.
    ///
    /// # Errors
    /// Why the picture cannot be written.
    fn save(&self, film: &ByteFilm) -> Result<String, String>;

    /// Returns the starting camera at a frame, if the scene moves.
    fn camera(&self, scene: &Scene, frame: u32) -> Option<Pose>;

    /// Prints the command that renders a picture: of this camera and layer, given as options of `octray render`, at this
    /// frame, with these settings and this transfer.
    fn say(&self, view: &str, frame: u32, settings: &Settings, transfer: Transfer);

    /// Makes another axis of a mesh point up from the next load on, and turns its light by `rotation`.
    ///
    /// # Errors
    /// Why it cannot be loaded again.
    fn turn_up(&self, up: UpAxis, rotation: DMat3) -> Result<(), String>;
}

/// The window before anything is loaded.
#[derive(Clone, Debug)]
pub struct Start {
    /// The name in the title.
    pub name: String,
    /// Pixels across and down.
    pub size: [u32; 2],
}

/// A scene that is loaded again.
#[derive(Debug)]
pub struct Loaded {
    /// The scene, or the first frame of a mesh that is played.
    pub scene: Scene,
    /// The frames of that mesh.
    pub frames: Option<Frames>,
    /// The starting camera.
    pub pose: Pose,
}

/// What the window shows.
pub struct Content {
    /// How it is shown.
    pub options: Options,
    /// The scene.
    pub scene: Scene,
    /// All files that belong to it, to be watched.
    pub sources: Sources,
    /// The program.
    pub host: Arc<dyn Host>,
}

/// How a scene is shown.
#[derive(Clone, Debug)]
pub struct Options {
    /// Whether a mesh is shown, which has six sides and can be turned, and not a scene.
    pub is_mesh: bool,
    /// The starting camera.
    pub pose: Pose,
    /// How to trace the last picture at rest. The size is ignored: the window has its own.
    pub settings: Settings,
    /// How linear channels become bytes.
    pub transfer: Transfer,
    /// How BVHs are built.
    pub quality: BuildQuality,
    /// Time for a frame while the camera moves.
    pub budget: Duration,
    /// Frames per second of an animated scene.
    pub fps: u32,
    /// Orbit for this time, then close.
    pub benchmark: Option<Duration>,
}

/// What is left of a closed window.
#[derive(Clone, Copy, Debug, Default)]
pub struct Closed {
    /// The results of a benchmark that showed frames.
    pub figures: Option<Report>,
    /// How many pictures were to be saved and are not.
    pub unsaved: usize,
}

/// Why there is no window.
#[derive(Debug)]
pub enum ViewError {
    /// There is no display.
    NoDisplay(String),
    /// Something else.
    Failed(String),
}

impl fmt::Display for ViewError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoDisplay(why) => write!(f, "no display to open a window on: {why}"),
            Self::Failed(why) => write!(f, "{why}"),
        }
    }
}

impl std::error::Error for ViewError {}

/// A variable of the environment and its value, unless that is empty.
fn named(name: &str) -> Option<String> {
    let value = std::env::var_os(name).filter(|value| !value.is_empty())?;
    Some(format!("{name}={}", crate::error::clip(&value.to_string_lossy())))
}

/// A connection to the display, made before anything is loaded.
#[derive(Debug)]
pub struct Display {
    event_loop: EventLoop<Event>,
}

impl Display {
    /// Connects.
    ///
    /// # Errors
    /// [`ViewError::NoDisplay`].
    pub fn connect() -> Result<Self, ViewError> {
        let mut builder = EventLoop::with_user_event();
        #[cfg(target_os = "linux")]
        match display::choice() {
            display::Choice::Usual => {}
            display::Choice::X11 => {
                winit::platform::x11::EventLoopBuilderExtX11::with_x11(&mut builder);
            }
            display::Choice::Silent => {
                let named = named("WAYLAND_DISPLAY").unwrap_or_default();
                return Err(ViewError::NoDisplay(format!("{named} does not answer")));
            }
        }
        builder
            .build()
            .map(|event_loop| Self { event_loop })
            .map_err(|_| {
                // The error itself only names a place in winit.
                let names = ["WAYLAND_DISPLAY", "DISPLAY"].into_iter().filter_map(named);
                let named: Vec<String> = names.collect();
                ViewError::NoDisplay(match &named[..] {
                    [] if cfg!(target_os = "linux") => "neither WAYLAND_DISPLAY nor DISPLAY is set".into(),
                    named => format!("cannot connect to {}", named.join(" and ")),
                })
            })
    }

    /// Returns a function that closes the window, from any thread.
    pub fn closer(&self) -> impl Fn() + Send + 'static + use<> {
        let proxy = self.event_loop.create_proxy();
        move || {
            // Fails once the window is closed.
            let _ = proxy.send_event(Event::Close);
        }
    }

    /// Loads on another thread and shows its progress, then the scene. Returns when the window is closed. Nothing is shown if
    /// `load` returns `None`.
    ///
    /// # Errors
    /// [`ViewError`].
    pub fn show(
        self,
        start: Start,
        load: impl FnOnce(&Loading) -> Option<Content> + Send + 'static,
    ) -> Result<Closed, ViewError> {
        let failed = |error: &dyn fmt::Display| ViewError::Failed(error.to_string());
        let Some(mut shell) = Shell::new(start, self.event_loop.create_proxy(), load) else {
            return Ok(Closed::default());
        };
        self.event_loop.set_control_flow(ControlFlow::Wait);
        self.event_loop
            .run_app(&mut shell)
            .map_err(|error| failed(&error))?;
        shell.finish()
    }
}

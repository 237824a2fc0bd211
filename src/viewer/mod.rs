//! The live window: an orbit camera around a scene that is traced anew for every frame.
//!
//! [`orbit`], [`budget`], [`progressive`] and [`benchmark`] are plain types that need no window. [`worker`] traces on a
//! thread of its own and gets its wishes through the [`mailbox`], [`window`](self) takes input and shows what is ready, [`watch`] reloads.

pub mod benchmark;
pub mod boxes;
pub mod budget;
pub mod keys;
pub mod look;
pub mod mailbox;
pub mod orbit;
mod overlay;
mod primary;
mod probe;
pub mod progressive;
pub mod screen;
mod status;
mod surface;
pub mod watch;
mod window;
pub mod worker;

use crate::{
    accel::{BuildQuality, Bvh},
    render::{ByteFilm, Settings},
    scene::Scene,
};
use benchmark::Report;
use look::Model;
use orbit::Pose;
use std::{fmt, path::PathBuf, sync::Arc, time::Duration};
use window::{App, Event};
use winit::event_loop::{ControlFlow, EventLoop};

/// The most pixels of a window's side: what window systems count in 16 bits, signed.
pub const MAX_SIDE: u32 = 32_767;

/// What the window leaves to the program that opens it.
pub trait Host: Send + Sync {
    /// Loads the scene: it, or what is wrong with it; and all files that were asked for, to be watched.
    fn load(&self) -> (Result<Scene, String>, Vec<PathBuf>);

    /// Writes a picture to a new file and returns its name.
    ///
    /// # Errors
    /// Why it cannot be written.
    fn save(&self, film: &ByteFilm) -> Result<String, String>;

    /// Prints a line.
    fn say(&self, line: &str);
}

/// How to begin.
#[derive(Clone, Debug)]
pub struct Options {
    /// What the window is called.
    pub name: String,
    /// The camera.
    pub pose: Pose,
    /// The window's size, and how to trace.
    pub settings: Settings,
    /// What BVHs are built.
    pub quality: BuildQuality,
    /// Time for a frame while the camera moves.
    pub budget: Duration,
    /// Orbit by itself for so long, and end.
    pub benchmark: Option<Duration>,
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
            Self::NoDisplay(why) => write!(f, "there is no display to open a window on: {why}"),
            Self::Failed(why) => write!(f, "{why}"),
        }
    }
}

impl std::error::Error for ViewError {}

/// A connection to the display; asked for before anything is loaded.
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
        EventLoop::with_user_event()
            .build()
            .map(|event_loop| Self { event_loop })
            .map_err(|_| {
                // The error itself tells where in winit it arose.
                let named = |name: &str| {
                    let value = std::env::var_os(name).filter(|value| !value.is_empty())?;
                    Some(format!("{name}={}", value.to_string_lossy()))
                };
                let names = ["WAYLAND_DISPLAY", "DISPLAY"].into_iter().filter_map(named);
                let named: Vec<String> = names.collect();
                ViewError::NoDisplay(match &named[..] {
                    [] if cfg!(target_os = "linux") => "neither WAYLAND_DISPLAY nor DISPLAY is set".into(),
                    named => format!("the window system does not answer {}", named.join(" ")),
                })
            })
    }

    /// Opens the window and returns when it is closed; the figures, if a benchmark was asked for and frames were shown in
    /// it.
    ///
    /// # Errors
    /// [`ViewError`].
    pub fn show(
        self,
        options: Options,
        scene: Scene,
        files: Vec<PathBuf>,
        host: Arc<dyn Host>,
    ) -> Result<Option<Report>, ViewError> {
        let failed = |error: &dyn fmt::Display| ViewError::Failed(error.to_string());
        let quality = options.quality;
        let bvh = Bvh::build_with(&scene, quality);
        let model = Arc::new(Model { scene, bvh });
        let proxy = self.event_loop.create_proxy();
        if options.benchmark.is_none() {
            let proxy = proxy.clone();
            watch::start(Arc::clone(&host), files, quality, move |reloaded| {
                // The window is closed: nobody needs to know.
                let _ = proxy.send_event(Event::Reloaded(reloaded));
            });
        }
        self.event_loop.set_control_flow(ControlFlow::Wait);
        let mut app = App::new(options, model, host, proxy).map_err(|error| failed(&error))?;
        self.event_loop
            .run_app(&mut app)
            .map_err(|error| failed(&error))?;
        app.finish()
    }
}

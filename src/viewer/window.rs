//! The window of a loaded scene: shows pictures when they are ready, and waits in between.

use super::{
    Closed, Host, Options, ViewError, axis,
    benchmark::Benchmark,
    keys::Held,
    loading::{Loading, Ready},
    mailbox::{Picture, Shared},
    orbit::Orbit,
    overlay::{self, Overlay},
    playback::{Awaited, Playback},
    pose::Pose,
    probe,
    request::{Boxes, Look, Request, Style},
    shell::{Event, Screen},
    status::Status,
    timeline::Timeline,
    watch::{self, Reload, Reloaded},
    worker::{self, Note},
};
use crate::{format::mesh::UpAxis, ray::SceneHit};
use glam::DMat3;
use std::{
    sync::{Arc, Mutex, PoisonError},
    time::{Duration, Instant},
};
use winit::{
    dpi::{PhysicalPosition, PhysicalSize},
    event::{ElementState, MouseButton, StartCause, WindowEvent},
    event_loop::{ActiveEventLoop, ControlFlow, EventLoopProxy},
};

/// How long a message is shown.
const MESSAGE: Duration = Duration::from_secs(3);
/// How long progress of loading is shown if no more follows.
const LOADING: Duration = Duration::from_hours(1);
/// Time between two steps of flight.
pub(super) const STEP: Duration = Duration::from_millis(15);
/// The speed of the benchmark's orbit, 45 degrees per second, in pixels of a drag.
const BENCHMARK_PIXELS_PER_SECOND: f64 = 45.0 / super::orbit::DEGREES_PER_PIXEL;

/// What to frame.
#[derive(Clone, Copy, Debug)]
pub enum Framing {
    /// The object of this primitive; without one, everything except the ground.
    Under(Option<SceneHit>),
    /// The mesh without its ground, from one of its six sides.
    Side(usize),
}

/// Where the mouse is, and its buttons.
#[derive(Debug, Default)]
pub(super) struct Mouse {
    /// `None` until it is known.
    at: Option<PhysicalPosition<f64>>,
    is_inside: bool,
    pub(super) left: bool,
    pub(super) right: bool,
}

impl Mouse {
    /// Notes what an event says. Returns how far the mouse has moved, pixels to the right and down.
    pub(super) fn note(&mut self, event: &WindowEvent) -> [f64; 2] {
        match event {
            &WindowEvent::CursorMoved { position: to, .. } => {
                let from = self.at.replace(to).unwrap_or(to);
                self.is_inside = true;
                return [to.x - from.x, to.y - from.y];
            }
            WindowEvent::CursorLeft { .. } => self.is_inside = false,
            WindowEvent::MouseInput { state, button, .. } => {
                let pressed = *state == ElementState::Pressed;
                match button {
                    MouseButton::Left => self.left = pressed,
                    MouseButton::Right => self.right = pressed,
                    _ => {}
                }
            }
            // Releases in other windows are not reported.
            WindowEvent::Focused(false) => (self.left, self.right) = (false, false),
            _ => {}
        }
        [0.0; 2]
    }

    /// The pixel under it in a window of this size.
    fn pixel(&self, size: [u32; 2]) -> Option<[u32; 2]> {
        let at = self.at.filter(|_| self.is_inside)?;
        let inside = |p: f64, pixels: u32| (p >= 0.0 && p < f64::from(pixels)).then_some(p as u32);
        Some([inside(at.x, size[0])?, inside(at.y, size[1])?])
    }
}

/// Which texts are shown over the picture.
#[derive(Debug, Default)]
pub(super) struct Panels {
    pub(super) help: bool,
    pub(super) figures: bool,
    pub(super) probe: bool,
}

/// The state of the window.
pub struct App {
    /// In the title.
    name: String,
    pub(super) options: Options,
    pub(super) host: Arc<dyn Host>,
    pub(super) proxy: EventLoopProxy<Event>,
    pub(super) shared: Arc<Shared>,
    screen: Screen,
    pub(super) failure: Option<String>,

    pub(super) reload: Option<Reload>,
    pub(super) timeline: Arc<Timeline>,
    pub(super) playback: Playback,
    /// What the animation does once it is loaded.
    pub(super) awaited: Option<Awaited>,
    pub(super) orbit: Orbit,
    /// The starting camera; that of the frame if the scene's camera moves.
    pub(super) home: Pose,
    /// Which axis of a mesh points up: at the start and now.
    pub(super) up: [UpAxis; 2],
    /// Turns the camera when the mesh, turned by key, is loaded.
    pub(super) turn: DMat3,
    pub(super) style: Style,
    pub(super) size: [u32; 2],

    pub(super) picture: Picture,
    pub(super) status: Status,
    pub(super) benchmark: Option<Benchmark>,

    pub(super) mouse: Mouse,
    pub(super) held: Held,
    pub(super) flown_at: Option<Instant>,

    pub(super) panels: Panels,
    pub(super) progress: Option<f32>,
    pub(super) error: Option<String>,
    /// Why the scene cannot move to the frame.
    pub(super) stuck: Option<String>,
    pub(super) message: Option<(String, Instant)>,
    /// Whether a picture will be saved once the scene is at the frame.
    pub(super) saves: bool,
    /// How many pictures are being saved. Held while a file is written, so that the end waits for it.
    pub(super) writing: Arc<Mutex<usize>>,
}

impl App {
    /// Shows a scene in a window, and begins to trace it.
    ///
    /// # Errors
    /// In words: the options are not a valid view, or the system refuses a thread.
    pub(super) fn new(
        name: String,
        ready: Ready,
        screen: Screen,
        mouse: Mouse,
        proxy: EventLoopProxy<Event>,
    ) -> Result<Self, String> {
        let Ready {
            options,
            timeline,
            sources,
            host,
        } = ready;
        let orbit = Orbit::new(options.pose, timeline.now().scene.bounds());
        let orbit = orbit.map_err(|error| error.to_string())?;
        let reload = options.benchmark.is_none().then(|| {
            let (proxy, progress) = (proxy.clone(), Loading::again(proxy.clone()));
            let host = Arc::clone(&host);
            watch::start(host, sources, options.quality, progress, move |reloaded| {
                // Fails once the window is closed.
                let _ = proxy.send_event(Event::Reloaded(reloaded));
            })
        });
        let reload = reload.transpose()?;
        let up = axis::nearest(options.pose.up);
        let settings = options.settings;
        let mut app = Self {
            name,
            host,
            proxy,
            shared: Arc::default(),
            size: screen.size(),
            screen,
            failure: None,
            reload,
            playback: Playback::new(timeline.count(), options.fps),
            timeline,
            awaited: None,
            orbit,
            home: options.pose,
            up: [up; 2],
            turn: DMat3::IDENTITY,
            style: Style {
                look: Look::Full,
                brute: false,
                antialias: true,
                boxes: Boxes::Hidden,
                settings,
                transfer: options.transfer,
            },
            picture: Picture::default(),
            status: Status::default(),
            benchmark: None,
            mouse,
            held: Held::default(),
            flown_at: None,
            panels: Panels::default(),
            progress: None,
            error: None,
            stuck: None,
            saves: false,
            message: None,
            writing: Arc::default(),
            options,
        };
        app.begin()?;
        Ok(app)
    }

    /// Ends the worker after the window is closed.
    ///
    /// # Errors
    /// [`ViewError`] if the window could not be opened or was lost.
    pub fn finish(self) -> Result<Closed, ViewError> {
        self.shared.end();
        // Waits for a file that is being written, not for a picture that is still traced for one.
        let unsaved = *self.writing.lock().unwrap_or_else(PoisonError::into_inner);
        match self.failure {
            Some(why) => Err(ViewError::Failed(why)),
            None => Ok(Closed {
                figures: self.benchmark.and_then(|benchmark| benchmark.report()),
                unsaved: unsaved + usize::from(self.saves),
            }),
        }
    }

    fn begin(&mut self) -> Result<(), String> {
        let (shared, proxy, budget) = (Arc::clone(&self.shared), self.proxy.clone(), self.options.budget);
        super::on_thread(move || {
            worker::run(&shared, budget, &|note| {
                // Fails once the window is closed.
                let _ = proxy.send_event(Event::Worker(note));
            });
        })?;
        self.benchmark = self
            .options
            .benchmark
            .map(|length| Benchmark::new(length, Instant::now()));
        if self.benchmark.is_none() {
            self.say("press ? for the keys");
        }
        self.ask();
        Ok(())
    }

    pub(super) fn request(&self) -> Request {
        Request {
            timeline: Arc::clone(&self.timeline),
            frame: self.playback.frame(),
            pose: self.orbit.pose(),
            camera: self.orbit.camera(),
            style: self.style,
            size: self.size,
        }
    }

    /// The pixel under the mouse.
    pub(super) fn mouse_pixel(&self) -> Option<[u32; 2]> {
        self.mouse.pixel(self.size)
    }

    /// A description of what is under the mouse, if it is switched on.
    fn probed(&self) -> Option<Vec<String>> {
        let pixel = self.mouse_pixel().filter(|_| self.panels.probe)?;
        let camera = self.orbit.camera();
        Some(probe::describe(&self.timeline.now(), &camera, self.size, pixel))
    }

    /// Sends the worker a new request. A window without pixels shows nothing.
    pub(super) fn ask(&mut self) {
        self.progress = None;
        if !self.size.contains(&0) {
            self.shared.post(self.request());
        }
    }

    pub(super) fn redraw(&self) {
        self.screen.redraw();
    }

    pub(super) fn say(&mut self, message: impl Into<String>) {
        self.message = Some((message.into(), Instant::now() + MESSAGE));
        self.redraw();
    }

    fn resized(&mut self, size: PhysicalSize<u32>) {
        self.size = [size.width, size.height];
        self.ask();
    }

    /// Puts the newest picture and the overlay on the screen.
    fn draw(&mut self) -> Result<(), String> {
        let now = Instant::now();
        let is_new = self.shared.take(&mut self.picture);
        let probed = self.probed();
        if self.message.as_ref().is_some_and(|(_, until)| now >= *until) {
            self.message = None;
        }
        self.screen.draw(|canvas, scale_factor| {
            overlay::copy(&self.picture, canvas);
            if is_new {
                self.status.shown(&self.picture, now);
            }
            let figures = || [vec![self.status.line(&self.picture)], self.status.modes()].concat();
            overlay::draw(
                canvas,
                scale_factor,
                &Overlay {
                    help: self.panels.help,
                    figures: self.panels.figures.then(figures),
                    probed: probed.as_deref(),
                    progress: self.progress,
                    error: self.error.as_deref().or(self.stuck.as_deref()),
                    message: self.message.as_ref().map(|(text, _)| text.as_str()),
                },
            );
        })?;
        if is_new {
            if let Some(title) = self.status.title(&self.name, &self.picture, now) {
                self.screen.set_title(&title);
            }
            if let Some(benchmark) = &mut self.benchmark {
                benchmark.shown(&self.picture, Instant::now());
            }
        }
        Ok(())
    }

    /// Moves on along the orbit of the benchmark.
    fn orbit_on(&mut self, event_loop: &ActiveEventLoop) {
        let Some(benchmark) = &self.benchmark else { return };
        let now = Instant::now();
        if benchmark.is_over(now) {
            event_loop.exit();
            return;
        }
        let seconds = self.flown_at.map_or(0.0, |at| (now - at).as_secs_f64());
        self.flown_at = Some(now);
        self.orbit
            .turn(BENCHMARK_PIXELS_PER_SECOND * seconds.max(1e-6), 0.0);
        self.ask();
    }

    fn reloaded(&mut self, reloaded: Reloaded) {
        match reloaded {
            Ok((timeline, home)) => {
                self.orbit.set_bounds(timeline.now().scene.bounds());
                let what = match self.awaited.filter(|_| timeline.is_played()) {
                    Some(Awaited::Play) => "playing",
                    Some(Awaited::Step(_)) => "animation loaded",
                    None => "file reloaded",
                };
                self.take_timeline(timeline);
                self.error = None;
                self.say(what);
                self.turn_camera();
                self.go_home(home);
                self.show_frame();
            }
            Err(error) => {
                self.awaited = None;
                (self.error, self.message) = (Some(error), None);
                self.redraw();
            }
        }
    }
}

/// Handles events.
impl App {
    pub(super) fn new_events(&mut self, cause: StartCause) {
        if matches!(cause, StartCause::ResumeTimeReached { .. }) {
            self.play_on(Instant::now());
            if self.held.flies() {
                self.fly();
            }
            if self.message.is_some() {
                self.redraw();
            }
        }
    }

    pub(super) fn user_event(&mut self, event_loop: &ActiveEventLoop, event: Event) {
        match event {
            Event::Worker(Note::Picture) => {
                self.progress = None;
                self.orbit_on(event_loop);
                self.save_if_due();
            }
            Event::Worker(Note::Progress(share)) => self.progress = Some(share),
            Event::Worker(Note::Failed(frame, why)) => self.go_back(frame, &why),
            Event::Reloaded(reloaded) => self.reloaded(reloaded),
            Event::Objects(timeline, framing, pose) => {
                if Arc::ptr_eq(&timeline, &self.timeline) && pose == self.orbit.pose() {
                    self.frame(framing);
                }
            }
            Event::Saved(Ok(name)) => self.say(format!("saved {name}")),
            Event::Saved(Err(why)) => self.say(why),
            Event::Reloading(progress) => self.message = Some((progress, Instant::now() + LOADING)),
            Event::Loading(_) | Event::Loaded | Event::Close => {}
        }
        self.redraw();
    }

    pub(super) fn window_event(&mut self, event_loop: &ActiveEventLoop, event: WindowEvent) {
        let moved = self.mouse.note(&event);
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::Resized(size) => self.resized(size),
            // Synthetic events are of keys that are held when the focus comes or goes: they were pressed for another
            // window, or were reported before.
            WindowEvent::KeyboardInput {
                event,
                is_synthetic: false,
                ..
            } => self.key(&event, event_loop),
            WindowEvent::CursorMoved { .. } => self.mouse_moved(moved),
            WindowEvent::CursorLeft { .. } => self.redraw(),
            WindowEvent::MouseWheel { delta, .. } => self.wheel(delta),
            // Releases in other windows are not reported.
            WindowEvent::Focused(false) => self.held.clear(),
            WindowEvent::RedrawRequested => {
                if let Err(why) = self.draw() {
                    self.failure = Some(why);
                    event_loop.exit();
                }
            }
            _ => {}
        }
    }

    pub(super) fn about_to_wait(&self, event_loop: &ActiveEventLoop) {
        let step = self.flown_at.filter(|_| self.held.flies()).map(|at| at + STEP);
        let message = self.message.as_ref().map(|(_, until)| *until);
        let next = [step, message, self.playback.next()].into_iter().flatten().min();
        event_loop.set_control_flow(next.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
    }
}

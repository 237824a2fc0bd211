//! The window: takes input at once, shows pictures when they are ready, and waits in between.

use super::{
    Host, Options, ViewError,
    benchmark::{Benchmark, Report},
    keys::{self, Action},
    look::{Boxes, Look, Model, Style, Wanted},
    mailbox::{Picture, Shared},
    orbit::{Orbit, Pose, unit_of},
    overlay::{Overlay, copy, overlay},
    probe,
    progressive::GRIDS,
    screen::Canvas,
    status::Status,
    watch::Reloaded,
    worker::{self, Note},
};
use crate::{
    heat,
    render::{ByteFilm, Mode, Renderer},
    scene::CameraError,
};
use std::{
    num::NonZeroU32,
    ops::ControlFlow as Flow,
    rc::Rc,
    sync::{Arc, Mutex, PoisonError},
    thread,
    time::{Duration, Instant},
};
use winit::{
    application::ApplicationHandler,
    dpi::{PhysicalPosition, PhysicalSize},
    event::{ElementState, KeyEvent, MouseButton, MouseScrollDelta, StartCause, WindowEvent},
    event_loop::{ActiveEventLoop, ControlFlow, EventLoopProxy},
    window::{Window, WindowId},
};

type Surface = softbuffer::Surface<Rc<Window>, Rc<Window>>;

/// How long a message is shown.
const MESSAGE: Duration = Duration::from_secs(3);
/// Time between two steps of flight.
const STEP: Duration = Duration::from_millis(15);
/// A pixel of a right drag, or of a touchpad's scrolling, changes the distance by this factor; a notch of the wheel by
/// the other.
const FACTOR_OF_PIXEL: f64 = 1.01;
const FACTOR_OF_NOTCH: f64 = 1.1;
/// Degrees a second of the benchmark's orbit, as pixels of a drag.
const BENCHMARK_PIXELS_PER_SECOND: f64 = 45.0 / super::orbit::DEGREES_PER_PIXEL;

/// What other threads tell the window.
#[derive(Debug)]
pub enum Event {
    /// The worker.
    Worker(Note),
    /// The files.
    Reloaded(Reloaded),
    /// A picture was saved, or not.
    Saved(Result<String, String>),
}

struct Screen {
    window: Rc<Window>,
    surface: Surface,
}

/// Everything behind the window.
pub struct App {
    options: Options,
    host: Arc<dyn Host>,
    proxy: EventLoopProxy<Event>,
    shared: Arc<Shared>,
    screen: Option<Screen>,
    failure: Option<String>,

    model: Arc<Model>,
    orbit: Orbit,
    style: Style,
    size: [u32; 2],

    picture: Picture,
    status: Status,
    benchmark: Option<Benchmark>,

    mouse: PhysicalPosition<f64>,
    left: bool,
    right: bool,
    flying: [bool; keys::DIRECTIONS.len()],
    flown_at: Option<Instant>,

    help: bool,
    figures: bool,
    probe: bool,
    progress: Option<f32>,
    error: Option<String>,
    message: Option<(String, Instant)>,
    /// Held while a file is written, so that the end waits for it.
    writing: Arc<Mutex<()>>,
}

impl App {
    /// # Errors
    /// [`CameraError`], if the options make no view.
    pub fn new(
        options: Options,
        model: Arc<Model>,
        host: Arc<dyn Host>,
        proxy: EventLoopProxy<Event>,
    ) -> Result<Self, CameraError> {
        let orbit = Orbit::new(options.pose, unit_of(model.scene.bounds()))?;
        let settings = options.settings;
        Ok(Self {
            host,
            proxy,
            shared: Arc::default(),
            screen: None,
            failure: None,
            model,
            orbit,
            style: Style {
                look: Look::Full,
                brute: false,
                antialias: true,
                boxes: Boxes::Hidden,
                settings,
            },
            size: [settings.width, settings.height],
            picture: Picture::default(),
            status: Status::default(),
            benchmark: None,
            mouse: PhysicalPosition::default(),
            left: false,
            right: false,
            flying: Default::default(),
            flown_at: None,
            help: false,
            figures: false,
            probe: false,
            progress: None,
            error: None,
            message: None,
            writing: Arc::default(),
            options,
        })
    }

    /// After the window is closed.
    ///
    /// # Errors
    /// [`ViewError`], if it could not be opened or was lost.
    pub fn finish(self) -> Result<Option<Report>, ViewError> {
        self.shared.end();
        // A file that is being written is finished; a picture that is still traced for one is not waited for.
        let _written = self.writing.lock().unwrap_or_else(PoisonError::into_inner);
        match self.failure {
            Some(why) => Err(ViewError::Failed(why)),
            None => Ok(self.benchmark.and_then(|benchmark| benchmark.report())),
        }
    }

    fn open(&mut self, event_loop: &ActiveEventLoop) -> Result<(), String> {
        let [width, height] = self.size;
        let attributes = Window::default_attributes()
            .with_title(format!("octray - {}", self.options.name))
            .with_inner_size(PhysicalSize::new(width, height))
            .with_min_inner_size(PhysicalSize::new(16, 16));
        let cannot = |what: &str, error: &dyn std::fmt::Display| format!("cannot {what}: {error}");
        let window = event_loop
            .create_window(attributes)
            .map_err(|error| cannot("open a window", &error))?;
        let window = Rc::new(window);
        let draw = |error: softbuffer::SoftBufferError| cannot("draw into the window", &error);
        let context = softbuffer::Context::new(Rc::clone(&window)).map_err(draw)?;
        let surface = Surface::new(&context, Rc::clone(&window)).map_err(draw)?;
        let PhysicalSize { width, height } = window.inner_size();
        self.size = [width, height];
        self.screen = Some(Screen { window, surface });

        let (shared, proxy, budget) = (Arc::clone(&self.shared), self.proxy.clone(), self.options.budget);
        thread::spawn(move || {
            worker::run(&shared, budget, &|note| {
                // The window is closed: nobody needs to know.
                let _ = proxy.send_event(Event::Worker(note));
            });
        });
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

    fn wanted(&self) -> Wanted {
        Wanted {
            model: Arc::clone(&self.model),
            pose: self.orbit.pose(),
            camera: self.orbit.camera(),
            style: self.style,
            size: self.size,
        }
    }

    /// What is under the mouse, if that is asked for.
    fn probed(&self) -> Option<Vec<String>> {
        let inside = |p: f64, pixels: u32| (p >= 0.0 && p < f64::from(pixels)).then_some(p as u32);
        let x = inside(self.mouse.x, self.size[0]).filter(|_| self.probe)?;
        let y = inside(self.mouse.y, self.size[1])?;
        Some(probe::describe(
            &self.model,
            &self.orbit.camera(),
            self.size,
            [x, y],
        ))
    }

    /// Tells the worker what to show from now on. A window without pixels shows nothing.
    fn ask(&mut self) {
        self.progress = None;
        if !self.size.contains(&0) {
            self.shared.post(self.wanted());
        }
    }

    fn redraw(&self) {
        if let Some(screen) = &self.screen {
            screen.window.request_redraw();
        }
    }

    fn say(&mut self, message: impl Into<String>) {
        self.message = Some((message.into(), Instant::now() + MESSAGE));
        self.redraw();
    }

    fn act(&mut self, action: Action, event_loop: &ActiveEventLoop) {
        let style = &mut self.style;
        let look = |now: Look, wanted: Look| if now == wanted { Look::Full } else { wanted };
        let on = |on: bool| if on { "on" } else { "off" };
        let mut message = None;
        match action {
            Action::Quit => event_loop.exit(),
            Action::View(number) => {
                if let Some(pose) = Pose::classic_view(number) {
                    self.orbit.go_to(pose);
                }
            }
            Action::Frame => {
                let [width, height] = self.size.map(f64::from);
                self.orbit
                    .frame(self.model.scene.bounds(), width / height.max(1.0));
            }
            Action::Preview => style.look = look(style.look, Look::Preview),
            Action::Normals => style.look = look(style.look, Look::Normals),
            Action::Cost => {
                style.look = look(style.look, Look::Cost);
                if style.look == Look::Cost {
                    message = Some(format!(
                        "nodes and primitives a ray tests: 1 dark, {} yellow",
                        heat::HOTTEST
                    ));
                }
            }
            Action::Antialias => {
                style.antialias = !style.antialias;
                message = Some(format!("anti-aliasing {}", on(style.antialias)));
            }
            Action::Brute => {
                style.brute = !style.brute;
                message = Some(format!("BVH {}", on(!style.brute)));
            }
            Action::Leaves => {
                style.boxes = match style.boxes {
                    Boxes::Leaves => Boxes::Hidden,
                    _ => Boxes::Leaves,
                };
            }
            Action::LevelUp | Action::LevelDown => {
                let level = match (style.boxes, action) {
                    (Boxes::Level(0), Action::LevelUp) => None,
                    (Boxes::Level(level), Action::LevelUp) => Some(level - 1),
                    (Boxes::Level(level), _) => Some((level + 1).min(self.model.bvh.stats().depth)),
                    _ => Some(0),
                };
                style.boxes = level.map_or(Boxes::Hidden, Boxes::Level);
                message = Some(level.map_or("no boxes".into(), |level| format!("boxes of level {level}")));
            }
            Action::Mode => {
                let mode = &mut style.settings.mode;
                *mode = match *mode {
                    Mode::Packet => Mode::Scalar,
                    Mode::Scalar => Mode::Packet,
                };
                let name = if *mode == Mode::Packet {
                    "packets"
                } else {
                    "single rays"
                };
                message = Some(name.into());
                self.figures = true;
            }
            Action::PrintCamera => {
                let [width, height] = self.size;
                let line = format!("--size={width}x{height} {}", self.orbit.pose().options());
                self.host.say(&line);
                message = Some("camera printed".into());
            }
            Action::Save => {
                self.save();
                message = Some("saving".into());
            }
            Action::Probe => self.probe = !self.probe,
            Action::Figures => self.figures = !self.figures,
            Action::Help => self.help = !self.help,
            Action::Fly(_) => {}
        }
        if let Some(message) = message {
            self.say(message);
        }
        self.ask();
        self.redraw();
    }

    /// Traces and writes the picture at full quality, while the window goes on.
    fn save(&self) {
        let (host, proxy) = (Arc::clone(&self.host), self.proxy.clone());
        let (writing, shared) = (Arc::clone(&self.writing), Arc::clone(&self.shared));
        let mut wanted = self.wanted();
        // The same picture by the fastest way.
        wanted.style.brute &= wanted.style.look == Look::Cost;
        wanted.style.settings.mode = Mode::Packet;
        let n = if wanted.style.antialias {
            GRIDS[GRIDS.len() - 1]
        } else {
            1
        };
        thread::spawn(move || {
            let model = Arc::clone(&wanted.model);
            let mut renderer = Renderer::new(&model.scene, &model.bvh);
            let mut film = ByteFilm::black(0, 0);
            let go_on = |_| {
                if shared.has_ended() {
                    Flow::Break(())
                } else {
                    Flow::Continue(())
                }
            };
            let traced = worker::trace(&mut renderer, &model, &wanted, wanted.size, n, &mut film, &go_on);
            let saved = traced.map_err(|error| error.to_string()).and_then(|_| {
                let _writing = writing.lock().unwrap_or_else(PoisonError::into_inner);
                // Nobody would wait for a file that is begun now.
                if shared.has_ended() {
                    return Err("the window is closed".into());
                }
                host.save(&film)
            });
            let _ = proxy.send_event(Event::Saved(saved));
        });
    }

    fn key(&mut self, event: &KeyEvent, event_loop: &ActiveEventLoop) {
        let pressed = event.state == ElementState::Pressed;
        match keys::action(&event.logical_key) {
            Some(Action::Fly(direction)) if !event.repeat => {
                if !self.flying.contains(&true) {
                    // A tap is a step, too.
                    self.flown_at = Instant::now().checked_sub(STEP * 2);
                }
                self.flying[direction] = pressed;
                self.fly();
            }
            Some(Action::Fly(_)) | None => {}
            Some(action) if pressed && !event.repeat => self.act(action, event_loop),
            Some(_) => {}
        }
    }

    /// Flies on for the time since the last step.
    fn fly(&mut self) {
        if !self.flying.contains(&true) {
            self.flown_at = None;
            return;
        }
        let now = Instant::now();
        let seconds = self.flown_at.map_or(0.0, |at| (now - at).as_secs_f64()).min(0.1);
        self.flown_at = Some(now);
        let mut way = [0.0; 3];
        for (_, direction) in self.flying.iter().zip(keys::DIRECTIONS).filter(|(on, _)| **on) {
            for (sum, part) in way.iter_mut().zip(direction) {
                *sum += part * seconds;
            }
        }
        self.orbit.fly(way[0], way[1], way[2]);
        self.ask();
    }

    fn mouse_moved(&mut self, to: PhysicalPosition<f64>) {
        let [right, down] = [to.x - self.mouse.x, to.y - self.mouse.y];
        self.mouse = to;
        if self.left {
            self.orbit.turn(right, down);
        } else if self.right {
            self.orbit.approach(FACTOR_OF_PIXEL.powf(down));
        }
        if self.left || self.right {
            self.ask();
        } else if self.probe {
            self.redraw();
        }
    }

    fn wheel(&mut self, delta: MouseScrollDelta) {
        let factor = match delta {
            MouseScrollDelta::LineDelta(_, lines) => FACTOR_OF_NOTCH.powf(-f64::from(lines)),
            MouseScrollDelta::PixelDelta(pixels) => FACTOR_OF_PIXEL.powf(-pixels.y),
        };
        self.orbit.approach(factor);
        self.ask();
    }

    fn resized(&mut self, size: PhysicalSize<u32>) {
        self.size = [size.width, size.height];
        self.ask();
    }

    /// Puts the newest picture on the screen, and over it what there is to say.
    fn draw(&mut self) -> Result<(), String> {
        let now = Instant::now();
        let is_new = self.shared.take(&mut self.picture);
        let probed = self.probed();
        if self.message.as_ref().is_some_and(|(_, until)| now >= *until) {
            self.message = None;
        }
        let Some(screen) = &mut self.screen else {
            return Ok(());
        };
        let PhysicalSize { width, height } = screen.window.inner_size();
        let (Some(w), Some(h)) = (NonZeroU32::new(width), NonZeroU32::new(height)) else {
            return Ok(());
        };
        let lost = |error: softbuffer::SoftBufferError| format!("cannot draw into the window: {error}");
        screen.surface.resize(w, h).map_err(lost)?;
        let mut buffer = screen.surface.buffer_mut().map_err(lost)?;
        copy(&self.picture, &mut buffer, [width, height]);
        if is_new {
            self.status.shown(&self.picture, now);
        }
        let mut canvas = Canvas {
            pixels: &mut buffer,
            width,
            height,
        };
        overlay(
            &mut canvas,
            &Overlay {
                help: self.help,
                figures: self
                    .figures
                    .then(|| [vec![self.status.line(&self.picture)], self.status.modes()].concat()),
                probed: probed.as_deref(),
                progress: self.progress,
                error: self.error.as_deref(),
                message: self.message.as_ref().map(|(text, _)| text.as_str()),
            },
        );
        buffer.present().map_err(lost)?;
        if is_new {
            if let Some(title) = self.status.title(&self.options.name, &self.picture, now) {
                screen.window.set_title(&title);
            }
            if let Some(benchmark) = &mut self.benchmark {
                benchmark.shown(&self.picture, Instant::now());
            }
        }
        Ok(())
    }

    /// The next view of the benchmark's orbit.
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
            Ok(model) => {
                self.orbit.set_unit(unit_of(model.scene.bounds()));
                self.model = model;
                self.error = None;
                self.say("loaded again");
                self.ask();
            }
            Err(error) => {
                self.error = Some(error);
                self.redraw();
            }
        }
    }
}

impl ApplicationHandler<Event> for App {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.screen.is_none()
            && let Err(why) = self.open(event_loop)
        {
            self.failure = Some(why);
            event_loop.exit();
        }
    }

    fn new_events(&mut self, _: &ActiveEventLoop, cause: StartCause) {
        if matches!(cause, StartCause::ResumeTimeReached { .. }) {
            if self.flying.contains(&true) {
                self.fly();
            }
            if self.message.is_some() {
                self.redraw();
            }
        }
    }

    fn user_event(&mut self, event_loop: &ActiveEventLoop, event: Event) {
        match event {
            Event::Worker(Note::Picture) => {
                self.progress = None;
                self.orbit_on(event_loop);
            }
            Event::Worker(Note::Progress(share)) => self.progress = Some(share),
            Event::Reloaded(reloaded) => self.reloaded(reloaded),
            Event::Saved(Ok(name)) => self.say(format!("saved {name}")),
            Event::Saved(Err(why)) => self.say(why),
        }
        self.redraw();
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::Resized(size) => self.resized(size),
            // The synthetic ones are of keys that are held when the focus comes or goes: pressed for another window, or
            // reported as pressed here as well. (What is let go elsewhere is dealt with below. On X11 a key that is still
            // held when it repeats counts as pressed here then.)
            WindowEvent::KeyboardInput {
                event,
                is_synthetic: false,
                ..
            } => self.key(&event, event_loop),
            WindowEvent::CursorMoved { position, .. } => self.mouse_moved(position),
            WindowEvent::MouseInput { state, button, .. } => {
                let pressed = state == ElementState::Pressed;
                match button {
                    MouseButton::Left => self.left = pressed,
                    MouseButton::Right => self.right = pressed,
                    _ => {}
                }
            }
            WindowEvent::MouseWheel { delta, .. } => self.wheel(delta),
            // Keys that are let go elsewhere are not heard of.
            WindowEvent::Focused(false) => {
                self.flying = Default::default();
                (self.left, self.right) = (false, false);
            }
            WindowEvent::RedrawRequested => {
                if let Err(why) = self.draw() {
                    self.failure = Some(why);
                    event_loop.exit();
                }
            }
            _ => {}
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        let step = self
            .flown_at
            .filter(|_| self.flying.contains(&true))
            .map(|at| at + STEP);
        let message = self.message.as_ref().map(|(_, until)| *until);
        let next = [step, message].into_iter().flatten().min();
        event_loop.set_control_flow(next.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
    }
}

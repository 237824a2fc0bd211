//! The window itself: shows the progress of loading, then the [`App`].

use super::{
    Closed, Content, Start, ViewError,
    keys::{self, Action},
    loading::{self, Loading, Ready},
    overlay,
    pose::Pose,
    screen::Canvas,
    timeline::Timeline,
    watch::Reloaded,
    window::{App, Framing, Mouse},
    worker::Note,
};
use softbuffer::SoftBufferError;
use std::{
    num::NonZeroU32,
    rc::Rc,
    sync::{
        Arc,
        mpsc::{Receiver, RecvTimeoutError, TryRecvError},
    },
    time::Duration,
};
use winit::{
    application::ApplicationHandler,
    dpi::PhysicalSize,
    event::{ElementState, StartCause, WindowEvent},
    event_loop::{ActiveEventLoop, EventLoopProxy},
    window::{Window, WindowId},
};

type Surface = softbuffer::Surface<Rc<Window>, Rc<Window>>;

/// If loading takes less than this, the window opens afterwards: it would only flicker, above all at an error.
const PATIENCE: Duration = Duration::from_millis(200);

/// Events from other threads.
#[derive(Debug)]
pub enum Event {
    /// Progress of loading.
    Loading(String),
    /// Loading has ended.
    Loaded,
    /// From the worker.
    Worker(Note),
    /// Progress of loading the files again.
    Reloading(String),
    /// The files were loaded again.
    Reloaded(Reloaded),
    /// A picture was saved under this name, or could not be.
    Saved(Result<String, String>),
    /// The objects of a large scene are known, for this framing if the camera has not moved since.
    Objects(Arc<Timeline>, Framing, Pose),
    /// The window is to be closed.
    Close,
}

/// Why nothing can be drawn, without what only a programmer reads.
fn no_surface(error: SoftBufferError) -> String {
    let why = match error {
        SoftBufferError::PlatformError(Some(what), None) if what.starts_with("Visual ") => {
            "octray needs an X11 screen with 24-bit colour".into()
        }
        SoftBufferError::PlatformError(Some(what), None) => what,
        SoftBufferError::PlatformError(Some(what), Some(cause)) => format!("{what}: {cause}"),
        SoftBufferError::PlatformError(None, Some(cause)) => cause.to_string(),
        error => error.to_string(),
    };
    format!("cannot draw into the window: {why}")
}

/// A window and its pixels.
pub(super) struct Screen {
    window: Rc<Window>,
    surface: Surface,
}

impl Screen {
    fn open(event_loop: &ActiveEventLoop, start: &Start) -> Result<Self, String> {
        let [width, height] = start.size;
        let attributes = Window::default_attributes()
            .with_title(format!("octray - {}", start.name))
            .with_inner_size(PhysicalSize::new(width, height))
            .with_min_inner_size(PhysicalSize::new(16, 16));
        let window = event_loop
            .create_window(attributes)
            .map_err(|error| format!("cannot open a window: {error}"))?;
        let window = Rc::new(window);
        let context = softbuffer::Context::new(Rc::clone(&window)).map_err(no_surface)?;
        let surface = Surface::new(&context, Rc::clone(&window)).map_err(no_surface)?;
        Ok(Self { window, surface })
    }

    /// Pixels across and down.
    pub fn size(&self) -> [u32; 2] {
        let PhysicalSize { width, height } = self.window.inner_size();
        [width, height]
    }

    pub fn redraw(&self) {
        self.window.request_redraw();
    }

    pub fn set_title(&self, title: &str) {
        self.window.set_title(title);
    }

    /// Shows what `paint` draws; it gets the scale factor of the screen. A window without pixels shows nothing.
    pub fn draw(&mut self, paint: impl FnOnce(&mut Canvas<'_>, f64)) -> Result<(), String> {
        let [width, height] = self.size();
        let (Some(w), Some(h)) = (NonZeroU32::new(width), NonZeroU32::new(height)) else {
            return Ok(());
        };
        self.surface.resize(w, h).map_err(no_surface)?;
        let mut buffer = self.surface.buffer_mut().map_err(no_surface)?;
        let mut canvas = Canvas {
            pixels: &mut buffer,
            width,
            height,
        };
        paint(&mut canvas, self.window.scale_factor());
        buffer.present().map_err(no_surface)
    }
}

/// The window before and after loading.
pub(super) struct Shell {
    start: Start,
    proxy: EventLoopProxy<Event>,
    results: Receiver<Option<Ready>>,
    /// What was loaded before the window opened.
    ready: Option<Ready>,
    /// Progress of loading.
    text: String,
    /// `None` once the app has it.
    screen: Option<Screen>,
    /// Before there is an app.
    mouse: Mouse,
    app: Option<App>,
    failure: Option<String>,
}

impl Shell {
    /// Begins to load, and waits a moment for it. `None` if `load` returns `None` in this time.
    pub fn new(
        start: Start,
        proxy: EventLoopProxy<Event>,
        load: impl FnOnce(&Loading) -> Option<Content> + Send + 'static,
    ) -> Option<Self> {
        let results = loading::start(proxy.clone(), load);
        let ready = match results.recv_timeout(PATIENCE) {
            Ok(ready) => Some(ready?),
            Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => None,
        };
        Some(Self {
            text: format!("loading {}", start.name),
            start,
            proxy,
            results,
            ready,
            screen: None,
            mouse: Mouse::default(),
            app: None,
            failure: None,
        })
    }

    /// Ends the app after the window is closed.
    ///
    /// # Errors
    /// [`ViewError`] if the window could not be opened or was lost.
    pub fn finish(self) -> Result<Closed, ViewError> {
        let closed = self.app.map_or(Ok(Closed::default()), App::finish)?;
        match self.failure {
            Some(why) => Err(ViewError::Failed(why)),
            None => Ok(closed),
        }
    }

    /// Shows what is loaded as soon as it is.
    fn show_loaded(&mut self) -> Result<(), Option<String>> {
        let Some(screen) = self.screen.take() else {
            return Ok(());
        };
        let ready = match self.ready.take() {
            Some(ready) => ready,
            None => match self.results.try_recv() {
                Ok(Some(ready)) => ready,
                // The program knows why.
                Ok(None) => return Err(None),
                Err(TryRecvError::Disconnected) => return Err(Some("cannot load the scene".into())),
                Err(TryRecvError::Empty) => {
                    self.screen = Some(screen);
                    return Ok(());
                }
            },
        };
        let (mouse, proxy) = (std::mem::take(&mut self.mouse), self.proxy.clone());
        let app = App::new(self.start.name.clone(), ready, screen, mouse, proxy);
        self.app = Some(app.map_err(Some)?);
        Ok(())
    }

    /// Shows the progress of loading.
    fn draw(&mut self) -> Result<(), Option<String>> {
        let text = &self.text;
        let Some(screen) = &mut self.screen else {
            return Ok(());
        };
        screen
            .draw(|canvas, scale_factor| overlay::only(canvas, scale_factor, text))
            .map_err(Some)
    }

    /// Ends if something has failed.
    fn or_end(&mut self, done: Result<(), Option<String>>, event_loop: &ActiveEventLoop) {
        if let Err(why) = done {
            self.failure = why;
            event_loop.exit();
        }
    }
}

impl ApplicationHandler<Event> for Shell {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.screen.is_some() || self.app.is_some() {
            return;
        }
        let opened = Screen::open(event_loop, &self.start).map_err(Some);
        let shown = opened.and_then(|screen| {
            self.screen = Some(screen);
            self.show_loaded()
        });
        self.or_end(shown, event_loop);
    }

    fn new_events(&mut self, _: &ActiveEventLoop, cause: StartCause) {
        if let Some(app) = &mut self.app {
            app.new_events(cause);
        }
    }

    fn user_event(&mut self, event_loop: &ActiveEventLoop, event: Event) {
        match (&mut self.app, event) {
            (_, Event::Close) => event_loop.exit(),
            (Some(app), event) => app.user_event(event_loop, event),
            (None, Event::Loading(text)) => {
                self.text = text;
                if let Some(screen) = &self.screen {
                    screen.redraw();
                }
            }
            (None, _) => {
                let shown = self.show_loaded();
                self.or_end(shown, event_loop);
            }
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        if let Some(app) = &mut self.app {
            return app.window_event(event_loop, event);
        }
        self.mouse.note(&event);
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::KeyboardInput {
                event,
                is_synthetic: false,
                ..
            } if event.state == ElementState::Pressed
                && keys::action(&event.logical_key) == Some(Action::Quit) =>
            {
                event_loop.exit();
            }
            WindowEvent::RedrawRequested => {
                let drawn = self.draw();
                self.or_end(drawn, event_loop);
            }
            _ => {}
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        if let Some(app) = &self.app {
            app.about_to_wait(event_loop);
        }
    }
}

#[cfg(test)]
mod tests;

//! The thread that traces. The window tells it what it wants; the latest wish wins, and what is under way for an
//! older one at rest is given up. So input waits for no picture.

use super::{
    boxes,
    budget::Budget,
    look::{Boxes, Look, Model, Wanted},
    primary,
    progressive::Progressive,
    screen::{self, Canvas},
};
use crate::{
    math::Aabb,
    render::{ByteFilm, FrameStats, OnProgress, RenderError, Renderer, Settings},
};
use std::{
    ops::ControlFlow,
    sync::{
        Arc, Condvar, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicU64, Ordering},
    },
    time::{Duration, Instant},
};

/// When nothing has moved for so long, the camera rests.
const REST: Duration = Duration::from_millis(80);
/// For so long even the coarsest picture of a camera that has moved on is traced to its end: of pictures that take a
/// while every one is shown, and of those that take longer still none is waited for.
const STALE: Duration = Duration::from_secs(1);
/// How often a long picture says how far it is.
const PROGRESS: Duration = Duration::from_millis(250);
/// The epoch in which everything ends.
const END: u64 = u64::MAX;

/// A finished picture in pixels of the window.
#[derive(Debug, Default)]
pub struct Picture {
    /// 0RGB, row by row.
    pub pixels: Vec<u32>,
    /// Pixels across and down.
    pub size: [u32; 2],
    /// Pixels that were traced, across and down.
    pub traced: [u32; 2],
    /// Samples of each.
    pub samples: u32,
    /// Whether every pixel of the window was traced.
    pub full: bool,
    /// Whether it is all that there will be: nothing moves, and all samples are in.
    pub last: bool,
    /// Rays of all kinds.
    pub rays: u64,
    /// Tracing and shading alone.
    pub elapsed: Duration,
    /// Whether this was traced in packets, ray by ray, or by neither in particular.
    pub packets: Option<bool>,
}

/// What the worker has to say.
#[derive(Debug)]
pub enum Note {
    /// [`Shared::take`] has a new picture.
    Picture,
    /// So much of the next picture is done, 0 to 1.
    Progress(f32),
}

/// What the window and the worker share.
#[derive(Debug, Default)]
pub struct Shared {
    inbox: Mutex<Inbox>,
    arrived: Condvar,
    /// Counts wishes for other pictures.
    epoch: AtomicU64,
    /// The epoch of the last wish for more than another pose or size.
    turn: AtomicU64,
    done: Mutex<Done>,
}

#[derive(Debug, Default)]
struct Inbox {
    next: Option<Wish>,
    latest: Option<Wanted>,
}

/// What is wanted, and the epoch that it begins.
#[derive(Clone, Debug)]
struct Wish {
    wanted: Wanted,
    epoch: u64,
}

#[derive(Debug, Default)]
struct Done {
    picture: Option<Picture>,
    /// Memory of older pictures.
    spare: Vec<u32>,
}

/// What is left by a panicked thread is as good as any other state here.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Shared {
    /// Asks for a picture, instead of all that was asked for before.
    pub fn post(&self, wanted: Wanted) {
        let mut inbox = lock(&self.inbox);
        let mut epoch = self.epoch.load(Ordering::Relaxed);
        let latest = inbox.latest.as_ref();
        if !latest.is_some_and(|latest| latest.same_picture(&wanted)) {
            epoch += 1;
            self.epoch.store(epoch, Ordering::Relaxed);
            if !latest.is_some_and(|latest| latest.same_rays(&wanted)) {
                self.turn.store(epoch, Ordering::Relaxed);
            }
        }
        inbox.latest = Some(wanted.clone());
        inbox.next = Some(Wish { wanted, epoch });
        self.arrived.notify_one();
    }

    /// Ends the worker, soon.
    pub fn end(&self) {
        self.epoch.store(END, Ordering::Relaxed);
        let _inbox = lock(&self.inbox);
        self.arrived.notify_one();
    }

    /// The newest picture, if it has not been taken yet; `old` is given back for its memory.
    pub fn take(&self, old: &mut Picture) -> bool {
        let mut done = lock(&self.done);
        let Some(picture) = done.picture.take() else {
            return false;
        };
        done.spare = std::mem::replace(old, picture).pixels;
        true
    }

    fn has_ended(&self) -> bool {
        self.epoch.load(Ordering::Relaxed) == END
    }

    /// Whether another picture is wanted by now.
    fn is_over(&self, epoch: u64) -> bool {
        self.epoch.load(Ordering::Relaxed) != epoch
    }

    /// Whether a picture of other rays is.
    fn has_turned(&self, epoch: u64) -> bool {
        self.turn.load(Ordering::Relaxed) > epoch || self.has_ended()
    }

    /// The next wish. Waits for it for as long as `patience`, or for ever.
    fn next(&self, patience: Option<Duration>) -> Option<Wish> {
        let inbox = lock(&self.inbox);
        let is_quiet = |inbox: &mut Inbox| inbox.next.is_none() && !self.has_ended();
        let mut inbox = match patience {
            None => self
                .arrived
                .wait_while(inbox, is_quiet)
                .unwrap_or_else(PoisonError::into_inner),
            Some(patience) => {
                self.arrived
                    .wait_timeout_while(inbox, patience, is_quiet)
                    .unwrap_or_else(PoisonError::into_inner)
                    .0
            }
        };
        inbox.next.take()
    }
}

/// Traces what is asked for until [`Shared::end`].
pub fn run(shared: &Shared, budget: Duration, tell: &(dyn Fn(Note) + Sync)) {
    let mut wish = shared.next(None);
    while let Some(first) = wish {
        let model = Arc::clone(&first.wanted.model);
        let session = Session {
            shared,
            tell,
            model: &model,
            renderer: Renderer::new(&model.scene, &model.bvh),
            budget: Budget::new(budget),
            progressive: Progressive::default(),
            film: ByteFilm::black(0, 0),
            boxes: (Boxes::Hidden, Vec::new()),
        };
        wish = session.run(first);
    }
}

/// The time of one scene.
struct Session<'a> {
    shared: &'a Shared,
    tell: &'a (dyn Fn(Note) + Sync),
    model: &'a Model,
    renderer: Renderer<'a>,
    budget: Budget,
    progressive: Progressive,
    film: ByteFilm,
    boxes: (Boxes, Vec<Aabb>),
}

impl Session<'_> {
    /// Returns the first wish for another scene; `None` at the end.
    fn run(mut self, mut wish: Wish) -> Option<Wish> {
        let mut moving = true;
        loop {
            let patience = if moving {
                self.moving_frame(&wish);
                Some(REST)
            } else if let Some(n) = self.progressive.next(wish.wanted.style.antialias) {
                self.resting_frame(&wish, n);
                Some(Duration::ZERO)
            } else {
                None
            };
            moving = false;
            let newer = self.shared.next(patience);
            if self.shared.has_ended() {
                return None;
            }
            let Some(newer) = newer else { continue };
            let (old, new) = (&wish.wanted, &newer.wanted);
            if !Arc::ptr_eq(&new.model, &old.model) {
                return Some(newer);
            }
            if !new.same_picture(old) {
                if !new.same_rays(old) {
                    self.budget.forget();
                }
                moving = true;
            }
            wish = newer;
        }
    }

    /// A picture in time: coarser if it must be.
    fn moving_frame(&mut self, Wish { wanted, epoch }: &Wish) {
        self.progressive.restart();
        loop {
            let start = Instant::now();
            let plan = self.budget.plan(wanted.size);
            let (shared, budget, done) = (self.shared, self.budget.clone(), AtomicU64::new(0));
            let traced = self.trace(wanted, plan.size, 1, &|progress| {
                done.fetch_max(progress.pixels_done, Ordering::Relaxed);
                let elapsed = start.elapsed();
                let late = !plan.coarsest && budget.is_overdrawn(elapsed);
                let stale = elapsed > STALE && shared.is_over(*epoch);
                if late || stale || shared.has_turned(*epoch) {
                    return ControlFlow::Break(());
                }
                ControlFlow::Continue(())
            });
            match traced {
                Ok(stats) => {
                    if plan.full {
                        self.progressive.done(1);
                    }
                    self.publish(wanted, &stats, 1, plan.full);
                    let pixels = u64::from(plan.size[0]) * u64::from(plan.size[1]);
                    self.budget.learn(pixels, start.elapsed());
                    return;
                }
                Err(RenderError::Cancelled) if !plan.coarsest && !self.shared.has_turned(*epoch) => {
                    self.budget.learn_failure(done.into_inner(), start.elapsed());
                }
                Err(_) => return,
            }
        }
    }

    /// The whole picture, unless something else is wanted before it is done.
    fn resting_frame(&mut self, Wish { wanted, epoch }: &Wish, n: u32) {
        let (shared, tell) = (self.shared, self.tell);
        let start = Instant::now();
        let told = AtomicU64::new(0);
        let traced = self.trace(wanted, wanted.size, n, &|progress| {
            let ticks = (start.elapsed().as_millis() / PROGRESS.as_millis()) as u64;
            if told.fetch_max(ticks, Ordering::Relaxed) < ticks {
                tell(Note::Progress(
                    progress.pixels_done as f32 / progress.pixels_total as f32,
                ));
            }
            if shared.is_over(*epoch) {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        });
        match traced {
            Ok(stats) => {
                self.progressive.done(n);
                self.publish(wanted, &stats, n, true);
            }
            Err(RenderError::Cancelled) => {}
            // A limit: there will be no better picture than the one that is shown.
            Err(_) => self.progressive.done(super::progressive::GRIDS[3]),
        }
    }

    fn trace(
        &mut self,
        wanted: &Wanted,
        size: [u32; 2],
        n: u32,
        on_progress: OnProgress<'_>,
    ) -> Result<FrameStats, RenderError> {
        trace(
            &mut self.renderer,
            self.model,
            wanted,
            size,
            n,
            &mut self.film,
            on_progress,
        )
    }

    /// Hands the film over to the window, with what is drawn over it.
    fn publish(&mut self, wanted: &Wanted, stats: &FrameStats, n: u32, full: bool) {
        let mut pixels = std::mem::take(&mut lock(&self.shared.done).spare);
        screen::spread(&self.film, wanted.size, &mut pixels);
        let last = full && self.progressive.next(wanted.style.antialias).is_none();
        self.draw_boxes(wanted, &mut pixels, last || n > 1);
        let is_packets = wanted.style.settings.mode == crate::render::Mode::Packet;
        let either = !wanted.style.brute && wanted.style.look != Look::Cost;
        let picture = Picture {
            pixels,
            size: wanted.size,
            traced: [self.film.width(), self.film.height()],
            samples: n * n,
            full,
            last,
            rays: stats.rays.total(),
            elapsed: stats.elapsed,
            packets: either.then_some(is_packets),
        };
        lock(&self.shared.done).picture = Some(picture);
        (self.tell)(Note::Picture);
    }

    fn draw_boxes(&mut self, wanted: &Wanted, pixels: &mut [u32], rests: bool) {
        let which = wanted.style.boxes;
        if self.boxes.0 != which {
            self.boxes = (which, boxes::select(&self.model.bvh, which));
        }
        let all = &self.boxes.1;
        let stride = if rests {
            1
        } else {
            all.len().div_ceil(boxes::MOST_MOVING).max(1)
        };
        let mut canvas = Canvas {
            pixels,
            width: wanted.size[0],
            height: wanted.size[1],
        };
        boxes::draw(
            &mut canvas,
            &wanted.pose,
            all.iter().copied().step_by(stride),
            boxes::COLOR,
        );
    }
}

/// Traces what is wanted in `size` pixels.
///
/// # Errors
/// [`RenderError`].
pub fn trace(
    renderer: &mut Renderer<'_>,
    model: &Model,
    wanted: &Wanted,
    size: [u32; 2],
    n: u32,
    film: &mut ByteFilm,
    on_progress: OnProgress<'_>,
) -> Result<FrameStats, RenderError> {
    let style = &wanted.style;
    let settings = Settings {
        width: size[0],
        height: size[1],
        samples: n * n,
        ..style.settings
    };
    if style.look == Look::Full && !style.brute {
        return renderer.render(&wanted.camera, &settings, film, on_progress);
    }
    settings.validate()?;
    film.resize(size[0], size[1]);
    primary::render(model, &wanted.camera, style, n, film, on_progress)
}

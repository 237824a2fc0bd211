//! The thread that traces. The window tells it what it wants; the latest wish wins, and what is under way for an
//! older one is given up: at rest at once, else when its time is over. So input waits for no picture.

use super::{
    boxes,
    budget::Budget,
    look::{Boxes, Look, Model, Wanted},
    mailbox::{Picture, Shared, Wish},
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
        Arc,
        atomic::{AtomicU64, Ordering},
    },
    time::{Duration, Instant},
};

/// When nothing has moved for so long, the camera rests.
const REST: Duration = Duration::from_millis(80);
/// How often a long picture says how far it is.
const PROGRESS: Duration = Duration::from_millis(250);
/// What the worker has to say.
#[derive(Debug)]
pub enum Note {
    /// [`Shared::take`] has a new picture.
    Picture,
    /// So much of the next picture is done, 0 to 1.
    Progress(f32),
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
            stands_in: false,
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
    /// Whether brute force is too slow for a camera that moves, so that the BVH stands in for it: both make the same
    /// picture.
    stands_in: bool,
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
                    self.stands_in = false;
                }
                moving = true;
            }
            wish = newer;
        }
    }

    /// A picture in time: coarser if it must be. What takes far longer is given up, so that no input waits for it.
    fn moving_frame(&mut self, Wish { wanted, epoch }: &Wish) {
        self.progressive.restart();
        loop {
            let start = Instant::now();
            let stand_in = self.stands_in.then(|| wanted.by_bvh());
            let by_bvh = self.stands_in || !wanted.style.brute;
            let plan = self.budget.plan(wanted.size);
            let (shared, budget, done) = (self.shared, self.budget.clone(), AtomicU64::new(0));
            let traced = self.trace(stand_in.as_ref().unwrap_or(wanted), plan.size, 1, &|progress| {
                done.fetch_max(progress.pixels_done, Ordering::Relaxed);
                // With nothing coarser to try it is traced to its end, unless the camera has moved on.
                let has_other = !plan.coarsest || !by_bvh || shared.is_over(*epoch);
                if shared.has_turned(*epoch) || has_other && budget.is_overdrawn(start.elapsed()) {
                    return ControlFlow::Break(());
                }
                ControlFlow::Continue(())
            });
            match traced {
                Ok(stats) => {
                    if plan.full && stand_in.is_none() {
                        self.progressive.done(1);
                    }
                    self.publish(stand_in.as_ref().unwrap_or(wanted), *epoch, &stats, 1, plan.full);
                    let pixels = u64::from(plan.size[0]) * u64::from(plan.size[1]);
                    self.budget.learn(pixels, start.elapsed());
                    return;
                }
                Err(RenderError::Cancelled) if self.shared.has_turned(*epoch) => return,
                Err(RenderError::Cancelled) if plan.coarsest && by_bvh => return,
                Err(RenderError::Cancelled) if plan.coarsest => {
                    self.stands_in = true;
                    self.budget.forget();
                }
                Err(RenderError::Cancelled) => self.budget.learn_failure(done.into_inner(), start.elapsed()),
                Err(_) => return,
            }
            if self.shared.is_over(*epoch) {
                return;
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
                self.publish(wanted, *epoch, &stats, n, true);
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
    fn publish(&mut self, wanted: &Wanted, epoch: u64, stats: &FrameStats, n: u32, full: bool) {
        let mut pixels = self.shared.spare();
        screen::spread(&self.film, wanted.size, &mut pixels);
        let last = full && self.progressive.next(wanted.style.antialias).is_none();
        self.draw_boxes(wanted, &mut pixels, last || n > 1);
        let is_packets = wanted.style.settings.mode == crate::render::Mode::Packet;
        let either = !wanted.style.brute && wanted.style.look != Look::Cost;
        self.shared.publish(Picture {
            pixels,
            epoch,
            size: wanted.size,
            traced: [self.film.width(), self.film.height()],
            samples: n * n,
            full,
            last,
            stand_in: self.stands_in && !wanted.style.brute,
            rays: stats.rays.total(),
            elapsed: stats.elapsed,
            packets: either.then_some(is_packets),
        });
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
            self.model.scene.origin(),
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

//! The thread that traces the latest request of the window.
//!
//! A picture of an older request is given up: at rest at once, while the camera moves when its time is over. So input
//! never waits for a picture.

use super::{
    boxes,
    budget::Budget,
    mailbox::{Job, Picture, Shared},
    primary,
    progressive::Progressive,
    request::{Boxes, Look, Model, Request},
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

/// The camera is at rest when it has not moved for this long.
const REST: Duration = Duration::from_millis(80);
/// How often a long picture reports progress.
const PROGRESS: Duration = Duration::from_millis(250);

/// What the worker tells the window.
#[derive(Debug)]
pub enum Note {
    /// [`Shared::take`] has a new picture.
    Picture,
    /// The share of the next picture that is done, 0 to 1.
    Progress(f32),
}

/// Traces what is requested until [`Shared::end`].
pub fn run(shared: &Shared, budget: Duration, tell: &(dyn Fn(Note) + Sync)) {
    let mut job = shared.next(None);
    while let Some(first) = job {
        let model = Arc::clone(&first.request.model);
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
        job = session.run(first);
    }
}

/// The work on one scene.
struct Session<'a> {
    shared: &'a Shared,
    tell: &'a (dyn Fn(Note) + Sync),
    model: &'a Model,
    renderer: Renderer<'a>,
    budget: Budget,
    progressive: Progressive,
    film: ByteFilm,
    /// Whether brute force is too slow for a moving camera. The BVH then makes the same picture.
    stands_in: bool,
    boxes: (Boxes, Vec<Aabb>),
}

impl Session<'_> {
    /// Returns the first request for another scene; `None` at the end.
    fn run(mut self, mut job: Job) -> Option<Job> {
        let mut moving = true;
        loop {
            let timeout = if moving {
                self.moving_frame(&job);
                Some(REST)
            } else if let Some(n) = self.progressive.next(job.request.style.antialias) {
                self.resting_frame(&job, n);
                Some(Duration::ZERO)
            } else {
                None
            };
            moving = false;
            let newer = self.shared.next(timeout);
            if self.shared.has_ended() {
                return None;
            }
            let Some(newer) = newer else { continue };
            let (old, new) = (&job.request, &newer.request);
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
            job = newer;
        }
    }

    /// Traces a picture within the budget, coarser if necessary. One that takes far longer is given up.
    fn moving_frame(&mut self, Job { request, generation }: &Job) {
        self.progressive.restart();
        loop {
            let start = Instant::now();
            let stand_in = self.stands_in.then(|| request.by_bvh());
            let by_bvh = self.stands_in || !request.style.brute;
            let plan = self.budget.plan(request.size);
            let (shared, budget, done) = (self.shared, self.budget.clone(), AtomicU64::new(0));
            let traced = self.trace(stand_in.as_ref().unwrap_or(request), plan.size, 1, &|progress| {
                done.fetch_max(progress.pixels_done, Ordering::Relaxed);
                // The coarsest picture is finished unless the camera has moved on.
                let has_other = !plan.coarsest || !by_bvh || shared.changed_since(*generation);
                if shared.rays_changed_since(*generation) || has_other && budget.is_overdrawn(start.elapsed())
                {
                    return ControlFlow::Break(());
                }
                ControlFlow::Continue(())
            });
            match traced {
                Ok(stats) => {
                    if plan.full && stand_in.is_none() {
                        self.progressive.done(1);
                    }
                    self.publish(
                        stand_in.as_ref().unwrap_or(request),
                        *generation,
                        &stats,
                        1,
                        plan.full,
                    );
                    let pixels = u64::from(plan.size[0]) * u64::from(plan.size[1]);
                    self.budget.learn(pixels, start.elapsed());
                    return;
                }
                Err(RenderError::Cancelled) if self.shared.rays_changed_since(*generation) => return,
                Err(RenderError::Cancelled) if plan.coarsest && by_bvh => return,
                Err(RenderError::Cancelled) if plan.coarsest => {
                    self.stands_in = true;
                    self.budget.forget();
                }
                Err(RenderError::Cancelled) => self.budget.learn_failure(done.into_inner(), start.elapsed()),
                Err(_) => return,
            }
            if self.shared.changed_since(*generation) {
                return;
            }
        }
    }

    /// Traces the whole picture unless the request changes meanwhile.
    fn resting_frame(&mut self, Job { request, generation }: &Job, n: u32) {
        let (shared, tell) = (self.shared, self.tell);
        let start = Instant::now();
        let told = AtomicU64::new(0);
        let traced = self.trace(request, request.size, n, &|progress| {
            let ticks = (start.elapsed().as_millis() / PROGRESS.as_millis()) as u64;
            if told.fetch_max(ticks, Ordering::Relaxed) < ticks {
                tell(Note::Progress(
                    progress.pixels_done as f32 / progress.pixels_total as f32,
                ));
            }
            if shared.changed_since(*generation) {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        });
        match traced {
            Ok(stats) => {
                self.progressive.done(n);
                self.publish(request, *generation, &stats, n, true);
            }
            Err(RenderError::Cancelled) => {}
            // Over a limit: the picture on the screen stays.
            Err(_) => self.progressive.done(super::progressive::GRIDS[3]),
        }
    }

    fn trace(
        &mut self,
        request: &Request,
        size: [u32; 2],
        n: u32,
        on_progress: OnProgress<'_>,
    ) -> Result<FrameStats, RenderError> {
        trace(
            &mut self.renderer,
            self.model,
            request,
            size,
            n,
            &mut self.film,
            on_progress,
        )
    }

    /// Hands the film and the boxes over it to the window.
    fn publish(&mut self, request: &Request, generation: u64, stats: &FrameStats, n: u32, full: bool) {
        let mut pixels = self.shared.spare();
        screen::spread(&self.film, request.size, &mut pixels);
        let last = full && self.progressive.next(request.style.antialias).is_none();
        self.draw_boxes(request, &mut pixels, last || n > 1);
        let is_packets = request.style.settings.mode == crate::render::Mode::Packet;
        let either = !request.style.brute && request.style.look != Look::Cost;
        self.shared.publish(Picture {
            pixels,
            generation,
            size: request.size,
            traced: [self.film.width(), self.film.height()],
            samples: n * n,
            full,
            last,
            stand_in: self.stands_in && !request.style.brute,
            rays: stats.rays.total(),
            elapsed: stats.elapsed,
            packets: either.then_some(is_packets),
        });
        (self.tell)(Note::Picture);
    }

    fn draw_boxes(&mut self, request: &Request, pixels: &mut [u32], rests: bool) {
        let which = request.style.boxes;
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
            width: request.size[0],
            height: request.size[1],
        };
        boxes::draw(
            &mut canvas,
            &request.pose,
            self.model.scene.origin(),
            all.iter().copied().step_by(stride),
            boxes::COLOR,
        );
    }
}

/// Traces a request in `size` pixels, `n` samples along a side of each.
///
/// # Errors
/// [`RenderError`].
pub fn trace(
    renderer: &mut Renderer<'_>,
    model: &Model,
    request: &Request,
    size: [u32; 2],
    n: u32,
    film: &mut ByteFilm,
    on_progress: OnProgress<'_>,
) -> Result<FrameStats, RenderError> {
    let style = &request.style;
    let settings = Settings {
        width: size[0],
        height: size[1],
        samples: n * n,
        ..style.settings
    };
    if style.look == Look::Full && !style.brute {
        return renderer.render(&request.camera, &settings, film, on_progress);
    }
    settings.validate()?;
    film.resize(size[0], size[1]);
    primary::render(model, &request.camera, style, n, film, on_progress)
}

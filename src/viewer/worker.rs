//! The thread that traces the latest request of the window.
//!
//! A picture of an older request is given up: at rest at once, while the camera moves when its time is over. So input
//! never waits for a picture.

use super::{
    boxes,
    budget::Budget,
    mailbox::{Job, Picture, Shared},
    painter::Painter,
    progressive::Progressive,
    request::{Boxes, Look, Model, Request},
    screen::{self, Canvas},
};
use crate::{
    math::Aabb,
    render::{FrameStats, Mode, Progress, RenderError},
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
            painter: Painter::new(&model),
            budget: Budget::new(budget),
            progressive: Progressive::default(),
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
    painter: Painter<'a>,
    budget: Budget,
    progressive: Progressive,
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
            } else if let Some(samples) = self.progressive.next(job.request.style.last_samples()) {
                self.resting_frame(&job, samples);
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
            let shown = stand_in.as_ref().unwrap_or(request);
            let traced = self.painter.trace_denoised(shown, plan.size, 1, &|progress| {
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
                    // At rest a single sample keeps its grain.
                    let is_grainy = request.style.last_samples() == 1 && self.painter.denoises(request);
                    if plan.full && stand_in.is_none() && !is_grainy {
                        self.progressive.done(1);
                    }
                    self.publish(shown, *generation, &stats, 1, plan.full);
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
    fn resting_frame(&mut self, Job { request, generation }: &Job, samples: u32) {
        let (shared, tell) = (self.shared, self.tell);
        let start = Instant::now();
        let told = AtomicU64::new(0);
        let on_progress = |progress: Progress| {
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
        };
        let last = request.style.last_samples();
        let traced = if samples < last {
            self.painter
                .trace_denoised(request, request.size, samples, &on_progress)
        } else {
            self.painter.trace(request, request.size, samples, &on_progress)
        };
        match traced {
            Ok(stats) => {
                self.progressive.done(samples);
                self.publish(request, *generation, &stats, samples, true);
            }
            Err(RenderError::Cancelled) => {}
            // Over a limit: the picture on the screen stays.
            Err(_) => self.progressive.done(last),
        }
    }

    /// Hands the film and the boxes over it to the window.
    fn publish(&mut self, request: &Request, generation: u64, stats: &FrameStats, samples: u32, full: bool) {
        let mut pixels = self.shared.spare();
        screen::spread(&self.painter.film, request.size, &mut pixels);
        let last = full && self.progressive.next(request.style.last_samples()).is_none();
        self.draw_boxes(request, &mut pixels, last || samples > 1);
        let settings = request.style.settings(request.size, samples);
        let is_packets = settings.mode == Mode::Packet;
        let either = !request.style.brute && request.style.look != Look::Cost;
        self.shared.publish(Picture {
            pixels,
            generation,
            size: request.size,
            traced: [self.painter.film.width(), self.painter.film.height()],
            samples: settings.samples,
            adaptive: settings.adaptive,
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

//! The thread that traces the latest request of the window.
//!
//! A picture of an older request is cancelled: at once at rest, or when its time is over while the camera moves. So input
//! never waits for a picture.

use super::{
    boxes,
    budget::Budget,
    mailbox::{Job, Picture, Shared},
    painter::Painter,
    progressive::Progressive,
    request::{Boxes, Look, Request},
    screen::{self, Canvas},
    timeline::Model,
};
use crate::{
    math::Aabb,
    render::{FrameStats, Mode, Progress, RenderError},
};
use glam::Vec3;
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
/// Polling interval while a scene is in use at another frame, for a picture that is being saved.
const USED: Duration = Duration::from_millis(5);
/// How often a long picture reports progress.
const PROGRESS: Duration = Duration::from_millis(250);

/// Messages of the worker to the window.
#[derive(Debug)]
pub enum Note {
    /// [`Shared::take`] has a new picture.
    Picture,
    /// The share of the next picture that is done, 0 to 1.
    Progress(f32),
    /// The requested frame, and why the scene cannot move there.
    Failed(u32, String),
}

/// Traces what is requested until [`Shared::end`].
pub fn run(shared: &Shared, budget: Duration, tell: &(dyn Fn(Note) + Sync)) {
    let mut pace = Pace {
        budget: Budget::new(budget),
        stands_in: false,
    };
    let mut job = shared.next(None);
    while let Some(first) = job {
        let timeline = Arc::clone(&first.request.timeline);
        let model = match timeline.at(first.request.frame) {
            Ok(Some(model)) => model,
            Ok(None) if shared.has_ended() => return,
            Ok(None) => {
                job = shared.next(Some(USED)).or(Some(first));
                continue;
            }
            Err(error) => {
                tell(Note::Failed(first.request.frame, error));
                job = shared.next(None);
                continue;
            }
        };
        let session = Session {
            shared,
            tell,
            model: &model,
            painter: Painter::new(&model),
            pace: &mut pace,
            progressive: Progressive::default(),
            boxes: (Boxes::Hidden, Vec::new()),
        };
        job = session.run(first);
    }
}

/// The measured speed of moving frames.
struct Pace {
    budget: Budget,
    /// Whether brute force is too slow for a moving camera. The BVH then makes the same picture.
    stands_in: bool,
}

/// The work on one frame of a scene.
struct Session<'a> {
    shared: &'a Shared,
    tell: &'a (dyn Fn(Note) + Sync),
    model: &'a Model,
    painter: Painter<'a>,
    pace: &'a mut Pace,
    progressive: Progressive,
    boxes: (Boxes, Vec<Aabb>),
}

impl Session<'_> {
    /// Returns the first request for another scene or frame; `None` at the end.
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
            if !new.same_rays(old) {
                self.pace.budget.forget();
                self.pace.stands_in = false;
            }
            if !new.same_scene(old) {
                return Some(newer);
            }
            // Not by comparison: after A, B, A the picture of the first A may have been dropped for that of B.
            moving = newer.generation != job.generation;
            job = newer;
        }
    }

    /// Traces a picture within the budget, coarser if necessary. One that takes far longer is cancelled.
    fn moving_frame(&mut self, Job { request, generation }: &Job) {
        self.progressive.restart();
        loop {
            let start = Instant::now();
            let shown = &request.in_motion(self.pace.stands_in);
            let by_bvh = self.pace.stands_in || !request.style.brute;
            let plan = self.pace.budget.plan(request.size);
            let (shared, budget, done) = (self.shared, self.pace.budget.clone(), AtomicU64::new(0));
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
                    // At rest a single sample is not denoised.
                    let has_noise = self.painter.denoises(shown) || request.has_lens();
                    let is_noisy = request.style.last_samples() == 1 && has_noise;
                    if plan.full && !self.pace.stands_in && !is_noisy {
                        self.progressive.done(1);
                    }
                    self.publish(shown, *generation, &stats, 1, plan.full);
                    let pixels = u64::from(plan.size[0]) * u64::from(plan.size[1]);
                    self.pace.budget.learn(pixels, start.elapsed());
                    return;
                }
                Err(RenderError::Cancelled) if self.shared.rays_changed_since(*generation) => return,
                Err(RenderError::Cancelled) if plan.coarsest && by_bvh => return,
                Err(RenderError::Cancelled) if plan.coarsest => {
                    self.pace.stands_in = true;
                    self.pace.budget.forget();
                }
                Err(RenderError::Cancelled) => {
                    self.pace.budget.learn_failure(done.into_inner(), start.elapsed());
                }
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

    /// Passes the film, with the boxes drawn over it, to the window.
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
            frame: [request.frame, request.timeline.count()],
            traced: [self.painter.film.width(), self.painter.film.height()],
            samples: settings.samples,
            adaptive: settings.adaptive,
            full,
            last,
            stand_in: self.pace.stands_in && !request.style.brute,
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
            self.model.scene.world_point(Vec3::ZERO),
            all.iter().copied().step_by(stride),
            boxes::COLOR,
        );
    }
}

#[cfg(test)]
mod tests;

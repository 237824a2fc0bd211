//! Loading on another thread, with progress.

use super::{
    Content, Host, Options,
    shell::Event,
    sources::Sources,
    timeline::{Model, Timeline},
};
use crate::{
    accel::{BuildQuality, Bvh},
    scene::Scene,
};
use std::{
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
        mpsc::{self, Receiver},
    },
    time::{Duration, Instant},
};
use winit::event_loop::EventLoopProxy;

/// Bytes of a step of progress where the end is not known.
const MEGABYTE: u64 = 1_000_000;

/// Before that the time left is a guess.
const GUESS: Duration = Duration::from_secs(2);

/// Reports the progress of loading to the window.
#[derive(Clone, Debug)]
pub struct Loading {
    proxy: EventLoopProxy<Event>,
    /// What the window is told.
    event: fn(String) -> Event,
}

impl Loading {
    /// Reports that the scene is loaded again.
    pub(super) fn again(proxy: EventLoopProxy<Event>) -> Self {
        Self {
            proxy,
            event: Event::Reloading,
        }
    }

    /// Begins a stage of `total` steps; if that is 0, it shows the bytes that are read so far.
    #[must_use]
    pub fn stage(&self, what: impl Into<String>, total: u64) -> Stage {
        Stage {
            loading: self.clone(),
            what: what.into(),
            total,
            start: Instant::now(),
            done: AtomicU64::new(0),
            told: AtomicU64::new(0),
        }
    }
}

/// A stage of loading. The threads that work report to it.
#[derive(Debug)]
pub struct Stage {
    loading: Loading,
    what: String,
    total: u64,
    start: Instant,
    done: AtomicU64,
    /// The last reported progress, percent or megabytes.
    told: AtomicU64,
}

impl Stage {
    /// Notes that more steps are done.
    pub fn add(&self, steps: u64) {
        let done = self.done.fetch_add(steps, Ordering::Relaxed) + steps;
        self.show(done, self.total);
    }

    /// Shows `done` of `total` steps.
    pub fn show(&self, done: u64, total: u64) {
        let (now, unit) = measure(done, total);
        if self.told.swap(now, Ordering::Relaxed) != now {
            let left = time_left(self.start.elapsed(), done, total).unwrap_or_default();
            let text = format!("{}  {now} {unit}{left}", self.what);
            // Fails once the window is closed.
            let _ = self.loading.proxy.send_event((self.loading.event)(text));
        }
    }
}

/// The progress of a stage: percent, or the megabytes that are read.
fn measure(done: u64, total: u64) -> (u64, &'static str) {
    if total == 0 {
        return (done / MEGABYTE, "MB");
    }
    let percent = u128::from(done.min(total)) * 100 / u128::from(total);
    (percent as u64, "%")
}

/// How long the rest takes at the speed so far.
fn time_left(elapsed: Duration, done: u64, total: u64) -> Option<String> {
    if elapsed < GUESS || done == 0 || done >= total {
        return None;
    }
    let left = elapsed.as_secs_f64() * (total - done) as f64 / done as f64;
    Some(match left.ceil() {
        ..120.0 => format!(", {:.0} s left", left.ceil()),
        _ => format!(", {:.0} min left", left / 60.0),
    })
}

/// What the window shows, ready for tracing.
pub(super) struct Ready {
    pub options: Options,
    pub timeline: Arc<Timeline>,
    pub sources: Sources,
    pub host: Arc<dyn Host>,
}

/// Loads on another thread. Sends the result, `None` if `load` returned that; then, even if the thread panics,
/// [`Event::Loaded`].
pub(super) fn start(
    proxy: EventLoopProxy<Event>,
    load: impl FnOnce(&Loading) -> Option<Content> + Send + 'static,
) -> Receiver<Option<Ready>> {
    struct End(EventLoopProxy<Event>);
    impl Drop for End {
        fn drop(&mut self) {
            let _ = self.0.send_event(Event::Loaded);
        }
    }
    let (sender, results) = mpsc::channel();
    let end = End(proxy.clone());
    let loading = Loading {
        proxy,
        event: Event::Loading,
    };
    // Without a thread the end is reported at once.
    let _ = super::on_thread(move || {
        let _end = end;
        // Moved, so that even after a panic it is dropped before the end is reported.
        let sender = sender;
        let ready = load(&loading).map(|content| build(content, &loading));
        // Fails once the window is closed.
        let _ = sender.send(ready);
    });
    results
}

/// Builds the BVH of a scene, with progress.
pub(super) fn build_bvh(scene: &Scene, quality: BuildQuality, loading: &Loading) -> Bvh {
    let stage = loading.stage("building", 0);
    Bvh::build_watched(scene, quality, &|progress| {
        stage.show(progress.done, progress.total);
    })
}

fn build(content: Content, loading: &Loading) -> Ready {
    let Content {
        options,
        scene,
        sources,
        host,
    } = content;
    let bvh = build_bvh(&scene, options.quality, loading);
    Ready {
        options,
        timeline: Arc::new(Timeline::new(Model::new(scene, bvh))),
        sources,
        host,
    }
}

#[cfg(test)]
mod tests;

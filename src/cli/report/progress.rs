//! Progress bars, on a terminal only.

use super::grouped;
use crate::{cli::process::Interrupt, render::Progress, verify::Done};
use indicatif::{HumanBytes, ProgressBar, ProgressDrawTarget, ProgressStyle, WeakProgressBar};
use std::{
    ops::ControlFlow,
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicU64, Ordering},
        mpsc,
    },
    thread,
    time::{Duration, Instant},
};

/// A picture that is done sooner shows no bar, which would only flicker.
const PATIENCE: Duration = Duration::from_millis(200);
/// Redraws a second.
const RATE_HZ: u8 = 10;
/// How long a terminal may take to remove the bar when the process ends.
const CLEARING: Duration = Duration::from_millis(100);

/// The last bar that was made.
static LAST: Mutex<Option<WeakProgressBar>> = Mutex::new(None);

/// Removes the bar that is shown, if there is one, before a signal ends the process. A terminal that takes no output does not
/// keep it alive.
pub fn remove_bar() {
    let last = LAST.lock().unwrap_or_else(PoisonError::into_inner).take();
    let Some(bar) = last.and_then(|bar| bar.upgrade()) else {
        return;
    };
    let (done, cleared) = mpsc::channel();
    let clear = move || {
        bar.finish_and_clear();
        let _ = done.send(());
    };
    if thread::Builder::new().spawn(clear).is_ok() {
        let _ = cleared.recv_timeout(CLEARING);
    }
}

/// A bar that [`remove_bar`] removes.
fn remembered(bar: ProgressBar) -> ProgressBar {
    *LAST.lock().unwrap_or_else(PoisonError::into_inner) = Some(bar.downgrade());
    bar
}

/// Progress of a stage of work, with the time left. The threads that work report to it; another one draws it, also while
/// nothing is reported.
pub struct StageBar {
    /// What is done, before the bar.
    what: String,
    visible: bool,
    start: Instant,
    /// When the counted steps began.
    counted_from: Mutex<Instant>,
    done: AtomicU64,
    /// Steps in all. If that is 0, their number is unknown, and those that are done are bytes read.
    total: AtomicU64,
}

impl StageBar {
    /// A bar that [`Self::during`] shows if `visible`.
    pub fn new(visible: bool, what: impl Into<String>, total: u64) -> Self {
        let start = Instant::now();
        Self {
            what: what.into(),
            visible,
            start,
            counted_from: Mutex::new(start),
            done: AtomicU64::new(0),
            total: AtomicU64::new(total),
        }
    }

    /// Notes that more steps are done.
    pub fn add(&self, steps: u64) {
        self.done.fetch_add(steps, Ordering::Relaxed);
    }

    /// Notes that `done` of `total` steps are done. 0 begins other steps.
    pub fn show(&self, done: u64, total: u64) {
        if done == 0 {
            *self.counted_from.lock().unwrap_or_else(PoisonError::into_inner) = Instant::now();
        }
        self.done.store(done, Ordering::Relaxed);
        self.total.store(total, Ordering::Relaxed);
    }

    /// Shows the bar while this works, unless that is done soon.
    pub fn during<T>(&self, work: impl FnOnce() -> T) -> T {
        if !self.visible {
            return work();
        }
        thread::scope(|scope| {
            // Dropped even if the work panics, which ends the thread.
            let (_end, ended) = mpsc::channel();
            let draw = move || self.draw_until(&ended);
            // If the system refuses the thread, there is no bar.
            let _ = thread::Builder::new().spawn_scoped(scope, draw);
            work()
        })
    }

    fn draw_until(&self, ended: &mpsc::Receiver<()>) {
        let waits = |time| ended.recv_timeout(time) == Err(mpsc::RecvTimeoutError::Timeout);
        if !waits(PATIENCE) {
            return;
        }
        let target = ProgressDrawTarget::stderr_with_hz(2 * RATE_HZ);
        let bar = remembered(ProgressBar::with_draw_target(None, target).with_prefix(self.what.clone()));
        while {
            self.draw(&bar);
            waits(Duration::from_secs(1) / u32::from(RATE_HZ))
        } {}
        bar.finish_and_clear();
    }

    fn draw(&self, bar: &ProgressBar) {
        let [done, total] = [&self.done, &self.total].map(|steps| steps.load(Ordering::Relaxed));
        let (template, text) = if total == 0 {
            let seconds = self.start.elapsed().as_secs();
            let read = if done == 0 {
                String::new()
            } else {
                format!("{}  ", HumanBytes(done))
            };
            ("{prefix}  {msg}", format!("{read}{seconds} s"))
        } else {
            let from = *self.counted_from.lock().unwrap_or_else(PoisonError::into_inner);
            bar.set_length(total);
            bar.set_position(done);
            let left = time_left(from.elapsed(), done, total);
            ("{prefix}  {bar:40} {percent:>3} %  {msg}", format!("{left} left"))
        };
        // Cannot fail: the templates are constants.
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        bar.set_message(text);
        bar.tick();
    }
}

/// Progress of a picture. Reporting to it stops the rendering after an interrupt.
pub struct RenderBar<'a> {
    bar: StageBar,
    interrupt: &'a Interrupt,
}

impl<'a> RenderBar<'a> {
    /// A bar that [`Self::during`] shows if `visible`.
    pub fn new(visible: bool, interrupt: &'a Interrupt) -> Self {
        Self {
            bar: StageBar::new(visible, "rendering", 0),
            interrupt,
        }
    }

    /// Notes the progress; `Break` if rendering should stop.
    pub fn report(&self, progress: Progress) -> ControlFlow<()> {
        self.bar.show(progress.pixels_done, progress.pixels_total);
        if self.interrupt.requested() {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }

    /// As [`StageBar::during`].
    pub fn during<T>(&self, work: impl FnOnce() -> T) -> T {
        self.bar.during(work)
    }
}

/// The time left if the other steps take as long as those done. The first hundredth says too little.
fn time_left(elapsed: Duration, done: u64, total: u64) -> String {
    if done.saturating_mul(100) < total.max(1) {
        return "?".into();
    }
    let seconds = elapsed.as_secs_f64() * total.saturating_sub(done) as f64 / done as f64;
    // The cast saturates.
    match seconds.ceil() as u64 {
        seconds @ 0..60 => format!("{seconds} s"),
        seconds @ 60..3600 => format!("{}:{:02} min", seconds / 60, seconds % 60),
        seconds => format!("{}:{:02} h", seconds / 3600, seconds / 60 % 60),
    }
}

/// Progress of `octray verify`.
pub struct VerifyBar(Option<(ProgressBar, Option<u64>)>);

impl VerifyBar {
    /// A progress bar if `visible`; `rays` is the number of rays if it is limited.
    pub fn new(visible: bool, rays: Option<u64>) -> Self {
        Self(visible.then(|| {
            // Thousandths of the rays or of the time, whichever is further.
            let bar = ProgressBar::with_draw_target(Some(1000), ProgressDrawTarget::stderr());
            let style = ProgressStyle::with_template("{bar:40} {percent:>3} %  {msg}");
            // Cannot fail: the template is a constant.
            let bar = match style {
                Ok(style) => bar.with_style(style),
                Err(_) => bar,
            };
            (remembered(bar), rays)
        }))
    }

    /// Shows the progress.
    pub fn show(&self, done: Done, elapsed: Duration, limit: Option<Duration>) {
        let Some((bar, rays)) = &self.0 else { return };
        let of_rays = rays.map_or(0.0, |rays| done.rays as f64 / rays as f64);
        let of_time = limit.map_or(0.0, |limit| elapsed.as_secs_f64() / limit.as_secs_f64());
        bar.set_position((1000.0 * of_rays.max(of_time).min(1.0)) as u64);
        bar.set_message(format!("{} rays", grouped(done.rays)));
    }

    /// Removes the bar.
    pub fn clear(&self) {
        if let Some((bar, _)) = &self.0 {
            bar.finish_and_clear();
        }
    }
}

#[cfg(test)]
mod tests;

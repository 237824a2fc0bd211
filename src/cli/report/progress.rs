//! Progress bars, on a terminal only.

use super::grouped;
use crate::{cli::process::Interrupt, render::Progress, verify::Done};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle, WeakProgressBar};
use std::{
    fmt::Write,
    ops::ControlFlow,
    sync::{
        Mutex, OnceLock, PoisonError,
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

/// Progress of a stage of work, with the time left. The threads that work report to it.
pub struct StageBar {
    /// What is done, before the bar.
    what: String,
    /// Steps in all; 0 if unknown.
    total: u64,
    start: Instant,
    visible: bool,
    done: AtomicU64,
    shown: OnceLock<ProgressBar>,
}

impl StageBar {
    /// A bar that appears after a while, if `visible`.
    pub fn new(visible: bool, what: impl Into<String>, total: u64) -> Self {
        Self {
            what: what.into(),
            total,
            start: Instant::now(),
            visible,
            done: AtomicU64::new(0),
            shown: OnceLock::new(),
        }
    }

    /// Notes that more steps are done.
    pub fn add(&self, steps: u64) {
        let done = self.done.fetch_add(steps, Ordering::Relaxed) + steps;
        self.show(done, self.total);
    }

    /// Shows `done` of `total` steps.
    pub fn show(&self, done: u64, total: u64) {
        if self.visible && self.start.elapsed() > PATIENCE {
            self.shown
                .get_or_init(|| remembered(new_bar(&self.what, total)).with_elapsed(self.start.elapsed()))
                .set_position(done);
        }
    }

    /// Removes the bar.
    pub fn clear(&self) {
        if let Some(bar) = self.shown.get() {
            bar.finish_and_clear();
        }
    }
}

/// Progress of a picture. Reporting to it stops the rendering after an interrupt.
pub struct RenderBar<'a> {
    bar: StageBar,
    interrupt: &'a Interrupt,
}

impl<'a> RenderBar<'a> {
    /// A bar that appears after a while, if `visible`.
    pub fn new(visible: bool, interrupt: &'a Interrupt) -> Self {
        Self {
            bar: StageBar::new(visible, "", 0),
            interrupt,
        }
    }

    /// Shows the progress; `Break` if rendering should stop.
    pub fn report(&self, progress: Progress) -> ControlFlow<()> {
        self.bar.show(progress.pixels_done, progress.pixels_total);
        if self.interrupt.requested() {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }

    /// Removes the bar.
    pub fn clear(&self) {
        self.bar.clear();
    }
}

/// A bar of `total` steps; if that is 0, the bytes that are read so far.
fn new_bar(what: &str, total: u64) -> ProgressBar {
    let target = ProgressDrawTarget::stderr_with_hz(RATE_HZ);
    let (bar, template) = if total == 0 {
        (ProgressBar::with_draw_target(None, target), "{prefix}{bytes}")
    } else {
        let bar = ProgressBar::with_draw_target(Some(total), target);
        (bar, "{prefix}{bar:40} {percent:>3} %  {left}")
    };
    let bar = if what.is_empty() {
        bar
    } else {
        bar.with_prefix(format!("{what}  "))
    };
    match ProgressStyle::with_template(template) {
        // indicatif's own estimate would count the work before the bar appeared as done in no time.
        Ok(style) => bar.with_style(style.with_key(
            "left",
            move |state: &ProgressState, out: &mut dyn Write| {
                let left = time_left(state.elapsed(), state.pos(), total);
                let _ = write!(out, "{left} left");
            },
        )),
        // Cannot happen: the templates are constants.
        Err(_) => bar,
    }
}

/// The time left if the other steps take as long as those done.
fn time_left(elapsed: Duration, done: u64, total: u64) -> String {
    if done == 0 {
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

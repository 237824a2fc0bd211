//! A progress bar with the time left, on a terminal, where rendering takes a while.

use super::interrupt::Interrupt;
use crate::render::Progress;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use std::{
    fmt::Write,
    ops::ControlFlow,
    sync::{
        OnceLock,
        atomic::{AtomicU64, Ordering},
    },
    time::{Duration, Instant},
};

/// Pictures that are done sooner show no bar: it would only flicker.
const PATIENCE: Duration = Duration::from_millis(200);
/// Redraws a second.
const RATE_HZ: u8 = 10;

/// What the render threads report to.
pub struct Bar<'a> {
    start: Instant,
    visible: bool,
    shown: OnceLock<ProgressBar>,
    /// The most pixels that were done.
    pixels: AtomicU64,
    interrupt: &'a Interrupt,
}

impl<'a> Bar<'a> {
    /// A bar that appears later, if `visible`. Reporting to it stops the rendering after an interrupt.
    pub fn new(visible: bool, interrupt: &'a Interrupt) -> Self {
        Self {
            start: Instant::now(),
            visible,
            shown: OnceLock::new(),
            pixels: AtomicU64::new(0),
            interrupt,
        }
    }

    /// Shows where the rendering stands; `Break` if it should stop.
    pub fn report(&self, progress: Progress) -> ControlFlow<()> {
        self.pixels.fetch_max(progress.pixels_done, Ordering::Relaxed);
        if self.visible && self.start.elapsed() > PATIENCE {
            self.shown
                .get_or_init(|| new_bar(progress.pixels_total).with_elapsed(self.start.elapsed()))
                .set_position(progress.pixels_done);
        }
        if self.interrupt.requested() {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }

    /// Takes the bar away; how many pixels were done.
    pub fn clear(self) -> u64 {
        if let Some(bar) = self.shown.get() {
            bar.finish_and_clear();
        }
        self.pixels.into_inner()
    }
}

fn new_bar(pixels: u64) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(pixels), ProgressDrawTarget::stderr_with_hz(RATE_HZ));
    match ProgressStyle::with_template("{bar:40} {percent:>3} %  {left} left") {
        // indicatif's own estimate starts when the bar appears and takes what was done before for speed.
        Ok(style) => bar.with_style(style.with_key(
            "left",
            move |state: &ProgressState, out: &mut dyn Write| {
                let left = time_left(state.elapsed(), state.pos(), pixels);
                // Nothing better than an empty place is left to do.
                let _ = out.write_str(&left);
            },
        )),
        // The template is a constant; indicatif's own look would do as well.
        Err(_) => bar,
    }
}

/// How long the rest takes, if all pixels take as long as those that are done.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_left_is_in_proportion() {
        let left = |seconds, done| time_left(Duration::from_secs(seconds), done, 100);
        assert_eq!(left(1, 0), "?");
        assert_eq!(left(1, 10), "9 s");
        assert_eq!(left(10, 10), "1:30 min");
        assert_eq!(left(1000, 10), "2:30 h");
        assert_eq!(left(5, 100), "0 s");
    }
}

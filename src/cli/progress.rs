//! A progress bar with the time left, on a terminal, where rendering takes a while.

use super::interrupt::Interrupt;
use crate::render::Progress;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::{
    ops::ControlFlow,
    sync::OnceLock,
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
    bar: OnceLock<ProgressBar>,
    interrupt: &'a Interrupt,
}

impl<'a> Bar<'a> {
    /// A bar that appears later, if `visible`. Reporting to it stops the rendering after an interrupt.
    pub fn new(visible: bool, interrupt: &'a Interrupt) -> Self {
        Self {
            start: Instant::now(),
            visible,
            bar: OnceLock::new(),
            interrupt,
        }
    }

    /// Shows where the rendering stands; `Break` if it should stop.
    pub fn report(&self, progress: Progress) -> ControlFlow<()> {
        if self.visible && self.start.elapsed() > PATIENCE {
            self.bar
                .get_or_init(|| new_bar(progress.pixels_total).with_elapsed(self.start.elapsed()))
                .set_position(progress.pixels_done);
        }
        if self.interrupt.requested() {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }

    /// Takes the bar away.
    pub fn clear(self) {
        if let Some(bar) = self.bar.get() {
            bar.finish_and_clear();
        }
    }
}

fn new_bar(pixels: u64) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(pixels), ProgressDrawTarget::stderr_with_hz(RATE_HZ));
    match ProgressStyle::with_template("{bar:40} {percent:>3} %  {eta} left") {
        Ok(style) => bar.with_style(style),
        // The template is a constant; indicatif's own look would do as well.
        Err(_) => bar,
    }
}

//! Tests of `interrupt`.

use super::*;
use crate::{cli::report::RenderBar, render::Progress};
use std::ops::ControlFlow;

#[test]
fn a_signal_breaks_the_rendering_and_stops_what_follows() {
    let interrupt = Interrupt::default();
    let progress = Progress {
        pixels_done: 1,
        pixels_total: 2,
    };
    let bar = RenderBar::new(false, &interrupt);
    assert_eq!(bar.report(progress), ControlFlow::Continue(()));
    assert!(interrupt.check().is_ok());

    interrupt.requested.store(true, Ordering::Relaxed);
    assert_eq!(bar.report(progress), ControlFlow::Break(()));
    assert!(matches!(interrupt.check(), Err(CliError::Interrupted)));
}

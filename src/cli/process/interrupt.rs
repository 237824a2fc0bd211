//! Ctrl-C and other signals: they end the process at once, except where there is something to clean up.

use crate::cli::CliError;
#[cfg(feature = "viewer")]
use signal_hook::low_level;
use signal_hook::{consts, flag};
use std::sync::{
    Arc,
    atomic::{AtomicBool, AtomicUsize, Ordering},
};

#[cfg(unix)]
const SIGNALS: &[i32] = &[consts::SIGINT, consts::SIGTERM, consts::SIGHUP];
#[cfg(not(unix))]
const SIGNALS: &[i32] = &[consts::SIGINT, consts::SIGTERM];

/// Whether a signal has asked the program to stop.
#[derive(Debug, Default)]
pub struct Interrupt {
    requested: Arc<AtomicBool>,
    at_once: Arc<AtomicBool>,
    /// The last signal.
    signal: Arc<AtomicUsize>,
}

impl Interrupt {
    /// Takes over the signals: from now on they set a flag.
    pub fn install() -> Result<Self, CliError> {
        Self::install_with(|_| CliError::Interrupted.exit_code())
    }

    /// Takes over the signals for a window: they end the process at once, except during [`Self::hold_during`]. Ctrl-C is
    /// an interruption; the other signals close the window, which is no failure.
    #[cfg(feature = "viewer")]
    pub fn install_for_window() -> Result<Self, CliError> {
        let this = Self::install_with(|signal| match signal {
            consts::SIGINT => CliError::Interrupted.exit_code(),
            _ => 0,
        })?;
        this.at_once.store(true, Ordering::SeqCst);
        Ok(this)
    }

    fn install_with(exit_code: impl Fn(i32) -> u8) -> Result<Self, CliError> {
        let this = Self::default();
        let refused = |error| CliError::Failed(format!("cannot watch for signals: {error}"));
        for &signal in SIGNALS {
            // The handlers run in this order.
            let exit_code = i32::from(exit_code(signal));
            flag::register_conditional_shutdown(signal, exit_code, Arc::clone(&this.at_once))
                .and_then(|_| flag::register_usize(signal, Arc::clone(&this.signal), signal as usize))
                .and_then(|_| flag::register(signal, Arc::clone(&this.requested)))
                .map_err(refused)?;
        }
        // With a handler, exceeding the file size limit fails the write instead of killing the process, and the
        // temporary file is removed.
        #[cfg(unix)]
        flag::register(consts::SIGXFSZ, Arc::default()).map_err(refused)?;
        Ok(this)
    }

    /// Whether a signal has come.
    pub fn requested(&self) -> bool {
        self.requested.load(Ordering::Relaxed)
    }

    /// [`CliError::Interrupted`] if a signal has come.
    pub fn check(&self) -> Result<(), CliError> {
        if self.requested() {
            Err(CliError::Interrupted)
        } else {
            Ok(())
        }
    }

    /// Runs `work`, one at a time, to its end: a signal meanwhile ends the process afterwards.
    #[cfg(feature = "viewer")]
    pub fn hold_during<T>(&self, work: impl FnOnce() -> T) -> T {
        self.at_once.store(false, Ordering::SeqCst);
        let result = work();
        self.at_once.store(true, Ordering::SeqCst);
        if self.requested() {
            // Now it ends the process; if it cannot be sent, the window stays open.
            let _ = low_level::raise(self.signal.load(Ordering::SeqCst) as i32);
        }
        result
    }

    /// Runs `work` that leaves nothing to clean up: a signal ends the process at once.
    pub fn exit_at_once_during<T>(&self, work: impl FnOnce() -> T) -> Result<T, CliError> {
        self.at_once.store(true, Ordering::SeqCst);
        // A signal before this has only set the flag.
        self.check()?;
        let result = work();
        self.at_once.store(false, Ordering::SeqCst);
        Ok(result)
    }
}

#[cfg(test)]
mod tests {
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
        assert!(matches!(interrupt.exit_at_once_during(|| 5), Ok(5)));

        interrupt.requested.store(true, Ordering::Relaxed);
        assert_eq!(bar.report(progress), ControlFlow::Break(()));
        let late = interrupt.exit_at_once_during(|| panic!("done after the signal"));
        assert!(matches!(late, Err(CliError::Interrupted)));
    }
}

//! Ctrl-C and friends: a command that has something to clean up stops at its own pace, any other at once.

use super::CliError;
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

/// Whether a signal has asked us to stop.
#[derive(Debug, Default)]
pub struct Interrupt {
    requested: Arc<AtomicBool>,
    at_once: Arc<AtomicBool>,
    /// The signal that came last.
    signal: Arc<AtomicUsize>,
}

impl Interrupt {
    /// Takes over the signals: from now on they set a flag.
    pub fn install() -> Result<Self, CliError> {
        Self::install_with(|_| CliError::Interrupted.exit_code())
    }

    /// Takes over the signals for a window: at any time they end the process there and then, but for what
    /// [`Self::hold_during`] holds. What asks the window to close is no failure; Ctrl-C is an interruption, as elsewhere.
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
            // They run in this order.
            let exit_code = i32::from(exit_code(signal));
            flag::register_conditional_shutdown(signal, exit_code, Arc::clone(&this.at_once))
                .and_then(|_| flag::register_usize(signal, Arc::clone(&this.signal), signal as usize))
                .and_then(|_| flag::register(signal, Arc::clone(&this.requested)))
                .map_err(refused)?;
        }
        // A file above the process's size limit kills it, unless somebody listens: then the write fails,
        // and the temporary file is cleaned up.
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

    /// Forgets the signal: the next one counts as the first.
    pub fn forget(&self) {
        self.requested.store(false, Ordering::Relaxed);
    }

    /// Runs something that must not be cut off, one at a time: a signal that comes meanwhile ends the process afterwards.
    #[cfg(feature = "viewer")]
    pub fn hold_during<T>(&self, work: impl FnOnce() -> T) -> T {
        self.at_once.store(false, Ordering::SeqCst);
        let result = work();
        self.at_once.store(true, Ordering::SeqCst);
        if self.requested() {
            // It ends the process this time, or, if it cannot be sent, the window stays.
            let _ = low_level::raise(self.signal.load(Ordering::SeqCst) as i32);
        }
        result
    }

    /// Runs something that leaves nothing to clean up: a signal ends the process there and then.
    pub fn exit_at_once_during<T>(&self, work: impl FnOnce() -> T) -> Result<T, CliError> {
        self.at_once.store(true, Ordering::SeqCst);
        // A signal before the line above has only set the flag.
        self.check()?;
        let result = work();
        self.at_once.store(false, Ordering::SeqCst);
        Ok(result)
    }
}

#[cfg(test)]
mod tests {
    use super::super::progress::Bar;
    use super::*;
    use crate::render::Progress;
    use std::ops::ControlFlow;

    #[test]
    fn a_signal_breaks_the_rendering_and_stops_what_follows() {
        let interrupt = Interrupt::default();
        let progress = Progress {
            pixels_done: 1,
            pixels_total: 2,
        };
        let bar = Bar::new(false, &interrupt);
        assert_eq!(bar.report(progress), ControlFlow::Continue(()));
        assert!(matches!(interrupt.exit_at_once_during(|| 5), Ok(5)));

        interrupt.requested.store(true, Ordering::Relaxed);
        assert_eq!(bar.report(progress), ControlFlow::Break(()));
        let late = interrupt.exit_at_once_during(|| panic!("done after the signal"));
        assert!(matches!(late, Err(CliError::Interrupted)));
    }
}

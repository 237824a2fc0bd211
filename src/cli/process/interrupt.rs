//! Ctrl-C and other signals end the process soon, whatever it is doing, and leave no half-written file.
//!
//! Where signals can end a process, they do, once the temporary files are removed: a shell stops its loop at Ctrl-C only if
//! the program in it died of SIGINT.

use crate::cli::{CliError, report};
use signal_hook::{consts, flag};
use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    time::Duration,
};

#[cfg(unix)]
const SIGNALS: &[i32] = &[consts::SIGINT, consts::SIGTERM, consts::SIGHUP];
#[cfg(not(unix))]
const SIGNALS: &[i32] = &[consts::SIGINT, consts::SIGTERM];

/// How long work in small pieces may go on after a signal.
const MOMENT: Duration = Duration::from_millis(120);
/// How long a window may take to close after a signal.
#[cfg(all(unix, feature = "viewer"))]
const CLOSING: Duration = Duration::from_millis(300);

/// The signal that has come; 0 if none.
#[cfg(unix)]
static CAME: std::sync::atomic::AtomicI32 = std::sync::atomic::AtomicI32::new(0);

/// Whether a signal has asked the program to stop.
#[derive(Debug, Default)]
pub struct Interrupt {
    requested: Arc<AtomicBool>,
}

impl Interrupt {
    /// Handles signals. A signal first sets this flag, so that work in small pieces can end with partial results; if it has not
    /// ended after a moment, or at a second signal, the signal ends the process.
    ///
    /// # Errors
    /// [`CliError::Failed`] if the system does not allow it.
    pub fn install() -> Result<Self, CliError> {
        Self::install_with(MOMENT)
    }

    /// [`install`](Self::install) for work whose pieces take up to `patience`.
    ///
    /// # Errors
    /// [`CliError::Failed`] if the system does not allow it.
    pub fn install_with(patience: Duration) -> Result<Self, CliError> {
        let this = Self::default();
        watch(&this.requested, patience, || {})?;
        #[cfg(unix)]
        heed_file_size()?;
        Ok(this)
    }

    /// Handles signals for a window: the first one calls `close`, and the program has a moment to write what it has. On
    /// other systems than Unix the first signal ends the process.
    ///
    /// # Errors
    /// [`CliError::Failed`] if the system does not allow it.
    #[cfg(feature = "viewer")]
    pub fn of_window(close: impl Fn() + Send + 'static) -> Result<Self, CliError> {
        let this = Self::default();
        #[cfg(unix)]
        watch(&this.requested, CLOSING, close)?;
        #[cfg(not(unix))]
        watch(&Arc::default(), Duration::ZERO, close)?;
        #[cfg(unix)]
        heed_file_size()?;
        Ok(this)
    }

    /// Whether a signal has come.
    pub fn requested(&self) -> bool {
        self.requested.load(Ordering::Acquire)
    }

    /// [`CliError::Interrupted`] if a signal has come.
    pub fn check(&self) -> Result<(), CliError> {
        if self.requested() {
            Err(CliError::Interrupted)
        } else {
            Ok(())
        }
    }
}

/// Ends the process by the signal that has come, after an orderly stop; returns if none has come.
#[cfg(unix)]
pub fn end_by_signal() {
    match CAME.load(Ordering::Relaxed) {
        0 => {}
        signal => die_of(signal),
    }
}

/// Other systems have exit codes only.
#[cfg(not(unix))]
pub fn end_by_signal() {
    report::remove_bar();
}

/// With a handler, exceeding the file size limit fails the write instead of killing the process, and the temporary file is
/// removed.
#[cfg(unix)]
fn heed_file_size() -> Result<(), CliError> {
    let heard = flag::register(consts::SIGXFSZ, Arc::default());
    heard.map(drop).map_err(refused)
}

#[allow(clippy::needless_pass_by_value, reason = "map_err's argument")]
fn refused(error: std::io::Error) -> CliError {
    CliError::Failed(format!("cannot watch for signals: {error}"))
}

/// Whether the end of the terminal is ignored, as `nohup` has it: then it stays so. (Shells have their background jobs ignore
/// Ctrl-C, which octray hears nevertheless.)
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    signal == consts::SIGHUP && mask.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

/// Ends the process by the default action of a signal.
#[cfg(unix)]
fn die_of(signal: i32) -> ! {
    use signal_hook::low_level;
    report::remove_bar();
    // The first process of a container has no default actions.
    if std::process::id() != 1 {
        let _ = low_level::emulate_default_handler(signal);
    }
    low_level::exit(128 + signal)
}

/// Sets `requested` and calls `tell` when a signal comes. After `patience`, or at a second signal, the signal ends the process.
#[cfg(unix)]
fn watch(
    requested: &Arc<AtomicBool>,
    patience: Duration,
    tell: impl Fn() + Send + 'static,
) -> Result<(), CliError> {
    use signal_hook::iterator::Signals;
    use std::{thread, time::Instant};

    const POLL: Duration = Duration::from_millis(20);
    /// The thread only sleeps and removes files.
    const STACK_BYTES: usize = 1 << 17;

    let heard = SIGNALS.iter().filter(|&&signal| !is_ignored(signal));
    let mut signals = Signals::new(heard).map_err(refused)?;
    let requested = Arc::clone(requested);
    let wait = move || {
        if let Some(signal) = signals.forever().next() {
            CAME.store(signal, Ordering::Relaxed);
            requested.store(true, Ordering::Release);
            tell();
            let start = Instant::now();
            while start.elapsed() < patience && signals.pending().next().is_none() {
                thread::sleep(POLL);
            }
            crate::whole_file::abandon();
            die_of(signal);
        }
    };
    let thread = thread::Builder::new()
        .name("signals".into())
        .stack_size(STACK_BYTES);
    thread.spawn(wait).map(drop).map_err(refused)
}

/// On other systems the first signal sets the flag, and the second one ends the process.
#[cfg(not(unix))]
fn watch(requested: &Arc<AtomicBool>, patience: Duration, _tell: impl Fn()) -> Result<(), CliError> {
    let exit_code = CliError::Interrupted.exit_code();
    requested.store(patience.is_zero(), Ordering::Relaxed);
    for &signal in SIGNALS {
        // The handlers run in this order.
        flag::register_conditional_shutdown(signal, exit_code.into(), Arc::clone(requested))
            .and_then(|_| flag::register(signal, Arc::clone(requested)))
            .map_err(refused)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests;

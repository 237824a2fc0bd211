//! Thread pools, and calls that Ctrl-C ends.

use octray::QueryError;
use pyo3::{
    exceptions::{PyRuntimeError, PyValueError},
    prelude::*,
};
use rayon::{ThreadPool, ThreadPoolBuilder, prelude::*};
use std::{
    ops::Range,
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicBool, AtomicU32, AtomicUsize, Ordering},
    },
    thread::{self, Thread},
    time::{Duration, Instant},
};

/// How often a long call checks for Ctrl-C.
const POLL: Duration = Duration::from_millis(20);

/// How long a thread may work between two checks.
const STEP: Duration = Duration::from_millis(100);

/// How often a waiting call checks whether its turn has come.
const TURN: Duration = Duration::from_millis(1);

/// Rays per task, the number that the library traces at a time.
pub const PART: usize = 1 << 14;
/// The same for all hits of rays: some take a thousand times as long. Cancellation is noticed between tasks.
pub const SMALL_PART: usize = 1 << 8;

/// The process and the threads of all meshes without a number of threads. A forked process has none of its parent's threads,
/// so that it starts new ones.
static SHARED: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

fn start(threads: usize) -> PyResult<Arc<ThreadPool>> {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map(Arc::new)
        .map_err(|error| PyValueError::new_err(format!("{threads} threads cannot be started: {error}")))
}

/// The number of threads in `OCTRAY_THREADS`; 0 for one per core.
fn named_number() -> PyResult<usize> {
    match std::env::var("OCTRAY_THREADS") {
        Err(_) => Ok(0),
        Ok(text) => match text.parse::<usize>() {
            Ok(threads) if (1..=MOST_THREADS).contains(&threads) => Ok(threads),
            _ => Err(PyValueError::new_err(format!(
                "OCTRAY_THREADS is {text:?}, expected a number from 1 to {MOST_THREADS}"
            ))),
        },
    }
}

/// More threads than any machine has cores.
pub const MOST_THREADS: usize = 4096;

/// The threads of a mesh, in whichever process it is used.
pub struct Threads {
    /// `None` for the shared ones.
    pub own: Option<usize>,
    started: Mutex<Option<(u32, Arc<ThreadPool>)>>,
}

impl Threads {
    pub fn new(own: Option<usize>) -> PyResult<Self> {
        let threads = Self {
            own,
            started: Mutex::new(None),
        };
        threads.pool().map(|_| threads)
    }

    /// Returns the threads of this process.
    pub fn pool(&self) -> PyResult<Arc<ThreadPool>> {
        let place = if self.own.is_some() {
            &self.started
        } else {
            &SHARED
        };
        let mut place = place.lock().unwrap_or_else(PoisonError::into_inner);
        let process = std::process::id();
        if let Some((owner, pool)) = &*place
            && *owner == process
        {
            return Ok(Arc::clone(pool));
        }
        let pool = start(match self.own {
            Some(threads) => threads,
            None => named_number()?,
        })?;
        if let Some(parents) = place.replace((process, Arc::clone(&pool))) {
            // Its threads are in the parent process: dropping the pool would wake threads that do not exist here.
            std::mem::forget(parents);
        }
        Ok(pool)
    }
}

/// A lock for one call at a time. A forked process finds it free, whatever its parent did.
#[derive(Default)]
pub struct Turns {
    /// The process that holds it; 0 for none.
    process: AtomicU32,
    /// The thread of that process, by [`this_thread`]; 0 for none.
    thread: AtomicUsize,
}

/// A turn, until it is dropped.
pub struct Turn<'a>(&'a Turns);

/// A number of this thread, not 0.
fn this_thread() -> usize {
    static NEXT: AtomicUsize = AtomicUsize::new(1);
    thread_local!(static OWN: usize = NEXT.fetch_add(1, Ordering::Relaxed));
    OWN.with(|own| *own)
}

impl Turns {
    /// Waits for a turn; `what` is said if this thread has it.
    ///
    /// # Errors
    /// `RuntimeError` if this thread has the turn: a signal handler that waited would wait for itself.
    /// `KeyboardInterrupt`, or what another signal handler raises.
    pub fn take(&self, py: Python<'_>, what: &str) -> PyResult<Turn<'_>> {
        let own = std::process::id();
        loop {
            let holder = self.process.load(Ordering::Relaxed);
            let change = |holder| {
                self.process
                    .compare_exchange(holder, own, Ordering::Acquire, Ordering::Relaxed)
            };
            if holder != own && change(holder).is_ok() {
                self.thread.store(this_thread(), Ordering::Relaxed);
                return Ok(Turn(self));
            }
            if holder == own && self.thread.load(Ordering::Relaxed) == this_thread() {
                return Err(PyRuntimeError::new_err(format!(
                    "{what} (called from a signal handler?)"
                )));
            }
            py.detach(|| thread::sleep(TURN));
            py.check_signals()?;
        }
    }
}

impl Drop for Turn<'_> {
    fn drop(&mut self) {
        self.0.thread.store(0, Ordering::Relaxed);
        self.0.process.store(0, Ordering::Release);
    }
}

/// Returns the shared threads of this process.
pub fn shared() -> PyResult<Arc<ThreadPool>> {
    Threads::new(None)?.pool()
}

/// Wakes the thread that waits for some work when it is dropped: at the work's end, after a panic too.
struct End<'a> {
    is_over: &'a AtomicBool,
    waiting: Thread,
}

impl Drop for End<'_> {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
        self.waiting.unpark();
    }
}

/// Runs `work` on a thread of the pool, without the interpreter's lock, while this thread watches for Ctrl-C: `work` checks
/// the flag from time to time and ends early.
///
/// # Errors
/// `KeyboardInterrupt`, or what another signal handler raises.
pub fn interruptible<T: Send>(
    py: Python<'_>,
    pool: &ThreadPool,
    work: impl FnOnce(&AtomicBool) -> T + Send,
) -> PyResult<T> {
    let (cancelled, is_over) = (AtomicBool::new(false), AtomicBool::new(false));
    let (mut interrupted, mut done) = (Ok(()), None);
    py.detach(|| {
        let (cancelled, is_over, done) = (&cancelled, &is_over, &mut done);
        let waiting = thread::current();
        pool.in_place_scope(|scope| {
            scope.spawn(move |_| {
                let _end = End { is_over, waiting };
                *done = Some(work(cancelled));
            });
            while !is_over.load(Ordering::Relaxed) {
                thread::park_timeout(POLL);
                if interrupted.is_ok() && !is_over.load(Ordering::Relaxed) {
                    interrupted = Python::attach(|py| py.check_signals());
                    cancelled.store(interrupted.is_err(), Ordering::Relaxed);
                }
            }
        });
    });
    interrupted?;
    // A panic has gone on from the scope.
    Ok(done.expect("the work is done"))
}

/// The number of rays that are answered between two checks: small at first, then what [`STEP`] has time for. In most meshes
/// that is a whole part; where thousands of triangles overlap, a ray may take milliseconds.
pub struct Pace(AtomicUsize);

impl Default for Pace {
    fn default() -> Self {
        Self(AtomicUsize::new(SMALL_PART))
    }
}

impl Pace {
    /// Calls `ask` with one range of `answers` after the other, until the call is cancelled.
    pub fn steps<T>(
        &self,
        answers: &mut [T],
        cancelled: &AtomicBool,
        ask: impl Fn(Range<usize>, &mut [T]) -> Result<(), QueryError>,
    ) -> Result<(), QueryError> {
        let mut start = 0;
        while start < answers.len() && !cancelled.load(Ordering::Relaxed) {
            let end = answers.len().min(start + self.0.load(Ordering::Relaxed));
            let before = Instant::now();
            ask(start..end, &mut answers[start..end])?;
            let steps = STEP.as_secs_f64() / before.elapsed().as_secs_f64().max(1e-9);
            let next = ((end - start) as f64 * steps) as usize;
            self.0.store(next.max(16), Ordering::Relaxed);
            start = end;
        }
        Ok(())
    }
}

/// Calls `ask` with parts of `answers` and their ranges, on all threads of the pool, until the call is cancelled.
/// Threads wait for each other only at the end, so that a core taken by another program delays the others little.
pub fn in_parts<T: Send>(
    answers: &mut [T],
    part: usize,
    cancelled: &AtomicBool,
    ask: impl Fn(Range<usize>, &mut [T]) -> Result<(), QueryError> + Sync,
) -> Result<(), QueryError> {
    let parts = answers.par_chunks_mut(part).enumerate();
    parts.try_for_each(|(i, answers)| {
        if cancelled.load(Ordering::Relaxed) {
            return Ok(());
        }
        ask(i * part..i * part + answers.len(), answers)
    })
}

//! The threads of rayon's global pool, each pinned to a CPU if there are as many threads as CPUs.
//!
//! Unpinned, Linux often wakes two of them on one CPU of a virtual machine, because it mistakes a halted CPU for a busy one.
//! Tuned: see docs/lab-notes.md#pinned-threads

use crate::cli::{CliError, load::memory};
use rayon::ThreadPoolBuilder;
use std::{
    env,
    error::Error,
    sync::atomic::{AtomicBool, Ordering},
    thread,
};

/// More threads than this for each CPU gain nothing ...
const MOST_OF_CPU: usize = 4;
/// ... but up to this many are started if requested.
const ALWAYS_ALLOWED: usize = 64;

/// Starts the threads, unless they are started: the number in `RAYON_NUM_THREADS`, by default one for each CPU. On its own,
/// rayon would start them when first needed, and panic if that fails.
///
/// # Errors
/// [`CliError::Failed`] if the system refuses.
pub fn start() -> Result<(), CliError> {
    static STARTED: AtomicBool = AtomicBool::new(false);
    if STARTED.swap(true, Ordering::Relaxed) {
        return Ok(());
    }
    let asked = env::var("RAYON_NUM_THREADS").ok();
    let asked = asked
        .and_then(|number| number.parse::<u32>().ok())
        .filter(|&number| number > 0);
    let threads = useful(asked.unwrap_or(cpus() as u32)) as usize;
    let started = each_on_its_own_cpu(ThreadPoolBuilder::new().num_threads(threads)).build_global();
    started.map_err(|error| {
        let why = error
            .source()
            .map_or_else(|| error.to_string(), ToString::to_string);
        CliError::Failed(format!("cannot start threads: {why}"))
    })
}

/// The requested number of threads, limited to what is useful and fits into memory: the picture is the same. A thread
/// without memory for its start would end the process.
pub fn useful(asked: u32) -> u32 {
    let most = (MOST_OF_CPU * cpus()).max(ALWAYS_ALLOWED);
    let room = memory::room_for_threads();
    asked.min(u32::try_from(most).unwrap_or(u32::MAX)).min(room)
}

fn cpus() -> usize {
    thread::available_parallelism().map_or(1, usize::from)
}

/// Pins each thread to a CPU, if there are as many CPUs as threads.
#[cfg(target_os = "linux")]
fn each_on_its_own_cpu(pool: ThreadPoolBuilder) -> ThreadPoolBuilder {
    use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};
    let Ok(allowed) = sched_getaffinity(None) else {
        // More CPUs than `CpuSet` holds.
        return pool;
    };
    let mut cpus: Vec<usize> = (0..CpuSet::MAX_CPU).filter(|&cpu| allowed.is_set(cpu)).collect();
    // For small work rayon wakes the first threads only: those of several processes should not share a CPU.
    let first = std::process::id() as usize % cpus.len().max(1);
    cpus.rotate_left(first);
    pool.start_handler(move |thread_i| {
        if rayon::current_num_threads() == cpus.len() {
            let mut own = CpuSet::new();
            own.set(cpus[thread_i]);
            // Fails if the CPU has gone since; the thread stays unpinned.
            let _ = sched_setaffinity(None, &own);
        }
    })
}

/// Elsewhere threads are not pinned.
#[cfg(not(target_os = "linux"))]
fn each_on_its_own_cpu(pool: ThreadPoolBuilder) -> ThreadPoolBuilder {
    pool
}

#[cfg(all(test, target_os = "linux"))]
mod tests;

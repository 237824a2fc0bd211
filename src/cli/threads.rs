//! The threads of rayon's global pool, which most of what is parallel runs on.
//!
//! Where there is one for each CPU, each keeps to its own. Left to the system they are woken on any: Linux takes an
//! idle CPU of a virtual machine for a busy one (its host has halted it), wakes two threads on one, and moves one of
//! them milliseconds later. (Frames of 1920x1080 of the course's reflections.scn, 17 to 23 ms each, on an EPYC Zen 3
//! virtual machine with nothing else to do: two threads left to the system were 1.47 to 1.52 times as fast as one, with
//! spreads of 35 to 56 %; so they are 1.94 to 1.96 times as fast, with 3 to 8 %. Beside a program that kept a CPU busy,
//! and with four processes at a time, there was no difference.)

use rayon::{ThreadPoolBuildError, ThreadPoolBuilder};

/// Starts them. Left to itself, rayon starts them where it first needs them, and panics where the system has none to
/// give.
///
/// # Errors
/// [`ThreadPoolBuildError`], where it has none.
pub fn start() -> Result<(), ThreadPoolBuildError> {
    each_on_its_own_cpu(ThreadPoolBuilder::new()).build_global()
}

/// Threads that keep to a CPU each, if there are as many as CPUs that the process may use.
#[cfg(target_os = "linux")]
fn each_on_its_own_cpu(pool: ThreadPoolBuilder) -> ThreadPoolBuilder {
    use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};
    let Ok(allowed) = sched_getaffinity(None) else {
        // More CPUs than there is room for.
        return pool;
    };
    let mut cpus: Vec<usize> = (0..CpuSet::MAX_CPU).filter(|&cpu| allowed.is_set(cpu)).collect();
    // Where little is to be done, rayon wakes the first threads: those of several processes should not meet on one CPU.
    let first = std::process::id() as usize % cpus.len().max(1);
    cpus.rotate_left(first);
    pool.start_handler(move |thread_i| {
        if rayon::current_num_threads() == cpus.len() {
            let mut own = CpuSet::new();
            own.set(cpus[thread_i]);
            // A CPU that has gone since: the thread stays free.
            let _ = sched_setaffinity(None, &own);
        }
    })
}

/// Elsewhere they are left to the system.
#[cfg(not(target_os = "linux"))]
fn each_on_its_own_cpu(pool: ThreadPoolBuilder) -> ThreadPoolBuilder {
    pool
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;
    use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};

    /// The CPUs that the process may use, and a function that tells those of each of so many threads. `None` where the
    /// system does not say, or does not let threads choose.
    fn cpus() -> Option<(CpuSet, impl Fn(usize) -> Vec<CpuSet>)> {
        let allowed = sched_getaffinity(None).ok();
        let Some(allowed) = allowed.filter(|allowed| sched_setaffinity(None, allowed).is_ok()) else {
            println!("skipped: CPUs cannot be chosen here");
            return None;
        };
        let of_each = |threads: usize| {
            let pool = each_on_its_own_cpu(ThreadPoolBuilder::new().num_threads(threads));
            let pool = pool.build().expect("threads");
            pool.broadcast(|_| sched_getaffinity(None).expect("as before"))
        };
        Some((allowed, of_each))
    }

    #[test]
    fn as_many_threads_as_cpus_have_one_each() {
        let Some((allowed, of_each)) = cpus() else { return };
        let mut used = CpuSet::new();
        for own in of_each(allowed.count() as usize) {
            assert_eq!(own.count(), 1);
            let cpu = (0..CpuSet::MAX_CPU).find(|&cpu| own.is_set(cpu));
            used.set(cpu.expect("one"));
        }
        assert!(used == allowed, "{used:?} of {allowed:?}");
    }

    #[test]
    fn fewer_or_more_threads_are_free() {
        let Some((allowed, of_each)) = cpus() else { return };
        let count = allowed.count() as usize;
        for threads in [1, count + 1].into_iter().filter(|&threads| threads != count) {
            assert!(of_each(threads).iter().all(|own| *own == allowed));
        }
    }
}

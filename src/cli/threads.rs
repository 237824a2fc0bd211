//! The threads that everything runs on.
//!
//! Where there is one for each CPU, each keeps to its own. Left to the system they are woken on any: Linux takes an idle
//! CPU of a virtual machine for a busy one (its host has halted it), wakes two threads on one, and moves one of them
//! milliseconds later. (Two threads, frames of 1920x1080 of the course's reflections.scn in 20 to 30 ms, on an EPYC Zen 3
//! virtual machine with nothing else to do: 1.47 to 1.52 times as fast as one left to the system, with spreads of 35 to
//! 56 %; 1.94 to 1.96 times so, with 3 to 8 %.) Beside other programs nothing is lost that tiles do not make good:
//! threads take them from each other.

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
    let cpus: Vec<usize> = (0..CpuSet::MAX_CPU).filter(|&cpu| allowed.is_set(cpu)).collect();
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
    use rustix::thread::{CpuSet, sched_getaffinity};

    /// The CPUs that each of so many threads may use.
    fn cpus_of(threads: usize) -> Vec<CpuSet> {
        let pool = each_on_its_own_cpu(ThreadPoolBuilder::new().num_threads(threads));
        let pool = pool.build().expect("threads");
        pool.broadcast(|_| sched_getaffinity(None).expect("affinity"))
    }

    #[test]
    fn as_many_threads_as_cpus_have_one_each() {
        let allowed = sched_getaffinity(None).expect("affinity");
        let count = allowed.count() as usize;
        let mut used = CpuSet::new();
        for own in cpus_of(count) {
            assert_eq!(own.count(), 1);
            let cpu = (0..CpuSet::MAX_CPU).find(|&cpu| own.is_set(cpu));
            used.set(cpu.expect("one"));
        }
        assert!(used == allowed, "{used:?} of {allowed:?}");
    }

    #[test]
    fn fewer_or_more_threads_are_free() {
        let allowed = sched_getaffinity(None).expect("affinity");
        for threads in [1, allowed.count() as usize + 1] {
            if threads == allowed.count() as usize {
                continue;
            }
            assert!(cpus_of(threads).iter().all(|own| *own == allowed));
        }
    }
}

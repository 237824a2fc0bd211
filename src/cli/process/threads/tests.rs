use super::*;
use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};

/// The CPUs that the process may use, and a function that returns the set of each thread. `None` if the
/// system does not support pinning.
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
fn fewer_or_more_threads_are_not_pinned() {
    let Some((allowed, of_each)) = cpus() else { return };
    let count = allowed.count() as usize;
    for threads in [1, count + 1].into_iter().filter(|&threads| threads != count) {
        assert!(of_each(threads).iter().all(|own| *own == allowed));
    }
}

//! A build for every x86-64 CPU hands over to one for newer CPUs, where that lies beside it and the CPU can run it.
//!
//! `.ci/portable` makes such a pair. The instruction set of the kernels is chosen when they are compiled (only AVX-512 is
//! chosen at run time, in builds with multiply-add), so that a portable program is two programs. Handing over replaces
//! the process: signals, standard streams and the exit code are those of one program. Unix only.

use std::{env, os::unix::process::CommandExt, path::PathBuf, process::Command};

/// What the newer build's file is called, after this one's name.
const SUFFIX: &str = "-x86-64-v3";

/// The newer build, if it exists and runs on this CPU.
fn newer() -> Option<PathBuf> {
    let runs = is_x86_feature_detected!("avx2")
        && is_x86_feature_detected!("fma")
        && is_x86_feature_detected!("bmi1")
        && is_x86_feature_detected!("bmi2")
        && is_x86_feature_detected!("lzcnt")
        && is_x86_feature_detected!("movbe")
        && is_x86_feature_detected!("f16c");
    let this = env::current_exe().ok()?;
    let name = this.file_name()?.to_str()?;
    // A copy under the newer build's name would hand over to itself.
    if !runs || name.ends_with(SUFFIX) {
        return None;
    }
    let newer = this.with_file_name(format!("{name}{SUFFIX}"));
    newer.is_file().then_some(newer)
}

/// Becomes the newer build, if there is one. Returns if the newer build is missing or cannot be started.
pub fn hand_over() {
    let Some(newer) = newer() else { return };
    let mut arguments = env::args_os();
    let mut command = Command::new(newer);
    if let Some(name) = arguments.next() {
        command.arg0(name);
    }
    // It only comes back with an error, and then this build does as well.
    let _ = command.args(arguments).exec();
}

//! On a CPU that lacks the build's instructions (emulated here) the program says so instead of crashing.
#![cfg(all(target_arch = "x86_64", target_os = "linux"))]

use std::process::{Command, Output};

/// Runs the program under qemu's user-mode emulation; `None` where that is not installed.
fn emulated(cpu: &str) -> Option<Output> {
    let output = Command::new("qemu-x86_64")
        .args(["-cpu", cpu, env!("CARGO_BIN_EXE_octray"), "--version"])
        .output();
    if output.is_err() {
        println!("skipped: this needs `qemu-x86_64` (Debian: qemu-user)");
    }
    output.ok()
}

/// Standard error without the emulator's warnings about features that it lacks.
fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr)
        .lines()
        .filter(|line| !line.starts_with("qemu-x86_64: warning:"))
        .map(|line| format!("{line}\n"))
        .collect()
}

#[test]
fn an_old_cpu_is_refused() {
    if !cfg!(target_feature = "avx2") {
        println!("skipped: this build needs nothing that an old CPU lacks");
        return;
    }
    // No AVX, AVX without AVX2, one feature missing, no support by the operating system.
    for cpu in [
        "Nehalem",
        "SandyBridge",
        "core2duo",
        "qemu64",
        "Haswell,-bmi2",
        "Haswell,-abm",
        "Haswell,-xsave",
    ] {
        let Some(output) = emulated(cpu) else {
            return;
        };
        let stderr = stderr(&output);
        assert_eq!(output.status.code(), Some(4), "{cpu}: {output:?}");
        assert!(
            stderr.starts_with("error: this build needs a CPU with "),
            "{cpu}: {stderr}"
        );
        assert_eq!(stderr.lines().count(), 1, "{cpu}: {stderr}");
        assert!(output.stdout.is_empty());
    }
}

#[test]
fn a_new_enough_cpu_runs() {
    if cfg!(any(
        target_feature = "avx512f",
        target_feature = "adx",
        target_feature = "gfni"
    )) {
        println!("skipped: this build needs more than the emulator has");
        return;
    }
    for cpu in ["Haswell", "max"] {
        let Some(output) = emulated(cpu) else {
            return;
        };
        assert_eq!(output.status.code(), Some(0), "{cpu}: {output:?}");
        assert!(String::from_utf8_lossy(&output.stdout).starts_with("octray "));
    }
}

//! Signals end the program at once, without partial files, and as the system's default action would.
#![cfg(unix)]

use crate::program::{Folder, PROGRAM, Run, send_signal};
use std::{
    os::unix::process::CommandExt,
    process::Command,
    thread::sleep,
    time::{Duration, Instant},
};

/// A billion camera rays.
const LONG: [&str; 8] = [
    "a.scn",
    "--size",
    "1000x1000",
    "--samples",
    "1024",
    "--mode",
    "scalar",
    "--threads=2",
];

/// Whether the tests run under `nohup`, and octray ignores SIGHUP.
pub fn is_nohup() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask & 1 == 1)
}

/// The signals that end octray, as `kill` takes them.
pub fn ending() -> impl Iterator<Item = &'static str> {
    let hang_up = (!is_nohup()).then_some("-HUP");
    ["-INT", "-TERM"].into_iter().chain(hang_up)
}

#[cfg(target_os = "linux")]
#[test]
fn nohup_is_heeded() {
    let folder = Folder::new();
    let mut nohup = folder.any_command("nohup", &[PROGRAM]);
    let Ok(mut child) = nohup.args(LONG).args(["-o", "a.png"]).spawn() else {
        println!("skipped: this needs `nohup`");
        return;
    };
    sleep(Duration::from_millis(400));
    send_signal(&child, "-HUP");
    sleep(Duration::from_millis(400));
    assert!(child.try_wait().unwrap().is_none(), "it ended");
    send_signal(&child, "-TERM");
    child.wait().unwrap();
}

#[test]
fn signals_leave_nothing() {
    let folder = Folder::new();
    for name in ending() {
        let child = folder.command(&LONG).spawn().unwrap();
        sleep(Duration::from_millis(400));
        let start = Instant::now();
        send_signal(&child, name);
        let run = Run::new(child.wait_with_output().unwrap());
        run.died_of(name);
        let took = start.elapsed();
        assert!(took < Duration::from_secs(5), "{name}: {took:?}");
        assert_eq!(folder.names(), ["a.scn"], "{name}");
    }
}

/// Also where the work does not stop by itself soon enough.
#[test]
fn signals_leave_no_progress_bar() {
    let folder = Folder::new();
    let command = format!("timeout -s TERM 1 '{PROGRAM}' {} -o a.png", LONG.join(" "));
    let Ok(output) = folder
        .any_command("script", &["-qec", &command, "/dev/null"])
        .output()
    else {
        println!("skipped: this needs `script`");
        return;
    };
    let shown = String::from_utf8_lossy(&output.stdout);
    let after = shown.rsplit_once("left").map_or("\x1b[2K", |(_, after)| after);
    assert!(after.contains("\x1b[2K"), "{shown}");
}

/// bash goes on with its loop after a program that handled Ctrl-C and exited, even with 130.
#[cfg(target_os = "linux")]
#[test]
fn ctrl_c_stops_a_loop_of_the_shell() {
    let folder = Folder::new();
    let script = format!(
        "for i in 1 2 3; do '{PROGRAM}' {} -o $i.png; echo next; done",
        LONG.join(" ")
    );
    // A shell passes an ignored signal on to its background jobs, such as these tests.
    let mut bash = folder.any_command("env", &["--default-signal=INT", "bash", "-c", &script]);
    // Ctrl-C reaches the shell and the program.
    let Ok(child) = bash.process_group(0).spawn() else {
        println!("skipped: this needs `env`");
        return;
    };
    sleep(Duration::from_millis(600));
    let group = format!("-{}", child.id());
    let sent = Command::new("kill").args(["-INT", "--", &group]).status();
    assert!(sent.unwrap().success());
    let run = Run::new(child.wait_with_output().unwrap());
    run.died_of("-INT");
    assert_eq!((run.text(), folder.names()), ("", vec!["a.scn".to_owned()]));
}

#[test]
fn a_signal_while_generating_leaves_no_partial_file() {
    let folder = Folder::new();
    for wait in [50, 200, 600] {
        let child = folder
            .command(&["generate", "terrain", "--count", "1000000"])
            .spawn()
            .unwrap();
        sleep(Duration::from_millis(wait));
        send_signal(&child, "-TERM");
        let run = Run::new(child.wait_with_output().unwrap());
        if run.code != Some(0) {
            run.died_of("-TERM");
        }
        for name in folder.names() {
            assert!(
                ["a.scn", "terrain.ply", "terrain.scn"].contains(&&*name),
                "{name}"
            );
        }
    }
}

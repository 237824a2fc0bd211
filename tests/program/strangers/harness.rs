//! Runs the program and checks what every call promises: time, memory, and what it says.

use crate::program::Folder;
use std::{
    fs::File,
    io::{self, Read, Seek},
    os::unix::process::ExitStatusExt,
    process::{ExitStatus, Stdio},
    time::{Duration, Instant},
};

/// The memory limit of a call that names none, as a number and as an option.
const MEMORY: (u64, &str) = (300 << 20, "300M");
/// What may be taken beside it, bytes: the program itself, stacks, the allocator's free lists.
const BESIDE: u64 = 64 << 20;
/// No call on a small file takes longer.
const MOST_TIME: Duration = Duration::from_secs(10);
/// Calls that hang are ended after this time.
const PATIENCE: Duration = Duration::from_secs(20);
/// A message fits on a screen, bytes.
const MOST_TEXT: usize = 8_000;

/// A call of the program, to be run and checked.
pub struct Call<'a> {
    folder: &'a Folder,
    arguments: Vec<String>,
    memory: u64,
    input: Option<File>,
}

/// How a call ended.
#[derive(Debug)]
pub struct Ended {
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
    /// The largest resident memory, bytes.
    pub peak: u64,
    pub time: Duration,
}

impl<'a> Call<'a> {
    /// The program in this folder; `--max-memory 300M` is added to commands that take it.
    pub fn new(folder: &'a Folder, arguments: &[&str]) -> Self {
        let mut arguments: Vec<String> = arguments.iter().map(ToString::to_string).collect();
        let takes_memory = !matches!(
            arguments.first().map(String::as_str),
            Some("generate" | "man" | "completions")
        );
        if takes_memory && !arguments.iter().any(|argument| argument == "--max-memory") {
            arguments.extend(["--max-memory".to_owned(), MEMORY.1.to_owned()]);
        }
        Self {
            folder,
            arguments,
            memory: MEMORY.0,
            input: None,
        }
    }

    /// With another memory limit, in MiB.
    pub fn within(mut self, mebibytes: u64) -> Self {
        let at = self
            .arguments
            .iter()
            .position(|argument| argument == "--max-memory");
        self.arguments[at.expect("a command with a limit") + 1] = format!("{mebibytes}M");
        self.memory = mebibytes << 20;
        self
    }

    /// With this file as standard input; by default there is none.
    pub fn with_input(mut self, input: File) -> Self {
        self.input = Some(input);
        self
    }

    /// Runs it and checks the promises.
    pub fn run(self) -> Ended {
        let ended = self.measured();
        let name = self.arguments.join(" ");
        let name = name.chars().take(300).collect::<String>();
        assert!(matches!(ended.code, Some(0..=2)), "{name}: {ended:?}");
        assert!(ended.time < MOST_TIME, "{name}: {:?}", ended.time);
        let most = self.memory / 2 * 3 + BESIDE;
        assert!(
            ended.peak <= most,
            "{name}: {} of {most} bytes: {}",
            ended.peak,
            ended.stderr
        );
        for text in [&ended.stdout, &ended.stderr] {
            let is_odd = |c: char| {
                c.is_control() && c != '\n'
                    || matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
            };
            assert!(!text.contains(is_odd), "{name}: {text:?}");
            assert!(text.len() <= MOST_TEXT, "{name}: {} bytes", text.len());
        }
        let errors = ended
            .stderr
            .lines()
            .filter(|line| line.starts_with("error: "))
            .count();
        assert_eq!(errors, usize::from(ended.code != Some(0)), "{name}: {ended:?}");
        assert!(!ended.stderr.contains("panicked"), "{name}: {ended:?}");
        assert!(
            !ended.stderr.contains("memory allocation of"),
            "{name}: {ended:?}"
        );
        ended
    }

    /// Runs it, and expects one error that contains these words.
    pub fn refused(self, words: &str) {
        let ended = self.run();
        assert_eq!(ended.code, Some(1), "expected {words:?}: {ended:?}");
        assert!(ended.stderr.contains(words), "expected {words:?}: {ended:?}");
    }

    #[allow(clippy::zombie_processes, reason = "`wait` waits for it by its number")]
    fn measured(&self) -> Ended {
        let arguments: Vec<&str> = self.arguments.iter().map(String::as_str).collect();
        let (mut stdout, mut stderr) = (tempfile::tempfile().unwrap(), tempfile::tempfile().unwrap());
        let mut command = self.folder.command(&arguments);
        command
            .stdout(stdout.try_clone().unwrap())
            .stderr(stderr.try_clone().unwrap());
        if let Some(input) = &self.input {
            command.stdin(Stdio::from(input.try_clone().unwrap()));
        }
        let start = Instant::now();
        let child = command.spawn().unwrap();
        let (status, peak) = wait(child.id(), start);
        Ended {
            code: status.code(),
            stdout: text_of(&mut stdout),
            stderr: text_of(&mut stderr),
            peak,
            time: start.elapsed(),
        }
    }
}

fn text_of(file: &mut File) -> String {
    let mut bytes = Vec::new();
    file.rewind().unwrap();
    file.read_to_end(&mut bytes).unwrap();
    String::from_utf8_lossy(&bytes).into_owned()
}

/// Waits for a child, and ends it when it takes too long; how it ended, and the largest resident memory in bytes.
fn wait(child: u32, start: Instant) -> (ExitStatus, u64) {
    let child = libc::pid_t::try_from(child).unwrap();
    loop {
        let mut status = 0;
        // SAFETY: `rusage` holds integers only, for which zero is valid.
        let mut usage: libc::rusage = unsafe { std::mem::zeroed() };
        // SAFETY: both pointers are to living variables, and the child is this process's own and not yet waited for.
        let done = unsafe { libc::wait4(child, &raw mut status, libc::WNOHANG, &raw mut usage) };
        assert!(done >= 0, "{}", io::Error::last_os_error());
        if done == child {
            // KiB on Linux.
            return (ExitStatus::from_raw(status), usage.ru_maxrss as u64 * 1024);
        }
        if start.elapsed() > PATIENCE {
            // SAFETY: as above; the child has not been waited for, so that the number is still its own.
            unsafe { libc::kill(child, libc::SIGKILL) };
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}

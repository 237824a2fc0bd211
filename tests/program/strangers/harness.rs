//! Runs the program and checks the promises of every call: time, memory, and safe output.

use crate::program::Folder;
use std::{
    fs::{self, File},
    io::{Read, Seek},
    process::{Child, ExitStatus, Stdio},
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
            Some("completions" | "generate" | "man" | "verify")
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

    /// With this file as standard input, which is empty by default.
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
        let (status, peak) = wait(child, start);
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
///
/// The system's own account of a child that has ended (`wait4`) would include the memory of this process, from which it
/// was made.
fn wait(mut child: Child, start: Instant) -> (ExitStatus, u64) {
    let mut peak = 0;
    loop {
        peak = peak_of(child.id()).unwrap_or(0).max(peak);
        if let Some(status) = child.try_wait().unwrap() {
            return (status, peak);
        }
        if start.elapsed() > PATIENCE {
            child.kill().unwrap();
        }
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// The largest resident memory of a process so far, bytes.
fn peak_of(process: u32) -> Option<u64> {
    let status = fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix(" kB")?.parse().ok()?;
    Some(kibibytes * 1024)
}

//! Runs the program in a folder of its own.
#![allow(dead_code, reason = "each test file uses a part of it")]

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output, Stdio},
};
use tempfile::TempDir;

/// Where the program is.
pub const PROGRAM: &str = env!("CARGO_BIN_EXE_octray");

/// A folder with a scene in it, `a.scn`.
pub struct Folder {
    folder: TempDir,
}

impl Folder {
    pub fn new() -> Self {
        let this = Self {
            folder: TempDir::new().unwrap(),
        };
        this.write(
            "a.scn",
            "light 3 -2 5 0.7\nmaterial 1\nsphere 0 0 0.5 0.5\nmaterial 3\nsphere 0.6 0.4 0.2 0.2\n",
        );
        this
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    /// The names of all files, sorted.
    pub fn names(&self) -> Vec<String> {
        names_in(self.folder.path())
    }

    /// The program in this folder, connected to nothing.
    pub fn command(&self, arguments: &[&str]) -> Command {
        self.any_command(PROGRAM, arguments)
    }

    /// Any other program in this folder.
    pub fn any_command(&self, program: &str, arguments: &[&str]) -> Command {
        let mut command = Command::new(program);
        command
            .args(arguments)
            .current_dir(self.folder.path())
            // Whoever runs the tests may have a config file.
            .env("XDG_CONFIG_HOME", self.folder.path())
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        command
    }

    pub fn run(&self, arguments: &[&str]) -> Run {
        Run::new(self.command(arguments).output().unwrap())
    }

    /// Runs a shell script, in which `$0` is the program.
    pub fn shell(&self, script: &str) -> Run {
        Run::new(self.any_command("sh", &["-c", script, PROGRAM]).output().unwrap())
    }

    /// Runs the program and expects it to fail with this exit code, saying one thing that contains `words`
    /// on standard error and nothing on standard output, and leaving nothing behind.
    pub fn fails(&self, arguments: &[&str], code: i32, words: &str) {
        let before = self.names();
        let run = self.run(arguments);
        run.failed(code, words);
        assert_eq!(self.names(), before, "{arguments:?}");
    }
}

pub fn names_in(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

/// What a run left.
#[derive(Debug)]
pub struct Run {
    pub code: Option<i32>,
    pub stdout: Vec<u8>,
    pub stderr: String,
}

impl Run {
    pub fn new(output: Output) -> Self {
        Self {
            code: output.status.code(),
            stdout: output.stdout,
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// Exit code 0, and not a word on standard error.
    pub fn succeeded(&self) -> &Self {
        assert_eq!((self.code, self.stderr.as_str()), (Some(0), ""), "{self:?}");
        self
    }

    /// See [`Folder::fails`].
    pub fn failed(&self, code: i32, words: &str) {
        assert_eq!(self.code, Some(code), "{self:?}");
        assert!(self.stdout.is_empty(), "{self:?}");
        assert!(self.stderr.contains(words), "expected {words:?}: {self:?}");
        assert_eq!(self.stderr.matches("error:").count(), 1, "{self:?}");
        assert!(!self.stderr.contains("panicked"), "{self:?}");
        assert!(self.stderr.starts_with("error: "), "{self:?}");
        if self.stderr.contains("For more information, try") {
            // clap's own: an error line, the usage and where to find help.
            assert_eq!(code, 2, "{self:?}");
        } else {
            assert_eq!(self.stderr.trim_end().lines().count(), 1, "{self:?}");
        }
    }

    pub fn text(&self) -> &str {
        std::str::from_utf8(&self.stdout).unwrap()
    }
}

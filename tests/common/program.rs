//! Runs the program in a folder of its own.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Child, Command, ExitStatus, Output, Stdio},
    time::{Duration, Instant},
};
use tempfile::TempDir;

/// The program's path.
pub const PROGRAM: &str = env!("CARGO_BIN_EXE_octray");

/// A ball over an infinite checkerboard, in a mirror without end.
pub const PLANE: &str = "\
camera eye 3 -3 1.5 target 0 0 0.4 fov 40
background bottom 0.9 0.85 0.8 top 0.1 0.3 0.7
ambient 0.3 reach 0.5
light 3 -2 5 0.5
light 2 -4 3 0.3 radius 0.5
material matte cd 0.9 0.9 0.8 checker 0.2 0.1 0.3 size 0.3
plane 0 0 0 normal 0.02 0 1
material glass
sphere 0.5 -0.4 0.3 0.3
material blinn_phong cd 0.8 0.2 0.2 checker 0.9 0.9 0.9 size 0.1
sphere -0.3 0.2 0.5 0.5
material reflection mix 0.6 checker 0.5 0.5 0.5 size 1
plane -1 1 0 normal 1 -1 0.1
";

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

    /// Writes a triangle as NAME.gltf and NAME.bin; `more` are further members of the JSON.
    pub fn write_gltf(&self, name: &str, more: &str) {
        let corners = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        fs::write(
            self.path(&format!("{name}.bin")),
            corners.map(f32::to_le_bytes).concat(),
        )
        .unwrap();
        let json = format!(
            r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}}],
            "bufferViews":[{{"buffer":0,"byteLength":36}}],"buffers":[{{"uri":"{name}.bin","byteLength":36}}],{more}}}"#
        );
        self.write(&format!("{name}.gltf"), &json);
    }

    /// The names of all files, sorted.
    pub fn names(&self) -> Vec<String> {
        names_in(self.folder.path())
    }

    /// The program in this folder, without input.
    pub fn command(&self, arguments: &[&str]) -> Command {
        self.any_command(PROGRAM, arguments)
    }

    /// Any other program in this folder.
    pub fn any_command(&self, program: &str, arguments: &[&str]) -> Command {
        let mut command = Command::new(program);
        command
            .args(arguments)
            .current_dir(self.folder.path())
            // Not the user's config file.
            .env("XDG_CONFIG_HOME", self.folder.path())
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        command
    }

    /// Makes a named pipe. Returns `false` if this system has no `mkfifo`.
    pub fn make_pipe(&self, name: &str) -> bool {
        let made = self.any_command("mkfifo", &[name]).status();
        let made = made.is_ok_and(|status| status.success());
        if !made {
            println!("skipped: this needs `mkfifo`");
        }
        made
    }

    pub fn run(&self, arguments: &[&str]) -> Run {
        Run::new(self.command(arguments).output().unwrap())
    }

    /// Runs the program with arguments separated by spaces.
    pub fn run_line(&self, arguments: &str) -> Run {
        self.run(&arguments.split_whitespace().collect::<Vec<_>>())
    }

    /// Runs a shell script, in which `$0` is the program.
    pub fn shell(&self, script: &str) -> Run {
        Run::new(self.any_command("sh", &["-c", script, PROGRAM]).output().unwrap())
    }

    /// Runs the program and expects it to fail with this exit code and one error that contains `words`, without output
    /// on standard output or new files.
    pub fn fails(&self, arguments: &[&str], code: i32, words: &str) {
        let before = self.names();
        let run = self.run(arguments);
        run.failed(code, words);
        assert_eq!(self.names(), before, "{arguments:?}");
    }
}

/// Runs the program on a terminal of util-linux's `script`; `None` if that is not installed.
pub fn on_a_terminal(folder: &Folder, arguments: &str) -> Option<Run> {
    let command = format!("{PROGRAM} {arguments}");
    if let Ok(output) = folder
        .any_command("script", &["-qec", &command, "/dev/null"])
        .output()
    {
        Some(Run::new(output))
    } else {
        println!("skipped: this needs `script`");
        None
    }
}

/// The path of `scenes/meshes/NAME`.
pub fn shipped_mesh(name: &str) -> String {
    let meshes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/meshes");
    meshes.join(name).to_string_lossy().into_owned()
}

/// Sends a signal, such as `-INT`, to a program that may have ended already.
pub fn send_signal(child: &Child, name: &str) {
    // Jobs in the background ignore SIGINT until octray listens: before, it would get lost.
    let start = Instant::now();
    while name == "-INT" && ignores_interrupts(child) && start.elapsed() < Duration::from_secs(10) {
        std::thread::sleep(Duration::from_millis(5));
    }
    let _ = Command::new("kill")
        .args([name, &child.id().to_string()])
        .output();
}

/// Whether a process ignores SIGINT, as far as that is known.
fn ignores_interrupts(child: &Child) -> bool {
    let status = fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask & 2 != 0)
}

/// Expects `text` to contain all of these.
pub fn assert_contains(text: &str, words: &[&str]) {
    for word in words {
        assert!(text.contains(word), "{word} is not in: {text}");
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

/// The signal that ended a program.
#[cfg(unix)]
fn signal_of(status: ExitStatus) -> Option<i32> {
    std::os::unix::process::ExitStatusExt::signal(&status)
}

#[cfg(not(unix))]
fn signal_of(_: ExitStatus) -> Option<i32> {
    None
}

/// The result of a run.
#[derive(Debug)]
pub struct Run {
    pub code: Option<i32>,
    /// The signal that ended the program.
    pub signal: Option<i32>,
    pub stdout: Vec<u8>,
    pub stderr: String,
}

impl Run {
    pub fn new(output: Output) -> Self {
        Self {
            code: output.status.code(),
            signal: signal_of(output.status),
            stdout: output.stdout,
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// Expects the program to have died of this signal, such as `-INT`, without a word.
    pub fn died_of(&self, name: &str) {
        let number = ["-HUP", "-INT"].iter().position(|&other| other == name);
        let number = number.map_or(15, |number| number as i32 + 1);
        assert_eq!(
            (self.code, self.signal, self.stderr.as_str()),
            (None, Some(number), ""),
            "{name}: {self:?}"
        );
    }

    /// Expects exit code 0 and nothing on standard error.
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

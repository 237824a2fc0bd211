//! Starts `octray view` on a virtual display, drives it and takes screenshots.

pub mod cameras;
pub mod loading;
pub mod meshes;
pub mod moving;
mod screen;

pub use screen::Screen;

use super::program::Folder;
use image::RgbImage;
use std::{
    cell::RefCell,
    fs,
    io::{BufRead, BufReader, Write},
    os::unix::process::ExitStatusExt,
    path::PathBuf,
    process::{Child, Command, Stdio},
    sync::mpsc::{self, Receiver},
    thread::{self, JoinHandle},
    time::{Duration, Instant},
};

/// The size of a window.
pub const SIZE: [u32; 2] = [200, 150];
/// A message of one line ends above this row.
pub const BELOW_MESSAGE: u32 = 30;
/// The longest time to wait for anything.
const PATIENCE: Duration = Duration::from_mins(1);

/// A running `octray view`.
pub struct Viewer<'a> {
    screen: &'a Screen,
    folder: Folder,
    process: Child,
    lines: Receiver<String>,
    /// Standard error, known when the program has ended.
    stderr: Option<JoinHandle<String>>,
    errors: String,
    window: u32,
    scene: &'static str,
    size: [u32; 2],
    last_shot: RefCell<Shot>,
}

/// A screenshot: the server's bytes and the picture.
#[derive(Default)]
struct Shot {
    bytes: Vec<u8>,
    picture: RgbImage,
}

impl Drop for Viewer<'_> {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Tries again until there is a result.
pub fn wait_for<T>(what: &str, mut answer: impl FnMut() -> Result<T, String>) -> T {
    let start = Instant::now();
    loop {
        match answer() {
            Ok(answer) => return answer,
            Err(found) => assert!(start.elapsed() < PATIENCE, "waiting for {what}, found {found}"),
        }
        thread::sleep(Duration::from_millis(20));
    }
}

impl<'a> Viewer<'a> {
    pub fn open(screen: &'a Screen, size: [u32; 2], options: &[&str]) -> Self {
        Self::open_file(screen, "a.scn", "", size, options)
    }

    /// Opens another file than the folder's scene, with this text.
    pub fn open_file(
        screen: &'a Screen,
        scene: &'static str,
        text: &str,
        size: [u32; 2],
        options: &[&str],
    ) -> Self {
        let folder = Folder::new();
        fs::create_dir(folder.path("meshes")).unwrap();
        if !["a.scn", "-"].contains(&scene) {
            folder.write(scene, text);
        }
        let size_option = format!("--size={}x{}", size[0], size[1]);
        let arguments = [&["view", scene, &size_option], options].concat();
        let mut command = screen.on(folder.command(&arguments));
        if scene == "-" {
            command.stdin(Stdio::piped());
        }
        let mut process = command.stderr(Stdio::piped()).spawn().unwrap();
        let stderr = BufReader::new(process.stderr.take().unwrap());
        let stderr = thread::spawn(move || {
            let mut errors = String::new();
            for line in stderr.lines().map_while(Result::ok) {
                eprintln!("{line}");
                errors += &line;
            }
            errors
        });
        let stdout = BufReader::new(process.stdout.take().unwrap());
        let (sender, lines) = mpsc::channel();
        thread::spawn(move || {
            stdout
                .lines()
                .map_while(Result::ok)
                .try_for_each(|line| sender.send(line))
        });
        // Found by its process: the window of an earlier one may still exist.
        let window = wait_for("the window", || {
            if let Some(status) = process.try_wait().unwrap() {
                panic!("the program has ended: {status}");
            }
            screen.window_of(process.id()).ok_or_else(|| "none".into())
        });
        screen.place(window, [40, 30]);
        screen.focus(window);
        Self {
            screen,
            folder,
            process,
            lines,
            stderr: Some(stderr),
            errors: String::new(),
            window,
            scene,
            size,
            last_shot: RefCell::default(),
        }
    }

    /// Writes all of standard input, if that is the scene.
    pub fn feed(&mut self, text: &str) {
        let mut stdin = self.process.stdin.take().unwrap();
        stdin.write_all(text.as_bytes()).unwrap();
    }

    pub fn pid(&self) -> u32 {
        self.process.id()
    }

    pub fn pixels(&self) -> f64 {
        f64::from(self.size[0]) * f64::from(self.size[1])
    }

    pub fn key(&self, key: &str) {
        self.screen.xdotool(&["key", "--delay", "20", key]);
    }

    pub fn key_down(&self, key: &str) {
        self.screen.xdotool(&["keydown", key]);
    }

    pub fn key_up(&self, key: &str) {
        self.screen.xdotool(&["keyup", key]);
    }

    /// Gives the keyboard focus to the window or to none.
    pub fn set_focus(&self, has_focus: bool) {
        self.screen
            .focus(if has_focus { self.window } else { x11rb::NONE });
    }

    pub fn click(&self, button: u32, times: u32) {
        let [button, times] = [button, times].map(|n| n.to_string());
        self.screen
            .xdotool(&["click", "--delay", "20", "--repeat", &times, &button]);
    }

    pub fn move_mouse(&self, [x, y]: [u32; 2]) {
        let [window, x, y] = [self.window, x, y].map(|n| n.to_string());
        self.screen.xdotool(&["mousemove", "--window", &window, &x, &y]);
    }

    pub fn drag(&self, button: u32, from: [u32; 2], to: [u32; 2]) {
        let button = button.to_string();
        self.move_mouse(from);
        self.screen.xdotool(&["mousedown", &button]);
        for i in 1..=4 {
            let at = |axis: usize| (from[axis] * (4 - i) + to[axis] * i) / 4;
            self.move_mouse([at(0), at(1)]);
        }
        self.screen.xdotool(&["mouseup", &button]);
    }

    pub fn resize(&mut self, size: [u32; 2]) {
        self.screen.resize(self.window, size);
        self.size = size;
    }

    pub fn wait_for_title(&self, end: &str) {
        wait_for(end, || {
            let title = self.screen.title(self.window);
            if title.ends_with(end) { Ok(()) } else { Err(title) }
        });
    }

    pub fn title(&self) -> String {
        self.screen.title(self.window)
    }

    /// What the window shows. Most shots of a test that waits show the same, and are converted once.
    pub fn shot(&self) -> RgbImage {
        let bytes = self.screen.shot(self.window, self.size);
        let mut last = self.last_shot.borrow_mut();
        let [width, height] = self.size;
        if last.bytes != bytes || last.picture.dimensions() != (width, height) {
            // A loop, because iterators of bytes are slow without optimisation.
            last.picture = RgbImage::new(width, height);
            for (rgb, pixel) in last.picture.chunks_exact_mut(3).zip(bytes.chunks_exact(4)) {
                rgb.copy_from_slice(&pixel[..3]);
                rgb.swap(0, 2);
            }
            last.bytes = bytes;
        }
        last.picture.clone()
    }

    /// Waits until the window shows this picture from row `top` on, below messages.
    pub fn wait_for_picture(&self, what: &str, expected: &RgbImage, top: u32) {
        let start = Instant::now();
        wait_for(what, || {
            let shot = self.shot();
            if is_same(&shot, expected, top) {
                return Ok(());
            }
            // Counting and encoding take longer than looking: only when it may be the last.
            if start.elapsed() < PATIENCE / 2 {
                return Err("another picture".into());
            }
            keep(&shot, "last");
            let pixels = difference(&shot, expected, top);
            Err(format!("{pixels} other pixels: target/window/last.png"))
        });
    }

    /// Waits until more than a share of the pixels differ. Returns the picture.
    pub fn wait_for_change(&self, what: &str, from: &RgbImage, share: f64) -> RgbImage {
        wait_for(what, || {
            let shot = self.shot();
            let changed = difference(&shot, from, 0) as f64 / self.pixels();
            if changed > share {
                Ok(shot)
            } else {
                Err(format!("a change of {changed}"))
            }
        })
    }

    pub fn wait_for_file(&self, name: &str) {
        wait_for(name, || {
            let names = self.folder.names();
            if names.iter().any(|found| found == name) {
                Ok(())
            } else {
                Err(names.join(" "))
            }
        });
    }

    /// Returns what `octray render` makes of the same scene with these options, in the window's size.
    pub fn render(&self, options: &[&str]) -> RgbImage {
        let size = format!("--size={}x{}", self.size[0], self.size[1]);
        let own_size = options.iter().any(|option| option.starts_with("--size"));
        let size = if own_size { vec![] } else { vec![size.as_str()] };
        // Quiet: an empty scene causes a warning.
        let arguments = [
            &["render", "--quiet", self.scene, "-o", "expected.png"],
            options,
            &size,
        ]
        .concat();
        self.folder.run(&arguments).succeeded();
        self.picture("expected.png")
    }

    pub fn picture(&self, name: &str) -> RgbImage {
        image::open(self.folder.path(name)).unwrap().into_rgb8()
    }

    pub fn write(&self, name: &str, text: &str) {
        self.folder.write(name, text);
    }

    pub fn create_folder(&self, name: &str) {
        fs::create_dir(self.folder.path(name)).unwrap();
    }

    pub fn rename(&self, from: &str, to: &str) {
        fs::rename(self.folder.path(from), self.folder.path(to)).unwrap();
    }

    pub fn remove(&self, name: &str) {
        fs::remove_file(self.folder.path(name)).unwrap();
    }

    /// Returns the camera as options of `octray render`. The program has handled all earlier input then.
    pub fn camera_options(&self) -> String {
        self.key("c");
        let line = self.lines.recv_timeout(PATIENCE).expect("the camera, printed");
        let prefix = format!("octray render {} ", self.scene);
        line.strip_prefix(&prefix).expect(&line).to_owned()
    }

    /// Presses a key and expects the program to end with success.
    pub fn quit(&mut self, key: &str) {
        self.screen.xdotool(&["key", key]);
        self.ended();
    }

    /// Closes the window as a window manager does.
    pub fn close(&mut self) {
        self.screen.close(self.window);
        self.ended();
    }

    /// Presses keys without a pause.
    pub fn keys(&self, keys: &[&str]) {
        self.screen.xdotool(&[&["key", "--delay", "0"], keys].concat());
    }

    pub fn button(&self, button: u32, is_down: bool) {
        let what = if is_down { "mousedown" } else { "mouseup" };
        self.screen.xdotool(&[what, &button.to_string()]);
    }

    /// Sends a signal and expects the program to end of it.
    pub fn signal(&mut self, name: &str, signal: i32) {
        let pid = self.process.id().to_string();
        let sent = Command::new("kill").args(["-s", name, &pid]).status().unwrap();
        assert!(sent.success());
        self.ended_as(None, Some(signal));
    }

    /// Whether the program, which has ended, said this on standard error.
    pub fn said(&self, words: &str) -> bool {
        self.errors.contains(words)
    }

    /// Returns the names of the files in the folder.
    pub fn files(&self) -> Vec<String> {
        self.folder.names()
    }

    fn ended(&mut self) {
        self.ended_with(0);
    }

    /// Expects the program to end with that exit code.
    pub fn ended_with(&mut self, exit_code: i32) {
        self.ended_as(Some(exit_code), None);
    }

    fn ended_as(&mut self, exit_code: Option<i32>, signal: Option<i32>) {
        let status = wait_for("the end", || {
            self.process
                .try_wait()
                .unwrap()
                .ok_or_else(|| "a running program".into())
        });
        assert_eq!((status.code(), status.signal()), (exit_code, signal), "{status}");
        self.errors = self
            .stderr
            .take()
            .map_or_else(String::new, |thread| thread.join().unwrap());
        assert!(!self.said("panicked"), "a thread of the program panicked");
    }
}

/// Saves a picture to look at, under `target/window`.
pub fn keep(picture: &RgbImage, name: &str) {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("target/window");
    fs::create_dir_all(&folder).unwrap();
    picture.save(folder.join(format!("{name}.png"))).unwrap();
}

/// The bytes from row `top` on. A message may be higher than the picture.
fn below(picture: &RgbImage, top: u32) -> &[u8] {
    let first = 3 * (top * picture.width()) as usize;
    picture.as_raw().get(first..).unwrap_or_default()
}

/// Whether the pixels from row `top` on are the same.
fn is_same(a: &RgbImage, b: &RgbImage, top: u32) -> bool {
    a.dimensions() == b.dimensions() && below(a, top) == below(b, top)
}

/// Counts the pixels from row `top` on that differ: `usize::MAX` if the sizes do.
pub fn difference(a: &RgbImage, b: &RgbImage, top: u32) -> usize {
    if is_same(a, b, top) {
        return 0;
    }
    if a.dimensions() != b.dimensions() {
        return usize::MAX;
    }
    let pairs = below(a, top).chunks_exact(3).zip(below(b, top).chunks_exact(3));
    pairs.filter(|(a, b)| a != b).count()
}

/// Returns the CPU time of all threads of a process within `time`, in ticks of 10 ms.
pub fn idle_ticks(pid: u32, time: Duration) -> u64 {
    let ticks = || {
        let stat = fs::read_to_string(format!("/proc/{pid}/stat")).unwrap();
        let (_, fields) = stat.rsplit_once(") ").unwrap();
        let fields: Vec<&str> = fields.split(' ').collect();
        fields[11].parse::<u64>().unwrap() + fields[12].parse::<u64>().unwrap()
    };
    let before = ticks();
    thread::sleep(time);
    ticks() - before
}

//! A display of our own, and `octray view` on it.

use super::program::{Folder, Run};
use image::{Rgb, RgbImage};
use std::{
    fs,
    io::{BufRead, BufReader},
    path::PathBuf,
    process::{Child, ChildStdout, Command, Stdio},
    thread,
    time::{Duration, Instant},
};
use tempfile::TempDir;

/// How long anything may take on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);
const SCREEN: [u32; 2] = [800, 600];

/// Xvfb, whose screen is a file.
pub struct Screen {
    server: Child,
    display: String,
    folder: TempDir,
}

impl Drop for Screen {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

impl Screen {
    /// `None` where a program is missing: says so.
    pub fn start() -> Option<Self> {
        for program in ["Xvfb", "xdotool"] {
            let found = Command::new("sh")
                .args(["-c", &format!("command -v {program}")])
                .output();
            if !found.is_ok_and(|found| found.status.success()) {
                eprintln!("skipped: {program} is not installed");
                return None;
            }
        }
        let folder = TempDir::new().unwrap();
        let [width, height] = SCREEN;
        // The server chooses a free number, writes it and is ready then.
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-nolisten", "tcp", "-fbdir"])
            .arg(folder.path())
            .args(["-screen", "0", &format!("{width}x{height}x24")])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut number = String::new();
        BufReader::new(server.stdout.take().unwrap())
            .read_line(&mut number)
            .unwrap();
        Some(Self {
            server,
            display: format!(":{}", number.trim()),
            folder,
        })
    }

    /// The program, on this display.
    pub fn run(&self, folder: &Folder, arguments: &[&str]) -> Run {
        Run::new(self.on(folder.command(arguments)).output().unwrap())
    }

    fn on(&self, mut command: Command) -> Command {
        command
            .env("DISPLAY", &self.display)
            .env_remove("WAYLAND_DISPLAY");
        command
    }

    fn xdotool(&self, arguments: &[&str]) -> String {
        let mut command = Command::new("xdotool");
        command.args(arguments);
        let output = self.on(command).output().unwrap();
        String::from_utf8(output.stdout).unwrap()
    }

    /// A part of the screen, from the server's file (X window dump: a header of big-endian words, colours, rows).
    fn shot(&self, [left, top]: [u32; 2], [width, height]: [u32; 2]) -> RgbImage {
        let bytes = fs::read(self.folder.path().join("Xvfb_screen0")).unwrap();
        let word = |i: usize| u32::from_be_bytes(bytes[4 * i..4 * i + 4].try_into().unwrap()) as usize;
        let (header, row_bytes, colors) = (word(0), word(12), word(19));
        let pixels = &bytes[header + 12 * colors..];
        RgbImage::from_fn(width, height, |x, y| {
            let at = (top + y) as usize * row_bytes + 4 * (left + x) as usize;
            Rgb([pixels[at + 2], pixels[at + 1], pixels[at]])
        })
    }
}

/// A running `octray view a.scn`.
pub struct Viewer<'a> {
    screen: &'a Screen,
    folder: Folder,
    process: Child,
    lines: BufReader<ChildStdout>,
    window: String,
    size: [u32; 2],
}

impl Drop for Viewer<'_> {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Tries again until there is an answer.
fn wait_for<T>(what: &str, mut answer: impl FnMut() -> Result<T, String>) -> T {
    let start = Instant::now();
    loop {
        match answer() {
            Ok(answer) => return answer,
            Err(found) => assert!(start.elapsed() < PATIENCE, "waiting for {what}, found {found}"),
        }
        thread::sleep(Duration::from_millis(30));
    }
}

impl<'a> Viewer<'a> {
    pub fn open(screen: &'a Screen, size: [u32; 2], options: &[&str]) -> Self {
        let folder = Folder::new();
        fs::create_dir(folder.path("meshes")).unwrap();
        let size_option = format!("--size={}x{}", size[0], size[1]);
        let arguments = [&["view", "a.scn", &size_option], options].concat();
        let mut command = screen.on(folder.command(&arguments));
        let mut process = command.stderr(Stdio::inherit()).spawn().unwrap();
        let lines = BufReader::new(process.stdout.take().unwrap());
        let window = wait_for("the window", || {
            let found = screen.xdotool(&["search", "--onlyvisible", "--name", "^octray - "]);
            found.lines().last().map(str::to_owned).ok_or(found)
        });
        screen.xdotool(&["windowmove", &window, "40", "30"]);
        screen.xdotool(&["windowfocus", "--sync", &window]);
        Self {
            screen,
            folder,
            process,
            lines,
            window,
            size,
        }
    }

    pub fn pid(&self) -> u32 {
        self.process.id()
    }

    pub fn pixels(&self) -> f64 {
        f64::from(self.size[0]) * f64::from(self.size[1])
    }

    pub fn key(&self, key: &str) {
        self.screen.xdotool(&["key", "--delay", "40", key]);
        thread::sleep(Duration::from_millis(60));
    }

    pub fn click(&self, button: u32) {
        self.screen.xdotool(&["click", &button.to_string()]);
        thread::sleep(Duration::from_millis(60));
    }

    pub fn move_mouse(&self, x: u32, y: u32) {
        let [x, y] = [x, y].map(|c| c.to_string());
        self.screen
            .xdotool(&["mousemove", "--window", &self.window, &x, &y]);
        thread::sleep(Duration::from_millis(30));
    }

    pub fn drag(&self, button: u32, from: [u32; 2], to: [u32; 2]) {
        let button = button.to_string();
        self.move_mouse(from[0], from[1]);
        self.screen.xdotool(&["mousedown", &button]);
        for i in 1..=4 {
            let at = |axis: usize| (from[axis] * (4 - i) + to[axis] * i) / 4;
            self.move_mouse(at(0), at(1));
        }
        self.screen.xdotool(&["mouseup", &button]);
        thread::sleep(Duration::from_millis(60));
    }

    pub fn resize(&mut self, size: [u32; 2]) {
        let [width, height] = size.map(|side| side.to_string());
        self.screen
            .xdotool(&["windowsize", "--sync", &self.window, &width, &height]);
        self.size = size;
    }

    fn title(&self) -> String {
        self.screen.xdotool(&["getwindowname", &self.window])
    }

    pub fn wait_for_title(&self, end: &str) {
        wait_for(end, || {
            let title = self.title();
            if title.trim_end().ends_with(end) {
                Ok(())
            } else {
                Err(title)
            }
        });
    }

    /// Until the picture is all that there will be.
    pub fn settle(&self) {
        thread::sleep(Duration::from_millis(250));
        self.wait_for_title("- done");
        thread::sleep(Duration::from_millis(100));
    }

    pub fn wait_for_change(&self, from: &RgbImage) {
        wait_for("another picture", || {
            if difference(&self.shot(), from) > 0 {
                Ok(())
            } else {
                Err("the same".into())
            }
        });
        thread::sleep(Duration::from_millis(200));
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

    /// What the window shows.
    pub fn shot(&self) -> RgbImage {
        let geometry = self
            .screen
            .xdotool(&["getwindowgeometry", "--shell", &self.window]);
        let value = |name: &str| {
            let line = geometry
                .lines()
                .find_map(|line| line.strip_prefix(name)?.strip_prefix('='));
            line.expect(&geometry).parse().expect(&geometry)
        };
        self.screen.shot([value("X"), value("Y")], self.size)
    }

    /// What `octray render` makes of the same scene with these options, in the window's size.
    pub fn render(&self, options: &[&str]) -> RgbImage {
        let size = format!("--size={}x{}", self.size[0], self.size[1]);
        let own_size = options.iter().any(|option| option.starts_with("--size"));
        let size = if own_size { vec![] } else { vec![size.as_str()] };
        let arguments = [&["render", "a.scn", "-o", "expected.png"], options, &size].concat();
        self.folder.run(&arguments).succeeded();
        self.picture("expected.png")
    }

    pub fn picture(&self, name: &str) -> RgbImage {
        image::open(self.folder.path(name)).unwrap().into_rgb8()
    }

    pub fn write(&self, name: &str, text: &str) {
        self.folder.write(name, text);
    }

    pub fn next_line(&mut self) -> String {
        let mut line = String::new();
        self.lines.read_line(&mut line).unwrap();
        line.trim_end().to_owned()
    }

    pub fn camera_options(&mut self) -> String {
        self.key("c");
        self.next_line()
            .trim_start_matches("octray render a.scn ")
            .to_owned()
    }

    /// Presses a key, and expects the program to end soon and well.
    pub fn quit(&mut self, key: &str) {
        self.screen.xdotool(&["key", key]);
        self.ended();
    }

    /// What a window manager's close button does.
    pub fn close(&mut self) {
        close::send(&self.screen.display, &self.window);
        self.ended();
    }

    fn ended(&mut self) {
        let start = Instant::now();
        let status = wait_for("the end", || {
            self.process.try_wait().unwrap().ok_or_else(|| "no end".into())
        });
        assert!(status.success(), "{status}");
        assert!(
            start.elapsed() < Duration::from_secs(2),
            "the end took {:?}",
            start.elapsed()
        );
    }
}

/// Messages are shown for three seconds.
pub fn wait_for_messages_to_go() {
    thread::sleep(Duration::from_millis(3300));
}

/// Keeps a picture to look at, under `target/window`.
pub fn keep(picture: &RgbImage, name: &str) {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("target/window");
    fs::create_dir_all(&folder).unwrap();
    picture.save(folder.join(format!("{name}.png"))).unwrap();
}

/// How many pixels differ.
pub fn difference(a: &RgbImage, b: &RgbImage) -> usize {
    assert_eq!(a.dimensions(), b.dimensions());
    a.pixels().zip(b.pixels()).filter(|(a, b)| a != b).count()
}

/// CPU time that a process takes within a while, all threads together, in ticks of 10 ms.
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

mod close {
    //! The message by which a window manager closes a window.

    use x11rb::{
        connection::Connection,
        protocol::xproto::{ClientMessageEvent, ConnectionExt, EventMask},
    };

    pub fn send(display: &str, window: &str) {
        let (connection, _) = x11rb::connect(Some(display)).unwrap();
        let window: u32 = window.parse().unwrap();
        let atom = |name: &str| {
            let reply = connection.intern_atom(false, name.as_bytes()).unwrap().reply();
            reply.unwrap().atom
        };
        let data = [atom("WM_DELETE_WINDOW"), 0, 0, 0, 0];
        let message = ClientMessageEvent::new(32, window, atom("WM_PROTOCOLS"), data);
        connection
            .send_event(false, window, EventMask::NO_EVENT, message)
            .unwrap();
        connection.flush().unwrap();
    }
}

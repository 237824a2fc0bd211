//! Xvfb, and a connection to it to find windows and see what they show. Keys and mouse come from xdotool.

use super::wait_for;
use crate::program::{Folder, Run};
use std::{
    io::{BufRead, BufReader},
    process::{Child, Command, Stdio},
};
use x11rb::{
    connection::Connection,
    protocol::xproto::{
        Atom, AtomEnum, AutoRepeatMode, ChangeKeyboardControlAux, ClientMessageEvent, ConfigureWindowAux,
        ConnectionExt, EventMask, ImageFormat, InputFocus, MapState,
    },
    rust_connection::RustConnection,
};

pub struct Screen {
    server: Child,
    display: String,
    connection: RustConnection,
    root: u32,
}

impl Drop for Screen {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

impl Screen {
    /// Starts the server. Returns `None` if a program is missing.
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
        // The server writes its number when it is ready. Without -noreset it restarts, and refuses connections
        // meanwhile, when the last program leaves.
        let mut server = Command::new("Xvfb")
            .args([
                "-displayfd",
                "1",
                "-noreset",
                "-nolisten",
                "tcp",
                "-screen",
                "0",
                "800x600x24",
            ])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut number = String::new();
        BufReader::new(server.stdout.take().unwrap())
            .read_line(&mut number)
            .unwrap();
        let display = format!(":{}", number.trim());
        let (connection, screen_i) = x11rb::connect(Some(&display)).expect("Xvfb answers");
        let root = connection.setup().roots[screen_i].root;
        // A key is pressed once, however late a busy machine releases it.
        let once = ChangeKeyboardControlAux::new().auto_repeat_mode(AutoRepeatMode::OFF);
        connection
            .change_keyboard_control(&once)
            .unwrap()
            .check()
            .unwrap();
        Some(Self {
            server,
            display,
            connection,
            root,
        })
    }

    /// Runs the program on this display.
    pub fn run(&self, folder: &Folder, arguments: &[&str]) -> Run {
        Run::new(self.on(folder.command(arguments)).output().unwrap())
    }

    /// Sets this display for a command.
    pub fn on(&self, mut command: Command) -> Command {
        command
            .env("DISPLAY", &self.display)
            // No compositor answers there, as in a tmux that is older than the session.
            .env("WAYLAND_DISPLAY", "wayland-of-an-older-session");
        command
    }

    /// Runs xdotool. The server has delivered all input when it returns.
    pub fn xdotool(&self, arguments: &[&str]) {
        let mut command = Command::new("xdotool");
        command.args(arguments);
        let output = self.on(command).output().unwrap();
        assert!(output.status.success(), "xdotool {arguments:?}: {output:?}");
    }

    fn atom(&self, name: &str) -> Atom {
        let cookie = self.connection.intern_atom(false, name.as_bytes()).unwrap();
        cookie.reply().unwrap().atom
    }

    fn property(&self, window: u32, name: &str) -> Option<Vec<u8>> {
        let cookie = self
            .connection
            .get_property(false, window, self.atom(name), AtomEnum::ANY, 0, 1024)
            .unwrap();
        Some(cookie.reply().ok()?.value)
    }

    /// The visible window of a process.
    pub fn window_of(&self, pid: u32) -> Option<u32> {
        let tree = self.connection.query_tree(self.root).unwrap().reply().unwrap();
        tree.children.into_iter().find(|&window| {
            let attributes = self.connection.get_window_attributes(window).unwrap().reply();
            attributes.is_ok_and(|found| found.map_state == MapState::VIEWABLE)
                && self.property(window, "_NET_WM_PID") == Some(pid.to_ne_bytes().to_vec())
        })
    }

    pub fn title(&self, window: u32) -> String {
        let bytes = self.property(window, "_NET_WM_NAME").unwrap_or_default();
        String::from_utf8(bytes).unwrap()
    }

    pub fn place(&self, window: u32, [x, y]: [i32; 2]) {
        self.configure(window, &ConfigureWindowAux::new().x(x).y(y));
    }

    pub fn resize(&self, window: u32, [width, height]: [u32; 2]) {
        self.configure(window, &ConfigureWindowAux::new().width(width).height(height));
    }

    fn configure(&self, window: u32, aux: &ConfigureWindowAux) {
        let cookie = self.connection.configure_window(window, aux).unwrap();
        cookie.check().unwrap();
    }

    /// Gives the keyboard focus to a window, or to none: `x11rb::NONE`.
    pub fn focus(&self, window: u32) {
        wait_for("the focus", || {
            let cookie = self
                .connection
                .set_input_focus(InputFocus::PARENT, window, x11rb::CURRENT_TIME)
                .unwrap();
            cookie.check().map_err(|error| error.to_string())?;
            let focus = self.connection.get_input_focus().unwrap().reply().unwrap().focus;
            if focus == window {
                Ok(())
            } else {
                Err(format!("it at {focus}"))
            }
        });
    }

    /// Sends the message by which a window manager closes a window.
    pub fn close(&self, window: u32) {
        let data = [self.atom("WM_DELETE_WINDOW"), 0, 0, 0, 0];
        let message = ClientMessageEvent::new(32, window, self.atom("WM_PROTOCOLS"), data);
        let cookie = self
            .connection
            .send_event(false, window, EventMask::NO_EVENT, message)
            .unwrap();
        cookie.check().unwrap();
    }

    /// Returns the bytes of what a window shows. A pixel is four: blue, green, red, unused.
    pub fn shot(&self, window: u32, [width, height]: [u32; 2]) -> Vec<u8> {
        let [w, h] = [width, height].map(|side| side as u16);
        let cookie = self
            .connection
            .get_image(ImageFormat::Z_PIXMAP, window, 0, 0, w, h, u32::MAX);
        cookie.unwrap().reply().unwrap().data
    }
}

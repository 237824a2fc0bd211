//! Which of two window systems to use.

use std::{
    env,
    ffi::OsString,
    io::{self, Read, Write},
    os::unix::net::UnixStream,
    path::{Path, PathBuf},
    sync::mpsc,
    time::Duration,
};

/// How long a Wayland compositor may take to answer.
const PATIENCE: Duration = Duration::from_secs(4);

/// What to do about the window system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Choice {
    /// winit takes Wayland if it is named, else X11.
    Usual,
    /// X11, although a Wayland compositor is named.
    X11,
    /// Nothing: the only one that is named never answers.
    Silent,
}

/// How a Wayland compositor answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Answer {
    Yes,
    /// Nobody listens, or the connection ends.
    No,
    /// It takes the connection, and nothing follows.
    None,
}

/// Chooses. A compositor may be named and not answer: under xvfb-run, after `ssh -X`, in a tmux that is older than the session,
/// or because it hangs. winit takes Wayland if it is named, connects only once in a process, and waits forever.
pub(super) fn choice() -> Choice {
    let set = |name| env::var_os(name).filter(|value| !value.is_empty());
    let runtime = env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from);
    // An open connection cannot be tried: it would be used up.
    let (None, Some(wayland)) = (set("WAYLAND_SOCKET"), set("WAYLAND_DISPLAY")) else {
        return Choice::Usual;
    };
    let answer = answer(wayland, runtime.as_deref(), PATIENCE);
    match (answer, set("DISPLAY")) {
        (Answer::Yes, _) | (Answer::No, None) => Choice::Usual,
        (Answer::No | Answer::None, Some(_)) => Choice::X11,
        (Answer::None, None) => Choice::Silent,
    }
}

/// How the Wayland compositor at this address answers within that time.
fn answer(name: OsString, runtime: Option<&Path>, patience: Duration) -> Answer {
    let path = PathBuf::from(name);
    // As in libwayland, which ignores a relative folder.
    let path = match runtime {
        _ if path.is_absolute() => path,
        Some(folder) if folder.is_absolute() => folder.join(path),
        _ => return Answer::No,
    };
    let (sender, answers) = mpsc::channel();
    // On a thread, because connecting has no time limit: it waits while the compositor's queue is full.
    let ask = move || drop(sender.send(greet(&path, patience)));
    // Without a thread no answer comes.
    let _ = super::on_thread(ask);
    match answers.recv_timeout(patience) {
        Ok(Ok(true)) => Answer::Yes,
        Ok(Err(error)) if !is_timeout(&error) => Answer::No,
        Ok(Ok(false)) => Answer::No,
        _ => Answer::None,
    }
}

/// Asks a compositor for a sign of life. Returns whether one came before the end of the connection.
fn greet(path: &Path, patience: Duration) -> io::Result<bool> {
    let mut stream = UnixStream::connect(path)?;
    stream.set_read_timeout(Some(patience))?;
    // Object 1, the display; the length in bytes and request 0, `sync`; the number of the object that answers.
    let sync = [1, 12 << 16, 2_u32].map(u32::to_ne_bytes);
    stream.write_all(sync.as_flattened())?;
    Ok(stream.read(&mut [0; 8])? > 0)
}

fn is_timeout(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut)
}

#[cfg(test)]
mod tests;

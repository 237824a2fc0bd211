//! Which of two window systems to use.

use std::{
    env,
    ffi::OsString,
    os::unix::net::UnixStream,
    path::{Path, PathBuf},
};

/// Whether to use X11 although a Wayland compositor is named: it does not answer, and X11 has a display. So it is under
/// xvfb-run, after `ssh -X`, and in a tmux that is older than the session. winit takes Wayland if it is named, and connects
/// only once in a process.
pub(super) fn needs_x11() -> bool {
    let set = |name| env::var_os(name).filter(|value| !value.is_empty());
    let runtime = env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from);
    match (set("WAYLAND_SOCKET"), set("WAYLAND_DISPLAY"), set("DISPLAY")) {
        (None, Some(wayland), Some(_)) => !answers(wayland, runtime.as_deref()),
        _ => false,
    }
}

/// Whether a Wayland compositor answers at this address.
fn answers(name: OsString, runtime: Option<&Path>) -> bool {
    let path = PathBuf::from(name);
    // As in libwayland, which ignores a relative folder.
    let path = match runtime {
        _ if path.is_absolute() => path,
        Some(folder) if folder.is_absolute() => folder.join(path),
        _ => return false,
    };
    UnixStream::connect(path).is_ok()
}

#[cfg(test)]
mod tests;

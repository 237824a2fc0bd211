//! The end of a process without memory: one sentence and an exit code, where Rust would abort.
//!
//! The program's allocator calls [`out_of_memory`]. It is the last resort: memory that can be estimated is refused before it
//! is allocated.

use crate::{cli::CliError, error::escape};
use std::{
    io::{Cursor, Write},
    path::Path,
    sync::{
        Mutex, TryLockError,
        atomic::{AtomicBool, Ordering},
    },
    thread,
    time::Duration,
};

/// The longest name in the sentence, bytes.
const MOST_NAME: usize = 200;

/// The current input, ready to be printed.
static INPUT: Mutex<String> = Mutex::new(String::new());

/// Why there is no more memory.
#[derive(Clone, Copy, Debug)]
pub enum MemoryRefusal {
    /// The process has reached its limit.
    Limit,
    /// The system refused an allocation of this many bytes.
    System(usize),
}

/// Sets the current input, for the sentence.
pub fn at_work_on(input: &Path) {
    let name = input.to_string_lossy();
    let name: String = escape(&name).chars().take(MOST_NAME / 4).collect();
    *INPUT.lock().unwrap_or_else(std::sync::PoisonError::into_inner) = name;
}

/// Ends the process with one sentence on standard error, without partial files. Allocates nothing.
pub fn out_of_memory(why: MemoryRefusal) -> ! {
    static FIRST: AtomicBool = AtomicBool::new(true);
    let exit = || -> ! { signal_hook::low_level::exit(CliError::Failed(String::new()).exit_code().into()) };
    if !FIRST.swap(false, Ordering::Relaxed) {
        // Another thread is ending the process, or this one: removing a file allocates if its path is long.
        thread::sleep(Duration::from_secs(2));
        exit();
    }
    let mut text = Cursor::new([0; MOST_NAME + 200]);
    // What does not fit is cut.
    let _ = text.write_all(b"error: ");
    let input = match INPUT.try_lock() {
        Ok(input) => Some(input),
        Err(TryLockError::Poisoned(input)) => Some(input.into_inner()),
        Err(TryLockError::WouldBlock) => None,
    };
    if let Some(input) = input.filter(|input| !input.is_empty()) {
        let _ = write!(text, "{}: ", *input);
    }
    let _ = match why {
        MemoryRefusal::Limit => {
            text.write_all(b"this takes more memory than the limit allows (see --max-memory)\n")
        }
        MemoryRefusal::System(bytes) => writeln!(
            text,
            "out of memory: the system refused {} MiB more",
            bytes.div_ceil(1 << 20)
        ),
    };
    let length = text.position() as usize;
    say(text.get_ref().get(..length).unwrap_or_default());
    crate::whole_file::abandon();
    exit()
}

/// Writes to standard error without its lock, which a thread without memory may hold.
#[cfg(target_os = "linux")]
fn say(text: &[u8]) {
    let _ = rustix::io::write(rustix::stdio::stderr(), text);
}

#[cfg(not(target_os = "linux"))]
fn say(text: &[u8]) {
    let _ = std::io::stderr().write_all(text);
}

//! Standard streams that are closed when the program starts.
//!
//! The standard library opens `/dev/null` for them before `main`, so that a picture written to a closed standard output
//! would be lost without an error. This runs earlier and opens it the wrong way round: standard input for writing only,
//! standard output for reading only, so that any use of them fails.
#![allow(unsafe_code, reason = "what runs before `main` has only the C library")]

/// The C runtime calls the functions in `.init_array` before `main`; those numbered 95 run before those without a number.
// SAFETY: the section holds pointers to functions of the C calling convention, and this is one.
#[used]
#[unsafe(link_section = ".init_array.00095")]
static OPEN_CLOSED: extern "C" fn() = open_closed;

/// Opens standard input and output if they are closed: `open` takes the lowest free descriptor.
extern "C" fn open_closed() {
    for (descriptor, wrong_way) in [(0, libc::O_WRONLY), (1, libc::O_RDONLY)] {
        // SAFETY: `fcntl` with F_GETFD has no effect.
        let is_closed = unsafe { libc::fcntl(descriptor, libc::F_GETFD) } == -1;
        if is_closed {
            // SAFETY: the name ends in a zero byte. If it cannot be opened, the standard library ends the program.
            unsafe { libc::open(c"/dev/null".as_ptr(), wrong_way) };
        }
    }
}

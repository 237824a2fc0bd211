//! The program: hands over to the library's command line and passes its exit code on.

mod allocator;
#[cfg(target_os = "linux")]
mod streams;

use std::process::ExitCode;

#[global_allocator]
static ALLOCATOR: allocator::Limited = allocator::Limited::new();

fn main() -> ExitCode {
    octray::cli::main(|bytes| ALLOCATOR.set_limit(bytes))
}

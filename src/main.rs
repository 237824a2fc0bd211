//! The program: checks the CPU, then hands over to the library's command line and passes its exit code on.

mod allocator;
mod cpu;
#[cfg(all(unix, target_arch = "x86_64", not(target_feature = "avx2")))]
mod sibling;

use std::process::ExitCode;

#[global_allocator]
static ALLOCATOR: allocator::Limited = allocator::Limited::new();

fn main() -> ExitCode {
    // On Linux the check has run before `main`; elsewhere it is the first thing here.
    if !cfg!(target_os = "linux") && cpu::lacks_instructions() {
        eprint!("{}", cpu::MESSAGE);
        return ExitCode::from(cpu::EXIT_CODE);
    }
    #[cfg(all(unix, target_arch = "x86_64", not(target_feature = "avx2")))]
    sibling::hand_over();
    octray::cli::main(|bytes| ALLOCATOR.set_limit(bytes))
}

//! Limits of a command.

use super::values;
use crate::cli::load::memory;
use clap::Args;

/// Memory that a command may take.
#[derive(Args, Clone, Copy, Debug)]
#[command(next_help_heading = "Limits")]
pub struct MemoryArgs {
    /// Memory limit, such as 512M or 16G; larger work is refused before it begins [default: three quarters of what the
    /// machine, the cgroup and `ulimit -v` allow]
    #[arg(long, value_name = "SIZE", value_parser = values::bytes)]
    pub max_memory: Option<u64>,
}

impl MemoryArgs {
    /// The limit, bytes.
    pub fn limit(self) -> u64 {
        memory::limit(self.max_memory)
    }
}

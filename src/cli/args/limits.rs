//! Limits of a command.

use super::values;
use crate::cli::{load::memory, process::useful_threads};
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

/// Threads that a command uses.
#[derive(Args, Clone, Copy, Debug)]
pub struct ThreadsArgs {
    /// Number of threads; at most 4 per CPU, or 64 if that is more [default: one per CPU]
    #[arg(short = 'j', long, value_name = "N", value_parser = values::whole::<4096>)]
    threads: Option<u32>,
}

impl ThreadsArgs {
    /// How many to start; `None` for one per CPU.
    pub fn count(self) -> Option<u32> {
        self.threads.map(useful_threads)
    }
}

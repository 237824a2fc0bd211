//! The process itself: its signals, its threads, and its end without memory.

mod interrupt;
mod level;
mod memory;
mod threads;

pub use interrupt::{Interrupt, end_by_signal};
pub use level::hold_level;
pub use memory::{MemoryRefusal, at_work_on, out_of_memory};
pub use threads::{start as start_threads, useful as useful_threads};

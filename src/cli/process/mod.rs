//! The process itself: its signals and its threads.

mod interrupt;
mod threads;

pub use interrupt::Interrupt;
pub use threads::{start as start_threads, useful as useful_threads};

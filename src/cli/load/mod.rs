//! From a plan's input to a scene in memory, its camera and its lights.

mod camera;
pub mod faults;
mod input;
pub mod memory;
mod stage;

pub use input::{Input, load_and_list, load_bare, show_mesh};

//! Loads a plan's input: a scene in memory, with camera and lights.

mod camera;
mod environment;
pub mod faults;
mod input;
pub mod memory;
mod stage;

pub use input::{Input, load_and_list, load_bare, show_mesh};
pub use stage::Rig;

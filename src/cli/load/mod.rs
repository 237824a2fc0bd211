//! Loads a plan's input: a scene in memory, with camera and lights.

mod camera;
mod color;
mod environment;
pub mod faults;
mod input;
pub mod memory;
mod playback;
mod stage;

pub use color::Legend;
pub use input::{Input, load_and_list, load_bare, load_bytes, load_frame, show_mesh};
pub use playback::Poses;
pub use stage::Rig;

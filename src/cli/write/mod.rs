//! The files that a call writes: pictures, their AOVs, comparisons, JSON.

mod animation;
mod aov;
mod aov_files;
mod color_bar;
mod compare;
mod decode;
mod encode;
mod exr_layers;
mod json;
mod letters;
mod mark;
mod merge;
mod output;
mod palette;
mod picture;
mod place;
mod replace;
mod samples;
mod sheet;

pub use animation::Animation;
pub use aov::{AovKind, Axis, DepthRange, Z_STEP, instance_number};
pub use aov_files::{AovFiles, RenderedAovs};
pub use color_bar::{ColorBar, SMALLEST as SMALLEST_WITH_BAR};
pub use compare::{Comparison, Verdict};
pub use encode::{Format, is_animation};
pub use json::{json_line, write_json};
pub use merge::Tiles;
pub use output::{Output, check_writable, names_directory};
pub use picture::{Picture, Pixels};
pub use replace::{Inputs, identity, is_foreign};
pub use sheet::{Sheet, sheet_size};

//! Tests of the command line, in one program: linking takes longer than running them.

#[path = "../common/images.rs"]
mod images;
#[path = "../common/long.rs"]
mod long;
#[path = "../common/program.rs"]
mod program;
#[cfg(feature = "viewer")]
mod window;

// The longest test begins first: they start in the order of their names.
#[cfg(feature = "viewer")]
mod a_window;
mod animations;
mod cli;
mod cli_batch;
mod cli_config;
mod cli_docs;
mod cli_output;
mod cli_together;
mod cli_verify;
mod colors;
mod crops;
mod distortion;
mod edges;
mod environments;
mod faults;
mod inputs_kept;
mod job;
mod json;
mod left_out;
mod levels;
mod limits;
mod map_coordinates;
mod meant;
mod merge;
mod mesh_pictures;
mod moving;
mod options;
mod overwriting;
mod package;
mod picture_files;
mod playback;
mod points;
mod poses;
mod poses_in_parts;
mod sheets;
mod shell;
mod signals;
#[cfg(target_os = "linux")]
mod strangers;

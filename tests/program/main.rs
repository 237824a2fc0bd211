//! Tests of the command line, in one program: linking takes longer than running them.

#[path = "../common/images.rs"]
mod images;
#[path = "../common/program.rs"]
mod program;
#[cfg(feature = "viewer")]
mod window;

mod cli;
mod cli_batch;
mod cli_config;
mod cli_docs;
mod cli_output;
mod cli_together;
mod cli_verify;
mod crops;
mod faults;
mod limits;
mod mesh_pictures;
mod old_cpu;
mod options;
mod overwriting;
mod package;
mod picture_files;
#[cfg(feature = "viewer")]
mod viewer_window;

//! The Python module `octray._octray`: the functions that the package `octray` (in `octray/`) wraps, with contiguous arrays
//! of the right types.

mod arrays;
mod camera;
mod hits;
mod mesh;
mod picture;
mod rays;
mod scene;
mod shared;
mod solid;
mod threads;
mod whole;
mod words;

use pyo3::prelude::*;
use std::ffi::OsString;

/// Runs the program `octray` with arguments, the program's name first; returns its exit code.
#[pyfunction]
fn program(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| octray::cli::run(arguments, |_| {}))
}

/// Names the instruction set in use.
#[pyfunction]
fn isa() -> String {
    octray::isa().to_string()
}

#[pymodule]
fn _octray(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<mesh::Mesh>()?;
    module.add_class::<scene::Scene>()?;
    module.add_function(wrap_pyfunction!(picture::render, module)?)?;
    module.add_function(wrap_pyfunction!(camera::camera_rays, module)?)?;
    module.add_function(wrap_pyfunction!(whole::load, module)?)?;
    module.add_function(wrap_pyfunction!(whole::parts, module)?)?;
    module.add_function(wrap_pyfunction!(whole::of_parts, module)?)?;
    module.add_function(wrap_pyfunction!(program, module)?)?;
    module.add_function(wrap_pyfunction!(isa, module)?)
}

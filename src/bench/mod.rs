//! The workload that speed is judged by, and how it is measured: the same rays for every way of tracing, one
//! thread, and no figure without agreement.

mod measure;
mod workload;

pub use measure::{FrameTimes, Measurement, Method, compare, frame_times};
pub use workload::{Kind, RaySet, Workload};

//! The workload that speed is judged by, and how it is measured: the same rays for every way of tracing, one
//! thread, and no figure without agreement.

mod machine;
mod measure;
mod suite;
mod workload;

pub use machine::machine;
pub use measure::{FrameTimes, Measurement, Method, Results, compare, frame_times, reference, trace_set};
pub use suite::{SuiteError, SuiteScene, quick_suite, suite};
pub use workload::{Kind, RaySet, Workload};

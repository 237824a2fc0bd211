//! The workload that speed is judged by, and how it is measured: the same rays for every way of tracing, one
//! thread, and no figure without agreement; whole frames with one thread and with all.

mod frame;
mod machine;
mod measure;
mod suite;
mod workload;

pub use frame::{FrameTimes, frame_times};
pub use machine::machine;
pub use measure::{Measurement, Method, Results, compare, reference, trace_set};
pub use suite::{SuiteError, SuiteScene, quick_suite, suite};
pub use workload::{Kind, RaySet, Workload};

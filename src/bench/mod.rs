//! The benchmark: a fixed workload of rays, traced by every method on one thread with results compared bit for bit, and
//! whole frames on one and on all threads.

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

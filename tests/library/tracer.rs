//! The tracer against single rays: bundles, groups, entries, planes, sinks.

mod entry;
mod planes;
mod run;
mod sink;

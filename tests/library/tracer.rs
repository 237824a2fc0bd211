//! The tracer against single rays: bundles, groups, entries, planes, sinks.

mod bundle;
mod entry;
mod planes;
mod run;
mod sink;

#![no_main]

#[path = "../../tests/library/targets/mod.rs"]
#[allow(dead_code, reason = "each target uses its own function")]
mod targets;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| targets::vtk(bytes));

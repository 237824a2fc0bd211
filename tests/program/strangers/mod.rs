//! Untrusted files: whatever they contain, the program ends soon, within its memory, with at most one safe sentence.

mod command;
mod harness;
mod mesh;
mod process;
mod scene;

pub use harness::Call;

#[test]
fn the_harness_measures() {
    let folder = crate::program::Folder::new();
    let call = Call::new(&folder, &["a.scn", "--size", "16x16", "--quiet"]).run();
    assert_eq!(call.code, Some(0), "{call:?}");
    assert!(call.peak > 1 << 20, "{call:?}");
}

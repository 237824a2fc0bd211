//! Tests of `camera`.

use super::*;
use clap::Command;

fn names_of<A: Args>() -> Vec<String> {
    let command = A::augment_args(Command::new("octray"));
    command
        .get_arguments()
        .map(|argument| argument.get_id().to_string())
        .collect()
}

#[test]
fn all_options_are_listed() {
    assert_eq!(names_of::<CameraArgs>(), OPTIONS);
    assert_eq!(names_of::<MeshArgs>(), MESH_OPTIONS);
}

//! Tests of `generate`.

use super::*;
use crate::generate::{Kind, Options};

fn plan(kind: Kind, folder: &Path, seed: u64, count: usize) -> GeneratePlan {
    GeneratePlan {
        kind,
        options: Options {
            seed,
            count: Some(count),
        },
        folder: folder.to_owned(),
        force: false,
        json: None,
    }
}

#[test]
fn files_appear_and_the_command_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path().join("made here");
    let (told, json) = write(&plan(Kind::Terrain, &folder, 3, 200)).unwrap();
    assert!(told.contains("made here/terrain.scn' --eye="), "{told}");
    assert_eq!((json.meshes.len(), json.spheres), (1, 0));
    let mut names: Vec<_> = fs::read_dir(&folder)
        .unwrap()
        .map(|f| f.unwrap().file_name())
        .collect();
    names.sort();
    assert_eq!(names, ["terrain.ply", "terrain.scn"]);
    let text = fs::read_to_string(folder.join("terrain.scn")).unwrap();
    assert!(text.contains("\nply_file terrain.ply\n"), "{text}");
}

#[test]
fn counts_out_of_range_are_usage_errors() {
    let folder = tempfile::tempdir().unwrap();
    // The largest is refused by its number, also where memory is short.
    for count in [3, usize::MAX] {
        let error = run(&plan(Kind::Blobs, folder.path(), 0, count)).unwrap_err();
        assert_eq!(error.exit_code(), 2);
        assert!(error.text().unwrap().contains("expected 1000 to"));
    }
}

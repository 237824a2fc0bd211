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
fn too_small_counts_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let text = run(&plan(Kind::Blobs, folder.path(), 0, 3)).unwrap_err().text();
    assert!(text.unwrap().contains("expected 1000 to"));
}

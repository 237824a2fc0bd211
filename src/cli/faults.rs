//! Faults in a mesh's data: what is counted when, and when it is worth a warning.

use crate::scene::{MeshFaults, Scene};
use std::path::Path;

/// In meshes above this many triangles a rendering counts only those without area: the rest takes as long as the BVH.
/// `octray info` counts always.
const MOST_COUNTED: usize = 250_000;

/// What is known of a scene's faults.
pub struct Faults {
    triangles: usize,
    degenerate: usize,
    pub duplicate: Option<usize>,
    pub inverted: Option<usize>,
}

/// Counts the faults of a scene that is about to be rendered.
pub fn of(scene: &Scene) -> Faults {
    let triangles = scene.triangles().corners.len();
    let counted: Option<MeshFaults> = (triangles <= MOST_COUNTED).then(|| scene.mesh_faults());
    Faults {
        triangles,
        degenerate: scene.degenerate_triangles(),
        duplicate: counted.map(|faults| faults.duplicate),
        inverted: counted.map(|faults| faults.inverted),
    }
}

impl Faults {
    /// A few faults are normal in meshes made by programs; more than 1 % hint at a broken one.
    pub fn warning(&self, path: &Path) -> Option<String> {
        let many = self.triangles / 100;
        let kinds = [
            (Some(self.degenerate), "have no area and are never hit"),
            (self.duplicate, "are there more than once"),
            (self.inverted, "face the other way than their neighbours"),
        ];
        let said: Vec<String> = kinds
            .iter()
            .filter_map(|&(count, what)| Some(format!("{} {what}", count.filter(|&count| count > many)?)))
            .collect();
        let said = said.join(", ");
        let path = crate::error::escape(&path.display().to_string()).into_owned();
        (!said.is_empty()).then(|| format!("{path}: of {} triangles {said}", self.triangles))
    }
}

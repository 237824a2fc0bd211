//! Defects of a mesh: which are counted, and when to warn.

use crate::{
    error::clip_path,
    format::mesh::Coarse,
    math::Aabb,
    scene::{MeshFaults, Scene},
};
use std::path::Path;

/// Larger meshes are only checked for triangles without area: the other checks take as long as building the BVH.
/// `octray info` always checks all.
const MOST_COUNTED: usize = 250_000;

/// A scene's faults that were counted.
pub struct Faults {
    triangles: usize,
    degenerate: usize,
    pub duplicate: Option<usize>,
    pub inverted: Option<usize>,
}

/// Counts the faults of a scene before it is rendered.
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

/// A warning if a mesh is so far from 0 for its size that its coordinates are coarse, such as coordinates of a map in metres,
/// and its file has no finer ones.
pub fn coarse(path: &Path, bounds: &Aabb) -> Option<String> {
    let coarse = Coarse::of(bounds).filter(|coarse| coarse.size > 0.0);
    coarse.map(|Coarse { far, step, size }| {
        format!(
            "{}: its coordinates go up to {far}, where they are rounded to steps of {step}, but it is only {size} long: \
             subtract an offset from them",
            clip_path(path)
        )
    })
}

impl Faults {
    /// A warning if more than 1 % of the triangles have a fault: a few are normal in exported meshes.
    pub fn warning(&self, path: &Path) -> Option<String> {
        let many = self.triangles / 100;
        let kinds = [
            (Some(self.degenerate), "without area (never hit)"),
            (self.duplicate, "duplicate"),
            (self.inverted, "facing the opposite way to their neighbours"),
        ];
        let said: Vec<String> = kinds
            .iter()
            .filter_map(|&(count, what)| Some(format!("{} {what}", count.filter(|&count| count > many)?)))
            .collect();
        let said = said.join(", ");
        let path = clip_path(path);
        let all = match self.triangles {
            1 => "of 1 triangle".to_owned(),
            count => format!("of {count} triangles"),
        };
        (!said.is_empty()).then(|| format!("{path}: {all}, {said}"))
    }
}

#[cfg(test)]
mod tests;

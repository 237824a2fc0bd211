//! Meshes in memory that a picture stores once and places any number of times.

use super::MeshArrays;
use crate::{
    error::LoadError,
    format::{
        mesh::{LoadedMesh, SharedMesh, Surface, UpAxis, UpSource},
        ply,
    },
    ray::InstanceId,
    render::Aov,
    scene::{Scene, Transform},
};
use std::path::Path;

/// A mesh in memory and its placements.
#[derive(Debug, Default)]
pub struct PlacedArrays {
    pub mesh: MeshArrays,
    /// Each of them can place an instance.
    pub placements: Vec<Transform>,
    /// The index of each placement's instance among those of all meshes.
    pub instances: Vec<u32>,
}

/// Returns meshes and their placements as one mesh, whose z axis points up. `name` stands for it in notes; the colours of
/// triangles may take `memory` bytes.
pub(super) fn loaded(parts: Vec<PlacedArrays>, name: &Path, memory: u64) -> Result<LoadedMesh, LoadError> {
    let mut mesh = LoadedMesh {
        up: UpAxis::Z,
        up_source: UpSource::Stated,
        ..LoadedMesh::default()
    };
    let colors: Vec<[f32; 3]> = parts
        .iter()
        .flat_map(|part| part.mesh.face_colors())
        .copied()
        .collect();
    if !colors.is_empty() {
        ply::paint_triangles(&mut mesh, &colors, name, memory)?;
    }
    let mut painted = std::mem::take(&mut mesh.surface_of).into_iter();
    // Those of meshes without colours, and with colours of vertices.
    let neutral = mesh.surfaces.len() as u32;
    mesh.surfaces.extend([Surface::NEUTRAL, Surface::WHITE]);
    mesh.shared = parts
        .into_iter()
        .map(|PlacedArrays { mesh, placements, .. }| {
            let count = mesh.face_colors().len();
            let columns = mesh.columns;
            let surface_of = if count > 0 {
                painted.by_ref().take(count).collect()
            } else {
                vec![neutral + u32::from(!columns.colors.is_empty()); columns.triangles.len()]
            };
            SharedMesh {
                columns,
                surface_of,
                placements,
            }
        })
        .collect();
    Ok(mesh)
}

/// Numbers hits in instances by their triangle in its mesh and by `instances`, which has the index of each.
pub(super) fn number(pixels: &mut [Aov], scene: &Scene, instances: &[u32]) {
    for pixel in pixels
        .iter_mut()
        .filter(|pixel| pixel.instance != InstanceId::NONE)
    {
        let i = pixel.instance.0 as usize;
        let prototype = &scene.prototypes()[scene.instances()[i].prototype().0 as usize];
        pixel.primitive.0 -= prototype.triangles.start;
        pixel.instance = InstanceId(instances[i]);
    }
}

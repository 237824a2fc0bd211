//! The memory that a scene takes.

use crate::error::SceneError;

/// Peak memory of building the BVH, the BVH included, bytes per primitive.
// Tuned: see docs/lab-notes.md#bvh-bytes
pub const BVH_BYTES: u64 = 100;
/// Corners and material.
const TRIANGLE_BYTES: u64 = 16;
/// Centre, radius and material.
const SPHERE_BYTES: u64 = 20;
/// Three numbers of a position, a normal or a colour; texture coordinates and a tangent are six.
const VECTOR_BYTES: u64 = 12;

/// Checks that `[triangles, spheres, positions + normals + colours + texture coordinates]` and the build of their BVH fit
/// into `limit` bytes, beside `others` bytes of the scene. Counts fit into 32 bits each, so no sum of them overflows.
///
/// # Errors
/// [`SceneError::OverLimit`].
#[doc(hidden)]
pub fn check_memory(counts: [usize; 3], others: u64, limit: u64) -> Result<(), SceneError> {
    let [triangles, spheres, vectors] = counts.map(|count| count as u64);
    let needed = triangles * TRIANGLE_BYTES
        + spheres * SPHERE_BYTES
        + vectors * VECTOR_BYTES
        + (triangles + spheres) * BVH_BYTES;
    let needed = needed.saturating_add(others);
    if needed > limit {
        return Err(SceneError::OverLimit { needed, limit });
    }
    Ok(())
}

//! Stores geometries as prototypes, and places them relative to the middle of the scene.

use crate::{
    error::SceneError,
    query::{
        Geometry, QueryError,
        coordinates::{copied, far_middle},
    },
    scene::{MaterialId, PrototypeId, Scene, SceneBuilder, Transform, TriangleMesh},
};
use glam::DVec3;
use rayon::prelude::*;

/// What is kept of a geometry besides its prototype.
#[derive(Debug)]
pub(super) struct Part {
    /// World space; `None` if it is empty.
    pub bounds: Option<[DVec3; 2]>,
    pub middle: DVec3,
}

/// The box around the image of a box.
fn placed_box([lower, upper]: [DVec3; 2], transform: &Transform) -> [DVec3; 2] {
    let (linear, offset) = transform.about(DVec3::ZERO);
    let (mut least, mut most) = (offset, offset);
    for axis in 0..3 {
        let (from, to) = (linear.col(axis) * lower[axis], linear.col(axis) * upper[axis]);
        (least, most) = (least + from.min(to), most + from.max(to));
    }
    [least, most]
}

/// The coordinate of a box that is farthest from those of a point.
fn farthest(bounds: Option<[DVec3; 2]>, from: DVec3) -> f64 {
    let corners = bounds.into_iter().flatten();
    let each = corners.flat_map(|corner| corner.to_array().into_iter().zip(from.to_array()));
    let most = each.max_by(|(a, x), (b, y)| (a - x).abs().total_cmp(&(b - y).abs()));
    most.map_or(f64::NAN, |(value, _)| value)
}

/// Refuses transforms with numbers that are not finite.
pub(super) fn check_finite<'t>(
    mut transforms: impl Iterator<Item = &'t Transform>,
) -> Result<(), QueryError> {
    let wrong = transforms.position(|transform| !transform.is_finite());
    wrong.map_or(Ok(()), |instance| Err(QueryError::NotFinite { instance }))
}

/// Stores a geometry as a prototype.
pub(super) fn add(builder: &mut SceneBuilder, geometry: &Geometry) -> Result<(), QueryError> {
    let (vertices, spheres) = (geometry.scene().vertices(), geometry.scene().spheres());
    let mesh = TriangleMesh {
        x: copied(&vertices.x, "the vertices")?,
        y: copied(&vertices.y, "the vertices")?,
        z: copied(&vertices.z, "the vertices")?,
        triangles: copied(geometry.triangles(), "the triangles")?,
        ..TriangleMesh::default()
    };
    builder.add_prototype(|builder| {
        builder.add_mesh(mesh, MaterialId(0))?;
        let mut all = spheres.radius.iter().enumerate();
        all.try_for_each(|(i, &radius)| builder.add_sphere(spheres.center(i), radius, MaterialId(0)))
    })?;
    Ok(())
}

/// Placed geometries, before the hierarchy.
pub(super) struct Placed {
    pub scene: Scene,
    pub offset: DVec3,
    pub bounds: Option<[DVec3; 2]>,
}

impl Placed {
    /// Places prototypes; `instance` returns the mesh and the transform of each instance that is in the scene.
    pub(super) fn new<'t>(
        prototypes: &Scene,
        parts: &[Part],
        kept: Option<&[u32]>,
        count: usize,
        instance: impl Fn(usize) -> (usize, &'t Transform) + Sync,
    ) -> Result<Self, QueryError> {
        let in_scene = kept.map_or(count, <[u32]>::len);
        let box_of = |i: usize| {
            let (mesh, transform) = instance(i);
            parts[mesh].bounds.map(|bounds| placed_box(bounds, transform))
        };
        let both = |[a, b]: [DVec3; 2], [c, d]: [DVec3; 2]| [a.min(c), b.max(d)];
        let boxes = (0..in_scene).into_par_iter().with_min_len(1 << 10);
        let bounds = boxes.filter_map(box_of).reduce_with(both);
        let offset = bounds.map_or(DVec3::ZERO, far_middle);
        let placed = prototypes.placed(in_scene, |i| {
            let (mesh, transform) = instance(i);
            let from_middle = Transform::IDENTITY.then_translate(parts[mesh].middle);
            let placed = from_middle.then_transform(transform).then_translate(-offset);
            (PrototypeId(mesh as u32), placed)
        });
        let refused = |(i, error): (usize, SceneError)| {
            let index = kept.map_or(i, |kept| kept[i] as usize);
            match error {
                SceneError::Flat => QueryError::Flat { instance: index },
                SceneError::NotUsable { .. } => QueryError::Coordinate {
                    what: "instance",
                    index,
                    value: farthest(box_of(i), offset),
                },
                other => other.into(),
            }
        };
        Ok(Self {
            scene: placed.map_err(refused)?,
            offset,
            bounds,
        })
    }
}

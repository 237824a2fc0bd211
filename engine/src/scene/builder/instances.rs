//! Adding prototypes and instances.

use super::{MIN_PIECE, SceneBuilder, Vertices, check_memory};
use crate::{
    error::SceneError,
    math::{Aabb, max},
    scene::{
        Instance, MAX_INSTANCES, MAX_PROTOTYPES, Prototype, PrototypeId, Scene, SceneId, Spheres, Transform,
        instance::Unplaced, origin::origin_of,
    },
};
use glam::Vec3;
use rayon::prelude::*;
use std::{ops::Range, sync::Arc};

/// An instance, before and after it is placed, and its share of the hierarchy's build; bytes.
#[doc(hidden)]
pub const INSTANCE_BYTES: u64 = 260;

/// The numbers of triangles, spheres and vertices before a prototype.
#[derive(Clone, Copy)]
#[doc(hidden)]
pub struct StartOfPrototype([u32; 3]);

impl SceneBuilder {
    /// Adds a prototype of the triangles and spheres that `add` adds. They appear in the scene only where instances place them.
    ///
    /// # Errors
    /// That of `add`, [`SceneError::Nested`] if `add` adds instances or prototypes, or [`SceneError::TooMany`]. What was added
    /// until then stays in the scene.
    pub fn add_prototype(
        &mut self,
        add: impl FnOnce(&mut Self) -> Result<(), SceneError>,
    ) -> Result<PrototypeId, SceneError> {
        let start = self.start_prototype();
        let [prototypes, instances] = [self.prototypes.len(), self.instances.len()];
        add(self)?;
        if [self.prototypes.len(), self.instances.len()] != [prototypes, instances] {
            return Err(SceneError::Nested);
        }
        self.end_prototype(start)
    }

    /// Begins a prototype: whatever is added from now on is part of it.
    #[doc(hidden)]
    pub fn start_prototype(&self) -> StartOfPrototype {
        StartOfPrototype(self.counts())
    }

    /// Ends a prototype.
    #[doc(hidden)]
    pub fn end_prototype(&mut self, start: StartOfPrototype) -> Result<PrototypeId, SceneError> {
        if self.prototypes.len() >= MAX_PROTOTYPES {
            return Err(SceneError::TooMany {
                what: "prototypes",
                limit: MAX_PROTOTYPES,
            });
        }
        let StartOfPrototype([triangles, spheres, vertices]) = start;
        let [more_triangles, more_spheres, more_vertices] = self.counts();
        let mut prototype = Prototype {
            triangles: triangles..more_triangles,
            spheres: spheres..more_spheres,
            vertices: vertices..more_vertices,
            bounds: Aabb::EMPTY,
            center: Vec3::ZERO,
            scale: 1.0,
        };
        let corners = &self.triangles.corners[triangles as usize..more_triangles as usize];
        prototype.move_to_center(corners, &mut self.vertices, &mut self.spheres);
        self.prototypes.push(prototype);
        Ok(PrototypeId(self.prototypes.len() as u32 - 1))
    }

    /// Adds an instance of a prototype, placed by `transform`. Instances of empty prototypes are left out.
    ///
    /// # Errors
    /// [`SceneError::Flat`], [`SceneError::NotUsable`] if it ends up too far away, [`SceneError::TooMany`] or
    /// [`SceneError::OverLimit`].
    ///
    /// # Panics
    /// If the scene has no such prototype.
    pub fn add_instance(&mut self, prototype: PrototypeId, transform: &Transform) -> Result<(), SceneError> {
        let of = &self.prototypes[prototype.0 as usize];
        if of.is_empty() {
            return Ok(());
        }
        let instance = Unplaced::new(of, prototype, transform)?;
        self.check_instances(1)?;
        self.instances.push(instance);
        Ok(())
    }

    /// Checks that this many more instances are allowed, and fit into memory.
    ///
    /// # Errors
    /// [`SceneError::TooMany`] or [`SceneError::OverLimit`].
    #[doc(hidden)]
    pub fn check_instances(&self, more: usize) -> Result<(), SceneError> {
        if more > MAX_INSTANCES - self.instances.len() {
            return Err(SceneError::TooMany {
                what: "instances",
                limit: MAX_INSTANCES,
            });
        }
        let [triangles, spheres, vertices] = self.counts().map(|count| count as usize);
        let counts = [triangles, spheres, vertices + self.vectors()];
        check_memory(counts, self.other_bytes(more), self.memory)
    }

    fn counts(&self) -> [u32; 3] {
        [
            self.triangles.corners.len() as u32,
            self.spheres.radius.len() as u32,
            self.vertices.x.len() as u32,
        ]
    }
}

impl Prototype {
    /// Moves its positions, if they are far from 0, and scales them to about 1; finds its bounds. Vertices that no triangle of
    /// `corners` uses do not count.
    fn move_to_center(&mut self, corners: &[[u32; 3]], vertices: &mut Vertices, spheres: &mut Spheres) {
        let usize_range = |range: &Range<u32>| range.start as usize..range.end as usize;
        let (v, s) = (usize_range(&self.vertices), usize_range(&self.spheres));
        let of_piece = |piece: &[[u32; 3]]| {
            let used = piece.as_flattened().iter();
            Aabb::around(used.map(|&vertex| vertices.position(vertex)))
        };
        let pieces = corners.par_chunks(MIN_PIECE).map(of_piece);
        let mut bounds = pieces.reduce(|| Aabb::EMPTY, Aabb::union);
        for i in s.clone() {
            let (center, radius) = (spheres.center(i), Vec3::splat(spheres.radius[i]));
            bounds = bounds.union(Aabb {
                lower: center - radius,
                upper: center + radius,
            });
        }
        if bounds.is_empty() {
            return;
        }
        self.enclose(bounds);
        let of_vertices = [&mut vertices.x, &mut vertices.y, &mut vertices.z].map(|x| &mut x[v.clone()]);
        let centers = [
            &mut spheres.center_x,
            &mut spheres.center_y,
            &mut spheres.center_z,
        ];
        let centers = centers.map(|x| &mut x[s.clone()]);
        for columns in [of_vertices, centers] {
            for (column, center) in columns.into_iter().zip(self.center.to_array()) {
                for x in column {
                    *x = (*x - center) * self.scale;
                }
            }
        }
        for radius in &mut spheres.radius[s] {
            *radius = max(*radius * self.scale, f32::MIN_POSITIVE);
        }
    }
}

/// The box around instances, in world space.
pub(in crate::scene) fn bounds(prototypes: &[Prototype], instances: &[Unplaced]) -> Aabb {
    let of_one = |instance: &Unplaced| {
        let instance = instance.at(Vec3::ZERO);
        let prototype = &prototypes[instance.prototype().0 as usize];
        instance.placement().bounds(prototype.bounds)
    };
    let boxes = instances.par_iter().with_min_len(1 << 10).map(of_one);
    boxes.reduce(|| Aabb::EMPTY, Aabb::union)
}

/// The instances of a scene with this origin.
pub(super) fn placed(instances: &[Unplaced], origin: Vec3) -> Vec<Instance> {
    let instances = instances.par_iter().with_min_len(1 << 10);
    instances.map(|instance| instance.at(origin)).collect()
}

impl Scene {
    /// Returns a scene of these prototypes, which it shares, with `count` other instances and nothing else. A BVH of this scene
    /// can [follow](crate::accel::Bvh::follow) it if both have instances. `instance` returns the prototype of each, which is not
    /// empty, and its placement.
    ///
    /// # Errors
    /// The index of the first instance that cannot be placed, and why: as [`SceneBuilder::add_instance`].
    pub(crate) fn placed(
        &self,
        count: usize,
        instance: impl Fn(usize) -> (PrototypeId, Transform) + Sync,
    ) -> Result<Self, (usize, SceneError)> {
        if count > MAX_INSTANCES {
            let (what, limit) = ("instances", MAX_INSTANCES);
            return Err((limit, SceneError::TooMany { what, limit }));
        }
        let unplaced = |i: usize| {
            let (id, transform) = instance(i);
            Unplaced::new(&self.prototypes[id.0 as usize], id, &transform).map_err(|error| (i, error))
        };
        let all: Result<Vec<Unplaced>, _> = (0..count)
            .into_par_iter()
            .with_min_len(1 << 10)
            .map(&unplaced)
            .collect();
        // Any thread may be the first to fail.
        let all = all.map_err(|any| (0..count).find_map(|i| unplaced(i).err()).unwrap_or(any))?;
        let mut scene = SceneBuilder::new().finish();
        scene.vertices = Arc::clone(&self.vertices);
        scene.triangles = Arc::clone(&self.triangles);
        scene.spheres = Arc::clone(&self.spheres);
        scene.prototypes.clone_from(&self.prototypes);
        scene.degenerate = self.degenerate;
        scene.moving.meshes = self.moving.meshes;
        scene.id = SceneId::next();
        scene.bounds = bounds(&scene.prototypes, &all);
        scene.origin = origin_of(scene.bounds);
        scene.instances = placed(&all, scene.origin);
        Ok(scene)
    }
}

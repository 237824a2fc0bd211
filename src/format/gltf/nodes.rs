//! The node tree: transforms, meshes, cameras and lights.
//!
//! Everything that the nodes place is counted before any of it is built, so that a file that places a mesh a million times
//! is refused at once, or stores it once.

use super::{
    arrays::{Arrays, COLORED, NO_SURFACE, Room, scale},
    buffers::Buffers,
    instancing::{Instances, Instancing},
    lights::PunctualLights,
    materials::Shown,
    shapes::{Shape, shapes_of},
    sharing,
    translations::Translations,
};
use crate::{
    error::{LoadError, SceneError},
    format::{
        mesh::{
            Cloud, LINE_TRIANGLES, LoadedMesh, MAX_CAMERAS, MeshCamera, SharedMesh, Sharing, Surface, UpAxis,
            UpSource, camera_name, clamped_note, most_triangles,
        },
        textures,
    },
    scene::{INSTANCE_BYTES, Light, MAX_INSTANCES, Placing, Projection, Transform, check_memory},
};
use glam::{DMat4, DVec3};
use gltf::Document;
use std::path::Path;

/// A node with a mesh, a camera or a light, and its transform.
struct Placement<'a> {
    node: usize,
    /// Relative to the offset of the file.
    world: DMat4,
    /// The instances of its mesh; `None` for a single placement.
    instances: Option<Instances<'a>>,
}

impl Placement<'_> {
    /// How many times it places its mesh.
    fn count(&self) -> usize {
        self.instances.as_ref().map_or(1, |instances| instances.count)
    }

    /// Where it places its mesh the `i`th time.
    fn at(&self, i: usize, buffers: &Buffers<'_>) -> Result<DMat4, LoadError> {
        match &self.instances {
            Some(instances) => Ok(self.world * instances.transform(i, buffers)?),
            None => Ok(self.world),
        }
    }
}

/// A mesh whose shapes are read.
struct ReadMesh<'a> {
    shapes: Vec<Shape<'a>>,
    triangles: usize,
    /// How many placements are left.
    placements: usize,
    /// The number of its shared part, if it is stored once.
    part: Option<usize>,
}

/// A mesh that is stored once.
#[derive(Default)]
struct Part {
    arrays: Arrays,
    placements: Vec<Transform>,
    /// Once the arrays are there.
    placing: Option<Placing>,
}

/// The mesh so far.
#[derive(Default)]
pub(super) struct Reading {
    /// Baked meshes.
    baked: Arrays,
    parts: Vec<Part>,
    /// How many triangles there are room for, and how many there may be.
    triangles: usize,
    most_triangles: usize,
    cameras: Vec<MeshCamera>,
    lights: Vec<Light>,
    /// Whether the file has points or lines and no triangles.
    is_cloud: bool,
    has_lines: bool,
    /// The lights of the file.
    pub(super) punctual: PunctualLights,
    /// How many cameras there are beyond the limit.
    pub(super) cameras_left_out: usize,
    /// How many placements of shared meshes collapse them to lines or points.
    pub(super) collapsed: usize,
}

impl Reading {
    pub(super) fn new(punctual: PunctualLights, is_cloud: bool) -> Self {
        Self {
            is_cloud,
            punctual,
            ..Self::default()
        }
    }

    /// Reads the default scene, else the first one, else all root nodes.
    pub(super) fn scene(
        &mut self,
        document: &Document,
        materials: &[Shown],
        placed: (&Instancing, &Translations),
        buffers: &mut Buffers<'_>,
    ) -> Result<(), LoadError> {
        let placements = placements(document, &self.punctual, placed, buffers)?;
        check_instances(&placements, buffers)?;
        let mut meshes: Vec<Option<ReadMesh<'_>>> = document.meshes().map(|_| None).collect();
        let node_of = |placement: &Placement<'_>| document.nodes().nth(placement.node);
        for placement in &placements {
            let Some(mesh) = node_of(placement).and_then(|node| node.mesh()) else {
                continue;
            };
            let shapes = &mut meshes[mesh.index()];
            if shapes.is_none() {
                let of_mesh = shapes_of(&mesh, materials, self.is_cloud, buffers)?;
                *shapes = Some(ReadMesh {
                    triangles: of_mesh
                        .iter()
                        .map(Shape::triangle_count)
                        .fold(0, usize::saturating_add),
                    shapes: of_mesh,
                    placements: 0,
                    part: None,
                });
            }
            if let Some(shapes) = shapes {
                shapes.placements += placement.count();
            }
        }
        self.make_room(&mut meshes, buffers)?;
        for placement in &placements {
            let Some(node) = node_of(placement) else { continue };
            if let Some(mesh) = node.mesh()
                && let Some(shapes) = &mut meshes[mesh.index()]
            {
                for i in 0..placement.count() {
                    let world = placement.at(i, buffers)?;
                    self.place(shapes, &world, placement.node, buffers)?;
                }
            }
            self.punctual
                .place(placement.node, &placement.world, &mut self.lights);
            if let Some(camera) = node.camera() {
                let name = camera.name().or(node.name()).unwrap_or_default();
                let offset = buffers.budget().offset().vector();
                self.camera(name, camera.projection(), &placement.world, offset);
            }
        }
        buffers.budget().add_single_reach(self.baked.reach);
        Ok(())
    }

    /// Decides which meshes are stored once. Refuses too many triangles, and makes room for all others.
    fn make_room(
        &mut self,
        meshes: &mut [Option<ReadMesh<'_>>],
        buffers: &Buffers<'_>,
    ) -> Result<(), LoadError> {
        let sharing = if self.is_cloud {
            Sharing::Never
        } else {
            buffers.budget().sharing()
        };
        let counts = meshes.iter().map(|mesh| {
            mesh.as_ref()
                .map_or([0; 2], |mesh| [mesh.triangles, mesh.placements])
        });
        let shared = sharing::shared(counts, sharing);
        let (mut baked, mut instances) = (Room::default(), 0);
        let mut stored = Vec::new();
        for (mesh, is_shared) in meshes.iter_mut().zip(shared) {
            let Some(mesh) = mesh else { continue };
            if is_shared {
                let mut room = Room::default();
                room.add(&mesh.shapes, 1);
                mesh.part = Some(stored.len());
                stored.push((room, mesh.placements));
                instances += mesh.placements;
            } else {
                baked.add(&mesh.shapes, mesh.placements);
            }
        }
        let mut vectors = baked.all_vectors();
        // Each segment of a line becomes triangles.
        self.triangles = if self.is_cloud {
            let of_lines = baked.lines.saturating_mul(LINE_TRIANGLES);
            baked.points.saturating_add(of_lines)
        } else {
            baked.triangles
        };
        for (room, _) in &stored {
            self.triangles = self.triangles.saturating_add(room.triangles);
            vectors = vectors.saturating_add(room.all_vectors());
        }
        self.has_lines = baked.lines > 0;
        self.most_triangles = most_triangles(buffers.size());
        self.check_triangles(buffers)?;
        let budget = buffers.budget();
        // The scene would refuse it later.
        let (limit, taken) = (budget.limit(), instances as u64 * INSTANCE_BYTES);
        check_memory([self.triangles, 0, vectors], limit.saturating_sub(taken)).map_err(|error| {
            let error = match error {
                SceneError::OverLimit { needed, .. } => SceneError::OverLimit {
                    needed: needed.saturating_add(taken),
                    limit,
                },
                error => error,
            };
            buffers.refused(error.to_string())
        })?;
        self.baked.reserve(&baked, buffers)?;
        for (room, placements) in stored {
            let mut part = Part::default();
            part.arrays.reserve(&room, buffers)?;
            let reserved = budget.reserve(&mut part.placements, placements);
            reserved.map_err(|error| buffers.no_room(error))?;
            self.parts.push(part);
        }
        Ok(())
    }

    fn check_triangles(&self, buffers: &Buffers<'_>) -> Result<(), LoadError> {
        let (triangles, most) = (self.triangles, self.most_triangles);
        if triangles > most {
            let what = match (self.is_cloud, self.has_lines) {
                (true, true) => "points and triangles of lines",
                (true, false) => "points",
                (false, _) => "triangles",
            };
            return Err(buffers.refused(format!(
                "{triangles} {what}, counted once for each node that places them, expected at most {most} from \
                 {} bytes",
                buffers.size()
            )));
        }
        Ok(())
    }

    /// Places a mesh for a node.
    fn place(
        &mut self,
        mesh: &mut ReadMesh<'_>,
        world: &DMat4,
        node: usize,
        buffers: &Buffers<'_>,
    ) -> Result<(), LoadError> {
        mesh.placements -= 1;
        let is_baked = match mesh.part {
            Some(part) => !self.place_part(part, mesh, world, node, buffers)?,
            None => true,
        };
        for shape in &mut mesh.shapes {
            if is_baked {
                shape.prepare(buffers)?;
                self.baked.place(shape, world, buffers)?;
            }
            if mesh.placements == 0 {
                shape.release(buffers.budget());
            }
        }
        Ok(())
    }

    /// Places a mesh that is stored once. `false` if it must be baked there.
    fn place_part(
        &mut self,
        part: usize,
        mesh: &mut ReadMesh<'_>,
        world: &DMat4,
        node: usize,
        buffers: &Buffers<'_>,
    ) -> Result<bool, LoadError> {
        let part = &mut self.parts[part];
        let placing = if let Some(placing) = &part.placing {
            placing
        } else {
            for shape in &mut mesh.shapes {
                shape.prepare(buffers)?;
                part.arrays.place(shape, &DMat4::IDENTITY, buffers)?;
                shape.release(buffers.budget());
            }
            part.placing.insert(Placing::of(&part.arrays.columns))
        };
        let transform = Transform::from_rows([0, 1, 2].map(|i| world.row(i).to_array()));
        match placing.check(&transform) {
            Ok(()) => {
                self.baked.reach = self.baked.reach.max(part.arrays.reach * scale(world));
                part.placements.push(transform);
            }
            Err(SceneError::Flat) if transform.collapses() => self.collapsed += 1,
            // Flat shapes are visible, but rays cannot be transformed by a singular matrix.
            Err(SceneError::Flat) => {
                self.triangles = self.triangles.saturating_add(mesh.triangles);
                self.check_triangles(buffers)?;
                let mut room = Room::default();
                room.add(&mesh.shapes, 1);
                self.baked.reserve(&room, buffers)?;
                return Ok(false);
            }
            Err(error) => {
                return Err(buffers.refused(format!("nodes[{node}]: cannot place its mesh: {error}")));
            }
        }
        Ok(true)
    }

    fn camera(&mut self, name: &str, projection: gltf::camera::Projection<'_>, world: &DMat4, offset: DVec3) {
        if self.cameras.len() >= MAX_CAMERAS {
            self.cameras_left_out += 1;
            return;
        }
        // Cameras look along -z.
        let eye = world.w_axis.truncate() + offset;
        let (forward, up) = (-world.z_axis.truncate(), world.y_axis.truncate());
        self.cameras.push(MeshCamera {
            name: camera_name(name),
            eye,
            target: eye + forward.normalize_or_zero(),
            up: up.normalize_or_zero(),
            projection: match projection {
                gltf::camera::Projection::Perspective(perspective) => Projection::Perspective {
                    fov_degrees: f64::from(perspective.yfov()).to_degrees(),
                },
                gltf::camera::Projection::Orthographic(orthographic) => Projection::Orthographic {
                    height: 2.0 * f64::from(orthographic.ymag()),
                },
            },
        });
    }

    /// The mesh, with the materials that it uses; `path` is the file's.
    pub(super) fn finish(mut self, materials: Vec<Shown>, path: &Path) -> LoadedMesh {
        let mut surfaces: Vec<Surface> = materials.into_iter().map(|shown| shown.surface).collect();
        let parts = std::mem::take(&mut self.parts);
        let (mut parts, placements): (Vec<Arrays>, Vec<_>) = parts
            .into_iter()
            .map(|part| (part.arrays, part.placements))
            .unzip();
        parts.insert(0, self.baked);
        name_surfaces(&mut surfaces, &mut parts);
        let (mut untextured, mut clamped) = (0, 0);
        for part in &mut parts {
            untextured += part.leave_untextured(&mut surfaces);
            clamped += part.clamped;
        }
        let mut notes: Vec<String> = clamped_note(clamped, path).into_iter().collect();
        notes.extend(textures::untextured_note(untextured, path));
        let mut parts = parts.into_iter();
        let baked = parts.next().unwrap_or_default();
        if self.is_cloud {
            // The vertices have their colours.
            surfaces.clear();
        }
        let shared = parts.zip(placements).map(|(arrays, placements)| SharedMesh {
            columns: arrays.columns,
            surface_of: arrays.material_of,
            placements,
        });
        let cloud = Cloud {
            radius: None,
            lines: baked.lines,
        };
        LoadedMesh {
            cloud: (self.is_cloud && !baked.columns.x.is_empty()).then_some(cloud),
            columns: baked.columns,
            shared: shared.collect(),
            surfaces,
            surface_of: baked.material_of,
            cameras: self.cameras,
            lights: self.lights,
            // By the specification.
            up: UpAxis::Y,
            up_source: UpSource::Stated,
            notes,
            ..LoadedMesh::default()
        }
    }

    /// How many texture coordinates are not finite.
    pub(super) fn odd_uvs(&self) -> usize {
        let parts = self.parts.iter().map(|part| part.arrays.odd_uvs);
        self.baked.odd_uvs + parts.sum::<usize>()
    }
}

/// Gives surfaces to triangles without a material, or no surfaces to any if none has one.
fn name_surfaces(surfaces: &mut Vec<Surface>, parts: &mut [Arrays]) {
    let has_colors = parts.iter().any(|part| part.has_colors);
    let none = if has_colors { COLORED } else { NO_SURFACE };
    if parts
        .iter()
        .all(|part| part.material_of.iter().all(|&material| material == none))
    {
        surfaces.clear();
        for part in &mut *parts {
            part.material_of.clear();
        }
    }
    for (none, surface) in [(NO_SURFACE, Surface::NEUTRAL), (COLORED, Surface::WHITE)] {
        if parts.iter().any(|part| part.material_of.contains(&none)) {
            let index = surfaces.len() as u32;
            surfaces.push(surface);
            let all = parts.iter_mut().flat_map(|part| &mut part.material_of);
            for material in all.filter(|material| **material == none) {
                *material = index;
            }
        }
    }
}

/// Refuses more instances than the file's size allows: accessors of many nodes may be the same.
fn check_instances(placements: &[Placement<'_>], buffers: &Buffers<'_>) -> Result<(), LoadError> {
    let counts = placements
        .iter()
        .filter_map(|placement| Some(placement.instances.as_ref()?.count));
    let (count, size) = (counts.fold(0, usize::saturating_add), buffers.size());
    let most = size.saturating_mul(8).saturating_add(1 << 16).min(MAX_INSTANCES);
    if count > most {
        return Err(buffers.refused(format!(
            "{count} instances, expected at most {most} from {size} bytes"
        )));
    }
    Ok(())
}

/// The nodes that place something, in the order of the tree.
fn placements<'a>(
    document: &Document,
    punctual: &PunctualLights,
    (instancing, translations): (&Instancing, &Translations),
    buffers: &mut Buffers<'a>,
) -> Result<Vec<Placement<'a>>, LoadError> {
    let count = document.nodes().len();
    let scene = document.default_scene().or_else(|| document.scenes().next());
    let roots: Vec<usize> = if let Some(scene) = scene {
        scene.nodes().map(|node| node.index()).collect()
    } else {
        let mut is_child = vec![false; count];
        for child in document.nodes().flat_map(|node| node.children()) {
            is_child[child.index()] = true;
        }
        (0..count).filter(|&i| !is_child[i]).collect()
    };
    let mut visited = vec![false; count];
    let mut placements = Vec::new();
    // The transforms of nodes that have children; the first is the world's.
    let mut parents = vec![DMat4::IDENTITY];
    let offset = buffers.budget().offset();
    // A stack of nodes with their parents: children pushed in reverse come out in order.
    let mut waiting: Vec<(usize, usize)> = roots.into_iter().rev().map(|node| (node, 0)).collect();
    while let Some((i, parent)) = waiting.pop() {
        let Some(node) = document.nodes().nth(i) else {
            continue;
        };
        if std::mem::replace(&mut visited[i], true) {
            return Err(buffers.refused(format!("nodes[{i}] has two parents or contains itself")));
        }
        let columns = node.transform().matrix();
        let mut local = DMat4::from_cols_array_2d(&columns.map(|column| column.map(f64::from)));
        if let Some(translation) = translations.of_node(i) {
            local.w_axis = translation.extend(1.0);
        }
        let world = parents[parent] * local;
        if node.mesh().is_some() || node.camera().is_some() || punctual.is_at(i) {
            let instances = match node.mesh() {
                Some(_) => instancing.at(i, document, buffers)?,
                None => None,
            };
            let mut placed = world;
            placed.w_axis -= offset.vector().extend(0.0);
            placements.push(Placement {
                node: i,
                world: placed,
                instances,
            });
        }
        let first = waiting.len();
        waiting.extend(node.children().map(|child| (child.index(), parents.len())));
        if waiting.len() > first {
            waiting[first..].reverse();
            parents.push(world);
        }
    }
    Ok(placements)
}

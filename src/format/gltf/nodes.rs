//! The node tree: transforms, meshes, cameras and lights.
//!
//! Everything that the nodes place is counted before any of it is built, so that a file that places a mesh a million times
//! is refused at once, or stores it once.

use super::{
    animations::AnimatedPose,
    arrays::{Arrays, Room, name_surfaces, scale},
    buffers::Buffers,
    instancing::Instancing,
    lights::PunctualLights,
    materials::Shown,
    morphs::MorphTargets,
    shapes::{Pose, Shape, shapes_of},
    sharing,
    skins::Skins,
    translations::Translations,
    tree::{Place, Placement, Tree},
    visibility::Hidden,
};
use crate::{
    error::{LoadError, SceneError},
    format::{
        left_out::LeftOut,
        mesh::{
            Cloud, LINE_TRIANGLES, LoadedMesh, MAX_CAMERAS, MeshCamera, SharedMesh, Sharing, Surface, UpAxis,
            UpSource, camera_name, clamped_note, most_triangles,
        },
        textures,
    },
    scene::{INSTANCE_BYTES, Light, Placing, Projection, Transform, check_memory},
};
use glam::{DMat4, DVec3};
use gltf::{Document, Node};
use std::{
    collections::{BTreeMap, btree_map::Entry},
    path::Path,
};

/// How many steps the skins and morph targets of a small file may take: about a second. A step is a set of joints, or what
/// a target changes, of one vertex.
const MOST_POSE_STEPS: usize = 1 << 24;

/// Reading a primitive once more takes as long as this many steps.
const PRIMITIVE_STEPS: usize = 64;

/// What the nodes of a file refer to.
pub(super) struct Contents<'c> {
    pub(super) document: &'c Document,
    pub(super) materials: &'c [Shown],
    pub(super) instancing: &'c Instancing,
    pub(super) translations: &'c Translations,
    pub(super) hidden: &'c Hidden,
    pub(super) targets: &'c MorphTargets<'c>,
    pub(super) pose: &'c AnimatedPose,
}

impl<'c> Contents<'c> {
    /// The weights that a node has of its own.
    fn weights<'n>(&self, node: &Node<'n>) -> Option<&'n [f32]>
    where
        'c: 'n,
    {
        self.pose.weights(node.index()).or(node.weights())
    }
}

/// A mesh in one pose. Nodes without weights of their own may share its triangles.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Variant {
    mesh: usize,
    skin: Option<usize>,
    /// The node whose weights of morph targets are not those of the mesh.
    weights: Option<usize>,
}

impl Variant {
    /// What a node places; `None` without a mesh.
    fn of(node: &Node<'_>, contents: &Contents<'_>) -> Option<Self> {
        let mesh = node.mesh()?;
        let targets = contents.targets;
        let own = contents.weights(node).filter(|own| Some(*own) != mesh.weights());
        Some(Self {
            mesh: mesh.index(),
            skin: node.skin().map(|skin| skin.index()),
            weights: own.filter(|_| targets.has(mesh.index())).map(|_| node.index()),
        })
    }
}

/// A mesh whose shapes are read.
#[derive(Default)]
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
    /// How many steps skins and morph targets took.
    pose_steps: usize,
    cameras: Vec<MeshCamera>,
    lights: Vec<Light>,
    /// Whether the file shows points or lines and no triangles.
    is_cloud: bool,
    has_lines: bool,
    /// The lights of the file.
    punctual: PunctualLights,
    /// How many cameras there are beyond the limit.
    cameras_left_out: usize,
    /// How many placements of shared meshes collapse them to lines or points.
    collapsed: usize,
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
        contents: &Contents<'_>,
        buffers: &mut Buffers<'_>,
    ) -> Result<(), LoadError> {
        let document = contents.document;
        let tree = Tree::of(contents, &self.punctual, buffers)?;
        let mut skins = Skins::new(&tree.globals);
        let mut meshes = BTreeMap::new();
        let node_of = |placement: &Placement<'_>| document.nodes().nth(placement.node);
        let variant_of = |placement: &Placement<'_>, node: &Node<'_>| {
            let variant = Variant::of(node, contents);
            variant.filter(|_| !placement.is_hidden)
        };
        for placement in &tree.placements {
            let Some(node) = node_of(placement) else { continue };
            let Some(variant) = variant_of(placement, &node) else {
                continue;
            };
            let mesh = match meshes.entry(variant) {
                Entry::Occupied(mesh) => mesh.into_mut(),
                Entry::Vacant(place) => place.insert(self.read(&node, contents, &mut skins, buffers)?),
            };
            mesh.placements += placement.count();
        }
        self.make_room(&mut meshes, buffers)?;
        let mut cameras = vec![0; document.cameras().count()];
        for camera in document.nodes().filter_map(|node| node.camera()) {
            cameras[camera.index()] += 1;
        }
        for placement in &tree.placements {
            let Some(node) = node_of(placement) else { continue };
            let variant = variant_of(placement, &node);
            if let Some(mesh) = variant.and_then(|variant| meshes.get_mut(&variant)) {
                for i in 0..placement.count() {
                    self.place(mesh, &placement.at(i, buffers)?, buffers)?;
                }
            }
            if !placement.is_hidden {
                self.punctual
                    .place(placement.node, &placement.world, &mut self.lights);
            }
            if let Some(camera) = node.camera() {
                // Of several nodes with one camera each has its own name.
                let is_shared = cameras[camera.index()] > 1;
                let own = camera.name().filter(|_| !is_shared || node.name().is_none());
                let name = own.or(node.name()).unwrap_or_default();
                let offset = buffers.budget().offset().vector();
                self.camera(name, camera.projection(), &placement.world, offset);
            }
        }
        buffers.budget().add_single_reach(self.baked.reach);
        Ok(())
    }

    /// Reads the mesh of a node in its pose.
    fn read<'a>(
        &mut self,
        node: &Node<'_>,
        contents: &Contents<'_>,
        skins: &mut Skins<'_>,
        buffers: &mut Buffers<'a>,
    ) -> Result<ReadMesh<'a>, LoadError> {
        let Some(mesh) = node.mesh() else {
            return Ok(ReadMesh::default());
        };
        let joints = match node.skin() {
            Some(skin) => Some(skins.joints(&skin, buffers)?),
            None => None,
        };
        let weights = contents.weights(node).or(mesh.weights()).unwrap_or_default();
        if joints.is_some() || !weights.is_empty() {
            // The estimate of the JSON has room for each mesh once.
            let primitives = mesh.primitives().len();
            let room = buffers.budget().take_array::<Shape<'_>>(primitives + 1);
            room.map_err(|error| buffers.no_room(error))?;
            let steps = primitives.saturating_mul(weights.len() + PRIMITIVE_STEPS);
            self.count_steps(steps, buffers)?;
        }
        let pose = Pose {
            targets: contents.targets,
            weights,
            joints,
        };
        let shapes = shapes_of(&mesh, contents.materials, self.is_cloud, &pose, buffers)?;
        let triangles = shapes.iter().map(Shape::triangle_count);
        Ok(ReadMesh {
            triangles: triangles.fold(0, usize::saturating_add),
            shapes,
            ..ReadMesh::default()
        })
    }

    /// Decides which meshes are stored once. Refuses too many triangles, and makes room for all others.
    fn make_room(
        &mut self,
        meshes: &mut BTreeMap<Variant, ReadMesh<'_>>,
        buffers: &Buffers<'_>,
    ) -> Result<(), LoadError> {
        let sharing = if self.is_cloud {
            Sharing::Never
        } else {
            buffers.budget().sharing()
        };
        // Joints move each skinned mesh on its own.
        let counts = meshes.iter().map(|(variant, mesh)| match variant.skin {
            Some(_) => [0; 2],
            None => [mesh.triangles, mesh.placements],
        });
        let shared = sharing::shared(counts, sharing);
        let (mut baked, mut instances) = (Room::default(), 0);
        let mut stored = Vec::new();
        for (mesh, is_shared) in meshes.values_mut().zip(shared) {
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
        let placed = instances as u64 * INSTANCE_BYTES;
        check_memory([self.triangles, 0, vectors], placed, budget.limit()).map_err(|error| {
            let kind = (&error).into();
            buffers.refused(error.to_string()).with_kind(kind)
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
            return Err(buffers.too_much(format!(
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
        place: &Place,
        buffers: &Buffers<'_>,
    ) -> Result<(), LoadError> {
        mesh.placements -= 1;
        let is_baked = match mesh.part {
            Some(part) => !self.place_part(part, mesh, place, buffers)?,
            None => true,
        };
        for shape in &mut mesh.shapes {
            if is_baked {
                shape.prepare(buffers)?;
                self.count_steps(shape.pose_steps(), buffers)?;
                let world = if shape.is_skinned() {
                    &place.without_node
                } else {
                    &place.world
                };
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
        Place { node, world, .. }: &Place,
        buffers: &Buffers<'_>,
    ) -> Result<bool, LoadError> {
        if self.parts[part].placing.is_none() {
            for shape in &mut mesh.shapes {
                shape.prepare(buffers)?;
                self.count_steps(shape.pose_steps(), buffers)?;
                let arrays = &mut self.parts[part].arrays;
                arrays.place(shape, &DMat4::IDENTITY, buffers)?;
                shape.release(buffers.budget());
            }
        }
        let part = &mut self.parts[part];
        let placing = part.placing.get_or_insert_with(|| part.arrays.placing());
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

    /// Counts steps of posing meshes. Many nodes, sets and targets may name the same bytes.
    fn count_steps(&mut self, steps: usize, buffers: &Buffers<'_>) -> Result<(), LoadError> {
        self.pose_steps = self.pose_steps.saturating_add(steps);
        let (steps, size) = (self.pose_steps, buffers.size());
        let most = size.saturating_mul(8).saturating_add(MOST_POSE_STEPS);
        if steps > most {
            return Err(buffers.too_much(format!(
                "skins and morph targets change vertices {steps} times, counted for each node, expected at most {most} from \
                 {size} bytes"
            )));
        }
        Ok(())
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

    /// Lists what the nodes place that is not shown.
    pub(super) fn list_left_out(&self, left_out: &mut LeftOut) {
        left_out.count(self.punctual.left_out, "light", "lights");
        left_out.count(self.cameras_left_out, "camera", "cameras");
        left_out.count(
            self.collapsed,
            "placement scaled to a line or a point",
            "placements scaled to lines or points",
        );
    }

    /// All arrays.
    pub(super) fn arrays(&mut self) -> impl Iterator<Item = &mut Arrays> {
        let parts = self.parts.iter_mut().map(|part| &mut part.arrays);
        std::iter::once(&mut self.baked).chain(parts)
    }
}

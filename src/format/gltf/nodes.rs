//! The node tree: transforms, meshes, cameras and lights.
//!
//! All that the nodes place is counted before any of it is built, so that a file that places a mesh a million times is
//! refused at once.

use super::{
    Surface,
    buffers::Buffers,
    lights::PunctualLights,
    materials::{Shown, display_value},
    shapes::{Shape, shapes_of},
};
use crate::{
    error::{LoadError, SceneError},
    format::{
        mesh::{
            LoadedMesh, MAX_CAMERAS, MeshCamera, UpAxis, UpSource, camera_name, clamped_note, most_triangles,
        },
        textures,
        vertices::add_position,
    },
    scene::{Light, Projection, TriangleMesh, check_memory, is_usable},
};
use glam::{DMat3, DMat4, DVec3, DVec4, Vec3};
use gltf::Document;
use std::{ops::Range, path::Path};

/// A triangle without a material of its own.
const NO_SURFACE: u32 = u32::MAX;

/// A triangle without a material of its own whose vertices have colours.
const COLORED: u32 = u32::MAX - 1;

/// A node with a mesh, a camera or a light, and where it stands.
struct Placement {
    node: usize,
    world: DMat4,
}

/// The shapes of a mesh.
struct Shapes<'a> {
    shapes: Vec<Shape<'a>>,
    /// How many nodes are left to place them.
    placements: usize,
}

/// The mesh so far.
#[derive(Default)]
pub(super) struct Reading {
    columns: TriangleMesh,
    /// The index of each triangle's material in the file.
    material_of: Vec<u32>,
    has_normals: bool,
    has_colors: bool,
    has_uvs: bool,
    /// Triangles without texture coordinates whose material shows a texture.
    untextured: Vec<Range<usize>>,
    /// How many texture coordinates are not finite.
    pub(super) odd_uvs: usize,
    /// How many colours were not from 0 to 1.
    clamped: usize,
    cameras: Vec<MeshCamera>,
    lights: Vec<Light>,
    /// The lights of the file.
    pub(super) punctual: PunctualLights,
    /// How many cameras there are beyond the limit.
    pub(super) cameras_left_out: usize,
}

impl Reading {
    pub(super) fn with_lights(punctual: PunctualLights) -> Self {
        Self {
            punctual,
            ..Self::default()
        }
    }

    /// Reads the default scene, else the first one, else all root nodes.
    pub(super) fn scene(
        &mut self,
        document: &Document,
        materials: &[Shown],
        buffers: &mut Buffers<'_>,
    ) -> Result<(), LoadError> {
        let placements = placements(document, &self.punctual, buffers)?;
        let mut meshes: Vec<Option<Shapes<'_>>> = document.meshes().map(|_| None).collect();
        let node_of = |placement: &Placement| document.nodes().nth(placement.node);
        for mesh in placements
            .iter()
            .filter_map(|placement| node_of(placement)?.mesh())
        {
            let shapes = &mut meshes[mesh.index()];
            if shapes.is_none() {
                *shapes = Some(Shapes {
                    shapes: shapes_of(&mesh, materials, buffers)?,
                    placements: 0,
                });
            }
            if let Some(shapes) = shapes {
                shapes.placements += 1;
            }
        }
        self.make_room(&meshes, buffers)?;
        for placement in &placements {
            let Some(node) = node_of(placement) else { continue };
            if let Some(mesh) = node.mesh()
                && let Some(Shapes { shapes, placements }) = &mut meshes[mesh.index()]
            {
                *placements -= 1;
                for shape in shapes {
                    shape.prepare(buffers)?;
                    self.place(shape, &placement.world, buffers)?;
                    if *placements == 0 {
                        shape.release(buffers.budget());
                    }
                }
            }
            self.punctual
                .place(placement.node, &placement.world, &mut self.lights);
            if let Some(camera) = node.camera() {
                let name = camera.name().or(node.name()).unwrap_or_default();
                self.camera(name, camera.projection(), &placement.world);
            }
        }
        Ok(())
    }

    /// Refuses too many triangles, and makes room for all others.
    fn make_room(&mut self, meshes: &[Option<Shapes<'_>>], buffers: &Buffers<'_>) -> Result<(), LoadError> {
        let (mut triangles, mut vertices) = (0_usize, 0_usize);
        let (mut has_normals, mut has_colors, mut has_uvs) = (false, false, false);
        for Shapes { shapes, placements } in meshes.iter().flatten() {
            for shape in shapes {
                triangles = triangles.saturating_add(placements.saturating_mul(shape.triangle_count()));
                vertices = vertices.saturating_add(placements.saturating_mul(shape.vertices_at_least()));
                has_normals |= shape.normals.is_some();
                has_colors |= shape.colors.is_some();
                has_uvs |= shape.uvs.is_some();
            }
        }
        let most = most_triangles(buffers.size());
        if triangles > most {
            return Err(buffers.refused(format!(
                "{triangles} triangles, counted once for each node that places them, expected at most {most} from \
                 {} bytes",
                buffers.size()
            )));
        }
        let [normals, colors, uvs] =
            [has_normals, has_colors, has_uvs].map(|has| if has { vertices } else { 0 });
        let vectors = [normals, colors, uvs]
            .into_iter()
            .fold(vertices, usize::saturating_add);
        let budget = buffers.budget();
        // The scene would refuse it later.
        check_memory([triangles, 0, vectors], budget.limit())
            .map_err(|error| buffers.refused(error.to_string()))?;
        let columns = &mut self.columns;
        [&mut columns.x, &mut columns.y, &mut columns.z]
            .into_iter()
            .try_for_each(|column| budget.reserve(column, vertices))
            .and_then(|()| budget.reserve(&mut columns.normals, normals))
            .and_then(|()| budget.reserve(&mut columns.colors, colors))
            .and_then(|()| budget.reserve(&mut columns.uvs, uvs))
            .and_then(|()| budget.reserve(&mut columns.triangles, triangles))
            .and_then(|()| budget.reserve(&mut self.material_of, triangles))
            .map_err(|error| buffers.no_room(error))
    }

    fn camera(&mut self, name: &str, projection: gltf::camera::Projection<'_>, world: &DMat4) {
        if self.cameras.len() >= MAX_CAMERAS {
            self.cameras_left_out += 1;
            return;
        }
        // Cameras look along -z.
        let eye = world.w_axis.truncate();
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

    /// Adds a shape once.
    fn place(&mut self, shape: &Shape<'_>, world: &DMat4, buffers: &Buffers<'_>) -> Result<(), LoadError> {
        let (base, more) = (self.columns.x.len(), shape.used_count());
        let (budget, columns) = (buffers.budget(), &mut self.columns);
        self.has_normals |= shape.normals.is_some();
        self.has_colors |= shape.colors.is_some();
        self.has_uvs |= shape.uvs.is_some();
        let missing = |has: bool, length: usize| if has { base + more - length } else { 0 };
        let missing_normals = missing(self.has_normals, columns.normals.len());
        let missing_colors = missing(self.has_colors, columns.colors.len());
        let missing_uvs = missing(self.has_uvs, columns.uvs.len());
        [&mut columns.x, &mut columns.y, &mut columns.z]
            .into_iter()
            .try_for_each(|column| budget.reserve(column, more))
            .and_then(|()| budget.reserve(&mut columns.normals, missing_normals))
            .and_then(|()| budget.reserve(&mut columns.colors, missing_colors))
            .and_then(|()| budget.reserve(&mut columns.uvs, missing_uvs))
            .map_err(|error| buffers.no_room(error))?;
        self.positions(shape, world).map_err(|(i, error)| {
            buffers.refused(format!(
                "accessors[{}]: vertex {} of {}: {error}",
                shape.positions.accessor,
                i + 1,
                shape.positions.count
            ))
        })?;
        self.normals(shape, base, world);
        self.colors(shape, base, buffers)?;
        self.uvs(shape, base);
        let triangles = &mut self.columns.triangles;
        shape.add_triangles(triangles, base as u32);
        let none = if shape.colors.is_some() {
            COLORED
        } else {
            NO_SURFACE
        };
        let material = shape.material.map_or(none, |i| i as u32);
        if shape.is_textured && shape.uvs.is_none() {
            self.untextured.push(self.material_of.len()..triangles.len());
        }
        self.material_of.resize(triangles.len(), material);
        Ok(())
    }

    /// Adds positions. The error has the index of the first unusable one.
    fn positions(&mut self, shape: &Shape<'_>, world: &DMat4) -> Result<(), (usize, SceneError)> {
        let columns = &mut self.columns;
        let is_identity = *world == DMat4::IDENTITY;
        for i in shape.used() {
            let position = shape.positions.vector(i);
            let position = if is_identity {
                position
            } else {
                let [x, y, z] = position.map(f64::from);
                (*world * DVec4::new(x, y, z, 1.0))
                    .truncate()
                    .as_vec3()
                    .to_array()
            };
            add_position(columns, position).map_err(|error| (i, error))?;
        }
        Ok(())
    }

    /// Adds the normals of the vertices from `base` on. Missing and degenerate ones are zero.
    fn normals(&mut self, shape: &Shape<'_>, base: usize, world: &DMat4) {
        let columns = &mut self.columns;
        if let Some(normals) = &shape.normals {
            // Normals transform by the cofactor matrix, which exists for every matrix; a mirror flips them.
            let m = DMat3::from_mat4(*world);
            let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
            let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * m.determinant().signum();
            columns.normals.resize(base, Vec3::ZERO);
            columns.normals.extend(shape.used().map(|i| {
                let turned = cofactors * DVec3::from_array(normals.vector(i).map(f64::from));
                turned.normalize_or_zero().as_vec3()
            }));
        } else if self.has_normals {
            columns.normals.resize(columns.x.len(), Vec3::ZERO);
        }
    }

    /// Adds the colours of the vertices from `base` on, as display values. Missing ones are white.
    fn colors(&mut self, shape: &Shape<'_>, base: usize, buffers: &Buffers<'_>) -> Result<(), LoadError> {
        const WHITE: [f32; 3] = [1.0; 3];
        let columns = &mut self.columns;
        if let Some(colors) = &shape.colors {
            columns.colors.resize(base, WHITE);
            for i in shape.used() {
                let linear = colors.color(i);
                for (what, value) in ["red", "green", "blue"].into_iter().zip(linear) {
                    if !value.is_finite() {
                        let error = SceneError::NotUsable { what, value };
                        let (accessor, count) = (colors.accessor, colors.count);
                        let message = format!("accessors[{accessor}]: colour {} of {count}: {error}", i + 1);
                        return Err(buffers.refused(message));
                    }
                }
                self.clamped += usize::from(linear.iter().any(|channel| !(0.0..=1.0).contains(channel)));
                columns.colors.push(linear.map(display_value));
            }
        } else if self.has_colors {
            columns.colors.resize(columns.x.len(), WHITE);
        }
        Ok(())
    }

    /// Adds the texture coordinates of the vertices from `base` on.
    fn uvs(&mut self, shape: &Shape<'_>, base: usize) {
        let columns = &mut self.columns;
        if let Some((uvs, placement)) = &shape.uvs {
            columns.uvs.resize(base, [0.0; 2]);
            for i in shape.used() {
                let [u, v, _] = uvs.vector(i);
                let uv = placement.apply([u, v]);
                let is_odd = !uv.into_iter().all(is_usable);
                self.odd_uvs += usize::from(is_odd);
                columns.uvs.push(if is_odd { [0.0; 2] } else { uv });
            }
        } else if self.has_uvs {
            columns.uvs.resize(columns.x.len(), [0.0; 2]);
        }
    }

    /// The mesh, with the materials that it uses; `path` is the file's.
    pub(super) fn finish(mut self, materials: Vec<Shown>, path: &Path) -> LoadedMesh {
        let mut surfaces: Vec<Surface> = materials.into_iter().map(|shown| shown.surface).collect();
        let none = if self.has_colors { COLORED } else { NO_SURFACE };
        if self.material_of.iter().all(|&material| material == none) {
            surfaces.clear();
            self.material_of.clear();
        }
        for (none, surface) in [(NO_SURFACE, Surface::NEUTRAL), (COLORED, Surface::WHITE)] {
            if self.material_of.contains(&none) {
                let index = surfaces.len() as u32;
                surfaces.push(surface);
                for material in self.material_of.iter_mut().filter(|m| **m == none) {
                    *material = index;
                }
            }
        }
        // Ascending, as the triangles.
        let mut ranges = self.untextured.iter().peekable();
        let untextured = textures::leave_untextured(&mut surfaces, &mut self.material_of, |i| {
            while ranges.next_if(|range| range.end <= i).is_some() {}
            ranges.peek().is_some_and(|range| range.contains(&i))
        });
        let mut notes: Vec<String> = clamped_note(self.clamped, path).into_iter().collect();
        notes.extend(textures::untextured_note(untextured, path));
        LoadedMesh {
            columns: self.columns,
            surfaces,
            surface_of: self.material_of,
            cameras: self.cameras,
            lights: self.lights,
            // By the specification.
            up: UpAxis::Y,
            up_source: UpSource::Stated,
            notes,
            ..LoadedMesh::default()
        }
    }
}

/// The nodes that place something, in the order of the tree.
fn placements(
    document: &Document,
    punctual: &PunctualLights,
    buffers: &Buffers<'_>,
) -> Result<Vec<Placement>, LoadError> {
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
        let local = DMat4::from_cols_array_2d(&columns.map(|column| column.map(f64::from)));
        let world = parents[parent] * local;
        if node.mesh().is_some() || node.camera().is_some() || punctual.is_at(i) {
            placements.push(Placement { node: i, world });
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

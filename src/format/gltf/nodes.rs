//! The node tree: transforms, meshes and cameras.

use super::{Surface, buffers::Buffers, surface};
use crate::{
    error::{LoadError, SceneError},
    format::mesh::{LoadedMesh, MeshCamera, UpAxis, UpSource},
    scene::{TriangleMesh, is_usable},
};
use glam::{DMat3, DMat4, DVec3, DVec4, Vec3};
use gltf::{Document, Mesh, Node, Primitive, Semantic, camera::Projection, mesh::Mode};

/// The most triangles of a file. Few bytes can place one mesh a million times.
const MAX_TRIANGLES: usize = 1 << 26;

/// A triangle without a material of its own.
const NO_SURFACE: u32 = u32::MAX;

/// How many triangles a mesh has by the counts of its accessors.
fn promised(mesh: &Mesh<'_>) -> usize {
    let of_primitive = |primitive: Primitive<'_>| {
        let accessor = primitive
            .indices()
            .or_else(|| primitive.get(&Semantic::Positions));
        let corners = accessor.map_or(0, |accessor| accessor.count());
        match primitive.mode() {
            Mode::Triangles => corners / 3,
            Mode::TriangleStrip | Mode::TriangleFan => corners,
            _ => 0,
        }
    };
    // Reading refuses a count that is too large with a better message.
    mesh.primitives()
        .map(of_primitive)
        .filter(|&count| count <= MAX_TRIANGLES)
        .fold(0, usize::saturating_add)
}

/// The mesh so far.
#[derive(Default)]
pub(super) struct Reading {
    columns: TriangleMesh,
    /// The index of each triangle's material in the file.
    material_of: Vec<u32>,
    has_normals: bool,
    cameras: Vec<MeshCamera>,
}

impl Reading {
    /// Reads the default scene, else the first one, else all root nodes.
    pub(super) fn scene(&mut self, document: &Document, buffers: &mut Buffers<'_>) -> Result<(), LoadError> {
        let count = document.nodes().count();
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
        let nodes: Vec<Node<'_>> = document.nodes().collect();
        let mut visited = vec![false; count];
        let (mut placed, mut triangles) = (Vec::new(), 0_usize);
        // A stack: children pushed in reverse come out in order.
        let mut waiting: Vec<(usize, DMat4)> =
            roots.into_iter().rev().map(|i| (i, DMat4::IDENTITY)).collect();
        while let Some((i, parent)) = waiting.pop() {
            let node = &nodes[i];
            if std::mem::replace(&mut visited[i], true) {
                return Err(buffers.refused(format!("nodes[{i}] has two parents or contains itself")));
            }
            let columns = node.transform().matrix();
            let local = DMat4::from_cols_array_2d(&columns.map(|column| column.map(f64::from)));
            let world = parent * local;
            triangles = triangles.saturating_add(node.mesh().map_or(0, |mesh| promised(&mesh)));
            placed.push((i, world));
            let children: Vec<usize> = node.children().map(|child| child.index()).collect();
            waiting.extend(children.into_iter().rev().map(|i| (i, world)));
        }
        if triangles > MAX_TRIANGLES {
            return Err(buffers.refused(format!(
                "{triangles} triangles, counted once for each node that places them, expected at most {MAX_TRIANGLES}"
            )));
        }
        for (i, world) in placed {
            let node = &nodes[i];
            if let Some(mesh) = node.mesh() {
                for primitive in mesh.primitives() {
                    self.primitive(&primitive, &world, buffers)?;
                }
            }
            if let Some(camera) = node.camera() {
                let name = camera.name().or(node.name()).unwrap_or_default();
                self.camera(name, camera.projection(), &world);
            }
        }
        Ok(())
    }

    fn camera(&mut self, name: &str, projection: Projection<'_>, world: &DMat4) {
        let Projection::Perspective(perspective) = projection else {
            return;
        };
        // Cameras look along -z.
        let eye = world.w_axis.truncate();
        let (forward, up) = (-world.z_axis.truncate(), world.y_axis.truncate());
        self.cameras.push(MeshCamera {
            name: name.to_owned(),
            eye,
            target: eye + forward.normalize_or_zero(),
            up: up.normalize_or_zero(),
            fov_degrees: f64::from(perspective.yfov()).to_degrees(),
        });
    }

    fn primitive(
        &mut self,
        primitive: &Primitive<'_>,
        world: &DMat4,
        buffers: &mut Buffers<'_>,
    ) -> Result<(), LoadError> {
        if matches!(
            primitive.mode(),
            Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip
        ) {
            return Ok(());
        }
        let Some(positions) = primitive.get(&Semantic::Positions) else {
            return Ok(());
        };
        let accessor = positions.index();
        let positions = buffers.vectors::<3>(&positions)?;
        let corners = match primitive.indices() {
            Some(indices) => {
                let accessor = indices.index();
                let indices = buffers.indices(&indices)?;
                if let Some((i, index)) = indices
                    .iter()
                    .enumerate()
                    .find(|(_, i)| **i as usize >= positions.len())
                {
                    return Err(buffers.refused(format!(
                        "accessors[{accessor}]: vertex index {index} (number {}), but the primitive has only {} vertices",
                        i + 1,
                        positions.len()
                    )));
                }
                indices
            }
            None => (0..positions.len() as u32).collect(),
        };
        let base = self.columns.x.len();
        // Vertices without triangles are not limited otherwise.
        if base + positions.len() > 3 * MAX_TRIANGLES {
            return Err(buffers.refused(format!("more than {} vertices", 3 * MAX_TRIANGLES)));
        }
        self.positions(&positions, world).map_err(|(i, error)| {
            buffers.refused(format!(
                "accessors[{accessor}]: vertex {} of {}: {error}",
                i + 1,
                positions.len()
            ))
        })?;
        if let Some(normals) = primitive.get(&Semantic::Normals) {
            let normals = buffers.vectors::<3>(&normals)?;
            if normals.len() == positions.len() {
                self.normals(&normals, base, world);
            }
        }
        let corner = |i: usize| corners[i] + base as u32;
        let start = self.columns.triangles.len();
        let triangles = &mut self.columns.triangles;
        match primitive.mode() {
            // Every other triangle of a strip has the opposite winding.
            Mode::TriangleStrip => triangles.extend((2..corners.len()).map(|i| {
                let (a, b) = if i % 2 == 0 {
                    (i - 2, i - 1)
                } else {
                    (i - 1, i - 2)
                };
                [a, b, i].map(corner)
            })),
            Mode::TriangleFan => triangles.extend((2..corners.len()).map(|i| [0, i - 1, i].map(corner))),
            _ => triangles.extend((0..corners.len() / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2].map(corner))),
        }
        let added = self.columns.triangles.len() - start;
        let material = primitive.material().index().map_or(NO_SURFACE, |i| i as u32);
        self.material_of.resize(self.material_of.len() + added, material);
        Ok(())
    }

    /// Adds positions. The error has the index of the first unusable one.
    fn positions(&mut self, positions: &[[f32; 3]], world: &DMat4) -> Result<(), (usize, SceneError)> {
        let columns = &mut self.columns;
        for column in [&mut columns.x, &mut columns.y, &mut columns.z] {
            let no_memory = |_| (0, SceneError::NoMemory { what: "vertices" });
            column.try_reserve(positions.len()).map_err(no_memory)?;
        }
        let is_identity = *world == DMat4::IDENTITY;
        for (i, &position) in positions.iter().enumerate() {
            let [x, y, z] = if is_identity {
                position
            } else {
                let [x, y, z] = position.map(f64::from);
                (*world * DVec4::new(x, y, z, 1.0))
                    .truncate()
                    .as_vec3()
                    .to_array()
            };
            for (what, value) in [("x", x), ("y", y), ("z", z)] {
                if !is_usable(value) {
                    return Err((i, SceneError::NotUsable { what, value }));
                }
            }
            columns.x.push(x);
            columns.y.push(y);
            columns.z.push(z);
        }
        if self.has_normals {
            columns.normals.resize(columns.x.len(), Vec3::ZERO);
        }
        Ok(())
    }

    /// Sets the normals of the vertices from `base` on. Degenerate ones become zero.
    fn normals(&mut self, normals: &[[f32; 3]], base: usize, world: &DMat4) {
        self.has_normals = true;
        self.columns.normals.resize(self.columns.x.len(), Vec3::ZERO);
        // Normals transform by the cofactor matrix, which exists for every matrix; a mirror flips them.
        let m = DMat3::from_mat4(*world);
        let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
        let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * m.determinant().signum();
        for (to, normal) in self.columns.normals.iter_mut().skip(base).zip(normals) {
            let turned = cofactors * DVec3::from_array(normal.map(f64::from));
            *to = turned.normalize_or_zero().as_vec3();
        }
    }

    /// The mesh, with the materials that it uses.
    pub(super) fn finish(mut self, document: &Document) -> LoadedMesh {
        let mut surfaces: Vec<Surface> = document.materials().map(|m| surface(&m)).collect();
        if self.material_of.iter().all(|&material| material == NO_SURFACE) {
            surfaces.clear();
            self.material_of.clear();
        } else if self.material_of.contains(&NO_SURFACE) {
            let neutral = surfaces.len() as u32;
            surfaces.push(Surface::NEUTRAL);
            for material in self.material_of.iter_mut().filter(|m| **m == NO_SURFACE) {
                *material = neutral;
            }
        }
        LoadedMesh {
            columns: self.columns,
            surfaces,
            surface_of: self.material_of,
            cameras: self.cameras,
            // By the specification.
            up: UpAxis::Y,
            up_source: UpSource::Stated,
            notes: Vec::new(),
            textures: Vec::new(),
        }
    }
}

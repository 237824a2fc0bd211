//! The mesh files of a scene. A file that is placed a second time is read again and kept for all further placements: most
//! meshes are placed once, and keeping them all would double their memory.

use crate::{
    error::LoadError,
    format::{
        budget::Budget,
        files::{Files, load_error},
        left_out::LeftOut,
        mesh::{self, Cloud, LoadedMesh, MeshCamera},
        ply,
        reason::Reason,
    },
    scene::{Image, MaterialId, SceneBuilder, Transform, TriangleMesh},
};
use std::{
    collections::{HashMap, HashSet},
    io,
    path::{Path, PathBuf},
};

/// How many bytes of meshes may be read again or copied, together: each placement takes its own memory.
const MAX_COPIED_BYTES: u64 = 1 << 31;

/// The share of the memory limit that kept meshes may take.
const KEPT_SHARE: u64 = 4;

/// Which files a statement reads.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// PLY, whatever the file is called.
    Ply,
    /// Every format.
    Any,
}

/// The mesh files of a scene.
#[derive(Default)]
pub(super) struct Meshes {
    /// By their identity, and whether their colours are decoded.
    numbers: HashMap<(PathBuf, bool), usize>,
    files: Vec<MeshFile>,
    /// The files that meshes name.
    beside: HashSet<PathBuf>,
    /// How many bytes were read again or copied.
    copied: u64,
    /// How many bytes the kept meshes take.
    kept: u64,
}

#[derive(Default)]
struct MeshFile {
    /// Whether colours and textures become linear light.
    is_linear: bool,
    was_read: bool,
    kept: Option<Kept>,
    /// The materials of its own surfaces, once a placement uses them.
    own: Option<Vec<MaterialId>>,
}

/// A mesh that is placed again.
struct Kept {
    kind: Kind,
    /// Whether its images were read.
    has_images: bool,
    mesh: LoadedMesh,
}

impl Meshes {
    /// The number of the file with this identity, whose colours and textures become linear light if `is_linear`.
    pub(super) fn number(&mut self, identity: PathBuf, is_linear: bool) -> usize {
        let next = self.files.len();
        let number = *self.numbers.entry((identity, is_linear)).or_insert(next);
        if number == next {
            self.files.push(MeshFile {
                is_linear,
                ..MeshFile::default()
            });
        }
        number
    }

    /// Reads a file, unless its mesh is kept. `None` if it is kept, now or before. Images are read once, and only if the
    /// mesh shows its `own` materials.
    pub(super) fn load(
        &mut self,
        number: usize,
        path: &Path,
        (kind, own, takes_lights): (Kind, bool, bool),
        files: &mut dyn Files,
        budget: &Budget,
    ) -> Result<Option<LoadedMesh>, LoadError> {
        let file = &mut self.files[number];
        let needs_images = own && file.own.is_none();
        let is_whole = |kept: &Kept| kept.kind == kind && (kept.has_images || !needs_images);
        if file.kept.as_ref().is_some_and(is_whole) {
            return Ok(None);
        }
        let (copied, beside) = (&mut self.copied, &mut self.beside);
        let before = budget.taken();
        budget.set_wants_images(needs_images);
        let opened = files.mesh(path, budget);
        let opened = opened.map_err(|error| load_error(path, &error))?;
        if file.was_read {
            count(copied, opened.length()).map_err(|reason| reason.of_file(path))?;
        }
        let mut open = |path: &Path| {
            let opened = files.mesh(path, budget)?;
            if !beside.insert(files.identity(path)) {
                let counted = count(copied, opened.length());
                counted.map_err(|reason| io::Error::new(io::ErrorKind::FileTooLarge, reason.message))?;
            }
            opened.into_bytes(budget)
        };
        let mut mesh = match kind {
            Kind::Ply => ply::read(opened, path, None, budget)?,
            Kind::Any => mesh::read(opened, path, &mut open, budget)?,
        };
        leave_out(&mut mesh, (kind, takes_lights), path);
        if file.is_linear {
            mesh.linearize();
        }
        // To a mesh a missing material library is no fault.
        count(copied, 0).map_err(|reason| reason.of_file(path))?;
        budget.give_back_to(before);
        let size = size_of_mesh(&mesh);
        budget.take(size).map_err(|error| error.into_error(path))?;
        if !std::mem::replace(&mut file.was_read, true) {
            return Ok(Some(mesh));
        }
        mesh.notes.clear();
        mesh.texture_files.clear();
        let all = self.kept.saturating_add(size as u64);
        if all > budget.limit() / KEPT_SHARE {
            return Ok(Some(mesh));
        }
        self.kept = all;
        file.kept = Some(Kept {
            kind,
            has_images: needs_images,
            mesh,
        });
        Ok(None)
    }

    /// The mesh, if it is kept.
    pub(super) fn kept(&self, number: usize) -> Option<&LoadedMesh> {
        let kept = self.files[number].kept.as_ref();
        kept.map(|kept| &kept.mesh)
    }

    /// How many bytes a placement of a kept mesh takes.
    pub(super) fn size(&self, number: usize) -> usize {
        let kept = self.files[number].kept.as_ref();
        kept.map_or(0, |kept| size_of_columns(&kept.mesh))
    }

    /// The cameras of a kept mesh.
    pub(super) fn cameras(&self, number: usize) -> &[MeshCamera] {
        let kept = self.files[number].kept.as_ref();
        kept.map_or(&[], |kept| &kept.mesh.cameras)
    }

    /// Adds a mesh that was read, like [`LoadedMesh::add_to`], except materials and images that exist already. The error is a
    /// sentence.
    pub(super) fn add(
        &mut self,
        number: usize,
        mut mesh: LoadedMesh,
        material: Option<MaterialId>,
        builder: &mut SceneBuilder,
    ) -> Result<(), Reason> {
        let own = &mut self.files[number].own;
        let added = match (material, own) {
            (Some(_), _) => mesh.add_to(builder, material),
            (None, own) => {
                let ids = match own {
                    Some(ids) => ids,
                    None => own.insert(mesh.add_surfaces(builder)?),
                };
                builder.add_texture_files(mesh.texture_files);
                mesh::add_columns(builder, mesh.columns, mesh.cloud, ids, &mesh.surface_of)
            }
        };
        added.map_err(Reason::from)
    }

    /// Adds a copy of a kept mesh to a scene, as [`LoadedMesh::add_to`] does. The error is a sentence.
    pub(super) fn place(
        &mut self,
        number: usize,
        (transform, point_radius): (&Transform, Option<f32>),
        material: Option<MaterialId>,
        builder: &mut SceneBuilder,
        budget: &Budget,
    ) -> Result<(), Reason> {
        let MeshFile { kept, own, .. } = &mut self.files[number];
        let Some(Kept { mesh, .. }) = kept else {
            return Ok(());
        };
        count(&mut self.copied, size_of_columns(mesh))?;
        let mut columns = TriangleMesh {
            x: copied(&mesh.columns.x, budget)?,
            y: copied(&mesh.columns.y, budget)?,
            z: copied(&mesh.columns.z, budget)?,
            normals: copied(&mesh.columns.normals, budget)?,
            colors: match material {
                Some(_) => Vec::new(),
                None => copied(&mesh.columns.colors, budget)?,
            },
            uvs: match material {
                Some(_) => Vec::new(),
                None => copied(&mesh.columns.uvs, budget)?,
            },
            tangents: match material {
                Some(_) => Vec::new(),
                None => copied(&mesh.columns.tangents, budget)?,
            },
            triangles: copied(&mesh.columns.triangles, budget)?,
        };
        transform.apply(&mut columns);
        let cloud = match &mesh.cloud {
            Some(cloud) => Some(Cloud {
                radius: point_radius.or(cloud.radius),
                lines: copied(&cloud.lines, budget)?,
            }),
            None => None,
        };
        let added = if let Some(material) = material {
            mesh::add_columns(builder, columns, cloud, &[material], &[])
        } else {
            let ids = match own {
                Some(ids) => ids,
                None => own.insert(mesh.add_surfaces(builder)?),
            };
            mesh::add_columns(builder, columns, cloud, ids, &mesh.surface_of)
        };
        added.map_err(Reason::from)
    }
}

/// Counts bytes that are read again or copied.
fn count(copied: &mut u64, bytes: usize) -> Result<(), Reason> {
    *copied = copied.saturating_add(bytes as u64);
    if *copied > MAX_COPIED_BYTES {
        return Err(Reason::limit(format!(
            "placing meshes again takes more than {MAX_COPIED_BYTES} bytes, read and copied together"
        )));
    }
    Ok(())
}

fn copied<T: Copy>(from: &[T], budget: &Budget) -> Result<Vec<T>, Reason> {
    let mut copy = Vec::new();
    budget.reserve(&mut copy, from.len())?;
    copy.extend_from_slice(from);
    Ok(copy)
}

/// Removes contents that classic scenes do not have, with a note, and notes lights unless the first placement takes them.
fn leave_out(mesh: &mut LoadedMesh, (kind, takes_lights): (Kind, bool), path: &Path) {
    let mut left_out = LeftOut::default();
    if !takes_lights {
        left_out.count(
            mesh.lights.len(),
            "light (`mesh` takes it with `lights`)",
            "lights (`mesh` takes them with `lights`)",
        );
    }
    if kind == Kind::Ply
        && let Some(cloud) = mesh.cloud.take()
    {
        left_out.add(if cloud.lines.is_empty() { "points" } else { "lines" });
    }
    mesh.notes.extend(left_out.note(path));
}

/// How many bytes a mesh takes.
fn size_of_mesh(mesh: &LoadedMesh) -> usize {
    let images = mesh.images.iter().map(|image| Image::bytes(image.size()));
    let images: usize = images.sum();
    let lights = size_of_val(&mesh.lights[..]);
    size_of_columns(mesh) + images + size_of_val(&mesh.surfaces[..]) + size_of_val(&mesh.cameras[..]) + lights
}

/// How many bytes the arrays of its vertices and triangles take.
pub(super) fn size_of_columns(mesh: &LoadedMesh) -> usize {
    let columns = &mesh.columns;
    size_of_val(&columns.x[..])
        + size_of_val(&columns.y[..])
        + size_of_val(&columns.z[..])
        + size_of_val(&columns.normals[..])
        + size_of_val(&columns.colors[..])
        + size_of_val(&columns.uvs[..])
        + size_of_val(&columns.tangents[..])
        + size_of_val(&columns.triangles[..])
        + size_of_val(&mesh.surface_of[..])
        + mesh
            .cloud
            .as_ref()
            .map_or(0, |cloud| size_of_val(&cloud.lines[..]))
}

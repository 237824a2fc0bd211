//! Meshes of a scene: their files and their placement.

use super::{MAX_PATH, QUOTES_HINT, Reader, arguments::Arguments, words::Word};
use crate::{
    error::{LoadError, quote},
    format::{
        files,
        mesh::{self, LoadedMesh, MeshFormat},
        ply,
    },
    scene::{Camera, MaterialId, NamedCamera, Transform},
};
use glam::DVec3;
use std::path::PathBuf;

/// How many bytes of mesh files may be read for copies: each copy takes its own memory.
const MAX_COPIED_BYTES: u64 = 1 << 31;

/// How many meshes a scene may place. Exact repetitions do not count: their files are not read.
const MAX_MESHES: usize = 1 << 16;

/// How many cameras of meshes a scene keeps.
const MAX_MESH_CAMERAS: usize = 1 << 10;

/// Which files a statement reads.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// PLY, whatever the file is called.
    Ply,
    /// Every format.
    Any,
}

/// Equal for equal meshes: the file, and the bits of the transform.
pub(super) type Placed = (PathBuf, [u64; 12]);

impl Reader<'_> {
    /// `ply_file PATH`: a PLY mesh, not moved, with the current material.
    pub(super) fn ply_file(&mut self, mut arguments: Arguments<'_, '_>) -> Result<(), LoadError> {
        let [path] = arguments.leading()?;
        arguments.hint = QUOTES_HINT;
        arguments.end()?;
        let material = self.shape_material();
        self.add_mesh(&arguments, path, Transform::IDENTITY, Some(material), Kind::Ply)
    }

    /// `mesh PATH ...`: a mesh of any format, placed, with the current material or its own.
    pub(super) fn mesh(&mut self, mut arguments: Arguments<'_, '_>) -> Result<(), LoadError> {
        let [path] = arguments.leading()?;
        arguments.hint = QUOTES_HINT;
        let transform = read_transform(&mut arguments)?;
        self.needs_light |= self.material.is_none() || !self.is_silhouette;
        self.add_mesh(&arguments, path, transform, self.material, Kind::Any)
    }

    /// Adds a mesh, unless the same one stands there already: at equal t the lowest id wins, so the copy would be
    /// invisible. Ten thousand lines that name one mesh cost no more than one.
    fn add_mesh(
        &mut self,
        arguments: &Arguments<'_, '_>,
        word: Word<'_>,
        transform: Transform,
        material: Option<MaterialId>,
        kind: Kind,
    ) -> Result<(), LoadError> {
        let line = arguments.line;
        let what = match kind {
            Kind::Ply => ".ply",
            Kind::Any => "mesh",
        };
        let path = self.path(arguments, word, what)?;
        let cannot_load = |cause: LoadError| {
            line.error_at(&word, format!("cannot load {}", path.display()))
                .caused_by(cause)
        };
        let identity = self.files.identity(&path);
        let placed = (identity.clone(), transform.bits());
        if self.meshes.contains(&placed) {
            return Ok(());
        }
        if self.meshes.len() >= MAX_MESHES {
            return Err(line.error_at(&word, format!("more than {MAX_MESHES} placed meshes")));
        }
        let file = self
            .files
            .mesh(&path, self.budget)
            .map_err(|error| cannot_load(files::load_error(&path, &error)))?;
        if !self.mesh_files.insert(identity) {
            self.copied_bytes += file.length() as u64;
            if self.copied_bytes > MAX_COPIED_BYTES {
                let message = format!(
                    "copies of meshes add up to more than {MAX_COPIED_BYTES} bytes of files; each takes its own memory"
                );
                return Err(line.error_at(&word, message));
            }
        }
        let (files, budget) = (&mut *self.files, self.budget);
        let loaded = match kind {
            Kind::Ply => ply::read(file, &path, budget),
            Kind::Any => mesh::read(file, &path, &mut |path| files.beside_mesh(path, budget), budget),
        };
        let other_format = MeshFormat::of_path(&path).is_some_and(|format| format != MeshFormat::Ply);
        let mut loaded = loaded.map_err(|cause| {
            if kind == Kind::Ply && other_format {
                let message = "`ply_file` reads only PLY, expected `mesh` for other formats";
                return line.error_at(&arguments.keyword, message).caused_by(cause);
            }
            cannot_load(cause)
        })?;
        transform.apply(&mut loaded.columns);
        for note in std::mem::take(&mut loaded.notes) {
            self.builder.add_note(note);
        }
        self.add_cameras(&loaded, &transform);
        loaded.add_to(&mut self.builder, material).map_err(|error| {
            if transform == Transform::IDENTITY {
                cannot_load(LoadError::whole_file(&path, error.to_string()))
            } else {
                // The fault may lie in the placement, not in the file.
                line.error_at(&word, format!("cannot place {}: {error}", path.display()))
            }
        })?;
        self.meshes.insert(placed);
        Ok(())
    }

    /// Adds the cameras of a mesh, except those without a valid view.
    fn add_cameras(&mut self, mesh: &LoadedMesh, transform: &Transform) {
        let left = MAX_MESH_CAMERAS.saturating_sub(self.mesh_cameras);
        for camera in mesh.cameras.iter().take(left) {
            if let Ok(view) = Camera::new(&transform.view(&camera.view())) {
                self.mesh_cameras += 1;
                self.builder.add_mesh_camera(NamedCamera {
                    name: Some(camera.name.clone()).filter(|name| !name.is_empty()),
                    camera: view,
                });
            }
        }
    }

    /// A path of the scene file, joined to its folder.
    pub(super) fn path(
        &self,
        arguments: &Arguments<'_, '_>,
        word: Word<'_>,
        what: &str,
    ) -> Result<PathBuf, LoadError> {
        let message = match word.as_str() {
            Some("") => format!("the path is empty, expected the path of a {what} file"),
            Some(path) if path.len() > MAX_PATH => {
                format!("path of {} bytes, expected at most {MAX_PATH}", path.len())
            }
            Some(path) => return Ok(self.folder.join(path)),
            None => format!("path {} is not valid UTF-8", quote(word.text)),
        };
        Err(arguments.line.error_at(&word, message))
    }
}

/// The steps that place a mesh, in the order in which they apply.
fn read_transform(arguments: &mut Arguments<'_, '_>) -> Result<Transform, LoadError> {
    let mut transform = Transform::IDENTITY;
    while let Some((word, key)) = arguments.key(&["scale", "rotate", "translate"])? {
        transform = match key {
            "scale" => transform.then_scale(read_scale(arguments, word)?),
            "rotate" => {
                let [x, y, z, degrees] = arguments.take(word, "rotate x y z DEG")?;
                let axis = arguments.vector([x, y, z])?;
                if axis.try_normalize().is_none() {
                    let message =
                        "the axis of `rotate` is zero, expected a direction, such as `rotate 0 0 1 90`";
                    return Err(arguments.line.error(x.start, z.end() - x.start, message));
                }
                transform.then_rotate(axis, arguments.precise(degrees, "degrees")?)
            }
            _ => {
                let words = arguments.take(word, "translate x y z")?;
                transform.then_translate(arguments.vector(words)?)
            }
        };
    }
    Ok(transform)
}

/// One number for all axes, or three.
fn read_scale(arguments: &mut Arguments<'_, '_>, key: Word<'_>) -> Result<DVec3, LoadError> {
    let factor = |arguments: &Arguments<'_, '_>, word: Word<'_>| {
        let value = arguments.precise(word, "scale")?;
        // Products of several smaller ones round to zero.
        if value.abs() >= 1e-9 {
            return Ok(value);
        }
        let message = format!(
            "scale is {}, expected a number of size 1e-9 or more",
            quote(word.text)
        );
        Err(arguments.line.error_at(&word, message))
    };
    let [first] = arguments.take(key, "scale s` or `scale x y z")?;
    let x = factor(arguments, first)?;
    let is_number = |word: Option<Word<'_>>| word.is_some_and(|word| arguments.precise(word, "").is_ok());
    if !is_number(arguments.peek()) {
        return Ok(DVec3::splat(x));
    }
    if !is_number(arguments.peek_second()) {
        let second = arguments.peek().unwrap_or(first);
        let message = "`scale` with 2 numbers, expected `scale s` or `scale x y z`";
        return Err(arguments.line.error(second.end(), 1, message));
    }
    let [y, z] = arguments.take(key, "scale x y z")?;
    Ok(DVec3::new(x, factor(arguments, y)?, factor(arguments, z)?))
}

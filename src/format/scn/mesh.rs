//! Meshes of a scene: their files and their placement.

use super::{
    MAX_PATH, QUOTES_HINT, Reader,
    arguments::Arguments,
    line::Line,
    meshes::{Kind, size_of_columns},
    words::Word,
};
use crate::{
    error::{LoadError, clip_path, quote},
    format::{
        mesh::{LoadedMesh, MAX_CAMERAS, MeshCamera, MeshFormat},
        reason::Reason,
    },
    scene::{Camera, MaterialId, NamedCamera, SceneBuilder, Step, Transform},
};
use glam::DVec3;
use std::path::{Path, PathBuf};

/// How many meshes a scene may place, repetitions included.
const MAX_MESHES: usize = 1 << 16;

/// How many notes about its meshes a scene keeps.
const MAX_NOTES: usize = 1000;

/// Equal for equal meshes; numbers by their bits.
#[derive(PartialEq, Eq, Hash)]
pub(super) struct PlacementKey {
    /// The number of the file.
    mesh: usize,
    material: Option<MaterialId>,
    transform: [u64; 12],
    /// The radius of points, and the intensity of lights.
    numbers: [Option<u32>; 2],
    /// Whether colours and points are shown.
    is_any: bool,
}

/// How a mesh is placed.
#[derive(Clone, Copy)]
pub(super) struct Placement<'a> {
    pub(super) transform: Transform,
    /// Radius of the points and lines of a file without faces, scene units; `None` for that of the cloud.
    pub(super) point_radius: Option<f32>,
    /// A file of placements, and the transform before each of them.
    pub(super) file: Option<(Transform, Word<'a>)>,
    /// The total intensity of the file's lights at the centre of the mesh; `None` without them.
    pub(super) lights: Option<f32>,
    /// Whether the mesh is stored for instances, without its cameras.
    pub(super) is_stored: bool,
}

impl Placement<'_> {
    pub(super) const AS_IT_IS: Self = Self {
        transform: Transform::IDENTITY,
        point_radius: None,
        file: None,
        lights: None,
        is_stored: false,
    };
}

/// What may follow the path of a mesh.
const MESH_KEYS: [&str; 5] = ["scale", "rotate", "translate", "point_size", "lights"];

/// What may follow the time of a keyframe.
const STEPS: [&str; 3] = ["scale", "rotate", "translate"];

/// What may follow that of an instance.
pub(super) const INSTANCE_KEYS: [&str; 5] = ["scale", "rotate", "translate", "point_size", "placements"];

impl Reader<'_> {
    /// `ply_file PATH`: a PLY mesh, not moved, with the current material.
    pub(super) fn ply_file(&mut self, mut arguments: Arguments<'_, '_>) -> Result<(), LoadError> {
        let [path] = arguments.leading()?;
        arguments.hint = QUOTES_HINT;
        arguments.end()?;
        let material = self.shape_material();
        self.add_mesh(&arguments, path, Placement::AS_IT_IS, Some(material), Kind::Ply)
    }

    /// `mesh PATH ...`: a mesh of any format, placed, with the current material or its own.
    pub(super) fn mesh(&mut self, mut arguments: Arguments<'_, '_>) -> Result<(), LoadError> {
        let [path] = arguments.leading()?;
        arguments.hint = QUOTES_HINT;
        let placement = read_placement(&mut arguments, &MESH_KEYS)?;
        self.add_mesh(&arguments, path, placement, self.material, Kind::Any)
    }

    /// Adds a mesh, unless it is already placed there with the same material: at equal t the lowest id wins, so the copy would be
    /// invisible. Ten thousand identical lines cost no more than one.
    fn add_mesh(
        &mut self,
        arguments: &Arguments<'_, '_>,
        word: Word<'_>,
        placement: Placement<'_>,
        material: Option<MaterialId>,
        kind: Kind,
    ) -> Result<(), LoadError> {
        let line = arguments.line;
        let what = match kind {
            Kind::Ply => ".ply",
            Kind::Any => "mesh",
        };
        self.placing += 1;
        if self.placing > MAX_MESHES {
            return Err(line.too_many(&word, format!("more than {MAX_MESHES} placed meshes")));
        }
        let path = self.path(arguments, word, what)?;
        let number = self.mesh_number(&path, material);
        let key = PlacementKey {
            mesh: number,
            material,
            transform: placement.transform.bits(),
            numbers: [placement.point_radius, placement.lights].map(|number| number.map(f32::to_bits)),
            is_any: kind == Kind::Any,
        };
        if self.placements.contains(&key) {
            return Ok(());
        }
        let takes_lights = placement.lights.is_some();
        let mut loaded = self.load_mesh(arguments, word, &path, (material, kind, takes_lights))?;
        self.see_light(number, loaded.as_ref(), material);
        note_faces(loaded.as_mut(), &path, placement.point_radius);
        let lit = match placement.lights {
            Some(together) => self.light_up(number, loaded.as_ref(), (&placement, together), &path),
            None => Ok(()),
        };
        let added = lit.and_then(|()| self.place(number, loaded, &placement, material));
        added.map_err(|reason| {
            if placement.transform == Transform::IDENTITY {
                cannot_load(line, word, &path).caused_by(reason.of_file(&path))
            } else {
                // The fault may lie in the placement, not in the file.
                line.error_at(&word, format!("cannot place {}: {reason}", path.display()))
                    .with_kind(reason.kind)
            }
        })?;
        self.placements.insert(key);
        Ok(())
    }

    /// The number of a mesh file that is shown with `material`, or its own.
    pub(super) fn mesh_number(&mut self, path: &Path, material: Option<MaterialId>) -> usize {
        let is_linear = material.is_none() && self.own_is_srgb;
        self.meshes.number(self.files.identity(path), is_linear)
    }

    /// Reads the file of a mesh, unless it is kept.
    pub(super) fn load_mesh(
        &mut self,
        arguments: &Arguments<'_, '_>,
        word: Word<'_>,
        path: &Path,
        (material, kind, takes_lights): (Option<MaterialId>, Kind, bool),
    ) -> Result<Option<LoadedMesh>, LoadError> {
        let (number, is_own) = (self.mesh_number(path, material), material.is_none());
        let loaded = self.meshes.load(
            number,
            path,
            (kind, is_own, takes_lights),
            self.files,
            self.budget,
        );
        let other_format = MeshFormat::of_path(path).is_some_and(|format| format != MeshFormat::Ply);
        loaded.map_err(|cause| {
            if kind == Kind::Ply && other_format {
                let message = "`ply_file` reads only PLY, expected `mesh` for other formats";
                return arguments
                    .line
                    .error_at(&arguments.keyword, message)
                    .caused_by(cause);
            }
            if path
                .extension()
                .is_some_and(|extension| extension.eq_ignore_ascii_case("scn"))
            {
                let keyword = quote(arguments.keyword.text);
                let message = format!("{keyword} reads meshes, expected `include` for scenes");
                return arguments
                    .line
                    .error_at(&arguments.keyword, message)
                    .caused_by(cause);
            }
            cannot_load(arguments.line, word, path).caused_by(cause)
        })
    }

    /// Remembers whether a mesh, `loaded` or else kept, needs light with `material` or its own.
    pub(super) fn see_light(
        &mut self,
        number: usize,
        loaded: Option<&LoadedMesh>,
        material: Option<MaterialId>,
    ) {
        self.needs_light |= match (material, loaded.or_else(|| self.meshes.kept(number))) {
            (Some(_), _) => !self.is_silhouette,
            (None, mesh) => mesh.is_some_and(LoadedMesh::needs_light),
        };
    }

    /// Adds the lights of a mesh, `loaded` or else kept, with the total intensity `together` at its centre. The error is a
    /// sentence.
    fn light_up(
        &mut self,
        number: usize,
        loaded: Option<&LoadedMesh>,
        (placement, together): (&Placement<'_>, f32),
        path: &Path,
    ) -> Result<(), Reason> {
        let mesh = loaded.or_else(|| self.meshes.kept(number));
        let Some(mesh) = mesh else { return Ok(()) };
        let lights = mesh.placed_lights(&placement.transform, together)?;
        if lights.is_empty() {
            let why = if mesh.lights.is_empty() {
                "`lights`, but the file has none that can be read"
            } else {
                "`lights`, but none of the file's reaches the mesh"
            };
            self.add_mesh_note(format!("{}: {why}", clip_path(path)));
        }
        for light in lights {
            self.has_lights = true;
            self.builder.add(light)?;
        }
        Ok(())
    }

    /// Adds a note about a mesh, unless there are too many.
    pub(super) fn add_mesh_note(&mut self, note: String) {
        if self.mesh_notes < MAX_NOTES {
            self.mesh_notes += 1;
            self.builder.add_note(note);
        }
    }

    /// Adds a mesh with its cameras, lights and notes: `loaded`, or else a copy of the kept one. The error is a sentence.
    pub(super) fn place(
        &mut self,
        number: usize,
        loaded: Option<LoadedMesh>,
        placement: &Placement<'_>,
        material: Option<MaterialId>,
    ) -> Result<(), Reason> {
        let Placement {
            transform,
            point_radius,
            is_stored,
            ..
        } = placement;
        // Arrays that grow take up to twice their size; the first ones are moved.
        if !self.placements.is_empty() || !self.prototypes.is_empty() {
            let size = loaded.as_ref().map(size_of_columns);
            let size = size.unwrap_or_else(|| self.meshes.size(number));
            self.budget.take(size)?;
        }
        let (builder, count) = (&mut self.builder, &mut self.mesh_cameras);
        let Some(mut mesh) = loaded else {
            if !is_stored {
                add_cameras(builder, count, self.meshes.cameras(number), transform);
            }
            return self
                .meshes
                .place(number, (transform, *point_radius), material, builder, self.budget);
        };
        for note in std::mem::take(&mut mesh.notes) {
            self.add_mesh_note(note);
        }
        let (builder, count) = (&mut self.builder, &mut self.mesh_cameras);
        if !is_stored {
            add_cameras(builder, count, &mesh.cameras, transform);
        }
        transform.apply(&mut mesh.columns);
        if let Some(cloud) = &mut mesh.cloud {
            cloud.radius = *point_radius;
        }
        self.meshes.add(number, mesh, material, builder)
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

/// Adds a note if a file with faces has a `point_size`.
pub(super) fn note_faces(loaded: Option<&mut LoadedMesh>, path: &Path, point_radius: Option<f32>) {
    if let (Some(mesh), Some(_)) = (loaded.filter(|mesh| mesh.cloud.is_none()), point_radius) {
        let path = clip_path(path);
        mesh.notes
            .push(format!("{path}: the mesh has faces, so point_size has no effect"));
    }
}

/// The error about a mesh's file, without its cause.
pub(super) fn cannot_load(line: &Line<'_>, word: Word<'_>, path: &Path) -> LoadError {
    line.error_at(&word, format!("cannot load {}", path.display()))
}

/// Adds the cameras of a mesh, except those without a valid view. `count` is how many cameras meshes had so far.
fn add_cameras(builder: &mut SceneBuilder, count: &mut usize, cameras: &[MeshCamera], transform: &Transform) {
    for camera in cameras.iter().take(MAX_CAMERAS.saturating_sub(*count)) {
        *count += 1;
        if let Ok(view) = Camera::new(&transform.view(&camera.view())) {
            builder.add_mesh_camera(NamedCamera {
                name: Some(camera.name.clone()).filter(|name| !name.is_empty()),
                camera: view,
            });
        }
    }
}

/// The steps that place a mesh, in the order in which they apply, and the size of points and lines.
pub(super) fn read_placement<'a>(
    arguments: &mut Arguments<'_, 'a>,
    keys: &[&'static str],
) -> Result<Placement<'a>, LoadError> {
    let Placement {
        mut transform,
        mut point_radius,
        mut file,
        mut lights,
        is_stored,
    } = Placement::AS_IT_IS;
    while let Some((word, key)) = arguments.key(keys)? {
        transform = match key {
            "placements" => {
                if file.is_some() {
                    return Err(arguments.line.error_at(&word, "second placements, expected one"));
                }
                let [path] = arguments.take(word, "placements FILE")?;
                file = Some((transform, path));
                Transform::IDENTITY
            }
            "lights" => {
                if lights.is_some() {
                    return Err(arguments.line.error_at(&word, "second lights, expected one"));
                }
                lights = Some(read_lights(arguments, word)?);
                continue;
            }
            "point_size" => {
                if point_radius.is_some() {
                    return Err(arguments.line.error_at(&word, "second point_size, expected one"));
                }
                point_radius = Some(read_radius(arguments, word)?);
                continue;
            }
            _ => transform.then_step(&read_step(arguments, word, key)?),
        };
    }
    Ok(Placement {
        transform,
        point_radius,
        file,
        lights,
        is_stored,
    })
}

/// How bright the lights of a file are together.
fn read_lights(arguments: &mut Arguments<'_, '_>, key: Word<'_>) -> Result<f32, LoadError> {
    let [word] = arguments.take(key, "lights BRIGHTNESS")?;
    let together = arguments.number(word, "lights")?;
    if together > 0.0 {
        return Ok(together);
    }
    let message = format!("lights is {}, expected a number above 0", word.number());
    Err(arguments.line.error_at(&word, message))
}

/// The steps of a keyframe.
pub(super) fn read_steps(arguments: &mut Arguments<'_, '_>) -> Result<Vec<Step>, LoadError> {
    let mut steps = Vec::new();
    while let Some((word, key)) = arguments.key(&STEPS)? {
        steps.push(read_step(arguments, word, key)?);
    }
    Ok(steps)
}

/// One of [`STEPS`].
fn read_step(arguments: &mut Arguments<'_, '_>, word: Word<'_>, key: &str) -> Result<Step, LoadError> {
    Ok(match key {
        "scale" => Step::Scale(read_scale(arguments, word)?),
        "rotate" => {
            let [x, y, z, degrees] = arguments.take(word, "rotate x y z DEG")?;
            let axis = arguments.vector([x, y, z])?;
            if axis.try_normalize().is_none() {
                let message = "the axis of `rotate` is zero, expected a direction, such as `rotate 0 0 1 90`";
                return Err(arguments.line.error(x.start, z.end() - x.start, message));
            }
            let degrees = arguments.precise(degrees, "degrees")?;
            Step::Rotate { axis, degrees }
        }
        _ => {
            let words = arguments.take(word, "translate x y z")?;
            Step::Translate(arguments.vector(words)?)
        }
    })
}

/// The radius of points and lines, given as their diameter.
fn read_radius(arguments: &mut Arguments<'_, '_>, key: Word<'_>) -> Result<f32, LoadError> {
    let [word] = arguments.take(key, "point_size DIAMETER")?;
    let radius = (0.5 * arguments.precise(word, "point_size")?) as f32;
    if radius > 0.0 {
        return Ok(radius);
    }
    let message = format!("point_size is {}, expected a diameter above 0", word.number());
    Err(arguments.line.error_at(&word, message))
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
            "scale is {}, expected a number of magnitude 1e-9 or more",
            word.number()
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

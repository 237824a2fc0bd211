//! Meshes of every format, as one type.
//!
//! [`load`] reads a file; [`parse`] does the same with bytes, and asks for the files beside it. Which format it
//! is is decided by [`MeshFormat::of`]: by what the bytes begin with where that leaves no doubt, else by the
//! file's extension.

use super::{OpenMesh, files, gltf, obj, ply, source::Opened, stl};
use crate::{
    error::{LoadError, SceneError},
    scene::{Material, MaterialId, MeshColumns, SceneBuilder, View},
};
use glam::DVec3;
use std::path::{Path, PathBuf};

/// A mesh and what its file says about how to show it.
#[derive(Debug, Default)]
pub struct LoadedMesh {
    /// Positions, normals and triangles, in the file's own coordinates: nothing is turned or scaled.
    pub columns: MeshColumns,
    /// The surfaces that the file describes; empty if it describes none.
    pub surfaces: Vec<Surface>,
    /// For each triangle an index into `surfaces`; empty if `surfaces` is.
    pub surface_of: Vec<u32>,
    /// The file's perspective cameras, in its own coordinates.
    pub cameras: Vec<MeshCamera>,
    /// Which way is up by the format's convention.
    pub up: UpAxis,
    /// What was left out or missing and is no error, a sentence each: to be printed as warnings.
    pub notes: Vec<String>,
}

/// How a surface looks. Colours as they are shown under full light: display values, 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Diffuse colour.
    pub diffuse: [f32; 3],
    /// Colour of the highlight, strength included.
    pub specular: [f32; 3],
    /// Exponent of the highlight.
    pub alpha: u32,
}

impl Surface {
    /// A neutral, slightly glossy grey, for meshes that say nothing of their look.
    pub const NEUTRAL: Self = Self {
        diffuse: [0.86, 0.86, 0.84],
        specular: [0.12; 3],
        alpha: 24,
    };

    /// The surface as Blinn-Phong.
    #[must_use]
    pub fn material(&self) -> Material {
        Material::BlinnPhong {
            diffuse: self.diffuse,
            specular: self.specular,
            k_d: 1.0,
            k_s: 1.0,
            alpha: self.alpha,
        }
    }
}

/// A perspective camera of a mesh file, in the mesh's coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshCamera {
    /// Its name; empty if the file gives it none.
    pub name: String,
    /// Where it stands.
    pub eye: DVec3,
    /// A point that it looks at.
    pub target: DVec3,
    /// Which way is up in its picture.
    pub up: DVec3,
    /// Vertical field of view, degrees.
    pub fov_degrees: f64,
}

impl MeshCamera {
    /// How it looks at the mesh.
    #[must_use]
    pub fn view(&self) -> View {
        View {
            eye: self.eye,
            target: self.target,
            up: self.up,
            fov_degrees: self.fov_degrees,
        }
    }
}

/// The axis that points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UpAxis {
    /// glTF (by its specification) and OBJ (by habit).
    Y,
    /// PLY and STL, by habit.
    #[default]
    Z,
}

impl UpAxis {
    /// The axis as a unit vector.
    #[must_use]
    pub fn vector(self) -> DVec3 {
        match self {
            Self::Y => DVec3::Y,
            Self::Z => DVec3::Z,
        }
    }
}

/// The kinds of mesh files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// Stanford's polygon format, text or binary.
    Ply,
    /// Wavefront OBJ.
    Obj,
    /// Stereolithography, text or binary.
    Stl,
    /// glTF 2.0, as JSON or as one binary file (.glb).
    Gltf,
}

impl MeshFormat {
    /// What is said about files of other kinds.
    pub const EXPECTED: &str = "expected a mesh: .ply, .obj, .stl, .gltf or .glb";

    /// The format by the file's extension, in letters of either case.
    #[must_use]
    pub fn of_path(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "ply" => Some(Self::Ply),
            "obj" => Some(Self::Obj),
            "stl" => Some(Self::Stl),
            "gltf" | "glb" => Some(Self::Gltf),
            _ => None,
        }
    }

    /// The format by what the file begins with, where that leaves no doubt, else by its extension.
    #[must_use]
    pub fn of(path: &Path, bytes: &[u8]) -> Option<Self> {
        if bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r") {
            Some(Self::Ply)
        } else if bytes.starts_with(b"glTF") {
            Some(Self::Gltf)
        } else {
            Self::of_path(path)
        }
    }
}

impl LoadedMesh {
    /// A mesh without anything said about its look.
    #[must_use]
    pub fn plain(columns: MeshColumns, up: UpAxis) -> Self {
        Self {
            columns,
            up,
            ..Self::default()
        }
    }

    /// Adds the mesh to a scene: with `material` if one is given, else with its own surfaces, and with
    /// [`Surface::NEUTRAL`] if it has none.
    ///
    /// # Errors
    /// [`SceneError`], as of [`SceneBuilder::add_mesh`].
    pub fn add_to(self, builder: &mut SceneBuilder, material: Option<MaterialId>) -> Result<(), SceneError> {
        match material {
            Some(material) => builder.add_mesh(self.columns, material),
            None if self.surfaces.is_empty() => {
                let material = builder.add_material(Surface::NEUTRAL.material())?;
                builder.add_mesh(self.columns, material)
            }
            None => {
                let ids: Result<Vec<MaterialId>, SceneError> = self
                    .surfaces
                    .iter()
                    .map(|surface| builder.add_material(surface.material()))
                    .collect();
                let ids = ids?;
                let of_triangle = self.surface_of.iter();
                // An index beyond the surfaces becomes a material that the builder refuses.
                let materials = of_triangle
                    .map(|&i| ids.get(i as usize).copied().unwrap_or(MaterialId(u32::MAX)))
                    .collect();
                builder.add_mesh_with_materials(self.columns, materials)
            }
        }
    }
}

/// Loads a mesh file and the files that it names.
///
/// # Errors
/// [`LoadError`], with the place of the fault as far as the format has places.
pub fn load(path: &Path) -> Result<LoadedMesh, LoadError> {
    load_within(path, &mut Vec::new(), u64::MAX)
}

/// As [`load`], and adds to `asked` every file that was asked for: what is to be watched for changes. No file may have
/// more bytes than there are of `memory`.
///
/// # Errors
/// [`LoadError`], as for [`load`].
pub fn load_within(path: &Path, asked: &mut Vec<PathBuf>, memory: u64) -> Result<LoadedMesh, LoadError> {
    asked.push(path.to_path_buf());
    let file = files::open(path, memory).map_err(|error| files::load_error(path, &error))?;
    read(Opened::File(file), path, &mut |path| {
        asked.push(path.to_path_buf());
        files::read(path, memory)
    })
}

/// So many bytes tell that an .obj is no text.
const TEXT_HEAD: usize = 4096;

/// Reads a mesh from its file, as [`parse`] does from bytes: in pieces or as a whole, as its format wants it.
pub(super) fn read(opened: Opened, path: &Path, open: OpenMesh<'_>) -> Result<LoadedMesh, LoadError> {
    if MeshFormat::of(path, opened.head(16, &mut Vec::new())) == Some(MeshFormat::Ply) {
        let has_colors = ply::has_vertex_colors(opened.head(ply::HEAD, &mut Vec::new()));
        return Ok(plain_ply(ply::read(opened, path)?, has_colors));
    }
    let mut head = Vec::new();
    let head = opened.head(TEXT_HEAD, &mut head);
    match MeshFormat::of(path, head) {
        // To find the same out from gigabytes would take seconds.
        Some(MeshFormat::Obj) if head.contains(&0) => return obj::parse(head, path, open),
        Some(MeshFormat::Stl) => return stl::read(opened, path),
        _ => {}
    }
    let bytes = opened.into_bytes();
    parse(
        bytes.map_err(|error| files::load_error(path, &error))?,
        path,
        open,
    )
}

fn plain_ply(columns: MeshColumns, has_colors: bool) -> LoadedMesh {
    let mut loaded = LoadedMesh::plain(columns, UpAxis::Z);
    if has_colors {
        loaded.notes.push("left out: vertex colours".to_owned());
    }
    loaded
}

/// Reads a mesh from the bytes of its file. `path` stands for the file in errors, and tells its format where the
/// bytes do not; `open` gives the bytes of files that it names (an .mtl, a .bin), by paths joined to its folder.
///
/// # Errors
/// [`LoadError`], as for [`load`].
#[allow(
    clippy::needless_pass_by_value,
    reason = "the bytes are gone when the mesh is there, and both are large"
)]
pub fn parse(bytes: Vec<u8>, path: &Path, open: OpenMesh<'_>) -> Result<LoadedMesh, LoadError> {
    match MeshFormat::of(path, &bytes) {
        Some(MeshFormat::Ply) => {
            let has_colors = ply::has_vertex_colors(&bytes);
            Ok(plain_ply(ply::parse(&bytes, path)?, has_colors))
        }
        Some(MeshFormat::Obj) => obj::parse(&bytes, path, open),
        Some(MeshFormat::Stl) => stl::parse(&bytes, path),
        Some(MeshFormat::Gltf) => gltf::parse(&bytes, path, open),
        None => Err(LoadError::whole_file(
            path,
            format!(
                "this is no kind of mesh that octray reads, {}",
                MeshFormat::EXPECTED
            ),
        )),
    }
}

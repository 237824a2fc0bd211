//! Meshes of every format, as one type.
//!
//! [`load`] reads a file; [`parse`] reads bytes and calls back for the files that the mesh names. [`MeshFormat::of`] detects
//! the format by the first bytes if they are unmistakable, else by the file's extension.

mod animation;
mod cloud;
mod far;
mod lights;
mod load;
pub(super) mod scalars;
mod scene;
mod shared;
mod stray;
mod tubes;
mod up;
mod used;

pub use animation::{MeshAnimation, Moment};
#[cfg(feature = "cli")]
pub(crate) use animation::{index_of, listed};
pub use cloud::Cloud;
#[cfg(feature = "cli")]
pub(crate) use far::Coarse;
pub(super) use far::read as read_far;
#[cfg(feature = "cli")]
pub(crate) use lights::{exposed, sphere_around};
#[cfg(feature = "cli")]
pub(crate) use load::{animations, load_shown};
pub use load::{load, load_posed, load_shared, load_within, parse, parse_posed, parse_shared, parse_within};
pub(super) use load::{parse_as, read};
#[doc(hidden)]
pub use scalars::Scalars;
#[cfg(feature = "cli")]
pub(crate) use scalars::value_of;
pub(crate) use scalars::{Owner, Range, Scalar, Wanted, channels};
pub(super) use scene::add_columns;
pub use shared::{SharedMesh, Sharing};
#[cfg(feature = "gltf")]
pub(super) use tubes::{TRIANGLES as LINE_TRIANGLES, VERTICES as LINE_VERTICES};
pub use up::{UpAxis, UpSource};
pub(super) use used::{Unusable, usable_normal};

use super::{left_out::counted, place::BYTE_ORDER_MARK, textures::names};
use crate::{
    error::clip_path,
    scene::{Image, Lens, Light, MAX_TEXTURES, Material, Projection, SurfaceTextures, TriangleMesh, View},
};
use glam::DVec3;
use rayon::prelude::*;
use std::path::{Path, PathBuf};

/// A mesh, with the surfaces, cameras and lights of its file.
#[derive(Clone, Debug, Default)]
pub struct LoadedMesh {
    /// Positions, normals, colours and triangles in the file's coordinates less `offset`, not rotated or scaled. Colours are
    /// display values from 0 to 1, like those of [`Surface`]. If there are triangles, they use every vertex.
    pub columns: TriangleMesh,
    /// What `columns`, placements of `shared` and `lights` are relative to: 0, unless the mesh is so far from 0 for its size
    /// that `f32` is coarse, as in coordinates of a map, and the file has finer ones. [`LoadedMesh::move_offset`] changes it.
    pub offset: DVec3,
    /// Parts that are stored once and placed several times; only in glTF files read with [`Sharing`].
    pub shared: Vec<SharedMesh>,
    /// The surfaces that the file describes; may be empty.
    pub surfaces: Vec<Surface>,
    /// An index into `surfaces` for each triangle; empty if `surfaces` is.
    pub surface_of: Vec<u32>,
    /// The images that the textures of `surfaces` show.
    pub images: Vec<Image>,
    /// How vertices of a file without faces become spheres, and the lines between them; `None` if it has faces.
    pub cloud: Option<Cloud>,
    /// The file's cameras, perspective and orthographic, in its own coordinates.
    pub cameras: Vec<MeshCamera>,
    /// The file's lights, in its own coordinates less `offset`. Their intensities are relative to each other; those that have a
    /// position fall off.
    pub lights: Vec<Light>,
    /// The file's animations; only glTF has some.
    pub animations: Vec<MeshAnimation>,
    /// The axis that points up.
    pub up: UpAxis,
    /// Whether the file says so, or octray assumes it.
    pub up_source: UpSource,
    /// Warnings about missing files and ignored contents. Each begins with a file's path.
    pub notes: Vec<String>,
    /// The files of textures that the mesh names, read or not.
    pub texture_files: Vec<PathBuf>,
    /// Numbers that only octray's program asks for.
    #[doc(hidden)]
    pub scalars: Scalars,
}

/// What a command shows of a mesh.
#[cfg(feature = "cli")]
#[derive(Clone, Debug, Default)]
pub(crate) struct Shown {
    /// The images of its textures.
    pub images: bool,
    /// The pose of an animation instead of the stored one.
    pub moment: Option<Moment>,
    /// Numbers instead of its colours.
    pub scalars: Wanted,
}

#[cfg(feature = "cli")]
impl Shown {
    /// What becomes of parts that are placed several times: coordinates differ from place to place.
    pub(super) fn sharing(&self) -> Sharing {
        if self.scalars == Wanted::Coordinates {
            Sharing::Never
        } else {
            Sharing::WherePays
        }
    }
}

/// The first bytes of a ZIP archive. Of the formats that octray reads, only 3MF is one.
pub(super) const ZIP: &[u8] = b"PK\x03\x04";

/// The longest name of a file that a mesh names, in bytes: no system has longer ones.
pub(super) const MAX_NAME: usize = 4096;

/// The most triangles of a file that may place a shape many times: 2^22 plus eight for each of its `size` bytes, and at most
/// 2^26. `size` includes the files that it names, and of an archive is not what inflates from it.
#[cfg(any(feature = "gltf", feature = "threemf"))]
pub(super) fn most_triangles(size: usize) -> usize {
    size.saturating_mul(8).saturating_add(1 << 22).min(1 << 26)
}

/// The most cameras that a mesh has, and that a scene takes from its meshes.
pub(super) const MAX_CAMERAS: usize = 1 << 10;

/// The longest name of a camera, in bytes.
pub(super) const MAX_CAMERA_NAME: usize = 64;

#[cfg(feature = "gltf")]
/// The name of a mesh's camera, cut if it is too long.
pub(super) fn camera_name(name: &str) -> String {
    let end = name.floor_char_boundary(MAX_CAMERA_NAME);
    name.get(..end).unwrap_or_default().to_owned()
}

/// Whether bytes begin as a PLY file does; some programs write capitals.
pub(super) fn ply_first(bytes: &[u8]) -> bool {
    matches!(bytes, [p, l, y, b'\n' | b'\r', ..] if [*p, *l, *y].eq_ignore_ascii_case(b"ply"))
}

/// Whether bytes begin as a VTK file does: XML within its first tags, or a legacy file.
pub(super) fn is_vtk(bytes: &[u8]) -> bool {
    /// What legacy files begin with.
    const LEGACY: &[u8] = b"# vtk DataFile";
    let text = bytes
        .strip_prefix(BYTE_ORDER_MARK)
        .unwrap_or(bytes)
        .trim_ascii_start();
    let head = text.get(..1024).unwrap_or(text);
    let start = head.get(..LEGACY.len()).unwrap_or_default();
    start.eq_ignore_ascii_case(LEGACY)
        || head.starts_with(b"<") && head.windows(8).any(|part| part == b"<VTKFile")
}

/// Lists a texture that the file at `path` names.
pub(super) fn add_texture_file(files: &mut Vec<PathBuf>, path: &Path, name: &str) {
    if files.len() < MAX_TEXTURES && name.len() <= MAX_NAME {
        let beside = names::last_of_absolute(name);
        files.extend(
            [Some(name), beside]
                .into_iter()
                .flatten()
                .map(|name| names::joined(path, name)),
        );
    }
}

/// How a surface looks. Colours are display values from 0 to 1, as seen under full light, until
/// [`LoadedMesh::linearize`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Diffuse colour.
    pub diffuse: [f32; 3],
    /// Colour of the highlight, times its strength.
    pub specular: [f32; 3],
    /// Exponent of the highlight.
    pub alpha: u32,
    /// Whether it is shown without light.
    pub is_unlit: bool,
    /// Glass, shown instead of its colours; its tint is a display value, too.
    pub glass: Option<Material>,
    /// Textures, with indices into [`LoadedMesh::images`], and emission, a display value as the other colours.
    pub textures: SurfaceTextures,
}

impl Surface {
    /// A neutral, slightly glossy grey for meshes without materials.
    pub const NEUTRAL: Self = Self {
        diffuse: [0.86, 0.86, 0.84],
        specular: [0.12; 3],
        alpha: 24,
        is_unlit: false,
        glass: None,
        textures: SurfaceTextures::NONE,
    };

    /// White, for meshes with vertex colours and no material, so that the colours are unchanged.
    pub const WHITE: Self = Self {
        diffuse: [1.0; 3],
        specular: [0.06; 3],
        alpha: 24,
        is_unlit: false,
        glass: None,
        textures: SurfaceTextures::NONE,
    };

    /// Unglazed clay, for [`LoadedMesh::paint`].
    pub const CLAY: Self = Self {
        diffuse: [0.82, 0.76, 0.7],
        specular: [0.1; 3],
        alpha: 8,
        is_unlit: false,
        glass: None,
        textures: SurfaceTextures::NONE,
    };

    /// The surface of triangles without a material.
    pub(super) fn without_material(has_colors: bool) -> Self {
        if has_colors { Self::WHITE } else { Self::NEUTRAL }
    }

    /// The surface as Blinn-Phong, as a silhouette if it is unlit, or as glass.
    #[must_use]
    pub fn material(&self) -> Material {
        if let Some(glass) = self.glass {
            return glass;
        }
        if self.is_unlit {
            return Material::Silhouette { color: self.diffuse };
        }
        Material::BlinnPhong {
            diffuse: self.diffuse,
            specular: self.specular,
            k_d: 1.0,
            k_s: 1.0,
            alpha: self.alpha,
        }
    }
}

/// A camera of a mesh file, in the mesh's coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshCamera {
    /// Its name; empty if the file gives it none.
    pub name: String,
    /// Its position.
    pub eye: DVec3,
    /// A point that it looks at.
    pub target: DVec3,
    /// The up vector.
    pub up: DVec3,
    /// Perspective or orthographic.
    pub projection: Projection,
}

impl MeshCamera {
    /// Returns its view of the mesh.
    #[must_use]
    pub fn view(&self) -> View {
        View {
            eye: self.eye,
            target: self.target,
            up: self.up,
            projection: self.projection,
            lens: Lens::PINHOLE,
        }
    }
}

/// The formats of mesh files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// Stanford's polygon format, text or binary.
    Ply,
    /// Wavefront OBJ.
    Obj,
    /// Geomview's object file format, text.
    Off,
    /// Stereolithography, text or binary.
    Stl,
    /// glTF 2.0, as JSON or as one binary file (.glb).
    Gltf,
    /// 3MF, the 3D Manufacturing Format.
    ThreeMf,
    /// `PolyData` and `UnstructuredGrid` of VTK, the Visualization Toolkit.
    Vtk,
}

impl MeshFormat {
    /// The end of an error about any other file.
    pub const EXPECTED: &str =
        "expected a mesh: .ply, .obj, .off, .stl, .gltf, .glb, .3mf, .vtk, .vtp or .vtu";

    /// The format by the file's extension, in either case.
    #[must_use]
    pub fn of_path(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "ply" => Some(Self::Ply),
            "obj" => Some(Self::Obj),
            "off" => Some(Self::Off),
            "stl" => Some(Self::Stl),
            "gltf" | "glb" => Some(Self::Gltf),
            "3mf" => Some(Self::ThreeMf),
            "vtk" | "vtp" | "vtu" => Some(Self::Vtk),
            _ => None,
        }
    }

    /// The name of the format.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Ply => "PLY",
            Self::Obj => "OBJ",
            Self::Off => "OFF",
            Self::Stl => "STL",
            Self::Gltf => "glTF",
            Self::ThreeMf => "3MF",
            Self::Vtk => "VTK",
        }
    }

    /// The format by the file's first bytes if they are unmistakable, else by its extension.
    #[must_use]
    pub fn of(path: &Path, bytes: &[u8]) -> Option<Self> {
        if ply_first(bytes) {
            Some(Self::Ply)
        } else if bytes.starts_with(b"glTF") {
            Some(Self::Gltf)
        } else if bytes.starts_with(ZIP) {
            Some(Self::ThreeMf)
        } else if is_vtk(bytes) {
            Some(Self::Vtk)
        } else {
            Self::of_path(path)
        }
    }
}

impl LoadedMesh {
    /// A warning if the up axis was assumed and the mesh seems to lie on its side. It says what was assumed and which
    /// option of the program turns the mesh. `path` is the file's.
    #[must_use]
    pub fn up_note(&self, path: &Path) -> Option<String> {
        let UpSource::Assumed(format) = self.up_source else {
            return None;
        };
        let (axis, reason) = up::doubt(&self.columns, self.up)?;
        Some(format!(
            "{}: assumed {} is up ({} has no such field), but {reason}; --up-axis {axis} turns it",
            clip_path(path),
            self.up,
            format.name()
        ))
    }
}

/// Clamps the channels of finite colours to 0 to 1 and returns how many colours were outside.
pub(super) fn clamp_colors(colors: &mut [[f32; 3]]) -> usize {
    let clamp = |color: &mut [f32; 3]| {
        let before = *color;
        *color = before.map(|channel| channel.clamp(0.0, 1.0));
        usize::from(*color != before)
    };
    colors.par_iter_mut().with_min_len(1 << 14).map(clamp).sum()
}

/// The note about colours that [`clamp_colors`] has changed.
pub(super) fn clamped_note(clamped: usize, path: &Path) -> Option<String> {
    let colors = counted(clamped, "vertex colour is", "vertex colours are");
    (clamped > 0).then(|| format!("{}: {colors} not from 0 to 1: clamped", clip_path(path)))
}

#[cfg(test)]
mod tests;

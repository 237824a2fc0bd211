//! The numbers of records that are kept, and the names that programs give them.

use super::header::Role;
use serde_ply::PropertyType;

/// How many numbers of a vertex are kept.
pub(super) const SLOTS: usize = 11;
/// The slot of the normal's x; y and z follow.
pub(super) const NORMAL_SLOT: usize = 3;
/// The slot of red; green and blue follow.
pub(super) const COLOR_SLOT: usize = 6;
/// The slot of the first texture coordinate; the second follows.
pub(super) const UV_SLOT: usize = 9;
/// The slot of a number that is shown as a colour; it is not with the others, since it may have more digits.
pub(super) const VALUE_SLOT: usize = usize::MAX;
/// The names of the first slots.
pub(super) const VERTEX_SLOTS: [&str; COLOR_SLOT] = ["x", "y", "z", "nx", "ny", "nz"];
/// Names of the channels of a colour. A file's first complete set is used.
const COLOR_NAMES: [[&str; 3]; 4] = [
    ["red", "green", "blue"],
    ["diffuse_red", "diffuse_green", "diffuse_blue"],
    ["r", "g", "b"],
    SPLAT_COLOR,
];
/// A Gaussian splat's colour without what depends on direction: coefficients of the first spherical harmonic (Kerbl et al.
/// 2023, "3D Gaussian Splatting for Real-Time Radiance Field Rendering").
pub(super) const SPLAT_COLOR: [&str; 3] = ["f_dc_0", "f_dc_1", "f_dc_2"];
/// The value of that spherical harmonic: the square root of 1 / (4 pi).
const FIRST_HARMONIC: f32 = 0.282_094_8;
/// Names of texture coordinates of vertices, likewise.
const UV_NAMES: [[&str; 2]; 4] = [
    ["s", "t"],
    ["u", "v"],
    ["texture_u", "texture_v"],
    ["texture_s", "texture_t"],
];
/// Which properties of an element fill slots.
pub(super) struct SlotNames {
    role: Role,
    has_normals: bool,
    colors: Option<&'static [&'static str; 3]>,
    uvs: Option<&'static [&'static str; 2]>,
}

impl SlotNames {
    pub(super) fn of(definition: &serde_ply::ElementDef, role: Role) -> Self {
        let has = |names: &[&str]| names.iter().all(|name| definition.has_property(name));
        Self {
            role,
            has_normals: has(&VERTEX_SLOTS[3..]),
            colors: complete(definition, &COLOR_NAMES)
                .filter(|&&names| role == Role::Vertex || names != SPLAT_COLOR),
            uvs: complete(definition, &UV_NAMES),
        }
    }

    /// The slot of a property.
    pub(super) fn slot(&self, name: &str) -> Option<usize> {
        let number = |names: Option<&'static [&'static str]>, first: usize| {
            Some(first + names?.iter().position(|known| *known == name)?)
        };
        let color = || number(self.colors.map(|names| &names[..]), COLOR_SLOT);
        let uv = || number(self.uvs.map(|names| &names[..]), UV_SLOT);
        let vertex = number(Some(&VERTEX_SLOTS), 0).filter(|&slot| slot < 3 || self.has_normals);
        match self.role {
            Role::Vertex => vertex.or_else(color).or_else(uv),
            Role::Face => color(),
            Role::Strips | Role::Edge | Role::Other => None,
        }
    }
}

/// Makes colours of the coefficients of Gaussian splats, from 0 to 1 where they are outside.
pub(super) fn splat_colors(coefficients: &mut [[f32; 3]]) {
    for channel in coefficients.iter_mut().flatten() {
        *channel = (0.5 + FIRST_HARMONIC * *channel).clamp(0.0, 1.0);
    }
}

/// The first set of names that each name one number of every record.
fn complete<const N: usize>(
    definition: &serde_ply::ElementDef,
    sets: &'static [[&'static str; N]],
) -> Option<&'static [&'static str; N]> {
    let is_single_number = |name: &&str| {
        let mut named = definition.properties.iter().filter(|p| p.name == **name);
        let first = named.next().map(|property| &property.property_type);
        matches!(first, Some(PropertyType::Scalar(_))) && named.next().is_none()
    };
    sets.iter().find(|names| names.iter().all(is_single_number))
}

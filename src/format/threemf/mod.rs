//! 3MF: a ZIP archive with models as XML, which 3D printing uses.
//!
//! Reads the meshes and components of everything that is built, from several model parts, too, with base materials,
//! colours of corners and textures. A note lists what it does not read.
//!
//! Why not lib3mf: it is C++. The existing crates read no properties, or build a tree of the whole file before its size is
//! known, and report no line and column.
//!
//! Formats: *3MF Core Specification*, *Materials and Properties Extension* and *Production Extension*, 3MF Consortium.

mod build;
mod model;
mod package;
mod properties;

use super::{
    budget::Budget,
    left_out::counted,
    mesh::{LoadedMesh, Surface, UpAxis, UpSource},
    place::TextFault,
    textures::{self, Encoded},
    xml::Xml,
};
use crate::{
    error::{LoadError, clip_path, quote},
    scene::{Image, MAX_TEXTURES},
};
use build::Building;
use package::Package;
use properties::{COLORED, NO_SURFACE};
use std::path::Path;

/// The part that names the others.
const RELATIONSHIPS: &str = "_rels/.rels";

/// How the type of a relationship to the first model ends.
const MODEL_TYPE: &[u8] = b"/3dmodel";

/// Reads a mesh.
///
/// # Errors
/// [`LoadError`]: about a part of the archive, with line and column in it, or about the archive as a whole.
pub(super) fn parse(bytes: &[u8], path: &Path, budget: &Budget) -> Result<LoadedMesh, LoadError> {
    let mut package = Package::new(bytes, path, budget)?;
    let start = start_part(&mut package)?;
    let mut building = Building::new(package);
    building.build(&start)?;
    let unusable = building.unusable.take();
    let mut mesh = finish(building);
    mesh.leave_out_unusable(unusable, path, budget)?;
    Ok(mesh)
}

/// The model part that the archive begins with.
fn start_part(package: &mut Package<'_>) -> Result<String, LoadError> {
    if let Some(part) = package.find(RELATIONSHIPS) {
        let text = package.read(&part)?;
        let named = model_target(&text, package);
        package.budget().give_back(text.capacity());
        let named = named.map_err(|fault| fault.into_error(&text, &package.path_of(&part)))?;
        if let Some(named) = named {
            return Ok(named);
        }
    }
    package.find_ending(".model").ok_or_else(|| {
        let message = "this is a ZIP archive, not a 3MF mesh; unpack it first";
        LoadError::whole_file(package.path(), message)
    })
}

/// The part that relationships name as the first model.
fn model_target(text: &[u8], package: &Package<'_>) -> Result<Option<String>, TextFault> {
    let mut xml = Xml::new(text)?;
    xml.root("Relationships")?;
    while let Some(tag) = xml.child()? {
        if tag
            .find("Type")?
            .is_some_and(|kind| kind.value.ends_with(MODEL_TYPE))
        {
            let target = tag.get("Target")?;
            let part = package.find(&target.text()?);
            let missing = || target.fault(format!("the archive has no part {}", quote(target.value)));
            return part.ok_or_else(missing).map(Some);
        }
        xml.skip()?;
    }
    Ok(None)
}

/// The mesh, with the surfaces that it uses.
fn finish(building: Building<'_>) -> LoadedMesh {
    let Building {
        mut package,
        palette,
        mut columns,
        mut surface_of,
        ..
    } = building;
    let mut surfaces = palette.surfaces;
    let none = if columns.colors.is_empty() {
        NO_SURFACE
    } else {
        COLORED
    };
    if surface_of.iter().all(|&surface| surface == none) {
        surfaces.clear();
        surface_of.clear();
    }
    for (none, surface) in [(NO_SURFACE, Surface::NEUTRAL), (COLORED, Surface::WHITE)] {
        if surface_of.contains(&none) {
            let index = surfaces.len() as u32;
            surfaces.push(surface);
            for surface in surface_of.iter_mut().filter(|surface| **surface == none) {
                *surface = index;
            }
        }
    }
    let mut notes: Vec<String> = palette.left_out.note(package.path()).into_iter().collect();
    let images = images(
        &palette.images,
        &mut surfaces,
        &surface_of,
        &mut package,
        &mut notes,
    );
    if images.is_empty() && package.budget().wants_images() {
        columns.uvs = Vec::new();
    }
    LoadedMesh {
        columns,
        surfaces,
        surface_of,
        images,
        // By the specification.
        up: UpAxis::Z,
        up_source: UpSource::Stated,
        notes,
        ..LoadedMesh::default()
    }
}

/// Reads and decodes the images of the surfaces that triangles have.
fn images(
    parts: &[String],
    surfaces: &mut [Surface],
    surface_of: &[u32],
    package: &mut Package<'_>,
    notes: &mut Vec<String>,
) -> Vec<Image> {
    let budget = package.budget();
    if !budget.wants_images() {
        return Vec::new();
    }
    let used = textures::used_surfaces(surfaces.len(), surface_of);
    let shown = surfaces.iter().zip(used);
    let shown = shown.filter_map(|(surface, is_used)| is_used.then_some(surface));
    let mut used = textures::used_images(parts.len(), shown);
    let beyond = used.iter_mut().filter(|used| **used).skip(MAX_TEXTURES);
    let beyond = beyond.map(|used| *used = false).count();
    if beyond > 0 {
        let images = counted(beyond, "image", "images");
        let path = clip_path(package.path());
        notes.push(format!("{path}: left out: {images} beyond {MAX_TEXTURES}"));
    }
    let mut read = |name: &String| {
        let part = package.find(name);
        let part = part.ok_or_else(|| "the archive has no such part".to_owned())?;
        package.read(&part).map_err(|error| textures::reason(&error))
    };
    let read: Vec<Option<Result<Vec<u8>, String>>> = parts
        .iter()
        .zip(used)
        .map(|(name, is_used)| is_used.then(|| read(name)))
        .collect();
    let encoded = parts.iter().zip(&read).map(|(name, read)| {
        Some(Encoded {
            name: name.clone(),
            bytes: read.as_ref()?.as_deref().map_err(Clone::clone),
            is_normal_map: false,
        })
    });
    let encoded: Vec<Option<Encoded<'_>>> = encoded.collect();
    let images = textures::decode(&encoded, (surfaces, &[]), package.path(), budget, notes).images;
    for bytes in read.iter().flatten().flatten() {
        budget.give_back(bytes.capacity());
    }
    images
}

#[cfg(test)]
mod tests;

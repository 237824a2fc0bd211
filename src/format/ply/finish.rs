//! Makes the mesh with its surfaces, images and notes.

use super::{
    faces::Faces,
    header::Header,
    painted::{Look, Paint},
    slots::splat_colors,
};
#[cfg(feature = "cli")]
use crate::error::LoadError;
use crate::{
    error::clip_path,
    format::{
        OpenMesh,
        budget::{Budget, BudgetError},
        left_out::counted,
        mesh::{
            Cloud, LoadedMesh, MeshFormat, Surface, UpAxis, UpSource, add_texture_file, clamp_colors,
            clamped_note,
        },
        polygon::fans_note,
        textures::{Images, untextured_note},
        vertices::{NONE, Vertices},
    },
    scene::{Image, SurfaceTextures, Texture, TriangleMesh, Wrap},
};
use std::path::Path;

/// Makes the mesh. `open` gives the files of its images.
pub(super) fn finish(
    (mut columns, mut faces): (TriangleMesh, Faces<'_>),
    header: &Header,
    path: &Path,
    open: OpenMesh<'_>,
    budget: &Budget,
) -> Result<LoadedMesh, BudgetError> {
    faces.paint_plain(faces.triangles.len(), header)?;
    faces.paint.forget_looks(budget);
    if header.has_splats() {
        splat_colors(&mut columns.colors);
    }
    let clamped = if header.valued.is_none() {
        clamp_colors(&mut columns.colors)
    } else {
        0
    };
    let mut notes: Vec<String> = clamped_note(clamped, path).into_iter().collect();
    let mut texture_files = Vec::new();
    for name in &header.textures {
        add_texture_file(&mut texture_files, path, name);
    }
    let has_colors = !columns.colors.is_empty();
    let (surfaces, images) = surfaces(&faces, has_colors, header, path, open, &mut notes)?;
    let Faces {
        mut triangles,
        lines,
        fans,
        mut paint,
        values,
        ..
    } = faces;
    if images.is_empty() && budget.wants_images() {
        (columns.uvs, paint.uvs) = (Vec::new(), Vec::new());
    }
    if !paint.uvs.is_empty() {
        split(
            &mut columns,
            &mut triangles,
            std::mem::take(&mut paint.uvs),
            budget,
        )?;
    }
    columns.triangles = triangles;
    let complex = fans.cut_concave(&mut columns, budget)?;
    notes.extend(fans_note(complex, path));
    Ok(LoadedMesh {
        columns,
        surfaces,
        surface_of: paint.look_of,
        images,
        cloud: header.is_cloud().then_some(Cloud { radius: None, lines }),
        up: header.up.unwrap_or(UpAxis::Y),
        up_source: match header.up {
            Some(_) => UpSource::Stated,
            None => UpSource::Assumed(MeshFormat::Ply),
        },
        notes,
        texture_files,
        scalars: values,
        ..LoadedMesh::default()
    })
}

/// Gives each triangle of a mesh a colour, a display value from 0 to 1, as if it were a face of a file. `name` stands for the
/// mesh in notes; the colours may take `memory` bytes.
///
/// # Errors
/// [`LoadError`] if they take more.
#[cfg(feature = "cli")]
pub(crate) fn paint_triangles(
    mesh: &mut LoadedMesh,
    colors: &[[f32; 3]],
    name: &Path,
    memory: u64,
) -> Result<(), LoadError> {
    paint(mesh, colors, name, &Budget::new(memory)).map_err(|error| error.into_error(name))
}

/// As [`paint_triangles`], within a budget.
#[cfg(any(feature = "cli", feature = "vtk"))]
pub(in crate::format) fn paint(
    mesh: &mut LoadedMesh,
    colors: &[[f32; 3]],
    name: &Path,
    budget: &Budget,
) -> Result<(), BudgetError> {
    let paint = Paint::of(colors, budget)?;
    mesh.surfaces = paint
        .looks
        .iter()
        .map(|look| surface(look, None, false))
        .collect();
    mesh.notes.extend(rounded_note(paint.rounded, "there are", name));
    mesh.surface_of = paint.look_of;
    Ok(())
}

/// The surface of each look, and the images that they show. Adds the notes about textures and about everything that is left
/// out.
fn surfaces(
    faces: &Faces<'_>,
    has_colors: bool,
    header: &Header,
    path: &Path,
    open: OpenMesh<'_>,
    notes: &mut Vec<String>,
) -> Result<(Vec<Surface>, Vec<Image>), BudgetError> {
    let (paint, budget) = (&faces.paint, faces.budget);
    let mut left_out = header.left_out(faces.translucent);
    let (mut images, mut numbers) = (Images::default(), Vec::new());
    if header.shows_textures() {
        budget.reserve(&mut numbers, header.textures.len())?;
        for name in &header.textures {
            numbers.push(images.number(path, name, budget)?);
        }
        let unread = numbers.iter().filter(|number| number.is_none()).count();
        left_out.count(unread, "texture", "textures");
    }
    left_out.small_faces(faces.small);
    left_out.odd_normals(faces.odd_normals);
    left_out.count(
        faces.odd_uvs,
        "texture coordinate that is NaN or too large",
        "texture coordinates that are NaN or too large",
    );
    notes.extend(left_out.note(path));
    notes.extend(paint_notes(paint, header, path));
    let mut surfaces = Vec::new();
    budget.reserve(&mut surfaces, paint.looks.len())?;
    for look in &paint.looks {
        let image = look
            .texture
            .and_then(|texture| numbers.get(texture as usize).copied());
        surfaces.push(surface(look, image.flatten(), has_colors));
    }
    let shown = (&mut surfaces[..], &paint.look_of[..]);
    let images = images.read(shown, path, open, budget, notes);
    // Without its image a face looks as it would in a file without textures.
    for (shown, look) in surfaces.iter_mut().zip(&paint.looks) {
        if shown.textures.base.is_none() {
            *shown = surface(look, None, has_colors);
        }
    }
    Ok((surfaces, images))
}

/// How faces with this look are shown.
fn surface(look: &Look, image: Option<u32>, has_colors: bool) -> Surface {
    let plain = match (look.color, image) {
        (Some(color), _) => Surface {
            diffuse: color.map(f32::from_bits),
            ..Surface::WHITE
        },
        (None, Some(_)) => Surface::WHITE,
        (None, None) => Surface::without_material(has_colors),
    };
    Surface {
        textures: SurfaceTextures {
            base: image.map(|image| Texture {
                image,
                wrap: [Wrap::Repeat; 2],
                nearest: false,
            }),
            ..SurfaceTextures::NONE
        },
        ..plain
    }
}

/// The notes about colours and textures of faces.
fn paint_notes(paint: &Paint, header: &Header, path: &Path) -> Vec<String> {
    let mut notes: Vec<String> = untextured_note(paint.untextured, path).into_iter().collect();
    let mut add = |count: usize, one: &str, many: &str, rest: &str| {
        if count > 0 {
            notes.push(format!(
                "{}: {} {rest}",
                clip_path(path),
                counted(count, one, many)
            ));
        }
    };
    let numbers = match header.textures.len() {
        0 | 1 => "0".to_owned(),
        count => format!("from 0 to {}", count - 1),
    };
    add(
        paint.wrong_numbers,
        "face has",
        "faces have",
        &format!("a `texnumber` that is not {numbers}: shown without texture"),
    );
    add(
        paint.clamped,
        "face colour is",
        "face colours are",
        "not from 0 to 1: clamped",
    );
    notes.extend(rounded_note(paint.rounded, "the file has", path));
    notes
}

/// The note about faces whose colours are rounded; `there_are` says where too many are.
fn rounded_note(rounded: usize, there_are: &str, path: &Path) -> Option<String> {
    let faces = counted(rounded, "face has", "faces have");
    let path = clip_path(path);
    (rounded > 0).then(|| format!("{path}: {faces} a rounded colour: {there_are} too many colours"))
}

/// Gives corners their texture coordinates. A vertex whose corners differ becomes several.
fn split(
    mesh: &mut TriangleMesh,
    triangles: &mut [[u32; 3]],
    uvs: Vec<[[u32; 2]; 3]>,
    budget: &Budget,
) -> Result<(), BudgetError> {
    let mut vertices = Vertices::new(mesh.x.len(), budget)?;
    for (corner, uv) in triangles.as_flattened_mut().iter_mut().zip(uvs.as_flattened()) {
        let position = *corner as usize;
        *corner = vertices.vertex(*corner, *uv)?;
        if *corner as usize == mesh.x.len() {
            for column in [&mut mesh.x, &mut mesh.y, &mut mesh.z] {
                add_copy(column, position, budget)?;
            }
            add_copy(&mut mesh.normals, position, budget)?;
            add_copy(&mut mesh.colors, position, budget)?;
        }
    }
    let bytes = uvs.capacity() * size_of_val(&[[0_u32; 2]; 3]);
    drop(uvs);
    budget.give_back(bytes);
    let uvs = vertices.into_attributes();
    budget.reserve(&mut mesh.uvs, uvs.len())?;
    let uv = |bits: Option<[u32; 2]>| bits.filter(|bits| *bits != [NONE; 2]).unwrap_or_default();
    mesh.uvs
        .extend(uvs.into_iter().map(|bits| uv(bits).map(f32::from_bits)));
    Ok(())
}

/// Adds a copy of element `of` to an array, unless it is empty.
fn add_copy<T: Copy>(array: &mut Vec<T>, of: usize, budget: &Budget) -> Result<(), BudgetError> {
    if let Some(&copy) = array.get(of) {
        budget.reserve(array, 1)?;
        array.push(copy);
    }
    Ok(())
}

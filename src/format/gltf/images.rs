//! Images of textures: in a buffer, in a data URI, or in a separate file.

use super::{
    buffers::{Buffers, Bytes, data_of},
    materials::exponent,
};
use crate::{
    error::clip_path,
    format::{
        left_out::counted,
        mesh::Surface,
        textures::{self, Decoded, Encoded, Highlight},
    },
    scene::{Image, MAX_TEXTURES},
};
use gltf::{Document, json::Root};
use std::ops::Range;

/// Where an image's bytes are.
pub(super) enum Source {
    View(usize),
    Uri(String),
}

/// The images of a file, by their index. URIs are moved: one may hold an image.
pub(super) fn sources(root: &mut Root) -> Vec<Source> {
    let source = |image: &mut gltf::json::Image| match (image.uri.take(), image.buffer_view) {
        (Some(uri), _) => Source::Uri(uri),
        (None, Some(view)) => Source::View(view.value()),
        (None, None) => Source::View(usize::MAX),
    };
    root.images.iter_mut().map(source).collect()
}

/// Reads and decodes the images of the surfaces that triangles have (`used`), which name them by their index in the file.
pub(super) fn read(
    sources: &[Source],
    document: &Document,
    buffers: &mut Buffers<'_>,
    (surfaces, used, highlights): (&mut [Surface], &[bool], &[Option<Highlight>]),
    notes: &mut Vec<String>,
) -> Vec<Image> {
    if !buffers.budget().wants_images() {
        return Vec::new();
    }
    let shown = surfaces.iter().zip(used);
    let shown = shown.filter_map(|(surface, &is_used)| is_used.then_some(surface));
    let mut used = textures::used_images(sources.len(), shown);
    let beyond = used.iter_mut().filter(|used| **used).skip(MAX_TEXTURES);
    let beyond = beyond.map(|used| *used = false).count();
    if beyond > 0 {
        let images = counted(beyond, "image", "images");
        notes.push(format!(
            "{}: left out: {images} beyond {MAX_TEXTURES}",
            clip_path(buffers.path())
        ));
    }
    let before = buffers.budget().taken();
    let mut read = Vec::new();
    for (i, (source, is_used)) in sources.iter().zip(used).enumerate() {
        read.push(is_used.then(|| bytes(i, source, document, buffers)));
    }
    let mut encoded = Vec::new();
    for (i, (source, read)) in sources.iter().zip(&read).enumerate() {
        encoded.push(read.as_ref().map(|read| {
            Encoded {
                is_normal_map: true,
                name: match source {
                    Source::Uri(uri) if data_of(uri).is_none() => uri.clone(),
                    _ => format!("images[{i}]"),
                },
                bytes: match read {
                    Ok((bytes, range)) => bytes
                        .get(range.clone())
                        .ok_or_else(|| "its file is cut short".to_owned()),
                    Err(reason) => Err(reason.clone()),
                },
            }
        }));
    }
    let taken = buffers.budget().taken() - before;
    let Decoded {
        images, smoothness, ..
    } = textures::decode(
        &encoded,
        (&mut *surfaces, highlights),
        buffers.path(),
        buffers.budget(),
        notes,
    );
    for surface in surfaces {
        let map = surface.textures.specular_map;
        if let Some(&Some(mean)) = map.and_then(|map| smoothness.get(map.image as usize)) {
            // The highlight is as wide as that of the mean.
            surface.alpha = exponent(1.0 - f32::from(mean) / 255.0);
            // The map has all of its strength: linear light decodes each factor, and not their product.
            surface.specular = [1.0; 3];
        }
    }
    // Buffers stay until the mesh is read; what was read for images alone goes now.
    buffers.budget().give_back(taken as usize);
    images
}

/// The bytes of an image; the error is a sentence.
fn bytes<'a>(
    i: usize,
    source: &Source,
    document: &Document,
    buffers: &mut Buffers<'a>,
) -> Result<(Bytes<'a>, Range<usize>), String> {
    let name = format!("images[{i}]");
    let read = match source {
        Source::Uri(uri) => buffers.uri(&name, uri).map(|bytes| {
            let all = 0..bytes.len();
            (bytes, all)
        }),
        Source::View(view) => match document.views().nth(*view) {
            Some(view) => buffers.view(&view),
            None => return Err("it has neither `uri` nor `bufferView`".to_owned()),
        },
    };
    read.map_err(|error| textures::reason(&error))
}

#[cfg(test)]
mod tests;

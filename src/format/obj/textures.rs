//! Texture coordinates, and the images of the materials that triangles have.

use super::Obj;
use crate::{
    format::{
        OpenMesh, files,
        place::Words,
        textures::{self, Encoded},
    },
    scene::{Image, is_usable},
};
use std::{path::Path, sync::Arc};

impl Obj<'_> {
    /// Texture coordinates with their origin at the upper left corner; the file's is the lower left one. Some programs write
    /// NaN where there is no texture.
    pub(super) fn uv(&mut self, mut words: Words<'_>) -> [f32; 2] {
        let mut number = || {
            let (word, _) = words.next()?;
            fast_float2::parse::<f32, _>(word).ok()
        };
        let [u, v] = [number(), number()].map(Option::unwrap_or_default);
        if is_usable(u) && is_usable(v) {
            [u, 1.0 - v]
        } else {
            self.odd_uvs += 1;
            [0.0, 0.0]
        }
    }

    /// Reads and decodes the images of the surfaces that triangles have.
    pub(super) fn read_images(&mut self, path: &Path, open: OpenMesh<'_>) -> Vec<Image> {
        if !self.budget.wants_images() {
            return Vec::new();
        }
        let used = textures::used_surfaces(self.surfaces.len(), &self.surface_of);
        let surfaces = self.surfaces.iter().zip(used);
        let surfaces = surfaces.filter_map(|(surface, is_used)| is_used.then_some(surface));
        let files = self.images.paths();
        let used = textures::used_images(files.len(), surfaces);
        let read = |(file, is_used): (&Arc<Path>, bool)| {
            is_used.then(|| (open)(file).map_err(|error| textures::reason(&files::load_error(file, &error))))
        };
        let read: Vec<Option<Result<Vec<u8>, String>>> = files.iter().zip(used).map(read).collect();
        let mut encoded = Vec::new();
        for (file, read) in files.iter().zip(&read) {
            encoded.push(read.as_ref().map(|read| Encoded {
                name: file.to_string_lossy().into_owned(),
                bytes: read.as_deref().map_err(Clone::clone),
            }));
        }
        let images = textures::decode(&encoded, &mut self.surfaces, path, self.budget, &mut self.notes);
        for bytes in read.iter().flatten().flatten() {
            self.budget.give_back(bytes.capacity());
        }
        images
    }
}

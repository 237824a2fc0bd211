//! The material libraries that an OBJ file names.

use super::{FIRST_NAME, MOST_LIBRARIES, MOST_LIBRARY_BYTES, MOST_NOTES, NO_SURFACE, Obj, mtl};
use crate::{
    error::{clip, clip_path, in_bytes},
    format::{
        OpenMesh, budget::BudgetError, files, left_out::name_list, mesh::MAX_NAME, reason::Reason,
        textures::names,
    },
    scene::MAX_MATERIALS,
};
use std::path::{Component, Path};

impl Obj<'_> {
    /// Reads the material libraries of a statement `mtllib`: one whose name may have spaces, or else several names.
    pub(super) fn library(&mut self, names: &[u8], path: &Path, open: OpenMesh<'_>) -> Result<(), Reason> {
        if self.notes.len() > MOST_NOTES {
            return Ok(());
        }
        let Some(missing) = self.read_library(names, path, open)? else {
            return Ok(());
        };
        let words = names.split(u8::is_ascii_whitespace);
        let words = words.filter(|name| !name.is_empty() && name.len() < names.len());
        let (before, mut any_read) = (self.notes.len(), false);
        for name in words {
            match self.read_library(name, path, open)? {
                None => any_read = true,
                Some(missing) if self.notes.len() <= before + MOST_NOTES => self.notes.push(missing),
                Some(_) => {}
            }
        }
        if !any_read {
            // One note about the whole name instead of one for each word of it.
            self.notes.truncate(before);
            self.notes.push(missing);
        }
        Ok(())
    }

    /// Reads the library of this name, unless it has been read before; returns a note if it cannot be read.
    fn read_library(
        &mut self,
        name: &[u8],
        path: &Path,
        open: OpenMesh<'_>,
    ) -> Result<Option<String>, Reason> {
        if name.len() > MAX_NAME {
            let path = clip_path(path);
            return Ok(Some(format!(
                "{path}: the name of a material library is longer than {MAX_NAME} bytes; its materials are missing"
            )));
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        let written = String::from_utf8_lossy(name);
        let mut name = folder.join(written.as_ref());
        let is_named = |part: &Component<'_>| *part != Component::CurDir;
        if !self
            .libraries
            .insert(name.components().filter(is_named).collect())
        {
            return Ok(None);
        }
        if self.libraries.len() > MOST_LIBRARIES {
            return Err(Reason::limit(format!(
                "more than {MOST_LIBRARIES} material libraries"
            )));
        }
        let mut read = (open)(&name);
        if read.is_err()
            && let Some(last) = names::last_of_absolute(&written)
            && let Ok(beside) = (open)(&folder.join(last))
        {
            self.notes.push(format!(
                "{}: the material library has an absolute path of another machine (`{}`): taken from beside the mesh",
                clip_path(path),
                clip(&written)
            ));
            (name, read) = (folder.join(last), Ok(beside));
        }
        let bytes = match read {
            Ok(bytes) => bytes,
            Err(error) => {
                let error = files::load_error(&name, &error);
                let error = error.to_string();
                let (what, hint) = error.rsplit_once("; did you mean ").unwrap_or((&error, ""));
                let hint = if hint.is_empty() {
                    String::new()
                } else {
                    format!("; did you mean {hint}")
                };
                return Ok(Some(format!("{what}; its materials are missing{hint}")));
            }
        };
        self.library_bytes = self.library_bytes.saturating_add(bytes.len());
        if self.library_bytes > MOST_LIBRARY_BYTES {
            let most = in_bytes(MOST_LIBRARY_BYTES as u64);
            return Err(Reason::limit(format!(
                "the material libraries have more than {most}"
            )));
        }
        self.add_library(&bytes, &name)?;
        let capacity = bytes.capacity();
        drop(bytes);
        self.budget.give_back(capacity);
        Ok(None)
    }

    /// The number of a name that no library has yet.
    pub(super) fn missing(&mut self, name: &[u8]) -> Result<u32, BudgetError> {
        // Also of the lists that are made of all names.
        self.budget.take(name.len() + 2 * mtl::NAME_BYTES)?;
        let number = FIRST_NAME + self.missing_materials.len() as u32;
        self.missing_materials.insert(name.to_vec(), number);
        Ok(number)
    }

    /// Gives triangles the surfaces of libraries that came after the names in them. Notes the names that no library has.
    pub(super) fn find_late_materials(&mut self, path: &Path) {
        if self.missing_materials.is_empty() {
            return;
        }
        let mut names: Vec<(&u32, &Vec<u8>)> = self
            .missing_materials
            .iter()
            .map(|(name, number)| (number, name))
            .collect();
        names.sort_unstable();
        let surfaces = names
            .iter()
            .map(|(_, name)| self.surface_by_name.get(*name).copied());
        let surfaces: Vec<Option<u32>> = surfaces.collect();
        for surface in self
            .surface_of
            .iter_mut()
            .filter(|surface| **surface >= FIRST_NAME)
        {
            let found = surfaces.get((*surface - FIRST_NAME) as usize);
            *surface = found.copied().flatten().unwrap_or(NO_SURFACE);
        }
        let missing = names.iter().zip(&surfaces).filter(|(_, found)| found.is_none());
        let missing = name_list(missing.map(|((_, name), _)| name.as_slice()));
        // A library that could not be read has a note already.
        if !self.surfaces.is_empty() && !missing.is_empty() {
            let path = clip_path(path);
            self.notes.push(format!(
                "{path}: no material library has {missing}: shown in grey"
            ));
        }
    }

    /// Adds the materials of a library.
    fn add_library(&mut self, text: &[u8], path: &Path) -> Result<(), Reason> {
        let most = MAX_MATERIALS - self.surfaces.len();
        let files = (&mut self.texture_files, &mut self.images);
        let materials = mtl::parse(text, path, &mut self.notes, files, self.budget, most)?;
        if !self.images.is_empty() && !std::mem::replace(&mut self.keeps_uvs, true) {
            self.uvs_are_late = self.texture_coordinates > 0 || !self.corners.is_empty();
        }
        self.budget.reserve(&mut self.surfaces, materials.len())?;
        let reserved = self.surface_by_name.try_reserve(materials.len());
        reserved.map_err(|_| BudgetError::NoMemory)?;
        for (name, surface, shift) in materials {
            self.add_shift(shift)?;
            self.surface_by_name.insert(name, self.surfaces.len() as u32);
            self.surfaces.push(surface);
        }
        Ok(())
    }
}

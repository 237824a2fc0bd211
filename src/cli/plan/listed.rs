//! The pictures that `--save-poses` lists: all of a series, also those that other calls render or that exist.

use super::{Pictures, Turn, Turntable, aov_path, names};
use crate::cli::{CliError, write::AovKind};
use std::path::{Path, PathBuf};

/// A picture of the file of poses.
#[derive(Debug)]
pub struct ListedPicture {
    pub turn: Option<Turn>,
    pub path: PathBuf,
    /// The separate files of its AOVs.
    aovs: Vec<(AovKind, PathBuf)>,
}

impl ListedPicture {
    /// The separate file of an AOV.
    pub fn aov(&self, which: AovKind) -> Option<&Path> {
        let found = self.aovs.iter().find(|(kind, _)| *kind == which);
        found.map(|(_, path)| &**path)
    }

    /// All files of the picture.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        let aovs = self.aovs.iter().map(|(_, path)| &**path);
        [&*self.path].into_iter().chain(aovs)
    }
}

impl Pictures<'_> {
    /// All pictures of a scene's series; none if no file lists them.
    ///
    /// # Errors
    /// [`CliError::Usage`], never without a range of frames.
    pub(super) fn listed(
        &self,
        scene: &Path,
        series: Option<Turntable>,
    ) -> Result<Vec<ListedPicture>, CliError> {
        if !self.saves_poses {
            return Ok(Vec::new());
        }
        let whole = series.map(|series| Turntable {
            frames: None,
            ..series
        });
        let turns = self.turns(scene, whole)?;
        Ok(turns
            .into_iter()
            .map(|turn| self.listed_picture(scene, turn))
            .collect())
    }

    fn listed_picture(&self, scene: &Path, turn: Option<Turn>) -> ListedPicture {
        let path = names::picture(self.output, scene, turn, self.pose(turn)).path;
        let is_exr = path
            .extension()
            .is_some_and(|extension| extension.eq_ignore_ascii_case("exr"));
        let kinds = self.look.picture.aovs.iter().filter(|_| !is_exr);
        let aovs = kinds.filter_map(|&kind| Some((kind, aov_path(&path, kind.name())?.path)));
        ListedPicture {
            turn,
            aovs: aovs.collect(),
            path,
        }
    }
}

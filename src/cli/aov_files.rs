//! Where the variables of `--aov` go.

use super::{
    CliError,
    aov::{self, AovArg, AovReport, DepthRange},
    interrupt::Interrupt,
    output::Output,
    picture::{Picture, Pixels},
    picture_args::PictureArgs,
};
use crate::{
    render::{Aovs, OnProgress, RenderError, Renderer, Settings, Transfer},
    scene::{Camera, Scene},
};
use std::path::{Path, PathBuf};

/// The variables that were asked for, and their files: checked before anything is rendered.
#[derive(Debug)]
pub struct AovFiles {
    asked: Vec<AovArg>,
    /// A file for each; none where the picture's own file holds them all.
    files: Vec<Output>,
    /// How albedo becomes bytes.
    transfer: Transfer,
}

/// The variables of a picture, and how depth is shown.
pub struct RenderedAovs {
    aovs: Aovs,
    range: DepthRange,
}

impl AovFiles {
    /// Checks the places beside `output`, which is at `path`, for pictures of that size.
    ///
    /// # Errors
    /// [`CliError::Usage`], where the output has no name to derive others from; else as [`Output::prepare`].
    pub fn prepare(
        args: &PictureArgs,
        output: &Output,
        path: &Path,
        scene: &Path,
        [width, height]: [u32; 2],
    ) -> Result<Self, CliError> {
        let mut asked = args.aovs.clone();
        asked.sort_unstable();
        asked.dedup();
        let mut files = Vec::new();
        if !output.has_layers() {
            for which in &asked {
                files.push(Output::prepare(&beside(path, *which)?, scene, width, height)?);
            }
        }
        Ok(Self {
            asked,
            files,
            transfer: args.transfer(),
        })
    }

    /// The files beside the picture.
    pub fn files(&self) -> &[Output] {
        &self.files
    }

    /// Finds the variables, if any were asked for.
    ///
    /// # Errors
    /// As [`Renderer::aovs`].
    pub fn render(
        &self,
        renderer: &mut Renderer<'_>,
        scene: &Scene,
        camera: &Camera,
        settings: &Settings,
        on_progress: OnProgress<'_>,
    ) -> Result<Option<RenderedAovs>, RenderError> {
        if self.asked.is_empty() {
            return Ok(None);
        }
        let costs = self.asked.contains(&AovArg::Heat);
        let aovs = renderer.aovs(camera, settings, costs, on_progress)?;
        let range = DepthRange::new(scene.bounds(), camera.eye());
        Ok(Some(RenderedAovs { aovs, range }))
    }

    /// Writes the variables to their files, or gives them to the picture.
    ///
    /// # Errors
    /// As [`Output::write`].
    pub fn write(
        &self,
        RenderedAovs { aovs, range }: &RenderedAovs,
        picture: &mut Picture,
        interrupt: &Interrupt,
    ) -> Result<(), CliError> {
        if self.files.is_empty() {
            let channels = self.asked.iter().flat_map(|&which| aov::channels(aovs, which));
            picture.layers.extend(channels);
        }
        for (file, &which) in self.files.iter().zip(&self.asked) {
            let own = Picture::from(Pixels::Bytes(aov::picture(aovs, which, *range, self.transfer)));
            file.write(&own, interrupt)?;
        }
        Ok(())
    }

    /// What `--stats` says of them.
    pub fn report(&self, rendered: &RenderedAovs) -> Option<AovReport> {
        AovReport::new(&rendered.aovs, &self.asked, rendered.range)
    }
}

/// `a.depth.png` for `a.png`.
fn beside(path: &Path, which: AovArg) -> Result<PathBuf, CliError> {
    let (Some(stem), Some(extension)) = (path.file_stem(), path.extension()) else {
        return Err(CliError::Usage(format!(
            "--aov names its files after the picture's, which {} does not allow: expected a file such as -o a.png",
            path.display()
        )));
    };
    let mut name = stem.to_owned();
    for part in [".".as_ref(), which.name().as_ref(), ".".as_ref(), extension] {
        name.push(part);
    }
    Ok(path.with_file_name(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_named_after_the_picture() {
        let named = |path: &str| beside(Path::new(path), AovArg::Heat).map_err(|error| error.text());
        assert_eq!(named("b/a.png"), Ok("b/a.heat.png".into()));
        assert_eq!(named("a.b.tiff"), Ok("a.b.heat.tiff".into()));
        for path in ["-", "/dev/null"] {
            let text = named(path).unwrap_err().unwrap_or_default();
            assert!(text.contains("-o a.png"), "{text}");
        }
    }
}

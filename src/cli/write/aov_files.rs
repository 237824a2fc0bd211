//! The files of `--aov`.

use super::{
    aov::{self, AovKind, Axis, DepthRange, Z_STEP},
    encode::Format,
    output::Output,
    picture::{Picture, Pixels},
    place::Shows,
};
use crate::{
    cli::{
        CliError,
        plan::{PictureOptions, PicturePath, aov_path},
        report::AovReport,
    },
    error::clip_path,
    render::{Aovs, OnProgress, RenderError, Renderer, Settings},
    scene::{Camera, Scene},
};

/// The requested AOVs and their checked files.
#[derive(Debug)]
pub struct AovFiles {
    asked: Vec<AovKind>,
    /// A file for each AOV; none if the picture's own file holds them all.
    files: Vec<Output>,
    /// Units of a step of depth.
    z_step: f64,
}

/// The AOVs of a picture, and how depth is shown.
pub struct RenderedAovs {
    aovs: Aovs,
    range: DepthRange,
    axis: Axis,
}

impl AovFiles {
    /// Checks the files beside `output`, which is at `path`.
    ///
    /// # Errors
    /// [`CliError::Usage`] if the output has no name to derive others from; else as [`Output::prepare`].
    pub fn prepare(
        options: &PictureOptions,
        output: &Output,
        path: &PicturePath,
        size: (u32, u32),
        force: bool,
    ) -> Result<Self, CliError> {
        let mut asked = options.aovs.clone();
        asked.sort_unstable();
        asked.dedup();
        let mut files = Vec::new();
        if !output.is_exr() {
            if let Some(which) = asked.iter().find(|which| which.is_exact())
                && output.format() != Format::Png
            {
                return Err(CliError::Usage(format!(
                    "--aov {}: {} does not hold its numbers; name a picture such as .png or .exr",
                    which.name(),
                    output.format().name()
                )));
            }
            for which in &asked {
                let file = aov_path(&path.path, which.name()).ok_or_else(|| {
                    CliError::Usage(format!(
                        "--aov derives its file names from the picture's, and {} has none: use a file such as -o a.png",
                        clip_path(&path.path)
                    ))
                })?;
                files.push(Output::prepare(&file, size, force)?.synced_if(output.is_synced()));
            }
        }
        Ok(Self {
            asked,
            files,
            z_step: options.z_step,
        })
    }

    /// No AOVs.
    pub fn none() -> Self {
        Self {
            asked: Vec::new(),
            files: Vec::new(),
            z_step: Z_STEP,
        }
    }

    /// The files beside the picture.
    pub fn files(&self) -> &[Output] {
        &self.files
    }

    /// The separate file of an AOV.
    pub fn file(&self, which: AovKind) -> Option<&Output> {
        let at = self.in_files().position(|kind| kind == which)?;
        self.files.get(at)
    }

    /// The AOVs that have separate files.
    pub fn in_files(&self) -> impl Iterator<Item = AovKind> {
        self.asked.iter().copied().take(self.files.len())
    }

    /// Renders the requested AOVs.
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
        let costs = self.asked.contains(&AovKind::Heat);
        let aovs = renderer.aovs(camera, settings, costs, on_progress)?;
        let range = DepthRange::of(scene, camera);
        let axis = Axis::of(scene, camera, settings);
        Ok(Some(RenderedAovs { aovs, range, axis }))
    }

    /// Writes the AOVs to their files, or adds them to an EXR picture. Albedo becomes bytes as the picture's colours do.
    ///
    /// # Errors
    /// As [`Output::write`].
    pub fn write(
        &self,
        RenderedAovs { aovs, range, axis }: &RenderedAovs,
        picture: &mut Picture,
    ) -> Result<(), CliError> {
        if self.files.is_empty() {
            let channels = self
                .asked
                .iter()
                .flat_map(|&which| aov::channels(aovs, which, *axis));
            picture.layers.extend(channels);
        }
        for (file, &which) in self.files.iter().zip(&self.asked) {
            let mut own = Picture::from(if which.is_exact() {
                aov::exact(aovs, which, *axis, self.z_step)
            } else {
                Pixels::Bytes(aov::picture(aovs, which, *range, picture.transfer))
            });
            let shows = match which {
                AovKind::Albedo => Shows::Albedo(picture.transfer),
                AovKind::Z => Shows::Z(self.z_step),
                which => Shows::Aov(which),
            };
            own.place = picture.place.map(|place| place.showing(shows));
            file.write(&mut own)?;
        }
        Ok(())
    }

    /// A warning if the file of depth does not reach to all that the picture shows.
    pub fn warning(&self, RenderedAovs { aovs, axis, .. }: &RenderedAovs) -> Option<String> {
        let file = self.file(AovKind::Z)?;
        let count = aov::beyond_z(aovs, *axis, self.z_step);
        (count > 0).then(|| {
            format!(
                "{count} pixels of {} are farther than {} units and have depth 0: use a larger --z-step, or an .exr",
                file.name(),
                aov::farthest_z(self.z_step)
            )
        })
    }

    /// Their part of `--stats`.
    pub fn report(&self, rendered: &RenderedAovs) -> Option<AovReport> {
        AovReport::new(&rendered.aovs, &self.asked, rendered.range)
    }
}

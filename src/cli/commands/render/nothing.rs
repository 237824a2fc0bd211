//! Pictures that show nothing of a mesh: its camera looks elsewhere, or an outlier makes it smaller than a pixel.
//!
//! Scenes are not checked: their cameras may show the background on purpose.

use super::{Call, Loaded, written_name};
use crate::{
    cli::{plan::Frame, report},
    error::clip_path,
    ray::PrimitiveId,
    render::{Crop, FrameStats, RenderError, Renderer, Settings},
    scene::Camera,
};
use std::ops::ControlFlow;

/// How many pixels are checked at a time.
const PIXELS: u32 = 1 << 20;

impl Call<'_> {
    /// Warns if a picture of a mesh shows nothing, once for all pictures of the mesh.
    pub fn warn_of_nothing(
        &mut self,
        loaded: &Loaded<'_>,
        (renderer, camera): (&mut Renderer<'_>, &Camera),
        frame: &Frame,
        stats: &FrameStats,
    ) {
        let settings = &loaded.look.settings;
        // Some crops of any picture show nothing.
        if self.plan.quiet
            || self.warned_of_nothing
            || settings.crop.is_some()
            || stats.rays.total() > stats.rays.camera
        {
            return;
        }
        if matches!(shows_nothing(renderer, camera, settings), Ok(true)) {
            self.warned_of_nothing = true;
            let backs = if loaded.scene.has_one_sided() {
                ", unless from behind: its faces are one-sided"
            } else {
                ""
            };
            report::warnings([format!(
                "{} shows nothing: no camera ray hits {}{backs}",
                written_name(&frame.output),
                clip_path(loaded.path)
            )]);
        }
    }
}

/// Whether no ray through the centre of a pixel hits anything. Ends with the first rows in which one does.
fn shows_nothing(
    renderer: &mut Renderer<'_>,
    camera: &Camera,
    settings: &Settings,
) -> Result<bool, RenderError> {
    let Settings { width, height, .. } = *settings;
    let rows = (PIXELS / width.max(1)).max(1);
    for y0 in (0..height).step_by(rows as usize) {
        let crop = Crop {
            x0: 0,
            y0,
            x1: width,
            y1: height.min(y0.saturating_add(rows)),
        };
        let part = Settings {
            crop: Some(crop),
            ..*settings
        };
        let aovs = renderer.aovs(camera, &part, false, &|_| ControlFlow::Continue(()))?;
        if aovs.pixels.iter().any(|aov| aov.primitive != PrimitiveId::NONE) {
            return Ok(false);
        }
    }
    Ok(true)
}

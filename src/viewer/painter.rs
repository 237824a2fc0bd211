//! Traces the pictures of the window.

use super::{
    denoise::Denoiser,
    primary,
    request::{Look, Request, Style},
    timeline::Model,
};
use crate::render::{ByteFilm, Film, FrameStats, OnProgress, RenderError, Renderer, Transfer};
use rayon::prelude::*;

/// Pixels of a thread's piece of work.
const CHUNK: usize = 1 << 13;

/// Traces pictures of one scene, and keeps the memory for the next one.
#[derive(Debug)]
pub struct Painter<'a> {
    model: &'a Model,
    renderer: Renderer<'a>,
    /// The last picture.
    pub film: ByteFilm,
    /// The same before it was encoded.
    linear: Film,
    denoiser: Denoiser,
}

impl<'a> Painter<'a> {
    /// Makes a painter of a scene.
    #[must_use]
    pub fn new(model: &'a Model) -> Self {
        Self {
            model,
            renderer: Renderer::new(&model.scene, &model.bvh),
            film: ByteFilm::black(0, 0),
            linear: Film::new(0, 0),
            denoiser: Denoiser::default(),
        }
    }

    /// Traces a picture of `size` pixels with a number of samples each: the bytes of `octray render`.
    ///
    /// # Errors
    /// [`RenderError`].
    pub fn trace(
        &mut self,
        request: &Request,
        size: [u32; 2],
        samples: u32,
        on_progress: OnProgress<'_>,
    ) -> Result<FrameStats, RenderError> {
        let (camera, style) = (&request.seen_from(), &request.style);
        let settings = style.settings(size, samples);
        if !is_rendered(style) {
            settings.validate()?;
            self.film.resize(size[0], size[1]);
            return primary::render(self.model, camera, style, &settings, &mut self.film, on_progress);
        }
        if style.transfer == Transfer::Linear {
            return self
                .renderer
                .render(camera, &settings, &mut self.film, on_progress);
        }
        let stats = self
            .renderer
            .render(camera, &settings, &mut self.linear, on_progress)?;
        self.encode(style.transfer);
        Ok(stats)
    }

    /// Traces and denoises a picture of few samples. Soft light and ambient occlusion have the brightness of many samples.
    ///
    /// # Errors
    /// [`RenderError`].
    pub fn trace_denoised(
        &mut self,
        request: &Request,
        size: [u32; 2],
        samples: u32,
        on_progress: OnProgress<'_>,
    ) -> Result<FrameStats, RenderError> {
        if !self.denoises(request) {
            return self.trace(request, size, samples, on_progress);
        }
        let Request { camera, style, .. } = request;
        let settings = style.settings(size, samples);
        let stats = self
            .renderer
            .render(camera, &settings, &mut self.linear, on_progress)?;
        self.denoiser.run(self.model, camera, &settings, &mut self.linear);
        self.encode(style.transfer);
        Ok(stats)
    }

    /// Whether pictures of few samples are denoised. Not with a lens, since pixels out of focus show several surfaces.
    #[must_use]
    pub fn denoises(&self, request: &Request) -> bool {
        is_rendered(&request.style) && self.model.scene.is_sampled() && !request.has_lens()
    }

    fn encode(&mut self, transfer: Transfer) {
        self.film.resize(self.linear.width(), self.linear.height());
        let bytes = self.film.pixels_mut().par_chunks_mut(CHUNK);
        bytes
            .zip(self.linear.pixels().par_chunks(CHUNK))
            .for_each(|(bytes, linear)| {
                for (to, &rgb) in bytes.iter_mut().zip(linear) {
                    *to = transfer.encode(rgb);
                }
            });
    }
}

/// Whether the renderer makes the picture.
fn is_rendered(style: &Style) -> bool {
    style.look == Look::Full && !style.brute
}

#[cfg(test)]
mod tests;

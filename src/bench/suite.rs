//! The benchmark scenes: typical kinds, generated from a seed, so that nothing must be shipped.

use crate::{
    generate::{GenerateError, Kind, Options, View, generate},
    scene::{Camera, CameraError, Scene},
};
use std::fmt;

/// The description of a benchmark scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SuiteScene {
    /// The name in results.
    pub name: &'static str,
    /// The kind to generate.
    pub kind: Kind,
    /// Number of spheres, or the most triangles.
    pub count: usize,
    /// Distance of the eye from its target, relative to the kind's own view.
    pub distance: f64,
}

/// A scene of the suite could not be made; possible only with a count out of range.
#[derive(Debug)]
pub enum SuiteError {
    /// See [`GenerateError`].
    Generate(GenerateError),
    /// See [`CameraError`].
    Camera(CameraError),
    /// The primitives are not valid; the text says why.
    Scene(String),
}

impl fmt::Display for SuiteError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Generate(error) => error.fmt(f),
            Self::Camera(error) => error.fmt(f),
            Self::Scene(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for SuiteError {}

/// Returns the suite: few triangles that fill little of the picture, a figure as dense as a scan, an interior, a height
/// field of about one triangle per pixel, triangles far smaller than pixels, and spheres.
#[must_use]
pub fn suite() -> [SuiteScene; 6] {
    [
        scene("figurine", Kind::Figure, 6_000, 2.0),
        scene("figure", Kind::Figure, 70_000, 1.0),
        scene("interior", Kind::Interior, 370_000, 1.0),
        scene("terrain", Kind::Terrain, 1_000_000, 1.0),
        scene("blobs", Kind::Blobs, 10_000_000, 1.0),
        scene("spheres", Kind::Spheres, 100_000, 1.0),
    ]
}

/// Returns the same kinds in small sizes.
#[must_use]
pub fn quick_suite() -> [SuiteScene; 6] {
    [
        scene("figurine", Kind::Figure, 6_000, 2.0),
        scene("figure", Kind::Figure, 20_000, 1.0),
        scene("interior", Kind::Interior, 60_000, 1.0),
        scene("terrain", Kind::Terrain, 100_000, 1.0),
        scene("blobs", Kind::Blobs, 300_000, 1.0),
        scene("spheres", Kind::Spheres, 20_000, 1.0),
    ]
}

fn scene(name: &'static str, kind: Kind, count: usize, distance: f64) -> SuiteScene {
    SuiteScene {
        name,
        kind,
        count,
        distance,
    }
}

impl SuiteScene {
    /// Makes the scene and its camera.
    ///
    /// # Errors
    /// [`SuiteError`]; never for the scenes of [`suite`] and [`quick_suite`].
    pub fn make(&self) -> Result<(Scene, Camera), SuiteError> {
        let options = Options {
            seed: 0,
            count: Some(self.count),
        };
        let generated = generate(self.kind, options).map_err(SuiteError::Generate)?;
        let View { eye, target, .. } = generated.view;
        let view = View {
            eye: target + (eye - target) * self.distance,
            ..generated.view
        };
        let camera = view.camera().map_err(SuiteError::Camera)?;
        let scene = generated
            .into_scene()
            .map_err(|error| SuiteError::Scene(error.to_string()))?;
        Ok((scene, camera))
    }
}

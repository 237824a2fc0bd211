//! Gathers the light at all points of a tile: ambient light, each light in turn, and the environment.

use super::{
    ShadeSettings, Shader,
    draw::Draws,
    environment::Part,
    material::{self, IncidentLight, Light8},
    shadow::{self, Source},
    soft,
};
use crate::{
    lanes::{F32x8, LANES},
    scene::Scene,
    simd::{Level, at_level},
    trace::Tracer,
};

impl Shader {
    /// Sums up the light at each lit surface.
    pub(super) fn add_lights(
        &mut self,
        scene: &Scene,
        tracer: &mut Tracer<'_>,
        settings: ShadeSettings<'_>,
        depth: u32,
    ) {
        let lights = scene.lights();
        if lights.is_empty() && scene.environment().is_none() {
            self.light.clear();
        }
        // The first light overwrites the previous contents.
        self.light.resize(self.found.surfaces.len(), Light8::NONE);
        let lit = self
            .found
            .by_material
            .lit_surfaces(scene, &self.found.surfaces)
            .len();
        self.occlude_ambient(scene, tracer, settings, (depth, lit));
        self.map_ambient(scene, lit);
        let sources = lights.iter().map(Source::Light);
        let parts = [Part::Rest, Part::Suns]
            .into_iter()
            .take(scene.environment_rays());
        let environment = scene.environment().into_iter();
        let sources =
            sources
                .chain(environment.flat_map(|environment| {
                    parts.clone().map(|part| Source::Environment(environment, part))
                }));
        for (source_i, source) in sources.enumerate() {
            // The first pair is for ambient light.
            let draws = draws(&self.first_points, scene, settings, (depth, 1 + source_i));
            let power = match source {
                Source::Light(light) => light.power(),
                Source::Environment(..) => [1.0; 3],
            };
            let (rays, time) = shadow::pass(
                (source, power),
                (draws, settings.shadows),
                (scene, &mut *tracer),
                (&self.found.surfaces[..lit], &self.media),
                &mut self.arriving,
                &mut self.shadow,
            );
            self.shadow_rays += rays;
            self.tracing += time;
            if matches!(source, Source::Environment(..)) && scene.has_textures() {
                let occlusion = &self.found.textured.occlusion;
                for (power, share) in self.arriving.power.iter_mut().zip(occlusion) {
                    for channel in power {
                        multiply(channel, share);
                    }
                }
            }
            self.sum_up(scene, tracer.level(), lit, power, source_i == 0);
        }
    }

    /// Finds the ambient light at each lit surface if anything can block it.
    fn occlude_ambient(
        &mut self,
        scene: &Scene,
        tracer: &mut Tracer<'_>,
        settings: ShadeSettings<'_>,
        (depth, lit): (u32, usize),
    ) {
        self.ambient.clear();
        let Some(reach) = scene.ambient_reach().filter(|_| settings.shadows) else {
            return;
        };
        let (rays, time) = soft::ambient_pass(
            (scene.ambient(), reach),
            draws(&self.first_points, scene, settings, (depth, 0)),
            tracer,
            &self.found.surfaces[..lit],
            &mut self.ambient,
            &mut self.shadow,
        );
        self.ambient_rays += rays;
        self.tracing += time;
    }

    /// Multiplies the ambient light by occlusion maps.
    fn map_ambient(&mut self, scene: &Scene, lit: usize) {
        let occlusion = &self.found.textured.occlusion;
        if scene.has_textures() && !occlusion.is_empty() {
            self.ambient.resize(lit, F32x8::splat(scene.ambient()));
            for (ambient, share) in self.ambient.iter_mut().zip(occlusion) {
                multiply(ambient, share);
            }
        }
    }

    /// Adds the light that arrives to the sums of all lit surfaces.
    fn sum_up(&mut self, scene: &Scene, level: Level, lit: usize, power: [f32; 3], is_first: bool) {
        for (material, range) in self.found.by_material.ranges().take_while(|(_, r)| r.end <= lit) {
            let incident = IncidentLight {
                power,
                powers: self.arriving.power.get(range.clone()).unwrap_or_default(),
                n_dot_l: &self.arriving.n_dot_l[range.clone()],
                to_light: &self.arriving.to_light[range.clone()],
            };
            let material = &scene.materials()[material.0 as usize];
            let surfaces = &self.found.surfaces[range.clone()];
            let light = &mut self.light[range];
            at_level!(level, |simd| material::add_light(
                simd, material, incident, surfaces, light, is_first
            ));
        }
    }
}

fn multiply(values: &mut F32x8, by: &F32x8) {
    for (value, by) in values.as_mut_array().iter_mut().zip(by.as_array()) {
        *value *= by;
    }
}

/// The random points of two sample dimensions at a depth.
fn draws<'a>(
    first: &'a [[u32; LANES]],
    scene: &Scene,
    settings: ShadeSettings<'_>,
    (depth, pair): (u32, usize),
) -> Draws<'a> {
    Draws {
        first,
        sample: settings.sample,
        pair: (depth as usize * scene.draws_per_depth() + pair) as u32,
    }
}

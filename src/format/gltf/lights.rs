//! Point, spot and directional lights: the extension `KHR_lights_punctual`, The Khronos Group, 2018.
//!
//! The gltf crate would reject a whole file for a fault in its lights, so they are parsed separately.

use crate::scene::{Light, LightShape, MAX_LIGHTS, Spot, is_usable};
use glam::DMat4;
use gltf::json;
use serde::{Deserialize, de::IgnoredAny};

const EXTENSION: &str = "KHR_lights_punctual";

/// The lights of a file, and the nodes that place them.
#[derive(Default)]
pub(super) struct PunctualLights {
    lights: Vec<Lenient<Punctual>>,
    /// By node: an index into `lights`.
    of_node: Vec<Option<usize>>,
    /// How many lights cannot be read.
    pub left_out: usize,
}

#[derive(Deserialize)]
#[serde(default)]
struct Punctual {
    #[serde(rename = "type")]
    kind: String,
    color: [f32; 3],
    /// Candela, or lux of directional lights.
    intensity: f32,
    spot: Cone,
}

impl Default for Punctual {
    fn default() -> Self {
        Self {
            kind: String::new(),
            color: [1.0; 3],
            intensity: 1.0,
            spot: Cone::default(),
        }
    }
}

/// Half angles, radians.
#[derive(Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct Cone {
    inner_cone_angle: f32,
    outer_cone_angle: f32,
}

impl Default for Cone {
    fn default() -> Self {
        Self {
            inner_cone_angle: 0.0,
            outer_cone_angle: std::f32::consts::FRAC_PI_4,
        }
    }
}

/// A faulty light does not affect the others.
#[derive(Deserialize)]
#[serde(untagged)]
enum Lenient<T> {
    Read(T),
    Odd(IgnoredAny),
}

/// The parts of the JSON that matter here.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Lit {
    extensions: Extensions<Lights>,
    nodes: Vec<Lenient<LitNode>>,
}

#[derive(Default, Deserialize)]
#[serde(default, bound(deserialize = "T: Default + Deserialize<'de>"))]
struct Extensions<T> {
    #[serde(rename = "KHR_lights_punctual")]
    punctual: T,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct Lights {
    lights: Vec<Lenient<Punctual>>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct LitNode {
    extensions: Extensions<Placed>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct Placed {
    light: Option<usize>,
}

impl PunctualLights {
    /// Reads the JSON once more, but only if the file uses the extension.
    pub fn of(text: &[u8]) -> Self {
        // Some exporters forget `extensionsUsed`.
        if !super::has(text, EXTENSION) {
            return Self::default();
        }
        let Ok(Lit { extensions, nodes }) = json::deserialize::from_slice::<Lit>(text) else {
            return Self::default();
        };
        let of_node = nodes.into_iter().map(|node| match node {
            Lenient::Read(node) => node.extensions.punctual.light,
            Lenient::Odd(_) => None,
        });
        Self {
            lights: extensions.punctual.lights,
            of_node: of_node.collect(),
            left_out: 0,
        }
    }

    /// Whether a node places a light.
    pub fn is_at(&self, node: usize) -> bool {
        matches!(self.of_node.get(node), Some(Some(_)))
    }

    /// Adds the light of a node to `lights`, in the mesh's coordinates.
    pub fn place(&mut self, node: usize, world: &DMat4, lights: &mut Vec<Light>) {
        let Some(&Some(index)) = self.of_node.get(node) else {
            return;
        };
        let light = self.lights.get(index).and_then(|light| match light {
            Lenient::Read(punctual) => punctual.at(world),
            Lenient::Odd(_) => None,
        });
        match light.filter(|_| lights.len() < MAX_LIGHTS) {
            Some(light) => lights.push(light),
            None => self.left_out += 1,
        }
    }
}

impl Punctual {
    /// The light in the place and direction of a node; `None` if it is not one.
    fn at(&self, world: &DMat4) -> Option<Light> {
        let position = world.w_axis.truncate().as_vec3();
        // Lights shine along -z.
        let to_light = world.z_axis.truncate();
        let is_valid = self.intensity >= 0.0 && position.to_array().into_iter().all(is_usable);
        let shape = match &self.kind[..] {
            "directional" => LightShape::directional(to_light, 0.0).ok()?,
            "point" | "spot" => LightShape::Point { position },
            _ => return None,
        };
        let mut light = Light::new(shape);
        light.intensity = self.intensity;
        light.color = self.color.map(|channel| channel.clamp(0.0, 1.0));
        light.falloff = light.shape.position().map(|_| 1.0);
        if self.kind == "spot" {
            let Cone {
                inner_cone_angle: inner,
                outer_cone_angle: outer,
            } = self.spot;
            light.spot = Some(Spot::new(-to_light, inner.to_degrees(), outer.to_degrees()).ok()?);
        }
        let is_lit = is_valid && is_usable(light.intensity) && light.color.into_iter().all(f32::is_finite);
        is_lit.then_some(light)
    }
}

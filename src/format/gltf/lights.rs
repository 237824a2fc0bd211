//! Point, spot and directional lights: the extension `KHR_lights_punctual`, The Khronos Group, 2018.
//!
//! The gltf crate would refuse a whole file for a fault in its lights, so they are read apart from it.

use crate::scene::{Light, LightShape, MAX_LIGHTS, Spot, is_usable};
use glam::DMat4;
use gltf::json;
use serde::{Deserialize, de::IgnoredAny};

const EXTENSION: &str = "KHR_lights_punctual";

/// The lights of a file, and the nodes that place them.
#[derive(Default)]
pub(super) struct PunctualLights {
    lights: Vec<Punctual>,
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

/// The parts of the JSON that matter here.
#[derive(Deserialize)]
#[serde(default, bound(deserialize = "L: Deserialize<'de>, N: Deserialize<'de>"))]
struct Lit<L, N> {
    extensions: Extensions<Lights<L>>,
    nodes: Vec<N>,
}

#[derive(Deserialize)]
#[serde(default, bound(deserialize = "T: Deserialize<'de> + Default"))]
struct Extensions<T> {
    #[serde(rename = "KHR_lights_punctual")]
    punctual: T,
}

#[derive(Deserialize)]
#[serde(default, bound(deserialize = "L: Deserialize<'de>"))]
struct Lights<L> {
    lights: Vec<L>,
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

impl<L, N> Default for Lit<L, N> {
    fn default() -> Self {
        Self {
            extensions: Extensions::default(),
            nodes: Vec::new(),
        }
    }
}

impl<T: Default> Default for Extensions<T> {
    fn default() -> Self {
        Self {
            punctual: T::default(),
        }
    }
}

impl<L> Default for Lights<L> {
    fn default() -> Self {
        Self { lights: Vec::new() }
    }
}

impl PunctualLights {
    /// Reads the JSON once more, but only if the file uses the extension.
    pub fn of(text: &[u8]) -> Self {
        // Some exporters forget `extensionsUsed`.
        if !text
            .windows(EXTENSION.len())
            .any(|found| found == EXTENSION.as_bytes())
        {
            return Self::default();
        }
        // Counted first, which takes no memory: a scene has few lights.
        let counted: Lit<IgnoredAny, IgnoredAny> = json::deserialize::from_slice(text).unwrap_or_default();
        let count = counted.extensions.punctual.lights.len();
        let read = json::deserialize::from_slice::<Lit<Punctual, LitNode>>(text);
        match read.ok().filter(|_| count <= MAX_LIGHTS) {
            Some(Lit { extensions, nodes }) => Self {
                lights: extensions.punctual.lights,
                of_node: nodes
                    .into_iter()
                    .map(|node| node.extensions.punctual.light)
                    .collect(),
                left_out: 0,
            },
            None => Self {
                left_out: count,
                ..Self::default()
            },
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
        let light = self.lights.get(index).and_then(|punctual| punctual.at(world));
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

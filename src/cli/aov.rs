//! What `--aov` makes of a pixel's variables: pictures of bytes, EXR channels, lines for `--stats`.
//!
//! No scale depends on the picture's pixels: a crop's files are parts of the whole's.

use super::exr_layers::{Channel, Values};
use crate::{
    heat::heat,
    math::Aabb,
    ray::PrimitiveId,
    render::{Aov, Aovs, ByteFilm, Transfer, quantize},
};
use clap::ValueEnum;
use glam::Vec3;
use serde::Serialize;

/// Which variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum AovArg {
    /// Distance from the eye
    Depth,
    /// Shading normal
    Normal,
    /// The material's own colour
    Albedo,
    /// Which triangle or sphere
    Id,
    /// How many nodes and primitives the ray cost
    Heat,
}

impl AovArg {
    /// As on the command line and in file names.
    pub fn name(self) -> &'static str {
        match self {
            Self::Depth => "depth",
            Self::Normal => "normal",
            Self::Albedo => "albedo",
            Self::Id => "id",
            Self::Heat => "heat",
        }
    }
}

/// The distances that depth shows as white and as black: those of the nearest and the farthest place of the scene's
/// box. What is between is logarithmic, for the sake of small things on a wide ground.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DepthRange {
    pub white: f32,
    pub black: f32,
}

impl DepthRange {
    /// As seen from `eye`.
    pub fn new(bounds: Aabb, eye: Vec3) -> Self {
        if bounds.lower.cmpgt(bounds.upper).any() {
            return Self {
                white: 0.0,
                black: 1.0,
            };
        }
        let nearest = eye.clamp(bounds.lower, bounds.upper);
        let farthest = (bounds.lower - eye).abs().max((bounds.upper - eye).abs());
        let black = farthest.length();
        Self {
            white: (nearest - eye).length().max(black * NEAREST),
            black,
        }
    }

    fn gray(self, depth: f32) -> u8 {
        let [white, black, depth] = [self.white, self.black, depth].map(|t| libm::log(f64::from(t)));
        quantize(((black - depth) / (black - white).max(f64::MIN_POSITIVE)) as f32)
    }
}

/// Nothing nearer than this share of the farthest distance has a grey of its own: the eye may be within the box.
const NEAREST: f32 = 1e-4;

/// A colour for an id: neighbours' differ.
fn id_color(PrimitiveId(id): PrimitiveId) -> [u8; 3] {
    // Fibonacci hashing (Knuth): the golden ratio's share of 2^32.
    let bits = id.wrapping_add(1).wrapping_mul(0x9e37_79b9);
    let bits = (bits ^ bits >> 15).wrapping_mul(0x85eb_ca6b);
    [24, 16, 8].map(|shift| 55 + ((bits >> shift & 0xff) * 200 / 255) as u8)
}

/// The variable as a picture of bytes.
pub fn picture(aovs: &Aovs, which: AovArg, range: DepthRange, transfer: Transfer) -> ByteFilm {
    let color = |pixel: &Aov| match which {
        AovArg::Heat => heat(pixel.cost.total()),
        AovArg::Albedo => transfer.encode(pixel.albedo),
        _ if pixel.primitive == PrimitiveId::NONE => [0; 3],
        AovArg::Depth => [range.gray(pixel.depth); 3],
        AovArg::Normal => pixel.normal.map(|c| quantize(c * 0.5 + 0.5)),
        AovArg::Id => id_color(pixel.primitive),
    };
    let mut film = ByteFilm::black(aovs.width, aovs.height);
    for (to, pixel) in film.pixels_mut().iter_mut().zip(&aovs.pixels) {
        *to = color(pixel);
    }
    film
}

/// The variable's EXR channels: as they are.
pub fn channels(aovs: &Aovs, which: AovArg) -> Vec<Channel> {
    let floats = |name, value: &dyn Fn(&Aov) -> f32| Channel {
        name,
        values: Values::Floats(aovs.pixels.iter().map(value).collect()),
    };
    let whole = |name, value: &dyn Fn(&Aov) -> u32| Channel {
        name,
        values: Values::Whole(aovs.pixels.iter().map(value).collect()),
    };
    match which {
        AovArg::Depth => vec![floats("depth.Z", &|p| p.depth)],
        AovArg::Normal => vec![
            floats("normal.X", &|p| p.normal[0]),
            floats("normal.Y", &|p| p.normal[1]),
            floats("normal.Z", &|p| p.normal[2]),
        ],
        AovArg::Albedo => vec![
            floats("albedo.R", &|p| p.albedo[0]),
            floats("albedo.G", &|p| p.albedo[1]),
            floats("albedo.B", &|p| p.albedo[2]),
        ],
        AovArg::Id => vec![whole("id.primitive", &|p| p.primitive.0)],
        AovArg::Heat => vec![
            whole("heat.nodes", &|p| p.cost.nodes),
            whole("heat.primitives", &|p| p.cost.primitives),
        ],
    }
}

/// What `--stats` says of the variables.
#[derive(Debug, Serialize)]
pub struct AovReport {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth: Option<DepthRange>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub heat: Option<HeatReport>,
}

/// Costs of the rays through the pixels' centres, and which colours stand for them.
#[derive(Debug, Serialize)]
pub struct HeatReport {
    pub nodes: Costs,
    pub primitives: Costs,
    pub total: Costs,
    pub legend: Vec<Legend>,
}

#[derive(Debug, Serialize)]
pub struct Costs {
    pub mean: f64,
    pub most: u32,
}

/// A cost and its colour, `#rrggbb`.
#[derive(Debug, Serialize)]
pub struct Legend {
    pub cost: u32,
    pub color: String,
}

impl AovReport {
    /// Of the variables that were asked for; `None` where none of them needs words.
    pub fn new(aovs: &Aovs, asked: &[AovArg], range: DepthRange) -> Option<Self> {
        let costs = |of: &dyn Fn(&Aov) -> u32| Costs {
            mean: aovs.pixels.iter().map(|p| f64::from(of(p))).sum::<f64>() / aovs.pixels.len().max(1) as f64,
            most: aovs.pixels.iter().map(of).max().unwrap_or(0),
        };
        let legend = |power: u32| {
            let cost = 4_u32.pow(power);
            let [r, g, b] = heat(cost);
            Legend {
                cost,
                color: format!("#{r:02x}{g:02x}{b:02x}"),
            }
        };
        let report = Self {
            depth: asked.contains(&AovArg::Depth).then_some(range),
            heat: asked.contains(&AovArg::Heat).then(|| HeatReport {
                nodes: costs(&|p| p.cost.nodes),
                primitives: costs(&|p| p.cost.primitives),
                total: costs(&|p| p.cost.total()),
                legend: (0..=6).map(legend).collect(),
            }),
        };
        (report.depth.is_some() || report.heat.is_some()).then_some(report)
    }

    /// Names and values of the lines to read.
    pub fn lines(&self) -> Vec<(&'static str, String)> {
        let mut lines = Vec::new();
        if let Some(DepthRange { white, black }) = self.depth {
            lines.push(("depth", format!("white at {white}, black at {black}")));
        }
        if let Some(heat) = &self.heat {
            let costs = |what: &str, costs: &Costs| format!("{:.1} {what} (most {})", costs.mean, costs.most);
            lines.push((
                "heat",
                format!(
                    "a pixel's ray costs {}, {}, together {}",
                    costs("nodes", &heat.nodes),
                    costs("primitives", &heat.primitives),
                    costs("on average", &heat.total)
                ),
            ));
            let colors: Vec<String> = heat
                .legend
                .iter()
                .map(|entry| format!("{} {}", entry.cost, entry.color))
                .collect();
            lines.push(("heat legend", colors.join(", ")));
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depth_spans_the_scene() {
        let bounds = Aabb {
            lower: Vec3::ZERO,
            upper: Vec3::splat(2.0),
        };
        let range = DepthRange::new(bounds, Vec3::new(-3.0, 1.0, 1.0));
        assert_eq!(
            (range.white, range.gray(3.0), range.gray(range.black)),
            (3.0, 255, 0)
        );
        let within = DepthRange::new(bounds, Vec3::ONE);
        assert!(within.white > 0.0 && within.gray(0.0) == 255);
        DepthRange::new(Aabb::EMPTY, Vec3::ONE);
    }
}

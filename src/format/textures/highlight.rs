//! glTF's map of roughness and metal as a map of highlights.

#[cfg(feature = "textures")]
use crate::math::srgb;

/// How strong the highlight of a perfectly smooth surface is.
#[cfg(any(feature = "gltf", feature = "textures"))]
pub(in crate::format) const STRONGEST: f32 = 0.6;

/// What becomes of a map of roughness (green) and metal (blue): highlights are stronger where it is smooth, and have the
/// surface's colour where it is metal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(in crate::format) struct Highlight {
    /// The bits of the factor of roughness.
    roughness: u32,
    /// The bits of the metallic factor.
    metallic: u32,
    /// The base colour, display values.
    color: [u8; 3],
    /// The image of the base colour, which has the same texture coordinates.
    base: Option<u32>,
}

impl Highlight {
    /// Takes factors from 0 to 1 and display values.
    #[cfg(feature = "gltf")]
    pub(in crate::format) fn new(roughness: f32, metallic: f32, color: [f32; 3], base: Option<u32>) -> Self {
        let color = color.map(|channel| (channel * 255.0 + 0.5) as u8);
        let is_white = color == [u8::MAX; 3] && base.is_none();
        if metallic == 0.0 || is_white {
            return Self::without_metal(roughness);
        }
        Self {
            roughness: roughness.to_bits(),
            metallic: metallic.to_bits(),
            color,
            base,
        }
    }

    fn without_metal(roughness: f32) -> Self {
        Self {
            roughness: roughness.to_bits(),
            metallic: 0,
            color: [u8::MAX; 3],
            base: None,
        }
    }

    /// One of few: without metal, its roughness rounded to one of `steps`.
    pub(super) fn rounded(self, steps: f32) -> Self {
        let roughness = f32::from_bits(self.roughness);
        Self::without_metal((roughness * steps).round() / steps)
    }

    /// The image of the base colour, if it counts.
    pub(super) fn base(self) -> Option<u32> {
        self.base
    }

    /// Whether anything of this map is metal, so that the base colour counts.
    #[cfg(feature = "textures")]
    pub(super) fn shows_metal(self, map: &[u8]) -> bool {
        self.metallic != 0 && map.chunks_exact(4).any(|texel| texel[2] != 0)
    }

    /// Turns a map, RGBA, into the colours of highlights, display values. `base` are the texels of the base colour, as many,
    /// or none. Returns the mean smoothness, in 255ths.
    #[cfg(feature = "textures")]
    pub(super) fn apply(self, map: &mut [u8], base: &[u8]) -> u8 {
        let [roughness, metallic] = [self.roughness, self.metallic].map(f32::from_bits);
        // The base colour's display values, 0 to 1, by those of its texture.
        let tables: [[f32; 256]; 3] = self.color.map(|factor| {
            let factor = srgb::decode(f64::from(factor) / 255.0);
            std::array::from_fn(|texel| srgb::encode(srgb::decode(texel as f64 / 255.0) * factor) as f32)
        });
        let mut sum = 0;
        for (i, texel) in map.chunks_exact_mut(4).enumerate() {
            let rough = (f32::from(texel[1]) * roughness).clamp(0.1 * 255.0, 255.0);
            let smoothness = (255.0 - rough + 0.5) as u8;
            let metal = metallic * f32::from(texel[2]) / 255.0;
            let color = base.get(4 * i..4 * i + 3).unwrap_or(&[u8::MAX; 3]);
            for channel in 0..3 {
                let tint = 1.0 + metal * (tables[channel][usize::from(color[channel])] - 1.0);
                texel[channel] = (STRONGEST * f32::from(smoothness) * tint + 0.5) as u8;
            }
            texel[3] = u8::MAX;
            sum += u64::from(smoothness);
        }
        let count = map.len() as u64 / 4;
        ((sum + count / 2) / count.max(1)) as u8
    }
}

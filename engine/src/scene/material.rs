//! Materials: the reflection models and the ranges of their constants.

use super::{Scene, is_usable};
use crate::{classic, error::SceneError};

/// The largest Blinn-Phong exponent. Unit vectors in `f32` may be slightly too long, and a larger power would amplify
/// that.
pub const MAX_ALPHA: u32 = 10_000;

/// Factors of reflected ambient light: straight on, and what grazing angles add. See [`Scene::ambient_specular`].
// Tuned: see docs/lab-notes.md#reflected-ambient-light
pub(crate) const AMBIENT_SPECULAR: [f32; 2] = [0.5, 3.0];

/// The largest c_s k_s in reflected ambient light, about that of plastic: more would hide the base colour.
pub(crate) const MOST_POLISH: f32 = 0.08;

/// The range of refractive indices; below 1 for bubbles in a denser medium.
pub const INDEX_RANGE: (f32, f32) = (0.3, 3.0);

/// How a surface reflects light. I_a is the ambient light, I_i a light's intensity times its colour in a channel; the
/// constants of classic scenes are in [`classic`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Material {
    /// A constant colour, independent of light.
    Silhouette {
        /// The colour, linear RGB.
        color: [f32; 3],
    },
    /// `color * min(1, I_a + sum I_i max(0, n.l_i))`.
    Matte {
        /// The colour, linear RGB; white in classic scenes.
        color: [f32; 3],
    },
    /// `c_d (I_a + k_d sum I_i max(0, n.l_i)) + c_s k_s sum I_i max(0, n.h_i)^alpha`, clamped to [0, 1].
    BlinnPhong {
        /// c_d, linear RGB.
        diffuse: [f32; 3],
        /// c_s, linear RGB.
        specular: [f32; 3],
        /// k_d.
        k_d: f32,
        /// k_s.
        k_s: f32,
        /// The exponent, 1 to [`MAX_ALPHA`].
        alpha: u32,
    },
    /// `(1 - mirror_share) matte + mirror_share * (colour of the mirrored ray)`.
    Reflection {
        /// The matte part's colour, linear RGB; white in classic scenes.
        color: [f32; 3],
        /// The weight of the mirrored ray, 0 to 1.
        mirror_share: f32,
    },
    /// `F * (colour of the mirrored ray) + (1 - F) * (colour of the refracted ray)`, with F by Fresnel's equations for
    /// unpolarised light. Light that travels a distance t inside is multiplied by `tint^(t / depth)` (Beer-Lambert).
    /// Surfaces are closed, and outside is where spheres and counterclockwise triangles face.
    Glass {
        /// Refractive index of the inside relative to the outside, [`INDEX_RANGE`].
        index: f32,
        /// The colour of white light after `depth`, linear RGB.
        tint: [f32; 3],
        /// The distance that `tint` belongs to, scene units, above 0.
        depth: f32,
    },
}

impl Material {
    /// Returns the colour that textures multiply; the tint of glass.
    #[doc(hidden)]
    pub fn base_color_mut(&mut self) -> &mut [f32; 3] {
        match self {
            Self::Silhouette { color }
            | Self::Matte { color }
            | Self::Reflection { color, .. }
            | Self::BlinnPhong { diffuse: color, .. }
            | Self::Glass { tint: color, .. } => color,
        }
    }

    /// Returns the colour that textures multiply; the tint of glass.
    #[inline]
    pub(crate) fn base_color(mut self) -> [f32; 3] {
        *self.base_color_mut()
    }

    /// The four materials of a classic `.scn`, by their number there.
    pub const CLASSIC: [Self; 4] = [
        Self::Silhouette {
            color: classic::SILHOUETTE,
        },
        Self::Matte { color: [1.0; 3] },
        Self::BlinnPhong {
            diffuse: classic::DIFFUSE,
            specular: classic::SPECULAR,
            k_d: classic::K_D,
            k_s: classic::K_S,
            alpha: classic::ALPHA,
        },
        Self::Reflection {
            color: [1.0; 3],
            mirror_share: classic::MIRROR_SHARE,
        },
    ];

    /// Clear glass, index 1.5.
    pub const GLASS: Self = Self::Glass {
        index: 1.5,
        tint: [1.0; 3],
        depth: 1.0,
    };

    /// Returns whether light changes its colour inside the material.
    pub(crate) fn tints(&self) -> bool {
        matches!(*self, Self::Glass { tint, .. } if tint != [1.0; 3])
    }

    /// Returns the transmittance, by channel, of this distance inside the material.
    ///
    /// Both modes call it: powers by `libm` are the same on every machine.
    #[must_use]
    pub fn transmittance(&self, distance: f32) -> [f32; 3] {
        let Self::Glass { tint, depth, .. } = *self else {
            return [1.0; 3];
        };
        let depths = f64::from(distance) / f64::from(depth);
        tint.map(|share| {
            if share == 1.0 {
                1.0
            } else {
                libm::pow(f64::from(share), depths) as f32
            }
        })
    }

    /// Refuses constants out of range.
    pub(super) fn check(&self) -> Result<(), SceneError> {
        match *self {
            Self::Silhouette { color } | Self::Matte { color } => check_color(color),
            Self::BlinnPhong {
                diffuse,
                specular,
                k_d,
                k_s,
                alpha,
            } => {
                check_color(diffuse)?;
                check_color(specular)?;
                check_share("kd", k_d)?;
                check_share("ks", k_s)?;
                if (1..=MAX_ALPHA).contains(&alpha) {
                    Ok(())
                } else {
                    Err(SceneError::OutOfRange {
                        what: "alpha",
                        value: alpha as f32,
                        range: (1.0, MAX_ALPHA as f32),
                    })
                }
            }
            Self::Reflection { color, mirror_share } => {
                check_color(color)?;
                check_share("mix", mirror_share)
            }
            Self::Glass { index, tint, depth } => {
                check_range("ior", index, INDEX_RANGE)?;
                check_color(tint)?;
                let (what, value) = ("depth", depth);
                if !is_usable(depth) {
                    Err(SceneError::NotUsable { what, value })
                } else if depth <= 0.0 {
                    Err(SceneError::NotPositive { what, value })
                } else {
                    Ok(())
                }
            }
        }
    }

    /// Returns the kind and all constants as bits: equal for materials that are the same bit for bit.
    pub(super) fn bits(&self) -> [u32; 10] {
        let mut bits = [0; 10];
        let mut write = |kind: u32, constants: &[f32]| {
            bits[0] = kind;
            for (bits, constant) in bits[1..].iter_mut().zip(constants) {
                *bits = constant.to_bits();
            }
        };
        match *self {
            Self::Silhouette { color: [r, g, b] } => write(0, &[r, g, b]),
            Self::Matte { color: [r, g, b] } => write(1, &[r, g, b]),
            Self::BlinnPhong {
                diffuse: [r, g, b],
                specular: [sr, sg, sb],
                k_d,
                k_s,
                alpha,
            } => write(2, &[r, g, b, sr, sg, sb, k_d, k_s, alpha as f32]),
            Self::Reflection {
                color: [r, g, b],
                mirror_share,
            } => write(3, &[r, g, b, mirror_share]),
            Self::Glass {
                index,
                tint: [r, g, b],
                depth,
            } => write(4, &[index, r, g, b, depth]),
        }
        bits
    }
}

impl Scene {
    /// Returns whether Blinn-Phong reflects ambient light, too: min(c_s k_s, 0.08) I_a (0.5 + 3 (1 - n.v)^5), v to the
    /// viewer, after Schlick, *An Inexpensive BRDF Model for Physically-based Rendering*, 1994. Dark, glossy things show
    /// their shape then.
    #[inline]
    #[must_use]
    pub fn ambient_specular(&self) -> bool {
        self.ambient_specular
    }
}

/// Refuses a value outside [0, 1].
pub(super) fn check_share(what: &'static str, value: f32) -> Result<(), SceneError> {
    check_range(what, value, (0.0, 1.0))
}

pub(super) fn check_range(what: &'static str, value: f32, range: (f32, f32)) -> Result<(), SceneError> {
    if (range.0..=range.1).contains(&value) {
        Ok(())
    } else {
        Err(SceneError::OutOfRange { what, value, range })
    }
}

/// Refuses channels outside [0, 1].
pub(super) fn check_color([red, green, blue]: [f32; 3]) -> Result<(), SceneError> {
    check_share("red", red)?;
    check_share("green", green)?;
    check_share("blue", blue)
}

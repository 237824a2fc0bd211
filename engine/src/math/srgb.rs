//! The sRGB curve (IEC 61966-2-1), for channels from 0 on; above 1, brighter than white, it is continued.

/// Returns the light that a display value stands for.
#[doc(hidden)]
pub fn decode(display: f64) -> f64 {
    if display <= 0.04045 {
        display / 12.92
    } else {
        libm::pow((display + 0.055) / 1.055, 2.4)
    }
}

/// Returns the display value of light.
#[doc(hidden)]
pub fn encode(linear: f64) -> f64 {
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055
    }
}

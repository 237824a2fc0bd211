//! Values of options, from text.

use super::{picture_args, turntable};
use crate::scene::MAX_COORDINATE;
use glam::DVec3;

/// Width and height of a picture, pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
}

/// `WxH`, both above 0.
pub fn size(text: &str) -> Result<Size, String> {
    let parts = text.split_once(['x', 'X']).and_then(|(width, height)| {
        let side = |side: &str| side.parse().ok().filter(|&pixels| pixels > 0);
        Some(Size {
            width: side(width)?,
            height: side(height)?,
        })
    });
    parts.ok_or_else(|| "expected WIDTHxHEIGHT in pixels, both 1 or more, such as 512x512".into())
}

/// `x,y,z`.
pub fn vector(text: &str) -> Result<DVec3, String> {
    let mut numbers = text.split(',').map(|number| number.trim().parse::<f64>().ok());
    let mut next = || numbers.next().flatten();
    let vector = match (next(), next(), next()) {
        (Some(x), Some(y), Some(z)) => DVec3::new(x, y, z),
        _ => return Err("expected three numbers x,y,z such as -1,2.5,3".into()),
    };
    if numbers.next().is_some() {
        return Err("expected three numbers x,y,z, found more".into());
    }
    if vector.is_finite() && vector.abs().max_element() <= f64::from(MAX_COORDINATE) {
        Ok(vector)
    } else {
        Err(format!("expected numbers of at most {MAX_COORDINATE:e}"))
    }
}

/// A time in seconds, above 0 and at most an hour.
#[cfg(feature = "viewer")]
pub fn seconds(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|seconds| *seconds > 0.0 && *seconds <= 3600.0)
        .ok_or_else(|| "expected a number of seconds, more than 0 and at most 3600".into())
}

/// An angle between faces, degrees.
pub fn angle(text: &str) -> Result<f64, String> {
    let angle = text.parse().ok().filter(|angle| (0.0..=180.0).contains(angle));
    angle.ok_or_else(|| "expected degrees from 0 to 180, such as 30".into())
}

/// A difference of colours, 0 to 255.
pub fn levels(text: &str) -> Result<f32, String> {
    let levels = text.parse().ok().filter(|levels| (0.0..=255.0).contains(levels));
    levels.ok_or_else(|| "expected levels of 255: a number from 0 to 255".into())
}

/// A part of a whole, 0 to 1.
pub fn share(text: &str) -> Result<f64, String> {
    let share = text.parse().ok().filter(|share| (0.0..=1.0).contains(share));
    share.ok_or_else(|| "expected a share from 0 (none) to 1 (all), such as 0.001".into())
}

/// Bytes: a number with K, M, G or T (of 1024) behind it, if any; and `iB` or `B` if somebody likes that.
pub fn bytes(text: &str) -> Result<u64, String> {
    let expected = || "expected a number of bytes, 1 or more, such as 512M or 16G".to_owned();
    let digits = text.len() - text.trim_start_matches(|c: char| c.is_ascii_digit()).len();
    let (number, unit) = text.split_at(digits);
    let unit = unit.to_ascii_uppercase();
    let shift = match unit
        .strip_suffix("IB")
        .or(unit.strip_suffix('B'))
        .unwrap_or(&unit)
    {
        "" => 0,
        "K" => 10,
        "M" => 20,
        "G" => 30,
        "T" => 40,
        _ => return Err(expected()),
    };
    let bytes = number
        .parse()
        .ok()
        .and_then(|number: u64| number.checked_mul(1 << shift));
    bytes.filter(|&bytes| bytes > 0).ok_or_else(expected)
}

/// The numbers of a value, by its option's name.
pub fn numbers(option: &str, text: &str) -> Result<Vec<f64>, String> {
    Ok(match option {
        "size" => size(text).map(|size| vec![size.width.into(), size.height.into()])?,
        "eye" => vector(text)?.to_array().to_vec(),
        "smooth-angle" => vec![angle(text)?],
        "tolerance" => vec![levels(text)?.into()],
        "allow-pixels" => vec![share(text)?],
        "crop" => picture_args::crop(text)
            .map(|crop| [crop.x0, crop.y0, crop.x1, crop.y1].map(f64::from).to_vec())?,
        "frames" => turntable::frames(text).map(|frames| vec![frames.first.into(), frames.last.into()])?,
        "max-memory" => vec![bytes(text)? as f64],
        #[cfg(feature = "viewer")]
        "benchmark" => vec![seconds(text)?],
        _ => return Err("expected the name of an option whose value is made of numbers".into()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes() {
        assert_eq!(
            size("333x217"),
            Ok(Size {
                width: 333,
                height: 217
            })
        );
        for text in [
            "",
            "x",
            "12",
            "12x",
            "x12",
            "0x5",
            "5x0",
            "1x2x3",
            "-1x5",
            "1.5x2",
            "99999999999x1",
        ] {
            assert!(size(text).is_err(), "{text}");
        }
    }

    #[test]
    fn vectors() {
        assert_eq!(vector("-1,2.5,3e2"), Ok(DVec3::new(-1.0, 2.5, 300.0)));
        assert_eq!(vector("1, 2, 3"), Ok(DVec3::new(1.0, 2.0, 3.0)));
        for text in [
            "", "1,2", "1,2,3,4", "a,b,c", "1,,3", "nan,0,0", "inf,0,0", "1e10,0,0", "--target",
        ] {
            assert!(vector(text).is_err(), "{text}");
        }
    }

    #[test]
    fn bytes_have_units() {
        for (text, expected) in [
            ("1", 1),
            ("4096", 4096),
            ("512M", 512 << 20),
            ("2gib", 2 << 30),
            ("3KB", 3072),
            ("1t", 1 << 40),
        ] {
            assert_eq!(bytes(text), Ok(expected), "{text}");
        }
        for text in [
            "",
            "0",
            "G",
            "-1",
            "1.5G",
            "1 G",
            "1X",
            "1iB1",
            "99999999999T",
            "1é",
        ] {
            assert!(bytes(text).is_err(), "{text}");
        }
    }

    #[test]
    fn levels_and_shares() {
        assert_eq!(
            (levels("0"), levels("2.5"), levels("255")),
            (Ok(0.0), Ok(2.5), Ok(255.0))
        );
        assert_eq!(
            (share("0"), share("1e-3"), share("1")),
            (Ok(0.0), Ok(0.001), Ok(1.0))
        );
        for text in ["", "-1", "256", "nan", "inf", "1%", "x"] {
            assert!(levels(text).is_err() && share(text).is_err(), "{text}");
        }
        assert!(share("1.5").is_err());
    }
}

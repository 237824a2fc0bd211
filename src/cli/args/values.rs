//! Parsers of option values.

use super::camera::Ortho;
use crate::{
    cli::plan::{Backdrop, FrameRange, Side},
    math,
    render::{Crop, MAX_EDGE_WIDTH},
    scene::MAX_COORDINATE,
};
use glam::DVec3;

/// Width and height of a picture, pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
}

impl Size {
    /// That of a picture if nothing says another.
    pub const DEFAULT: Self = Self {
        width: 512,
        height: 512,
    };
}

/// `AxB`, both above 0.
fn pair(text: &str) -> Option<[u32; 2]> {
    let (a, b) = text.split_once(['x', 'X'])?;
    let side = |side: &str| side.trim().parse().ok().filter(|&side| side > 0);
    Some([side(a)?, side(b)?])
}

/// `WxH`, or one side of a square; above 0.
pub fn size(text: &str) -> Result<Size, String> {
    let [width, height] = pair(text).or_else(|| pair(&format!("{text}x{text}"))).ok_or(
        "expected WIDTHxHEIGHT in pixels, both 1 or more, such as 800x600, or one number for a square",
    )?;
    Ok(Size { width, height })
}

/// `COLUMNSxROWS`, both above 0.
pub fn grid(text: &str) -> Result<[u32; 2], String> {
    pair(text).ok_or_else(|| "expected COLUMNSxROWS, both 1 or more, such as 4x4".into())
}

/// A whole number from 1 to `MOST`.
pub fn whole<const MOST: u32>(text: &str) -> Result<u32, String> {
    let number = text.parse().ok().filter(|number| (1..=MOST).contains(number));
    let is_large = text.len() > 9 && text.bytes().all(|byte| byte.is_ascii_digit());
    number.ok_or_else(|| match MOST {
        u32::MAX if !is_large => "expected a whole number, 1 or more".into(),
        _ => format!("expected a whole number from 1 to {MOST}"),
    })
}

/// A whole number of 1 or more.
pub fn count(text: &str) -> Result<u64, String> {
    let number = text.parse().ok().filter(|&number| number > 0);
    number.ok_or_else(|| "expected a whole number, 1 or more".into())
}

/// A whole number of 0 or more.
pub fn number(text: &str) -> Result<u64, String> {
    text.parse()
        .map_err(|_| "expected a whole number, 0 or more".into())
}

/// An angle of any size, degrees.
pub fn degrees(text: &str) -> Result<f64, String> {
    text.parse()
        .map_err(|_| "expected a number of degrees, such as 45".into())
}

/// A vertical field of view, degrees.
pub fn field_of_view(text: &str) -> Result<f64, String> {
    let angle = text.parse().ok().filter(|&angle| angle > 0.0 && angle < 180.0);
    angle.ok_or_else(|| "expected degrees, more than 0 and less than 180, such as 45".into())
}

/// A length of any size, scene units.
pub fn length(text: &str) -> Result<f64, String> {
    text.parse()
        .map_err(|_| "expected a number of scene units, such as 2.5".into())
}

/// `HEIGHT`, or `fit`.
pub fn ortho(text: &str) -> Result<Ortho, String> {
    match text.parse() {
        Ok(height) => Ok(Ortho::Height(height)),
        Err(_) if text == "fit" => Ok(Ortho::Fit),
        Err(_) => Err("expected a number of scene units, such as 2.5, or fit".into()),
    }
}

/// A width of lines, pixels.
pub fn edge_width(text: &str) -> Result<f32, String> {
    let width = text
        .parse()
        .ok()
        .filter(|&width| width > 0.0 && width <= MAX_EDGE_WIDTH);
    width.ok_or_else(|| {
        format!("expected a number of pixels above 0 and at most {MAX_EDGE_WIDTH}, such as 1.5")
    })
}

/// A colour as bytes.
pub fn color(text: &str) -> Result<[u8; 3], String> {
    match text.parse() {
        Ok(Backdrop::Color(color)) => Ok(color),
        _ => Err("expected white, black, or a colour of six hexadecimal digits, such as 336699".into()),
    }
}

/// The name of a side, or `AZIMUTH,ELEVATION` in degrees.
pub fn side(text: &str) -> Result<Side, String> {
    let named = Side::NAMED.iter().find(|(name, _)| *name == text);
    let angles = || {
        let (azimuth, elevation) = text.split_once(',')?;
        let degrees = |word: &str| word.trim().parse().ok().filter(|angle: &f64| angle.is_finite());
        Some(Side {
            azimuth: degrees(azimuth)?,
            elevation: degrees(elevation)?,
        })
    };
    named.map(|&(_, side)| side).or_else(angles).ok_or_else(|| {
        let names = Side::NAMED.map(|(name, _)| name).join(", ");
        format!("expected {names}, or AZIMUTH,ELEVATION in degrees such as 35,20; a position goes to --eye")
    })
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
    if !vector.is_finite() {
        return Err("expected three finite numbers x,y,z such as -1,2.5,3".into());
    }
    if vector.abs().max_element() <= f64::from(MAX_COORDINATE) {
        Ok(vector)
    } else {
        Err(format!("expected numbers of at most {MAX_COORDINATE:e}"))
    }
}

/// `LOW,HIGH`, finite and different.
pub fn range(text: &str) -> Result<[f64; 2], String> {
    let number = |word: &str| word.trim().parse().ok().filter(|number: &f64| number.is_finite());
    let range = text
        .split_once(',')
        .and_then(|(low, high)| Some([number(low)?, number(high)?]));
    match range {
        Some([low, high]) if low == high => {
            Err("expected two different numbers LOW,HIGH such as 0,2.5".into())
        }
        Some(range) => Ok(range),
        None => Err("expected two finite numbers LOW,HIGH such as 0,2.5".into()),
    }
}

/// `x,y,z`, which is not the point 0.
pub fn direction(text: &str) -> Result<DVec3, String> {
    let vector = vector(text)?;
    match math::moderate(vector).try_normalize() {
        Some(_) => Ok(vector),
        None => Err("expected a direction x,y,z such as 1,1,0.5, and this has no length".into()),
    }
}

/// The most frames of a turntable.
pub const MOST_FRAMES: u32 = 10_000;

/// The highest number of a frame: that of scenes and animations.
const LAST_FRAME: u32 = 100_000;

/// The most columns of a sheet.
pub const MOST_COLUMNS: u32 = 1000;

/// The most frames per second of an animation: GIF shows each for at least a hundredth of a second.
pub const MOST_FPS: u32 = 100;

/// `A-B`, or `A` alone.
pub fn frames(text: &str) -> Result<FrameRange, String> {
    let number = |digits: &str| {
        let plain = !digits.is_empty() && digits.bytes().all(|digit| digit.is_ascii_digit());
        digits.parse().ok().filter(|&number: &u32| plain && number > 0)
    };
    let (first, last) = text.split_once('-').unwrap_or((text, text));
    match (number(first), number(last)) {
        (Some(first), Some(last)) if first.max(last) > LAST_FRAME => {
            Err(format!("expected numbers from 1 to {LAST_FRAME}"))
        }
        (Some(first), Some(last)) if first <= last => Ok(FrameRange { first, last }),
        (Some(first), Some(last)) => Err(format!("expected the lower number first: {last}-{first}")),
        _ => Err("expected two numbers A-B from 1 on, such as 1-24, or one".into()),
    }
}

/// `x0,y0,x1,y1`. Not checked against the size of the picture.
pub fn crop(text: &str) -> Result<Crop, String> {
    let numbers: Option<Vec<u32>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x0, y0, x1, y1]) if x0 < x1 && y0 < y1 => Ok(Crop { x0, y0, x1, y1 }),
        Some(&[..]) if text.split(',').count() == 4 => Err("expected x0 below x1 and y0 below y1".into()),
        _ => Err("expected four whole numbers x0,y0,x1,y1 in pixels, such as 0,0,256,128".into()),
    }
}

/// A time in seconds, above 0 and at most an hour.
#[cfg(feature = "viewer")]
pub fn seconds(text: &str) -> Result<f64, String> {
    seconds_up_to(3600, text)
}

/// A time in seconds, above 0 and at most a hundred days.
pub fn long_seconds(text: &str) -> Result<f64, String> {
    seconds_up_to(8_640_000, text)
}

/// A time of an animation, seconds.
pub fn moment(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok().filter(|seconds| (0.0..=1e6).contains(seconds));
    seconds.ok_or_else(|| "expected a number of seconds, at least 0 and at most 1000000".into())
}

fn seconds_up_to(most: u32, text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok();
    seconds
        .filter(|&seconds| seconds > 0.0 && seconds <= f64::from(most))
        .ok_or_else(|| format!("expected a number of seconds, more than 0 and at most {most}"))
}

/// The diameter of points and lines, scene units.
pub fn diameter(text: &str) -> Result<f32, String> {
    let largest = f64::from(MAX_COORDINATE);
    let diameter = text.parse().ok().filter(|diameter: &f64| *diameter <= largest);
    let diameter = diameter.map(|diameter| diameter as f32);
    // Half of it is above 0, too.
    let diameter = diameter.filter(|diameter| diameter * 0.5 > 0.0);
    diameter.ok_or_else(|| "expected a diameter in scene units, above 0 and at most 1e9".into())
}

/// A step of depth, scene units.
pub fn step(text: &str) -> Result<f64, String> {
    // Its inverse must be finite, too.
    let step = text.parse().ok().filter(|step| (1e-30..=1e30).contains(step));
    step.ok_or_else(|| "expected scene units, above 0, such as 0.001".into())
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

/// Bytes: a number, optionally followed by K, M, G or T (powers of 1024) and `B` or `iB`.
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

/// The numbers of an option's value.
pub fn numbers(option: &str, text: &str) -> Result<Vec<f64>, String> {
    Ok(match option {
        "size" => size(text).map(|size| vec![size.width.into(), size.height.into()])?,
        "eye" => vector(text)?.to_array().to_vec(),
        "smooth-angle" => vec![angle(text)?],
        "tolerance" => vec![levels(text)?.into()],
        "allow-pixels" => vec![share(text)?],
        "crop" => crop(text).map(|crop| [crop.x0, crop.y0, crop.x1, crop.y1].map(f64::from).to_vec())?,
        "frames" => frames(text).map(|frames| vec![frames.first.into(), frames.last.into()])?,
        "max-memory" => vec![bytes(text)? as f64],
        #[cfg(feature = "viewer")]
        "benchmark" => vec![seconds(text)?],
        _ => return Err("expected an option with numbers as its value".into()),
    })
}

#[cfg(test)]
mod tests;

//! Compares pictures with expected ones and writes how they differ.

use image::{Rgb, RgbImage};
use octray::render::Film;
use std::{
    fs,
    path::{Path, PathBuf},
};

/// The difference of a channel (of 255) up to which a pixel counts as equal.
const CHANNEL_TOLERANCE: u8 = 2;

/// The package's own folder.
pub fn package() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The picture's bytes as the program writes them.
#[allow(dead_code, reason = "tests of the program do not render by themselves")]
pub fn to_image(film: &Film) -> RgbImage {
    RgbImage::from_raw(film.width(), film.height(), film.to_rgb8()).expect("three bytes a pixel")
}

/// Counts pixels with a channel that differs by more than the tolerance.
pub fn count_different(a: &RgbImage, b: &RgbImage) -> usize {
    a.pixels()
        .zip(b.pixels())
        .filter(|(a, b)| largest_difference(a, b) > CHANNEL_TOLERANCE)
        .count()
}

fn largest_difference(a: &Rgb<u8>, b: &Rgb<u8>) -> u8 {
    (0..3).map(|c| a[c].abs_diff(b[c])).max().unwrap_or(0)
}

/// Compares `actual` with the PNG at `expected_path`. If more than `share` of the pixels differ, writes the expected, the
/// actual and the difference picture to `target/image-failures` and returns an error that names them.
pub fn compare(name: &str, actual: &RgbImage, expected_path: &Path, share: f64) -> Result<(), String> {
    let expected = image::open(expected_path)
        .map_err(|error| format!("{name}: cannot read {}: {error}", expected_path.display()))?
        .into_rgb8();
    if expected.dimensions() != actual.dimensions() {
        return Err(format!(
            "{name}: the picture is {:?}, expected {:?} as {}",
            actual.dimensions(),
            expected.dimensions(),
            expected_path.display()
        ));
    }
    let different = count_different(actual, &expected);
    let allowed = (share * f64::from(actual.width()) * f64::from(actual.height())) as usize;
    if different <= allowed {
        return Ok(());
    }
    let named = write_failure(name, actual, &expected)?;
    Err(format!(
        "{name}: {different} pixels differ by more than {CHANNEL_TOLERANCE}/255, at most {allowed} may; see\n{named}"
    ))
}

/// Compares with a golden picture in `tests/golden`. With `OCTRAY_BLESS=1` replaces a golden picture that differs or adds
/// one that is missing.
pub fn compare_golden(name: &str, actual: &RgbImage, share: f64) -> Result<(), String> {
    let path = package().join("tests/golden").join(format!("{name}.png"));
    let result = if path.is_file() {
        compare(name, actual, &path, share)
    } else {
        Err(format!(
            "{name}: {} is missing; OCTRAY_BLESS=1 writes it: look at it before you commit",
            path.display()
        ))
    };
    if result.is_err() && std::env::var_os("OCTRAY_BLESS").is_some_and(|value| value == "1") {
        return save(actual, &path);
    }
    result
}

/// Panics with all failed comparisons, so that one run shows them together.
pub fn assert_all(results: impl IntoIterator<Item = Result<(), String>>) {
    let failures: Vec<String> = results.into_iter().filter_map(Result::err).collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

fn save(picture: &RgbImage, path: &Path) -> Result<(), String> {
    picture
        .save(path)
        .map_err(|error| format!("cannot write {}: {error}", path.display()))
}

/// Writes the expected, the actual and the difference picture. The last is white where pixels count as different, and
/// eight times the difference elsewhere.
fn write_failure(name: &str, actual: &RgbImage, expected: &RgbImage) -> Result<String, String> {
    let folder = failure_folder();
    fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut difference = RgbImage::new(actual.width(), actual.height());
    for ((out, a), b) in difference
        .pixels_mut()
        .zip(actual.pixels())
        .zip(expected.pixels())
    {
        *out = if largest_difference(a, b) > CHANNEL_TOLERANCE {
            Rgb([255; 3])
        } else {
            Rgb([0, 1, 2].map(|c: usize| a[c].abs_diff(b[c]).saturating_mul(8)))
        };
    }
    let mut named = Vec::new();
    for (what, picture) in [
        ("expected", expected),
        ("actual", actual),
        ("difference", &difference),
    ] {
        let path = folder.join(format!("{name}-{what}.png"));
        save(picture, &path)?;
        named.push(format!("  {}", path.display()));
    }
    Ok(named.join("\n"))
}

fn failure_folder() -> PathBuf {
    // Cargo gives tests a folder in the target folder in use.
    Path::new(env!("CARGO_TARGET_TMPDIR"))
        .parent()
        .map_or_else(|| package().join("target"), Path::to_path_buf)
        .join("image-failures")
}

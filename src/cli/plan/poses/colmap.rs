//! Cameras of a COLMAP reconstruction: `images.txt` and `cameras.txt`, or `images.bin` and `cameras.bin`, side by side, as
//! <https://colmap.github.io/format.html> describes them.
//!
//! A rotation and a translation map the scene to the space of a camera that looks along z, with y down.

use super::{Frame, Lens, MAX_POSES, lens::Model};
use crate::{
    error::{LoadError, SourcePos, clip, clip_path, io_reason},
    format::open_file,
};
use glam::{DMat3, DQuat, DVec3};
use std::{
    collections::HashMap,
    fs::File,
    io::{self, BufRead, BufReader, Read},
    path::{Path, PathBuf},
    sync::Arc,
};

/// The longest line or name, bytes. The points of an image are in a line that may be longer: only its beginning is read.
const MOST_BYTES: u64 = 1 << 16;

/// How much of a line of points is read, bytes.
const BEGINNING: u64 = 1 << 10;

/// The most cameras.
const MAX_CAMERAS: u64 = 1 << 20;

/// The models of cameras, by their numbers: how many parameters each has, and whether one focal length is for both axes.
const MODELS: [(&str, usize, bool); 17] = [
    ("SIMPLE_PINHOLE", 3, true),
    ("PINHOLE", 4, false),
    ("SIMPLE_RADIAL", 4, true),
    ("RADIAL", 5, true),
    ("OPENCV", 8, false),
    ("OPENCV_FISHEYE", 8, false),
    ("FULL_OPENCV", 12, false),
    ("FOV", 5, false),
    ("SIMPLE_RADIAL_FISHEYE", 4, true),
    ("RADIAL_FISHEYE", 5, true),
    ("THIN_PRISM_FISHEYE", 12, false),
    ("RAD_TAN_THIN_PRISM_FISHEYE", 16, false),
    ("SIMPLE_DIVISION", 4, true),
    ("DIVISION", 5, false),
    ("SIMPLE_FISHEYE", 3, true),
    ("FISHEYE", 4, false),
    ("EUCM", 6, false),
];

/// The model behind the last of [`MODELS`], whose parameters are a width and a height.
const PANORAMA: &str = "EQUIRECTANGULAR";

/// An image: where its camera stands.
struct Image {
    name: String,
    rotation: [f64; 4],
    translation: [f64; 3],
    camera: u32,
}

/// Whether this is the list of images of a reconstruction.
pub(super) fn is_images(path: &Path) -> bool {
    path.file_name()
        .is_some_and(|name| name == "images.txt" || name == "images.bin")
}

/// The list of images in a folder, or `path` itself.
///
/// # Errors
/// [`LoadError`] for a folder without images, and for a file of a reconstruction that has other contents.
pub(super) fn images_in(path: &Path) -> Result<PathBuf, LoadError> {
    if path.is_dir() {
        let mut names = ["images.bin", "images.txt"].iter().map(|name| path.join(name));
        return names.find(|images| images.is_file()).ok_or_else(|| {
            let why =
                "this is a directory without images.bin or images.txt of COLMAP: name a NeRF transforms.json";
            LoadError::whole_file(path, why)
        });
    }
    let stem = path.file_stem().and_then(|stem| stem.to_str());
    let extension = path.extension().and_then(|extension| extension.to_str());
    match (stem, extension) {
        (Some("cameras" | "points3D" | "rigs" | "frames"), Some(extension @ ("bin" | "txt"))) => {
            let why = format!("this file of COLMAP has no poses: name images.{extension}");
            Err(LoadError::whole_file(path, why))
        }
        _ => Ok(path.to_owned()),
    }
}

/// The file of cameras that belongs to a list of images.
pub(super) fn cameras_beside(images: &Path) -> PathBuf {
    images.with_file_name(if is_binary(images) {
        "cameras.bin"
    } else {
        "cameras.txt"
    })
}

fn is_binary(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "bin")
}

/// Reads the images of a reconstruction, in the order of their names.
pub(super) fn frames(path: &Path) -> Result<Vec<Frame>, LoadError> {
    let (is_binary, beside) = (is_binary(path), cameras_beside(path));
    let lenses = if is_binary {
        binary::cameras(&mut Records::open(&beside)?)
    } else {
        text::cameras(&mut Lines::open(&beside)?)
    }?;
    let mut images = if is_binary {
        binary::images(&mut Records::open(path)?)
    } else {
        text::images(&mut Lines::open(path)?)
    }?;
    images.sort_by(|a, b| a.name.cmp(&b.name));
    let frame = |image: Image| {
        let Some(lens) = lenses.get(&image.camera) else {
            let why = format!(
                "{}: no camera {} in {}",
                image.name,
                image.camera,
                clip_path(&beside)
            );
            return Err(LoadError::whole_file(path, why));
        };
        if image.rotation == [0.0; 4] {
            let why = format!("{}: its rotation is 0 0 0 0, expected a quaternion", image.name);
            return Err(LoadError::whole_file(path, why));
        }
        Ok(image.frame(lens.clone()))
    };
    images.into_iter().map(frame).collect()
}

impl Image {
    /// The pose as in a NeRF file: from a camera that looks along -z, with y up, to the scene.
    fn frame(self, lens: Lens) -> Frame {
        let [w, x, y, z] = self.rotation;
        let to_scene = DMat3::from_quat(DQuat::from_xyzw(x, y, z, w).normalize()).transpose();
        let eye = -(to_scene * DVec3::from_array(self.translation));
        let (right, up, back) = (to_scene.x_axis, -to_scene.y_axis, -to_scene.z_axis);
        let row = |i: usize| [right[i], up[i], back[i], eye[i]];
        Frame {
            file_path: self.name,
            transform_matrix: vec![row(0), row(1), row(2)],
            lens,
        }
    }
}

/// Why a camera of a model with this name or number is refused.
fn unknown_model(model: &str) -> String {
    if model.trim_matches('`') == PANORAMA {
        format!("{PANORAMA} has no focal length, expected a perspective camera, such as PINHOLE")
    } else {
        format!("unknown camera model {model}, expected one that octray knows, such as PINHOLE")
    }
}

/// The lens of a camera of `model`.
fn lens(model: usize, size: [f64; 2], numbers: &[f64]) -> Lens {
    let (name, _, is_simple) = MODELS[model];
    let (fl_x, fl_y) = (numbers[0], numbers[usize::from(!is_simple)]);
    let rest = &numbers[if is_simple { 1 } else { 2 }..];
    let model = Model::of_colmap(name, &rest[2..]);
    Lens::of_pixels([fl_x, fl_y], [rest[0], rest[1]], size, model)
}

fn open(path: &Path) -> Result<BufReader<File>, LoadError> {
    let opened = open_file(path).map(BufReader::new);
    opened.map_err(|error| LoadError::whole_file(path, io_reason(&error)))
}

/// The lines of a text.
struct Lines {
    path: Arc<PathBuf>,
    reader: BufReader<File>,
    /// Bytes that are no UTF-8 are replaced, as in names of binary files.
    line: String,
    number: u32,
}

impl Lines {
    fn open(path: &Path) -> Result<Self, LoadError> {
        Ok(Self {
            path: Arc::new(path.to_path_buf()),
            reader: open(path)?,
            line: String::new(),
            number: 0,
        })
    }

    /// A fault of the current line, at this byte of it.
    fn fault(&self, offset: usize, message: impl AsRef<str>) -> LoadError {
        let at = SourcePos {
            file: Arc::clone(&self.path),
            line: self.number,
            column: offset as u32 + 1,
        };
        LoadError::new(at, message)
    }

    /// Moves to the next line that is neither empty nor a comment; false at the end.
    fn next(&mut self) -> Result<bool, LoadError> {
        loop {
            self.number = self.number.saturating_add(1);
            let mut line = Vec::new();
            let mut rest = self.reader.by_ref().take(MOST_BYTES + 1);
            let count = rest.read_until(b'\n', &mut line);
            let count = count.map_err(|error| self.fault(0, error.to_string()))?;
            if count as u64 > MOST_BYTES {
                return Err(self.fault(0, format!("a line of more than {MOST_BYTES} bytes")));
            }
            // A byte order mark.
            if self.number == 1 && line.starts_with(b"\xef\xbb\xbf") {
                line.drain(..3);
            }
            self.line = String::from_utf8_lossy(&line).into_owned();
            let text = self.line.trim_ascii();
            if count == 0 {
                return Ok(false);
            }
            if !text.is_empty() && !text.starts_with('#') {
                return Ok(true);
            }
        }
    }

    /// Moves behind the next line, of any length, and keeps the words of its beginning. Says whether these are all.
    fn skip(&mut self) -> Result<bool, LoadError> {
        self.number = self.number.saturating_add(1);
        let mut line = Vec::new();
        let mut beginning = self.reader.by_ref().take(BEGINNING);
        let read = beginning.read_until(b'\n', &mut line);
        let is_cut = line.len() as u64 == BEGINNING && !line.ends_with(b"\n");
        let skipped = read.and_then(|_| {
            if is_cut {
                self.reader.skip_until(b'\n')
            } else {
                Ok(0)
            }
        });
        skipped.map_err(|error| self.fault(0, error.to_string()))?;
        if is_cut {
            // The last word may be a part of one.
            let end = line.iter().rposition(u8::is_ascii_whitespace);
            line.truncate(end.unwrap_or(0));
        }
        self.line = String::from_utf8_lossy(&line).into_owned();
        Ok(!is_cut)
    }

    /// The words of the current line, each with its place. The last of `most` holds all that is left.
    fn words(&self, most: usize) -> Vec<(usize, &str)> {
        let text = &self.line[..];
        let mut words = Vec::new();
        let mut at = 0;
        while let Some(start) = text[at..].find(|c: char| !c.is_ascii_whitespace()) {
            let start = at + start;
            let rest = text[start..].trim_ascii_end();
            let length = rest.find(|c: char| c.is_ascii_whitespace());
            let length = length.filter(|_| words.len() + 1 < most).unwrap_or(rest.len());
            words.push((start, &text[start..start + length]));
            at = start + length;
        }
        words
    }

    /// The numbers that words are.
    fn numbers(&self, words: &[(usize, &str)]) -> Result<Vec<f64>, LoadError> {
        let number = |&(at, word): &(usize, &str)| {
            let number = word.parse().ok().filter(|number: &f64| number.is_finite());
            number.ok_or_else(|| self.fault(at, format!("found `{word}`, expected a number")))
        };
        words.iter().map(number).collect()
    }

    /// The id that a word is.
    fn id(&self, (at, word): (usize, &str)) -> Result<u32, LoadError> {
        let id = word.parse().ok();
        id.ok_or_else(|| self.fault(at, format!("found `{word}`, expected the number of a camera")))
    }
}

mod text {
    use super::{HashMap, Image, Lens, Lines, LoadError, MAX_CAMERAS, MAX_POSES, MODELS, clip};

    /// `CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]`
    pub(super) fn cameras(lines: &mut Lines) -> Result<HashMap<u32, Lens>, LoadError> {
        let mut lenses = HashMap::new();
        while lines.next()? {
            let words = lines.words(usize::MAX);
            let [id, model, size @ ..] = &words[..] else {
                return Err(lines.fault(0, "expected a camera: number, model, width, height, parameters"));
            };
            let known = MODELS.iter().position(|(name, ..)| *name == model.1);
            let Some(known) = known else {
                return Err(lines.fault(model.0, super::unknown_model(&format!("`{}`", model.1))));
            };
            let numbers = lines.numbers(size)?;
            let (name, count, _) = MODELS[known];
            let [width, height, parameters @ ..] = &numbers[..] else {
                return Err(lines.fault(model.0, "expected a width and a height after the model"));
            };
            if parameters.len() != count {
                let found = parameters.len();
                let why = format!("{name} has {found} parameters, expected {count}");
                return Err(lines.fault(model.0, why));
            }
            if *width <= 0.0 || *height <= 0.0 {
                let why = format!("found a picture of {width}x{height}, expected pixels");
                return Err(lines.fault(model.0 + model.1.len() + 1, why));
            }
            let lens = super::lens(known, [*width, *height], parameters);
            lenses.insert(lines.id(*id)?, lens);
            if lenses.len() as u64 > MAX_CAMERAS {
                return Err(lines.fault(0, format!("more than {MAX_CAMERAS} cameras")));
            }
        }
        Ok(lenses)
    }

    /// `IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME`, then a line of points.
    pub(super) fn images(lines: &mut Lines) -> Result<Vec<Image>, LoadError> {
        let mut images = Vec::new();
        while lines.next()? {
            let words = lines.words(10);
            let [_, pose @ .., camera, name] = &words[..] else {
                return Err(lines.fault(0, EXPECTED));
            };
            let numbers = lines.numbers(pose)?;
            let &[qw, qx, qy, qz, x, y, z] = &numbers[..] else {
                return Err(lines.fault(0, EXPECTED));
            };
            images.push(Image {
                name: name.1.to_owned(),
                rotation: [qw, qx, qy, qz],
                translation: [x, y, z],
                camera: lines.id(*camera)?,
            });
            if images.len() > MAX_POSES {
                return Err(lines.fault(0, format!("more than {MAX_POSES} images")));
            }
            let is_whole = lines.skip()?;
            if !is_points(&lines.words(usize::MAX), is_whole) {
                let name = images.last().map_or("", |image| &image.name);
                let why = format!(
                    "expected the line of points of {}, which may be empty",
                    clip(name)
                );
                return Err(lines.fault(0, why));
            }
        }
        Ok(images)
    }

    /// Whether the words of a line, or those of its beginning, are points: `X Y POINT3D_ID` each.
    fn is_points(words: &[(usize, &str)], is_whole: bool) -> bool {
        let is_part = |(i, (_, word)): (usize, &(usize, &str))| {
            let number = word.parse::<f64>().ok();
            number.is_some_and(|number| i % 3 < 2 || number.fract() == 0.0)
        };
        words.iter().enumerate().all(is_part) && (!is_whole || words.len().is_multiple_of(3))
    }

    const EXPECTED: &str = "expected an image: number, rotation (w x y z), translation, camera, name";
}

/// The records of a binary file.
struct Records {
    path: PathBuf,
    reader: BufReader<File>,
}

impl Records {
    fn open(path: &Path) -> Result<Self, LoadError> {
        Ok(Self {
            path: path.to_path_buf(),
            reader: open(path)?,
        })
    }

    fn fault(&self, message: impl AsRef<str>) -> LoadError {
        LoadError::whole_file(&self.path, message)
    }

    fn bytes<const N: usize>(&mut self) -> Result<[u8; N], LoadError> {
        let mut bytes = [0; N];
        let read = self.reader.read_exact(&mut bytes);
        read.map_err(|_| self.fault("the file ends early"))?;
        Ok(bytes)
    }

    fn u32(&mut self) -> Result<u32, LoadError> {
        self.bytes().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Result<u64, LoadError> {
        self.bytes().map(u64::from_le_bytes)
    }

    fn numbers<const N: usize>(&mut self) -> Result<[f64; N], LoadError> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = self.bytes().map(f64::from_le_bytes)?;
            if !number.is_finite() {
                return Err(self.fault(format!("found {number}, expected a finite number")));
            }
        }
        Ok(numbers)
    }

    fn name(&mut self) -> Result<String, LoadError> {
        let mut name = Vec::new();
        let read = self.reader.by_ref().take(MOST_BYTES).read_until(0, &mut name);
        read.map_err(|error| self.fault(error.to_string()))?;
        if name.pop() != Some(0) {
            return Err(self.fault("a name without an end"));
        }
        Ok(String::from_utf8_lossy(&name).into_owned())
    }

    /// Skips bytes that may not be there: a read behind them fails.
    fn skip(&mut self, bytes: u64) -> Result<(), LoadError> {
        let skipped = io::copy(&mut self.reader.by_ref().take(bytes), &mut io::sink());
        match skipped {
            Ok(count) if count == bytes => Ok(()),
            _ => Err(self.fault("the file ends early")),
        }
    }
}

mod binary {
    use super::{HashMap, Image, Lens, LoadError, MAX_CAMERAS, MAX_POSES, MODELS, PANORAMA, Records};

    /// Bytes of a point of an image.
    const POINT: u64 = 24;

    pub(super) fn cameras(records: &mut Records) -> Result<HashMap<u32, Lens>, LoadError> {
        let count = records.u64()?;
        if count > MAX_CAMERAS {
            return Err(records.fault(format!("{count} cameras, expected at most {MAX_CAMERAS}")));
        }
        let mut lenses = HashMap::new();
        for _ in 0..count {
            let (id, model) = (records.u32()?, records.u32()? as usize);
            let [width, height] = [records.u64()?, records.u64()?];
            let Some(&(_, count, _)) = MODELS.get(model) else {
                let name = if model == MODELS.len() {
                    format!("`{PANORAMA}`")
                } else {
                    model.to_string()
                };
                return Err(records.fault(format!("camera {id}: {}", super::unknown_model(&name))));
            };
            if width == 0 || height == 0 {
                let why = format!("camera {id}: found a picture of {width}x{height}, expected pixels");
                return Err(records.fault(why));
            }
            let [first, second, third] = records.numbers()?;
            let mut parameters = vec![first, second, third];
            for _ in 3..count {
                let [parameter] = records.numbers()?;
                parameters.push(parameter);
            }
            lenses.insert(id, super::lens(model, [width as f64, height as f64], &parameters));
        }
        Ok(lenses)
    }

    pub(super) fn images(records: &mut Records) -> Result<Vec<Image>, LoadError> {
        let count = records.u64()?;
        if count > MAX_POSES as u64 {
            return Err(records.fault(format!("{count} images, expected at most {MAX_POSES}")));
        }
        let mut images = Vec::new();
        for _ in 0..count {
            records.u32()?;
            let image = Image {
                rotation: records.numbers()?,
                translation: records.numbers()?,
                camera: records.u32()?,
                name: records.name()?,
            };
            images.push(image);
            let points = records.u64()?;
            records.skip(points.saturating_mul(POINT))?;
        }
        Ok(images)
    }
}

#[cfg(test)]
mod tests;

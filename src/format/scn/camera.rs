//! The statement `camera`.

use super::{
    Place, Reader,
    arguments::Arguments,
    at::{self, Moved, MovedThing},
    statements::again,
    words::Word,
};
use crate::{
    error::{LoadError, quote},
    format::mesh::{MAX_CAMERA_NAME, MAX_CAMERAS},
    scene::{Camera, CameraError, CameraMotion, Lens, NamedCamera, Projection, View},
};
use glam::DVec3;

const KEYS: [&str; 7] = ["eye", "target", "up", "fov", "ortho", "aperture", "focus"];

/// Where to place errors about the view: the words that it was read from.
#[derive(Default)]
struct Places<'a> {
    target: Option<Word<'a>>,
    up: Option<Word<'a>>,
    projection: Option<Word<'a>>,
    aperture: Option<Word<'a>>,
    focus: Option<Word<'a>>,
}

impl<'a> Places<'a> {
    fn of(&self, error: CameraError) -> Option<Word<'a>> {
        match error {
            CameraError::FieldOfView(_)
            | CameraError::ViewHeight(_)
            | CameraError::PrincipalOffset(_)
            | CameraError::PixelAspect(_)
            | CameraError::Distortion(_)
            | CameraError::DistortedProjection => self.projection,
            CameraError::UpParallel => self.up.or(self.target),
            CameraError::EyeOnTarget | CameraError::NotFinite | CameraError::NoKeyframes => self.target,
            CameraError::Aperture(_) => self.aperture,
            CameraError::Focus(_) => self.focus,
        }
    }
}

impl Reader<'_> {
    pub(super) fn camera(&mut self, mut arguments: Arguments<'_, '_>) -> Result<(), LoadError> {
        arguments.needs = &["eye", "target"];
        let name = camera_name(&mut arguments, &KEYS)?;
        let is_plain = name.is_some_and(|name| !name.quoted);
        let next = arguments.peek().map_or(&b""[..], |next| next.text);
        if is_plain && !KEYS.iter().any(|key| key.as_bytes() == next) {
            arguments.hint = " (put double quotes around a name with spaces)";
        }
        let end = name.unwrap_or(arguments.keyword).end();
        let (view, places) = view(&mut arguments, end, None)?;
        let moves = at::follows(arguments.line.rest);
        let mut lens = MovingLens::default();
        lens.add(&arguments, &places);
        if !moves {
            lens.check()?;
        }
        let camera = checked(&arguments, &view, &places)?;
        let name = name.map(|word| String::from_utf8_lossy(word.text).into_owned());
        if let Some(first) = self.seen.cameras.get(&name) {
            let what = name.map_or_else(
                || "camera without a name".to_owned(),
                |name| format!("camera {}", quote(name.as_bytes())),
            );
            return Err(again(&arguments, &what, first));
        }
        if self.seen.cameras.len() >= MAX_CAMERAS {
            let message = format!("more than {MAX_CAMERAS} cameras in one scene");
            return Err(arguments.line.too_many(&arguments.keyword, message));
        }
        self.seen.cameras.insert(name.clone(), Place::of(&arguments));
        if moves {
            let what = MovedThing::Camera {
                name,
                view: Box::new(view),
                motion: CameraMotion::default(),
                lens,
            };
            self.moved = Some(Moved::new(what, arguments.line, &arguments.keyword));
        } else {
            self.builder.add_camera(NamedCamera { name, camera });
        }
        Ok(())
    }
}

/// The lens of a camera, whose line and keyframes may say its parts.
#[derive(Default)]
pub(super) struct MovingLens {
    has_aperture: bool,
    /// The error about the first `focus` if there is no `aperture`.
    lonely_focus: Option<LoadError>,
}

impl MovingLens {
    fn add(&mut self, arguments: &Arguments<'_, '_>, places: &Places<'_>) {
        self.has_aperture |= places.aperture.is_some();
        if let (Some(focus), None) = (places.focus, &self.lonely_focus) {
            let message = "`focus` without `aperture`, the diameter of the lens";
            self.lonely_focus = Some(arguments.line.error_at(&focus, message));
        }
    }

    /// Refuses a `focus` without an `aperture`.
    pub(super) fn check(&mut self) -> Result<(), LoadError> {
        let lonely = self.lonely_focus.take().filter(|_| !self.has_aperture);
        lonely.map_or(Ok(()), Err)
    }
}

/// The view of a keyframe: that of the camera's line, with the given keys replaced.
pub(super) fn keyframe(
    arguments: &mut Arguments<'_, '_>,
    own: &View,
    lens: &mut MovingLens,
) -> Result<View, LoadError> {
    let end = arguments.keyword.end();
    let (view, places) = view(arguments, end, Some(own))?;
    checked(arguments, &view, &places)?;
    lens.add(arguments, &places);
    Ok(view)
}

/// The camera of a view.
fn checked(arguments: &Arguments<'_, '_>, view: &View, places: &Places<'_>) -> Result<Camera, LoadError> {
    Camera::new(view).map_err(|error| {
        let word = places.of(error).unwrap_or(arguments.keyword);
        arguments.line.error_at(&word, error.to_string())
    })
}

/// Reads the keys; `end` is where the words before them end. Missing keys are taken from `own`, if there is one.
fn view<'a>(
    arguments: &mut Arguments<'_, 'a>,
    mut end: usize,
    own: Option<&View>,
) -> Result<(View, Places<'a>), LoadError> {
    let (mut eye, mut target) = (own.map(|own| own.eye), own.map(|own| own.target));
    let (mut up, mut projection, mut lens) = own
        .map_or((View::UP, Projection::DEFAULT, Lens::PINHOLE), |own| {
            (own.up, own.projection, own.lens)
        });
    let mut places = Places::default();
    while let Some((word, key)) = arguments.key_once(&KEYS)? {
        if let "eye" | "target" | "up" = key {
            let words = arguments.take(word, &format!("{key} x y z"))?;
            let vector = arguments.vector(words)?;
            end = words[2].end();
            match key {
                "eye" => eye = Some(vector),
                "target" => (target, places.target) = (Some(vector), Some(word)),
                _ => (up, places.up) = (vector, Some(word)),
            }
            continue;
        }
        let usage = if key == "fov" { "DEG" } else { "number" };
        let [value] = arguments.take(word, &format!("{key} {usage}"))?;
        let number = arguments.precise(value, key)?;
        end = value.end();
        match key {
            "aperture" => (lens.aperture, places.aperture) = (number, Some(value)),
            "focus" => (lens.focus, places.focus) = (Some(number), Some(value)),
            _ if places.projection.is_some() => {
                let message = "both `fov` and `ortho` in this line, expected one of them";
                return Err(arguments.line.error_at(&word, message));
            }
            _ => {
                places.projection = Some(value);
                projection = if key == "fov" {
                    Projection::Perspective { fov_degrees: number }
                } else {
                    Projection::Orthographic { height: number }
                };
            }
        }
    }
    let eye = eye.ok_or_else(|| arguments.missing("eye", end))?;
    let target: DVec3 = target.ok_or_else(|| arguments.missing("target", end))?;
    let view = View {
        eye,
        target,
        up,
        projection,
        lens,
    };
    Ok((view, places))
}

/// The name of a camera, if the next word is one.
fn camera_name<'a>(
    arguments: &mut Arguments<'_, 'a>,
    keys: &[&'static str],
) -> Result<Option<Word<'a>>, LoadError> {
    let Some(word) = arguments.peek() else {
        return Ok(None);
    };
    if !word.quoted && keys.iter().any(|key| key.as_bytes() == word.text) {
        return Ok(None);
    }
    // Followed by a number, it is a misspelt key, not a name.
    let number_follows = arguments
        .peek_second()
        .is_some_and(|next| arguments.precise(next, "").is_ok());
    if !word.quoted && number_follows {
        return arguments.key(keys).map(|_| None);
    }
    let faulty = |message: String| Err(arguments.line.error_at(&word, message));
    match word.as_str() {
        None => faulty(format!("name {} is not valid UTF-8", quote(word.text))),
        Some(name) if name.trim().is_empty() => {
            faulty("the name is empty; give the camera a name, or leave the name out".into())
        }
        Some(name) if name.len() > MAX_CAMERA_NAME => faulty(format!(
            "name of {} bytes, expected at most {MAX_CAMERA_NAME}",
            name.len()
        )),
        Some(_) => Ok(arguments.next()),
    }
}

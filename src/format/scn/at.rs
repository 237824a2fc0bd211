//! Keyframes: `at T ...` below an `instance` or a `camera`.

use super::{
    Reader,
    arguments::Arguments,
    camera::{self, MovingLens},
    line::Line,
    mesh,
    words::Word,
};
use crate::{
    error::{LoadError, SceneError, SourcePos},
    scene::{CameraMotion, MAX_KEYFRAMES, Motion, PrototypeId, Transform, View},
};
use std::ops::Range;

/// The statement above keyframes, which is added to the scene after they have been read.
pub(super) struct Moved {
    pub(super) what: MovedThing,
    /// The place of errors about all keyframes together.
    at: SourcePos,
    line: Vec<u8>,
    word: Range<usize>,
    /// The error if there is no second keyframe.
    lonely: Option<LoadError>,
}

pub(super) enum MovedThing {
    Instances {
        prototype: PrototypeId,
        /// Placements before the motion.
        transforms: Vec<Transform>,
        motion: Motion,
    },
    Camera {
        name: Option<String>,
        view: Box<View>,
        motion: CameraMotion,
        lens: MovingLens,
    },
}

impl Moved {
    pub(super) fn new(what: MovedThing, line: &Line<'_>, word: &Word<'_>) -> Self {
        Self {
            what,
            at: line.at(word.start),
            line: line.bytes.to_vec(),
            word: word.start..word.end(),
            lonely: None,
        }
    }
}

/// Whether the next statement of a text is a keyframe.
pub(super) fn follows(rest: &[u8]) -> bool {
    let lines = rest.split(|&byte| byte == b'\n').map(<[u8]>::trim_ascii);
    let mut statements = lines.filter(|line| !line.is_empty() && !line.starts_with(b"//"));
    let behind = statements.next().and_then(|line| line.strip_prefix(b"at"));
    behind.is_some_and(|behind| match behind {
        [] => true,
        [first, ..] => first.is_ascii_whitespace() || behind.starts_with(b"//"),
    })
}

impl Reader<'_> {
    /// `at T ...`: a keyframe of the instance or camera above.
    pub(super) fn at(&mut self, mut arguments: Arguments<'_, '_>) -> Result<(), LoadError> {
        let line = arguments.line;
        let Some(mut moved) = self.moved.take() else {
            let above = match self.last_statement {
                "" => "nothing is above it".into(),
                last => format!("`{last}` does not move"),
            };
            let message = format!("`at` without an `instance` or `camera` above it: {above}");
            return Err(line.error_at(&arguments.keyword, message));
        };
        let [time] = arguments.leading()?;
        let number = arguments.precise(time, "the time")?;
        if self.keyframes >= MAX_KEYFRAMES {
            let message = format!("more than {MAX_KEYFRAMES} keyframes in one scene");
            return Err(line.too_many(&arguments.keyword, message));
        }
        self.keyframes += 1;
        let (count, fits) = match &moved.what {
            MovedThing::Instances { motion, .. } => (motion.times().len(), motion.check_time(number)),
            MovedThing::Camera { motion, .. } => (motion.times().len(), motion.check_time(number)),
        };
        fits.map_err(|error| line.error_at(&time, error.to_string()).with_kind((&error).into()))?;
        let behind = arguments.peek().unwrap_or(time);
        let added = match &mut moved.what {
            MovedThing::Instances { motion, .. } => motion.add(number, mesh::read_steps(&mut arguments)?),
            MovedThing::Camera {
                view, motion, lens, ..
            } => motion.add(number, camera::keyframe(&mut arguments, view, lens)?),
        };
        added.map_err(|error| {
            line.error_at(&behind, error.to_string())
                .with_kind((&error).into())
        })?;
        moved.lonely = (count == 0).then(|| {
            let message = "only one keyframe, expected another `at` below it: motion needs two";
            line.error_at(&arguments.keyword, message)
        });
        self.moved = Some(moved);
        Ok(())
    }

    /// Adds the moving instances or camera after the keyframes have been read.
    pub(super) fn end_motion(&mut self) -> Result<(), LoadError> {
        let Some(moved) = self.moved.take() else {
            return Ok(());
        };
        let Moved {
            what,
            at,
            line,
            word,
            lonely,
        } = moved;
        if let Some(lonely) = lonely {
            return Err(lonely);
        }
        let place = Some(at.clone());
        let added = match what {
            MovedThing::Instances {
                prototype,
                transforms,
                motion,
            } => self
                .builder
                .add_moving_instances(prototype, transforms, motion, place),
            MovedThing::Camera {
                name,
                motion,
                mut lens,
                ..
            } => {
                lens.check()?;
                self.builder.add_moving_camera_of(name, motion, place)
            }
        };
        added.map_err(|error| {
            let message = match error {
                SceneError::AtTime { time, why, .. } => format!("cannot be placed at {time}: {why}"),
                error => format!("cannot be placed: {error}"),
            };
            LoadError::new(at, message).with_line(&line, word)
        })
    }
}

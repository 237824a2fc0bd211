//! Plays the frames of an animated scene or mesh, in real time.

use super::{pose::Pose, timeline::Timeline, window::App};
use std::{
    sync::Arc,
    time::{Duration, Instant},
};

/// The current frame. Frames count from 1, and the first follows the last.
#[derive(Clone, Copy, Debug)]
pub struct Playback {
    frame: u32,
    count: u32,
    /// Frames per second.
    fps: u32,
    /// If it plays: since when, and how many frames ago that was.
    since: Option<(Instant, u64)>,
    /// Whether the last step went back.
    is_back: bool,
    /// The frame to which the last step led if it cannot be shown: the next step that way goes past it.
    failed: Option<u32>,
}

impl Playback {
    /// Begins at the first of `count` frames, stopped.
    #[must_use]
    pub fn new(count: u32, fps: u32) -> Self {
        Self {
            frame: 1,
            count,
            fps,
            since: None,
            is_back: false,
            failed: None,
        }
    }

    /// Returns the frame.
    #[must_use]
    pub fn frame(&self) -> u32 {
        self.frame
    }

    /// Whether there is more than one frame.
    #[must_use]
    pub fn moves(&self) -> bool {
        self.count > 1
    }

    /// Sets the number of frames of a scene that is loaded again.
    pub fn set_count(&mut self, count: u32) {
        self.count = count;
        self.failed = None;
        self.frame = self.frame.min(count);
        if !self.moves() {
            self.since = None;
        }
    }

    /// Plays or stops.
    pub fn toggle(&mut self, now: Instant) {
        self.since = match self.since {
            None if self.moves() => Some((now, 0)),
            _ => None,
        };
    }

    /// Stops.
    pub fn stop(&mut self) {
        self.since = None;
    }

    /// Stops at the frame that is shown, because another one `failed`.
    pub fn stop_at(&mut self, shown: u32, failed: u32) {
        self.stop();
        self.frame = shown.clamp(1, self.count.max(1));
        self.failed = Some(failed);
    }

    /// Whether it plays.
    #[must_use]
    pub fn plays(&self) -> bool {
        self.since.is_some()
    }

    /// Stops, and moves on by `steps` frames, or back if negative.
    pub fn step(&mut self, steps: i64) {
        self.stop();
        let is_back = steps < 0;
        let failed = self.failed.take().filter(|_| is_back == self.is_back);
        self.is_back = is_back;
        let frame = i64::from(failed.unwrap_or(self.frame)) - 1 + steps;
        self.frame = frame.rem_euclid(self.count.into()) as u32 + 1;
    }

    /// Moves on to the frame of this time. Returns whether it is another one.
    pub fn go_on(&mut self, now: Instant) -> bool {
        let Some((since, done)) = self.since else {
            return false;
        };
        let frames = (now.saturating_duration_since(since).as_secs_f64() * f64::from(self.fps)) as u64;
        if frames <= done {
            return false;
        }
        self.step(((frames - done) % u64::from(self.count)) as i64);
        self.since = Some((since, frames));
        true
    }

    /// Returns when the next frame is due.
    #[must_use]
    pub fn next(&self) -> Option<Instant> {
        let (since, done) = self.since?;
        // Rounded up to a microsecond, so that the frame is due then.
        let micros = ((done + 1) * 1_000_000).div_ceil(self.fps.into()) + 1;
        since.checked_add(Duration::from_micros(micros))
    }
}

/// What the animation of a mesh does once it is loaded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Awaited {
    /// It plays.
    Play,
    /// It stands this many frames after the first.
    Step(i64),
}

impl Awaited {
    /// What follows when a key asks for more before it is loaded.
    #[must_use]
    pub fn and(self, then: Self) -> Self {
        match (self, then) {
            (Self::Step(first), Self::Step(more)) => Self::Step(first.saturating_add(more)),
            // The space bar again: stop.
            (Self::Play, Self::Play) => Self::Step(0),
            (_, then) => then,
        }
    }
}

impl App {
    /// Plays the scene, or stops.
    pub(super) fn play(&mut self) {
        if self.has_frames(Awaited::Play) {
            self.playback.toggle(Instant::now());
        }
    }

    /// Stops at another frame.
    pub(super) fn step(&mut self, steps: i64) {
        if self.has_frames(Awaited::Step(steps)) {
            self.playback.step(steps);
            self.show_frame();
        }
    }

    /// Whether there are frames. Those of a mesh are loaded first; `then` follows.
    fn has_frames(&mut self, then: Awaited) -> bool {
        let moves = self.playback.moves();
        if let (false, Some(reload)) = (moves, &self.reload) {
            if let Some(before) = self.awaited {
                self.awaited = Some(before.and(then));
                return false;
            }
            match self.host.animate() {
                Ok(true) => {
                    reload.ask();
                    self.awaited = Some(then);
                    self.say("loading the animation");
                }
                Ok(false) => self.say("no keyframes: nothing moves"),
                Err(why) => self.say(why),
            }
        }
        moves
    }

    /// Shows the frames of a scene that is loaded again.
    pub(super) fn take_timeline(&mut self, timeline: Arc<Timeline>) {
        self.playback.set_count(timeline.count());
        self.timeline = timeline;
        // A load that began before an animation was asked for has none.
        match self.awaited.take_if(|_| self.timeline.is_played()) {
            Some(Awaited::Play) => self.playback.toggle(Instant::now()),
            Some(Awaited::Step(steps)) => self.playback.step(steps),
            None => {}
        }
    }

    /// Shows the frame that is due.
    pub(super) fn play_on(&mut self, now: Instant) {
        if self.playback.go_on(now) {
            self.show_frame();
        }
    }

    /// Shows the frame. The camera follows that of the scene, unless it was moved.
    pub(super) fn show_frame(&mut self) {
        let frame = self.playback.frame();
        if let Some(pose) = self.host.camera(&self.timeline.now().scene, frame) {
            self.go_home(pose);
        }
        self.stuck = None;
        self.ask();
    }

    /// Goes back to the frame that is shown, because another one cannot be.
    pub(super) fn go_back(&mut self, frame: u32, why: &str) {
        // It may have been left by a step while it was loaded.
        if !self.playback.plays() && self.playback.frame() != frame {
            return;
        }
        self.playback.stop_at(self.timeline.now().frame(), frame);
        if std::mem::take(&mut self.saves) {
            self.say("not saved");
        }
        self.show_frame();
        self.stuck = Some(format!("frame {frame}: {why}"));
    }

    /// Changes the starting camera, which the camera follows unless it was moved.
    pub(super) fn go_home(&mut self, home: Pose) {
        let follows = self.orbit.pose() == self.home;
        self.home = home;
        if follows {
            self.orbit.go_to(home);
        }
    }
}

#[cfg(test)]
mod tests;

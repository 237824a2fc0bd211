//! Statistics in the title and the overlay.

use super::mailbox::Picture;
use std::time::{Duration, Instant};

/// The shortest time between two titles: people read them, and the window system handles each change.
const TITLE: Duration = Duration::from_millis(250);
/// A longer time than this between two frames means that the camera was at rest.
const PAUSE: Duration = Duration::from_millis(200);

/// Statistics of the frames on the screen.
#[derive(Debug, Default)]
pub struct Status {
    last: Option<Instant>,
    seconds_per_frame: Option<f64>,
    title_at: Option<Instant>,
    /// Millions of rays per second of packets and of single rays, as last measured.
    mrays: [Option<f64>; 2],
}

impl Status {
    /// Records a picture that is on the screen.
    pub fn shown(&mut self, picture: &Picture, now: Instant) {
        let since = self.last.replace(now).map(|last| now - last);
        self.seconds_per_frame = match (since, self.seconds_per_frame) {
            (Some(since), _) if since > PAUSE || picture.samples > 1 => None,
            (Some(since), None) => Some(since.as_secs_f64()),
            (Some(since), Some(old)) => Some(old + 0.1 * (since.as_secs_f64() - old)),
            (None, _) => None,
        };
        if let Some(packets) = picture.packets {
            self.mrays[usize::from(!packets)] = mrays(picture);
        }
    }

    /// Returns the title of the window if it is time for a new one.
    pub fn title(&mut self, name: &str, picture: &Picture, now: Instant) -> Option<String> {
        let soon = self.title_at.is_some_and(|at| now < at + TITLE);
        if soon && !picture.last {
            return None;
        }
        self.title_at = Some(now);
        Some(format!("octray - {name} - {}", self.line(picture)))
    }

    /// Returns frames and rays per second, resolution and samples.
    pub fn line(&self, picture: &Picture) -> String {
        let [width, height] = picture.size;
        let [w, h] = picture.traced;
        let [frame, count] = picture.frame;
        let mut line = String::new();
        if count > 1 {
            line.push_str(&format!("frame {frame}/{count} - "));
        }
        if let Some(seconds) = self.seconds_per_frame {
            line.push_str(&format!("{:.0} fps - ", 1.0 / seconds.max(1e-6)));
        }
        if let Some(mrays) = mrays(picture) {
            // Brute force may be far slower.
            let digits = if mrays < 1.0 { 4 } else { 1 };
            line.push_str(&format!("{mrays:.digits$} Mrays/s - "));
        }
        line.push_str(&format!("{width}x{height}"));
        if !picture.full {
            line.push_str(&format!(" from {w}x{h}"));
        }
        let s = if picture.samples == 1 { "" } else { "s" };
        let most = if picture.adaptive { "up to " } else { "" };
        line.push_str(&format!(" - {most}{} sample{s}", picture.samples));
        if picture.stand_in {
            line.push_str(" - BVH while moving");
        }
        if picture.last {
            line.push_str(" - done");
        }
        line
    }

    /// Returns millions of rays per second of both modes.
    pub fn modes(&self) -> Vec<String> {
        ["packets    ", "single rays"]
            .iter()
            .zip(self.mrays)
            .map(|(name, mrays)| match mrays {
                Some(mrays) => format!("{name} {mrays:8.1} Mrays/s"),
                None => format!("{name}   (press p)"),
            })
            .collect()
    }
}

fn mrays(picture: &Picture) -> Option<f64> {
    let seconds = picture.elapsed.as_secs_f64();
    (seconds > 0.0).then(|| picture.rays as f64 / 1e6 / seconds)
}

#[cfg(test)]
mod tests;

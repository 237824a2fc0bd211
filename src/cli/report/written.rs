//! The closing line: what was written.

use std::time::Duration;

/// The pictures of one scene that were written.
#[derive(Default)]
pub struct Written {
    count: usize,
    first: String,
    last: String,
    time: Duration,
}

impl Written {
    /// Adds a picture, called `name`, and the time that it took.
    pub fn add(&mut self, name: &str, time: Duration) {
        if self.count == 0 {
            name.clone_into(&mut self.first);
        }
        // All frames of an animation have one name.
        self.count += usize::from(name != self.last);
        name.clone_into(&mut self.last);
        self.time += time;
    }

    /// `wrote a.png (512x512, 6 ms)`.
    pub fn line(&self, (width, height): (u32, u32)) -> String {
        let Self {
            count, first, last, ..
        } = self;
        let what = if *count == 1 {
            first.clone()
        } else {
            format!("{count} pictures, {first} to {last}")
        };
        format!("wrote {what} ({width}x{height}, {})\n", duration(self.time))
    }
}

fn duration(time: Duration) -> String {
    let seconds = time.as_secs();
    match seconds {
        0 => format!("{} ms", time.as_millis().max(1)),
        1..60 => format!("{:.1} s", time.as_secs_f64()),
        60..3600 => format!("{}:{:02} min", seconds / 60, seconds % 60),
        _ => format!("{}:{:02} h", seconds / 3600, seconds / 60 % 60),
    }
}

#[cfg(test)]
mod tests;

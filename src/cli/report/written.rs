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
mod tests {
    use super::*;

    #[test]
    fn one_line_for_one_picture_or_many() {
        let mut written = Written::default();
        written.add("a-1.png", Duration::from_micros(6400));
        assert_eq!(written.line((512, 256)), "wrote a-1.png (512x256, 6 ms)\n");
        written.add("a-2.png", Duration::from_millis(300));
        written.add("a-3.png", Duration::from_secs(2));
        assert_eq!(
            written.line((9, 8)),
            "wrote 3 pictures, a-1.png to a-3.png (9x8, 2.3 s)\n"
        );
        for (seconds, expected) in [
            (0.0, "1 ms"),
            (0.9999, "999 ms"),
            (125.0, "2:05 min"),
            (7500.0, "2:05 h"),
        ] {
            assert_eq!(duration(Duration::from_secs_f64(seconds)), expected);
        }
    }
}

//! Numbers of a mesh: what its file has, and what colours mean.

use crate::{
    cli::load::Legend,
    error::clip,
    format::mesh::{Range, Scalar},
};
use serde::Serialize;

/// A number of each vertex or face of a file.
#[derive(Debug, Serialize)]
pub(super) struct ScalarInfo {
    name: String,
    /// `vertices` or `faces`.
    of: &'static str,
    /// The smallest and the largest finite number; null if there is none.
    low: Option<f64>,
    high: Option<f64>,
}

impl ScalarInfo {
    pub(super) fn new(Scalar { name, of, range }: Scalar) -> Self {
        let Range(range) = range;
        Self {
            name,
            of: of.name(),
            low: range.map(|[low, _]| low),
            high: range.map(|[_, high]| high),
        }
    }

    /// `"quality" of vertices, 0 to 2.5`.
    pub(super) fn text(&self) -> String {
        text((&self.name, self.of), (self.low, self.high))
    }
}

impl Legend {
    /// `"quality" of vertices, 0 to 2.5, viridis`.
    pub(super) fn text(&self) -> String {
        let range = text((&self.name, self.of), (self.low, self.high));
        format!("{range}, {}", self.map)
    }
}

fn text((name, of): (&str, &str), range: (Option<f64>, Option<f64>)) -> String {
    let range = match range {
        (Some(low), Some(high)) => format!("{} to {}", short(low), short(high)),
        _ => "no finite number".to_owned(),
    };
    format!("\"{}\" of {of}, {range}", clip(name))
}

/// A number with as many digits as it needs.
fn short(value: f64) -> String {
    /// Whole numbers below this are exact, also as `i64`.
    const WHOLE: f64 = (1_u64 << 53) as f64;
    if value.fract() == 0.0 && value.abs() < WHOLE {
        return (value as i64).to_string();
    }
    let single = value as f32;
    let text = if f64::from(single) == value {
        format!("{single:?}")
    } else {
        format!("{value:?}")
    };
    text.strip_suffix(".0").unwrap_or(&text).to_owned()
}

#[cfg(test)]
mod tests {
    use super::short;

    #[test]
    fn numbers_are_short() {
        let found = [0.1_f32.into(), 0.1, 3.0, -2_147_483_648.0, -1e300, 1e-9].map(short);
        assert_eq!(found, ["0.1", "0.1", "3", "-2147483648", "-1e300", "1e-9"]);
    }
}

//! Sums of numbers without rounding, for exact signs (Shewchuk, *Adaptive Precision Floating-Point Arithmetic and Fast
//! Robust Geometric Predicates*, 1997).

/// A sum without rounding: numbers that do not overlap, the smallest first.
#[derive(Debug, Default)]
pub(crate) struct Expansion(Vec<f64>);

impl Expansion {
    pub fn add(&mut self, number: f64) {
        let mut rest = number;
        self.0.retain_mut(|part| {
            // Knuth's sum of two.
            let sum = rest + *part;
            let of_part = sum - rest;
            *part = (rest - (sum - of_part)) + (*part - of_part);
            rest = sum;
            *part != 0.0
        });
        if rest != 0.0 {
            self.0.push(rest);
        }
    }

    /// The largest part has the sign of the sum.
    #[must_use]
    pub fn sign(&self) -> f64 {
        self.0.last().copied().unwrap_or(0.0)
    }
}

#[cfg(test)]
mod tests;

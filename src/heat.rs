//! Costs as colours: the heat map of `octray render --aov heat` and of the live window.

/// The cost that has the last colour; the scale is logarithmic, from 1.
pub const HOTTEST: u32 = 4096;

/// The colour of a cost, by the viridis colour map (van der Walt and Smith 2015).
pub fn heat(cost: u32) -> [u8; 3] {
    let share = libm::log2(f64::from(cost.max(1))) / libm::log2(f64::from(HOTTEST));
    let color = colorous::VIRIDIS.eval_continuous(share.min(1.0));
    [color.r, color.g, color.b]
}

#[cfg(test)]
mod tests;

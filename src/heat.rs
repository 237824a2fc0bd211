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
mod tests {
    use super::*;

    #[test]
    fn heat_runs_from_1_to_the_hottest() {
        assert_eq!(heat(0), heat(1));
        assert_eq!(heat(HOTTEST), heat(u32::MAX));
        let brightness = |cost: u32| heat(4_u32.pow(cost)).map(u32::from).iter().sum::<u32>();
        assert!((0..6).all(|power| brightness(power) < brightness(power + 1)));
    }
}

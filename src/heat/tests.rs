//! Tests of `heat`.

use super::*;

#[test]
fn heat_runs_from_1_to_the_hottest() {
    assert_eq!(heat(0), heat(1));
    assert_eq!(heat(HOTTEST), heat(u32::MAX));
    let brightness = |cost: u32| heat(4_u32.pow(cost)).map(u32::from).iter().sum::<u32>();
    assert!((0..6).all(|power| brightness(power) < brightness(power + 1)));
}

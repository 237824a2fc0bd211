//! Tests of `palette`.

use super::*;

#[test]
fn few_colors_stay_and_many_stay_near() {
    let mut few: Vec<u8> = (0..256_u32)
        .flat_map(|i| [i * 7 % 256, i, i * i % 256].map(|value| value as u8))
        .collect();
    let before = few.clone();
    reduce(&mut few);
    assert_eq!(few, before);
    // A ramp of 766 colours, each step one of a channel.
    let ramp = |i: u32| [0, 255, 510].map(|start| i.saturating_sub(start).min(255) as u8);
    let before: Vec<u8> = (0..766).flat_map(ramp).collect();
    let mut many = before.clone();
    reduce(&mut many);
    let largest = many.iter().zip(&before).map(|(a, b)| a.abs_diff(*b)).max();
    assert!(largest <= Some(2), "{largest:?}");
    let mut colors = many.as_chunks::<3>().0.to_vec();
    colors.sort_unstable();
    colors.dedup();
    assert!(colors.len() <= MOST_COLORS);
    reduce(&mut []);
}

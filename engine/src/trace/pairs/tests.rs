//! Tests of `pairs`.

use super::*;
use crate::lanes::LANES;

#[test]
fn children_of_packets_become_packets_of_children() {
    let mut random = fastrand::Rng::with_seed(5);
    for _ in 0..1000 {
        let (low, high) = (random.u64(..) & random.u64(..), random.u64(..) & random.u64(..));
        let pairs = Pairs::of_packets(low, high);
        for (c, p) in (0..LANES).flat_map(|c| (0..PACKETS).map(move |p| (c, p))) {
            let word = if p < 8 { low } else { high };
            let expected = word >> (p % 8 * 8 + c) & 1 != 0;
            assert_eq!(
                pairs.packets(c) >> p & 1 != 0,
                expected,
                "{low:x} {high:x}: {c}, {p}"
            );
        }
    }
}

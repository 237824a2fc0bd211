//! Tests of `stack`.

use super::*;

#[test]
fn leaves_come_in_the_order_in_which_they_were_deferred() {
    let leaf = |packets| Entry {
        packets,
        ..Entry::NONE
    };
    let mut leaves = DeferredLeaves::EMPTY;
    assert!(leaves.pop().is_none());
    let mut next = 0;
    for i in 0..20 {
        leaves.push(leaf(i));
        if leaves.is_full() {
            assert_eq!(leaves.oldest().map(|leaf| leaf.packets), Some(next));
            assert_eq!(leaves.pop().map(|leaf| leaf.packets), Some(next));
            next += 1;
        }
    }
    let left: Vec<u32> = std::iter::from_fn(|| leaves.pop())
        .map(|leaf| leaf.packets)
        .collect();
    assert_eq!(left, [17, 18, 19]);
}

//! Tests of `budget`.

use super::*;

#[test]
fn what_is_given_back_can_be_taken_again() {
    let budget = Budget::new(100);
    assert_eq!(budget.take(60), Ok(()));
    assert_eq!(
        budget.take_array::<u64>(6),
        Err(BudgetError::OverLimit {
            needed: 108,
            limit: 100
        })
    );
    assert_eq!((budget.taken(), budget.left()), (60, 40));
    budget.give_back(50);
    assert_eq!(budget.take(90), Ok(()));
    assert_eq!(budget.left(), 0);
    budget.give_back_to(10);
    assert_eq!(budget.left(), 90);
    assert!(budget.take(usize::MAX).is_err());
    let (budget, mut array) = (Budget::new(100), vec![0_u64; 4]);
    budget.take_array::<u64>(4).expect("it fits");
    assert_eq!(budget.reserve(&mut array, 1), Ok(()));
    assert_eq!((array.capacity(), budget.taken()), (8, 64));
    array.resize(8, 0);
    assert!(budget.reserve(&mut array, 1).is_err());
    assert_eq!((array.capacity(), budget.taken()), (8, 64));
    assert_eq!(Budget::unlimited().take_array::<u64>(usize::MAX), Ok(()));
}

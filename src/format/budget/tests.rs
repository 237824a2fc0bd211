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

#[test]
fn large_files_report_what_is_parsed() {
    let reports = Arc::new(std::sync::Mutex::new(Vec::new()));
    let list = Arc::clone(&reports);
    let budget = Budget::new(Limits {
        on_parsed: Some(Arc::new(move |done, total| {
            list.lock().expect("no panic").push((done, total));
        })),
        ..Limits::from(u64::MAX)
    });
    budget.parsing(PARSED - 1).at(PARSED - 1);
    let mut progress = budget.parsing(3 * PARSED);
    for byte in [0, PARSED, PARSED + 1, 2 * PARSED + 5] {
        progress.at(byte);
    }
    drop(progress);
    let reports = reports.lock().expect("no panic");
    let total = 3 * PARSED;
    assert_eq!(
        *reports,
        [(0, total), (PARSED, total), (2 * PARSED + 5, total), (0, 0)]
    );
}

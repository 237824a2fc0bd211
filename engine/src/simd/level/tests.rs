//! Tests of `level`.

use super::*;

#[test]
fn levels_are_found_by_their_names() {
    for level in Level::all() {
        assert_eq!(level.to_string().parse(), Ok(level));
    }
    assert!(Level::all().is_sorted() && Level::all().any(|level| level == Level::current()));
    assert_eq!("AVX2".parse::<Level>(), Err(LevelError::Unknown));
    if Level::all().count() < 3 {
        assert_eq!("avx512".parse::<Level>(), Err(LevelError::Unavailable));
    }
}

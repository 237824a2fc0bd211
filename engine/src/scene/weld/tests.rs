#[test]
fn equal_positions_map_to_the_first() {
    let found = super::weld(&[1.0, 0.0, 1.0, -0.0, 1.0], &[2.0, 0.0, 2.0, 0.0, 3.0], &[0.0; 5]);
    assert_eq!(found, [0, 1, 0, 1, 4]);
}

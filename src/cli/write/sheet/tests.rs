use super::*;

#[test]
fn sizes() {
    assert_eq!(sheet_size([100, 50], 3, 7), Some([3 * 108 + 8, 3 * 74 + 8]));
    assert_eq!(sheet_size([100, 50], 9, 2), Some([2 * 108 + 8, 74 + 8]));
    assert_eq!(sheet_size([u32::MAX, 1], 1, 1), None);
    assert_eq!(sheet_size([1 << 20, 1], 1 << 20, 1 << 20), None);
}

#[test]
fn long_names_and_odd_letters_stay_in_their_place() {
    let mut sheet = Sheet::new([20, 10], 2, 3).expect("memory");
    for name in ["a name that is too long", "\u{1f600}\u{7}", ""] {
        sheet.add(name, None);
    }
    let is_ink = |x: u32, y: u32| sheet.film.pixels()[(y * sheet.film.width() + x) as usize] != PAPER;
    let (width, height) = sheet.size();
    for y in 0..height {
        for x in (0..width).filter(|&x| is_ink(x, y)) {
            assert!((GAP..width - GAP).contains(&x) && y >= GAP + 10, "{x} {y}");
        }
    }
    assert!((0..width).any(|x| (0..height).any(|y| is_ink(x, y))));
}

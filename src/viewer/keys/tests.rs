//! Tests of `keys`.

use super::*;
use winit::keyboard::KeyCode;

#[test]
fn the_help_fits_and_lists_every_character() {
    assert!(HELP.iter().all(|line| line.len() <= 30));
    let keys: String = HELP.iter().map(|line| &line[..line.len().min(6)]).collect();
    let characters = (' '..='~').filter(|c| action(&Key::Character(c.to_string().into())).is_some());
    for c in characters.filter(|c| !c.is_ascii_digit()) {
        assert!(keys.contains(c), "{c}");
    }
}

#[test]
fn a_key_that_is_released_under_another_name_ends_its_flight() {
    let [arrow, keypad, up] = [KeyCode::ArrowLeft, KeyCode::Numpad4, KeyCode::ArrowUp].map(PhysicalKey::Code);
    let mut held = Held::default();
    for key in [arrow, keypad, keypad] {
        held.press(key, 2);
        assert_eq!(held.flight(), [-1.0, 0.0, 0.0]);
    }
    held.press(up, 0);
    assert_eq!(held.flight(), [-1.0, 0.0, 1.0]);
    assert!(held.release(keypad) && !held.release(keypad));
    assert_eq!(held.flight(), [-1.0, 0.0, 1.0]);
    assert!(held.release(arrow) && held.flies());
    assert!(held.release(up) && !held.flies());
    assert_eq!(held.flight(), [0.0; 3]);
}

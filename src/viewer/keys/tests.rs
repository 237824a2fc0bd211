//! Tests of `keys`.

use super::*;

#[test]
fn the_help_fits_and_lists_every_character() {
    assert!(HELP.iter().all(|line| line.len() <= 30));
    let keys: String = HELP.iter().map(|line| &line[..line.len().min(6)]).collect();
    let characters = (' '..='~').filter(|c| action(&Key::Character(c.to_string().into())).is_some());
    for c in characters.filter(|c| !c.is_ascii_digit()) {
        assert!(keys.contains(c), "{c}");
    }
}

use super::*;

#[test]
fn strings_hold_no_objects() {
    let size = |text: &str| parsed_size(text.as_bytes()) - text.len();
    assert_eq!(size(r#"{"{[,":[1,2]}"#), OBJECT + ARRAY + ELEMENT + 2 * QUOTE);
    assert_eq!(size(r#""\"{\\","#), ELEMENT + 2 * QUOTE);
    assert_eq!(size(r#""\"#), QUOTE);
    // Arrays within arrays.
    assert_eq!(size("[ [],\n[[3]]]"), ARRAY + 3 * OBJECT + ELEMENT);
}

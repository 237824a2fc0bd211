//! Tests of `message`.

use super::*;

#[test]
fn a_message_fits_on_a_screen() {
    assert_eq!(on_a_screen("a\nb\n"), "a\nb\n");
    assert_eq!(on_a_screen("a\u{1b}[2J\tb"), "a\\u{1b}[2J\\tb");
    let long = on_a_screen(&"\u{e9}".repeat(1 << 20));
    assert!(long.len() <= MOST_BYTES && long.ends_with("\u{e9}..."));
    let numbered: Vec<String> = (1..=1000).map(|number| number.to_string()).collect();
    let many = on_a_screen(&(numbered.join("\n") + "\n"));
    assert_eq!(many.lines().count(), MOST_LINES + 1);
    assert!(
        many.contains("\n30\n... 940 lines ...\n971\n") && many.ends_with("\n1000\n"),
        "{many}"
    );
    let fits = numbered[..MOST_LINES].join("\n");
    assert_eq!(on_a_screen(&fits), fits);
    let escapes = on_a_screen(&format!("{}\n", "\u{1b}".repeat(3000)).repeat(10));
    assert!(
        escapes.len() < MOST_BYTES && escapes.contains("... 8 lines ..."),
        "{escapes}"
    );
}

#[test]
fn json_stays_json() {
    let words = "a\u{1b}\u{7f}\u{9b}\u{61c}\u{202e}\u{e0041}\n\"";
    let json = serde_json::to_string(words).unwrap() + "\n";
    let tame = tame_json(&json);
    assert_eq!(serde_json::from_str::<String>(&tame).unwrap(), words);
    assert!(tame.is_ascii() && tame.matches('\n').count() == 1, "{tame}");
}

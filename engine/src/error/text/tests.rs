use super::*;

#[test]
fn words_are_escaped_and_cut() {
    assert_eq!(quote(b"sphere"), "`sphere`");
    assert_eq!(quote(b"\x1b[31mred\xff\x00"), "`\\u{1b}[31mred\\xff\\u{0}`");
    assert_eq!(quote("caf\u{e9}\u{202e}".as_bytes()), "`caf\u{e9}\\u{202e}`");
    assert_eq!(quote(&[b'a'; 100]), format!("`{}...`", "a".repeat(40)));
    assert_eq!(quote(&[b'a'; 1000]), format!("`{}...`", "a".repeat(40)));
    assert_eq!(
        quote("\u{20ac}".repeat(40).as_bytes()),
        format!("`{}`", "\u{20ac}".repeat(40))
    );
}

#[test]
fn what_hides_or_reorders_is_escaped() {
    for c in "\u{0}\u{1b}\u{7f}\u{85}\u{9b}\u{a0}\u{ad}\u{61c}\u{200b}\u{200f}\u{2028}\u{202e}\u{2066}\u{2069}\u{feff}\u{e0041}"
        .chars()
    {
        assert_eq!(escape(&c.to_string()), c.escape_default().to_string());
    }
    // Letters, accents, ideographs and emoji stay.
    let plain = "a \u{e9} e\u{301} \u{5b57} \u{1f600} \u{5d0}\\\"";
    assert_eq!(escape(plain), plain);
}

#[test]
fn long_values_lose_their_middle() {
    assert_eq!(clip("a\u{1b}b"), "a\\u{1b}b");
    let long = format!("/{}/end.scn", "d".repeat(3_000_000));
    let cut = clip(&long);
    assert!(
        cut.len() <= VALUE_LIMIT && cut.starts_with("/ddd") && cut.ends_with("ddd/end.scn"),
        "{cut}"
    );
    // An escape is not cut in two.
    let cut = clip(&"\u{1b}".repeat(1000));
    assert!(
        cut.len() <= VALUE_LIMIT && cut.replace("\\u{1b}", "") == CUT,
        "{cut}"
    );
}

#[test]
fn the_caret_stands_below_the_word() {
    let excerpt = Excerpt::new(b"\tsphere  0 x 1 1  ", 11..12);
    assert_eq!(excerpt.text(), " sphere  0 x 1 1");
    assert_eq!(excerpt.carets(), "           ^");
    let behind = Excerpt::new(b"light 1 2\r", 9..9);
    assert_eq!(
        (behind.text(), behind.carets().as_str()),
        ("light 1 2", "         ^")
    );
    let escaped = Excerpt::new(b"\x07\xff bad", 3..6);
    assert_eq!(escaped.text(), "\\u{7}\\xff bad");
    assert_eq!(escaped.carets(), "          ^^^");
    assert_eq!(Excerpt::new(b"", 0..0).carets(), "^");
    assert_eq!(Excerpt::new(b"ab", 90..95).carets(), "  ^");
}

#[test]
fn a_long_line_is_cut_around_the_word() {
    let mut line = vec![b'a'; 5000];
    line[3000..3004].copy_from_slice(b"WORD");
    let excerpt = Excerpt::new(&line, 3000..3004);
    assert!(excerpt.text().len() <= LINE_LIMIT + 2 * CUT.len());
    assert!(excerpt.text().starts_with("...aaa") && excerpt.text().ends_with("aaa..."));
    assert_eq!(excerpt.text().find("WORD"), excerpt.carets().find('^'));
    assert_eq!(excerpt.carets().trim_start(), "^^^^");
    let whole = Excerpt::new(&line, 0..5000);
    assert!(whole.carets().len() <= LINE_LIMIT);
    assert!(whole.text().ends_with("aaa..."));
}

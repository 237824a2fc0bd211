use super::{Owner, Range, absent, channels, value_of};

#[test]
fn numbers_keep_their_bits() {
    for value in [
        0.0,
        -0.0,
        1.5,
        1e300,
        f64::MIN_POSITIVE / 8.0,
        f64::INFINITY,
        f64::NAN,
        -1.0e-7,
    ] {
        assert_eq!(value_of(channels(value)).to_bits(), value.to_bits(), "{value}");
    }
}

#[test]
fn ranges_are_of_finite_numbers() {
    let range = Range::of([f64::NAN, 3.0, f64::NEG_INFINITY, -2.0].into_iter());
    assert_eq!(range.0, Some([-2.0, 3.0]));
    assert_eq!(range.and(Range::of([7.0].into_iter())).0, Some([-2.0, 7.0]));
    assert_eq!(Range::default().and(range), range);
    assert_eq!(Range::of([f64::NAN].into_iter()).0, None);
}

#[test]
fn errors_list_what_there_is() {
    let text = |has: &[(Owner, &str)]| absent("a\u{1b}b", has).message;
    assert_eq!(
        text(&[]),
        "no scalar property `a\\u{1b}b`: the file has none; x, y and z are the coordinates"
    );
    let both = text(&[
        (Owner::Vertices, "q"),
        (Owner::Faces, "w"),
        (Owner::Vertices, "r s"),
    ]);
    assert!(
        both.contains("has `q`, `r s` of vertices and `w` of faces;"),
        "{both}"
    );
    let many: Vec<_> = (0..70).map(|_| (Owner::Vertices, "n")).collect();
    assert!(text(&many).contains("`n`, ... of vertices"));
}

//! Tests of `shell`.

use super::*;

#[test]
fn errors_of_the_display_are_plain() {
    let why = |what: Option<&str>, cause: Option<&str>| {
        let error = SoftBufferError::PlatformError(what.map(str::to_owned), cause.map(Into::into));
        no_surface(error).replace("cannot draw into the window: ", "")
    };
    let of_depth = "Visual 0x21 does not use softbuffer's pixel format and is unsupported";
    assert_eq!(
        [
            why(Some(of_depth), None),
            why(Some("no window"), None),
            why(Some("no window"), Some("it is gone")),
            why(None, Some("it is gone")),
        ],
        [
            "octray needs an X11 screen with 24-bit colour",
            "no window",
            "no window: it is gone",
            "it is gone",
        ]
    );
}

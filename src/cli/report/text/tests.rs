//! Tests of `text`.

use super::*;
use crate::error::in_bytes;

#[test]
fn numbers_are_readable() {
    assert_eq!(grouped(0), "0");
    assert_eq!(grouped(999), "999");
    assert_eq!(grouped(1000), "1 000");
    assert_eq!(grouped(12_345_678), "12 345 678");
    assert_eq!(in_bytes(1023), "1023 B");
    assert_eq!(in_bytes(1536), "1.5 KiB");
    assert_eq!(in_bytes(3 << 30), "3.0 GiB");
}

#[test]
fn words_are_quoted_for_a_shell() {
    for (path, expected) in [
        ("a/b-1.scn", "a/b-1.scn"),
        ("für.scn", "für.scn"),
        ("a b'c$HOME.scn", "'a b'\\''c$HOME.scn'"),
        ("-x.scn", "./-x.scn"),
        ("- x.scn", "'./- x.scn'"),
        ("n\nl's.scn", "$'n\\012l\\'s.scn'"),
        ("\u{202e}a.scn", "$'\\342\\200\\256a.scn'"),
    ] {
        assert_eq!(quoted_path(Path::new(path)), expected);
    }
    // The name of an animation is no path.
    assert_eq!(quoted(OsStr::new("-walk")), "-walk");
}

#[cfg(unix)]
#[test]
fn a_shell_reads_quoted_words() {
    use std::{os::unix::ffi::OsStrExt, process::Command};

    for name in [&b"-a\\b 'c'\n\x1b7.scn"[..], b"$'\xff\x80 0.scn", b"~", b"*\\"] {
        let word = quoted_path(Path::new(OsStr::from_bytes(name)));
        let Ok(run) = Command::new("bash")
            .args(["-c", &format!("printf %s {word}")])
            .output()
        else {
            return;
        };
        let read = run.stdout.strip_prefix(b"./").unwrap_or(&run.stdout);
        assert_eq!(read, name, "{word}");
    }
}

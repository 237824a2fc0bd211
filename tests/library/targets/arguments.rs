//! The parsers of option values: accepted values are within their limits.

use octray::cli::{named, parse_value};

/// The options with parsers of their own, indexed by an input's first byte.
const OPTIONS: [&str; 9] = [
    "size",
    "eye",
    "smooth-angle",
    "tolerance",
    "allow-pixels",
    "crop",
    "frames",
    "benchmark",
    "max-memory",
];

/// A byte that chooses the option, and the option's value.
pub fn arguments(bytes: &[u8]) {
    let Some((&which, value)) = bytes.split_first() else {
        return;
    };
    let Ok(text) = std::str::from_utf8(value) else {
        return;
    };
    let Some(&option) = OPTIONS.get(usize::from(which.wrapping_sub(b'0'))) else {
        names(text);
        return;
    };
    match parse_value(option, text) {
        Ok(numbers) => check(option, &numbers),
        Err(message) => assert!(message.contains("expected"), "{option}={text}: {message}"),
    }
}

fn check(option: &str, numbers: &[f64]) {
    let holds = match (option, numbers) {
        ("size", &[width, height]) => width >= 1.0 && height >= 1.0,
        ("eye", &[x, y, z]) => [x, y, z].iter().all(|number| number.abs() <= 1e9),
        ("smooth-angle", &[degrees]) => (0.0..=180.0).contains(&degrees),
        ("tolerance", &[levels]) => (0.0..=255.0).contains(&levels),
        ("allow-pixels", &[share]) => (0.0..=1.0).contains(&share),
        ("crop", &[x0, y0, x1, y1]) => x0 < x1 && y0 < y1,
        ("frames", &[first, last]) => 1.0 <= first && first <= last,
        ("benchmark", &[seconds]) => seconds > 0.0 && seconds <= 3600.0,
        ("max-memory", &[bytes]) => bytes >= 1.0,
        _ => false,
    };
    assert!(holds, "{option}: {numbers:?}");
}

/// A file name pattern and, after a line break, the scene's name.
fn names(text: &str) {
    let (pattern, scene) = text.split_once('\n').unwrap_or((text, "cow.scn"));
    let whole = named(pattern, scene, None);
    assert!(
        pattern.contains("{stem}") || pattern.contains("{folder}") || whole == pattern,
        "{pattern:?}: {whole:?}"
    );
    // Numbers of one digit: their names have one length and sort as the numbers do.
    let [three, seven] = [3, 7].map(|number| named(pattern, scene, Some(number)));
    assert_eq!(three.len(), seven.len());
    assert!(three <= seven, "{pattern:?}: {three:?} and {seven:?}");
}

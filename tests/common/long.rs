//! How many cases a test tries: few of each kind with `cargo test`, many with `OCTRAY_LONG=1 cargo test`, which takes hours.

/// Whether `OCTRAY_LONG` is set.
pub fn is_long() -> bool {
    std::env::var_os("OCTRAY_LONG").is_some()
}

/// Returns `long` if `OCTRAY_LONG` is set, else `short`.
pub fn rounds<T>(short: T, long: T) -> T {
    if is_long() { long } else { short }
}

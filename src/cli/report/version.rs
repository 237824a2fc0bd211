//! The output of `--version`.

use crate::Level;
use std::sync::LazyLock;

static SHORT: LazyLock<String> =
    LazyLock::new(|| format!("{} ({})", env!("CARGO_PKG_VERSION"), crate::isa()));

static LONG: LazyLock<String> = LazyLock::new(|| {
    let levels: Vec<&str> = Level::all().map(Level::name).collect();
    format!(
        "{}\nfor {}-{}, with code for these levels of this CPU: {}",
        *SHORT,
        std::env::consts::ARCH,
        std::env::consts::OS,
        levels.join(", "),
    )
});

/// Version and instruction set, for `-V`.
pub fn short() -> &'static str {
    &SHORT
}

/// The same and the levels of this CPU, for `--version`.
pub fn long() -> &'static str {
    &LONG
}

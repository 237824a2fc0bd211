//! What `--version` says.

use crate::math;
use std::sync::LazyLock;

static SHORT: LazyLock<String> =
    LazyLock::new(|| format!("{} ({})", env!("CARGO_PKG_VERSION"), crate::isa()));

static LONG: LazyLock<String> = LazyLock::new(|| {
    let features = features();
    let features = if features.is_empty() {
        "the baseline alone".into()
    } else {
        features.join(" ")
    };
    format!(
        "{}\ncompiled for: {}-{}, {features}\nmultiply-add: {}",
        *SHORT,
        std::env::consts::ARCH,
        std::env::consts::OS,
        if math::FUSED { "fused" } else { "not fused" },
    )
});

/// Version and instruction set, for `-V`.
pub fn short() -> &'static str {
    &SHORT
}

/// The same and what the build was compiled for, for `--version`.
pub fn long() -> &'static str {
    &LONG
}

/// Target features that matter to the kernels and that this build has.
fn features() -> Vec<&'static str> {
    macro_rules! compiled_in {
        ($($feature:literal)*) => {
            [$(($feature, cfg!(target_feature = $feature))),*]
        };
    }
    compiled_in!("sse4.1" "sse4.2" "popcnt" "avx" "avx2" "fma" "bmi1" "bmi2" "lzcnt" "f16c" "avx512f" "avx512vl" "neon")
        .into_iter()
        .filter_map(|(name, has)| has.then_some(name))
        .collect()
}

//! The instruction set levels, and the entry into code that is compiled for one.

use super::Portable;
#[cfg(target_arch = "x86_64")]
use super::{Avx2, Avx512};
use std::{
    fmt,
    str::FromStr,
    sync::atomic::{AtomicU8, Ordering},
};

/// An instruction set that octray has code for and that this CPU has. Every level computes the same, bit for bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Level(Token);

/// The cases of [`at_level!`]: each proves that the CPU has the instructions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Token {
    /// What the build was compiled for: on x86-64 without flags SSE2, on aarch64 NEON.
    Portable(Portable),
    /// AVX2 and FMA: x86-64 CPUs since 2013 (Haswell, Zen).
    #[cfg(target_arch = "x86_64")]
    Avx2(Avx2),
    /// AVX-512 as of Skylake-X and Zen 4.
    #[cfg(target_arch = "x86_64")]
    Avx512(Avx512),
}

/// Evaluates an expression with `$simd`, the token of a level. It should be one call of a function that is generic over
/// [`Simd`](super::Simd) and marked `#[inline(always)]`, like all that it calls: what is not inlined is compiled for any
/// CPU. Use it for large pieces of work, not in the loops of a kernel.
#[doc(hidden)]
#[macro_export]
macro_rules! at_level {
    ($level:expr, |$simd:ident| $body:expr) => {
        match $crate::simd::Level::token($level) {
            $crate::simd::Token::Portable($simd) => $crate::simd::Simd::call(
                $simd,
                #[inline(always)]
                || $body,
            ),
            #[cfg(target_arch = "x86_64")]
            $crate::simd::Token::Avx2($simd) => $crate::simd::Simd::call(
                $simd,
                #[inline(always)]
                || $body,
            ),
            #[cfg(target_arch = "x86_64")]
            $crate::simd::Token::Avx512($simd) => $crate::simd::Simd::call(
                $simd,
                #[inline(always)]
                || $body,
            ),
        }
    };
}
pub use at_level;

/// The level to which the process is limited: its index plus 1, or 0.
static HELD: AtomicU8 = AtomicU8::new(0);

impl Level {
    /// The level that every CPU of the build's architecture has.
    pub const PORTABLE: Self = Self(Token::Portable(Portable));

    /// Returns all levels, the lowest first, with `None` for those that this CPU lacks.
    fn each() -> [Option<Self>; 3] {
        #[cfg(target_arch = "x86_64")]
        let (avx2, avx512) = (
            Avx2::detected().map(|token| Self(Token::Avx2(token))),
            Avx512::detected().map(|token| Self(Token::Avx512(token))),
        );
        #[cfg(not(target_arch = "x86_64"))]
        let (avx2, avx512) = (None, None);
        [Some(Self::PORTABLE), avx2, avx512]
    }

    /// Returns the levels of this CPU, the lowest first.
    pub fn all() -> impl DoubleEndedIterator<Item = Self> {
        Self::each().into_iter().flatten()
    }

    /// Returns the default level: the highest of this CPU, or the one that was [set](Self::hold) for the process.
    #[must_use]
    pub fn current() -> Self {
        let [_, avx2, avx512] = Self::each();
        let highest = match HELD.load(Ordering::Relaxed) {
            1 => None,
            2 => avx2,
            _ => avx512.or(avx2),
        };
        highest.unwrap_or(Self::PORTABLE)
    }

    /// Makes this the process's default level from now on.
    pub fn hold(self) {
        let place = Self::each().iter().position(|&level| level == Some(self));
        HELD.store(place.map_or(0, |place| place as u8 + 1), Ordering::Relaxed);
    }

    /// Returns the name that [`FromStr`] parses.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self.0 {
            Token::Portable(_) => "portable",
            #[cfg(target_arch = "x86_64")]
            Token::Avx2(_) => "avx2",
            #[cfg(target_arch = "x86_64")]
            Token::Avx512(_) => "avx512",
        }
    }

    /// Returns the name of the instruction set, such as "x86-64 AVX2+FMA".
    #[must_use]
    pub fn instructions(self) -> &'static str {
        match self.0 {
            Token::Portable(_) => COMPILED_FOR,
            #[cfg(target_arch = "x86_64")]
            Token::Avx2(_) => "x86-64 AVX2+FMA",
            #[cfg(target_arch = "x86_64")]
            Token::Avx512(_) => "x86-64 AVX-512",
        }
    }

    #[inline(always)]
    #[doc(hidden)]
    pub fn token(self) -> Token {
        self.0
    }
}

/// The current level.
impl Default for Level {
    fn default() -> Self {
        Self::current()
    }
}

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Returns the instruction set of [`Level::current`], which octray uses in this process.
#[must_use]
pub fn isa() -> &'static str {
    Level::current().instructions()
}

/// The instruction set of the portable level.
const COMPILED_FOR: &str = if cfg!(target_feature = "avx512f") {
    "x86-64, compiled for AVX-512"
} else if cfg!(target_feature = "avx2") {
    "x86-64, compiled for AVX2"
} else if cfg!(target_arch = "x86_64") {
    "x86-64 SSE2"
} else if cfg!(target_arch = "aarch64") {
    "aarch64 NEON"
} else {
    std::env::consts::ARCH
};

/// Why a name gives no [`Level`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LevelError {
    /// There is no level of this name.
    Unknown,
    /// This CPU, or its system, lacks the instructions.
    Unavailable,
}

impl fmt::Display for LevelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Unknown => "no such instruction set, expected portable, avx2 or avx512",
            Self::Unavailable => "this CPU does not have these instructions",
        })
    }
}

impl std::error::Error for LevelError {}

impl FromStr for Level {
    type Err = LevelError;

    fn from_str(name: &str) -> Result<Self, LevelError> {
        match Self::all().find(|level| level.name() == name) {
            Some(level) => Ok(level),
            None if ["avx2", "avx512"].contains(&name) => Err(LevelError::Unavailable),
            None => Err(LevelError::Unknown),
        }
    }
}

#[cfg(test)]
mod tests;

//! The live window: an orbit camera around a scene that is traced anew for every frame.
//!
//! [`orbit`], [`budget`] and [`progressive`] are plain types that need no window.

pub mod budget;
pub mod orbit;
pub mod progressive;

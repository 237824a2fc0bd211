//! The memory that loading takes, counted in one place.
//!
//! Code that reads a file or makes an array from one takes the bytes from the budget before it allocates them, and gives
//! back what it frees before the load ends.

use super::{
    mesh::{Moment, Sharing, Wanted},
    offset::Offset,
    reason::Reason,
};
use crate::error::{LoadError, in_bytes};
use std::{
    fmt, io,
    path::Path,
    sync::{
        Arc, OnceLock,
        atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering},
    },
};

/// Receives the number of bytes of a large file read since the last call, from the threads that read it.
pub(crate) type OnRead = Arc<dyn Fn(usize) + Send + Sync>;

/// Receives how much of a large file is parsed, and its size, both in bytes; twice 0 when that is done.
pub(crate) type OnParsed = Arc<dyn Fn(usize, usize) + Send + Sync>;

/// Receives the path of each file before it is opened.
pub(crate) type OnOpen = Arc<dyn Fn(&Path) + Send + Sync>;

/// The limits of a load, and its callbacks.
#[derive(Clone)]
pub(crate) struct Limits {
    /// Bytes.
    pub memory: u64,
    pub on_read: Option<OnRead>,
    pub on_parsed: Option<OnParsed>,
    pub on_open: Option<OnOpen>,
}

impl From<u64> for Limits {
    fn from(memory: u64) -> Self {
        Self {
            memory,
            on_read: None,
            on_parsed: None,
            on_open: None,
        }
    }
}

/// How many folders are searched for names like those of missing files.
const MAX_SUGGESTIONS: u64 = 4;

/// After how many bytes progress is reported. Smaller files are parsed at once.
const PARSED: usize = 1 << 20;

/// The progress of a file that is parsed in order.
pub(super) struct Parsing<'b> {
    on_parsed: Option<&'b (dyn Fn(usize, usize) + Send + Sync)>,
    total: usize,
    /// From which byte on there is something to report.
    next: usize,
}

impl Parsing<'_> {
    /// Notes the byte that is parsed next.
    #[inline]
    pub(super) fn at(&mut self, byte: usize) {
        if byte >= self.next {
            self.next = byte.saturating_add(PARSED);
            if let Some(on_parsed) = self.on_parsed {
                on_parsed(byte, self.total);
            }
        }
    }
}

impl Drop for Parsing<'_> {
    fn drop(&mut self) {
        if let Some(on_parsed) = self.on_parsed {
            on_parsed(0, 0);
        }
    }
}

/// The memory that one load may take; shared by all files that it reads.
pub(super) struct Budget {
    limit: u64,
    on_read: Option<OnRead>,
    on_parsed: Option<OnParsed>,
    on_open: Option<OnOpen>,
    taken: AtomicU64,
    /// How many missing files suggestions were asked for.
    missing: AtomicU64,
    /// Whether the images of the next mesh are read.
    wants_images: AtomicBool,
    /// What becomes of a mesh's parts that stand in several places.
    sharing: Sharing,
    /// The moment of an animation in which a mesh is shown, instead of its stored pose.
    moment: Option<Moment>,
    /// Which numbers of a mesh are read.
    scalars: Wanted,
    /// What coordinates are read relative to; set for the second reading of a mesh far from 0.
    offset: OnceLock<Offset>,
    /// The largest absolute coordinate that the file stores as `f32`, as bits.
    single_reach: AtomicU32,
}

/// Why a load cannot have more memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BudgetError {
    /// It would take more than its limit.
    OverLimit {
        /// What it has taken and requests now, bytes.
        needed: u64,
        /// Bytes.
        limit: u64,
    },
    /// The system refuses it.
    NoMemory,
}

impl Budget {
    /// A budget with these limits.
    pub(super) fn new(limits: impl Into<Limits>) -> Self {
        let Limits {
            memory,
            on_read,
            on_parsed,
            on_open,
        } = limits.into();
        Self {
            limit: memory,
            on_read,
            on_parsed,
            on_open,
            taken: AtomicU64::new(0),
            missing: AtomicU64::new(0),
            wants_images: AtomicBool::new(true),
            sharing: Sharing::Never,
            moment: None,
            scalars: Wanted::Nothing,
            offset: OnceLock::new(),
            single_reach: AtomicU32::new(0),
        }
    }

    /// The budget of a mesh whose parts may be shared.
    pub(super) fn with_sharing(self, sharing: Sharing) -> Self {
        Self { sharing, ..self }
    }

    /// The budget of a mesh that is shown in a moment of an animation.
    pub(super) fn with_moment(self, moment: Option<Moment>) -> Self {
        Self { moment, ..self }
    }

    /// The budget of a mesh of which these numbers are read.
    #[cfg(feature = "cli")]
    pub(super) fn with_scalars(self, scalars: Wanted) -> Self {
        Self { scalars, ..self }
    }

    /// Which numbers of a mesh are read.
    pub(super) fn scalars(&self) -> &Wanted {
        &self.scalars
    }

    /// The moment of an animation in which a mesh is shown.
    pub(super) fn moment(&self) -> Option<&Moment> {
        self.moment.as_ref()
    }

    /// What becomes of a mesh's parts that stand in several places.
    #[cfg_attr(
        not(feature = "gltf"),
        allow(dead_code, reason = "only glTF files have such parts")
    )]
    pub(super) fn sharing(&self) -> Sharing {
        self.sharing
    }

    /// A budget that only counts.
    pub(super) fn unlimited() -> Self {
        Self::new(u64::MAX)
    }

    /// The progress callback.
    pub(super) fn on_read(&self) -> Option<OnRead> {
        self.on_read.clone()
    }

    /// Reports how much of a file of `total` bytes is parsed.
    pub(super) fn parsing(&self, total: usize) -> Parsing<'_> {
        let on_parsed = self.on_parsed.as_deref().filter(|_| total >= PARSED);
        if let Some(on_parsed) = on_parsed {
            on_parsed(0, total);
        }
        Parsing {
            on_parsed,
            total,
            next: PARSED,
        }
    }

    /// Tells that a file is about to be opened.
    pub(super) fn opens(&self, path: &Path) {
        if let Some(on_open) = &self.on_open {
            on_open(path);
        }
    }

    /// The limit, in bytes.
    pub(super) fn limit(&self) -> u64 {
        self.limit
    }

    /// Whether a missing file is one of the first few: to suggest another, a whole folder is read.
    pub(super) fn may_suggest(&self) -> bool {
        self.missing.fetch_add(1, Ordering::Relaxed) < MAX_SUGGESTIONS
    }

    /// Sets whether images of meshes are read from now on: a mesh that is placed again shows the images that are there.
    pub(super) fn set_wants_images(&self, wants: bool) {
        self.wants_images.store(wants, Ordering::Relaxed);
    }

    /// Whether images of meshes are read.
    pub(super) fn wants_images(&self) -> bool {
        self.wants_images.load(Ordering::Relaxed)
    }

    /// Sets what coordinates of the mesh are read relative to from now on, once.
    pub(super) fn set_offset(&self, offset: Offset) {
        // Only the first offset counts; there is no other.
        let _ = self.offset.set(offset);
    }

    /// What coordinates of a mesh are read relative to.
    pub(super) fn offset(&self) -> Offset {
        self.offset.get().copied().unwrap_or(Offset::NONE)
    }

    /// Records that the file stores coordinates up to `reach` as `f32`, which another reading would not make finer.
    pub(super) fn add_single_reach(&self, reach: f32) {
        // Numbers of 0 or more are ordered as their bits.
        self.single_reach
            .fetch_max(reach.abs().to_bits(), Ordering::Relaxed);
    }

    /// How far from 0 they are.
    pub(super) fn single_reach(&self) -> f32 {
        f32::from_bits(self.single_reach.load(Ordering::Relaxed))
    }

    /// What is left, in bytes.
    pub(super) fn left(&self) -> u64 {
        self.limit - self.taken().min(self.limit)
    }

    /// What has been taken and not given back, in bytes.
    pub(super) fn taken(&self) -> u64 {
        self.taken.load(Ordering::Relaxed)
    }

    /// Takes `bytes`.
    ///
    /// # Errors
    /// [`BudgetError`]; nothing is taken then.
    pub(super) fn take(&self, bytes: usize) -> Result<(), BudgetError> {
        let add = |taken: u64| taken.checked_add(bytes as u64).filter(|sum| *sum <= self.limit);
        match self.taken.fetch_update(Ordering::Relaxed, Ordering::Relaxed, add) {
            Ok(_) => Ok(()),
            Err(taken) => Err(BudgetError::OverLimit {
                needed: taken.saturating_add(bytes as u64),
                limit: self.limit,
            }),
        }
    }

    /// Takes an array of `count` elements of type `T`.
    ///
    /// # Errors
    /// [`BudgetError`]; nothing is taken then.
    pub(super) fn take_array<T>(&self, count: usize) -> Result<(), BudgetError> {
        self.take(count.saturating_mul(size_of::<T>()))
    }

    /// Makes room for `more` elements of an array whose capacity is taken already. It grows to twice its size, if that
    /// much is left; while it grows, the old array is still there.
    ///
    /// # Errors
    /// [`BudgetError`]; the array is unchanged then.
    pub(super) fn reserve<T>(&self, array: &mut Vec<T>, more: usize) -> Result<(), BudgetError> {
        let room = array.capacity() - array.len();
        if more <= room {
            return Ok(());
        }
        let old = array.capacity();
        let most = (self.left() / size_of::<T>().max(1) as u64) as usize;
        let new = old.saturating_mul(2).min(most).max(old + (more - room));
        self.take_array::<T>(new)?;
        let reserved = array.try_reserve_exact(new - array.len());
        let freed = if reserved.is_ok() { old } else { new };
        self.give_back(freed * size_of::<T>());
        reserved.map_err(|_| BudgetError::NoMemory)
    }

    /// Gives back `bytes` that are free again.
    pub(super) fn give_back(&self, bytes: usize) {
        let less = |taken: u64| Some(taken.saturating_sub(bytes as u64));
        // The closure never gives `None`, so this cannot fail.
        let _ = self
            .taken
            .fetch_update(Ordering::Relaxed, Ordering::Relaxed, less);
    }

    /// Gives back all but `taken` bytes, a former value of [`Budget::taken`].
    pub(super) fn give_back_to(&self, taken: u64) {
        self.taken.fetch_min(taken, Ordering::Relaxed);
    }
}

impl BudgetError {
    /// The error about the file at `path`.
    pub(super) fn into_error(self, path: &Path) -> LoadError {
        Reason::from(self).of_file(path)
    }
}

impl fmt::Display for BudgetError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::OverLimit { needed, limit } => write!(
                f,
                "loading takes {} of memory or more, above the memory limit of {}",
                in_bytes(needed),
                in_bytes(limit)
            ),
            Self::NoMemory => f.write_str("the file does not fit into memory"),
        }
    }
}

impl std::error::Error for BudgetError {}

impl From<BudgetError> for io::Error {
    fn from(error: BudgetError) -> Self {
        Self::new(io::ErrorKind::OutOfMemory, error)
    }
}

#[cfg(test)]
mod tests;

//! The memory limit of a command, and the memory of pictures.
//!
//! The scene's memory is estimated during loading ([`crate::scene::SceneBuilder::within`]), the picture's here. Work that does
//! not fit is refused before it begins, instead of failing in the middle.

use crate::{
    accel::BuildQuality,
    cli::CliError,
    error::in_bytes,
    scene::{BVH_BYTES, Scene},
};
use std::{fs, path::Path};

/// Address space of a thread's stack, bytes.
const STACK_BYTES: u64 = 9 << 18;

/// [`BVH_BYTES`] of a PLOC build. Tuned: see docs/lab-notes.md#ploc-memory
const PLOC_BYTES: u64 = 300;

/// Address space that rayon's threads and the allocator set aside, bytes.
const THREADS_BYTES: u64 = 64 << 20;

/// The factors of a pixel's memory while its picture is rendered and written.
#[derive(Clone, Copy, Debug, Default)]
pub struct PixelBytes {
    /// Bytes in the film: 12 (floats), 16 (with alpha), or 3 (bytes).
    pub film: u64,
    /// It goes into an EXR file, whose writer keeps several copies.
    pub exr: bool,
    /// AOVs are rendered, too.
    pub aovs: bool,
    /// It is compared with a reference.
    pub compared: bool,
}

impl PixelBytes {
    /// Bytes of a pixel. Tuned: see docs/lab-notes.md#picture-memory
    fn total(self) -> u64 {
        // The encoded file, in a vector that doubles as it grows.
        let file = if self.exr { self.film } else { 8 };
        let aovs = match (self.aovs, self.exr) {
            (false, _) => 0,
            (true, false) => 48,
            (true, true) => 130,
        };
        let compared = if self.compared { 40 } else { 0 };
        self.film + file + aovs + compared
    }
}

/// The memory limit, bytes: `max`, or a share of the available memory.
pub fn limit(max: Option<u64>) -> u64 {
    max.unwrap_or_else(default_limit).min(own_limit())
}

/// The allocator's limit for the memory limit `limit`, bytes. Estimates are good to about a quarter, and the program itself
/// takes some.
pub fn cap(limit: u64) -> u64 {
    const BESIDE: u64 = 32 << 20;
    limit.saturating_add(limit / 4).saturating_add(BESIDE)
}

/// The part of `limit` that a picture leaves for the scene.
///
/// # Errors
/// [`CliError::Memory`] if the picture alone does not fit.
pub fn beside_picture(limit: u64, (width, height): (u32, u32), pixel: PixelBytes) -> Result<u64, CliError> {
    let needed = u64::from(width) * u64::from(height) * pixel.total();
    limit.checked_sub(needed).ok_or_else(|| {
        CliError::Memory(format!(
            "a picture of {width}x{height} needs about {} of memory, more than the limit of {} (see --max-memory)",
            in_bytes(needed),
            in_bytes(limit)
        ))
    })
}

/// Checks that the stacks of `threads` threads fit.
///
/// # Errors
/// [`CliError::Memory`] if `ulimit -v` leaves no room for them.
pub fn check_threads(threads: Option<u32>) -> Result<(), CliError> {
    let (needed, limit) = (u64::from(threads.unwrap_or(1)) * STACK_BYTES, own_limit());
    if needed > limit {
        return Err(CliError::Memory(format!(
            "--threads {}: the stacks need {} of address space, more than the limit of {}",
            threads.unwrap_or(1),
            in_bytes(needed),
            in_bytes(limit)
        )));
    }
    Ok(())
}

/// How many threads there is room for in the address space: their stacks, and the heaps that glibc reserves for each.
pub fn room_for_threads() -> u32 {
    const EACH: u64 = 80 << 20;
    u32::try_from(own_limit() / EACH).unwrap_or(u32::MAX).max(1)
}

/// Checks that the memory for building the BVH can be allocated. Untouched memory costs nothing; without the check the
/// build might run out of memory halfway.
///
/// # Errors
/// [`CliError::Memory`].
pub fn check_build(scene: &Scene, quality: BuildQuality) -> Result<(), CliError> {
    let bytes = if quality == BuildQuality::Ploc {
        PLOC_BYTES
    } else {
        BVH_BYTES
    };
    let needed = (scene.primitive_count() + scene.instances().len()) as u64 * bytes;
    let mut room: Vec<u8> = Vec::new();
    let asked = usize::try_from(needed).map(|needed| room.try_reserve_exact(needed));
    // Keeps the compiler from removing the allocation.
    std::hint::black_box(&room);
    match asked {
        Ok(Ok(())) => Ok(()),
        _ => Err(CliError::Memory(format!(
            "out of memory: building the BVH of {} primitives needs about {}",
            scene.primitive_count(),
            in_bytes(needed)
        ))),
    }
}

/// Three quarters of the smallest limit of machine and control groups; no limit if none is known.
fn default_limit() -> u64 {
    let limits = [machine(), cgroup()];
    limits
        .into_iter()
        .flatten()
        .min()
        .map_or(u64::MAX, three_quarters)
}

/// Three quarters of what the process may allocate in addition to its threads.
fn own_limit() -> u64 {
    process().map_or(u64::MAX, |limit| {
        three_quarters(limit.saturating_sub(THREADS_BYTES))
    })
}

fn three_quarters(bytes: u64) -> u64 {
    bytes / 4 * 3
}

/// The machine's memory, bytes.
#[cfg(target_os = "linux")]
#[allow(
    clippy::useless_conversion,
    reason = "the field's type differs between targets"
)]
fn machine() -> Option<u64> {
    let info = rustix::system::sysinfo();
    u64::from(info.totalram).checked_mul(u64::from(info.mem_unit))
}

/// The process's own limits, as of `ulimit -v` and `ulimit -d`.
#[cfg(target_os = "linux")]
fn process() -> Option<u64> {
    use rustix::process::{Resource, getrlimit};
    [Resource::As, Resource::Data]
        .into_iter()
        .filter_map(|resource| getrlimit(resource).current)
        .min()
}

/// Elsewhere `--max-memory` is the only limit.
#[cfg(not(target_os = "linux"))]
fn machine() -> Option<u64> {
    None
}

/// Elsewhere `--max-memory` is the only limit.
#[cfg(not(target_os = "linux"))]
fn process() -> Option<u64> {
    None
}

/// The smallest limit of the process's control group and those around it, of cgroups 1 and 2.
fn cgroup() -> Option<u64> {
    let groups = fs::read_to_string("/proc/self/cgroup").ok()?;
    least_of_groups(&groups, Path::new("/sys/fs/cgroup"))
}

/// The same from the text of `/proc/self/cgroup`, with the groups' files below `mounted`.
fn least_of_groups(groups: &str, mounted: &Path) -> Option<u64> {
    let files = groups.lines().filter_map(|line| {
        let mut parts = line.splitn(3, ':').skip(1);
        let (controllers, path) = (parts.next()?, parts.next()?.trim_start_matches('/'));
        match controllers {
            "" => Some((mounted.to_path_buf(), path, "memory.max")),
            names if names.split(',').any(|name| name == "memory") => {
                Some((mounted.join("memory"), path, "memory.limit_in_bytes"))
            }
            _ => None,
        }
    });
    let limits = files.flat_map(|(root, path, file)| {
        // In a container the path may be the outer one; its own limit is then the root's.
        let mut folder = root.join(path);
        let mut found = Vec::new();
        while folder.starts_with(&root) {
            let text = fs::read_to_string(folder.join(file)).unwrap_or_default();
            found.extend(text.trim().parse::<u64>());
            if !folder.pop() {
                break;
            }
        }
        found
    });
    limits.min()
}

#[cfg(test)]
mod tests;

//! `--max-memory`: how much memory a command may take, and whether a picture fits into that.
//!
//! A scene's part is estimated where it is loaded ([`crate::scene::SceneBuilder::within`]), a picture's here, from what was
//! measured with pictures of 16 million pixels. So what will not fit is refused before the work begins, and not by the
//! system in the middle of it.

use super::CliError;
use crate::{
    accel::BuildQuality,
    error::in_bytes,
    scene::{BVH_BYTES, Scene},
};
use clap::Args;
use std::{fs, path::Path};

/// What a command may take of the machine.
#[derive(Args, Clone, Copy, Debug, Default)]
#[command(next_help_heading = "Limits")]
pub struct MemoryArgs {
    /// The most memory to take, such as 512M or 16G; what will not fit is refused before the work begins [default: three
    /// quarters of what the machine, the cgroup or `ulimit -v` allows]
    #[arg(long, value_name = "SIZE", value_parser = super::value::bytes)]
    pub max_memory: Option<u64>,
}

/// What a thread's stack takes of a process's address space, bytes; of memory it takes what is used.
const STACK_BYTES: u64 = 9 << 18;

/// [`BVH_BYTES`] where PLOC divides: measured on a terrain of two million triangles (290).
const PLOC_BYTES: u64 = 300;

/// What threads take of a process's address space before they do anything, bytes.
const THREADS_BYTES: u64 = 64 << 20;

/// What a pixel takes at most while its picture is rendered and written, bytes.
#[derive(Clone, Copy, Debug)]
pub struct PixelBytes {
    /// The film: floats (12), with alpha (16), or bytes (3).
    pub film: u64,
    /// Whether it goes into an EXR file, whose writer keeps several copies.
    pub exr: bool,
    /// Whether variables are found, too.
    pub aovs: bool,
    /// Whether it is compared with a picture.
    pub compared: bool,
}

impl PixelBytes {
    fn total(self) -> u64 {
        // The file's bytes grow in memory, and double when they do.
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

impl MemoryArgs {
    /// What may be taken, bytes.
    pub fn limit(self) -> u64 {
        self.max_memory.unwrap_or_else(default_limit).min(own_limit())
    }

    /// What is left of it for the scene beside a picture.
    ///
    /// # Errors
    /// [`CliError::Failed`], where the picture alone is too much.
    pub fn beside(self, (width, height): (u32, u32), pixel: PixelBytes) -> Result<u64, CliError> {
        let needed = u64::from(width) * u64::from(height) * pixel.total();
        let limit = self.limit();
        limit.checked_sub(needed).ok_or_else(|| {
            CliError::Failed(format!(
                "a picture of {width}x{height} takes about {} of memory with what is made of it, more than the limit of {} \
                 (see --max-memory)",
                in_bytes(needed),
                in_bytes(limit)
            ))
        })
    }
}

/// Whether so many threads can be started.
///
/// # Errors
/// [`CliError::Failed`], where `ulimit -v` leaves no room for their stacks.
pub fn check_threads(threads: Option<u32>) -> Result<(), CliError> {
    let (needed, limit) = (u64::from(threads.unwrap_or(1)) * STACK_BYTES, own_limit());
    if needed > limit {
        return Err(CliError::Failed(format!(
            "--threads {}: their stacks take {} of the process's address space, more than the limit of {}",
            threads.unwrap_or(1),
            in_bytes(needed),
            in_bytes(limit)
        )));
    }
    Ok(())
}

/// Whether the memory is there that building a scene's BVH takes. It is taken and given back without being used, which
/// costs nothing; without it the system would end the program in the middle of the work.
///
/// # Errors
/// [`CliError::Failed`].
pub fn check_build(scene: &Scene, quality: BuildQuality) -> Result<(), CliError> {
    let bytes = if quality == BuildQuality::Ploc {
        PLOC_BYTES
    } else {
        BVH_BYTES
    };
    let needed = scene.primitive_count() as u64 * bytes;
    let mut room: Vec<u8> = Vec::new();
    let asked = usize::try_from(needed).map(|needed| room.try_reserve_exact(needed));
    // Else the compiler may leave out what is never used.
    std::hint::black_box(&room);
    match asked {
        Ok(Ok(())) => Ok(()),
        _ => Err(CliError::Failed(format!(
            "the BVH of {} primitives does not fit into memory: building it takes about {}",
            scene.primitive_count(),
            in_bytes(needed)
        ))),
    }
}

/// Three quarters of the least of all limits, or no limit where none is known.
fn default_limit() -> u64 {
    let limits = [machine(), cgroup()];
    limits
        .into_iter()
        .flatten()
        .min()
        .map_or(u64::MAX, three_quarters)
}

/// What the process's own limits leave: beyond them no allocation succeeds, whatever is asked for. Threads' stacks and
/// what the allocator sets aside count there, too.
fn own_limit() -> u64 {
    process().map_or(u64::MAX, |limit| {
        three_quarters(limit.saturating_sub(THREADS_BYTES))
    })
}

fn three_quarters(bytes: u64) -> u64 {
    bytes / 4 * 3
}

/// The machine's memory. Known on Linux; elsewhere there is only what --max-memory says.
fn machine() -> Option<u64> {
    kibibytes(&fs::read_to_string("/proc/meminfo").ok()?)
}

fn kibibytes(meminfo: &str) -> Option<u64> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
    let number: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    number.checked_mul(1024)
}

/// The least limit of the process's control group and of those around it: of version 2, else of version 1.
fn cgroup() -> Option<u64> {
    let groups = fs::read_to_string("/proc/self/cgroup").ok()?;
    least_of_groups(&groups, Path::new("/sys/fs/cgroup"))
}

/// The same of what `/proc/self/cgroup` says, with the groups' files below `mounted`.
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
        // In a container the path may be that outside: its own limit is then the root's.
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

/// The process's own limits, as of `ulimit -v` and `ulimit -d`.
fn process() -> Option<u64> {
    least_of_process(&fs::read_to_string("/proc/self/limits").ok()?)
}

fn least_of_process(limits: &str) -> Option<u64> {
    let soft = |line: &str| {
        let rest = line
            .strip_prefix("Max address space")
            .or(line.strip_prefix("Max data size"))?;
        rest.split_whitespace().next()?.parse().ok()
    };
    limits.lines().filter_map(soft).min()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_system_says() {
        assert_eq!(
            kibibytes("MemTotal:       24598420 kB\nMemFree: 1 kB\n"),
            Some(24_598_420 << 10)
        );
        assert_eq!(kibibytes(""), None);
        let limits = "Limit  Soft Limit  Hard Limit  Units\n\
            Max data size             unlimited            unlimited            bytes\n\
            Max address space         4194304000           unlimited            bytes\n";
        assert_eq!(least_of_process(limits), Some(4_194_304_000));
        assert_eq!(least_of_process(""), None);
        if cfg!(target_os = "linux") {
            assert!(machine().is_some_and(|bytes| bytes > 1 << 24));
            assert!(default_limit() <= three_quarters(machine().unwrap_or(0)));
        }
    }

    #[test]
    fn limits_of_control_groups() {
        let root = tempfile::TempDir::new().unwrap();
        let write = |name: &str, text: &str| {
            let path = root.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        };
        write("a/memory.max", "8000000\n");
        write("a/b/memory.max", "max\n");
        write("a/c/memory.max", "5000000\n");
        write("memory/d/memory.limit_in_bytes", "3000000\n");
        write("memory/memory.limit_in_bytes", "9223372036854771712\n");
        write("odd/memory.max", "many\n");
        for (groups, expected) in [
            // The group's own limit, and that of a group around it.
            ("0::/a/c\n", Some(5_000_000)),
            ("0::/a/b\n", Some(8_000_000)),
            // Of a group that cannot be seen from here, those around it that can.
            ("0::/a/gone/too\n", Some(8_000_000)),
            ("0::/\n", None),
            ("0::/odd\n", None),
            // Version 1, alone and beside version 2.
            ("7:cpu,memory:/d\n3:pids:/a\n", Some(3_000_000)),
            ("7:memory:/elsewhere\n", Some(9_223_372_036_854_771_712)),
            ("7:memory:/d\n0::/a/c\n", Some(3_000_000)),
            ("", None),
            ("nonsense\n::\n", None),
        ] {
            assert_eq!(least_of_groups(groups, root.path()), expected, "{groups:?}");
        }
    }

    #[test]
    fn pictures_that_do_not_fit() {
        let args = MemoryArgs {
            max_memory: Some(100_000_000),
        };
        let bytes = PixelBytes {
            film: 3,
            exr: false,
            aovs: false,
            compared: false,
        };
        assert_eq!(args.beside((1000, 1000), bytes).ok(), Some(89_000_000));
        assert!(args.beside((4000, 4000), bytes).is_err());
        assert!(
            args.beside(
                (1000, 1000),
                PixelBytes {
                    aovs: true,
                    film: 16,
                    exr: true,
                    ..bytes
                }
            )
            .is_err()
        );
    }
}

//! Files that appear whole or not at all: written under a temporary name in the same folder, then renamed.
//!
//! The temporary name is a hash of the target's name and a small number, and the file is locked while it is written. A
//! killed process leaves at most this file, unlocked; the next writer of the same target removes it. So nothing piles
//! up, however often a farm kills its renderers. (Crates for temporary files use random names, which no later process can
//! recognise.)

use std::{
    fs::{self, File, OpenOptions, Permissions, TryLockError},
    io::{self, BufWriter, Write},
    path::{Path, PathBuf},
    sync::{Mutex, MutexGuard, PoisonError},
};

/// Processes that may write one file at the same time.
const MOST_WRITERS: u32 = 16;
/// Attempts to claim a temporary name while other processes race for it.
const MOST_TRIES: u32 = 100;

/// The most symbolic links followed, as in Linux.
const MAX_LINKS: usize = 40;

/// The temporary files of this process, which [`abandon`] removes.
static TEMPORARIES: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn temporaries() -> MutexGuard<'static, Vec<PathBuf>> {
    TEMPORARIES.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes all temporary files before the process ends in the middle of its work. No file is renamed afterwards.
pub fn abandon() {
    // A thread that is stuck between creating and listing its file must not delay the exit.
    for _ in 0..100 {
        if let Ok(temporaries) = TEMPORARIES.try_lock() {
            for path in &*temporaries {
                let _ = fs::remove_file(path);
            }
            std::mem::forget(temporaries);
            return;
        }
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
}

/// Writes a file whole or not at all, and replaces an existing one, whose permissions stay. A link stays, and what it leads
/// to is replaced. A device or a pipe is written through: replacing it would make it a file.
///
/// # Errors
/// Those of `write` or of the system; the old file is then unchanged.
pub fn write(path: &Path, write: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>) -> io::Result<()> {
    let old = fs::metadata(path).ok();
    if old.as_ref().is_some_and(|old| !old.is_file()) {
        // Links are not followed here: /dev/stdout leads to a pipe without a path.
        let mut file = OpenOptions::new().write(true).open(path)?;
        let mut out = BufWriter::with_capacity(1 << 16, &mut file);
        write(&mut out)?;
        return out.flush();
    }
    let target = follow_links(path)?;
    if old.is_some() {
        // Renaming over it would ignore the old file's permissions.
        OpenOptions::new().write(true).open(&target)?;
    }
    let mut temporary = Temporary::beside(&target, old.map(|old| old.permissions()))?;
    let mut out = BufWriter::with_capacity(1 << 16, temporary.file());
    write(&mut out)?;
    out.flush()?;
    drop(out);
    temporary.persist()
}

/// Follows all symbolic links at the end of a path, whether their target exists or not.
///
/// # Errors
/// If there are more than `MAX_LINKS`.
pub fn follow_links(path: &Path) -> io::Result<PathBuf> {
    if let Ok(path) = fs::canonicalize(path) {
        return Ok(path);
    }
    let mut path = path.to_owned();
    for _ in 0..MAX_LINKS {
        let Ok(link) = fs::read_link(&path) else {
            // A missing folder is refused later.
            let folder = fs::canonicalize(folder_of(&path));
            return Ok(match (folder, path.file_name()) {
                (Ok(folder), Some(name)) if folder.is_dir() => folder.join(name),
                _ => path,
            });
        };
        // An absolute link replaces the whole path.
        path = folder_of(&path).join(link);
    }
    Err(io::Error::other("too many symbolic links"))
}

/// A file under its temporary name; removed on drop unless it was renamed.
#[derive(Debug)]
pub struct Temporary {
    file: File,
    /// The temporary name.
    path: PathBuf,
    target: PathBuf,
    is_done: bool,
}

impl Temporary {
    /// A new file in the folder of `target`, with these permissions or those of any new file.
    ///
    /// # Errors
    /// If the file cannot be created, or given the permissions.
    pub fn beside(target: &Path, permissions: Option<Permissions>) -> io::Result<Self> {
        let name = target.file_name().unwrap_or_default();
        let hash = fnv_1a(name.as_encoded_bytes());
        for number in 0..MOST_WRITERS {
            // The target's name may be as long as names can be.
            let path = folder_of(target).join(format!(".octray-{hash:016x}-{number}.tmp"));
            let mut temporaries = temporaries();
            let claimed = claim(&path).map_err(|error| said(error, folder_of(target)))?;
            if let Some(file) = claimed {
                temporaries.push(path.clone());
                drop(temporaries);
                let this = Self {
                    file,
                    path,
                    target: target.to_path_buf(),
                    is_done: false,
                };
                permissions.map_or(Ok(()), |permissions| this.file.set_permissions(permissions))?;
                return Ok(this);
            }
        }
        Err(io::Error::other(format!(
            "{MOST_WRITERS} others are writing it, or have left .octray-{hash:016x}-*.tmp in its folder"
        )))
    }

    /// Writes all of `bytes`, in pieces: the system locks a file during a call, and [`abandon`] would have to wait for it.
    ///
    /// # Errors
    /// What the system says.
    pub fn write_all(&mut self, bytes: &[u8]) -> io::Result<()> {
        const PIECE: usize = 1 << 20;
        bytes
            .chunks(PIECE)
            .try_for_each(|piece| self.file.write_all(piece))
    }

    /// To write to.
    pub fn file(&mut self) -> &mut File {
        &mut self.file
    }

    /// Gives it its name.
    ///
    /// There is no `fsync`: a picture can be rendered again, and waiting for the disk would take longer than most renders.
    ///
    /// # Errors
    /// What the system says.
    pub fn persist(mut self) -> io::Result<()> {
        let mut temporaries = temporaries();
        fs::rename(&self.path, &self.target)?;
        temporaries.retain(|path| *path != self.path);
        self.is_done = true;
        Ok(())
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if !self.is_done {
            // If this fails, the next writer of the same target removes it.
            let mut temporaries = temporaries();
            let _ = fs::remove_file(&self.path);
            temporaries.retain(|path| *path != self.path);
        }
    }
}

/// The error that no file can be made in a folder. That of /proc and the like is "not found", as if there were no folder.
fn said(error: io::Error, folder: &Path) -> io::Error {
    if error.kind() == io::ErrorKind::NotFound && folder.is_dir() {
        return io::Error::other("its directory does not accept new files");
    }
    error
}

/// Creates a file of that name for this process alone; `None` if another process holds it.
///
/// An existing file is never written to: in a shared folder it could be a link to something else. It is removed if
/// nobody holds its lock, and created again. Only the holder of the lock removes or renames such a file, and a lock counts
/// only while the locked file has the name.
fn claim(path: &Path) -> io::Result<Option<File>> {
    for _ in 0..MOST_TRIES {
        match OpenOptions::new().write(true).create_new(true).open(path) {
            Ok(file) => match file.try_lock() {
                // Somebody may have taken it for a stale one between the two steps.
                Ok(()) if is_at(&file, path) => return Ok(Some(file)),
                Ok(()) | Err(TryLockError::WouldBlock) => {}
                // A file system without locks.
                Err(TryLockError::Error(_)) => return Ok(Some(file)),
            },
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                if !remove_stale(path) {
                    return Ok(None);
                }
            }
            Err(error) => return Err(error),
        }
    }
    Ok(None)
}

/// Removes the file that a killed process has left. Returns whether the name may be tried again.
fn remove_stale(path: &Path) -> bool {
    // This program creates neither links nor pipes, and opening a pipe would block.
    match fs::symlink_metadata(path) {
        Ok(found) if found.is_file() => {}
        Ok(_) => return false,
        Err(error) => return error.kind() == io::ErrorKind::NotFound,
    }
    let mut options = OpenOptions::new();
    #[cfg(unix)]
    {
        use std::os::unix::fs::OpenOptionsExt;
        // It may have been replaced by one since.
        options.custom_flags(libc::O_NOFOLLOW | libc::O_NONBLOCK);
    }
    match options.read(true).open(path) {
        Ok(file) => {
            let is_stale = file.try_lock().is_ok();
            is_stale && (!is_at(&file, path) || fs::remove_file(path).is_ok())
        }
        Err(error) => error.kind() == io::ErrorKind::NotFound,
    }
}

/// Whether an open file is the one that has this name.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let identity = |found: fs::Metadata| (found.dev(), found.ino());
    match (file.metadata(), fs::symlink_metadata(path)) {
        (Ok(file), Ok(found)) => identity(file) == identity(found),
        _ => false,
    }
}

/// Other systems do not let open files be replaced.
#[cfg(not(unix))]
fn is_at(_: &File, path: &Path) -> bool {
    path.exists()
}

/// The hash FNV-1a: the same in every build, unlike the standard library's.
fn fnv_1a(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, &byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

/// The folder of a file, "." for a bare name.
pub fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

#[cfg(test)]
mod tests;

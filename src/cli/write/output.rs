//! The output of a picture: checked before rendering, written whole or not at all.

use super::{
    encode::Format,
    picture::Picture,
    replace::{Identity, identity, is_foreign},
};
use crate::{
    cli::{
        CliError,
        plan::{Origin, PictureOptions, PicturePath, is_standard_stream},
        report,
    },
    error::clip_path,
    render::Transfer,
    whole_file::{Temporary, folder_of, follow_links},
};
use std::{
    fs::{self, File, OpenOptions, Permissions},
    io::{self, Write},
    path::{Path, PathBuf, is_separator},
};

/// Where to write, and how.
#[derive(Debug)]
enum Place {
    /// Standard output, and the file that it is redirected to.
    Stdout(Option<Identity>),
    /// A device, a named pipe, ...: written to directly, because replacing it would make it a file.
    Special(PathBuf),
    /// A file, old or new: replaced in one step. Symbolic links are resolved, so that they stay.
    File {
        path: PathBuf,
        /// The existing file.
        old: Option<Old>,
    },
}

/// A file that will be replaced.
#[derive(Debug)]
struct Old {
    permissions: Permissions,
    identity: Option<Identity>,
    is_foreign: bool,
}

/// An output that is being written.
#[derive(Debug)]
pub enum Opened {
    Stdout,
    Special(File),
    File(Temporary),
}

/// A checked place for a picture.
#[derive(Debug)]
pub struct Output {
    name: String,
    full_name: String,
    origin: Origin,
    /// Replaces no file that octray did not write.
    is_careful: bool,
    /// Is synced to disk before it gets its name.
    is_synced: bool,
    place: Place,
    format: Format,
}

/// Whether a new file's name has backslashes where a folder would need `/`.
fn has_backslash(path: &Path) -> bool {
    let with_slashes = path.to_string_lossy().replace('\\', "/");
    let is_folder = Path::new(&with_slashes).parent().is_some_and(Path::is_dir);
    !cfg!(windows) && path != Path::new(&with_slashes) && is_folder && !path.exists()
}

impl Output {
    /// Checks that a picture of `width` x `height` can be written to `path`, as far as that can be known
    /// without writing it. With `force` it may replace any file.
    ///
    /// # Errors
    /// [`CliError::Usage`] for an unknown extension or a terminal, [`CliError::Failed`] for a folder that is
    /// missing or not writable, and the like.
    pub fn prepare(
        PicturePath { path, origin }: &PicturePath,
        (width, height): (u32, u32),
        force: bool,
    ) -> Result<Self, CliError> {
        if *origin == Origin::Typed && has_backslash(path) {
            let name = clip_path(path);
            return Err(CliError::Usage(format!("{name}: write `/` instead of `\\`")));
        }
        let (name, place, format) = if is_standard_stream(path) {
            Self::stdout()?
        } else {
            Self::file(path)?
        };
        format.check_size(width, height)?;
        let full_name = match place {
            Place::Stdout(_) => name.clone(),
            Place::Special(_) | Place::File { .. } => path.to_string_lossy().into_owned(),
        };
        Ok(Self {
            name,
            full_name,
            origin: *origin,
            is_careful: *origin == Origin::Derived && !force,
            is_synced: false,
            place,
            format,
        })
    }

    /// Syncs the file to disk before it gets its name. If a later call relies on names, a power cut or a server that reports
    /// its full disk late must not leave a truncated file.
    pub fn synced_if(mut self, is_synced: bool) -> Self {
        self.is_synced = is_synced;
        self
    }

    /// Whether it is synced to disk before it gets its name.
    pub fn is_synced(&self) -> bool {
        self.is_synced
    }

    /// Its name in messages.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The whole name, which may hold anything.
    pub fn full_name(&self) -> &str {
        &self.full_name
    }

    /// Who chose its name.
    pub fn origin(&self) -> Origin {
        self.origin
    }

    /// Whether it is a file, old or new, and no device or pipe.
    pub fn is_file(&self) -> bool {
        matches!(self.place, Place::File { .. })
    }

    /// Whether the file exists already.
    pub fn exists(&self) -> bool {
        self.old().is_some()
    }

    fn old(&self) -> Option<&Old> {
        match &self.place {
            Place::File { old, .. } => old.as_ref(),
            Place::Stdout(_) | Place::Special(_) => None,
        }
    }

    /// The file that will be replaced or written to.
    pub fn replaced(&self) -> Option<&Identity> {
        match &self.place {
            Place::Stdout(file) => file.as_ref(),
            _ => self.old()?.identity.as_ref(),
        }
    }

    /// Whether a file exists that octray did not write.
    pub fn replaces_foreign(&self) -> bool {
        self.old().is_some_and(|old| old.is_foreign)
    }

    /// Refuses to replace a file that octray did not write, unless the user typed its name or forces it.
    ///
    /// # Errors
    /// [`CliError::Failed`].
    pub fn check_foreign(&self) -> Result<(), CliError> {
        if !(self.is_careful && self.replaces_foreign()) {
            return Ok(());
        }
        let why = if self.format.has_mark() {
            "was not written by octray"
        } else {
            "may be another program's (QOI files do not say who wrote them)"
        };
        Err(CliError::Failed(format!(
            "{} exists and {why}; name another file with -o or replace it with --force",
            self.name
        )))
    }

    /// Whether it is an EXR file, which holds linear floats and any channels.
    pub fn is_exr(&self) -> bool {
        self.format == Format::Exr
    }

    /// One path for all names of a place; "-" for standard output.
    pub fn place(&self) -> &Path {
        match &self.place {
            Place::Stdout(_) => Path::new("-"),
            Place::Special(path) | Place::File { path, .. } => path,
        }
    }

    fn stdout() -> Result<(String, Place, Format), CliError> {
        report::check_stdout()?;
        if report::prints_to_terminal() {
            return Err(CliError::Usage(
                "will not write a PNG to a terminal: redirect it with > or |".into(),
            ));
        }
        let file = Path::new("/dev/stdout");
        let file = fs::metadata(file).ok().and_then(|found| identity(file, &found));
        Ok(("standard output".into(), Place::Stdout(file), Format::Png))
    }

    fn file(path: &Path) -> Result<(String, Place, Format), CliError> {
        let name = clip_path(path);
        let found = match fs::metadata(path) {
            // Otherwise only writing the finished picture would fail.
            Err(error) if error.kind() == io::ErrorKind::InvalidFilename => {
                return Err(CliError::writing(&name, &error));
            }
            found => found.ok(),
        };
        if names_directory(path) || found.as_ref().is_some_and(fs::Metadata::is_dir) {
            return Err(CliError::Failed(format!(
                "cannot write {name}: it is a directory; name a file in it, such as {}",
                clip_path(&path.join("{stem}.png"))
            )));
        }
        let special = found.as_ref().is_some_and(|found| !found.is_file());
        let format = match path.extension() {
            Some(extension) => Format::from_extension(extension),
            None if special => Some(Format::Png),
            None => None,
        };
        let format = format.ok_or_else(|| Format::unknown(path))?;
        if special {
            return Ok((name, Place::Special(path.to_owned()), format));
        }
        let path = follow_links(path).map_err(|error| CliError::writing(&name, &error))?;
        check_writable(&path, found.is_some(), &name)?;
        let old = found.map(|found| Old {
            permissions: found.permissions(),
            identity: identity(&path, &found),
            is_foreign: is_foreign(&path),
        });
        Ok((name, Place::File { path, old }, format))
    }

    /// An empty picture of the kind that will be written.
    pub fn new_picture(&self, options: &PictureOptions) -> Picture {
        Picture::new(self.format, options)
    }

    /// Whether the options suit the format.
    ///
    /// # Errors
    /// [`CliError::Usage`], with valid alternatives.
    pub fn check(&self, options: &PictureOptions) -> Result<(), CliError> {
        let name = &self.name;
        if options.backdrop.is_transparent() && !self.format.has_alpha() {
            return Err(CliError::Usage(format!(
                "{name}: this format has no alpha channel, expected .png, .qoi, .tiff, .tif, .exr, or .apng for animations"
            )));
        }
        if options.transfer == Transfer::Srgb && self.format == Format::Exr {
            return Err(CliError::Usage(format!(
                "{name}: EXR holds linear floats; leave out --srgb, or use another format"
            )));
        }
        Ok(())
    }

    /// The format of the file.
    pub fn format(&self) -> Format {
        self.format
    }

    /// Whether it will hold all frames of a turntable.
    pub fn is_animation(&self) -> bool {
        self.format.is_animation()
    }

    /// Whether a turntable's frames go there, or one picture. Standard output takes an animation as Y4M.
    ///
    /// # Errors
    /// [`CliError::Usage`] for an animation without a turntable.
    pub fn for_turntable(mut self, is_turning: bool) -> Result<Self, CliError> {
        if is_turning && matches!(self.place, Place::Stdout(_)) {
            self.format = Format::Y4m;
        }
        if self.is_animation() && !is_turning {
            return Err(CliError::Usage(format!(
                "{}: an animation of one frame; add --turntable N, take a scene with keyframes (`at`) or a glTF file with an animation, or name a picture such as .png",
                self.name
            )));
        }
        Ok(self)
    }

    /// Begins to write: nothing is at a file's place until it is [closed](Self::close).
    ///
    /// # Errors
    /// [`CliError`].
    pub fn open(&self) -> Result<Opened, CliError> {
        let opened = match &self.place {
            Place::Stdout(_) => Ok(Opened::Stdout),
            Place::Special(path) => OpenOptions::new().write(true).open(path).map(Opened::Special),
            Place::File { path, old } => {
                let permissions = old.as_ref().map(|old| old.permissions.clone());
                Temporary::beside(path, permissions).map(Opened::File)
            }
        };
        opened.map_err(|error| CliError::writing(&self.name, &error))
    }

    /// Adds bytes.
    ///
    /// # Errors
    /// [`CliError`].
    pub fn append(&self, opened: &mut Opened, bytes: &[u8]) -> Result<(), CliError> {
        let written = match opened {
            Opened::Stdout => return report::print_bytes(bytes),
            Opened::Special(file) => file.write_all(bytes),
            Opened::File(temporary) => temporary.write_all(bytes),
        };
        written.map_err(|error| CliError::writing(&self.name, &error))
    }

    /// Gives a file its name.
    ///
    /// # Errors
    /// [`CliError`].
    pub fn close(&self, opened: Opened) -> Result<(), CliError> {
        let closed = match (opened, &self.place) {
            (Opened::File(temporary), Place::File { path, .. }) => self.persist(temporary, path),
            _ => Ok(()),
        };
        closed.map_err(|error| CliError::writing(&self.name, &error))
    }

    /// Encodes and writes the picture. On failure the place is as it was before (a device or a pipe may have
    /// got a part).
    ///
    /// # Errors
    /// [`CliError`].
    pub fn write(&self, picture: &mut Picture) -> Result<(), CliError> {
        let bytes = self.format.encode(picture)?;
        self.write_bytes(&bytes)
    }

    /// Writes the bytes of an encoded picture, as [`Self::write`] does.
    ///
    /// # Errors
    /// [`CliError`].
    pub fn write_bytes(&self, bytes: &[u8]) -> Result<(), CliError> {
        let mut opened = self.open()?;
        self.append(&mut opened, bytes)?;
        self.close(opened)
    }

    fn persist(&self, mut temporary: Temporary, path: &Path) -> io::Result<()> {
        if self.is_synced {
            match temporary.file().sync_all() {
                // A file system that cannot.
                Err(error)
                    if matches!(
                        error.kind(),
                        io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported
                    ) => {}
                synced => synced?,
            }
        }
        if self.is_careful && is_foreign(path) {
            return Err(io::Error::other(
                "another program has created a file of this name meanwhile",
            ));
        }
        temporary.persist()
    }
}

/// Whether a path ends as a directory's, which may not exist.
pub fn names_directory(path: &Path) -> bool {
    let last = path.as_os_str().as_encoded_bytes().last();
    last.is_some_and(|&byte| is_separator(char::from(byte)))
}

/// Whether the file may be replaced or made, found out without changing it.
pub fn check_writable(path: &Path, exists: bool, name: &str) -> Result<(), CliError> {
    let folder = folder_of(path);
    if !folder.is_dir() {
        let what = if folder.exists() {
            format!("`{}` is a file, expected a directory", clip_path(folder))
        } else {
            format!("directory `{}` does not exist", clip_path(folder))
        };
        return Err(CliError::Failed(format!("cannot write {name}: {what}")));
    }
    // Replacing would not ask for the old file's permission, so ask here.
    let old: io::Result<Option<File>> = if exists {
        OpenOptions::new().write(true).open(path).map(Some)
    } else {
        Ok(None)
    };
    old.and_then(|_| Temporary::beside(path, None))
        .map(drop)
        .map_err(|error| CliError::writing(name, &error))
}

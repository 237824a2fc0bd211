//! Notices when files change, and loads the scene again.

use super::{
    Host, Loaded, Loading, loading,
    pose::Pose,
    sources::{Sources, is_same},
    timeline::{Model, Timeline},
};
use crate::accel::BuildQuality;
use notify::{
    EventKind, RecommendedWatcher, RecursiveMode, Watcher,
    event::{ModifyKind, RenameMode},
};
use std::{
    collections::{HashMap, HashSet},
    fs::{self, Metadata},
    path::{Path, PathBuf},
    sync::{
        Arc,
        mpsc::{self, Receiver, RecvTimeoutError, Sender},
    },
    time::{Duration, Instant},
};

/// Programs write files in pieces. A change is complete when nothing has followed for this long.
const QUIET: Duration = Duration::from_millis(120);
/// How often to look whether folders are still those that are watched: the system tells nothing of the folders above them.
const LOOK: Duration = Duration::from_millis(if cfg!(test) { 250 } else { 1000 });

/// The scene, loaded again, with its starting camera, or the error.
pub type Reloaded = Result<(Arc<Timeline>, Pose), String>;

/// Why the scene is loaded again.
#[derive(Debug)]
enum Change {
    /// Something changed at this path.
    At(PathBuf),
    /// What was at this path is removed or moved away.
    Removed(PathBuf),
    /// The window requested it, or anything may have changed.
    Asked,
}

/// Loads the scene again on request.
#[derive(Clone, Debug)]
pub struct Reload(Sender<Change>);

impl Reload {
    /// Requests that the scene is loaded again.
    pub fn ask(&self) {
        // Fails if the thread panicked: then nothing reloads.
        let _ = self.0.send(Change::Asked);
    }
}

/// Watches files on another thread until the process ends, and loads again what changed since it was read. If the system cannot
/// watch files, the scene is reloaded only on request, if a folder is replaced, or if a file changed while it was loaded.
///
/// # Errors
/// Why the system refuses the thread.
pub fn start(
    host: Arc<dyn Host>,
    sources: Sources,
    quality: BuildQuality,
    progress: Loading,
    tell: impl Fn(Reloaded) + Send + 'static,
) -> Result<Reload, String> {
    let (sender, changes) = mpsc::channel();
    let reload = Reload(sender.clone());
    super::on_thread(move || {
        let mut watched = Watched::new(sender);
        watched.add(sources.files);
        let mut is_late = sources.states.have_changed();
        while watched.wait(&changes, is_late).is_some() {
            let (loaded, sources) = host.load(&progress);
            // A faulty scene may name fewer files than before: all stay watched.
            watched.add(sources.files);
            is_late = sources.states.have_changed();
            tell(loaded.map(|Loaded { scene, frames, pose }| {
                let bvh = loading::build_bvh(&scene, quality, &progress);
                let timeline = Timeline::with_frames(Model::new(scene, bvh), frames);
                (Arc::new(timeline), pose)
            }));
        }
    })?;
    Ok(reload)
}

/// Files and their folders. Folders are watched because editors replace files.
struct Watched {
    /// `None` where the system cannot watch files.
    watcher: Option<RecommendedWatcher>,
    /// All files, as the scene names them.
    named: HashSet<PathBuf>,
    /// The same as the system reports them.
    files: HashSet<PathBuf>,
    folders: HashMap<PathBuf, Folder>,
    /// When the folders are looked at next.
    next_look: Instant,
}

/// A watched folder.
struct Folder {
    /// Its path without links, if it exists.
    real: Option<PathBuf>,
    /// What was at its path; `None` if that is gone.
    state: Option<Metadata>,
}

impl Watched {
    fn new(changes: Sender<Change>) -> Self {
        let watcher = notify::recommended_watcher(move |event: notify::Result<notify::Event>| {
            let Ok(event) = event else { return };
            if event.need_rescan() {
                // The system has dropped events.
                let _ = changes.send(Change::Asked);
            }
            let change = match event.kind {
                EventKind::Access(_) => return,
                // `notify` ends the watch of a folder that moves, even if it comes back.
                EventKind::Remove(_)
                | EventKind::Modify(ModifyKind::Name(RenameMode::From | RenameMode::Any)) => Change::Removed,
                _ => Change::At,
            };
            for path in event.paths {
                // Fails when the process is about to end.
                let _ = changes.send(change(path));
            }
        });
        Self {
            watcher: watcher.ok(),
            named: HashSet::new(),
            files: HashSet::new(),
            folders: HashMap::new(),
            next_look: Instant::now() + LOOK,
        }
    }

    fn add(&mut self, files: impl IntoIterator<Item = PathBuf>) {
        for file in files {
            self.add_at(&file);
            // What a link leads to.
            if let Ok(real) = fs::canonicalize(&file) {
                self.add_at(&real);
            }
            self.named.insert(file);
        }
    }

    /// Adds the file of this path and its folder.
    fn add_at(&mut self, file: &Path) {
        let folder = match file.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        if !self.folders.contains_key(folder) {
            // Before it is watched, so that another one that takes its place is noticed.
            let state = fs::metadata(folder).ok();
            let real = fs::canonicalize(folder).ok();
            if let (Some(watcher), Some(real)) = (&mut self.watcher, &real) {
                // Fails beyond the system's limit.
                let _ = watcher.watch(real, RecursiveMode::NonRecursive);
            }
            self.folders.insert(folder.to_owned(), Folder { real, state });
        }
        let real = self.folders.get(folder).and_then(|folder| folder.real.as_ref());
        if let (Some(real), Some(name)) = (real, file.file_name()) {
            self.files.insert(real.join(name));
        }
    }

    /// Waits until a reload is requested, or a watched file has changed and settled; the latter only if it `is_late` already.
    /// `None` if neither can happen.
    fn wait(&mut self, changes: &Receiver<Change>, is_late: bool) -> Option<()> {
        let mut has_changed = is_late;
        while !has_changed {
            let now = Instant::now();
            if now >= self.next_look {
                has_changed = self.look();
                continue;
            }
            match changes.recv_timeout(self.next_look - now) {
                Ok(Change::Asked) => {
                    // One load answers all that has come.
                    for change in changes.try_iter() {
                        self.forget(&change);
                    }
                    self.look();
                    return Some(());
                }
                Ok(change) => has_changed = self.concerns(&change),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return None,
            }
        }
        let mut last = Instant::now();
        while let Some(left) = QUIET.checked_sub(last.elapsed()) {
            match changes.recv_timeout(left) {
                Ok(change) if self.concerns(&change) => last = Instant::now(),
                Ok(_) | Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return None,
            }
        }
        self.look();
        Some(())
    }

    /// Whether a change is one of a watched file or folder.
    fn concerns(&mut self, change: &Change) -> bool {
        self.forget(change);
        match change {
            Change::Asked => true,
            Change::At(path) | Change::Removed(path) => {
                let is_folder = self
                    .folders
                    .values()
                    .any(|folder| folder.real.as_ref() == Some(path));
                self.files.contains(path) || is_folder && self.look()
            }
        }
    }

    /// Forgets the state of a folder that has gone: one that is made again, or comes back, may have the same.
    fn forget(&mut self, change: &Change) {
        if let Change::Removed(path) = change {
            for folder in self
                .folders
                .values_mut()
                .filter(|folder| folder.real.as_ref() == Some(path))
            {
                folder.state = None;
            }
        }
    }

    /// Looks whether each folder is the one that is watched. If not, watches all anew and returns true.
    fn look(&mut self) -> bool {
        self.next_look = Instant::now() + LOOK;
        let is_here = |(path, folder): (&PathBuf, &Folder)| {
            is_same(folder.state.as_ref(), fs::metadata(path).ok().as_ref())
        };
        if self.folders.iter().all(is_here) {
            return false;
        }
        for (_, folder) in self.folders.drain() {
            if let (Some(watcher), Some(real)) = (&mut self.watcher, &folder.real) {
                // Fails if the watch has gone with its folder.
                let _ = watcher.unwatch(real);
            }
        }
        self.files.clear();
        let named = std::mem::take(&mut self.named);
        self.add(named);
        true
    }
}

#[cfg(test)]
mod tests;

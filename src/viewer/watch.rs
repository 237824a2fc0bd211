//! Notices when files change, and loads the scene again.

use super::{
    Host, Loaded, Loading, loading,
    pose::Pose,
    timeline::{Model, Timeline},
};
use crate::accel::BuildQuality;
use notify::{EventKind, RecommendedWatcher, RecursiveMode, Watcher};
use std::{
    collections::HashSet,
    fs,
    path::{Path, PathBuf},
    sync::{
        Arc,
        mpsc::{self, Receiver, RecvTimeoutError, Sender},
    },
    thread,
    time::Duration,
};

/// Programs write files in pieces. A change is complete when nothing has followed for this long.
const QUIET: Duration = Duration::from_millis(120);

/// The scene, loaded again, with its starting camera, or the error.
pub type Reloaded = Result<(Arc<Timeline>, Pose), String>;

/// Why the scene is loaded again.
#[derive(Debug)]
enum Change {
    /// This file changed.
    File(PathBuf),
    /// The window requested it.
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

/// Watches `files` on another thread until the process ends. If the system cannot watch files, the scene is reloaded only on
/// request.
pub fn start(
    host: Arc<dyn Host>,
    files: Vec<PathBuf>,
    quality: BuildQuality,
    progress: Loading,
    tell: impl Fn(Reloaded) + Send + 'static,
) -> Reload {
    let (sender, changes) = mpsc::channel();
    let reload = Reload(sender.clone());
    thread::spawn(move || {
        let mut watched = Watched::new(sender);
        watched.add(&files);
        while watched.wait(&changes).is_some() {
            let (loaded, files) = host.load(&progress);
            // A faulty scene may name fewer files than before: all stay watched.
            watched.add(&files);
            tell(loaded.map(|Loaded { scene, frames, pose }| {
                let bvh = loading::build_bvh(&scene, quality, &progress);
                let timeline = Timeline::with_frames(Model::new(scene, bvh), frames);
                (Arc::new(timeline), pose)
            }));
        }
    });
    reload
}

/// Files and their folders. Folders are watched because editors replace files.
struct Watched {
    /// `None` where the system cannot watch files.
    watcher: Option<RecommendedWatcher>,
    files: HashSet<PathBuf>,
    folders: HashSet<PathBuf>,
}

impl Watched {
    fn new(changes: Sender<Change>) -> Self {
        let watcher = notify::recommended_watcher(move |event: notify::Result<notify::Event>| {
            if let Ok(event) = event
                && !matches!(event.kind, EventKind::Access(_))
            {
                for path in event.paths {
                    // Fails when the process is about to end.
                    let _ = changes.send(Change::File(path));
                }
            }
        });
        Self {
            watcher: watcher.ok(),
            files: HashSet::new(),
            folders: HashSet::new(),
        }
    }

    fn add(&mut self, files: &[PathBuf]) {
        for file in files {
            for path in [in_real_folder(file), fs::canonicalize(file).ok()]
                .into_iter()
                .flatten()
            {
                if let Some(folder) = path.parent()
                    && !self.folders.contains(folder)
                    && let Some(watcher) = &mut self.watcher
                    && watcher.watch(folder, RecursiveMode::NonRecursive).is_ok()
                {
                    self.folders.insert(folder.to_owned());
                }
                self.files.insert(path);
            }
        }
    }

    /// Waits until a reload is requested, or a watched file has changed and settled. `None` if neither can happen.
    fn wait(&self, changes: &Receiver<Change>) -> Option<()> {
        loop {
            match changes.recv().ok()? {
                Change::Asked => return Some(()),
                Change::File(path) if self.files.contains(&path) => break,
                Change::File(_) => {}
            }
        }
        loop {
            match changes.recv_timeout(QUIET) {
                Ok(_) => {}
                Err(RecvTimeoutError::Timeout) => return Some(()),
                Err(RecvTimeoutError::Disconnected) => return None,
            }
        }
    }
}

/// The file's path with links in its folder resolved, as the system reports it.
fn in_real_folder(file: &Path) -> Option<PathBuf> {
    let folder = match file.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    Some(fs::canonicalize(folder).ok()?.join(file.file_name()?))
}

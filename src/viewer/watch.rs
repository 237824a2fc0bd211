//! Notices when files change, and loads the scene again.

use super::{Host, look::Model};
use crate::accel::{BuildQuality, Bvh};
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

/// Programs write files in pieces: it is over when nothing has come for so long.
const QUIET: Duration = Duration::from_millis(120);

/// What came of loading the scene again: the scene, or what is wrong with it.
pub type Reloaded = Result<Arc<Model>, String>;

/// Watches `files` from a thread of its own until the process ends. Where the system cannot watch files, there is no
/// reload.
pub fn start(
    host: Arc<dyn Host>,
    files: Vec<PathBuf>,
    quality: BuildQuality,
    tell: impl Fn(Reloaded) + Send + 'static,
) {
    thread::spawn(move || {
        let (sender, changes) = mpsc::channel();
        if let Some(mut watched) = Watched::new(sender) {
            watched.add(&files);
            while watched.wait(&changes).is_some() {
                let (scene, files) = host.load();
                // What could not be loaded may name fewer files than before: all stay watched.
                watched.add(&files);
                tell(scene.map(|scene| {
                    let bvh = Bvh::build_with(&scene, quality);
                    Arc::new(Model { scene, bvh })
                }));
            }
        }
    });
}

/// Files and the folders that they are in: a file that is replaced is another file in the same folder.
struct Watched {
    watcher: RecommendedWatcher,
    files: HashSet<PathBuf>,
    folders: HashSet<PathBuf>,
}

impl Watched {
    fn new(changes: Sender<PathBuf>) -> Option<Self> {
        let watcher = notify::recommended_watcher(move |event: notify::Result<notify::Event>| {
            if let Ok(event) = event
                && !matches!(event.kind, EventKind::Access(_))
            {
                for path in event.paths {
                    // Nobody listens any more: the process is about to end.
                    let _ = changes.send(path);
                }
            }
        })
        .ok()?;
        Some(Self {
            watcher,
            files: HashSet::new(),
            folders: HashSet::new(),
        })
    }

    fn add(&mut self, files: &[PathBuf]) {
        for file in files {
            for path in [in_real_folder(file), fs::canonicalize(file).ok()]
                .into_iter()
                .flatten()
            {
                if let Some(folder) = path.parent()
                    && !self.folders.contains(folder)
                    && self.watcher.watch(folder, RecursiveMode::NonRecursive).is_ok()
                {
                    self.folders.insert(folder.to_owned());
                }
                self.files.insert(path);
            }
        }
    }

    /// Waits until a watched file has changed, and then until it changes no more. `None` if that can never be.
    fn wait(&self, changes: &Receiver<PathBuf>) -> Option<()> {
        while !self.files.contains(&changes.recv().ok()?) {}
        loop {
            match changes.recv_timeout(QUIET) {
                Ok(_) => {}
                Err(RecvTimeoutError::Timeout) => return Some(()),
                Err(RecvTimeoutError::Disconnected) => return None,
            }
        }
    }
}

/// The file's path with a folder that is no link: as the system names it when it changes.
fn in_real_folder(file: &Path) -> Option<PathBuf> {
    let folder = match file.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    Some(fs::canonicalize(folder).ok()?.join(file.file_name()?))
}

//! Tests of `watch`.

use super::*;
use tempfile::TempDir;

/// Watches files. Sends itself when that has changed.
struct Watch {
    watched: Watched,
    changes: Receiver<Change>,
}

impl Watch {
    fn new(files: impl IntoIterator<Item = PathBuf>) -> Self {
        let (sender, changes) = mpsc::channel();
        let mut watched = Watched::new(sender);
        watched.add(files);
        Self { watched, changes }
    }

    /// Expects that `what` is noticed.
    fn notices(mut self, what: &str) -> Self {
        let (sender, done) = mpsc::channel();
        std::thread::spawn(move || {
            if self.watched.wait(&self.changes, false).is_some() {
                let _ = sender.send(self);
            }
        });
        done.recv_timeout(Duration::from_secs(20)).expect(what)
    }

    /// Whether anything comes until the folders have been looked at again.
    fn is_quiet(&mut self) -> bool {
        let end = Instant::now() + LOOK;
        let mut is_quiet = true;
        while is_quiet && Instant::now() < end {
            is_quiet = match self.changes.recv_timeout(LOOK / 4) {
                Ok(change) => !self.watched.concerns(&change),
                Err(_) => !self.watched.look(),
            };
        }
        is_quiet
    }

    /// Expects an end of changes. A busy machine reports some late.
    fn settles(mut self) -> Self {
        assert!((0..10).any(|_| self.is_quiet()));
        self
    }
}

#[test]
fn a_folder_that_is_replaced_stays_watched() {
    let folder = TempDir::new().unwrap();
    let [above, other] = ["above", "other"].map(|name| folder.path().join(name));
    let [sub, new] = [above.join("sub"), above.join("new")];
    let file = sub.join("a.scn");
    for folder in [&sub, &new, &other.join("sub")] {
        fs::create_dir_all(folder).unwrap();
        fs::write(folder.join("a.scn"), "1").unwrap();
    }
    let watch = Watch::new([file.clone()]).settles();
    let write = |text: &str| fs::write(&file, text).unwrap();
    write("12");
    let mut watch = watch.notices("a file");
    for round in 0..2 {
        fs::rename(&sub, above.join(format!("old{round}"))).unwrap();
        fs::rename(&new, &sub).unwrap();
        watch = watch.notices("another folder");
        write("123");
        watch = watch.notices("a file in another folder").settles();
        // What is written into the old one is of no concern.
        fs::write(above.join(format!("old{round}/a.scn")), "1234").unwrap();
        assert!(watch.is_quiet());
        fs::create_dir(&new).unwrap();
        fs::write(new.join("a.scn"), "1").unwrap();
    }
    // Removed and made again, at once and later.
    for pause in [0, 10, 500] {
        fs::remove_dir_all(&sub).unwrap();
        std::thread::sleep(Duration::from_millis(pause));
        if pause > 250 {
            watch = watch.notices("a folder that is gone");
        }
        fs::create_dir(&sub).unwrap();
        write("12345");
        watch = watch.notices("a new folder");
        write("123456");
        watch = watch.notices("a file in a new folder");
    }
    // The folder above it.
    fs::rename(&above, folder.path().join("old")).unwrap();
    fs::rename(&other, &above).unwrap();
    let watch = watch.notices("another folder above");
    write("1234567");
    watch.notices("a file below another folder").settles();
}

/// Below a watched folder, too.
#[test]
fn a_folder_that_comes_back_stays_watched() {
    let folder = TempDir::new().unwrap();
    let [scene, sub, away] = ["a.scn", "sub", "away"].map(|name| folder.path().join(name));
    let file = sub.join("inc.txt");
    fs::create_dir(&sub).unwrap();
    for path in [&scene, &file] {
        fs::write(path, "1").unwrap();
    }
    let mut watch = Watch::new([scene, file.clone()]);
    for pause in [0, 30, 400] {
        fs::rename(&sub, &away).unwrap();
        std::thread::sleep(Duration::from_millis(pause));
        fs::rename(&away, &sub).unwrap();
        watch = watch.notices("a folder that moves").settles();
        fs::write(&file, "12").unwrap();
        watch = watch.notices("a file in a folder that came back").settles();
    }
}

#[cfg(unix)]
#[test]
fn what_a_link_leads_to_is_watched() {
    use std::os::unix::fs::symlink;

    let folder = TempDir::new().unwrap();
    let [one, two, link] = ["one", "two", "link"].map(|name| folder.path().join(name));
    for folder in [&one, &two] {
        fs::create_dir(folder).unwrap();
        fs::write(folder.join("a.scn"), "1").unwrap();
    }
    symlink(&one, &link).unwrap();
    let watch = Watch::new([link.join("a.scn")]);
    fs::write(one.join("a.scn"), "12").unwrap();
    let watch = watch.notices("a file behind a link");
    fs::remove_file(&link).unwrap();
    symlink(&two, &link).unwrap();
    let watch = watch.notices("another link");
    fs::write(two.join("a.scn"), "12").unwrap();
    watch.notices("a file behind another link").settles();
}

/// A file that is written all the time, beside a watched one, does not keep its changes from being noticed.
#[test]
fn other_files_do_not_delay_a_change() {
    let folder = TempDir::new().unwrap();
    let [file, log] = ["a.scn", "log"].map(|name| folder.path().join(name));
    fs::write(&file, "1").unwrap();
    let watch = Watch::new([file.clone()]);
    let (sender, end) = mpsc::channel::<()>();
    let busy = std::thread::spawn(move || {
        while matches!(end.try_recv(), Err(mpsc::TryRecvError::Empty)) {
            fs::write(&log, "1").unwrap();
            std::thread::sleep(Duration::from_millis(1));
        }
    });
    fs::write(&file, "12").unwrap();
    watch.notices("a file beside a busy one");
    drop(sender);
    busy.join().unwrap();
}

#[test]
fn requests_and_late_changes_need_no_event() {
    let folder = TempDir::new().unwrap();
    let (sender, changes) = mpsc::channel();
    let mut watched = Watched::new(sender.clone());
    watched.add([folder.path().join("missing/a.scn"), PathBuf::from("/")]);
    for _ in 0..3 {
        sender.send(Change::Asked).unwrap();
    }
    assert_eq!(watched.wait(&changes, false), Some(()));
    assert!(changes.try_recv().is_err(), "one load answers all requests");
    assert_eq!(watched.wait(&changes, true), Some(()));
    drop(sender);
    watched.watcher = None;
    assert_eq!(watched.wait(&changes, false), None);
}

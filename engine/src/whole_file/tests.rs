use super::*;

fn write_bytes(path: &Path, bytes: &[u8]) {
    write(path, |out| out.write_all(bytes)).unwrap();
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn a_file_appears_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a");
    write_bytes(&path, b"old");
    let failed = write(&path, |out| {
        out.write_all(&[0; 1 << 18])?;
        Err(io::Error::other("no more"))
    });
    assert_eq!(failed.unwrap_err().to_string(), "no more");
    assert_eq!(fs::read(&path).unwrap(), b"old");
    assert_eq!(names(folder.path()), ["a"]);
}

#[test]
#[cfg(unix)]
fn a_link_stays() {
    let folder = tempfile::tempdir().unwrap();
    let (file, link) = (folder.path().join("a"), folder.path().join("b"));
    fs::write(&file, "old").unwrap();
    std::os::unix::fs::symlink("a", &link).unwrap();
    write_bytes(&link, b"new");
    assert_eq!(fs::read(&file).unwrap(), b"new");
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    // Also a link to nothing.
    fs::remove_file(&file).unwrap();
    write_bytes(&link, b"newer");
    assert_eq!(fs::read(&file).unwrap(), b"newer");
}

#[test]
#[cfg(unix)]
fn permissions_and_devices_stay() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let (path, link) = (folder.path().join("a"), folder.path().join("b"));
    fs::write(&path, "mine").unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o600)).unwrap();
    write_bytes(&path, b"new");
    assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o600);
    std::os::unix::fs::symlink("/dev/null", &link).unwrap();
    write_bytes(&link, b"new");
    assert!(!fs::metadata("/dev/null").unwrap().is_file());
}

#[test]
fn what_others_are_writing_stays_and_what_they_left_goes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a");
    let first = Temporary::beside(&path, None).unwrap();
    let second = Temporary::beside(&path, None).unwrap();
    assert_ne!(first.path, second.path);
    let (first_path, second_path) = (first.path.clone(), second.path.clone());
    // As after SIGKILL: the file remains, the lock is gone.
    fs::write(&first_path, "half").unwrap();
    let stale = fs::read(&first_path).unwrap();
    drop(first);
    fs::write(&first_path, stale).unwrap();
    let third = Temporary::beside(&path, None).unwrap();
    assert_eq!(third.path, first_path);
    assert_eq!(fs::read(&first_path).unwrap(), b"");
    assert!(second_path.exists());
    third.persist().unwrap();
    drop(second);
    assert_eq!(names(folder.path()), ["a"]);
}

#[test]
#[cfg(unix)]
fn links_in_the_way_are_not_followed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a");
    let name = Temporary::beside(&path, None).unwrap().path.clone();
    fs::write(folder.path().join("other"), "other").unwrap();
    std::os::unix::fs::symlink("other", &name).unwrap();
    write_bytes(&path, b"new");
    assert_eq!(fs::read(folder.path().join("other")).unwrap(), b"other");
    assert!(fs::symlink_metadata(&name).unwrap().is_symlink());
    assert_eq!(fs::read(&path).unwrap(), b"new");
}

#[test]
fn many_writers_of_one_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a");
    std::thread::scope(|scope| {
        for letter in *b"abcdefgh" {
            let path = &path;
            scope.spawn(move || {
                for _ in 0..50 {
                    let all = vec![letter; 5000];
                    write_bytes(path, &all);
                }
            });
        }
    });
    let found = fs::read(&path).unwrap();
    assert!(found.len() == 5000 && found.iter().all(|&letter| letter == found[0]));
    assert_eq!(names(folder.path()), ["a"]);
}

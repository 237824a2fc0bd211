use super::*;

#[test]
#[cfg(target_os = "linux")]
fn the_machine_has_memory() {
    assert!(machine().is_some_and(|bytes| bytes > 1 << 24));
    assert!(default_limit() <= three_quarters(machine().unwrap_or(0)));
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
        // A group that is not visible from here has the limits of the visible groups around it.
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
    let bytes = PixelBytes {
        film: 3,
        ..PixelBytes::default()
    };
    let beside = |size, bytes| beside_picture(100_000_000, size, bytes).ok();
    assert_eq!(beside((1000, 1000), bytes), Some(89_000_000));
    assert_eq!(beside((4000, 4000), bytes), None);
    let layers = PixelBytes {
        film: 16,
        exr: true,
        aovs: true,
        compared: false,
    };
    assert_eq!(beside((1000, 1000), layers), None);
}

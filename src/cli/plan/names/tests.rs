use super::*;

fn name(pattern: &str, number: Option<u32>) -> String {
    let name = expand(Path::new(pattern), Path::new("herd/cow.scn"), number, None);
    name.into_os_string().into_string().unwrap()
}

#[test]
fn stems() {
    for (scene, expected) in [
        ("a/b.c.scn", "b.c"),
        ("b", "b"),
        (".scn", ".scn"),
        ("-", "stdin"),
        ("..", "octray"),
        ("", "octray"),
    ] {
        assert_eq!(stem(Path::new(scene)), expected, "{scene}");
    }
}

#[test]
fn patterns() {
    for (pattern, number, expected) in [
        ("a.png", None, "a.png"),
        ("out/{stem}.png", None, "out/cow.png"),
        ("{stem}/{stem}{stem}.png", None, "cow/cowcow.png"),
        ("a-####.png", Some(7), "a-0007.png"),
        ("a-#.png", Some(12345), "a-12345.png"),
        ("####", Some(0), "0000"),
        ("a#b##.png", Some(3), "a#b03.png"),
        ("a##{stem}.png", Some(3), "a03cow.png"),
        ("f##/a.png", Some(3), "f##/a.png"),
        ("f##/a#.png", Some(u32::MAX), "f##/a4294967295.png"),
        ("a####.png", None, "a####.png"),
        ("a.png", Some(3), "a.png"),
        ("{ste#m}", Some(3), "{ste3m}"),
        ("{{stem}}", None, "{cow}"),
        ("{stem", None, "{stem"),
        ("{folder}/{stem}.png", None, "herd/cow.png"),
        ("{folder}{", None, "herd{"),
        ("", Some(1), ""),
        ("ä#ö", Some(1), "ä1ö"),
    ] {
        assert_eq!(name(pattern, number), expected, "{pattern}");
    }
    let odd = Path::new("a#{folder}{pose}.scn");
    for (pattern, expected) in [
        ("{stem}-##.png", "a#{folder}{pose}-01.png"),
        ("{pose}-##.png", "b#{stem}-01.png"),
        ("{pose}{stem}", "b#{stem}a#{folder}{pose}"),
    ] {
        let name = expand(Path::new(pattern), odd, Some(1), Some("b#{stem}"));
        assert_eq!(name, Path::new(expected), "{pattern}");
    }
    assert_eq!(name("{pose}.png", Some(1)), "{pose}.png");
}

#[test]
fn a_frame_alone_has_the_name_that_it_has_among_others() {
    assert_eq!(of_frame(Some("{stem}/a-##.png"), 1), "{stem}/a-01.png");
    assert_eq!(of_frame(Some("a.png"), 1), "a.png");
    assert_eq!(of_frame(None, 12), "{stem}-0012.png");
}

#[test]
fn unknown_placeholders() {
    for (pattern, unknown) in [
        ("{stem}-{folder}-{pose}.png", None),
        ("{dir}/{stem}.png", Some("{dir}")),
        ("{{name}}", Some("{name}")),
        ("{A}{}{a b}{stem{x", None),
    ] {
        assert_eq!(unknown_placeholder(Path::new(pattern)), unknown, "{pattern}");
    }
}

/// Only the file's name has a number.
#[test]
fn numbers_of_other_programs() {
    for (pattern, better) in [
        ("x%d/a%d.png", "x%d/a####.png"),
        ("a%03d.png", "a###.png"),
        ("a%d-##.png", "a-##.png"),
    ] {
        let why = check_pattern(Path::new(pattern), true).expect_err(pattern);
        assert!(why.ends_with(&format!("such as {better}")), "{why}");
    }
    assert_eq!(check_pattern(Path::new("x%d/a.png"), true), Ok(()));
}

#[test]
fn patterns_that_keep_poses_apart() {
    for (pattern, better) in [
        ("{pose}.png", Some("{pose}_#.png")),
        ("b.c/{pose}", Some("b.c/{pose}_#")),
        ("{pose}/a.png", Some("{pose}/a_#.png")),
        ("r{pose}##.png", Some("r{pose}_##.png")),
        ("##{pose}.png", Some("##_{pose}.png")),
        ("{pose}1#.png", Some("{pose}_#.png")),
        ("a-#.png", None),
    ] {
        assert_eq!(
            pattern_per_pose(Path::new(pattern)).as_deref(),
            better,
            "{pattern}"
        );
    }
}

#[test]
fn a_scene_without_a_folder_is_in_the_current_one() {
    let current = std::env::current_dir().unwrap();
    assert_eq!(Some(&*folder(Path::new("a.scn"))), current.file_name());
    assert_eq!(folder(Path::new("-")), "stdin");
}

#[test]
fn a_name_is_typed_only_as_a_whole() {
    let scene = Path::new("s/cow.scn");
    let turn = Some(Turn { number: 2, count: 9 });
    for (pattern, turn, expected, origin) in [
        (None, None, "cow.png", Origin::Derived),
        (None, turn, "cow-0002.png", Origin::Derived),
        (Some("a.png"), None, "a.png", Origin::Typed),
        (Some("a/{stem}.png"), None, "a/cow.png", Origin::Derived),
        (Some("a-#.png"), turn, "a-2.png", Origin::Derived),
        (Some("a-#.png"), None, "a-#.png", Origin::Typed),
    ] {
        let named = picture(pattern.map(Path::new), scene, turn, None);
        assert_eq!(
            (named.path.as_path(), named.origin),
            (Path::new(expected), origin)
        );
    }
}

#[test]
fn other_files_are_named_after_the_picture() {
    for (path, expected) in [
        ("b/a.png", Some("b/a.heat.png")),
        ("a.b.tiff", Some("a.b.heat.tiff")),
        ("-", None),
        ("/dev/null", None),
    ] {
        let named = aov(Path::new(path), "heat").map(|named| named.path);
        assert_eq!(named, expected.map(PathBuf::from), "{path}");
    }
    let typed = picture(Some(Path::new("b/c.d.jpg")), Path::new("cow.scn"), None, None);
    let named = difference(None, Some(&typed), Path::new("cow.scn"), None, None);
    assert_eq!(
        (named.path, named.origin),
        ("b/c.d-difference.png".into(), Origin::Derived)
    );
}

#[test]
fn any_pattern_gives_a_name() {
    let mut random = fastrand::Rng::new();
    let characters: Vec<char> = "#/{}.\u{e4}".chars().chain('a'..='z').collect();
    for _ in 0..256 {
        let length = random.usize(..=20);
        let mut pattern: String = (0..length).filter_map(|_| random.choice(&characters)).collect();
        pattern += random.choice(["", STEM]).unwrap();
        pattern += &"#".repeat(random.usize(..=9));
        let number = random.bool().then(|| random.u32(..));
        println!("{pattern:?}, {number:?}");
        let name = name(&pattern, number);
        if number.is_none() {
            assert_eq!(name, pattern.replace(STEM, "cow").replace(FOLDER, "herd"));
        }
    }
}

#[test]
fn numbers_sort_as_their_names_do() {
    let mut random = fastrand::Rng::new();
    for _ in 0..256 {
        let [a, b] = [(); 2].map(|()| random.u32(..10_000));
        let [name_a, name_b] = [a, b].map(|number| name("x-####.png", Some(number)));
        assert_eq!(a.cmp(&b), name_a.cmp(&name_b), "{a} and {b}");
    }
}

use super::*;

fn texts(line: &str) -> Vec<(usize, String)> {
    let words = split(line.as_bytes()).expect("words");
    words
        .iter()
        .map(|word| (word.start, String::from_utf8_lossy(word.text).into_owned()))
        .collect()
}

fn own(words: &[(usize, &str)]) -> Vec<(usize, String)> {
    words
        .iter()
        .map(|&(start, text)| (start, text.to_owned()))
        .collect()
}

#[test]
fn blanks_and_comments() {
    assert_eq!(texts(""), []);
    assert_eq!(texts(" \t\r"), []);
    assert_eq!(texts("// sphere 1"), []);
    assert_eq!(texts("//"), []);
    assert_eq!(texts("material\t 2\r"), own(&[(0, "material"), (10, "2")]));
    assert_eq!(texts("  material 2// matte?"), own(&[(2, "material"), (11, "2")]));
    assert_eq!(texts("a/b /"), own(&[(0, "a/b"), (4, "/")]));
}

#[test]
fn paths() {
    assert_eq!(
        texts("ply_file ..//a.ply // b"),
        own(&[(0, "ply_file"), (9, "..//a.ply")])
    );
    assert_eq!(
        texts("ply_file \"a // b.ply\" //"),
        own(&[(0, "ply_file"), (9, "a // b.ply")])
    );
    assert_eq!(texts("ply_file \"\""), own(&[(0, "ply_file"), (9, "")]));
    assert_eq!(
        texts("camera \"from // above\" eye"),
        own(&[(0, "camera"), (7, "from // above"), (23, "eye")])
    );
    assert_eq!(
        texts("mesh \"my mesh.ply\" scale \"2"),
        own(&[(0, "mesh"), (5, "my mesh.ply"), (19, "scale"), (25, "\"2")])
    );
    assert_eq!(
        texts("instance \"a b\" placements \"c // d\" scale \"2"),
        own(&[
            (0, "instance"),
            (9, "a b"),
            (15, "placements"),
            (26, "c // d"),
            (35, "scale"),
            (41, "\"2")
        ])
    );
    assert_eq!(
        texts("environment \"a b.hdr\" rotate 1"),
        own(&[(0, "environment"), (12, "a b.hdr"), (22, "rotate"), (29, "1")])
    );
    assert_eq!(texts("light \"1"), own(&[(0, "light"), (6, "\"1")]));
    assert_eq!(split(b"ply_file \"a.ply").expect_err("open").start, 9);
    assert_eq!(split(b"ply_file \"a\"b").expect_err("letter").start, 12);
}

use super::*;

#[test]
fn sizes() {
    let expected = Size {
        width: 333,
        height: 217,
    };
    assert_eq!(size("333x217"), Ok(expected));
    assert_eq!(size("333 X 217"), Ok(expected));
    let (width, height) = (12, 12);
    assert_eq!(size("12"), Ok(Size { width, height }));
    for text in [
        "",
        "x",
        "12x",
        "x12",
        "0x5",
        "5x0",
        "1x2x3",
        "-1x5",
        "1.5x2",
        "99999999999x1",
    ] {
        assert!(size(text).is_err(), "{text}");
    }
}

#[test]
fn vectors() {
    assert_eq!(vector("-1,2.5,3e2"), Ok(DVec3::new(-1.0, 2.5, 300.0)));
    assert_eq!(vector("1, 2, 3"), Ok(DVec3::new(1.0, 2.0, 3.0)));
    for text in [
        "", "1,2", "1,2,3,4", "a,b,c", "1,,3", "nan,0,0", "inf,0,0", "1e10,0,0", "--target",
    ] {
        assert!(vector(text).is_err(), "{text}");
    }
}

#[test]
fn bytes_have_units() {
    for (text, expected) in [
        ("1", 1),
        ("4096", 4096),
        ("512M", 512 << 20),
        ("2gib", 2 << 30),
        ("3KB", 3072),
        ("1t", 1 << 40),
    ] {
        assert_eq!(bytes(text), Ok(expected), "{text}");
    }
    for text in [
        "",
        "0",
        "G",
        "-1",
        "1.5G",
        "1 G",
        "1X",
        "1iB1",
        "99999999999T",
        "1é",
    ] {
        assert!(bytes(text).is_err(), "{text}");
    }
}

#[test]
fn levels_and_shares() {
    assert_eq!(
        (levels("0"), levels("2.5"), levels("255")),
        (Ok(0.0), Ok(2.5), Ok(255.0))
    );
    assert_eq!(
        (share("0"), share("1e-3"), share("1")),
        (Ok(0.0), Ok(0.001), Ok(1.0))
    );
    for text in ["", "-1", "256", "nan", "inf", "1%", "x"] {
        assert!(levels(text).is_err() && share(text).is_err(), "{text}");
    }
    assert!(share("1.5").is_err());
}

#[test]
fn diameters() {
    assert_eq!((diameter("0.5"), diameter("1e9")), (Ok(0.5), Ok(1e9)));
    for text in ["", "0", "-0", "-1", "nan", "inf", "1e10", "1e-60", "1e-45", "x"] {
        assert!(diameter(text).is_err(), "{text}");
    }
}

#[test]
fn frame_ranges() {
    assert_eq!(frames("1-24"), Ok(FrameRange { first: 1, last: 24 }));
    assert_eq!(frames("007-7"), Ok(FrameRange { first: 7, last: 7 }));
    assert_eq!(frames("5"), Ok(FrameRange { first: 5, last: 5 }));
    assert!(frames("9-3").unwrap_err().contains("3-9"));
    for text in [
        "",
        "-",
        "1-",
        "-1",
        "0-3",
        "0",
        "1--2",
        "1-2-3",
        "+1-2",
        "1 - 2",
        "a-b",
        "1..2",
        "1,2",
        "99999999999-3",
        "1-100001",
        "1-4294967295",
        "１-２",
    ] {
        assert!(frames(text).is_err(), "{text}");
    }
}

#[test]
fn edges() {
    for (text, expected) in [("1", 1.0), (".5", 0.5), ("100", 100.0), ("1e-3", 1e-3)] {
        assert_eq!(edge_width(text), Ok(expected));
    }
    for text in ["0", "-1", "100.1", "inf", "nan", "", "1px", "1e-99"] {
        assert!(edge_width(text).is_err(), "{text}");
    }
    assert_eq!(color("#01abFF"), Ok([1, 0xab, 255]));
    assert_eq!(color("black"), Ok([0; 3]));
    for text in ["scene", "transparent", "red", "12345", "1234567", ""] {
        assert!(color(text).is_err(), "{text}");
    }
}

#[test]
fn crops() {
    let expected = Crop {
        x0: 1,
        y0: 2,
        x1: 30,
        y1: 4,
    };
    assert_eq!(crop("1, 2,30,4"), Ok(expected));
    assert_eq!(crop(&expected.to_string()), Ok(expected));
    for text in [
        "",
        "1,2,3",
        "1,2,3,4,5",
        "1,2,1,4",
        "1,4,3,4",
        "-1,2,3,4",
        "0.5,0,1,1",
        "5,5,2,2",
    ] {
        assert!(crop(text).is_err(), "{text}");
    }
}

#[test]
fn any_text_is_taken_or_refused() {
    let mut random = fastrand::Rng::new();
    let characters: Vec<char> = "+ -".chars().chain('0'..='9').chain('a'..='z').collect();
    for _ in 0..256 {
        let length = random.usize(..=12);
        let text: String = (0..length).filter_map(|_| random.choice(&characters)).collect();
        println!("{text:?}");
        if let Ok(FrameRange { first, last }) = frames(&text) {
            assert!(0 < first && first <= last);
        }
    }
}

//! Formats of images, and options of OBJ files.

use super::*;
use crate::long::rounds;

/// An image of 2x1 pixels in another format.
fn written(format: image::ImageFormat) -> Vec<u8> {
    let image = image::RgbaImage::from_raw(2, 1, [RED, BLUE].concat()).expect("two pixels");
    let mut bytes = io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).expect("it is written");
    bytes.into_inner()
}

#[test]
fn gif_and_tiff_are_shown() {
    for format in [image::ImageFormat::Gif, image::ImageFormat::Tiff] {
        let (scene, notes) = obj_scene("Kd 1 1 1\nmap_Kd a.png", &written(format));
        assert!(notes.is_empty(), "{notes:?}");
        let film = film(&scene, &above(), sized(64));
        let [left, right] = [15, 48].map(|x| film.pixels()[32 * 64 + x]);
        assert!(left[0] > 0.9 && left[2] < 0.1, "{format:?}: {left:?}");
        assert!(right[2] > 0.9 && right[0] < 0.1, "{format:?}: {right:?}");
    }
    // Headers that promise more bytes than follow: the size of the screen, and the entries for width and height.
    let mut gif = written(image::ImageFormat::Gif);
    gif[6..10].fill(0xff);
    let mut tiff = written(image::ImageFormat::Tiff);
    for tag in [256_u16, 257] {
        let key = [&tag.to_le_bytes()[..], &4_u16.to_le_bytes(), &1_u32.to_le_bytes()].concat();
        let at = tiff.windows(8).position(|bytes| bytes == key).expect("an entry");
        tiff[at + 8..at + 12].copy_from_slice(&65535_u32.to_le_bytes());
    }
    for image in [gif, tiff] {
        let (_, notes) = obj_scene("map_Kd a.png", &image);
        let expected =
            "a.obj: texture a.png is not shown: it has 65535x65535 pixels, expected at most 16384x16384";
        assert_eq!(notes, [expected]);
    }
}

/// A TIFF image of 2x1 pixels with a palette of 8 bits, of which it uses the second and the last colour, or of 1 bit. `word`
/// writes a number, `most` stands for full light.
fn with_palette(head: &[u8], word: fn(u16) -> [u8; 2], most: u16, bits: u16) -> Vec<u8> {
    let (count, left) = (1 << bits, usize::from(bits == 8));
    let long = |number: u32| {
        let [high, low] = [(number >> 16) as u16, number as u16].map(word);
        if head[0] == b'M' { [high, low] } else { [low, high] }.concat()
    };
    let (first, pixels) = (8_u32, 8 + 2 + 9 * 12 + 4);
    let short = |tag: u16, value: u16| {
        [
            &[word(tag), word(3), word(0), word(0)].concat()[..4],
            &long(1),
            &word(value),
            &[0, 0],
        ]
        .concat()
    };
    let long_entry = |tag: u16, kind: u16, count: u32, value: u32| {
        [&[word(tag), word(kind)].concat()[..], &long(count), &long(value)].concat()
    };
    let mut bytes = [head, &long(first), &word(9)].concat();
    for entry in [
        short(256, 2),
        short(257, 1),
        short(258, bits),
        short(259, 1),
        short(262, 3),
        long_entry(273, 4, 1, pixels),
        short(278, 1),
        long_entry(279, 4, 1, 2),
        long_entry(320, 3, 3 * count as u32, pixels + 2),
    ] {
        bytes.extend(entry);
    }
    bytes.extend(long(0));
    bytes.extend(if bits == 8 { [1, 255] } else { [0b0100_0000, 0] });
    let mut map = vec![0; 3 * count];
    (map[left], map[3 * count - 1]) = (most, most);
    bytes.extend(map.into_iter().flat_map(word));
    bytes
}

#[test]
fn palettes_of_tiff_are_shown() {
    for tiff in [
        with_palette(b"II*\0", u16::to_le_bytes, 0xffff, 8),
        with_palette(b"MM\0*", u16::to_be_bytes, 0xffff, 8),
        with_palette(b"II*\0", u16::to_le_bytes, 0xff, 8),
        with_palette(b"II*\0", u16::to_le_bytes, 0xffff, 1),
        with_palette(b"MM\0*", u16::to_be_bytes, 0xff, 1),
    ] {
        let (scene, notes) = obj_scene("Kd 1 1 1\nmap_Kd a.png", &tiff);
        assert!(notes.is_empty(), "{notes:?}");
        let film = film(&scene, &above(), sized(64));
        let [left, right] = [15, 48].map(|x| film.pixels()[32 * 64 + x]);
        assert!(left[0] > 0.9 && left[2] < 0.1, "{left:?}");
        assert!(right[2] > 0.9 && right[0] < 0.1, "{right:?}");
        // Cut short, it is refused or read, and nothing worse.
        for length in (0..tiff.len()).step_by(rounds(7, 1)) {
            obj_scene("Kd 1 1 1\nmap_Kd a.png", &tiff[..length]);
        }
    }
}

/// A TIFF image that promises a palette, but has none.
#[test]
fn what_to_do_with_other_tiff_is_said() {
    let mut tiff = written(image::ImageFormat::Tiff);
    // The entry of the photometric interpretation, a short number.
    let key = [262_u16, 3, 1, 0].map(u16::to_le_bytes).concat();
    let at = tiff.windows(8).position(|bytes| bytes == key).expect("an entry");
    tiff[at + 8] = 3;
    let (_, notes) = obj_scene("map_Kd a.png", &tiff);
    let expected = "a.obj: texture a.png is not shown: this is a TIFF with a palette of 0 colours, expected grey, RGB or CMYK of \
                    8-bit or 16-bit integers, RGB of 32-bit floats, black and white, or a palette of 2 or 256 colours";
    assert_eq!(notes, [expected]);
    // Instead of the rows of a strip, the order of bits.
    let mut tiff = with_palette(b"II*\0", u16::to_le_bytes, 0xffff, 1);
    let key = [278_u16, 3, 1, 0].map(u16::to_le_bytes).concat();
    let at = tiff.windows(8).position(|bytes| bytes == key).expect("an entry");
    (tiff[at], tiff[at + 8]) = (266_u16.to_le_bytes()[0], 2);
    let (_, notes) = obj_scene("map_Kd a.png", &tiff);
    let expected = "a.obj: texture a.png is not shown: this is a TIFF with the bits of each byte in reverse order (FillOrder 2), \
                    expected the usual order";
    assert_eq!(notes, [expected]);
}

/// Options of `map_Kd` scale and offset the coordinates, whose origin is the lower left corner.
#[test]
fn textures_are_scaled_and_offset() {
    let image = png([2, 2], &[RED, GREEN, BLUE, WHITE]);
    let at = |options: &str, [x, y]: [usize; 2]| {
        let (scene, notes) = obj_scene(&format!("Kd 1 1 1\nmap_Kd {options} a.png"), &image);
        assert!(notes.is_empty(), "{notes:?}");
        let pixel = film(&scene, &above(), sized(64)).pixels()[y * 64 + x];
        pixel.map(|channel| if channel > 0.5 { 255 } else { 0 })
    };
    let rgb = |[red, green, blue, _]: [u8; 4]| [red, green, blue];
    for (options, expected) in [
        // The texels of the corners, from the upper left one on, and of the middle of the upper left quarter.
        ("", [RED, GREEN, BLUE, WHITE, RED]),
        ("-o 0.5", [GREEN, RED, WHITE, BLUE, GREEN]),
        ("-o 0 0.5 0", [BLUE, WHITE, RED, GREEN, BLUE]),
        ("-s 2 2 1", [RED, GREEN, BLUE, WHITE, WHITE]),
        ("-s 0.2 0.2 0.2 -o 0.15 0.15", [BLUE, BLUE, BLUE, BLUE, BLUE]),
        ("-clamp on -s 1 0.5 -o 0 0.5 7", [RED, GREEN, RED, GREEN, RED]),
    ] {
        let places = [[4, 4], [59, 4], [4, 59], [59, 59], [24, 24]];
        let found = places.map(|place| at(options, place));
        assert_eq!(found, expected.map(rgb), "{options}");
    }
    // All textures of a material are placed as its first one, and turbulence is not shown.
    let (_, notes) = obj_scene(
        "Kd 1 1 1\nmap_Kd -s 2 2 a.png\nmap_Ke -s 2 a.png\nKe 1 1 1",
        &image,
    );
    assert_eq!(notes, ["a.mtl: left out: 1 offset or scale of a texture"]);
    let (_, notes) = obj_scene("Kd 1 1 1\nmap_Kd -t 0 1 0 a.png", &image);
    assert_eq!(notes, ["a.mtl: left out: 1 turbulence of a texture"]);
}

/// Two materials share texture coordinates.
#[test]
fn each_material_scales_its_own_texture() {
    let text = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n\
        usemtl a\nf 1/1 2/2 3/3\nusemtl b\nf 1/1 2/2 3/3\nf 3/3 2/2 1/1\n";
    let library = "newmtl a\nmap_Kd a.png\nnewmtl b\nmap_Kd -s 3 2 -o 0.25 a.png\n";
    let loaded = mesh::parse(text.into(), Path::new("a.obj"), &mut |path| match path.to_str() {
        Some("a.mtl") => Ok(library.into()),
        _ => Ok(png([1, 1], &[RED])),
    });
    let columns = loaded.expect("a mesh").columns;
    let uvs = |i: usize| columns.triangles[i].map(|corner| columns.uvs[corner as usize]);
    assert_eq!(uvs(0), [[0.0, 1.0], [1.0, 1.0], [0.0, 0.0]]);
    assert_eq!(uvs(1), [[0.25, 1.0], [3.25, 1.0], [0.25, -1.0]]);
    assert_eq!(uvs(2), [[0.25, -1.0], [3.25, 1.0], [0.25, 1.0]]);
    assert_eq!(columns.x.len(), 6);
}

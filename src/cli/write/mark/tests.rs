use super::*;

fn chunk(kind: &[u8], data: &[u8]) -> Vec<u8> {
    let length = (data.len() as u32).to_be_bytes();
    [&length[..], kind, data, b"sum."].concat()
}

fn png(chunks: &[(&[u8], &[u8])]) -> Vec<u8> {
    let chunks = chunks.iter().flat_map(|(kind, data)| chunk(kind, data));
    b"\x89PNG\r\n\x1a\n".iter().copied().chain(chunks).collect()
}

#[test]
fn a_png_says_who_wrote_it_before_its_pixels() {
    let text: (&[u8], &[u8]) = (b"tEXt", b"Software\0octray");
    let header: (&[u8], &[u8]) = (b"IHDR", &[0; 13]);
    assert!(is_own_png(&png(&[header, text])));
    assert!(is_own_png(&png(&[header, (b"tEXt", b"Title\0octray"), text])));
    for chunks in [
        &[header, (b"IDAT", b""), text][..],
        &[header, (b"tEXt", b"Software\0octray2")],
        &[header, (b"tEXt", b"Software\0other")],
        &[header, (b"zTXt", b"Software\0octray")],
    ] {
        assert!(!is_own_png(&png(chunks)), "{chunks:?}");
    }
    let whole = png(&[header, text]);
    // The last four bytes are the checksum.
    for length in 0..whole.len() - 4 {
        assert!(!is_own_png(&whole[..length]), "{length}");
    }
    let endless = [&png(&[header])[..], &[0xff; 4], b"tEXtSoftware\0octray"].concat();
    assert!(!is_own_png(&endless));
}

#[test]
fn any_bytes_are_looked_at() {
    let mut random = fastrand::Rng::new();
    for _ in 0..256 {
        let bytes: Vec<u8> = (0..random.usize(..100)).map(|_| random.u8(..)).collect();
        println!("{bytes:?}");
        assert!(!is_own_png(&[b"\x89PNG\r\n\x1a\n", &bytes[..]].concat()));
        assert!(!has_mark(&bytes, &bytes));
    }
}

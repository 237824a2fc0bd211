//! Tests of `png`.

use super::*;

#[test]
fn a_film_is_saved_whole_and_says_who_made_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    let mut film = Film::new(2, 1);
    film.pixels_mut()[1] = [1.0, 0.5, 0.0];
    film.save_png(&path, Transfer::Linear).unwrap();
    let mut reader = ::png::Decoder::new(io::BufReader::new(std::fs::File::open(&path).unwrap()))
        .read_info()
        .unwrap();
    let mut bytes = vec![0; 6];
    reader.next_frame(&mut bytes).unwrap();
    assert_eq!(bytes, [0, 0, 0, 255, 127, 0]);
    let texts = &reader.info().uncompressed_latin1_text;
    assert_eq!(
        texts.iter().map(|t| (&*t.keyword, &*t.text)).collect::<Vec<_>>(),
        [("Software", SOFTWARE)]
    );
    Film::new(0, 0).save_png(&path, Transfer::Linear).unwrap_err();
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

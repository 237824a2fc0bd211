//! Tests of `bands`.

use super::*;

fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.unwrap().install(work)
}

#[test]
fn every_row_is_in_one_band() {
    for (width, height, rows) in [(3, 40, 16), (1, 16, 16), (5, 1, 16), (7, 33, 1)] {
        let mut pixels = vec![u32::MAX; (width * height) as usize];
        let bands = Bands::new(&mut pixels, width, rows);
        let fill = |(y, band): (u32, &mut [u32])| {
            for (row, y) in band.chunks_mut(width as usize).zip(y..) {
                for pixel in row {
                    assert_eq!(*pixel, u32::MAX);
                    *pixel = y;
                }
            }
        };
        on_threads(4, || bands.in_turn().for_each(fill));
        let expected: Vec<u32> = (0..height).flat_map(|y| (0..width).map(move |_| y)).collect();
        assert_eq!(pixels, expected);
    }
}

#[test]
fn one_thread_takes_bands_from_the_top() {
    let mut pixels = [0_u8; 50];
    let bands = Bands::new(&mut pixels, 1, 16);
    let taken: Vec<_> = on_threads(1, || bands.in_turn().map(|(y, band)| (y, band.len())).collect());
    assert_eq!(taken, [(0, 16), (16, 16), (32, 16), (48, 2)]);
}

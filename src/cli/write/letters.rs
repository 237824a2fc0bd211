//! Letters of 8x8 pixels.

use font8x8::legacy::BASIC_LEGACY;

/// Side of a letter, pixels.
pub const LETTER: u32 = 8;

/// The pixels of a line of text that have ink, x and y from its top left corner. Other characters than ASCII are `?`.
pub fn ink(line: impl IntoIterator<Item = char>) -> impl Iterator<Item = [u32; 2]> {
    let glyph = |c: char| {
        BASIC_LEGACY
            .get(c as usize)
            .unwrap_or(&BASIC_LEGACY['?' as usize])
    };
    (0..).zip(line).flat_map(move |(i, c)| {
        (0..).zip(glyph(c)).flat_map(move |(y, bits)| {
            let columns = (0..LETTER).filter(move |x| bits >> x & 1 == 1);
            columns.map(move |x| [i * LETTER + x, y])
        })
    })
}

/// A text of at most that many letters; one that is too long loses its middle, since names differ at their ends.
pub fn fitting(text: &str, most: usize) -> Vec<char> {
    /// Where a text was cut.
    const CUT: &str = "..";
    let letters: Vec<char> = text.chars().collect();
    let kept = most.saturating_sub(CUT.len());
    if letters.len() <= most || kept < 2 {
        return letters.into_iter().take(most).collect();
    }
    let (head, tail) = (kept.div_ceil(2), kept / 2);
    let tail = &letters[letters.len() - tail..];
    letters[..head]
        .iter()
        .copied()
        .chain(CUT.chars())
        .chain(tail.iter().copied())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_texts_keep_both_ends() {
        let fitting = |most| fitting("truck-1.glb", most).into_iter().collect::<String>();
        assert_eq!(fitting(11), "truck-1.glb");
        assert_eq!(fitting(10), "truc...glb");
        assert_eq!(fitting(7), "tru..lb");
        assert_eq!(fitting(2), "tr");
    }

    #[test]
    fn unknown_letters_are_question_marks() {
        assert!(ink("\u{1f600}".chars()).eq(ink("?".chars())));
        assert!(ink("a?".chars()).all(|[x, y]| x < 16 && y < 8));
    }
}

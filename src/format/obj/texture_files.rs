//! Statements of textures: options before or after the name of a file, which may contain spaces.

use super::{super::place::Words, mtl::number, textures::Shift};
use crate::scene::{MAX_NORMAL_SCALE, Wrap};
use std::borrow::Cow;

/// What a texture statement says.
pub(super) struct TextureFile<'a> {
    pub(super) written: &'a [u8],
    pub(super) options: Options,
}

impl TextureFile<'_> {
    pub(super) fn name(&self) -> Cow<'_, str> {
        String::from_utf8_lossy(self.written)
    }
}

/// The options that octray shows.
#[derive(Clone, Copy)]
pub(super) struct Options {
    pub(super) wrap: Wrap,
    pub(super) shift: Shift,
    pub(super) is_turbulent: bool,
    /// The factor of a bump map.
    pub(super) strength: f32,
}

/// Reads a texture statement.
pub(super) fn texture_file(mut words: Words<'_>) -> TextureFile<'_> {
    let mut name = words.rest();
    let mut options = Options {
        wrap: Wrap::Repeat,
        shift: Shift::NONE,
        is_turbulent: false,
        strength: 1.0,
    };
    while let Some((option @ [b'-', ..], _)) = words.next() {
        options.read(option, &mut words);
        name.start = words.position();
    }
    let name = words.text(name).trim_ascii_start();
    let comment = name
        .windows(2)
        .position(|pair| pair[0].is_ascii_whitespace() && pair[1] == b'#');
    let name = name
        .get(..comment.unwrap_or(name.len()))
        .unwrap_or_default()
        .trim_ascii_end();
    let name = without_options(name, &mut options);
    let unquoted = name.strip_prefix(b"\"").and_then(|name| name.strip_suffix(b"\""));
    TextureFile {
        written: unquoted.unwrap_or(name),
        options,
    }
}

/// A name without the options after it, which are read. What is not an option with its values to the end of the line
/// belongs to the name, such as ` -s ` of `wood -s 2.png`.
fn without_options<'a>(name: &'a [u8], options: &mut Options) -> &'a [u8] {
    let mut words = Words::new(name, 0..name.len());
    // The end of the name, and the options after it.
    let mut found: Option<(usize, Options)> = None;
    let mut end = 0;
    while let Some((word, range)) = words.next() {
        let (start, mut read) = found.unwrap_or((end, *options));
        let mut values = words.clone();
        found = None;
        if range.start > 0 && read.read(word, &mut values) {
            found = Some((start, read));
            words = values;
        }
        end = words.position();
    }
    let Some((end, read)) = found else {
        return name;
    };
    *options = read;
    name.get(..end).unwrap_or_default()
}

impl Options {
    /// Reads the values of an option. Returns whether it is a known one with the values that it has.
    fn read(&mut self, option: &[u8], words: &mut Words<'_>) -> bool {
        let is_switch = |word: &[u8]| matches!(word, b"on" | b"off");
        match option {
            b"-mm" => number(words).is_some() & number(words).is_some(),
            b"-bm" => {
                let strength = number(words);
                let most = MAX_NORMAL_SCALE;
                self.strength = strength.unwrap_or(1.0).clamp(-most, most);
                strength.is_some()
            }
            b"-o" | b"-s" | b"-t" => self.read_numbers(option, words) > 0,
            b"-clamp" => {
                let value = words.next().map(|(word, _)| word);
                if value == Some(b"on") {
                    self.wrap = Wrap::Clamp;
                }
                value.is_some_and(is_switch)
            }
            b"-blendu" | b"-blendv" | b"-cc" => words.next().is_some_and(|(word, _)| is_switch(word)),
            b"-boost" | b"-texres" => number(words).is_some(),
            b"-imfchan" => words
                .next()
                .is_some_and(|(word, _)| matches!(word, [channel] if b"rgbmlz".contains(channel))),
            _ => {
                if option.starts_with(b"-") {
                    words.next();
                }
                false
            }
        }
    }

    /// Reads one number or more; the third is for textures with depth. Returns how many there are.
    fn read_numbers(&mut self, option: &[u8], words: &mut Words<'_>) -> usize {
        let mut numbers = words.clone();
        let mut count = 0;
        while let Some(number) = number(&mut numbers) {
            let place = match option {
                b"-s" => self.shift.scale.get_mut(count),
                b"-o" => self.shift.offset.get_mut(count),
                _ => {
                    self.is_turbulent |= number != 0.0;
                    None
                }
            };
            if let Some(place) = place {
                *place = number;
            }
            *words = numbers.clone();
            count += 1;
        }
        count
    }
}

#[cfg(test)]
mod tests;

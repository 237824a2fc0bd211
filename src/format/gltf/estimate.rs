//! How much memory the parsed JSON takes, estimated from its text: the parser cannot be limited.

/// The largest structure of an object, a node, in an array that has grown to twice its size, with what reading the scene
/// adds for each; or the least table of a map.
const OBJECT: usize = 768;
/// The least array of numbers of any kind. An array that is an element of another may stand for an object.
const ARRAY: usize = 160;
/// A number of any kind in an array that has grown to twice its size.
const ELEMENT: usize = 64;
/// Half the least allocation of a string.
const QUOTE: usize = 16;

/// How many bytes the JSON of this text takes once it is parsed, at most.
pub(super) fn parsed_size(text: &[u8]) -> usize {
    let (mut within_string, mut size, mut last) = (false, text.len(), b' ');
    let mut bytes = text.iter();
    while let Some(byte) = bytes.next() {
        let more = match (byte, within_string) {
            (b'"', _) => {
                within_string = !within_string;
                QUOTE
            }
            (b'\\', true) => {
                bytes.next();
                0
            }
            (b'{', false) => OBJECT,
            (b'[', false) if matches!(last, b'[' | b',') => OBJECT,
            (b'[', false) => ARRAY,
            (b',', false) => ELEMENT,
            _ => 0,
        };
        size = size.saturating_add(more);
        if !byte.is_ascii_whitespace() {
            last = *byte;
        }
    }
    size
}

#[cfg(test)]
mod tests;

//! The first directory of a TIFF or BigTIFF file: a list of entries with a tag, a type, a count, and the numbers or their place.

/// The first directory of a file.
pub(super) struct Directory<'a> {
    bytes: &'a [u8],
    is_little: bool,
    /// Of BigTIFF, whose places have 64 bits.
    is_big: bool,
    first: usize,
    entries: usize,
}

/// The numbers of an entry.
struct Numbers {
    at: usize,
    /// Bytes of a number.
    width: usize,
    count: u64,
}

impl<'a> Directory<'a> {
    /// `None` if the file is no TIFF, or ends before it.
    pub(super) fn first(bytes: &'a [u8]) -> Option<Self> {
        let (is_little, is_big) = Self::kind(bytes)?;
        let mut directory = Self {
            bytes,
            is_little,
            is_big,
            first: 0,
            entries: 0,
        };
        let (place, count) = if is_big { (8, 8) } else { (4, 2) };
        let at = usize::try_from(directory.read(place, if is_big { 8 } else { 4 })?).ok()?;
        directory.first = at.checked_add(count)?;
        let entries = usize::try_from(directory.read(at, count)?).ok()?;
        // No more than fit into the file.
        directory.entries = entries.min(bytes.len() / directory.entry_bytes());
        Some(directory)
    }

    /// Whether a file has its low bytes first, and whether it is BigTIFF; `None` if it is no TIFF.
    pub(super) fn kind(bytes: &[u8]) -> Option<(bool, bool)> {
        match bytes.first_chunk()? {
            b"II*\0" => Some((true, false)),
            b"MM\0*" => Some((false, false)),
            b"II+\0" => Some((true, true)),
            b"MM\0+" => Some((false, true)),
            _ => None,
        }
    }

    fn entry_bytes(&self) -> usize {
        if self.is_big { 20 } else { 12 }
    }

    /// The unsigned number in these bytes.
    fn read(&self, at: usize, bytes: usize) -> Option<u64> {
        let number = self.bytes.get(at..at.checked_add(bytes)?)?.iter();
        let add = |number: u64, &byte: &u8| number << 8 | u64::from(byte);
        Some(if self.is_little {
            number.rev().fold(0, add)
        } else {
            number.fold(0, add)
        })
    }

    fn numbers(&self, tag: u16) -> Option<Numbers> {
        let places = (0..self.entries).map(|i| self.first.checked_add(i * self.entry_bytes()));
        let mut places = places.map_while(|at| at);
        let entry = places.find(|&at| self.read(at, 2) == Some(tag.into()))?;
        let width = match self.read(entry + 2, 2)? {
            1 => 1,
            3 => 2,
            4 => 4,
            16 => 8,
            _ => return None,
        };
        let long = if self.is_big { 8 } else { 4 };
        let count = self.read(entry + 4, long)?;
        let inside = entry + 4 + long;
        // Few numbers are in the entry itself.
        let at = match count.checked_mul(width as u64)? {
            bytes if bytes <= long as u64 => inside,
            _ => usize::try_from(self.read(inside, long)?).ok()?,
        };
        Some(Numbers { at, width, count })
    }

    /// The count of an entry's numbers; 0 without the entry.
    pub(super) fn count(&self, tag: u16) -> u64 {
        self.numbers(tag).map_or(0, |numbers| numbers.count)
    }

    /// A number of an entry; `None` if it has fewer.
    pub(super) fn number(&self, tag: u16, index: usize) -> Option<u64> {
        let Numbers { at, width, count } = self.numbers(tag)?;
        let at = at.checked_add(index.checked_mul(width)?)?;
        self.read(at, width).filter(|_| (index as u64) < count)
    }

    /// Where the lowest byte of an entry's first number is.
    pub(super) fn lowest_byte(&self, tag: u16) -> Option<usize> {
        let Numbers { at, width, .. } = self.numbers(tag)?;
        Some(if self.is_little { at } else { at + width - 1 })
    }
}

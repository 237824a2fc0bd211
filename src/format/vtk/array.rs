//! Arrays of numbers: where a file stores them, and their values in turn.

use super::encoded::{self, Encoding};
use crate::{
    error::{LoadErrorKind, quote},
    format::{
        budget::Budget,
        place::{TextFault, Words},
    },
};
use std::{borrow::Cow, cell::Cell, ops::Range};

/// The type of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Kind {
    /// The type that an attribute `type` names; `None` for strings and bits.
    pub(super) fn of_xml(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"Int8" => Self::I8,
            b"UInt8" => Self::U8,
            b"Int16" => Self::I16,
            b"UInt16" => Self::U16,
            b"Int32" => Self::I32,
            b"UInt32" => Self::U32,
            b"Int64" => Self::I64,
            b"UInt64" => Self::U64,
            b"Float32" => Self::F32,
            b"Float64" => Self::F64,
            _ => return None,
        })
    }

    /// The type that a word of a legacy file names, in lower case; `None` for strings, bits and unknown words.
    pub(super) fn of_legacy(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"char" | b"signed_char" | b"vtktypeint8" => Self::I8,
            b"unsigned_char" | b"vtktypeuint8" => Self::U8,
            b"short" | b"vtktypeint16" => Self::I16,
            b"unsigned_short" | b"vtktypeuint16" => Self::U16,
            // Ids are written as `int`, whatever a program's have.
            b"int" | b"vtkidtype" | b"vtktypeint32" => Self::I32,
            b"unsigned_int" | b"vtktypeuint32" => Self::U32,
            b"long" | b"long_long" | b"vtktypeint64" => Self::I64,
            b"unsigned_long" | b"unsigned_long_long" | b"vtktypeuint64" => Self::U64,
            b"float" | b"vtktypefloat32" => Self::F32,
            b"double" | b"vtktypefloat64" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes of a number.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }
}

/// A file, and how it stores binary data.
pub(super) struct File<'a> {
    pub(super) text: &'a [u8],
    pub(super) budget: &'a Budget,
    pub(super) encoding: Encoding<'a>,
    /// How many bytes may still be decoded: arrays may overlap, or inflate to much more than the file.
    pub(super) work: Cell<u64>,
}

/// Where numbers are.
#[derive(Clone)]
pub(super) enum Source<'a> {
    /// Words of the text.
    Words(Range<usize>),
    /// Their bytes.
    Bytes(&'a [u8]),
    /// base64 in the text.
    Inline(Range<usize>),
    /// At this offset in the appended data.
    Appended(u64),
}

/// An array of a file.
#[derive(Clone)]
pub(super) struct Array<'a> {
    pub(super) name: String,
    /// `None` if these are no numbers.
    pub(super) kind: Option<Kind>,
    /// Numbers in each tuple, at least 1.
    pub(super) components: usize,
    /// Whether its numbers are colours, as shares of 1 unless they are bytes.
    pub(super) is_color: bool,
    pub(super) source: Source<'a>,
    /// The tag or words that describe it, if they have a line.
    pub(super) place: Option<Range<usize>>,
}

impl<'a> Array<'a> {
    /// A fault of the array.
    pub(super) fn fault(&self, message: impl Into<String>) -> TextFault {
        match &self.place {
            Some(place) => TextFault::new(place.clone(), message),
            None => TextFault::of_file(message),
        }
    }

    /// As a message calls it.
    pub(super) fn quoted(&self) -> String {
        quote(self.name.as_bytes())
    }

    /// Reads its numbers. If it has fewer than `count`, that is an error, of text once they end.
    pub(super) fn open(&self, count: usize, file: &File<'a>) -> Result<Numbers<'a>, TextFault> {
        let Some(kind) = self.kind else {
            return Err(self.fault(format!("{} has no numbers, expected some", self.quoted())));
        };
        let encoded = |data| encoded::read(data, file).map_err(|fault| fault.at(self));
        let bytes = match &self.source {
            Source::Words(range) => {
                // Before memory is reserved for them: a number has a digit and a space.
                if count > range.len().div_ceil(2) {
                    return Err(self.too_short(range.len().div_ceil(2) as u64, "at most ", count));
                }
                return Ok(Numbers {
                    values: Values::Words(Words::new(file.text, range.clone())),
                    array: self.clone_without_name(),
                    name: self.quoted(),
                });
            }
            Source::Bytes(bytes) => Bytes::borrowed(bytes, file.budget),
            Source::Inline(range) => encoded(encoded::Data::base64(
                file.text.get(range.clone()).unwrap_or_default(),
            ))?,
            Source::Appended(offset) => {
                let data = file.encoding.appended(*offset);
                encoded(data.ok_or_else(|| {
                    self.fault(format!(
                        "the data of {} begin at byte {offset} of the appended data, beyond its end",
                        self.quoted()
                    ))
                })?)?
            }
        };
        let has = bytes.as_slice().len() / kind.size();
        if has < count {
            return Err(self.too_short(has as u64, "", count));
        }
        Ok(Numbers {
            values: Values::Binary {
                bytes,
                at: 0,
                kind,
                is_big: file.encoding.is_big,
            },
            array: self.clone_without_name(),
            name: self.quoted(),
        })
    }

    fn too_short(&self, has: u64, at_most: &str, count: usize) -> TextFault {
        self.fault(format!(
            "{} has {at_most}{has} numbers, expected {count}",
            self.quoted()
        ))
    }

    /// For faults.
    fn clone_without_name(&self) -> Self {
        Self {
            name: String::new(),
            ..self.clone()
        }
    }
}

/// Bytes that are in the file, or were decoded and count in the budget until they are dropped.
pub(super) struct Bytes<'a> {
    bytes: Cow<'a, [u8]>,
    budget: &'a Budget,
}

impl<'a> Bytes<'a> {
    pub(super) fn borrowed(bytes: &'a [u8], budget: &'a Budget) -> Self {
        Self {
            bytes: Cow::Borrowed(bytes),
            budget,
        }
    }

    /// Bytes whose capacity is taken from the budget.
    pub(super) fn owned(bytes: Vec<u8>, budget: &'a Budget) -> Self {
        Self {
            bytes: Cow::Owned(bytes),
            budget,
        }
    }

    pub(super) fn as_slice(&self) -> &[u8] {
        &self.bytes
    }
}

impl Drop for Bytes<'_> {
    fn drop(&mut self) {
        if let Cow::Owned(bytes) = &self.bytes {
            self.budget.give_back(bytes.capacity());
        }
    }
}

/// The numbers of an array, in turn.
pub(super) struct Numbers<'a> {
    values: Values<'a>,
    array: Array<'a>,
    name: String,
}

enum Values<'a> {
    Words(Words<'a>),
    Binary {
        bytes: Bytes<'a>,
        at: usize,
        kind: Kind,
        is_big: bool,
    },
}

/// A number in a binary array, with its own type.
#[derive(Clone, Copy)]
enum Number {
    Whole(i64),
    Real(f64),
}

impl Numbers<'_> {
    /// Whether they are binary numbers of 32 bits with a fraction.
    pub(super) fn is_single(&self) -> bool {
        matches!(&self.values, Values::Binary { kind: Kind::F32, .. })
    }

    /// The next number of a binary array.
    #[inline]
    fn binary(&mut self) -> Result<Number, TextFault> {
        let Values::Binary {
            bytes,
            at,
            kind,
            is_big,
        } = &mut self.values
        else {
            return Err(self.ended());
        };
        let found = number(bytes.as_slice().get(*at..).unwrap_or_default(), *kind, *is_big);
        *at += kind.size();
        found.ok_or_else(|| self.ended())
    }

    /// The next number, as `parse` makes it of a word, or as the second function does of any other number.
    #[inline]
    pub(super) fn next_as<T>(
        &mut self,
        parse: impl FnOnce(&[u8]) -> Result<T, fast_float2::Error>,
        convert: impl FnOnce(f64) -> T,
    ) -> Result<T, TextFault> {
        if let Values::Words(words) = &mut self.values {
            let Some((word, place)) = words.next() else {
                return Err(self.ended());
            };
            return parse(word).map_err(|_| self.wrong(word, place, "a number"));
        }
        Ok(convert(match self.binary()? {
            Number::Whole(value) => value as f64,
            Number::Real(value) => value,
        }))
    }

    /// The next number.
    #[inline]
    pub(super) fn real(&mut self) -> Result<f64, TextFault> {
        self.next_as(|word| fast_float2::parse(word), |value| value)
    }

    /// The next number, which must be whole and from 0 to below `limit`; `what` says what it is.
    #[inline]
    pub(super) fn index(&mut self, limit: u64, what: &str) -> Result<u64, TextFault> {
        let (value, place) = match &mut self.values {
            Values::Words(words) => {
                let Some((word, place)) = words.next() else {
                    return Err(self.ended());
                };
                let value = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
                let value = value.ok_or_else(|| self.wrong(word, place.clone(), "a whole number"))?;
                (value, Some(place))
            }
            Values::Binary { .. } => match self.binary()? {
                Number::Whole(value) => (value, None),
                Number::Real(value) => {
                    let message = format!("{} has the number {value}, expected whole ones", self.name);
                    return Err(self.array.fault(message));
                }
            },
        };
        match u64::try_from(value) {
            Ok(index) if index < limit => Ok(index),
            _ => {
                let message = format!(
                    "{what} {value} in {}, expected 0 to {}",
                    self.name,
                    limit as i128 - 1
                );
                Err(match place {
                    Some(place) => TextFault::new(place, message),
                    None => self.array.fault(message),
                })
            }
        }
    }

    /// Whether there are no more.
    pub(super) fn is_at_end(&self) -> bool {
        match &self.values {
            Values::Words(words) => words.rest().is_empty(),
            Values::Binary { bytes, at, kind, .. } => at.saturating_add(kind.size()) > bytes.as_slice().len(),
        }
    }

    /// Skips numbers.
    pub(super) fn skip(&mut self, count: usize) -> Result<(), TextFault> {
        match &mut self.values {
            Values::Words(words) => {
                if count > 0 && words.nth(count - 1).is_none() {
                    return Err(self.ended());
                }
            }
            Values::Binary { at, kind, .. } => *at = at.saturating_add(count.saturating_mul(kind.size())),
        }
        Ok(())
    }

    /// Where the last number ends.
    pub(super) fn fault(&self, message: impl Into<String>) -> TextFault {
        match &self.values {
            Values::Words(words) => {
                let at = words.position();
                TextFault::new(at.saturating_sub(1)..at, message)
            }
            Values::Binary { .. } => self.array.fault(message),
        }
    }

    #[cold]
    fn ended(&self) -> TextFault {
        self.fault(format!("{} ends too early, expected more numbers", self.name))
    }

    #[cold]
    fn wrong(&self, word: &[u8], place: Range<usize>, expected: &str) -> TextFault {
        TextFault::new(
            place,
            format!("found {} in {}, expected {expected}", quote(word), self.name),
        )
    }
}

/// The first number of some bytes.
#[inline]
fn number(bytes: &[u8], kind: Kind, is_big: bool) -> Option<Number> {
    macro_rules! read {
        ($type:ty) => {{
            let bytes = *bytes.first_chunk()?;
            if is_big {
                <$type>::from_be_bytes(bytes)
            } else {
                <$type>::from_le_bytes(bytes)
            }
        }};
    }
    Some(match kind {
        Kind::I8 => Number::Whole(read!(i8).into()),
        Kind::U8 => Number::Whole(read!(u8).into()),
        Kind::I16 => Number::Whole(read!(i16).into()),
        Kind::U16 => Number::Whole(read!(u16).into()),
        Kind::I32 => Number::Whole(read!(i32).into()),
        Kind::U32 => Number::Whole(read!(u32).into()),
        Kind::I64 => Number::Whole(read!(i64)),
        Kind::U64 => Number::Whole(i64::try_from(read!(u64)).unwrap_or(i64::MAX)),
        Kind::F32 => Number::Real(read!(f32).into()),
        Kind::F64 => Number::Real(read!(f64)),
    })
}

/// A limit that was exceeded, or a fault of encoded data, before its array is known.
pub(super) struct Wrong {
    pub(super) message: String,
    pub(super) kind: LoadErrorKind,
}

impl Wrong {
    pub(super) fn new(message: impl Into<String>) -> Self {
        Self {
            message: message.into(),
            kind: LoadErrorKind::Invalid,
        }
    }

    fn at(self, array: &Array<'_>) -> TextFault {
        let message = format!("the data of {}: {}", array.quoted(), self.message);
        array.fault(message).with_kind(self.kind)
    }
}

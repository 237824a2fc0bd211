//! XML as a tree that is walked once, in order, with the place of every tag and attribute.
//!
//! quick-xml finds the tags. Nothing is copied: tags and attributes are slices of the text.

#[cfg(feature = "threemf")]
use crate::{error::SceneError, format::offset::Offset, scene::is_usable};
use crate::{
    error::{LoadErrorKind, quote},
    format::place::{TextFault, after_mark, refuse_binary},
};
use quick_xml::{
    Error, Reader,
    escape::unescape,
    events::{BytesStart, Event},
};
use std::ops::Range;

/// The deepest nesting of elements. A model needs six levels.
const MAX_DEPTH: usize = 64;

/// XML text, read up to a tag.
pub(super) struct Xml<'a> {
    text: &'a [u8],
    reader: Reader<&'a [u8]>,
    /// The offset of the text after its byte order mark.
    start: usize,
    /// The names of the open elements, the innermost last.
    open: Vec<&'a [u8]>,
    /// The last tag was that of an empty element, which has no end tag.
    is_empty: bool,
}

impl<'a> Xml<'a> {
    /// Starts reading. The text must be UTF-8.
    pub(super) fn new(text: &'a [u8]) -> Result<Self, TextFault> {
        refuse_binary(text, "XML")?;
        let start = after_mark(text);
        let mut reader = Reader::from_reader(text.get(start..).unwrap_or_default());
        let config = reader.config_mut();
        // Names are compared here, where they have a place.
        config.check_end_names = false;
        config.allow_unmatched_ends = true;
        config.allow_dangling_amp = true;
        Ok(Self {
            text,
            reader,
            start,
            open: Vec::new(),
            is_empty: false,
        })
    }

    /// Where the next tag is searched, in the text.
    pub(super) fn position(&self) -> usize {
        self.start + self.reader.buffer_position() as usize
    }

    /// The root element, which must be a `name`.
    pub(super) fn root(&mut self, name: &str) -> Result<Tag<'a>, TextFault> {
        match self.child()? {
            Some(tag) if tag.name() == name.as_bytes() => Ok(tag),
            Some(tag) => {
                let message = format!("found the element {}, expected `{name}`", quote(tag.name()));
                Err(TextFault::new(tag.place, message))
            }
            None => {
                let end = self.text.len();
                let message = format!("found no XML element, expected `{name}`");
                Err(TextFault::new(end..end, message))
            }
        }
    }

    /// The next child of the open element; `None` at its end. Each child must be read to its end, or skipped.
    pub(super) fn child(&mut self) -> Result<Option<Tag<'a>>, TextFault> {
        if std::mem::take(&mut self.is_empty) {
            return Ok(None);
        }
        loop {
            let from = self.position();
            let event = self.reader.read_event();
            let place = from..self.position();
            match event.map_err(|error| self.fault(&error))? {
                Event::Start(start) => {
                    let tag = Tag::new(self.text, start, place);
                    self.open.push(tag.full_name());
                    if self.open.len() > MAX_DEPTH {
                        let message = format!("XML elements nest more than {MAX_DEPTH} deep");
                        return Err(TextFault::new(tag.place, message).with_kind(LoadErrorKind::Limit));
                    }
                    return Ok(Some(tag));
                }
                Event::Empty(start) => {
                    self.is_empty = true;
                    return Ok(Some(Tag::new(self.text, start, place)));
                }
                Event::End(end) => {
                    let expected = self.open.pop();
                    if expected == Some(end.name().into_inner()) {
                        return Ok(None);
                    }
                    let expected = expected.map_or_else(|| "no end of an element".to_owned(), end_tag);
                    let message = format!("found {}, expected {expected}", end_tag(end.name().into_inner()));
                    return Err(TextFault::new(place, message));
                }
                Event::DocType(_) => {
                    let message = "found a document type definition, which octray does not read";
                    return Err(TextFault::new(place, message));
                }
                Event::Eof => {
                    let Some(open) = self.open.last() else {
                        return Ok(None);
                    };
                    let end = self.text.len();
                    let message = format!("the XML ends before {}", end_tag(open));
                    return Err(TextFault::new(end..end, message));
                }
                _ => {}
            }
        }
    }

    /// Skips the rest of the open element.
    pub(super) fn skip(&mut self) -> Result<(), TextFault> {
        if std::mem::take(&mut self.is_empty) {
            return Ok(());
        }
        let depth = self.open.len();
        while self.open.len() >= depth {
            self.child()?;
        }
        Ok(())
    }

    fn fault(&self, error: &Error) -> TextFault {
        let at = self.start + self.reader.error_position() as usize;
        TextFault::new(at..at + 1, format!("not valid XML: {error}"))
    }
}

fn end_tag(name: &[u8]) -> String {
    let name = quote(name);
    format!("`</{}>`", name.trim_matches('`'))
}

/// The start tag of an element.
pub(super) struct Tag<'a> {
    text: &'a [u8],
    start: BytesStart<'a>,
    /// Where it is in the text.
    pub(super) place: Range<usize>,
}

impl<'a> Tag<'a> {
    fn new(text: &'a [u8], start: BytesStart<'a>, place: Range<usize>) -> Self {
        Self { text, start, place }
    }

    /// The range of a slice of the text.
    fn place_of(&self, part: &[u8]) -> Range<usize> {
        let start = (part.as_ptr() as usize).saturating_sub(self.text.as_ptr() as usize);
        start..start + part.len()
    }

    fn full_name(&self) -> &'a [u8] {
        let place = self.place_of(self.start.name().into_inner());
        self.text.get(place).unwrap_or_default()
    }

    /// Its name without a namespace prefix.
    pub(super) fn name(&self) -> &'a [u8] {
        without_prefix(self.full_name())
    }

    /// Its attributes, up to the first error.
    pub(super) fn attributes(&self) -> impl Iterator<Item = Result<Attribute<'a>, TextFault>> {
        let mut all = self.start.attributes();
        // Checks compare each attribute with all others.
        all.with_checks(false);
        all.map(|attribute| match attribute {
            Ok(attribute) => {
                let part = |bytes: &[u8]| self.text.get(self.place_of(bytes)).unwrap_or_default();
                Ok(Attribute {
                    name: part(attribute.key.into_inner()),
                    value: part(&attribute.value),
                    place: self.place_of(&attribute.value),
                })
            }
            Err(error) => {
                let message = format!("not valid XML: {error}");
                Err(TextFault::new(self.place.clone(), message))
            }
        })
    }

    /// The attribute of this name: without a prefix if there is one, else with any prefix.
    pub(super) fn find(&self, name: &str) -> Result<Option<Attribute<'a>>, TextFault> {
        let mut prefixed = None;
        for attribute in self.attributes() {
            let attribute = attribute?;
            if attribute.name == name.as_bytes() {
                return Ok(Some(attribute));
            }
            if without_prefix(attribute.name) == name.as_bytes() {
                prefixed = Some(attribute);
            }
        }
        Ok(prefixed)
    }

    /// The attribute of this name. Missing is an error.
    pub(super) fn get(&self, name: &str) -> Result<Attribute<'a>, TextFault> {
        self.find(name)?.ok_or_else(|| self.lacks(name))
    }

    /// The error about a missing attribute.
    pub(super) fn lacks(&self, name: &str) -> TextFault {
        let message = format!("{} has no attribute `{name}`", quote(self.full_name()));
        TextFault::new(self.place.clone(), message)
    }
}

fn without_prefix(name: &[u8]) -> &[u8] {
    let colon = name.iter().position(|&byte| byte == b':');
    name.get(colon.map_or(0, |colon| colon + 1)..).unwrap_or_default()
}

/// An attribute.
pub(super) struct Attribute<'a> {
    /// Its name, with the prefix.
    pub(super) name: &'a [u8],
    /// Its value, with entities as written.
    pub(super) value: &'a [u8],
    /// Where its value is in the text.
    pub(super) place: Range<usize>,
}

impl Attribute<'_> {
    /// An error about the value.
    pub(super) fn fault(&self, message: impl Into<String>) -> TextFault {
        TextFault::new(self.place.clone(), message)
    }

    /// The value as text, with entities replaced.
    pub(super) fn text(&self) -> Result<String, TextFault> {
        let text = std::str::from_utf8(self.value).map_err(|_| self.fault("this is not UTF-8"))?;
        let text = unescape(text).map_err(|error| self.fault(format!("not valid XML: {error}")))?;
        Ok(text.into_owned())
    }

    /// The value as a whole number.
    #[cfg(feature = "threemf")]
    pub(super) fn index(&self) -> Result<u32, TextFault> {
        let digits = std::str::from_utf8(self.value.trim_ascii());
        let index = digits.ok().and_then(|digits| digits.parse::<u32>().ok());
        index.ok_or_else(|| {
            let (name, value) = (quote(self.name), quote(self.value));
            self.fault(format!("{name} is {value}, expected a whole number"))
        })
    }

    /// The value as a colour such as `#FF8000`, perhaps with an opacity.
    #[cfg(feature = "threemf")]
    pub(super) fn color(&self) -> Result<[u8; 4], TextFault> {
        let digits = self.value.trim_ascii().strip_prefix(b"#");
        let digits = digits.filter(|digits| digits.iter().all(u8::is_ascii_hexdigit));
        let digits = digits.and_then(|digits| std::str::from_utf8(digits).ok());
        let number = digits.and_then(|digits| u32::from_str_radix(digits, 16).ok());
        let (Some(number), Some(6 | 8)) = (number, digits.map(str::len)) else {
            let found = quote(self.value);
            return Err(self.fault(format!("found {found}, expected a colour such as `#FF8000`")));
        };
        let is_opaque = digits.is_none_or(|digits| digits.len() == 6);
        Ok(if is_opaque { number << 8 | 0xff } else { number }.to_be_bytes())
    }

    /// The value as a coordinate on an axis, less an offset. `unusable` becomes the fault of the first one that is NaN or
    /// too large.
    #[cfg(feature = "threemf")]
    pub(super) fn coordinate(
        &self,
        axis: usize,
        offset: Offset,
        unusable: &mut Option<TextFault>,
    ) -> Result<f32, TextFault> {
        let what = ["x", "y", "z"][axis];
        let value = offset
            .parse(axis, self.value.trim_ascii())
            .map_err(|_| self.fault(format!("`{what}` is {}, expected a number", quote(self.value))))?;
        if !is_usable(value) && unusable.is_none() {
            *unusable = Some(self.fault(SceneError::NotUsable { what, value }.to_string()));
        }
        Ok(value)
    }
}

#[cfg(all(test, feature = "threemf"))]
mod tests;

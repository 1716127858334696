//! A bounded reader of XML: elements with their places in the text, and an escape for writers.
//!
//! Document types are refused, so that no entity but the five of XML exists and nothing is fetched.
//! The text is UTF-8.
//!
//! Source: XML 1.0, Namespaces in XML 1.0.

use crate::error::StreamError;
use crate::limits::{DescriptionLimits, StreamLimits};
use quick_xml::XmlVersion;
use quick_xml::events::attributes::Attributes;
use quick_xml::events::{BytesRef, Event};
use quick_xml::reader::Reader;
use std::borrow::Cow;
use std::ops::Range;

/// Maximum depth of an element, number of its attributes, and of the namespaces that it can name.
const MOST: usize = 64;
/// Maximum number of attributes per element of the limit.
const ATTRIBUTES: u64 = 8;

/// What a namespace stands for; identifiers are compared without regard to case.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Namespace {
    /// None.
    Absent,
    /// Generic bitstream syntax description.
    Gbsd,
    /// Digital item adaptation.
    Dia,
    /// Digital item declaration.
    Didl,
    /// Digital item identification.
    Dii,
    /// Names of a bitstream.
    Bs1,
    /// Ours.
    Vh,
    /// Types of XML schemas.
    Xsi,
    /// Any other.
    Other,
}

impl Namespace {
    fn of(identifier: &str) -> Self {
        match identifier.trim().to_ascii_lowercase().as_str() {
            "" => Self::Absent,
            "urn:mpeg:mpeg21:2003:01-dia-gbsd-ns" | "urn:mpeg:mpeg21:dia:schema:gbsd:2003" => {
                Self::Gbsd
            }
            "urn:mpeg:mpeg21:2003:01-dia-ns" => Self::Dia,
            "urn:mpeg:mpeg21:2002:02-didl-ns" | "urn:mpeg:mpeg21:2002:01-didl-ns" => Self::Didl,
            "urn:mpeg:mpeg21:2002:01-dii-ns" => Self::Dii,
            "urn:mpeg:mpeg21:2003:01-dia-bsdl1-ns" => Self::Bs1,
            "urn:articula:vh:1" => Self::Vh,
            "http://www.w3.org/2001/xmlschema-instance" => Self::Xsi,
            _ => Self::Other,
        }
    }
}

/// An attribute with its value unescaped; `xmlns` is none.
#[derive(Debug, Clone)]
pub(crate) struct Attribute<'a> {
    pub(crate) namespace: Namespace,
    /// Name with its prefix.
    pub(crate) key: &'a str,
    /// Name without its prefix.
    pub(crate) name: &'a str,
    pub(crate) value: Cow<'a, str>,
    /// Place of the value in the text, without its quotes.
    pub(crate) place: Range<usize>,
}

/// An element, by places in the text.
#[derive(Debug, Clone)]
pub(crate) struct Element<'a> {
    pub(crate) namespace: Namespace,
    /// Name without its prefix.
    pub(crate) name: &'a str,
    /// Prefix with its colon, or nothing.
    pub(crate) prefix: &'a str,
    /// Number of the element after the last one within it.
    pub(crate) end: usize,
    /// Its start tag.
    pub(crate) tag: Range<usize>,
    /// All of it, with its tags.
    pub(crate) span: Range<usize>,
    attributes: Range<usize>,
    text: Option<usize>,
}

/// A document whose elements are numbered in their order.
#[derive(Debug)]
pub(crate) struct Document<'a> {
    pub(crate) source: &'a str,
    pub(crate) elements: Vec<Element<'a>>,
    attributes: Vec<Attribute<'a>>,
    texts: Vec<Cow<'a, str>>,
}

impl<'a> Document<'a> {
    /// Parses a document.
    ///
    /// # Errors
    /// A [`StreamError`] that names the line, if it is no UTF-8, not well-formed, has a document type
    /// or exceeds a limit.
    pub(crate) fn parse(bytes: &'a [u8], limits: &DescriptionLimits) -> Result<Self, StreamError> {
        StreamLimits::check("document", "bytes", bytes.len() as u64, limits.bytes)?;
        let source = std::str::from_utf8(bytes).map_err(|e| {
            let at = format!("byte {}", e.valid_up_to());
            StreamError::malformed(at, "expected a document in UTF-8")
        })?;
        let source = source.strip_prefix('\u{feff}').unwrap_or(source);
        if let Some((offset, c)) = source.char_indices().find(|(_, c)| !is_allowed(*c)) {
            return Err(StreamError::malformed(line(source, offset), forbidden(c)));
        }
        let mut parser = Parser {
            document: Document {
                source,
                elements: Vec::new(),
                attributes: Vec::new(),
                texts: Vec::new(),
            },
            limits: *limits,
            open: Vec::new(),
            scopes: Vec::new(),
        };
        parser.run()?;
        Ok(parser.document)
    }

    /// The numbers of the elements in an element, without those within them.
    pub(crate) fn children(&self, of: usize) -> impl Iterator<Item = usize> + '_ {
        let end = self.elements.get(of).map_or(0, |element| element.end);
        let mut next = of + 1;
        std::iter::from_fn(move || {
            let here = next;
            (here < end).then(|| {
                next = self.elements[here].end;
                here
            })
        })
    }

    /// The attributes of an element.
    pub(crate) fn attributes(&self, of: usize) -> &[Attribute<'a>] {
        &self.attributes[self.elements[of].attributes.clone()]
    }

    /// An attribute of one of some namespaces, by its name without regard to case.
    pub(crate) fn attribute(
        &self,
        of: usize,
        namespace: Namespace,
        name: &str,
    ) -> Option<&Attribute<'a>> {
        let is_it =
            |a: &&Attribute<'a>| a.namespace == namespace && a.name.eq_ignore_ascii_case(name);
        self.attributes(of).iter().find(is_it)
    }

    /// The value of an attribute without a namespace.
    pub(crate) fn value(&self, of: usize, name: &str) -> Option<&str> {
        let found = self.attribute(of, Namespace::Absent, name);
        found.map(|attribute| attribute.value.as_ref())
    }

    /// The type of an element (`xsi:type`) without its prefix.
    pub(crate) fn kind(&self, of: usize) -> Option<&str> {
        let found = self.attribute(of, Namespace::Xsi, "type")?;
        let value = found.value.trim();
        Some(value.rsplit_once(':').map_or(value, |(_, name)| name))
    }

    /// Whether an element has a name, without regard to case.
    pub(crate) fn is(&self, element: usize, name: &str) -> bool {
        self.elements[element].name.eq_ignore_ascii_case(name)
    }

    /// The first element with a name in an element.
    pub(crate) fn child(&self, of: usize, name: &str) -> Option<usize> {
        self.children(of).find(|child| self.is(*child, name))
    }

    /// The text of an element without that of elements within it, trimmed.
    pub(crate) fn text(&self, of: usize) -> &str {
        let found = self.elements[of].text;
        found.map_or("", |number| self.texts[number].trim())
    }

    /// The place of an element, for messages.
    pub(crate) fn line(&self, of: usize) -> String {
        line(
            self.source,
            self.elements.get(of).map_or(0, |e| e.span.start),
        )
    }

    /// An error at an element.
    pub(crate) fn bad(&self, of: usize, what: impl Into<String>) -> StreamError {
        StreamError::malformed(self.line(of), one_line(what.into()))
    }
}

/// Greatest length of a message in characters.
const MESSAGE: usize = 240;

/// A message of one line, as documents may hold texts of any length.
fn one_line(what: String) -> String {
    if what.len() <= MESSAGE && !what.contains(char::is_control) {
        return what;
    }
    let plain = |c: char| if c.is_control() { ' ' } else { c };
    let mut out: String = what.chars().take(MESSAGE).map(plain).collect();
    if what.chars().nth(MESSAGE).is_some() {
        out.push('…');
    }
    out
}

fn line(source: &str, offset: usize) -> String {
    let before = source.as_bytes().get(..offset).unwrap_or_default();
    format!(
        "line {}",
        1 + before.iter().filter(|byte| **byte == b'\n').count()
    )
}

struct Parser<'a> {
    document: Document<'a>,
    limits: DescriptionLimits,
    /// Elements whose end is not reached yet.
    open: Vec<usize>,
    /// Prefixes, what they stand for, and the depth at which they were declared.
    scopes: Vec<(&'a str, Namespace, usize)>,
}

impl<'a> Parser<'a> {
    fn bad(&self, offset: usize, what: impl Into<String>) -> StreamError {
        StreamError::malformed(line(self.document.source, offset), one_line(what.into()))
    }

    fn run(&mut self) -> Result<(), StreamError> {
        let source = self.document.source;
        let mut reader = Reader::from_str(source);
        loop {
            let start = reader.buffer_position() as usize;
            let event = reader.read_event();
            let event = event.map_err(|e| {
                let at = reader.error_position() as usize;
                self.bad(at, format!("malformed XML: {e}"))
            })?;
            let end = reader.buffer_position() as usize;
            match event {
                Event::Start(_) => self.start(start, end, false)?,
                Event::Empty(_) => self.start(start, end, true)?,
                Event::End(_) => self.end(end),
                Event::Text(text) => self.text(start, text.into_inner())?,
                Event::CData(text) => self.text(start, text.into_inner())?,
                Event::GeneralRef(entity) => {
                    let text = self.entity(start, &entity)?;
                    self.text(start, text.into())?;
                }
                Event::DocType(_) => {
                    return Err(StreamError::Unsupported {
                        at: line(source, start),
                        what: "a document type".into(),
                        mend: "remove <!DOCTYPE> and write what its entities stand for".into(),
                    });
                }
                Event::Decl(declared) => {
                    let encoding = declared.encoding().and_then(Result::ok);
                    let encoding = encoding.unwrap_or_default();
                    let is_known = ["", "utf-8", "utf8", "us-ascii"]
                        .contains(&encoding.to_ascii_lowercase().as_str());
                    if !is_known {
                        let what = format!("encoding {encoding}, expected UTF-8");
                        return Err(self.bad(start, what));
                    }
                }
                Event::Comment(_) | Event::PI(_) => {}
                Event::Eof => break,
            }
        }
        match (self.document.elements.first(), self.open.last()) {
            (None, _) => Err(self.bad(source.len(), "expected an element")),
            (_, Some(open)) => {
                let name = self.document.elements[*open].name;
                let what = format!("the document ends before </{name}>; it is truncated");
                Err(self.bad(source.len(), what))
            }
            _ => Ok(()),
        }
    }

    /// Compares a number of things with a limit.
    fn limit(
        &self,
        offset: usize,
        which: &'static str,
        found: usize,
        limit: u64,
    ) -> Result<(), StreamError> {
        if found as u64 <= limit {
            return Ok(());
        }
        let at = line(self.document.source, offset);
        StreamLimits::check(&at, which, found as u64, limit)
    }

    fn start(&mut self, start: usize, end: usize, is_empty: bool) -> Result<(), StreamError> {
        let number = self.document.elements.len();
        if self.open.is_empty() && number > 0 {
            return Err(self.bad(start, "an element after the end of the document"));
        }
        self.limit(start, "elements", number + 1, self.limits.nodes)?;
        let depth = self.open.len() + 1;
        self.limit(start, "elements within each other", depth, MOST as u64)?;
        // Without the signs around it.
        let trimmed = end - if is_empty { 2 } else { 1 };
        let source: &'a str = self.document.source;
        let inner = source.get(start + 1..trimmed).unwrap_or_default();
        let name_end = inner.find(|c: char| c.is_ascii_whitespace());
        let name_end = name_end.unwrap_or(inner.len());
        let name = &inner[..name_end];
        let attributes = self.attributes(start, inner, name_end)?;
        let (prefix, local) = name.split_once(':').unwrap_or(("", name));
        let namespace = self.namespace(prefix, start)?;
        self.document.elements.push(Element {
            namespace,
            name: local,
            prefix: &name[..name.len() - local.len()],
            end: number + 1,
            tag: start..end,
            span: start..end,
            attributes,
            text: None,
        });
        self.open.push(number);
        if is_empty {
            self.end(end);
        }
        Ok(())
    }

    /// Reads the attributes behind the name of an element, and the namespaces that it declares.
    fn attributes(
        &mut self,
        offset: usize,
        inner: &'a str,
        name_end: usize,
    ) -> Result<Range<usize>, StreamError> {
        let source: &'a str = self.document.source;
        let first = self.document.attributes.len();
        let depth = self.open.len() + 1;
        let mut prefixes: [&'a str; MOST] = [""; MOST];
        for (count, attribute) in Attributes::new(inner, name_end).enumerate() {
            let unreadable = |e: &dyn std::fmt::Display| {
                self.bad(offset, format!("an attribute cannot be read: {e}"))
            };
            let attribute = attribute.map_err(|e| unreadable(&e))?;
            let value = attribute.normalized_value(XmlVersion::Implicit1_0);
            let value = value.map_err(|e| unreadable(&e))?;
            // What the source holds is allowed; what stands by its number may not be.
            if let Cow::Owned(value) = &value
                && let Some(c) = value.chars().find(|c| !is_allowed(*c))
            {
                return Err(self.bad(offset, forbidden(c)));
            }
            self.limit(offset, "attributes", count + 1, MOST as u64)?;
            let key = attribute.key.into_inner();
            let (prefix, local) = key.split_once(':').unwrap_or(("", key));
            if prefix == "xmlns" || key == "xmlns" {
                let prefix = if prefix.is_empty() { "" } else { local };
                self.scopes.push((prefix, Namespace::of(&value), depth));
                self.limit(offset, "namespaces", self.scopes.len(), MOST as u64)?;
                continue;
            }
            let place = match &attribute.value {
                Cow::Borrowed(raw) => {
                    let from = raw.as_ptr() as usize - source.as_ptr() as usize;
                    from..from + raw.len()
                }
                Cow::Owned(_) => 0..0,
            };
            prefixes[self.document.attributes.len() - first] = prefix;
            self.document.attributes.push(Attribute {
                namespace: Namespace::Absent,
                key,
                name: local,
                value,
                place,
            });
        }
        let all = self.document.attributes.len();
        let most = ATTRIBUTES.saturating_mul(self.limits.nodes);
        self.limit(offset, "attributes", all, most)?;
        for (number, prefix) in (first..all).zip(prefixes) {
            if !prefix.is_empty() {
                self.document.attributes[number].namespace = self.namespace(prefix, offset)?;
            }
        }
        Ok(first..all)
    }

    fn namespace(&self, prefix: &str, offset: usize) -> Result<Namespace, StreamError> {
        let declared = self.scopes.iter().rev().find(|scope| scope.0 == prefix);
        match (declared, prefix) {
            (Some(scope), _) => Ok(scope.1),
            (None, "") => Ok(Namespace::Absent),
            (None, "xml") => Ok(Namespace::Other),
            _ => {
                let what = format!("the prefix {prefix} is not declared");
                Err(self.bad(offset, what))
            }
        }
    }

    fn end(&mut self, end: usize) {
        let depth = self.open.len();
        while self.scopes.last().is_some_and(|scope| scope.2 >= depth) {
            self.scopes.pop();
        }
        let next = self.document.elements.len();
        if let Some(number) = self.open.pop() {
            let element = &mut self.document.elements[number];
            element.span.end = end;
            element.end = next;
        }
    }

    fn text(&mut self, offset: usize, text: Cow<'a, str>) -> Result<(), StreamError> {
        let is_blank = text.trim().is_empty();
        let Some(number) = self.open.last() else {
            if is_blank {
                return Ok(());
            }
            return Err(self.bad(offset, "text outside of the document"));
        };
        let element = &mut self.document.elements[*number];
        match element.text {
            None if is_blank => {}
            None => {
                element.text = Some(self.document.texts.len());
                self.document.texts.push(text);
            }
            Some(known) => self.document.texts[known].to_mut().push_str(&text),
        }
        Ok(())
    }

    fn entity(&self, offset: usize, entity: &BytesRef<'_>) -> Result<String, StreamError> {
        if entity.is_char_ref() {
            let found = entity.resolve_char_ref().ok().flatten();
            let found = found.filter(|c| is_allowed(*c)).map(String::from);
            return found.ok_or_else(|| self.bad(offset, "a character that does not exist"));
        }
        let name = entity.xml10_content();
        let known = quick_xml::escape::resolve_predefined_entity(&name);
        known.map(String::from).ok_or_else(|| {
            let what = "an entity that XML does not predefine; write what it stands for";
            self.bad(offset, what)
        })
    }
}

/// Whether a document may hold a character, as itself or by its number (XML 1.0, 2.2).
pub(super) fn is_allowed(c: char) -> bool {
    !matches!(c, '\0'..='\u{8}' | '\u{b}' | '\u{c}' | '\u{e}'..='\u{1f}' | '\u{fffe}' | '\u{ffff}')
}

fn forbidden(c: char) -> String {
    format!("U+{:04X}, which XML cannot hold", u32::from(c))
}

/// A number that stands in a text without sign or point.
pub(crate) fn whole(text: &str) -> Option<u64> {
    let text = text.trim();
    let is_plain = !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    is_plain.then(|| text.parse().ok()).flatten()
}

/// Escapes a text for an element or an attribute in double quotes. Characters that XML 1.0 cannot
/// hold become U+FFFD.
pub(crate) fn escape(text: &str) -> Cow<'_, str> {
    let is_plain = |byte: u8| byte >= b' ' && !matches!(byte, b'&' | b'<' | b'>' | b'"' | 0x7f);
    if text.bytes().all(is_plain) && !text.contains(['\u{fffe}', '\u{ffff}']) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\t' => out.push_str("&#9;"),
            '\n' => out.push_str("&#10;"),
            '\r' => out.push_str("&#13;"),
            c if is_allowed(c) => out.push(c),
            _ => out.push('\u{fffd}'),
        }
    }
    Cow::Owned(out)
}

#[cfg(test)]
mod tests;

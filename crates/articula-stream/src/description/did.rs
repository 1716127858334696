//! DID: the list of the resources of a digital item, and what adapts them.
//!
//! Form: `docs/formats/did.md`. Source: ISO/IEC 21000-2 (digital item declaration language, DIDL),
//! annex B of the thesis.

use super::bsd_link::BsdLink;
use super::item_path::ItemPath;
use super::xml::{Document, Namespace, escape};
use crate::error::StreamError;
use crate::limits::DescriptionLimits;
use articula_core::Mismatch;
use std::fmt::Write;

/// A digital item declaration.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Did {
    /// Items in order.
    pub items: Vec<DidItem>,
}

/// An item: resources, and items in it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct DidItem {
    /// Its name.
    pub id: Option<String>,
    /// What is said of it.
    pub descriptors: Vec<DidDescriptor>,
    /// Items in it.
    pub items: Vec<Self>,
    /// Its components.
    pub components: Vec<DidComponent>,
}

/// Resources with what is said of them.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct DidComponent {
    /// What is said of them.
    pub descriptors: Vec<DidDescriptor>,
    /// Resources, alternatives of each other.
    pub resources: Vec<DidResource>,
}

/// A statement about an item or a component.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum DidDescriptor {
    /// An identifier of something related, such as the track of a stream (`trackID=2`).
    RelatedIdentifier(String),
    /// What adapts the resource.
    BsdLink(BsdLink),
    /// Another statement, carried as it is: its type and its XML or text.
    Other {
        /// Media type.
        mime_type: String,
        /// Content of the statement, as it stands in the document.
        xml: String,
    },
}

/// A resource: its media type, and where it is or what it holds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DidResource {
    /// Media type, such as `application/sdp`.
    pub mime_type: String,
    /// The file in the item.
    pub reference: Option<ItemPath>,
    /// Text of the resource in the declaration itself; empty if it has none.
    pub text: String,
}

impl Did {
    /// Reads a declaration. References that leave the item are an error; nothing is opened.
    ///
    /// # Errors
    /// A [`StreamError`] that names the line, for XML that cannot be read, an unknown element of the
    /// namespace of DIDL, a BSDLink without description, and references that leave the item.
    pub fn read(bytes: &[u8], limits: &DescriptionLimits) -> Result<Self, StreamError> {
        let document = Document::parse(bytes, limits)?;
        if !document.is(0, "DIDL") {
            let name = document.elements[0].name;
            return Err(document.bad(0, format!("<{name}>, expected DIDL")));
        }
        let items = own(&document, 0).map(|element| match document.is(element, "Item") {
            true => item(&document, element),
            false => Err(unknown(&document, element, "Item")),
        });
        let items = items.collect::<Result<_, StreamError>>()?;
        Ok(Self { items })
    }

    /// Writes the declaration, so that [`Did::read`] gives it back.
    ///
    /// # Errors
    /// A [`Mismatch`] if the XML of a statement cannot stand in it: it is not well-formed, or has
    /// prefixes other than `dia`, `dii`, `dip`, `mpeg7` and `xsi` that it does not declare.
    pub fn write(&self) -> Result<String, Mismatch> {
        let mut out = String::from(HEAD);
        self.items
            .iter()
            .for_each(|item| write_item(&mut out, item));
        out.push_str("</DIDL>\n");
        let limits = DescriptionLimits {
            bytes: u64::MAX,
            nodes: u64::MAX >> 8,
        };
        match Self::read(out.as_bytes(), &limits) {
            Ok(same) if same == *self => Ok(out),
            Ok(_) => {
                let what = "a text cannot stand in XML as it is: blanks around it, or a statement \
                            that another kind of descriptor has";
                Err(Mismatch::new("DIDL", what))
            }
            Err(e) => Err(Mismatch::new("DIDL", e.to_string())),
        }
    }

    /// All links with the resources that they adapt, in order.
    pub fn links(&self) -> Vec<(&BsdLink, &DidResource)> {
        let mut found = Vec::new();
        for item in &self.items {
            links(item, &mut found);
        }
        found
    }
}

const HEAD: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
    <DIDL xmlns=\"urn:mpeg:mpeg21:2002:02-DIDL-NS\" xmlns:dia=\"urn:mpeg:mpeg21:2003:01-DIA-NS\" \
    xmlns:dii=\"urn:mpeg:mpeg21:2002:01-DII-NS\" xmlns:dip=\"urn:mpeg:mpeg21:2003:01-DIP-NS\" \
    xmlns:mpeg7=\"urn:mpeg:mpeg7:schema:2001\" \
    xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\">\n";

fn links<'a>(item: &'a DidItem, found: &mut Vec<(&'a BsdLink, &'a DidResource)>) {
    for component in &item.components {
        let descriptors = component.descriptors.iter().chain(&item.descriptors);
        let link = descriptors.filter_map(|descriptor| match descriptor {
            DidDescriptor::BsdLink(link) => Some(link),
            _ => None,
        });
        if let (Some(link), Some(resource)) = (link.clone().next(), component.resources.first()) {
            found.push((link, resource));
        }
    }
    item.items.iter().for_each(|inner| links(inner, found));
}

/// Elements of the namespace of DIDL, or of none; others are left out.
fn own<'a>(document: &'a Document<'_>, of: usize) -> impl Iterator<Item = usize> + 'a {
    document.children(of).filter(|child| {
        let namespace = document.elements[*child].namespace;
        matches!(namespace, Namespace::Didl | Namespace::Absent)
    })
}

fn unknown(document: &Document<'_>, element: usize, expected: &str) -> StreamError {
    let name = document.elements[element].name;
    document.bad(element, format!("<{name}>, expected {expected}"))
}

fn item(document: &Document<'_>, element: usize) -> Result<DidItem, StreamError> {
    let mut found = DidItem {
        id: document.value(element, "id").map(str::to_owned),
        ..DidItem::default()
    };
    for child in own(document, element) {
        if document.is(child, "Descriptor") {
            found.descriptors.extend(descriptor(document, child)?);
        } else if document.is(child, "Item") {
            found.items.push(item(document, child)?);
        } else if document.is(child, "Component") {
            found.components.push(component(document, child)?);
        } else {
            return Err(unknown(document, child, "Descriptor, Item or Component"));
        }
    }
    Ok(found)
}

fn component(document: &Document<'_>, element: usize) -> Result<DidComponent, StreamError> {
    let mut found = DidComponent::default();
    for child in own(document, element) {
        if document.is(child, "Descriptor") {
            found.descriptors.extend(descriptor(document, child)?);
        } else if document.is(child, "Resource") {
            found.resources.push(resource(document, child)?);
        } else {
            return Err(unknown(document, child, "Descriptor or Resource"));
        }
    }
    Ok(found)
}

fn resource(document: &Document<'_>, element: usize) -> Result<DidResource, StreamError> {
    let reference = match document.value(element, "ref") {
        None => None,
        Some(text) => {
            let path: Result<ItemPath, Mismatch> = text.parse();
            Some(path.map_err(|e| document.bad(element, e.to_string()))?)
        }
    };
    Ok(DidResource {
        mime_type: document
            .value(element, "mimeType")
            .unwrap_or_default()
            .to_owned(),
        reference,
        text: document.text(element).to_owned(),
    })
}

/// The statements of a descriptor; one may hold several.
fn descriptor(document: &Document<'_>, element: usize) -> Result<Vec<DidDescriptor>, StreamError> {
    let statements = own(document, element).map(|child| match document.is(child, "Statement") {
        true => statement(document, child),
        false => Err(unknown(document, child, "Statement")),
    });
    statements.collect()
}

fn statement(document: &Document<'_>, element: usize) -> Result<DidDescriptor, StreamError> {
    let inside = element + 1..document.elements[element].end;
    let link = inside.clone().find(|inner| {
        let kind = document.kind(*inner).unwrap_or_default();
        document.is(*inner, "Description") && kind.eq_ignore_ascii_case("BSDLinkType")
    });
    if let Some(link) = link {
        return BsdLink::read(document, link).map(DidDescriptor::BsdLink);
    }
    let only = (inside.len() == 1).then_some(element + 1);
    let identifier = only.filter(|inner| document.is(*inner, "RelatedIdentifier"));
    if let Some(identifier) = identifier {
        let text = document.text(identifier).to_owned();
        return Ok(DidDescriptor::RelatedIdentifier(text));
    }
    let here = &document.elements[element];
    let source = document.source;
    let close = source[here.span.clone()]
        .rfind("</")
        .map(|at| here.span.start + at);
    let inner = close.and_then(|close| source.get(here.tag.end..close));
    Ok(DidDescriptor::Other {
        mime_type: document
            .value(element, "mimeType")
            .unwrap_or_default()
            .to_owned(),
        xml: inner.unwrap_or_default().to_owned(),
    })
}

fn write_item(out: &mut String, item: &DidItem) {
    // Writing to a text cannot fail.
    let _ = match &item.id {
        Some(id) => writeln!(out, "<Item id=\"{}\">", escape(id)),
        None => writeln!(out, "<Item>"),
    };
    item.descriptors
        .iter()
        .for_each(|descriptor| write_descriptor(out, descriptor));
    item.items.iter().for_each(|inner| write_item(out, inner));
    for component in &item.components {
        out.push_str("<Component>\n");
        component
            .descriptors
            .iter()
            .for_each(|descriptor| write_descriptor(out, descriptor));
        for resource in &component.resources {
            let _ = write!(
                out,
                "<Resource mimeType=\"{}\"",
                escape(&resource.mime_type)
            );
            if let Some(path) = &resource.reference {
                let _ = write!(out, " ref=\"{}\"", escape(path.as_str()));
            }
            let _ = match resource.text.as_str() {
                "" => writeln!(out, "/>"),
                text => writeln!(out, ">{}</Resource>", escape(text)),
            };
        }
        out.push_str("</Component>\n");
    }
    out.push_str("</Item>\n");
}

fn write_descriptor(out: &mut String, descriptor: &DidDescriptor) {
    let (mime_type, inner) = match descriptor {
        DidDescriptor::RelatedIdentifier(text) => {
            let text = escape(text);
            (
                "text/xml",
                format!("<dii:RelatedIdentifier>{text}</dii:RelatedIdentifier>"),
            )
        }
        DidDescriptor::BsdLink(link) => {
            let mut inner = String::new();
            link.write(&mut inner);
            ("text/xml", inner)
        }
        DidDescriptor::Other { mime_type, xml } => (mime_type.as_str(), xml.clone()),
    };
    let mime_type = escape(mime_type);
    let _ = writeln!(
        out,
        "<Descriptor><Statement mimeType=\"{mime_type}\">{inner}</Statement></Descriptor>"
    );
}

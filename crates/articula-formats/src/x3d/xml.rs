//! The XML encoding: elements are nodes, attributes their fields.
//!
//! A document type that names an external file is skipped, as every X3D file has one; nothing is
//! ever fetched. One with an internal subset is an error, as are entities except the five of XML.
//!
//! Source: ISO/IEC 19776-1 (X3D encodings: XML); XML 1.0, 2.8 and 4.1.

use super::scene::{Builder, NodeId, declares_fields, standard_kind};
use crate::error::ReadError;
use crate::limits::Limits;
use quick_xml::XmlVersion;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;
use std::borrow::Cow;

/// Maximum number of attributes, twice the number of fields of any node.
const MAX_ATTRIBUTES: usize = 128;

/// Kind of an open element.
#[derive(Debug, Clone)]
enum Element {
    /// A node, or the `USE` of one.
    Node(NodeId),
    /// A `fieldValue` of a prototype instance: its content goes into this field.
    Field(NodeId, String),
    /// `X3D`, `head`, `Scene` and statements.
    Frame,
    /// An element that is left out with its content.
    Skipped,
}

/// Reads a whole document.
pub(super) fn parse<'a, 'l>(
    text: &'a str,
    limits: &'l Limits,
) -> Result<Builder<'a, 'l>, ReadError> {
    let mut parser = Parser {
        builder: Builder::new(text, limits),
        open: Vec::new(),
        seen_root: false,
    };
    let mut reader = Reader::from_str(text);
    reader.config_mut().expand_empty_elements = true;
    loop {
        let offset = reader.buffer_position() as usize;
        let event = reader.read_event().map_err(|e| {
            let at = reader.error_position() as usize;
            parser.builder.malformed(at, format!("malformed XML: {e}"))
        })?;
        match event {
            Event::Start(start) => parser.start(&start, offset)?,
            Event::End(_) => parser.end(),
            Event::DocType(what) => parser.check_doctype(&what, offset)?,
            Event::GeneralRef(entity) => parser.check_entity(&entity, offset)?,
            Event::Eof => break,
            _ => {}
        }
    }
    parser.finish(text.len())
}

#[derive(Debug)]
struct Parser<'a, 'l> {
    builder: Builder<'a, 'l>,
    open: Vec<Element>,
    seen_root: bool,
}

type Attributes = Vec<(String, String)>;

impl<'a, 'l> Parser<'a, 'l> {
    fn start(&mut self, start: &BytesStart<'_>, offset: usize) -> Result<(), ReadError> {
        self.builder.check_depth(self.open.len() + 1, offset)?;
        let name = start.local_name().into_inner().to_owned();
        if !self.seen_root && name != "X3D" {
            let what = format!("the file begins with <{name}>, expected <X3D>");
            return Err(self.builder.malformed(offset, what));
        }
        self.seen_root = true;
        let element = match self.open.last() {
            Some(Element::Skipped) => Element::Skipped,
            _ => {
                let attributes = self.attributes(start, offset)?;
                self.element(name, attributes, offset)?
            }
        };
        self.open.push(element);
        Ok(())
    }

    fn end(&mut self) {
        if let Some(Element::Node(id)) = self.open.pop() {
            self.builder.close(id);
        }
    }

    fn finish(self, length: usize) -> Result<Builder<'a, 'l>, ReadError> {
        if !self.seen_root || !self.open.is_empty() {
            let what = "the file ends before </X3D>; it is truncated";
            return Err(self.builder.malformed(length, what));
        }
        Ok(self.builder)
    }

    fn element(
        &mut self,
        name: String,
        mut attributes: Attributes,
        offset: usize,
    ) -> Result<Element, ReadError> {
        let mut take = |key: &str| {
            let found = attributes.iter().position(|(name, _)| name == key);
            found.map(|i| attributes.swap_remove(i).1)
        };
        match name.as_str() {
            "X3D" => {
                self.builder.version(&take("version").unwrap_or_default());
                Ok(Element::Frame)
            }
            "head" | "Scene" | "component" => Ok(Element::Frame),
            "meta" => {
                let name = take("name").unwrap_or_default();
                self.builder
                    .meta(&name, &take("content").unwrap_or_default());
                Ok(Element::Frame)
            }
            "unit" => {
                let category = take("category").unwrap_or_default();
                let factor = take("conversionFactor").unwrap_or_default();
                self.builder.unit(&category, &factor, offset);
                Ok(Element::Frame)
            }
            "ROUTE" => {
                let mut end = |node: &str, field: &str| {
                    (
                        take(node).unwrap_or_default(),
                        take(field).unwrap_or_default(),
                    )
                };
                let (from, to) = (end("fromNode", "fromField"), end("toNode", "toField"));
                let (from, to) = ((&*from.0, &*from.1), (&*to.0, &*to.1));
                self.builder.route(from, to, offset);
                Ok(Element::Frame)
            }
            "EXPORT" | "ProtoDeclare" | "ExternProtoDeclare" | "IS" | "field" => {
                Ok(Element::Skipped)
            }
            "IMPORT" | "Inline" => {
                let what = format!("{name} is not read; its content is left out");
                self.builder.warn(offset, what);
                Ok(Element::Skipped)
            }
            "fieldValue" => Ok(self.field_value(take("name"), take("value"))),
            "ProtoInstance" => {
                let kind = take("name").unwrap_or_default();
                let kind = standard_kind(&kind).into_owned();
                self.node(kind, attributes, offset)
            }
            _ if declares_fields(&name) => Ok(Element::Skipped),
            _ => self.node(name, attributes, offset),
        }
    }

    fn field_value(&mut self, name: Option<String>, value: Option<String>) -> Element {
        let (Some(Element::Node(id)), Some(name)) = (self.open.last(), name) else {
            return Element::Skipped;
        };
        let id = *id;
        if let Some(value) = value {
            let field = (Cow::Owned(name.clone()), Cow::Owned(value));
            self.builder.scene.nodes[id].texts.push(field);
        }
        Element::Field(id, name)
    }

    fn node(
        &mut self,
        kind: String,
        attributes: Attributes,
        offset: usize,
    ) -> Result<Element, ReadError> {
        let (mut def, mut used, mut container) = (String::new(), None, None);
        let mut texts = Vec::new();
        for (key, value) in attributes {
            match key.as_str() {
                "DEF" => def = value,
                "USE" => used = Some(value),
                "containerField" => container = Some(value),
                _ => texts.push((Cow::Owned(key), Cow::Owned(value))),
            }
        }
        let (parent, field) = match self.open.last() {
            Some(Element::Field(id, name)) => (Some(*id), Some(name.clone())),
            Some(Element::Node(id)) => (Some(*id), container),
            _ => (None, container),
        };
        let field = field.map_or_else(|| Cow::Borrowed(usual_field(&kind)), Cow::Owned);
        if let Some(name) = used {
            if let Some(id) = self.builder.used(&name, offset) {
                self.builder.attach(parent, field, id);
            }
            // A USE has no content; if there is some, there is no node to attach it to.
            return Ok(Element::Skipped);
        }
        let id = self.builder.open(kind, offset)?;
        let node = &mut self.builder.scene.nodes[id];
        node.def = Cow::Owned(def);
        node.texts = texts;
        self.builder.attach(parent, field, id);
        Ok(Element::Node(id))
    }

    fn attributes(&self, start: &BytesStart<'_>, offset: usize) -> Result<Attributes, ReadError> {
        let mut list: Attributes = Vec::new();
        // The parser's check for duplicates is quadratic; here the number of attributes is bounded.
        for attribute in start.attributes().with_checks(false) {
            let bad = |e: &dyn std::fmt::Display| {
                let what = format!("an attribute cannot be read: {e}");
                self.builder.malformed(offset, what)
            };
            let attribute = attribute.map_err(|e| bad(&e))?;
            let key = attribute.key.into_inner();
            let value = attribute
                .normalized_value(XmlVersion::Implicit1_0)
                .map_err(|e| bad(&e))?;
            if list.iter().any(|(known, _)| known == key) {
                return Err(bad(&format!("{key} is given twice")));
            }
            if list.len() == MAX_ATTRIBUTES {
                return Err(bad(&format!("the limit is {MAX_ATTRIBUTES} attributes")));
            }
            list.push((key.to_owned(), value.into_owned()));
        }
        Ok(list)
    }

    fn check_doctype(&self, declared: &str, offset: usize) -> Result<(), ReadError> {
        if !declared.contains('[') {
            return Ok(());
        }
        Err(ReadError::Unsupported {
            at: self.builder.line(offset),
            what: "a document type with an internal subset".to_owned(),
            mend: "remove the part in [ ] from <!DOCTYPE>".to_owned(),
        })
    }

    fn check_entity(&self, name: &str, offset: usize) -> Result<(), ReadError> {
        let known = matches!(name, "amp" | "lt" | "gt" | "quot" | "apos") || name.starts_with('#');
        if known {
            return Ok(());
        }
        let what = "an entity that XML does not predefine".to_owned();
        Err(ReadError::Unsupported {
            at: self.builder.line(offset),
            what,
            mend: "write the character instead of its name".to_owned(),
        })
    }
}

/// Returns the default field of a node type, used if the file has no `containerField`.
fn usual_field(kind: &str) -> &'static str {
    match kind {
        "Appearance" => "appearance",
        "Material" | "UnlitMaterial" | "PhysicalMaterial" | "TwoSidedMaterial" => "material",
        "ImageTexture" | "PixelTexture" | "MovieTexture" | "MultiTexture" => "texture",
        "TextureTransform" => "textureTransform",
        "Coordinate" | "CoordinateDouble" => "coord",
        "TextureCoordinate" | "TextureCoordinateGenerator" | "MultiTextureCoordinate" => "texCoord",
        "Normal" => "normal",
        "Color" | "ColorRGBA" => "color",
        "HAnimDisplacer" => "displacers",
        "HAnimMotion" => "motions",
        "IndexedFaceSet"
        | "IndexedTriangleSet"
        | "IndexedTriangleFanSet"
        | "IndexedTriangleStripSet"
        | "TriangleSet"
        | "TriangleFanSet"
        | "TriangleStripSet"
        | "IndexedLineSet"
        | "LineSet"
        | "PointSet"
        | "Box"
        | "Sphere"
        | "Cylinder"
        | "Cone"
        | "Text"
        | "ElevationGrid"
        | "Extrusion"
        | "QuadSet"
        | "IndexedQuadSet" => "geometry",
        _ if kind.starts_with("Metadata") => "metadata",
        _ => "children",
    }
}

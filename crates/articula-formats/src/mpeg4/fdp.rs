//! FDP files of Xface: units of a face, its feature points, and the vertices that each FAP moves.
//!
//! Source: Xface's XML format, version 0.2 (`docs/formats/mpeg4.md`). The facial definition
//! parameters of the standard are a binary scene; this format holds corresponding data for one
//! external mesh. Numbers are in the mesh's own unit.

pub use super::fdp_write::write;
use articula_core::LibmQuat;

use crate::words::shortened;
use crate::{Limits, Parsed, ReadError, Warning};
use articula_core::fap_table::FAP_COUNT;
use glam::{Quat, Vec3};
use quick_xml::XmlVersion;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;
use std::fmt::Display;
use std::str::FromStr;

/// The supported version.
pub(super) const VERSION: &str = "0.2";
/// Maximum number of attributes, several times that of any element.
const MAX_ATTRIBUTES: usize = 64;
/// Maximum absolute value of a number.
const LARGEST: f32 = 1e9;

/// Distances of the neutral face, in the mesh's unit; FAPs are in 1024ths of them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Fapu {
    /// Diameter of the iris.
    pub irisd0: f32,
    /// Distance between the eyes.
    pub es0: f32,
    /// Distance from eye to nose.
    pub ens0: f32,
    /// Distance from mouth to nose.
    pub mns0: f32,
    /// Width of the mouth.
    pub mw0: f32,
}

/// A mesh file of the face.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MeshSource {
    /// Its content, such as `Rest` or `SmileOpen`.
    pub alias: String,
    /// Kind of that content: `FapExpression`, `Modifier` or `Viseme`.
    pub category: String,
    /// The files, relative to this one; none is read.
    pub meshes: Vec<String>,
    /// Parts of the face, such as `LeftEye`, and the submesh that shows each.
    pub parts: Vec<(String, String)>,
}

/// Influence of one FAP on the vertices around a feature point.
#[derive(Debug, Clone, PartialEq)]
pub struct FapInfluence {
    /// Number of the FAP, 1 to 68 (the file counts from 0).
    pub fap: usize,
    /// Name of its falloff function in Xface.
    pub kind: String,
    /// Strength.
    pub weight: f32,
}

/// A feature point on a mesh, and the vertices that follow it.
#[derive(Debug, Clone, PartialEq)]
pub struct FeaturePoint {
    /// Group and number: 2.10 is `(2, 10)`.
    pub point: (u8, u8),
    /// Submesh that contains it.
    pub mesh: String,
    /// Index of its vertex.
    pub vertex: u32,
    /// Vertices in its zone.
    pub zone: Vec<u32>,
    /// The FAPs that move them.
    pub influences: Vec<FapInfluence>,
}

/// Content of an FDP file of the Xface toolkit: units, meshes and feature points of a face.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FdpFile {
    /// Facial animation parameter units.
    pub fapu: Fapu,
    /// Position of the face.
    pub translation: Vec3,
    /// Orientation of the face.
    pub rotation: Quat,
    /// Mesh files.
    pub sources: Vec<MeshSource>,
    /// Feature points, in the order of the file.
    pub points: Vec<FeaturePoint>,
}

impl FdpFile {
    /// Returns which FAPs move at least one vertex; index 0 is FAP 1.
    pub fn moved(&self) -> [bool; FAP_COUNT] {
        let mut moved = [false; FAP_COUNT];
        for point in self.points.iter().filter(|p| !p.zone.is_empty()) {
            for influence in point.influences.iter().filter(|i| i.weight != 0.0) {
                moved[influence.fap - 1] = true;
            }
        }
        moved
    }
}

/// Reads an FDP file.
///
/// # Errors
/// [`ReadError`] with the line, if it is not such a document, has a document type or entities of
/// its own, or exceeds the limits.
pub fn read(bytes: &[u8], limits: &Limits) -> Result<Parsed<FdpFile>, ReadError> {
    Limits::check("file", "bytes", bytes.len() as u64, limits.bytes)?;
    let text = std::str::from_utf8(bytes).map_err(|e| {
        let line = Place::new(bytes).line(e.valid_up_to());
        ReadError::malformed(line, "the text is not valid UTF-8")
    })?;
    let mut parser = Parser {
        place: Place::new(bytes),
        limits,
        open: Vec::new(),
        values: 0,
        found: FdpFile::default(),
        seen: SeenElements::default(),
        warnings: Vec::new(),
    };
    let mut reader = Reader::from_str(text);
    reader.config_mut().expand_empty_elements = true;
    loop {
        let offset = reader.buffer_position() as usize;
        let event = reader.read_event().map_err(|e| {
            let line = parser.place.line(reader.error_position() as usize);
            ReadError::malformed(line, format!("malformed XML: {e}"))
        })?;
        match event {
            Event::Start(start) => parser.start(&start, offset)?,
            Event::End(_) => {
                parser.open.pop();
            }
            Event::Text(words) => parser.words(&words, offset)?,
            Event::CData(words) => parser.words(&words, offset)?,
            Event::DocType(_) => {
                return Err(parser.refused(offset, "a document type", "remove <!DOCTYPE>"));
            }
            Event::GeneralRef(_) => {
                return Err(parser.refused(
                    offset,
                    "an entity",
                    "write the character instead of its name",
                ));
            }
            Event::Eof => break,
            _ => {}
        }
    }
    parser.finish()
}

/// Required elements that were found.
#[derive(Debug, Default)]
struct SeenElements {
    root: bool,
    fapu: bool,
}

struct Parser<'a> {
    place: Place<'a>,
    limits: &'a Limits,
    open: Vec<String>,
    values: u64,
    found: FdpFile,
    seen: SeenElements,
    warnings: Vec<Warning>,
}

impl Parser<'_> {
    fn start(&mut self, start: &BytesStart<'_>, offset: usize) -> Result<(), ReadError> {
        let line = self.place.line(offset);
        let depth = self.open.len() as u64 + 1;
        Limits::check(&line, "nested elements", depth, self.limits.depth)?;
        let name = start.name().into_inner().to_owned();
        if !self.seen.root && name != "xfdp" {
            let shown = shortened(&name);
            let what = format!("the file begins with <{shown}>, expected <xfdp>");
            return Err(ReadError::malformed(line, what));
        }
        self.seen.root = true;
        let element = Element {
            attributes: self.attributes(start, &line)?,
            line,
        };
        match name.as_str() {
            "file" => self.version(&element),
            "fapu" => self.fapu(&element)?,
            "translation" => {
                self.found.translation = element.vector(["x", "y", "z"])?;
            }
            "rotation" => {
                let axis = element.vector(["axis_x", "axis_y", "axis_z"])?;
                let angle = element.number("axis_angle")?;
                let axis = axis.try_normalize().unwrap_or(Vec3::Y);
                self.found.rotation = Quat::libm_axis_angle(axis, angle);
            }
            "entity" => self.found.sources.push(MeshSource {
                alias: element.word("alias"),
                category: element.word("category"),
                ..MeshSource::default()
            }),
            "mesh" | "bind" => self.part(&name, &element)?,
            "fdp" => self.point(&element)?,
            "influence" => self.influence(&element)?,
            _ => {}
        }
        self.count(&element.line, 1)?;
        self.open.push(name);
        Ok(())
    }

    fn version(&mut self, element: &Element) {
        let version = element.word("version");
        if version != VERSION {
            let shown = shortened(&version);
            let what = format!("version \"{shown}\" is read as {VERSION}");
            self.warnings.push(Warning::new(&element.line, what));
        }
    }

    fn fapu(&mut self, element: &Element) -> Result<(), ReadError> {
        self.seen.fapu = true;
        let unit = |name: &str| -> Result<f32, ReadError> {
            let value = element.number(name)?;
            if value > 0.0 {
                return Ok(value);
            }
            let what = format!("{name} of {value} found, a length above 0 expected");
            Err(ReadError::malformed(&element.line, what))
        };
        self.found.fapu = Fapu {
            irisd0: unit("IRISD0")?,
            es0: unit("ES0")?,
            ens0: unit("ENS0")?,
            mns0: unit("MNS0")?,
            mw0: unit("MW0")?,
        };
        Ok(())
    }

    fn part(&mut self, name: &str, element: &Element) -> Result<(), ReadError> {
        let Some(source) = self.found.sources.last_mut() else {
            let what = format!("<{name}> found outside of an <entity>");
            return Err(ReadError::malformed(&element.line, what));
        };
        if name == "mesh" {
            source.meshes.push(element.word("file"));
        } else {
            let part = (element.word("item"), element.word("submesh"));
            source.parts.push(part);
        }
        Ok(())
    }

    fn point(&mut self, element: &Element) -> Result<(), ReadError> {
        let name = element.word("name");
        let parts = name.split_once('.');
        let point =
            parts.and_then(|(group, number)| Some((group.parse().ok()?, number.parse().ok()?)));
        let Some(point) = point else {
            let shown = shortened(&name);
            let what = format!("feature point \"{shown}\" found, expected one such as 2.10");
            return Err(ReadError::malformed(&element.line, what));
        };
        self.found.points.push(FeaturePoint {
            point,
            mesh: element.word("affects"),
            vertex: element.whole("index")?,
            zone: Vec::new(),
            influences: Vec::new(),
        });
        Ok(())
    }

    fn influence(&mut self, element: &Element) -> Result<(), ReadError> {
        let index: usize = element.whole("fap")?;
        let Some(point) = self.found.points.last_mut() else {
            let what = "<influence> found outside of an <fdp>";
            return Err(ReadError::malformed(&element.line, what));
        };
        if index >= FAP_COUNT {
            let what = format!("fap {index} found, 0 to {} expected", FAP_COUNT - 1);
            return Err(ReadError::malformed(&element.line, what));
        }
        point.influences.push(FapInfluence {
            fap: index + 1,
            kind: element.word("type"),
            weight: element.number("weight")?,
        });
        Ok(())
    }

    /// Reads the text between tags; only zones have some.
    fn words(&mut self, words: &str, offset: usize) -> Result<(), ReadError> {
        if self.open.last().is_none_or(|name| name != "indices") {
            return Ok(());
        }
        let line = self.place.line(offset);
        self.count(&line, words.split_whitespace().count() as u64)?;
        let Some(point) = self.found.points.last_mut() else {
            let what = "<indices> found outside of an <fdp>";
            return Err(ReadError::malformed(line, what));
        };
        for word in words.split_whitespace() {
            let Ok(index) = word.parse::<u32>() else {
                let shown = shortened(word);
                let what = format!("vertex \"{shown}\" found, a whole number expected");
                return Err(ReadError::malformed(line, what));
            };
            point.zone.push(index);
        }
        Ok(())
    }

    fn attributes(
        &self,
        start: &BytesStart<'_>,
        line: &str,
    ) -> Result<Vec<(String, String)>, ReadError> {
        let mut list: Vec<(String, String)> = Vec::new();
        // The parser's check for duplicates is quadratic; here the number of attributes is bounded.
        for attribute in start.attributes().with_checks(false) {
            let broken =
                |e: &dyn Display| ReadError::malformed(line, format!("malformed XML: {e}"));
            let attribute = attribute.map_err(|e| broken(&e))?;
            let key = attribute.key.into_inner();
            let value = attribute.normalized_value(XmlVersion::Implicit1_0);
            let value = value.map_err(|e| broken(&e))?;
            if list.iter().any(|(known, _)| known == key) {
                return Err(broken(&"an attribute is given twice"));
            }
            if list.len() == MAX_ATTRIBUTES {
                return Err(broken(&"an element has too many attributes"));
            }
            list.push((key.to_owned(), value.into_owned()));
        }
        Ok(list)
    }

    fn count(&mut self, line: &str, more: u64) -> Result<(), ReadError> {
        self.values += more;
        Limits::check(
            line,
            "elements and vertices",
            self.values,
            self.limits.elements,
        )
    }

    fn refused(&mut self, offset: usize, what: &str, mend: &str) -> ReadError {
        ReadError::Unsupported {
            at: self.place.line(offset),
            what: what.to_owned(),
            mend: mend.to_owned(),
        }
    }

    fn finish(mut self) -> Result<Parsed<FdpFile>, ReadError> {
        if !self.seen.root || !self.open.is_empty() {
            let what = "the file ends before </xfdp>; it is truncated";
            return Err(ReadError::malformed(self.place.line(usize::MAX), what));
        }
        if !self.seen.fapu {
            let what = "the file has no <fapu>; the units of the face are 0";
            self.warnings.push(Warning::new("head", what));
        }
        Ok(Parsed {
            value: self.found,
            warnings: self.warnings,
        })
    }
}

/// Content of a start tag.
struct Element {
    attributes: Vec<(String, String)>,
    line: String,
}

impl Element {
    /// Returns the text of an attribute; empty if it is absent.
    fn word(&self, name: &str) -> String {
        let found = self.attributes.iter().find(|(key, _)| key == name);
        found.map(|(_, value)| value.clone()).unwrap_or_default()
    }

    fn whole<T: FromStr>(&self, name: &str) -> Result<T, ReadError> {
        let value = self.word(name).trim().parse::<T>().ok();
        value.ok_or_else(|| self.no_number(name))
    }

    fn number(&self, name: &str) -> Result<f32, ReadError> {
        let value = self.word(name).trim().parse::<f32>().ok();
        let value = value.filter(|v| v.abs() <= LARGEST);
        value.ok_or_else(|| self.no_number(name))
    }

    fn no_number(&self, name: &str) -> ReadError {
        let shown = shortened(&self.word(name));
        let what = format!("{name}=\"{shown}\" found, a number expected");
        ReadError::malformed(&self.line, what)
    }

    fn vector(&self, names: [&str; 3]) -> Result<Vec3, ReadError> {
        let [x, y, z] = names.map(|name| self.number(name));
        Ok(Vec3::new(x?, y?, z?))
    }
}

/// Conversion of ascending byte offsets to line numbers.
struct Place<'a> {
    bytes: &'a [u8],
    offset: usize,
    line: usize,
}

impl<'a> Place<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        Self {
            bytes,
            offset: 0,
            line: 1,
        }
    }

    fn line(&mut self, offset: usize) -> String {
        let offset = offset.clamp(self.offset, self.bytes.len());
        let passed = &self.bytes[self.offset..offset];
        self.line += passed.iter().filter(|b| **b == b'\n').count();
        self.offset = offset;
        format!("line {}", self.line)
    }
}

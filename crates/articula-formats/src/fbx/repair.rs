//! Repair of what the crate `fbx-rs` refuses whole files for, though other readers only skip it.
//!
//! Bytes change, lengths never do. The kinds, each told once with its number:
//!
//! 1. binary data in a property: the record is renamed, the data then read as text
//! 2. text of a property beyond ASCII: `_` in its place; names of objects stay
//! 3. connections of kinds besides `OO` and `OP`: the record is renamed, which leaves it out
//! 4. connections to no object: left out
//! 5. further parents of a model: left out
//! 6. meshes without points or polygons: the record is renamed
//!
//! On the way the walk collects facts that the crate does not tell.

use super::kinds::Kinds;
use super::records::{self, Level, Place, Record, Value};
use super::walk::walk;
use std::borrow::Cow;
use std::collections::{HashMap, HashSet};
use std::ops::Range;

/// First version with numbers of objects; before, their names stand in the connections.
const NUMBERED: u32 = 7000;

/// First version whose objects stand in `Objects`.
const OBJECTS: u32 = 6000;

/// What is said of binary data.
const BLOB: &str = "a property holds binary data, which is not read";

/// A file that is ready to be read, and facts of it.
#[derive(Debug)]
pub(super) struct Repaired<'b> {
    pub(super) bytes: Cow<'b, [u8]>,
    /// Where the bytes follow no rule.
    pub(super) odd: Option<Place>,
    /// Metres per unit, if the file states them.
    pub(super) unit_metres: Option<f64>,
    /// Models with a transform of their geometry alone.
    pub(super) geometric: HashSet<i64>,
}

/// Repairs a file of at most `depth` levels and tells what was repaired.
pub(super) fn repair<'b>(bytes: &'b [u8], depth: usize, kinds: &mut Kinds) -> Repaired<'b> {
    let version = records::version(bytes);
    let mut search = Search {
        bytes,
        kinds,
        is_numbered: version.is_none_or(|v| v >= NUMBERED),
        edits: Vec::new(),
        objects: HashMap::new(),
        connections: Vec::new(),
        mesh: None,
        model: None,
        unit_metres: None,
        geometric: HashSet::new(),
    };
    let odd = walk(bytes, depth, &mut |record| search.visit(record));
    search.close_mesh();
    if version.is_none_or(|v| v >= OBJECTS) && !search.objects.is_empty() {
        search.connect();
    }
    let (edits, unit_metres, geometric) = (search.edits, search.unit_metres, search.geometric);
    Repaired {
        bytes: edited(bytes, &edits),
        odd,
        unit_metres,
        geometric,
    }
}

/// A change of bytes.
#[derive(Debug)]
enum Edit {
    Byte(usize, u8),
    /// Bytes that are no ASCII become `_`.
    Plain(Range<usize>),
}

fn edited<'b>(bytes: &'b [u8], edits: &[Edit]) -> Cow<'b, [u8]> {
    if edits.is_empty() {
        return Cow::Borrowed(bytes);
    }
    let mut own = bytes.to_vec();
    for edit in edits {
        match edit {
            Edit::Byte(at, byte) => own[*at] = *byte,
            Edit::Plain(range) => own[range.clone()]
                .iter_mut()
                .filter(|b| !is_plain(**b))
                .for_each(|b| *b = b'_'),
        }
    }
    Cow::Owned(own)
}

fn is_plain(byte: u8) -> bool {
    byte > 0 && byte < 128
}

/// What connections name: a number, or in old files a name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Id<'b> {
    Number(i64),
    Name(&'b [u8]),
}

impl<'b> Id<'b> {
    fn of(value: Option<&Value>, bytes: &'b [u8], is_numbered: bool) -> Option<Self> {
        match value? {
            Value::Integer(number) if is_numbered => Some(Self::Number(*number)),
            text @ Value::Text(_) if !is_numbered => text.text(bytes).map(Self::Name),
            _ => None,
        }
    }

    /// Whether it is the scene itself.
    fn is_scene(self) -> bool {
        match self {
            Self::Number(number) => number == 0,
            Self::Name(name) => matches!(name, b"Model::Scene" | b"Scene\0\x01Model"),
        }
    }
}

struct Connection<'b> {
    /// First byte of the record's name.
    name: usize,
    is_kept_kind: bool,
    of_objects: bool,
    ends: Option<[Id<'b>; 2]>,
}

/// A mesh whose records are being visited.
struct OpenMesh {
    /// First byte of the name of the record that goes if there are no polygons.
    name: Option<usize>,
    has_points: bool,
    has_polygons: bool,
}

struct Search<'b, 'k> {
    bytes: &'b [u8],
    kinds: &'k mut Kinds,
    is_numbered: bool,
    edits: Vec<Edit>,
    /// The objects, and whether each is a model.
    objects: HashMap<Id<'b>, bool>,
    connections: Vec<Connection<'b>>,
    mesh: Option<OpenMesh>,
    /// Number of the model whose records are being visited.
    model: Option<i64>,
    unit_metres: Option<f64>,
    geometric: HashSet<i64>,
}

impl Search<'_, '_> {
    fn visit(&mut self, record: &Record<'_>) {
        match record.level {
            Level::Object => self.object(record),
            Level::Part => self.part(record),
            Level::Connection => self.connection(record),
            Level::Entry { of_settings } => self.entry(record, of_settings),
            Level::Blob => {
                self.kinds.note(|| "properties".to_owned(), BLOB);
                self.edits.push(Edit::Byte(record.name.end - 1, b'_'));
            }
            _ => {}
        }
    }

    fn object(&mut self, record: &Record<'_>) {
        self.close_mesh();
        let name = &self.bytes[record.name.clone()];
        let class = record.values.get(if self.is_numbered { 2 } else { 1 });
        let class = class.and_then(|v| v.text(self.bytes)).unwrap_or_default();
        let class = class.strip_prefix(b"Fbx").unwrap_or(class);
        let id = Id::of(record.values.first(), self.bytes, self.is_numbered);
        let is_model = name == b"Model";
        if let Some(id) = id {
            self.objects.entry(id).or_insert(is_model);
        }
        self.model = match id {
            Some(Id::Number(number)) if is_model => Some(number),
            _ => None,
        };
        let is_mesh = name == b"Geometry" && class == b"Mesh";
        self.mesh = (is_mesh || is_model && !self.is_numbered).then(|| OpenMesh {
            name: is_mesh.then_some(record.name.start),
            has_points: false,
            has_polygons: false,
        });
        if class == b"LodGroup" {
            let what = "levels of detail of the file are all read, as meshes beside each other";
            self.kinds.note(|| "objects".to_owned(), what);
        }
    }

    fn part(&mut self, record: &Record<'_>) {
        let is_filled = match record.values {
            [Value::List(count)] => *count > 0,
            values => !values.is_empty(),
        };
        let is_additive = record.values.first().and_then(|v| v.text(self.bytes));
        match &self.bytes[record.name.clone()] {
            b"Mode" if is_additive == Some(b"Additive") => {
                let what = "a cluster adds to the others of its skin; read as a part of a sum of 1";
                self.kinds.note(|| "skins".to_owned(), what);
            }
            b"Vertices" => {
                if let Some(mesh) = &mut self.mesh {
                    mesh.has_points = is_filled;
                    mesh.name.get_or_insert(record.name.start);
                }
            }
            b"PolygonVertexIndex" => {
                if let Some(mesh) = &mut self.mesh {
                    mesh.has_polygons = is_filled;
                }
            }
            _ => {}
        }
    }

    fn close_mesh(&mut self) {
        let Some(mesh) = self.mesh.take() else {
            return;
        };
        if let (Some(name), false) = (mesh.name, mesh.has_points && mesh.has_polygons) {
            let what = "a mesh has no points or no polygons; left out";
            self.kinds.note(|| "meshes".to_owned(), what);
            self.edits.push(Edit::Byte(name, b'X'));
        }
    }

    fn entry(&mut self, record: &Record<'_>, of_settings: bool) {
        let name = record.values.first().and_then(|v| v.text(self.bytes));
        let name = name.unwrap_or_default();
        let at = || format!("property \"{}\"", String::from_utf8_lossy(name));
        for value in record.values {
            let range = match value {
                Value::Text(range) => range,
                Value::Raw { tag, bytes } => {
                    self.kinds.note(at, BLOB);
                    self.edits.push(Edit::Byte(*tag, b'S'));
                    bytes
                }
                _ => continue,
            };
            if self.bytes[range.clone()].iter().all(|b| is_plain(*b)) {
                continue;
            }
            if matches!(value, Value::Text(_)) {
                let what = "a property has bytes beyond ASCII, read as _";
                self.kinds.note(at, what);
            }
            self.edits.push(Edit::Plain(range.clone()));
        }
        let numbers = || record.values.iter().filter_map(Value::number);
        if of_settings && name == b"UnitScaleFactor" {
            let centimetres = numbers().next_back();
            let metres = centimetres.map(|c| c * 0.01);
            self.unit_metres = metres.filter(|m| m.is_finite() && *m > 0.0);
        }
        if let (Some(model), Some(kind)) = (self.model, name.strip_prefix(b"Geometric")) {
            let usual = if kind == b"Scaling" { 1.0 } else { 0.0 };
            if numbers().any(|n| n != usual) {
                self.geometric.insert(model);
            }
        }
    }

    fn connection(&mut self, record: &Record<'_>) {
        let kind = record.values.first().and_then(|v| v.text(self.bytes));
        let id = |at| Id::of(record.values.get(at), self.bytes, self.is_numbered);
        self.connections.push(Connection {
            name: record.name.start,
            is_kept_kind: matches!(kind, Some(b"OO" | b"OP")),
            of_objects: kind == Some(b"OO"),
            ends: id(1).zip(id(2)).map(|(from, to)| [from, to]),
        });
    }

    /// Leaves out connections of other kinds, to no object, and to further parents.
    fn connect(&mut self) {
        let mut with_parent = HashSet::new();
        for connection in &self.connections {
            let is_model = |id: &Id<'_>| self.objects.get(id) == Some(&true);
            let is_known = |id: &Id<'_>| self.objects.contains_key(id);
            let what = match &connection.ends {
                _ if !connection.is_kept_kind => {
                    "a connection between properties is not read, as of HumanIK"
                }
                Some([from, to]) if is_known(from) && (to.is_scene() || is_known(to)) => {
                    let places =
                        connection.of_objects && is_model(from) && (to.is_scene() || is_model(to));
                    if !places || with_parent.insert(*from) {
                        continue;
                    }
                    "a model has two parents; only the first is used"
                }
                _ => "a connection leads to no object; left out",
            };
            self.kinds.note(|| "connections".to_owned(), what);
            self.edits.push(Edit::Byte(connection.name, b'D'));
        }
    }
}

//! Small FBX files, written in both encodings from one tree.

/// A record.
#[derive(Debug, Clone, Default)]
pub(super) struct Record {
    pub(super) name: String,
    pub(super) values: Vec<Value>,
    pub(super) records: Vec<Record>,
}

#[derive(Debug, Clone)]
pub(super) enum Value {
    Text(Vec<u8>),
    /// Name and class of an object.
    Name(String, &'static str),
    Raw(Vec<u8>),
    Long(i64),
    Real(f64),
    Ints(Vec<i32>),
    Longs(Vec<i64>),
    Floats(Vec<f32>),
    Reals(Vec<f64>),
}

pub(super) fn text(text: &str) -> Value {
    Value::Text(text.as_bytes().to_vec())
}

pub(super) fn record(name: &str, values: Vec<Value>, records: Vec<Record>) -> Record {
    Record {
        name: name.to_owned(),
        values,
        records,
    }
}

/// A property of an object.
pub(super) fn property(name: &str, kind: &str, values: &[f64]) -> Record {
    let head = [name, kind, "", "A"].map(text).into_iter();
    let values = head.chain(values.iter().map(|v| Value::Real(*v)));
    record("P", values.collect(), vec![])
}

fn object(kind: &str, id: i64, name: &str, class: &'static str, subclass: &str) -> Record {
    let name = Value::Name(name.to_owned(), class);
    record(kind, vec![Value::Long(id), name, text(subclass)], vec![])
}

fn with(mut object: Record, records: Vec<Record>) -> Record {
    object.records.extend(records);
    object
}

fn properties(list: Vec<Record>) -> Record {
    record("Properties70", vec![], list)
}

/// A connection of two objects.
pub(super) fn connection(kind: &str, from: i64, to: i64, property: Option<&str>) -> Record {
    let mut values = vec![text(kind), Value::Long(from), Value::Long(to)];
    values.extend(property.map(text));
    record("C", values, vec![])
}

/// Ticks in a second.
pub(super) const SECOND: i64 = 46_186_158_000;

fn cluster(id: i64, points: &[i32], bound: [f64; 3]) -> Record {
    let matrix = |x: f64, y: f64, z: f64| {
        let mut all = [0.0; 16];
        [all[0], all[5], all[10], all[15]] = [1.0; 4];
        [all[12], all[13], all[14]] = [x, y, z];
        Value::Reals(all.to_vec())
    };
    let [x, y, z] = bound;
    with(
        object("Deformer", id, "", "SubDeformer", "Cluster"),
        vec![
            record("Indexes", vec![Value::Ints(points.to_vec())], vec![]),
            record(
                "Weights",
                vec![Value::Reals(vec![1.0; points.len()])],
                vec![],
            ),
            record("Transform", vec![matrix(-x, -y, -z)], vec![]),
            record("TransformLink", vec![matrix(x, y, z)], vec![]),
        ],
    )
}

/// The connections of the figure.
fn connections() -> Vec<Record> {
    vec![
        connection("OO", 1, 0, None),
        connection("OO", 2, 0, None),
        connection("OO", 3, 2, None),
        connection("OO", 4, 2, None),
        connection("OO", 5, 3, None),
        connection("OO", 10, 1, None),
        connection("OO", 20, 10, None),
        connection("OO", 21, 20, None),
        connection("OO", 22, 20, None),
        connection("OO", 2, 21, None),
        connection("OO", 3, 22, None),
        connection("OO", 31, 30, None),
        connection("OO", 32, 31, None),
        connection("OP", 32, 3, Some("Lcl Rotation")),
        connection("OP", 33, 32, Some("d|Z")),
    ]
}

/// Two bones with a skin over two triangles and a take of a second that turns the upper one; the stored pose is
/// 10 cm beside the bound one.
pub(super) fn figure() -> Vec<Record> {
    let one = |name: &str, value: Value| record(name, vec![value], vec![]);
    let geometry = with(
        object("Geometry", 10, "", "Geometry", "Mesh"),
        vec![
            one(
                "Vertices",
                Value::Reals(vec![0., 0., 0., 10., 0., 0., 10., 50., 0., 0., 50., 0.]),
            ),
            one("PolygonVertexIndex", Value::Ints(vec![0, 1, 2, -4])),
        ],
    );
    let curve = with(
        object("AnimationCurve", 33, "", "AnimCurve", ""),
        vec![
            one("KeyTime", Value::Longs(vec![0, SECOND])),
            one("KeyValueFloat", Value::Floats(vec![0.0, 90.0])),
            one("KeyAttrFlags", Value::Ints(vec![4])),
            one("KeyAttrDataFloat", Value::Floats(vec![0.0; 4])),
            one("KeyAttrRefCount", Value::Ints(vec![2])),
        ],
    );
    let place = |x: f64, y: f64| {
        let kind = "Lcl Translation";
        vec![properties(vec![property(kind, kind, &[x, y, 0.0])])]
    };
    let time = |name: &str, ticks: i64| {
        let head = [name, "KTime", "Time", ""].map(text).into_iter();
        record("P", head.chain([Value::Long(ticks)]).collect(), vec![])
    };
    let range = properties(vec![time("LocalStop", SECOND), time("LocalStart", 0)]);
    let objects = vec![
        geometry,
        object("Model", 1, "Skin", "Model", "Mesh"),
        with(
            object("Model", 2, "Hips", "Model", "LimbNode"),
            place(10.0, 0.0),
        ),
        with(
            object("Model", 3, "Spine", "Model", "LimbNode"),
            place(0.0, 50.0),
        ),
        object("NodeAttribute", 4, "", "NodeAttribute", "LimbNode"),
        object("NodeAttribute", 5, "", "NodeAttribute", "LimbNode"),
        object("Deformer", 20, "", "Deformer", "Skin"),
        cluster(21, &[0, 1], [0.0; 3]),
        cluster(22, &[2, 3], [0.0, 50.0, 0.0]),
        with(
            object("AnimationStack", 30, "turn", "AnimStack", ""),
            vec![range],
        ),
        object("AnimationLayer", 31, "Base", "AnimLayer", ""),
        object("AnimationCurveNode", 32, "R", "AnimCurveNode", ""),
        curve,
    ];
    let settings = vec![
        property("UnitScaleFactor", "double", &[1.0]),
        record(
            "P",
            vec![
                text("TimeMode"),
                text("enum"),
                text(""),
                text(""),
                Value::Long(6),
            ],
            vec![],
        ),
    ];
    vec![
        record("GlobalSettings", vec![], vec![properties(settings)]),
        record("Objects", vec![], objects),
        record("Connections", vec![], connections()),
    ]
}

/// The record of a path of names, from the top.
pub(super) fn at<'r>(records: &'r mut [Record], path: &[&str]) -> &'r mut Record {
    let found = records.iter_mut().find(|r| r.name == path[0]).unwrap();
    match path {
        [_] => found,
        [_, rest @ ..] => at(&mut found.records, rest),
        [] => unreachable!("a path has a name"),
    }
}

/// The bytes of a binary file.
pub(super) fn binary(version: u32, records: &[Record]) -> Vec<u8> {
    let mut bytes = b"Kaydara FBX Binary  \0\x1a\0".to_vec();
    bytes.extend(version.to_le_bytes());
    let width = if version < 7500 { 4 } else { 8 };
    for record in records {
        write(&mut bytes, record, width);
    }
    bytes.resize(bytes.len() + 3 * width + 1, 0);
    bytes
}

fn write(bytes: &mut Vec<u8>, record: &Record, width: usize) {
    let start = bytes.len();
    let number = |bytes: &mut Vec<u8>, value: usize| {
        bytes.extend(&(value as u64).to_le_bytes()[..width]);
    };
    number(bytes, 0);
    number(bytes, record.values.len());
    number(bytes, 0);
    bytes.push(record.name.len() as u8);
    bytes.extend(record.name.as_bytes());
    let first = bytes.len();
    record
        .values
        .iter()
        .for_each(|value| write_value(bytes, value));
    let length = bytes.len() - first;
    if !record.records.is_empty() {
        record
            .records
            .iter()
            .for_each(|inner| write(bytes, inner, width));
        bytes.resize(bytes.len() + 3 * width + 1, 0);
    }
    let end = bytes.len();
    bytes[start..start + width].copy_from_slice(&(end as u64).to_le_bytes()[..width]);
    let place = start + 2 * width;
    bytes[place..place + width].copy_from_slice(&(length as u64).to_le_bytes()[..width]);
}

fn write_value(bytes: &mut Vec<u8>, value: &Value) {
    let mut list = |tag: u8, count: usize, data: Vec<u8>| {
        bytes.push(tag);
        for number in [count, 0, data.len()] {
            bytes.extend((number as u32).to_le_bytes());
        }
        bytes.extend(data);
    };
    match value {
        Value::Ints(v) => list(
            b'i',
            v.len(),
            v.iter().flat_map(|x| x.to_le_bytes()).collect(),
        ),
        Value::Longs(v) => list(
            b'l',
            v.len(),
            v.iter().flat_map(|x| x.to_le_bytes()).collect(),
        ),
        Value::Floats(v) => list(
            b'f',
            v.len(),
            v.iter().flat_map(|x| x.to_le_bytes()).collect(),
        ),
        Value::Reals(v) => list(
            b'd',
            v.len(),
            v.iter().flat_map(|x| x.to_le_bytes()).collect(),
        ),
        Value::Long(v) => {
            bytes.push(b'L');
            bytes.extend(v.to_le_bytes());
        }
        Value::Real(v) => {
            bytes.push(b'D');
            bytes.extend(v.to_le_bytes());
        }
        Value::Text(_) | Value::Name(..) | Value::Raw(_) => {
            let (tag, data) = match value {
                Value::Raw(data) => (b'R', data.clone()),
                Value::Text(data) => (b'S', data.clone()),
                Value::Name(name, class) => (b'S', format!("{name}\0\u{1}{class}").into_bytes()),
                _ => unreachable!("matched above"),
            };
            bytes.push(tag);
            bytes.extend((data.len() as u32).to_le_bytes());
            bytes.extend(data);
        }
    }
}

/// The bytes of a text file.
pub(super) fn ascii(records: &[Record]) -> Vec<u8> {
    let mut bytes = b"; FBX 7.4.0 project file\n".to_vec();
    records
        .iter()
        .for_each(|record| write_text(&mut bytes, record, 0));
    bytes
}

fn write_text(bytes: &mut Vec<u8>, record: &Record, depth: usize) {
    let indent = "\t".repeat(depth);
    bytes.extend(format!("{indent}{}: ", record.name).bytes());
    for (index, value) in record.values.iter().enumerate() {
        if index > 0 {
            bytes.push(b',');
        }
        let list = |all: Vec<String>| format!("*{} {{\na: {}\n}}", all.len(), all.join(","));
        match value {
            Value::Text(text) | Value::Raw(text) => {
                bytes.push(b'"');
                bytes.extend(text);
                bytes.push(b'"');
            }
            Value::Name(name, class) => bytes.extend(format!("\"{class}::{name}\"").bytes()),
            Value::Long(v) => bytes.extend(v.to_string().bytes()),
            Value::Real(v) => bytes.extend(v.to_string().bytes()),
            Value::Ints(v) => bytes.extend(list(v.iter().map(i32::to_string).collect()).bytes()),
            Value::Longs(v) => bytes.extend(list(v.iter().map(i64::to_string).collect()).bytes()),
            Value::Floats(v) => bytes.extend(list(v.iter().map(f32::to_string).collect()).bytes()),
            Value::Reals(v) => bytes.extend(list(v.iter().map(f64::to_string).collect()).bytes()),
        }
    }
    let is_block = record.values.iter().all(|v| {
        matches!(
            v,
            Value::Text(_) | Value::Name(..) | Value::Raw(_) | Value::Long(_) | Value::Real(_)
        )
    });
    let opens = is_block && (!record.records.is_empty() || depth < 2 && record.name != "C");
    if opens {
        bytes.extend(b" {\n");
        record
            .records
            .iter()
            .for_each(|inner| write_text(bytes, inner, depth + 1));
        bytes.extend(format!("{indent}}}").bytes());
    }
    bytes.push(b'\n');
}

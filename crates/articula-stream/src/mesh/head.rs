//! The head of a stream: objects, levels and the table of chunks.

use super::codec::{Grid, Layout, MorphLayout, Scale};
use super::hash::{Hash, hash_of};
use crate::coding::Coding;
use crate::unit::{Field, Marker, Meaning, Unit, bits_of};
use crate::{StreamError, StreamLimits};
use articula_core::{ByteReader, LevelRow, LevelTable, SurfaceError, push_varint};
use glam::{Vec2, Vec3};
use std::ops::Range;

const MAGIC: &[u8; 4] = b"AMSH";
const VERSION: u8 = 2;
/// Version in which levels were counted from the coarsest, 0.
const OLD_VERSION: u8 = 1;
/// Size of the fixed part at the start of the head, its length field included.
const FIXED: usize = 12;
/// Size of a chunk's entry in the table: length and hash.
const ENTRY: usize = 12;
const MAX_LEVELS: usize = 256;
const MAX_REGIONS: usize = 256;
const MAX_NAME: usize = 256;
const MAX_OBJECTS: usize = 1 << 16;
const MAX_MORPHS: usize = 1 << 16;

/// A part of the character with its own chunks.
#[derive(Debug, Clone, PartialEq)]
pub struct StreamObject {
    /// Index of the mesh in the character.
    pub mesh: u32,
    /// Index of the primitive in the mesh.
    pub primitive: u32,
    /// Region of the primitive; 0 if there is only one.
    pub region: u32,
    /// Kinds of values and their number of bits.
    pub layout: Layout,
    /// Scale from whole numbers to metres and texture coordinates.
    pub scale: Scale,
}

/// Parsed head of a stream, sufficient to request any chunk.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshStream {
    /// Number, in the whole character, of the finest level in this stream; 0 is the original. 0 for
    /// streams of version 1, which do not store it.
    pub finest_level: usize,
    /// Levels in this stream, finest first.
    pub levels: LevelTable,
    /// Objects in this stream.
    pub objects: Vec<StreamObject>,
    /// Encoded record of each object, part of the hashed data of its chunks.
    pub(super) records: Vec<Vec<u8>>,
    /// Length and hash of each chunk, by level (coarsest first), then by object.
    pub(super) entries: Vec<(u32, Hash)>,
    /// Size of the head in bytes.
    pub head_bytes: usize,
    counts: Counts,
}

/// Numbering of levels in the hashes of a stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Counts {
    /// From the original, 0.
    FromFinest,
    /// From the coarsest level of the whole character, 0, as in version 1; the value is the number
    /// of the coarsest level in the stream.
    FromCoarsest(usize),
}

impl MeshStream {
    /// Returns the size of the head in bytes; needs the first 12 bytes of the stream.
    ///
    /// # Errors
    /// [`StreamError::Malformed`] if this is not a stream, [`StreamError::Unsupported`] for another
    /// version.
    pub fn head_length(bytes: &[u8]) -> Result<usize, StreamError> {
        let mut r = ByteReader::new(bytes);
        if r.take::<4>()? != *MAGIC {
            return Err(StreamError::malformed(
                "byte 0",
                "not a mesh stream: it does not begin with \"AMSH\"",
            ));
        }
        let [version, ..] = r.take::<4>()?;
        if version != VERSION && version != OLD_VERSION {
            return Err(StreamError::Unsupported {
                at: "byte 4".into(),
                what: format!("version {version} of the mesh stream"),
                mend: "write it again with this version of Articula".into(),
            });
        }
        let length = r.u32()? as usize;
        if length < FIXED {
            return Err(r
                .bad(format!("a head of {length} bytes is too short"))
                .into());
        }
        Ok(length)
    }

    /// Parses the head of a stream; `bytes` must contain at least the whole head.
    ///
    /// # Errors
    /// [`StreamError::Malformed`] with the byte offset, [`StreamError::Unsupported`] for another
    /// version, [`StreamError::LimitExceeded`].
    pub fn open(bytes: &[u8], limits: &StreamLimits) -> Result<Self, StreamError> {
        let head_bytes = Self::head_length(bytes)?;
        StreamLimits::check("byte 8", "bytes", head_bytes as u64, limits.bytes)?;
        let Some(head) = bytes.get(..head_bytes) else {
            let what = format!("unexpected end, expected a head of {head_bytes} bytes");
            return Err(StreamError::malformed(
                format!("byte {}", bytes.len()),
                what,
            ));
        };
        let mut r = ByteReader::new(head);
        r.take::<FIXED>()?;
        let is_old = head[MAGIC.len()] == OLD_VERSION;
        let (number, levels) = read_levels(&mut r, is_old)?;
        let count = count_of(&mut r, "objects", MAX_OBJECTS)?;
        let mut objects = Vec::new();
        let mut records = Vec::new();
        for _ in 0..count {
            let start = r.at();
            objects.push(read_object(&mut r)?);
            records.push(head[start..r.at()].to_vec());
        }
        let chunks = levels.levels.len() * count;
        if r.left() as u64 != (chunks * ENTRY) as u64 {
            let what = format!(
                "{} bytes do not fit the entries of {chunks} chunks",
                r.left()
            );
            return Err(r.bad(what).into());
        }
        let mut entries = Vec::with_capacity(chunks);
        for _ in 0..chunks {
            entries.push((r.u32()?, r.take()?));
        }
        r.end()?;
        let all = entries.iter().map(|e| u64::from(e.0)).sum::<u64>();
        // Also ensures that chunk offsets fit in 32 bits.
        StreamLimits::check(
            "byte 8",
            "bytes",
            head_bytes as u64 + all,
            limits.bytes.min(u64::from(u32::MAX)),
        )?;
        let (finest_level, counts) = match is_old {
            true => (0, Counts::FromCoarsest(number)),
            false => (number, Counts::FromFinest),
        };
        Ok(Self {
            finest_level,
            levels,
            objects,
            records,
            entries,
            head_bytes,
            counts,
        })
    }

    /// Returns the byte range of a chunk, by level of this stream (0 is its finest) and object;
    /// empty if the chunk was cut out, `None` if there is no such level or object.
    pub fn chunk(&self, level: usize, object: usize) -> Option<Range<usize>> {
        if level >= self.levels.levels.len() || object >= self.objects.len() {
            return None;
        }
        let at = self.place(level, object);
        let before = self.entries[..at].iter().map(|e| e.0 as usize);
        let start = self.head_bytes + before.sum::<usize>();
        Some(start..start + self.entries[at].0 as usize)
    }

    /// Level, object and bytes of all chunks, in the order of the bytes.
    pub(super) fn chunks(&self) -> impl Iterator<Item = (usize, usize, Range<u64>)> {
        let levels = (0..self.levels.levels.len()).rev();
        let objects = self.objects.len();
        let places = levels.flat_map(move |level| (0..objects).map(move |o| (level, o)));
        let mut at = self.head_bytes as u64;
        places
            .zip(&self.entries)
            .map(move |((level, object), entry)| {
                let start = at;
                at += u64::from(entry.0);
                (level, object, start..at)
            })
    }

    /// Index of a chunk in the order of the bytes, which begin with the coarsest level.
    fn place(&self, level: usize, object: usize) -> usize {
        (self.levels.levels.len() - 1 - level) * self.objects.len() + object
    }

    /// Returns whether the table's length and hash match these bytes.
    pub(super) fn names(&self, level: usize, object: usize, chunk: &[u8]) -> bool {
        let coarsest = self.levels.levels.len() - 1;
        let number = match self.counts {
            Counts::FromFinest => self.finest_level + level,
            Counts::FromCoarsest(first) => first + coarsest - level,
        };
        let record = &self.records[object];
        let entry = &self.entries[self.place(level, object)];
        hash_of(number, level == coarsest, record, chunk) == entry.1
    }

    /// Number of a chunk in the map, by its place: the stream, the head, and each level before its
    /// chunks.
    fn unit_number(&self, place: usize) -> u32 {
        (2 + place / self.objects.len() + 1 + place) as u32
    }

    /// Returns the map of the stream: a unit for each level, coarsest first as in the bytes, with a
    /// unit for each object's chunk, marked `level` (in the whole character), `object`, `mesh` and
    /// `region`. A cut that removes a chunk writes 0 to its length field in the head; the fields
    /// are in the order of the chunks.
    pub fn unit(&self) -> Unit {
        let table = self.head_bytes - ENTRY * self.entries.len();
        let field = |i: usize| Field {
            name: "length".into(),
            bits: bits_of(table + ENTRY * i..table + ENTRY * i + 4),
            value: u64::from(self.entries[i].0),
            coding: Coding::LittleEndian,
            meaning: Meaning::BytesOf(self.unit_number(i)),
        };
        let head = Unit {
            fields: (0..self.entries.len()).map(field).collect(),
            ..Unit::of_bytes("head", 0..self.head_bytes)
        };
        let mut at = self.head_bytes;
        let mut children = vec![head];
        for level in (0..self.levels.levels.len()).rev() {
            let start = at;
            let number = (self.finest_level + level) as u32;
            let mut chunks = Vec::with_capacity(self.objects.len());
            for (o, object) in self.objects.iter().enumerate() {
                let end = at + self.entries[self.place(level, o)].0 as usize;
                let marks = [
                    ("level", number),
                    ("object", o as u32),
                    ("mesh", object.mesh),
                    ("region", object.region),
                ];
                chunks.push(Unit {
                    markers: marks.map(|(scheme, value)| marker(scheme, value)).into(),
                    ..Unit::of_bytes("chunk", at..end)
                });
                at = end;
            }
            children.push(Unit {
                markers: vec![marker("level", number)],
                children: chunks,
                ..Unit::of_bytes("level", start..at)
            });
        }
        Unit {
            children,
            ..Unit::of_bytes("mesh stream", 0..at)
        }
    }
}

fn marker(scheme: &'static str, value: u32) -> Marker {
    Marker {
        scheme: scheme.into(),
        value,
    }
}

/// Writes a head; `entries` are those of all chunks, in order.
pub(super) fn write(
    finest_level: usize,
    levels: &LevelTable,
    records: &[Vec<u8>],
    entries: &[(u32, Hash)],
) -> Vec<u8> {
    let mut out = MAGIC.to_vec();
    out.extend([VERSION, 0, 0, 0]);
    out.extend([0; 4]);
    push_varint(&mut out, finest_level as u64);
    push_varint(&mut out, levels.levels.len() as u64);
    // Coarsest first, like the chunks.
    for level in levels.levels.iter().rev() {
        push_varint(&mut out, level.triangles);
        push_varint(&mut out, level.vertices);
        for error in [&level.rest, &level.motion] {
            for metres in [
                error.max_metres,
                error.p99_metres,
                error.p95_metres,
                error.mean_metres,
            ] {
                out.extend(metres.to_le_bytes());
            }
        }
    }
    push_varint(&mut out, levels.mixable_to as u64);
    push_varint(&mut out, levels.regions.len() as u64);
    for region in &levels.regions {
        push_varint(&mut out, region.len() as u64);
        out.extend(region.as_bytes());
    }
    push_varint(&mut out, records.len() as u64);
    records.iter().for_each(|record| out.extend(record));
    for (length, hash) in entries {
        out.extend(length.to_le_bytes());
        out.extend(hash);
    }
    let length = out.len() as u32;
    out[8..FIXED].copy_from_slice(&length.to_le_bytes());
    out
}

/// Encodes the record of an object.
pub(super) fn record(object: &StreamObject) -> Vec<u8> {
    let mut out = Vec::new();
    for number in [object.mesh, object.primitive, object.region] {
        push_varint(&mut out, u64::from(number));
    }
    let layout = &object.layout;
    out.extend([
        layout.position_bits,
        layout.normal_bits,
        layout.texcoord_bits,
        u8::from(layout.has_colors),
    ]);
    push_varint(&mut out, u64::from(layout.joints));
    push_varint(&mut out, layout.morphs.len() as u64);
    out.extend(layout.morphs.iter().map(|m| u8::from(m.has_normals)));
    let scale = &object.scale;
    let mut metres = vec![scale.grid.step, scale.texcoord_step];
    metres.extend(scale.grid.origin.to_array());
    metres.extend(scale.texcoord_origin.to_array());
    metres.iter().for_each(|v| out.extend(v.to_le_bytes()));
    out
}

/// Reads the number of the level as stored in this version, and the table.
fn read_levels(r: &mut ByteReader<'_>, is_old: bool) -> Result<(usize, LevelTable), StreamError> {
    let number = count_of(r, "levels", MAX_LEVELS)?;
    let count = count_of(r, "levels", MAX_LEVELS)?;
    if count == 0 {
        return Err(r.bad("the stream has no level").into());
    }
    let mut levels = Vec::with_capacity(count);
    for _ in 0..count {
        levels.push(LevelRow {
            triangles: r.varint()?,
            vertices: r.varint()?,
            rest: read_error(r)?,
            motion: read_error(r)?,
        });
    }
    levels.reverse();
    let mixable = count_of(r, "levels", MAX_LEVELS)?;
    let mut regions = Vec::new();
    for _ in 0..count_of(r, "regions", MAX_REGIONS)? {
        let mut name = Vec::new();
        for _ in 0..count_of(r, "bytes of a name", MAX_NAME)? {
            name.extend(r.take::<1>()?);
        }
        regions
            .push(String::from_utf8(name).map_err(|_| r.bad("a region name is not valid UTF-8"))?);
    }
    let levels = LevelTable {
        levels,
        regions,
        mixable_to: if is_old {
            count.saturating_sub(1 + mixable)
        } else {
            mixable
        },
    };
    Ok((number, levels))
}

fn read_error(r: &mut ByteReader<'_>) -> Result<SurfaceError, StreamError> {
    let mut metres = || {
        let value = f32::from_le_bytes(r.take()?);
        match value >= 0.0 {
            true => Ok(value),
            false => Err(r.bad(format!("an error must be at least 0, found {value}"))),
        }
    };
    Ok(SurfaceError {
        max_metres: metres()?,
        p99_metres: metres()?,
        p95_metres: metres()?,
        mean_metres: metres()?,
    })
}

fn read_object(r: &mut ByteReader<'_>) -> Result<StreamObject, StreamError> {
    let mut number = || {
        let value = r.varint()?;
        u32::try_from(value).map_err(|_| r.bad(format!("index {value} exceeds 32 bits")))
    };
    let (mesh, primitive, region) = (number()?, number()?, number()?);
    let [position_bits, normal_bits, texcoord_bits, flags] = r.take::<4>()?;
    let joints = r.varint()?;
    let morphs = count_of(r, "morph targets", MAX_MORPHS)?;
    let mut layout = Layout {
        position_bits,
        normal_bits,
        texcoord_bits,
        has_colors: flags == 1,
        joints: u16::try_from(joints)
            .map_err(|_| r.bad(format!("{joints} joints, the limit is 65535")))?,
        morphs: Vec::new(),
    };
    for _ in 0..morphs {
        let [has_normals] = r.take::<1>()?;
        if has_normals > 1 {
            return Err(r
                .bad("the normals flag of a morph target must be 0 or 1")
                .into());
        }
        layout.morphs.push(MorphLayout {
            has_normals: has_normals == 1,
        });
    }
    if flags > 1 {
        return Err(r.bad(format!("unknown flags {flags}")).into());
    }
    layout
        .check()
        .map_err(|e| r.bad(format!("{}: {}", e.at, e.what)))?;
    let scale = Scale {
        grid: Grid {
            step: r.positive("a step")?,
            origin: Vec3::ZERO,
        },
        texcoord_origin: Vec2::ZERO,
        texcoord_step: r.positive("a step")?,
    };
    let mut finite = || {
        let value = f32::from_le_bytes(r.take()?);
        match value.is_finite() {
            true => Ok(value),
            false => Err(r.bad(format!("an origin must be finite, found {value}"))),
        }
    };
    let origin = Vec3::new(finite()?, finite()?, finite()?);
    let texcoord_origin = Vec2::new(finite()?, finite()?);
    Ok(StreamObject {
        mesh,
        primitive,
        region,
        layout,
        scale: Scale {
            grid: Grid {
                origin,
                ..scale.grid
            },
            texcoord_origin,
            texcoord_step: scale.texcoord_step,
        },
    })
}

/// Reads a count of at most `limit`.
fn count_of(
    r: &mut ByteReader<'_>,
    which: &'static str,
    limit: usize,
) -> Result<usize, StreamError> {
    let at = format!("byte {}", r.at());
    let count = r.varint()?;
    StreamLimits::check(&at, which, count, limit as u64)?;
    Ok(count as usize)
}

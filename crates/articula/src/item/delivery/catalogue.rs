//! What a client can ask for: the ranges of bytes of each layer, of motions also by access unit.

use crate::error::{Context as _, Error, Result};
use crate::item::files::MANIFEST;
use crate::item::manifest::Manifest;
use crate::item::part::{ItemPart, PartKind};
use crate::item::sent::FileEntry;
use std::collections::BTreeMap;
use std::ops::Range;

/// What a piece is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum PieceOf {
    /// The manifest.
    Manifest,
    /// The figure, and files that are carried whole.
    Figure,
    /// Of a part: what all layers share (`layer` is `None`) or one layer; of the whole stream or of one
    /// access unit.
    Part {
        part: usize,
        unit: Option<usize>,
        layer: Option<usize>,
    },
}

/// Bytes that are asked for together.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Piece {
    pub(crate) of: PieceOf,
    /// Where they lie in the stream of the part; empty for whole files.
    pub(crate) ranges: Vec<Range<u64>>,
    /// Bytes as they are sent.
    pub(crate) bytes: u64,
}

/// Returns the bytes of each access unit of a motion.
pub(crate) type UnitsOf<'a> = dyn FnMut(&ItemPart) -> Result<Vec<Range<u64>>> + 'a;

/// All pieces of an item. What has no bytes is no piece.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Catalogue {
    pub(crate) pieces: Vec<Piece>,
    index: BTreeMap<PieceOf, usize>,
}

impl Catalogue {
    /// The pieces of an item; `units` returns the bytes of each access unit of a motion, in order.
    pub(crate) fn of(manifest: &Manifest, units: &mut UnitsOf<'_>) -> Result<Self> {
        let mut pieces = vec![whole(PieceOf::Manifest, manifest_bytes(manifest))];
        let carried = manifest.whole.iter().map(|file| &file.file);
        let files = carried.chain([&manifest.figure.file]);
        let always = files.map(|file| manifest.sent_bytes(file)).sum();
        pieces.push(whole(PieceOf::Figure, always));
        for (index, part) in manifest.parts.iter().enumerate() {
            match part.kind {
                PartKind::Texture => pieces.extend(sizes(manifest, index, part)),
                _ => {
                    let of_stream = stream(index, part, units);
                    pieces
                        .extend(of_stream.with_context(|| part.file.clone().unwrap_or_default())?);
                }
            }
        }
        pieces.retain(|piece| piece.bytes > 0);
        let index = pieces.iter().enumerate().map(|(i, piece)| (piece.of, i));
        Ok(Self {
            index: index.collect(),
            pieces,
        })
    }

    /// The index of a piece; `None` if it has no bytes.
    pub(crate) fn find(&self, of: PieceOf) -> Option<usize> {
        self.index.get(&of).copied()
    }

    /// Bytes of some pieces.
    pub(crate) fn bytes(&self, pieces: &[usize]) -> u64 {
        pieces.iter().map(|piece| self.pieces[*piece].bytes).sum()
    }
}

fn whole(of: PieceOf, bytes: u64) -> Piece {
    Piece {
        of,
        ranges: Vec::new(),
        bytes,
    }
}

/// Bytes of the manifest as it is sent.
fn manifest_bytes(manifest: &Manifest) -> u64 {
    FileEntry::of(MANIFEST, &manifest.to_json()).sent_bytes()
}

/// The sizes of a texture, each a file.
fn sizes(manifest: &Manifest, index: usize, part: &ItemPart) -> Vec<Piece> {
    let layers = part.layers.iter().enumerate();
    let files = layers.filter_map(|(layer, of)| Some((layer, of.file.as_ref()?)));
    let piece = |(layer, file): (usize, &String)| {
        let of = PieceOf::Part {
            part: index,
            unit: None,
            layer: Some(layer),
        };
        whole(of, manifest.sent_bytes(file))
    };
    files.map(piece).collect()
}

/// Base and layers of a stream, of a motion by access unit.
fn stream(index: usize, part: &ItemPart, units: &mut UnitsOf<'_>) -> Result<Vec<Piece>> {
    let has_ranges = !part.base_ranges.is_empty()
        && part
            .layers
            .iter()
            .all(|l| l.bytes == 0 || !l.ranges.is_empty());
    if !has_ranges {
        let what = "the manifest has no ranges of bytes for this stream, so that it cannot be fetched \
                    in parts; package the character again";
        return Err(Error::unsuited(what));
    }
    let units = match part.kind {
        PartKind::BodyMotion | PartKind::FaceMotion => units(part)?,
        PartKind::Mesh | PartKind::Texture => Vec::new(),
    };
    let layers = part.layers.iter().enumerate();
    let layers = layers.map(|(layer, of)| (Some(layer), &of.ranges));
    let mut pieces = Vec::new();
    for (layer, ranges) in std::iter::once((None, &part.base_ranges)).chain(layers) {
        let mut places: BTreeMap<Option<usize>, Vec<Range<u64>>> = BTreeMap::new();
        for [start, count] in ranges {
            split(*start..*start + *count, &units, &mut places);
        }
        for (unit, ranges) in places {
            pieces.push(Piece {
                of: PieceOf::Part {
                    part: index,
                    unit,
                    layer,
                },
                bytes: ranges.iter().map(|range| range.end - range.start).sum(),
                ranges,
            });
        }
    }
    Ok(pieces)
}

/// The bytes of each access unit of a motion as its base ranges tell them, in order: the first range is the
/// head of the stream with that of the first unit, each other one begins a unit. Empty for a stream that has
/// no more than a head.
pub(crate) fn access_units(part: &ItemPart) -> Vec<Range<u64>> {
    let Some(([start, count], later)) = part.base_ranges.split_first() else {
        return Vec::new();
    };
    let first = start + count;
    let starts = std::iter::once(first).chain(later.iter().map(|[start, _]| *start));
    let ends = later.iter().map(|[start, _]| *start).chain([part.bytes]);
    let units = starts.zip(ends).map(|(start, end)| start..end);
    units.filter(|unit| !unit.is_empty()).collect()
}

/// Splits a range at the borders of access units; what comes before the first is in none.
fn split(
    range: Range<u64>,
    units: &[Range<u64>],
    places: &mut BTreeMap<Option<usize>, Vec<Range<u64>>>,
) {
    let head_end = units.first().map_or(u64::MAX, |unit| unit.start);
    let head = range.start..range.end.min(head_end);
    let first = units.partition_point(|unit| unit.end <= range.start);
    let within = units.iter().enumerate().skip(first);
    let within = within.take_while(|(_, unit)| unit.start < range.end);
    let of_units = within.map(|(number, unit)| {
        let common = range.start.max(unit.start)..range.end.min(unit.end);
        (Some(number), common)
    });
    for (unit, range) in std::iter::once((None, head)).chain(of_units) {
        if !range.is_empty() {
            places.entry(unit).or_default().push(range);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_split_at_access_units() {
        let units = [10..20, 20..21, 21..30];
        let mut places = BTreeMap::new();
        split(4..12, &units, &mut places);
        split(15..28, &units, &mut places);
        let of = |unit, ranges: &[Range<u64>]| (unit, ranges.to_vec());
        let one = |range: Range<u64>| [range];
        let expected = [
            of(None, &one(4..10)),
            of(Some(0), &[10..12, 15..20]),
            of(Some(1), &one(20..21)),
            of(Some(2), &one(21..28)),
        ];
        assert_eq!(places, expected.into());
    }
}

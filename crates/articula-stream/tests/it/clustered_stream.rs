//! Streams of mesh levels: the result on a client by different paths, and refused input.

use crate::small_human::{asset, source};
use articula_build::{MeshLevelOptions, mesh_levels};
use articula_core::LevelTable;
use articula_mutate::{Edit, Mutations, cut_off};
use articula_stream::Unit;
use articula_stream::mesh::{Grid, Precision, QuantisedMesh, decode_level, quantise};
use articula_stream::mesh::{MeshStream, ObjectLevels, Receiver, StreamObject, write};
use articula_stream::{CutRule, StreamError, StreamLimits, cut};
use std::collections::BTreeSet;
use std::sync::OnceLock;

/// The levels of a small reference human: two objects, skin in two tones.
pub(crate) fn levels() -> &'static (LevelTable, Vec<ObjectLevels>) {
    static LEVELS: OnceLock<(LevelTable, Vec<ObjectLevels>)> = OnceLock::new();
    LEVELS.get_or_init(|| {
        let made = mesh_levels(asset(), &MeshLevelOptions::default()).unwrap();
        let precision = Precision::default();
        let mut objects = Vec::new();
        for (m, mesh) in source().meshes.iter().enumerate() {
            let grid = Grid::new(&mesh.primitives, precision.position_bits).unwrap();
            for (p, primitive) in mesh.primitives.iter().enumerate() {
                let parts = &made.parts[objects.len()];
                let quantised = quantise(primitive, parts, &grid, &precision).unwrap();
                objects.push(ObjectLevels {
                    object: StreamObject {
                        mesh: m as u32,
                        primitive: p as u32,
                        region: 0,
                        layout: quantised.layout,
                        scale: quantised.scale,
                    },
                    levels: quantised.levels,
                });
            }
        }
        (made.table, objects)
    })
}

/// A mesh as a set of triangles of vertices by value, each rotated to its lowest corner.
fn by_value(mesh: &QuantisedMesh) -> BTreeSet<[Vec<i64>; 3]> {
    let corner = |w: u32| -> Vec<i64> {
        let (w, p) = (w as usize, mesh.wedge_points[w as usize] as usize);
        let mut all: Vec<i64> = mesh.positions[p].map(i64::from).into();
        all.extend(
            mesh.skins[p]
                .iter()
                .flat_map(|s| [s.0.into(), i64::from(s.1)]),
        );
        all.push(-1);
        all.extend(mesh.normals.get(w).iter().flat_map(|n| n.map(i64::from)));
        all.extend(mesh.texcoords.get(w).iter().flat_map(|n| n.map(i64::from)));
        all
    };
    let faces = mesh.faces.iter().map(|f| f.map(corner));
    faces
        .map(|[a, b, c]| {
            let turns = [
                [a.clone(), b.clone(), c.clone()],
                [b.clone(), c.clone(), a.clone()],
                [c, a, b],
            ];
            turns.into_iter().min().unwrap()
        })
        .collect()
}

/// A client that has the head of a stream and no chunk.
fn waiting(whole: &[u8]) -> Receiver {
    let limits = StreamLimits::default();
    let head = MeshStream::open(whole, &limits).unwrap().head_bytes;
    Receiver::read(&whole[..head], &limits).unwrap()
}

/// The value of a unit's marker in a scheme.
fn marker(unit: &Unit, scheme: &str) -> Option<u32> {
    let mut markers = unit.markers.iter();
    markers.find(|m| m.scheme == scheme).map(|m| m.value)
}

#[test]
fn refining_gives_at_each_step_the_mesh_of_direct_delivery() {
    let (table, objects) = levels();
    let count = table.levels.len();
    let whole = write(table, objects, 0..count).unwrap().bytes;
    let limits = StreamLimits::default();
    let mut receiver = waiting(&whole);
    for level in (0..count).rev() {
        let alone = write(table, objects, level..level + 1).unwrap().bytes;
        let direct = Receiver::read(&alone, &limits).unwrap();
        for (o, object) in objects.iter().enumerate() {
            let before = receiver.mesh(o).unwrap().clone();
            let chunk = receiver.stream().chunk(level, o).unwrap();
            receiver.refine(o, &whole[chunk]).unwrap();
            let mesh = receiver.mesh(o).unwrap();
            let truth = by_value(&object.levels[level]);
            assert_eq!(truth.len(), object.levels[level].faces.len());
            assert!(by_value(mesh) == truth, "level {level}, object {o}");
            assert!(by_value(direct.mesh(o).unwrap()) == truth);
            // No vertex changes its index, and no value is sent again.
            assert!(mesh.positions.starts_with(&before.positions));
            assert!(mesh.wedge_points.starts_with(&before.wedge_points));
            assert!(mesh.normals.starts_with(&before.normals));
        }
    }
}

#[test]
fn one_level_alone_refines_with_the_chunks_of_the_whole() {
    let (table, objects) = levels();
    let count = table.levels.len();
    let limits = StreamLimits::default();
    let whole = write(table, objects, 0..count).unwrap().bytes;
    let from = count - 3;
    let to_finest = write(table, objects, 0..from + 1).unwrap().bytes;
    let (whole_head, head) = (
        MeshStream::open(&whole, &limits).unwrap(),
        MeshStream::open(&to_finest, &limits).unwrap(),
    );
    assert_eq!((head.finest_level, head.levels.levels.len()), (0, from + 1));
    let mut receiver = waiting(&to_finest);
    for o in 0..objects.len() {
        receiver
            .refine(o, &to_finest[head.chunk(from, o).unwrap()])
            .unwrap();
        for level in (0..from).rev() {
            let chunk = whole_head.chunk(level, o).unwrap();
            receiver.refine(o, &whole[chunk]).unwrap();
        }
        assert!(by_value(receiver.mesh(o).unwrap()) == by_value(&objects[o].levels[0]));
    }
    // A level in the middle has its number in the head and in its markers.
    let alone = write(table, objects, 2..3).unwrap();
    let head = MeshStream::open(&alone.bytes, &limits).unwrap();
    assert_eq!((head.finest_level, head.levels.levels.len()), (2, 1));
    assert_eq!(marker(&alone.unit.children[1], "level"), Some(2));
}

#[test]
fn freed_levels_come_back_the_same() {
    let (table, objects) = levels();
    let limits = StreamLimits::default();
    let whole = write(table, objects, 0..table.levels.len()).unwrap().bytes;
    let fine = Receiver::read(&whole, &limits).unwrap();
    let mut receiver = fine.clone();
    let count = table.levels.len();
    let kept = count - 2;
    for (o, object) in objects.iter().enumerate() {
        receiver.coarsen(o, kept);
        assert_eq!(receiver.finest_level(o), Some(kept));
        assert_eq!(receiver.next_level(o), Some(kept - 1));
        assert!(by_value(receiver.mesh(o).unwrap()) == by_value(&object.levels[kept]));
        let triangles = receiver.triangles(o).unwrap();
        let vertices = receiver.mesh(o).unwrap().wedge_points.len();
        assert_eq!(triangles.check(vertices), Ok(()));
        for level in (0..kept).rev() {
            let chunk = fine.stream().chunk(level, o).unwrap();
            receiver.refine(o, &whole[chunk]).unwrap();
        }
        assert_eq!(receiver.mesh(o), fine.mesh(o));
        assert_eq!(receiver.next_level(o), None);
        let shown: Vec<_> = fine.triangles(o).unwrap().level(1).collect();
        assert_eq!(shown.len(), object.levels[1].faces.len());
    }
    receiver.coarsen(0, count);
    assert_eq!(receiver.finest_level(0), None);
    assert_eq!(receiver.mesh(0).unwrap().faces.len(), 0);
    assert_eq!(receiver.next_level(9), None, "there is no such object");
}

#[test]
fn damaged_and_misplaced_chunks_change_nothing() {
    let (table, objects) = levels();
    let limits = StreamLimits::default();
    let whole = write(table, objects, 0..table.levels.len()).unwrap().bytes;
    let stream = MeshStream::open(&whole, &limits).unwrap();
    let chunk = |level, o| whole[stream.chunk(level, o).unwrap()].to_vec();
    let mut receiver = waiting(&whole);
    let first = table.levels.len() - 1;
    let next = first - 1;
    receiver.refine(0, &chunk(first, 0)).unwrap();
    let before = receiver.mesh(0).cloned();
    let good = chunk(next, 0);
    let refused = |receiver: &mut Receiver, bytes: &[u8]| {
        let error = receiver.refine(0, bytes).unwrap_err();
        assert!(matches!(error, StreamError::Malformed { .. }), "{error}");
        let place = format!("level {next}, object 0");
        assert!(error.to_string().contains(&place), "{error}");
    };
    for at in (0..good.len()).step_by(7) {
        let mut bad = good.clone();
        bad[at] ^= 1 << (at % 8);
        refused(&mut receiver, &bad);
        refused(&mut receiver, &good[..at]);
    }
    refused(&mut receiver, &chunk(next - 1, 0));
    refused(&mut receiver, &chunk(next, 1));
    refused(&mut receiver, &[]);
    assert_eq!(receiver.mesh(0).cloned(), before);
    receiver.refine(0, &good).unwrap();
    let nobody = receiver.refine(9, &good).unwrap_err();
    assert!(matches!(nobody, StreamError::Mismatch(_)), "{nobody}");
}

#[test]
fn a_stream_cut_after_any_level_is_a_whole_coarser_character() {
    let (table, objects) = levels();
    let limits = StreamLimits::default();
    let written = write(table, objects, 0..table.levels.len()).unwrap();
    written.unit.check().unwrap();
    written.unit.check_values(&written.bytes).unwrap();
    assert_eq!(written.unit.bytes() as usize, written.bytes.len());
    let of_level = |u: &&Unit| u.label == "level";
    let units = written.unit.children.iter().filter(of_level);
    for (unit, l) in units.zip((0..table.levels.len()).rev()) {
        assert_eq!(marker(unit, "level"), Some(l as u32));
        let cut = (unit.bits.end / 8) as usize;
        let receiver = Receiver::read(&written.bytes[..cut], &limits).unwrap();
        for (o, object) in objects.iter().enumerate() {
            assert_eq!(receiver.finest_level(o), Some(l));
            assert!(by_value(receiver.mesh(o).unwrap()) == by_value(&object.levels[l]));
            assert_eq!(marker(&unit.children[o], "object"), Some(o as u32));
        }
    }
}

#[test]
fn an_object_ends_where_a_chunk_was_cut_out() {
    let (table, objects) = levels();
    let limits = StreamLimits::default();
    let written = write(table, objects, 0..table.levels.len()).unwrap();
    let stream = MeshStream::open(&written.bytes, &limits).unwrap();
    // Like a cut: the bytes are removed, their length in the head becomes 0.
    let cut = table.levels.len() - 3;
    let gone = stream.chunk(cut, 0).unwrap();
    let length = &written.unit.children[0].fields[2 * objects.len()];
    assert_eq!(length.value as usize, gone.len());
    let mut bytes = written.bytes.clone();
    length.coding.write(&mut bytes, &length.bits, 0).unwrap();
    bytes.drain(gone);
    let receiver = Receiver::read(&bytes, &limits).unwrap();
    assert_eq!(receiver.finest_level(0), Some(cut + 1));
    assert_eq!(receiver.finest_level(1), Some(0));
    assert!(by_value(receiver.mesh(0).unwrap()) == by_value(&objects[0].levels[cut + 1]));
    assert!(by_value(receiver.mesh(1).unwrap()) == by_value(&objects[1].levels[0]));
    let left = receiver.stream().unit();
    left.check().unwrap();
    left.check_values(&bytes).unwrap();
}

#[test]
fn heads_of_other_files_and_short_ones_are_errors() {
    let (table, objects) = levels();
    let limits = StreamLimits::default();
    let whole = write(table, objects, 0..table.levels.len()).unwrap().bytes;
    let head = MeshStream::open(&whole, &limits).unwrap().head_bytes;
    assert_eq!(MeshStream::head_length(&whole[..12]).unwrap(), head);
    for length in 0..head {
        assert!(MeshStream::open(&whole[..length], &limits).is_err());
    }
    for at in 0..head {
        for bit in 0..8 {
            let mut bad = whole[..head].to_vec();
            bad[at] ^= 1 << bit;
            // It is refused, or no chunk of the altered part matches any more; never a panic.
            let _ = MeshStream::open(&bad, &limits).map(|s| s.unit().check());
        }
    }
    assert!(write(table, objects, 2..2).is_err());
    assert!(write(table, objects, 0..9).is_err());
    let again = write(table, objects, 0..table.levels.len()).unwrap().bytes;
    assert!(again == whole, "the same input gives the same bytes");
}

/// A stream of version 1, written by the code of that time, with levels counted from the coarsest:
/// a tube of 128, 64 and 26 triangles.
const OLD: &[u8] = include_bytes!("old/tube-1.ams");

#[test]
fn streams_of_version_1_are_read_and_written_as_version_2() {
    let limits = StreamLimits::default();
    let old = Receiver::read(OLD, &limits).unwrap();
    let head = old.stream();
    assert_eq!(head.finest_level, 0);
    let triangles = head.levels.levels.iter().map(|l| l.triangles);
    assert_eq!(triangles.collect::<Vec<_>>(), [128, 64, 26]);
    assert!(head.levels.errors().is_ok(), "the finest has no error");
    assert_eq!(old.finest_level(0), Some(0));
    assert_eq!(old.mesh(0).unwrap().faces.len(), 128);
    let unit = head.unit();
    unit.check().unwrap();
    unit.check_values(OLD).unwrap();
    let markers = unit.children.iter().filter_map(|u| marker(u, "level"));
    assert_eq!(markers.collect::<Vec<_>>(), [2, 1, 0]);
    // Each of its levels as a mesh, encoded again.
    let mut levels = Vec::new();
    for level in 0..3 {
        let mut coarser = old.clone();
        coarser.coarsen(0, level);
        levels.push(coarser.mesh(0).unwrap().clone());
    }
    let object = ObjectLevels {
        object: head.objects[0].clone(),
        levels,
    };
    let written = write(&head.levels, std::slice::from_ref(&object), 0..3).unwrap();
    let new = Receiver::read(&written.bytes, &limits).unwrap();
    assert_eq!(new.stream().levels, head.levels);
    assert_eq!(written.bytes[4], 2);
    for level in 0..3 {
        let [a, b] = [old.clone(), new.clone()].map(|mut receiver| {
            receiver.coarsen(0, level);
            by_value(receiver.mesh(0).unwrap())
        });
        assert!(a == b && a.len() == head.levels.levels[level].triangles as usize);
        // The coded bytes are the same; the hashes in the head are not.
        let chunk = |bytes: &[u8], head: &MeshStream| bytes[head.chunk(level, 0).unwrap()].to_vec();
        assert_eq!(
            chunk(OLD, head),
            chunk(&written.bytes, new.stream()),
            "level {level}"
        );
    }
}

#[test]
fn mutated_streams_give_a_character_or_an_error() {
    let mutations = Mutations {
        edits: &[
            Edit::FlipBit,
            Edit::SetByte,
            Edit::InsertByte,
            Edit::RemoveByte,
            Edit::Truncate,
            Edit::Repeat(32),
            Edit::Delete(32),
        ],
        most: 3,
    };
    const TRIES: usize = 4000;
    let limits = StreamLimits {
        bytes: 1 << 20,
        elements: 1 << 16,
    };
    let whole = Receiver::read(OLD, &limits).unwrap();
    let head = whole.stream();
    let read = |bytes: &[u8]| {
        let Ok(found) = Receiver::read(bytes, &limits) else {
            return false;
        };
        found.stream().unit().check().unwrap();
        for (o, object) in found.stream().objects.iter().enumerate() {
            found.mesh(o).unwrap().check(&object.layout).unwrap();
        }
        true
    };
    assert!((1..TRIES).contains(&mutations.read_of(OLD, TRIES, read)));
    for bytes in cut_off(OLD) {
        assert_eq!(read(bytes), bytes.len() >= head.head_bytes);
    }
    // Without hashes: the coded data itself.
    let layout = &head.objects[0].layout;
    let decodes = |bytes: &[u8]| {
        let Ok(found) = decode_level(None, bytes, layout, &limits) else {
            return false;
        };
        found.check(layout).unwrap();
        true
    };
    let alone = &OLD[head.chunk(2, 0).unwrap()];
    assert!(mutations.read_of(alone, TRIES, decodes) < TRIES);
    let mut coarse = whole.clone();
    coarse.coarsen(0, 2);
    let coarse = coarse.mesh(0).unwrap();
    let refines = |bytes: &[u8]| {
        let Ok(found) = decode_level(Some(coarse), bytes, layout, &limits) else {
            return false;
        };
        found.check(layout).unwrap();
        true
    };
    let added = &OLD[head.chunk(1, 0).unwrap()];
    assert!(mutations.read_of(added, TRIES, refines) < TRIES);
}

#[test]
fn a_stream_cut_by_level_is_that_which_ends_there() {
    let (table, objects) = levels();
    let whole = write(table, objects, 0..table.levels.len()).unwrap();
    let limits = StreamLimits::default();
    for finest in 0..table.levels.len() as u32 {
        let rule = CutRule::default().at_least("level", finest);
        let part = cut(&whole.bytes, &whole.unit, |unit| rule.keeps(unit)).unwrap();
        part.unit.check_values(&part.bytes).unwrap();
        let received = Receiver::read(&part.bytes, &limits).unwrap();
        let complete = Receiver::read(&whole.bytes, &limits).unwrap();
        for object in 0..objects.len() {
            assert_eq!(received.finest_level(object), Some(finest as usize));
            let mut coarse = complete.clone();
            coarse.coarsen(object, finest as usize);
            assert_eq!(received.triangles(object), coarse.triangles(object));
        }
        // The map of the cut is that of its bytes.
        assert_eq!(
            MeshStream::open(&part.bytes, &limits).unwrap().unit(),
            part.unit
        );
        let coarser = CutRule::default().at_least("level", finest + 1);
        let twice = cut(&part.bytes, &part.unit, |unit| coarser.keeps(unit)).unwrap();
        let once = cut(&whole.bytes, &whole.unit, |unit| coarser.keeps(unit)).unwrap();
        assert_eq!(twice.bytes, once.bytes);
    }
}

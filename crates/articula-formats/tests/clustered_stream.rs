//! A stream of mesh levels: what a client puts together, whatever way it took, and what it refuses.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use articula_build::ClipOptions;
use articula_build::character;
use articula_build::{MeshLevelOptions, mesh_levels};
use articula_core::LevelTable;
use articula_core::stream::Unit;
use articula_formats::clustered_stream::{MeshStream, ObjectLevels, Receiver, StreamObject, write};
use articula_formats::mesh_codec::{Grid, Precision, QuantisedMesh, quantise};
use articula_formats::{Limits, ReadError};
use articula_human::{HumanOptions, human};
use std::collections::BTreeSet;
use std::sync::OnceLock;

/// The levels of a small reference human: two objects, skin in two tones.
fn levels() -> &'static (LevelTable, Vec<ObjectLevels>) {
    static LEVELS: OnceLock<(LevelTable, Vec<ObjectLevels>)> = OnceLock::new();
    LEVELS.get_or_init(|| {
        let options = HumanOptions { triangles: 3000 };
        let source = human(&options).unwrap();
        let asset = character(&source, None, &ClipOptions::default()).unwrap();
        let made = mesh_levels(&asset, &MeshLevelOptions::default()).unwrap();
        let precision = Precision::default();
        let mut objects = Vec::new();
        for (m, mesh) in source.meshes.iter().enumerate() {
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

/// A mesh as a set of triangles of vertices by value, each turned to its least corner.
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

#[test]
fn refining_gives_at_each_step_the_mesh_of_direct_delivery() {
    let (table, objects) = levels();
    let count = table.levels.len();
    let whole = write(table, objects, 0..count).unwrap().bytes;
    let limits = Limits::default();
    let mut receiver = Receiver::new(MeshStream::open(&whole, &limits).unwrap(), limits);
    for level in 0..count {
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
            // No number of a vertex changes, no value is sent again.
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
    let limits = Limits::default();
    let whole = write(table, objects, 0..count).unwrap().bytes;
    let from_2 = write(table, objects, 2..count).unwrap().bytes;
    let (whole_head, head) = (
        MeshStream::open(&whole, &limits).unwrap(),
        MeshStream::open(&from_2, &limits).unwrap(),
    );
    assert_eq!(head.first_level, 2);
    let mut receiver = Receiver::new(head.clone(), limits);
    for o in 0..objects.len() {
        receiver
            .refine(o, &from_2[head.chunk(0, o).unwrap()])
            .unwrap();
        for level in 3..count {
            let chunk = whole_head.chunk(level, o).unwrap();
            receiver.refine(o, &whole[chunk]).unwrap();
        }
        let finest = by_value(objects[o].levels.last().unwrap());
        assert!(by_value(receiver.mesh(o).unwrap()) == finest);
    }
}

#[test]
fn freed_levels_come_back_the_same() {
    let (table, objects) = levels();
    let limits = Limits::default();
    let whole = write(table, objects, 0..table.levels.len()).unwrap().bytes;
    let fine = Receiver::read(&whole, &limits).unwrap();
    let mut receiver = fine.clone();
    for (o, object) in objects.iter().enumerate() {
        receiver.coarsen(o, 2);
        assert_eq!(receiver.levels(o), 2);
        assert!(by_value(receiver.mesh(o).unwrap()) == by_value(&object.levels[1]));
        let triangles = receiver.triangles(o).unwrap();
        let vertices = receiver.primitive(o).unwrap().positions.len();
        assert_eq!(triangles.check(vertices), Ok(()));
        for level in 2..table.levels.len() {
            let chunk = fine.stream().chunk(level, o).unwrap();
            receiver.refine(o, &whole[chunk]).unwrap();
        }
        assert_eq!(receiver.mesh(o), fine.mesh(o));
        let shown: Vec<_> = fine.triangles(o).unwrap().level(2).collect();
        assert_eq!(shown.len(), object.levels[2].faces.len());
    }
}

#[test]
fn damaged_and_misplaced_chunks_change_nothing() {
    let (table, objects) = levels();
    let limits = Limits::default();
    let whole = write(table, objects, 0..table.levels.len()).unwrap().bytes;
    let stream = MeshStream::open(&whole, &limits).unwrap();
    let chunk = |level, o| whole[stream.chunk(level, o).unwrap()].to_vec();
    let mut receiver = Receiver::new(stream.clone(), limits);
    receiver.refine(0, &chunk(0, 0)).unwrap();
    let before = receiver.mesh(0).cloned();
    let good = chunk(1, 0);
    let refused = |receiver: &mut Receiver, bytes: &[u8]| {
        let error = receiver.refine(0, bytes).unwrap_err();
        assert!(matches!(error, ReadError::Malformed { .. }), "{error}");
        assert!(error.to_string().contains("level 1, object 0"), "{error}");
    };
    for at in (0..good.len()).step_by(7) {
        let mut bad = good.clone();
        bad[at] ^= 1 << (at % 8);
        refused(&mut receiver, &bad);
        refused(&mut receiver, &good[..at]);
    }
    refused(&mut receiver, &chunk(2, 0));
    refused(&mut receiver, &chunk(1, 1));
    refused(&mut receiver, &[]);
    assert_eq!(receiver.mesh(0).cloned(), before);
    receiver.refine(0, &good).unwrap();
    assert!(receiver.refine(9, &good).is_err());
}

#[test]
fn a_stream_cut_after_any_level_is_a_whole_coarser_character() {
    let (table, objects) = levels();
    let limits = Limits::default();
    let written = write(table, objects, 0..table.levels.len()).unwrap();
    written.unit.check().unwrap();
    assert_eq!(written.unit.bytes() as usize, written.bytes.len());
    let of_level = |u: &&Unit| u.label == "level";
    for (l, unit) in written.unit.children.iter().filter(of_level).enumerate() {
        assert_eq!(unit.marker("level"), Some(l as u32));
        let cut = (unit.bits.end / 8) as usize;
        let receiver = Receiver::read(&written.bytes[..cut], &limits).unwrap();
        for (o, object) in objects.iter().enumerate() {
            assert_eq!(receiver.levels(o), l + 1);
            assert!(by_value(receiver.mesh(o).unwrap()) == by_value(&object.levels[l]));
            assert_eq!(unit.children[o].marker("object"), Some(o as u32));
        }
    }
}

#[test]
fn an_object_ends_where_a_chunk_was_cut_out() {
    let (table, objects) = levels();
    let limits = Limits::default();
    let written = write(table, objects, 0..table.levels.len()).unwrap();
    let stream = MeshStream::open(&written.bytes, &limits).unwrap();
    // As a cut does it: the bytes go, their length in the head becomes 0.
    let gone = stream.chunk(2, 0).unwrap();
    let field = &written.unit.children[0].fields[2 * objects.len()];
    let length = (field.bits.start / 8) as usize;
    let mut bytes = written.bytes.clone();
    bytes.drain(gone);
    bytes[length..length + 4].fill(0);
    let receiver = Receiver::read(&bytes, &limits).unwrap();
    assert_eq!(receiver.levels(0), 2);
    assert_eq!(receiver.levels(1), table.levels.len());
    assert!(by_value(receiver.mesh(0).unwrap()) == by_value(&objects[0].levels[1]));
    let finest = objects[1].levels.last().unwrap();
    assert!(by_value(receiver.mesh(1).unwrap()) == by_value(finest));
}

#[test]
fn heads_of_other_files_and_short_ones_are_errors() {
    let (table, objects) = levels();
    let limits = Limits::default();
    let whole = write(table, objects, 0..table.levels.len()).unwrap().bytes;
    let head = MeshStream::open(&whole, &limits).unwrap().head_bytes();
    assert_eq!(MeshStream::head_length(&whole[..12]).unwrap(), head);
    for length in 0..head {
        assert!(MeshStream::open(&whole[..length], &limits).is_err());
    }
    for at in 0..head {
        for bit in 0..8 {
            let mut bad = whole[..head].to_vec();
            bad[at] ^= 1 << bit;
            // Either it is refused, or no chunk of what changed fits any more; never a panic.
            let _ = MeshStream::open(&bad, &limits).map(|s| (s.bytes(), s.unit().check()));
        }
    }
    assert!(write(table, objects, 2..2).is_err());
    assert!(write(table, objects, 0..9).is_err());
    let again = write(table, objects, 0..table.levels.len()).unwrap().bytes;
    assert!(again == whole, "the same input gives the same bytes");
}

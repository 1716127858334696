//! A stored stream of format version 2 is read back by every later version.

mod shapes;

use articula_core::{LevelRow, LevelTable, SurfaceError};
use articula_stream::StreamLimits;
use articula_stream::mesh::{
    Grid, Layout, MorphLayout, ObjectLevels, QuantisedMesh, Receiver, Scale, StreamObject, write,
};
use glam::{Vec2, Vec3};
use shapes::Shape;
use std::path::Path;

/// Number of levels of each object.
const LEVELS: usize = 3;

/// The objects of the stored stream, with all kinds of values, common and rare ones.
fn objects() -> Vec<ObjectLevels> {
    let morph = |has_normals| MorphLayout { has_normals };
    let morphs = vec![morph(true), morph(false), morph(true)];
    let whole = Layout {
        position_bits: 13,
        normal_bits: 9,
        texcoord_bits: 11,
        has_colors: true,
        joints: 6,
        morphs: morphs.clone(),
    };
    let surface = Layout {
        position_bits: 17,
        normal_bits: 13,
        texcoord_bits: 15,
        ..Layout::default()
    };
    let bare = Layout {
        position_bits: 10,
        joints: 6,
        ..Layout::default()
    };
    let limits = Layout {
        position_bits: 20,
        normal_bits: 16,
        texcoord_bits: 20,
        has_colors: true,
        joints: 300,
        morphs,
    };
    let lump = |side, layout: &Layout| {
        let mut shape = Shape::lump(side, layout);
        for seed in 1..LEVELS as i32 {
            shape.coarsen(seed);
        }
        shape
    };
    let shapes = [
        (lump(11, &whole), whole),
        (lump(7, &surface), surface),
        (lump(6, &bare), bare),
        (Shape::scattered(120, &limits), limits),
    ];
    let scale = Scale {
        grid: Grid {
            origin: Vec3::ZERO,
            step: 0.001,
        },
        texcoord_origin: Vec2::ZERO,
        texcoord_step: 0.001,
    };
    (0u32..)
        .zip(shapes)
        .map(|(mesh, (shape, layout))| ObjectLevels {
            levels: shape.meshes(&layout),
            object: StreamObject {
                mesh,
                primitive: 0,
                region: 0,
                layout,
                scale,
            },
        })
        .collect()
}

fn table(objects: &[ObjectLevels]) -> LevelTable {
    let row = |l: usize| {
        let sum =
            |of: fn(&QuantisedMesh) -> usize| objects.iter().map(|o| of(&o.levels[l]) as u64).sum();
        let error = SurfaceError {
            max_metres: l as f32 * 0.25,
            ..SurfaceError::default()
        };
        LevelRow {
            triangles: sum(|m| m.faces.len()),
            vertices: sum(|m| m.wedge_points.len()),
            rest: error,
            motion: error,
        }
    };
    LevelTable {
        levels: (0..LEVELS).map(row).collect(),
        ..LevelTable::default()
    }
}

/// A corner by value.
type Corner = (
    [i32; 3],
    Vec<(u16, u8)>,
    Vec<[i32; 3]>,
    [Option<[i32; 2]>; 2],
    Option<[u8; 4]>,
    Vec<[i32; 3]>,
);

/// The faces by value, sorted.
fn faces(mesh: &QuantisedMesh) -> Vec<[Corner; 3]> {
    let corner = |w: u32| {
        let w = w as usize;
        let p = mesh.wedge_points[w] as usize;
        let turns = mesh.morph_normals.iter().filter_map(|m| m.get(w).copied());
        (
            mesh.positions[p],
            mesh.skins.get(p).cloned().unwrap_or_default(),
            mesh.morphs.iter().map(|m| m[p]).collect(),
            [&mesh.normals, &mesh.texcoords].map(|list| list.get(w).copied()),
            mesh.colors.get(w).copied(),
            turns.collect(),
        )
    };
    let turned = |f: &[u32; 3]| {
        let mut f = f.map(corner);
        let first = (0..3).min_by_key(|&k| &f[k]).unwrap();
        f.rotate_left(first);
        f
    };
    let mut faces: Vec<[Corner; 3]> = mesh.faces.iter().map(turned).collect();
    faces.sort_unstable();
    faces
}

/// Reads a stream and compares the meshes of all its levels with those of `objects`.
fn check_stream(bytes: &[u8], objects: &[ObjectLevels]) {
    let whole = Receiver::read(bytes, &StreamLimits::default()).unwrap();
    for (o, object) in objects.iter().enumerate() {
        for (l, level) in object.levels.iter().enumerate() {
            let mut shown = whole.clone();
            shown.coarsen(o, l);
            let shown = faces(shown.mesh(o).unwrap());
            assert!(shown == faces(level), "object {o}, level {l}");
        }
    }
}

/// The bytes are stored, since nothing else fixes the predictions and models that encoder and
/// decoder share: changed in both, they still agree with each other, but no longer with the streams
/// that users have. The meshes are those of `shapes`, which does not use the codec. So a difference
/// has one of two reasons. If the stored stream no longer decodes, the format has another version,
/// and this file is read as an old one. If it does, but is not what the encoder writes, the encoder
/// has other choices (such as coefficients), and `cargo xtask golden` stores them.
#[test]
fn a_stored_stream_is_read_and_written_again() {
    let objects = objects();
    for object in &objects {
        for level in &object.levels {
            level.check(&object.object.layout).unwrap();
        }
        let sizes: Vec<usize> = object.levels.iter().map(|l| l.faces.len()).collect();
        assert!(
            sizes.windows(2).all(|s| s[1] < s[0] && s[1] > 10),
            "{sizes:?}"
        );
    }
    let written = write(&table(&objects), &objects, 0..LEVELS).unwrap().bytes;
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/levels-2.ams");
    let is_renewed = std::env::var_os("ARTICULA_GOLDEN").is_some_and(|v| v == "renew");
    if is_renewed && !path.exists() {
        std::fs::write(&path, &written).unwrap();
    }
    let stored = std::fs::read(&path).unwrap();
    check_stream(&stored, &objects);
    if is_renewed {
        check_stream(&written, &objects);
        std::fs::write(&path, &written).unwrap();
    } else {
        assert!(written == stored, "the encoder writes other bytes");
    }
}

//! Palettes, keys and steps by hand.

use super::*;
use crate::clip::{Clip, Tracks};
use crate::clip_set::ClipStorage;
use crate::joint_lods::JointLods;
use crate::rig::tests::rig_of;
use glam::Vec3;

/// One joint; a clip of a second at 4 Hz and a single pose.
fn parts() -> (ClipSet, PaletteMap) {
    let rig = rig_of(&[(None, Vec3::ZERO, 0)]);
    let clip = |frames| Clip::new("c", 4.0, frames, 1, Tracks::default()).unwrap();
    let joint_lods = JointLods::whole(&rig).unwrap();
    let map = PaletteMap::joints(&joint_lods);
    let clips = [clip(5), clip(1)];
    (
        ClipSet::new(&rig, joint_lods, &clips, ClipStorage::Float).unwrap(),
        map,
    )
}

fn keys(times: &[f32], first_matrix: u32) -> Option<CachedKeys> {
    Some(CachedKeys {
        times_secs: times.to_vec(),
        first_matrix,
        error_metres: 0.25,
    })
}

fn rows(matrices: u16) -> CachedRows {
    let row = |i: u16| [f32::from(i), 0.0, -1.0, 0.5];
    CachedRows::Float((0..matrices * 3).map(row).collect())
}

#[test]
fn by_hand() {
    let (clips, map) = parts();
    // The single pose is the first palette.
    let all = [
        vec![keys(&[0.0, 0.125, 0.25, 1.0], 1)],
        vec![keys(&[0.0], 0)],
    ];
    let cache = PoseCache::new(&clips, &map, &all, rows(5)).unwrap();
    let record = |clip, secs| {
        let r = cache.locate(clip, 0, secs).unwrap();
        (r.before, r.after, r.blend)
    };
    let expected = [
        (0.0, (1, 2, 0.0)),
        (0.0625, (1, 2, 0.5)),
        (0.125, (2, 3, 0.0)),
        (0.25, (3, 4, 0.0)),
        (0.4375, (3, 4, 0.25)),
        (1.0, (4, 4, 0.0)),
        (7.0, (4, 4, 0.0)),
        (f32::INFINITY, (4, 4, 0.0)),
        (-3.0, (1, 2, 0.0)),
        (f32::NEG_INFINITY, (1, 2, 0.0)),
        (f32::NAN, (1, 2, 0.0)),
    ];
    for (secs, expected) in expected {
        assert_eq!(record(0, secs), expected, "at {secs} s");
        assert_eq!(record(1, secs), (0, 0, 0.0), "a single pose at {secs} s");
    }
    let mut out = [[0.0; 4]; 3];
    let at = cache.locate(0, 0, 0.4375).unwrap();
    cache.blend(0, &[at], Backend::best(), PaletteRows::Float(&mut out));
    // Matrix 3 begins with row 9, matrix 4 with row 12: a quarter of the way.
    assert_eq!(out[1], [10.75, 0.0, -1.0, 0.5]);
    assert_eq!(cache.error_metres(0, 0), Some(0.25));
    assert_eq!(
        (cache.step_error_metres(0, 0), cache.nearest(0, 0, 0.0)),
        (None, None)
    );
    assert_eq!(cache.rows().len(), 5 * 3);
    assert_eq!(
        (cache.clips(), cache.levels(), cache.matrices(0)),
        (2, 1, 1)
    );
    let times: Vec<f32> = cache.times_secs(0, 0).unwrap().collect();
    assert_eq!(times, [0.0, 0.125, 0.25, 1.0]);
}

fn steps(count: u32, first_matrix: u32) -> Option<CachedSteps> {
    Some(CachedSteps {
        count,
        first_matrix,
        error_metres: 0.5,
        blend_error_metres: None,
    })
}

#[test]
fn steps_by_hand() {
    let (clips, map) = parts();
    let cache = |all: &[Vec<Option<CachedSteps>>]| {
        PoseCache::new(&clips, &map, &[vec![None], vec![None]], rows(9))
            .unwrap()
            .with_steps(&clips, all)
    };
    // Five palettes, a quarter of a second apart.
    let made = cache(&[vec![steps(5, 3)], vec![steps(1, 2)]]).unwrap();
    for (secs, first_matrix) in [
        (0.0, 3),
        (0.12, 3),
        (0.125, 4),
        (0.25, 4),
        (0.8, 6),
        (0.9, 7),
        (1.0, 7),
        (9.0, 7),
        (f32::INFINITY, 7),
        (-3.0, 3),
        (f32::NEG_INFINITY, 3),
        (f32::NAN, 3),
    ] {
        assert_eq!(made.nearest(0, 0, secs), Some(first_matrix), "at {secs} s");
        assert_eq!(
            made.nearest(1, 0, secs),
            Some(2),
            "a single pose at {secs} s"
        );
    }
    assert_eq!(made.step_error_metres(0, 0), Some(0.5));
    assert_eq!(made.error_metres(0, 0), None);
    let at = |all: &[Vec<Option<CachedSteps>>]| cache(all).unwrap_err().at;
    assert_eq!(at(&[vec![None]]), "steps");
    assert_eq!(at(&[vec![None], vec![]]), "steps[1]");
    assert_eq!(at(&[vec![steps(0, 0)], vec![None]]), "steps[0][0].count");
    assert_eq!(at(&[vec![steps(1, 0)], vec![None]]), "steps[0][0].count");
    assert_eq!(
        at(&[vec![None], vec![steps(8, 2)]]),
        "steps[1][0].first_matrix"
    );
    let beyond = [vec![steps(u32::MAX, u32::MAX)], vec![None]];
    assert_eq!(at(&beyond), "steps[0][0].first_matrix");
    let nan = steps(5, 0).map(|s| CachedSteps {
        error_metres: f32::NAN,
        ..s
    });
    assert_eq!(at(&[vec![nan], vec![None]]), "steps[0][0].error_metres");
}

#[test]
fn records_of_the_closer_palettes_by_hand() {
    let (clips, map) = parts();
    // Keys at matrices 1 to 4, within 0.25 m; steps at 5 to 9, a quarter of a second apart.
    let of_keys = [
        vec![keys(&[0.0, 0.125, 0.25, 1.0], 1)],
        vec![keys(&[0.0], 0)],
    ];
    let cache = |of_keys: &[Vec<Option<CachedKeys>>], error: Option<f32>| {
        let blended = |s: CachedSteps| CachedSteps {
            blend_error_metres: error,
            ..s
        };
        let of_steps = [
            vec![steps(5, 5).map(blended)],
            vec![steps(1, 0).map(blended)],
        ];
        let cache = PoseCache::new(&clips, &map, of_keys, rows(10)).unwrap();
        cache.with_steps(&clips, &of_steps)
    };
    let record = |cache: &PoseCache, clip, secs| {
        let r = cache.record(clip, 0, secs).unwrap();
        (r.before, r.after, r.blend)
    };
    let closer = cache(&of_keys, Some(0.125)).unwrap();
    assert_eq!(closer.record_error_metres(0, 0), Some(0.125));
    assert_eq!(closer.error_metres(0, 0), Some(0.25), "of keys");
    for (secs, expected) in [
        (0.0, (5, 6, 0.0)),
        (0.0625, (5, 6, 0.25)),
        (0.25, (6, 7, 0.0)),
        (0.875, (8, 9, 0.5)),
        (1.0, (9, 9, 0.0)),
        (7.0, (9, 9, 0.0)),
        (f32::INFINITY, (9, 9, 0.0)),
        (-3.0, (5, 6, 0.0)),
        (f32::NAN, (5, 6, 0.0)),
    ] {
        assert_eq!(record(&closer, 0, secs), expected, "at {secs} s");
        assert_eq!(record(&closer, 1, secs), (0, 0, 0.0), "a single pose");
    }
    // Not closer, or not measured: those of keys.
    for error in [Some(0.25), Some(0.5), None] {
        let made = cache(&of_keys, error).unwrap();
        assert_eq!(made.record_error_metres(0, 0), Some(0.25));
        assert_eq!(record(&made, 0, 0.4375), (3, 4, 0.25));
    }
    // Without keys, where blends of steps were measured.
    let none = [vec![None], vec![None]];
    let alone = cache(&none, Some(0.5)).unwrap();
    assert_eq!(alone.record_error_metres(0, 0), Some(0.5));
    assert_eq!(record(&alone, 0, 0.0625), (5, 6, 0.25));
    let unknown = cache(&none, None).unwrap();
    let found = (unknown.record_error_metres(0, 0), unknown.record(0, 0, 0.0));
    assert_eq!(found, (None, None));
    let wrong = cache(&of_keys, Some(-1.0)).unwrap_err();
    assert_eq!(wrong.at, "steps[0][0].error_metres");
}

#[test]
fn levels_share_the_palettes_of_the_finest() {
    let rig = rig_of(&[(None, Vec3::ZERO, 0), (Some(0), Vec3::Y, 0)]);
    let clip = Clip::new("c", 4.0, 5, 2, Tracks::default()).unwrap();
    let mean = rig.rest_pose();
    let joint_lods = JointLods::new(&rig, vec![0, 1], vec![2, 1], mean).unwrap();
    let map = PaletteMap::joints(&joint_lods);
    let clips = ClipSet::new(&rig, joint_lods, &[clip], ClipStorage::Float).unwrap();
    let times = [0.0, 0.5, 1.0];
    // Three keys of two matrices, then three steps of two; the coarser level reads one of the two.
    let shared = [vec![keys(&times, 0), keys(&times, 0)]];
    let make = |rows| {
        PoseCache::new(&clips, &map, &shared, rows)?
            .with_steps(&clips, &[vec![steps(3, 6), steps(3, 6)]])
    };
    let cache = make(rows(12)).unwrap();
    for level in [0, 1] {
        let record = cache.locate(0, level, 0.75).unwrap();
        assert_eq!((record.before, record.after, record.blend), (2, 4, 0.5));
        assert_eq!(cache.nearest(0, level, 0.75), Some(10));
    }
    assert_eq!(cache.keys.len(), 4, "with the end, once for both");
    let mut out = [[0.0; 4]; 3];
    let at = cache.locate(0, 1, 0.5).unwrap();
    cache.blend(1, &[at], Backend::best(), PaletteRows::Float(&mut out));
    assert_eq!(out.map(|row| row[0]), [6.0, 7.0, 8.0], "matrix 2");
    assert_eq!(make(rows(11)).unwrap_err().at, "steps[0][0].first_matrix");
    // Palettes of its own lie without gaps.
    let own = [vec![keys(&times, 0), keys(&times, 6)]];
    let cache = PoseCache::new(&clips, &map, &own, rows(9)).unwrap();
    assert_eq!(cache.locate(0, 1, 0.75).unwrap().before, 7);
}

#[test]
fn validity_table() {
    let (clips, map) = parts();
    let at = |first, second, rows| {
        let all = [vec![first], vec![second]];
        PoseCache::new(&clips, &map, &all, rows)
            .map_err(|e| e.at)
            .err()
    };
    let single = || keys(&[0.0], 0);
    assert_eq!(at(None, None, rows(0)), None, "all are evaluated");
    assert_eq!(at(keys(&[0.0, 1.0], 0), single(), rows(2)), None);
    let times = [
        &[0.0][..],
        &[],
        &[0.1, 1.0],
        &[0.0, 0.5],
        &[0.0, 0.5, 0.5, 1.0],
        &[0.0, f32::NAN, 1.0],
    ];
    for times in times {
        let found = at(keys(times, 0), single(), rows(9));
        assert_eq!(found.as_deref(), Some("keys[0][0].times_secs"), "{times:?}");
    }
    let beyond = at(single().filter(|_| false), keys(&[0.0], 2), rows(2));
    assert_eq!(beyond.as_deref(), Some("keys[1][0].first_matrix"));
    let nan = single().map(|k| CachedKeys {
        error_metres: f32::NAN,
        ..k
    });
    assert_eq!(
        at(None, nan, rows(2)).as_deref(),
        Some("keys[1][0].error_metres")
    );
    let odd = CachedRows::Float(vec![[0.0; 4]; 4]);
    assert_eq!(at(None, None, odd).as_deref(), Some("rows"));
    let at = |all: &[Vec<Option<CachedKeys>>]| {
        PoseCache::new(&clips, &map, all, rows(1)).unwrap_err().at
    };
    assert_eq!(at(&[vec![None]]), "keys");
    assert_eq!(at(&[vec![None], vec![]]), "keys[1]");
}

//! ABP-2: what a stream shows, whole, cut and in pieces.

use crate::cut_streams::as_version_1;
use crate::small_human::{asset as figure, source};
use articula_build::Asset;
use articula_core::playback::{FigureModel, FigurePlayer, FigureViews, FullDetail};
use articula_core::{Clip, Mesh, ModelPose, PosedMesh, Rig, Wrap};
use articula_mutate::{Edit, Mutations};
use articula_stream::abp2::{
    CarriedSkeleton, EncodedMotion, Grouping, MotionOptions, MotionReceiver, UnitOrder, encode,
    motion_map, prefix_map,
};
use articula_stream::{CutRule, StreamLimits, Unit, cut, read_index, write_index};
use glam::{Quat, Vec3};
use std::collections::BTreeMap;
use std::path::Path;

fn coded(grouping: Grouping, order: UnitOrder) -> EncodedMotion {
    let Asset { rig, mesh, .. } = figure();
    let options = MotionOptions {
        grouping,
        order,
        access_unit_secs: 0.6,
        manifest: true,
        ..MotionOptions::default()
    };
    encode(rig, mesh, walk(), &options).unwrap()
}

fn walk() -> &'static Clip {
    figure()
        .clips
        .iter()
        .find(|clip| clip.name == "walk")
        .unwrap()
}

fn received(bytes: &[u8]) -> MotionReceiver {
    MotionReceiver::read(bytes, &figure().rig, &StreamLimits::default()).unwrap()
}

/// Greatest distance of the skin of two clips, at frames.
fn farthest(rig: &Rig, mesh: &Mesh, a: &Clip, b: &Clip, frames: std::ops::Range<usize>) -> f64 {
    let mut posed = [PosedMesh::new(rig, mesh), PosedMesh::new(rig, mesh)];
    let mut most = 0.0_f64;
    for frame in frames {
        let time = frame as f64 / f64::from(a.rate_hz());
        let [one, other] = &mut posed;
        let weights = &mesh.morph_weights;
        let one = one.pose_at(a, time, Wrap::Clamp).skinned(weights);
        let other = other.pose_at(b, time, Wrap::Clamp).skinned(weights);
        let pairs = one.positions.iter().zip(&other.positions);
        most = pairs
            .map(|(a, b)| f64::from(a.distance(*b)))
            .fold(most, f64::max);
    }
    most
}

fn error(bytes: &[u8]) -> f64 {
    let Asset { rig, mesh, .. } = figure();
    let shown = received(bytes).clip().unwrap();
    farthest(rig, mesh, walk(), &shown, 0..walk().frames())
}

#[test]
fn every_tier_keeps_its_tolerance_at_every_vertex() {
    for grouping in Grouping::ALL {
        let coded = coded(grouping, UnitOrder::Tier);
        let mut bytes = usize::MAX;
        for tier in 0..5 {
            let rule = CutRule::default().at_least("tier", tier);
            let part = cut(&coded.bytes, &coded.unit, |unit| rule.keeps(unit)).unwrap();
            let found = error(&part.bytes);
            let limit = 1e-4 * 3_f64.powi(tier as i32);
            assert!(
                found <= 1.01 * limit + 2e-7,
                "{grouping:?} tier {tier}: {found}"
            );
            let told = coded.errors[tier as usize].max_metres;
            assert!(
                (found - told).abs() < 1e-6,
                "tier {tier}: {found}, told {told}"
            );
            assert!(part.bytes.len() < bytes);
            bytes = part.bytes.len();
        }
    }
}

/// The units of an access unit by their markers, with their bytes.
fn units<'a>(stream: &'a [u8], map: &Unit) -> BTreeMap<Vec<u32>, &'a [u8]> {
    let mut units = BTreeMap::new();
    for access_unit in &map.children {
        for unit in &access_unit.children {
            if let Some(tier) = unit.marker("tier") {
                let of = |scheme| unit.marker(scheme).unwrap_or(u32::MAX);
                let number = access_unit.marker("access_unit").unwrap();
                let key = vec![number, of("loa"), of("region"), of("joint"), tier];
                let bytes = unit.bits.start as usize / 8..unit.bits.end as usize / 8;
                assert!(units.insert(key, &stream[bytes]).is_none());
            }
        }
    }
    units
}

#[test]
fn every_cut_decodes_and_keeps_its_units_as_they_are() {
    for grouping in Grouping::ALL {
        let coded = coded(grouping, UnitOrder::Tier);
        let all = units(&coded.bytes, &coded.unit);
        let joints: Vec<u32> = match grouping {
            Grouping::Joint => vec![0, 5, 40, 88, 999],
            _ => vec![999],
        };
        for loa in 0..=5 {
            for mask in [0b1111_1110, 0b0011_0000, 0b0000_1100, 0] {
                for tier in 0..=5 {
                    for joint in &joints {
                        let joint = *joint;
                        let body = CutRule::default().at_most("loa", loa);
                        let body = match grouping {
                            Grouping::Loa => body,
                            _ => body.in_mask("region", mask),
                        };
                        let keeps =
                            |unit: &Unit| body.keeps(unit) && unit.marker("joint") != Some(joint);
                        let tiers = CutRule::default().at_least("tier", tier);
                        let once = cut(&coded.bytes, &coded.unit, |unit| {
                            keeps(unit) && tiers.keeps(unit)
                        });
                        let once = once.unwrap();
                        let first = cut(&coded.bytes, &coded.unit, keeps).unwrap();
                        let twice = cut(&first.bytes, &first.unit, |unit| tiers.keeps(unit));
                        assert_eq!(twice.unwrap(), once);
                        let map = motion_map(&once.bytes, &StreamLimits::default()).unwrap();
                        assert_eq!(map, once.unit);
                        assert!(received(&once.bytes).is_whole());
                        let kept = units(&once.bytes, &once.unit);
                        assert!(kept.iter().all(|(key, bytes)| all[key] == *bytes));
                    }
                }
            }
        }
    }
}

#[test]
fn a_dropped_group_shows_its_reference_and_others_move_as_before() {
    let coded = coded(Grouping::LoaRegion, UnitOrder::Tier);
    let legs = CutRule::default().in_mask("region", 0b0111_0000);
    let part = cut(&coded.bytes, &coded.unit, |unit| legs.keeps(unit)).unwrap();
    let whole = received(&coded.bytes).clip().unwrap();
    let shown = received(&part.bytes).clip().unwrap();
    let articulation = figure().rig.articulation();
    let (mut kept, mut held) = (0, 0);
    for (a, b) in whole
        .tracks()
        .rotations
        .iter()
        .zip(&shown.tracks().rotations)
    {
        let region = 1 + articulation.joints[usize::from(a.target)].region as u32;
        if a.values.len() == 1 {
            continue;
        }
        if 0b0111_0000 >> region & 1 == 1 {
            assert_eq!(a, b);
            kept += 1;
        } else {
            assert!(b.values.iter().all(|q| *q == b.values[0]));
            held += 1;
        }
    }
    assert!(kept > 5 && held > 10, "{kept} kept, {held} held");
}

#[test]
fn every_prefix_decodes_to_what_the_manifest_says() {
    for order in [UnitOrder::Tier, UnitOrder::Value] {
        let coded = coded(Grouping::LoaRegion, order);
        let Asset { rig, mesh, .. } = figure();
        let mut part = MotionReceiver::new(rig, &StreamLimits::default());
        for (length, byte) in coded.bytes.iter().enumerate() {
            let clip = part.clip();
            assert!(!part.is_whole());
            assert_eq!(part.head().is_none(), clip.is_err());
            // In one piece, a prefix is the same.
            if length % 19 == 0 {
                assert_eq!(received(&coded.bytes[..length]).clip().ok(), clip.ok());
            }
            part.receive(&[*byte]).unwrap();
        }
        assert!(part.is_whole());
        let head = received(&coded.bytes).head().unwrap().clone();
        for row in coded.manifest.iter().step_by(7) {
            let part = received(&coded.bytes[..row.bytes]);
            let frames = head.frames_of(row.access_unit);
            assert_eq!(part.frames(), frames.end);
            let found = farthest(rig, mesh, walk(), &part.clip().unwrap(), frames);
            // The manifest measures some of the vertices.
            let told = row.error.max_metres;
            assert!(
                told <= found + 1e-6 && found < 1.3 * told,
                "{found}, told {told}"
            );
        }
        let last = coded.manifest.last().unwrap();
        assert_eq!(last.bytes, coded.bytes.len());
    }
}

#[test]
fn the_order_by_value_falls_faster() {
    let area = |order| {
        let coded = coded(Grouping::LoaRegion, order);
        let of_first = coded.manifest.iter().filter(|row| row.access_unit == 0);
        let rows: Vec<_> = of_first.collect();
        let mean = rows.windows(2).map(|pair| {
            let bytes = (pair[1].bytes - pair[0].bytes) as f64;
            pair[0].error.mean_metres * bytes
        });
        mean.sum::<f64>()
    };
    let (by_tier, by_value) = (area(UnitOrder::Tier), area(UnitOrder::Value));
    assert!(by_value < 0.9 * by_tier, "{by_value} of {by_tier}");
}

#[test]
fn pieces_of_any_length_make_the_same_clip() {
    let coded = coded(Grouping::Loa, UnitOrder::Tier);
    let whole = received(&coded.bytes);
    for size in [1, 7, 500] {
        let mut receiver = MotionReceiver::new(&figure().rig, &StreamLimits::default());
        let mut shown = 0;
        for piece in coded.bytes.chunks(size) {
            let changed = receiver.receive(piece).unwrap();
            assert!(changed.is_empty() || changed.end >= shown);
            shown = receiver.frames();
        }
        assert!(receiver.is_whole() && receiver.hash() == whole.hash());
        assert_eq!(receiver.clip(), whole.clip());
    }
}

#[test]
fn a_player_plays_what_has_arrived_and_refines_without_a_jump() {
    let Asset { rig, mesh, .. } = figure();
    let coded = coded(Grouping::LoaRegion, UnitOrder::Value);
    let mut receiver = MotionReceiver::new(rig, &StreamLimits::default());
    let mut pieces = coded.bytes.chunks(coded.bytes.len() / 12);
    while receiver.frames() == 0 {
        receiver.receive(pieces.next().unwrap()).unwrap();
    }
    let step = 1.0 / 60.0;
    let mut controller = FullDetail::default();
    let arrived = |receiver: &MotionReceiver| {
        let clip = receiver.clip().unwrap();
        FigureModel::new(rig.clone(), [clip]).unwrap()
    };
    let mut player = FigurePlayer::new(arrived(&receiver), &mesh.morph_weights);
    let mut before: Option<Vec<Vec3>> = None;
    let mut moved: f32 = 0.0;
    loop {
        for _ in 0..6 {
            player.advance(step, &mut |_| {});
            player.control(&mut controller, FigureViews::Cameras(&[]));
            player.hierarchy();
            let joints = (0..rig.len()).map(|j| player.model_pose().position(j));
            let joints: Vec<Vec3> = joints.collect();
            if let Some(before) = &before {
                let steps = joints.iter().zip(before).map(|(a, b)| a.distance(*b));
                moved = steps.fold(moved, f32::max);
            }
            before = Some(joints);
        }
        let Some(piece) = pieces.next() else {
            break;
        };
        receiver.receive(piece).unwrap();
        player.set_model(arrived(&receiver), 0.2).unwrap();
    }
    assert!(receiver.is_whole());
    // A joint of a walk moves at up to 6 m/s; frames that jumped to what arrives would show more.
    assert!((0.01..0.1).contains(&moved), "{moved} m in a frame");
    // After the time of the refinement, the whole stream is shown.
    player.advance(0.25, &mut |_| {});
    player.control(&mut controller, FigureViews::Cameras(&[]));
    player.hierarchy();
    let state = player.state().unwrap().clip_state();
    let mut posed = PosedMesh::new(rig, mesh);
    let whole = receiver.clip().unwrap();
    posed.pose_at(&whole, f64::from(state.secs()), Wrap::Loop);
    for joint in 0..rig.len() {
        let apart = posed
            .model
            .position(joint)
            .distance(player.model_pose().position(joint));
        assert!(apart < 1e-4, "joint {joint}: {apart} m");
    }
}

#[test]
fn a_stream_is_for_one_rig() {
    let coded = coded(Grouping::Loa, UnitOrder::Tier);
    let mut skeleton = source().skeleton.clone();
    skeleton.joints.truncate(80);
    let mut articulation = figure().rig.articulation().clone();
    articulation.joints.truncate(80);
    let shorter = Rig::new(&skeleton, articulation.clone()).unwrap();
    let refused = |rig: &Rig| {
        let read = MotionReceiver::read(&coded.bytes, rig, &StreamLimits::default());
        read.unwrap_err().to_string()
    };
    assert!(refused(&shorter).contains("89 joints"));
    let mut moved = figure().rig.articulation().clone();
    moved.joints.iter_mut().for_each(|joint| joint.level = 3);
    let same = Rig::new(&source().skeleton, moved).unwrap();
    assert!(refused(&same).contains("levels of articulation"));
}

/// The stored stream with its index: `walk.abp`, written from the reference human's walk, and
/// `walk.auix`.
fn golden(name: &str, made: &[u8]) -> Vec<u8> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/golden")
        .join(name);
    if std::env::var_os("ARTICULA_GOLDEN").is_some_and(|v| v == "renew") {
        std::fs::write(&path, made).unwrap();
    }
    std::fs::read(&path).unwrap()
}

#[test]
fn a_stored_stream_decodes_to_the_same_numbers() {
    let coded = coded(Grouping::Joint, UnitOrder::Tier);
    let stored = golden("walk.abp", &coded.bytes);
    let index = golden("walk.auix", &write_index(&coded.unit));
    assert_eq!(
        stored, coded.bytes,
        "the encoder has changed: run `cargo xtask golden`"
    );
    assert_eq!(read_index(&index).unwrap(), coded.unit);
    let hash = format!("{:016x}", received(&stored).hash());
    let told = golden("walk.hash", hash.as_bytes());
    assert_eq!(hash.as_bytes(), told);
}

#[test]
fn a_stored_stream_of_version_1_is_still_read() {
    // Written before there were checksums, of the same motion.
    let stored = include_bytes!("../golden/walk-1.abp");
    let read = received(stored);
    assert_eq!(read.head().unwrap().version, 1);
    let told = include_str!("../golden/walk.hash");
    assert!(read.is_whole() && format!("{:016x}", read.hash()) == told);
    let coded = coded(Grouping::Joint, UnitOrder::Tier);
    assert_eq!(read.clip(), received(&coded.bytes).clip());
    assert_eq!(as_version_1(&coded.bytes), stored);
    let limits = StreamLimits::default();
    let map = motion_map(stored, &limits).unwrap();
    map.check_values(stored).unwrap();
    let rule = CutRule::default().at_least("tier", 2);
    let part = cut(stored, &map, |unit| rule.keeps(unit)).unwrap();
    assert_eq!(motion_map(&part.bytes, &limits).unwrap(), part.unit);
    let of_new = cut(&coded.bytes, &coded.unit, |unit| rule.keeps(unit)).unwrap();
    assert_eq!(as_version_1(&of_new.bytes), part.bytes);
}

#[test]
fn hostile_streams_end_in_an_error_or_a_clip() {
    let mutations = Mutations {
        edits: &[
            Edit::SetByte,
            Edit::FlipBit,
            Edit::Truncate,
            Edit::Repeat(60),
            Edit::Delete(60),
        ],
        most: 3,
    };
    let limits = StreamLimits {
        bytes: 1 << 20,
        elements: 1 << 20,
    };
    for grouping in Grouping::ALL {
        let good = coded(grouping, UnitOrder::Tier).bytes;
        let read = |bytes: &[u8]| {
            if let Ok(map) = motion_map(bytes, &limits) {
                map.check().unwrap();
                map.check_values(bytes).unwrap();
            }
            let Ok(read) = MotionReceiver::read(bytes, &figure().rig, &limits) else {
                return false;
            };
            if let Ok(clip) = read.clip() {
                assert_eq!(clip.joints(), figure().rig.len());
            }
            true
        };
        mutations.read_of(&good, 300, read);
        // Without checksums more of the decoder sees damage.
        mutations.read_of(&as_version_1(&good), 700, read);
    }
}

#[test]
fn scales_and_morph_targets_are_coded() {
    use articula_core::{Morph, Track, Tracks};
    let Asset { rig, mesh, .. } = figure();
    // Two targets that move a third of the vertices each, and a head that swells.
    let morph = |slot: u16| Morph {
        slot,
        vertices: (0..mesh.len() as u32)
            .skip(usize::from(slot))
            .step_by(3)
            .collect(),
        positions: vec![Vec3::new(0.0, 0.02, 0.01); mesh.len().div_ceil(3)],
        normals: vec![Vec3::ZERO; mesh.len().div_ceil(3)],
    };
    let mut mesh = Mesh::clone(mesh);
    mesh.morphs = (0..2).map(morph).collect();
    mesh.morphs.iter_mut().for_each(|m| {
        m.positions.truncate(m.vertices.len());
        m.normals.truncate(m.vertices.len());
    });
    mesh.morph_weights = vec![0.0, 0.3];
    let head = rig.find("skullbase").unwrap();
    let frames = 40;
    let wave = |i: usize, speed: f32| (i as f32 * speed).sin();
    let track = |target, values| Track {
        target,
        step: false,
        values,
    };
    let tracks = Tracks {
        scales: vec![Track {
            target: head as u16,
            step: false,
            values: (0..frames)
                .map(|i| Vec3::splat(1.0 + 0.2 * wave(i, 0.3)))
                .collect(),
        }],
        morphs: vec![
            track(0, (0..frames).map(|i| 0.5 + 0.5 * wave(i, 0.2)).collect()),
            track(1, vec![0.0]),
        ],
        ..Tracks::default()
    };
    let clip = Clip::new("swell", 30.0, frames, rig.len(), tracks).unwrap();
    let coded = encode(rig, &mesh, &clip, &MotionOptions::default()).unwrap();
    let shown = received(&coded.bytes).clip().unwrap();
    let at = |clip: &Clip, frame: usize| {
        let mut weights = mesh.morph_weights.clone();
        articula_core::sample_morphs(clip, frame as f64 / 30.0, Wrap::Clamp, &mut weights);
        let mut posed = PosedMesh::new(rig, &mesh);
        posed
            .pose_at(clip, frame as f64 / 30.0, Wrap::Clamp)
            .skinned(&weights)
            .positions
    };
    for frame in 0..frames {
        let (a, b) = (at(&clip, frame), at(&shown, frame));
        let most = a
            .iter()
            .zip(&b)
            .map(|(a, b)| a.distance(*b))
            .fold(0.0, f32::max);
        assert!(most <= 1.01e-4, "frame {frame}: {most}");
    }
    assert_eq!(shown.tracks().morphs[1].values, [0.0]);
    let whole = shown.tracks().scales[0].values.len();
    assert_eq!(whole, frames);
}

#[test]
fn a_rig_without_a_mesh_and_a_clip_of_one_frame() {
    let Asset { rig, .. } = figure();
    let mesh = Mesh::default();
    let coded = encode(rig, &mesh, walk(), &MotionOptions::default()).unwrap();
    let shown = received(&coded.bytes).clip().unwrap();
    let (mut a, mut b) = (ModelPose::new(rig.len()), ModelPose::new(rig.len()));
    let mut posed = PosedMesh::new(rig, &mesh);
    for frame in 0..walk().frames() {
        let time = frame as f64 / f64::from(walk().rate_hz());
        a.matrices
            .clone_from(&posed.pose_at(walk(), time, Wrap::Clamp).model.matrices);
        b.matrices
            .clone_from(&posed.pose_at(&shown, time, Wrap::Clamp).model.matrices);
        for joint in 0..rig.len() {
            assert!(a.position(joint).distance(b.position(joint)) < 1.01e-4);
        }
    }
    let still = articula_core::Tracks {
        rotations: vec![articula_core::Track {
            target: 0,
            step: false,
            values: vec![Quat::from_rotation_y(0.7)],
        }],
        ..articula_core::Tracks::default()
    };
    let still = Clip::new("still", 24.0, 1, rig.len(), still).unwrap();
    let coded = encode(rig, &mesh, &still, &MotionOptions::default()).unwrap();
    let shown = received(&coded.bytes);
    assert!(shown.is_whole() && shown.frames() == 1);
    let turn = shown.clip().unwrap().tracks().rotations[0].values[0];
    assert!(turn.angle_between(Quat::from_rotation_y(0.7)) < 1e-3);
}

#[test]
fn a_prefix_maps_what_is_there_as_a_whole() {
    let limits = StreamLimits::default();
    let coded = coded(Grouping::Loa, UnitOrder::Tier);
    let ends = coded
        .unit
        .children
        .iter()
        .map(|unit| unit.bits.end as usize / 8);
    let ends: Vec<usize> = ends.collect();
    assert!(ends.len() > 2);
    for length in 0..=coded.bytes.len() {
        let part = prefix_map(&coded.bytes[..length], &limits);
        let whole = ends.iter().filter(|end| **end <= length).count();
        match whole {
            0 => assert!(part.is_err()),
            _ => assert_eq!(part.unwrap().children, coded.unit.children[..whole]),
        }
    }
    assert_eq!(prefix_map(&coded.bytes, &limits).unwrap(), coded.unit);
    let longer = [&coded.bytes[..], &[0]].concat();
    assert!(prefix_map(&longer, &limits).is_err());
}

#[test]
fn the_coarsest_units_are_one_range_of_bytes() {
    for order in [UnitOrder::Tier, UnitOrder::Value] {
        let coded = coded(Grouping::LoaRegion, order);
        for access_unit in &coded.unit.children[1..] {
            let tiers = access_unit
                .children
                .iter()
                .filter_map(|unit| unit.marker("tier"));
            let tiers: Vec<u32> = tiers.collect();
            let base = tiers.iter().take_while(|tier| **tier == 4).count();
            assert!(base > 3 && !tiers[base..].contains(&4), "{tiers:?}");
        }
    }
}

#[test]
fn access_units_have_at_most_a_second() {
    let Asset { rig, mesh, .. } = figure();
    let coded = encode(rig, mesh, walk(), &MotionOptions::default()).unwrap();
    let head = received(&coded.bytes).head().unwrap().clone();
    assert!(head.access_units > 0);
    for access_unit in 0..head.access_units {
        let frames = head.frames_of(access_unit).len();
        assert!(frames as f64 <= f64::from(head.rate_hz));
    }
}

#[test]
fn a_carried_skeleton_is_that_of_the_rig() {
    let Asset { rig, mesh, .. } = figure();
    let options = MotionOptions {
        skeleton: true,
        ..MotionOptions::default()
    };
    let with = encode(rig, mesh, walk(), &options).unwrap();
    let without = encode(rig, mesh, walk(), &MotionOptions::default()).unwrap();
    let limits = StreamLimits::default();
    assert_eq!(CarriedSkeleton::open(&without.bytes, &limits), Ok(None));
    let carried = CarriedSkeleton::open(&with.bytes, &limits)
        .unwrap()
        .unwrap();
    assert_eq!(carried.skeleton, source().skeleton);
    let own = Rig::new(&carried.skeleton, carried.articulation).unwrap();
    for (a, b) in own
        .articulation()
        .joints
        .iter()
        .zip(&rig.articulation().joints)
    {
        assert_eq!((a.level, a.region), (b.level, b.region));
    }
    let shown = MotionReceiver::read(&with.bytes, &own, &limits).unwrap();
    assert_eq!(shown.clip(), received(&without.bytes).clip());
    // What remains when the skeleton is cut away is the stream without it.
    let cut = cut(&with.bytes, &with.unit, |unit| unit.label != "skeleton").unwrap();
    assert!(cut.bytes == without.bytes && cut.unit == without.unit);
}

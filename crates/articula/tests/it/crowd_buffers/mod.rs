//! The bytes of a crowd's buffers are those that `docs/formats/crowd-buffers.md` defines.
//!
//! They lie in `tests/golden/crowd` for each form, with the poses of the plain path beside them. That
//! the bytes show these poses is checked by `oracle/crowd_buffers.test.mjs`, which knows the page alone.

mod expected;
mod figure;

use articula::Executor;
use articula::crowd::{
    CacheUse, Camera, CrowdAsset, CrowdBuffers, CrowdOptions, CrowdPlayer, Detail, JointLodMethod,
    PaletteForm, PaletteMatrices, Viewport,
};
use articula_core::crowd::{CharacterState, ClipState, DrawKind};
use expected::{Member, Shown, expected, is_near};
use figure::figure;
use glam::Vec3;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Folder, form and use of the cache.
const FRAMES: [(&str, PaletteForm, CacheUse); 6] = [
    ("matrix", PaletteForm::Matrix, CacheUse::Gpu),
    ("half", PaletteForm::HalfMatrix, CacheUse::Gpu),
    ("rigid", PaletteForm::Rigid, CacheUse::Gpu),
    ("half-rigid", PaletteForm::HalfRigid, CacheUse::Gpu),
    ("matrix-stepped", PaletteForm::Matrix, CacheUse::Cpu),
    ("half-stepped", PaletteForm::HalfMatrix, CacheUse::Cpu),
];

fn member(x: f32, z: f32, shows: (usize, f32), level: Option<usize>) -> Member {
    Member {
        position: Vec3::new(x, 0.0, z),
        yaw_radians: 0.3 * x,
        scale: 1.0,
        shows,
        fades_to: None,
        level,
    }
}

/// Characters near and far, in one clip and between two, at a key, hidden.
fn members() -> Vec<Member> {
    let mut members = vec![
        member(-1.0, 0.0, (0, 0.3), Some(0)),
        member(0.0, 0.0, (0, 0.4), Some(0)),
        member(-30.0, -400.0, (0, 0.554), Some(1)),
        member(10.0, -400.0, (1, 0.2), Some(1)),
        member(0.0, 40.0, (0, 0.1), None),
        member(40.0, -400.0, (1, 0.0), Some(1)),
        member(1.5, -1.0, (1, 0.3), Some(0)),
    ];
    members[1].fades_to = Some((1, 0.15, 0.375));
    members[3].fades_to = Some((0, 0.7, 0.75));
    members[6].scale = 1.5;
    members
}

fn played((form, cache): (PaletteForm, CacheUse)) -> CrowdPlayer {
    let kept = figure::KEPT.map(|name| format!("joint({name})"));
    let options = CrowdOptions {
        joints: JointLodMethod::Named(kept.join(" + ").parse().unwrap()),
        pose_cache: true,
        form,
        ..CrowdOptions::default()
    };
    let asset = CrowdAsset::from_asset(figure().asset, &options, &Executor::default()).unwrap();
    let members = members();
    let mut player = CrowdPlayer::new(&asset, members.len()).unwrap();
    player.detail = Detail::Tolerance { px: 2.0 };
    player.cache = cache;
    let clips = &asset.model().parts().clips;
    for (c, member) in members.iter().enumerate() {
        player.place(c, member.position, member.yaw_radians);
        if member.scale != 1.0 {
            player.set_scale(c, member.scale);
        }
        let state = |clip, secs| ClipState::new(clips, clip).at_secs(clips, secs);
        let shows = state(member.shows.0, member.shows.1);
        let shows = match member.fades_to {
            Some((clip, secs, weight)) => CharacterState::blend(shows, state(clip, secs), weight),
            None => shows.into(),
        };
        player.crowd_mut().play(c, shows);
    }
    let camera = Camera::looking_at(Vec3::new(0.0, 1.0, 6.0), Vec3::Y, Viewport::default());
    player.frame(0.0, &camera);
    player
}

fn golden(form: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/golden/crowd")
        .join(form)
}

fn is_renewed() -> bool {
    std::env::var_os("ARTICULA_GOLDEN").is_some_and(|v| v == "renew")
}

#[test]
fn bytes_are_the_golden_ones() {
    for (name, form, cache) in FRAMES {
        let buffers = CrowdBuffers::new(&played((form, cache))).unwrap();
        for (file, bytes) in buffers.files().unwrap() {
            let path = golden(name).join(file);
            if is_renewed() {
                std::fs::create_dir_all(golden(name)).unwrap();
                std::fs::write(&path, &bytes).unwrap();
            }
            let stored = std::fs::read(&path).unwrap();
            assert!(stored == bytes, "{name}/{file} has other bytes");
        }
    }
}

#[test]
fn expected_poses_are_those_of_the_plain_path() {
    for (name, form, cache_use) in FRAMES {
        let player = played((form, cache_use));
        let members = members();
        for (c, member) in members.iter().enumerate() {
            assert_eq!(
                player.crowd().level(c),
                member.level,
                "{name}: character {c}"
            );
        }
        let cache = player.asset().model().parts().cache.as_ref();
        assert_eq!(cache.is_some(), !form.is_rigid());
        let list = player.crowd().draw_list();
        let shown = Shown {
            cache,
            is_by_gpu: cache_use == CacheUse::Gpu,
            recorded: list.characters(DrawKind::Record),
            stepped: list.characters(DrawKind::Step),
        };
        let made = expected(&figure(), &members, shown);
        let path = golden(name).join("expected.json");
        if is_renewed() {
            let text = made
                .to_string()
                .replace("{\"character\"", "\n{\"character\"");
            std::fs::write(&path, text + "\n").unwrap();
        }
        let stored = std::fs::read(&path).unwrap();
        let stored: Value = serde_json::from_slice(&stored).unwrap();
        assert!(is_near(&made, &stored), "{name}/expected.json differs");
    }
}

#[test]
fn both_levels_have_draws_and_cached_poses() {
    for (name, form, cache) in FRAMES {
        let manifest = CrowdBuffers::new(&played((form, cache))).unwrap().manifest;
        let levels = |groups: &[articula::crowd::GroupManifest]| -> Vec<(usize, usize)> {
            groups.iter().map(|g| (g.level, g.count)).collect()
        };
        let found = [&manifest.draws, &manifest.records, &manifest.stepped];
        let found = found.map(|list| levels(&list.groups));
        // One clip is too fast to be blended from keys at level 0, as the CPU does, but not from equal parts.
        let expected = match (form.is_rigid(), cache) {
            (true, _) => [vec![(0, 3), (1, 3)], vec![], vec![]],
            (_, CacheUse::Gpu) => [vec![(0, 1), (1, 1)], vec![(0, 2), (1, 2)], vec![]],
            // The rounding of halves is too much for a step of the near one, which the CPU blends.
            _ if name == "half-stepped" => [vec![(0, 3), (1, 1)], vec![], vec![(1, 2)]],
            _ => [vec![(0, 2), (1, 1)], vec![], vec![(0, 1), (1, 2)]],
        };
        assert_eq!(found, expected, "{name}");
        let matrices: Vec<usize> = manifest.levels.iter().map(|l| l.matrices).collect();
        assert_eq!(
            (manifest.entries.len(), matrices),
            (8, vec![8, 4]),
            "{name}"
        );
        // The other one at level 0 plays the clip in which the face rests.
        assert_eq!(
            manifest.draws.with_morph_sets
                + manifest.records.with_morph_sets
                + manifest.stepped.with_morph_sets,
            2
        );
    }
}

#[test]
fn palettes_of_joints_are_refused() {
    let options = CrowdOptions {
        matrices: PaletteMatrices::Joints,
        ..CrowdOptions::default()
    };
    let asset = CrowdAsset::from_asset(figure().asset, &options, &Executor::default()).unwrap();
    let player = CrowdPlayer::new(&asset, 1).unwrap();
    let why = CrowdBuffers::new(&player).unwrap_err();
    assert!(why.to_string().contains("palettes of the skin"), "{why}");
}

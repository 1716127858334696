//! Scenes that say who matters and what hides whom.

use crate::crowd::{asset_of, human, human_asset};
use articula::crowd::{
    CacheUse, Camera, CharacterEntry, CrowdAsset, CrowdEvent, CrowdOptions, CrowdPlayer, Culling,
    DetailGoal, Hiders, ParsedScene, SceneOptions, ScenePlayer, View, Viewport, write_scene,
};
use articula_build::Scene;
use glam::Vec3;
use std::fmt::Write as _;
use std::sync::Arc;

/// Reads a scene with the characters that are open already.
pub(crate) fn read_scene(
    bytes: &[u8],
    characters: &[CharacterEntry<'_>],
    display_hz: f64,
) -> articula::Result<Scene> {
    ParsedScene::parse(bytes)?.resolve(characters, display_hz)
}

const OPTIONS: SceneOptions = SceneOptions {
    detail: DetailGoal::Tolerance(1.0),
    cache: CacheUse::Never,
    hiders: Hiders::Walls,
};

/// A cast of one.
fn cast(asset: &CrowdAsset) -> CharacterEntry<'_> {
    CharacterEntry {
        name: "human",
        file: None,
        clips: asset.clips(),
    }
}

/// A camera at the origin that looks along -Z, and characters in rows before it.
fn scene_of(asset: &CrowdAsset, more: &str, places: &[[f32; 2]], member: &str) -> Arc<Scene> {
    let clip = &asset.clips()[0].name;
    let mut text = format!(
        r#"{{"camera": [{{"t": 0, "eye": [0, 1.2, 0], "target": [0, 1.2, -1]}}], {more} "members": ["#
    );
    for (i, [x, z]) in places.iter().enumerate() {
        let comma = if i > 0 { "," } else { "" };
        let place = format!(r#""position": [{x}, 0, {z}], "phase": 0.{i}"#);
        write!(text, r#"{comma}{{{place}, "clip": "{clip}"{member}}}"#).unwrap();
    }
    text.push_str("]}");
    read_scene(text.as_bytes(), &[cast(asset)], 60.0)
        .unwrap()
        .into()
}

/// Levels of the characters after some frames.
fn levels(player: &mut ScenePlayer, count: usize, frames: usize) -> Vec<Option<usize>> {
    for _ in 0..frames {
        player.plan(1.0 / 60.0).unwrap();
        player.crowds_mut()[0].evaluate();
    }
    let crowd = player.crowds()[0].crowd();
    (0..count).map(|c| crowd.level(c)).collect()
}

#[test]
fn who_stands_behind_a_wall_costs_nothing_and_keeps_time() {
    let asset = human_asset();
    let places = [[0.0, -10.0], [1.0, -14.0], [8.0, -10.0], [0.0, -4.0]];
    let wall = r#""walls": [{"centre": [0, 2, -6], "size": [6, 4, 0.2]}],"#;
    let open = scene_of(asset, "", &places, "");
    let walled = scene_of(asset, wall, &places, "");
    let heroes = scene_of(asset, wall, &places, r#", "role": "main""#);
    let mut open_player =
        ScenePlayer::new(std::slice::from_ref(asset), open.clone(), OPTIONS).unwrap();
    let mut player =
        ScenePlayer::new(std::slice::from_ref(asset), walled.clone(), OPTIONS).unwrap();
    let all = levels(&mut open_player, 4, 90);
    let seen = levels(&mut player, 4, 90);
    assert!(all.iter().all(Option::is_some), "{all:?}");
    assert_eq!(seen, [None, None, all[2], all[3]]);
    assert_eq!((open_player.hidden(), player.hidden()), (0, 2));
    for character in 0..4 {
        let state = |p: &ScenePlayer| p.crowds()[0].crowd().state(character);
        assert_eq!(state(&player), state(&open_player), "{character}");
    }
    let mut heroes = ScenePlayer::new(std::slice::from_ref(asset), heroes, OPTIONS).unwrap();
    assert_eq!(levels(&mut heroes, 4, 90)[..2], [None, None]);
    // Without hiders the walls are not drawn.
    let nothing = SceneOptions {
        hiders: Hiders::Nothing,
        ..OPTIONS
    };
    let mut player = ScenePlayer::new(std::slice::from_ref(asset), walled, nothing).unwrap();
    assert_eq!(
        levels(&mut player, 4, 1),
        levels(
            &mut ScenePlayer::new(std::slice::from_ref(asset), open, OPTIONS).unwrap(),
            4,
            1
        )
    );
}

#[test]
fn a_crowd_hides_who_stands_behind_it() {
    let asset = human_asset();
    // A row of broad backs close to the camera, and one far behind its middle.
    let mut places: Vec<[f32; 2]> = (0..9).map(|i| [0.15 * (i as f32 - 4.0), -2.0]).collect();
    places.push([0.0, -60.0]);
    let scene = scene_of(asset, "", &places, "");
    let everything = SceneOptions {
        hiders: Hiders::Everything,
        ..OPTIONS
    };
    let mut player = ScenePlayer::new(std::slice::from_ref(asset), scene, everything).unwrap();
    let seen = levels(&mut player, places.len(), 2);
    assert_eq!(seen[9], None, "{seen:?}");
    assert!(seen[..9].iter().all(Option::is_some), "{seen:?}");
}

#[test]
fn roles_change_the_tolerance_and_change_by_cue() {
    let asset = human_asset();
    let places = [[0.0, -30.0], [2.0, -30.0]];
    let more = r#""roles": {"extra": 0.25}, "cues": [
        {"t": 0.5, "role": "main", "members": [1]},
        {"t": 1.0, "role": null, "members": [1]}],"#;
    let scene = scene_of(asset, more, &places, r#", "role": "extra""#);
    let neutral = scene_of(asset, "", &places, "");
    let mut player = ScenePlayer::new(std::slice::from_ref(asset), scene, OPTIONS).unwrap();
    let mut plain = ScenePlayer::new(std::slice::from_ref(asset), neutral, OPTIONS).unwrap();
    let usual = levels(&mut plain, 2, 10)[0];
    let extra = levels(&mut player, 2, 10);
    assert!(extra[1] > usual, "{extra:?} against {usual:?}");
    assert_eq!(player.crowds()[0].importance(1), 0.25);
    let hero = levels(&mut player, 2, 30);
    assert_eq!(hero[0], extra[0], "who has no cue keeps its role");
    assert!(hero[1] < usual, "{hero:?} against {usual:?}");
    assert_eq!(
        player.scene().importance.roles[player.role(1).unwrap()].name,
        "main"
    );
    levels(&mut player, 2, 30);
    assert_eq!(
        (player.role(1), player.crowds()[0].importance(1)),
        (None, 1.0)
    );
}

#[test]
fn scenes_with_roles_are_written_as_they_were_read() {
    let asset = human_asset();
    let clip = &asset.clips()[0].name;
    let more = format!(
        r#""roles": {{"king": 8}}, "clip_importance": {{"{clip}": 2}},
        "zones": [{{"min": [-1, -12], "max": [1, -8], "importance": 3}}],
        "walls": [{{"centre": [0, 2, -6], "size": [6, 4, 0.5], "yaw_deg": 45}}],
        "cues": [{{"t": 0.5, "role": "audience", "members": [0]}}, {{"t": 1, "role": null, "members": [0, 1]}}],"#
    );
    let places = [[0.0, -10.0], [3.0, -10.0]];
    let scene = scene_of(asset, &more, &places, r#", "role": "king""#);
    let again = read_scene(&write_scene(&scene, &[cast(asset)]), &[cast(asset)], 60.0).unwrap();
    assert_eq!(again.importance, scene.importance);
    assert_eq!(again.members, scene.members);
    let wall = again.walls[0];
    assert!((wall.yaw_radians - scene.walls[0].yaw_radians).abs() < 1e-6);
    let player = ScenePlayer::new(std::slice::from_ref(asset), scene, OPTIONS).unwrap();
    let importance = [0, 1].map(|c| player.crowds()[0].importance(c));
    assert_eq!(importance, [8.0 * 3.0 * 2.0, 8.0 * 2.0]);
}

#[test]
fn mistakes_in_roles_are_named_with_their_place() {
    let asset = human_asset();
    let clip = &asset.clips()[0].name;
    let camera = r#""camera": [{"t": 0, "eye": [0, 1, 5], "target": [0, 1, 0]}]"#;
    let why = |more: &str, role: &str| {
        let member = format!(r#"{{"position": [0, 0, 0], "clip": "{clip}"{role}}}"#);
        let text = format!(r#"{{{camera}, {more} "members": [{member}]}}"#);
        let read = read_scene(text.as_bytes(), &[cast(asset)], 60.0);
        read.unwrap_err().to_string()
    };
    for (more, role, says) in [
        (r#""roles": {"king": 0},"#, "", "roles: king: importance"),
        ("", r#", "role": "queen""#, "members[0]: role"),
        (r#""clip_importance": {"fly": 2},"#, "", "clip_importance"),
        (
            r#""zones": [{"min": [1, 0], "max": [0, 1], "importance": 1}],"#,
            "",
            "zones[0]: min",
        ),
        (
            r#""walls": [{"centre": [0, 0, 0], "size": [1, 0, 1]}],"#,
            "",
            "walls[0]: size",
        ),
        (
            r#""cues": [{"t": -1, "role": null, "members": [0]}],"#,
            "",
            "cues[0]: t",
        ),
        (
            r#""cues": [{"t": 1, "role": null, "members": [1]}],"#,
            "",
            "cues[0]: members",
        ),
        (
            r#""cues": [{"t": 1, "role": null, "members": []}, {"t": 0.5, "role": null, "members": []}],"#,
            "",
            "cues[1]: t",
        ),
        (
            r#""cues": [{"t": 1, "role": "queen", "members": [0]}],"#,
            "",
            "cues[0]",
        ),
    ] {
        let found = why(more, role);
        assert!(found.contains(says), "{more}{role}: {found}");
    }
}

/// A change of importance moves no vertex of a character that is drawn before and after farther than its event says, in the measure of errors: the
/// 95th percentile over vertices, and half of the maximum.
#[test]
fn a_change_of_role_jumps_no_farther_than_told() {
    let options = CrowdOptions {
        pose_cache: true,
        ..CrowdOptions::default()
    };
    let asset = asset_of(human(), &options);
    let mut crowd = CrowdPlayer::new(&asset, 40).unwrap();
    for c in 0..40 {
        let place = Vec3::new((c % 8) as f32 - 3.5, 0.0, -6.0 - (c / 8) as f32 * 9.0);
        crowd.place(c, place, c as f32);
        crowd.play(c, c % asset.clips().len(), 0.07 * c as f32);
    }
    let eye = Vec3::new(0.0, 1.5, 0.0);
    let camera = Camera::looking_at(eye, eye - Vec3::Z, Viewport::default());
    let mut told = 0;
    for importance in [1.0, 8.0, 0.25, 1.0] {
        let shown = |crowd: &CrowdPlayer, c: usize| {
            let (mesh, skinned) = crowd.skinned(c)?;
            let mut is_drawn = vec![false; skinned.positions.len()];
            let corners = mesh.triangles.iter().flatten();
            corners.for_each(|v| is_drawn[*v as usize] = true);
            Some((is_drawn, skinned.positions))
        };
        let before: Vec<_> = (0..40).map(|c| shown(&crowd, c)).collect();
        for c in 0..40 {
            crowd.set_importance(c, importance);
        }
        let (mut events, views) = (Vec::new(), [View::of(&camera)]);
        crowd.plan(0.0, Culling::Views(&views), &mut |event| events.push(event));
        crowd.evaluate();
        for event in events {
            let CrowdEvent::Level {
                character,
                from: Some(_),
                to: Some(_),
                jump_px,
            } = event
            else {
                continue;
            };
            let (is_drawn, after) = shown(&crowd, character).unwrap();
            let (was_drawn, before) = before[character].as_ref().unwrap();
            let span = crowd.crowd().cull_result(character).pixels_per_metre;
            // A vertex that a level does not draw is where nobody sees it.
            let in_both = (0..after.len()).filter(|v| was_drawn[*v] && is_drawn[*v]);
            let mut apart: Vec<f32> = in_both
                .map(|v| before[v].distance(after[v]) * span)
                .collect();
            apart.sort_by(f32::total_cmp);
            let (p95, worst) = (apart[apart.len() * 95 / 100], apart[apart.len() - 1]);
            assert!(
                p95.max(0.5 * worst) <= jump_px * 1.01,
                "{character}: {p95}, {worst} of {jump_px}"
            );
            told += 1;
        }
    }
    assert!(told > 40, "{told} changes");
}

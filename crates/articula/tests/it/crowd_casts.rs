//! Scenes with several characters and several views.

use crate::crowd::{asset_of, human};
use crate::crowd_roles::read_scene;
use articula::crowd::{
    Budget, CacheUse, CharacterEntry, CrowdAsset, CrowdOptions, CrowdPlayer, DetailGoal, Hiders,
    ParsedScene, SceneOptions, ScenePlayer, write_scene,
};
use articula_build::{Plaza, Scene, plaza};
use std::sync::{Arc, OnceLock};

const OPTIONS: SceneOptions = SceneOptions {
    detail: DetailGoal::Tolerance(1.0),
    cache: CacheUse::Cpu,
    hiders: Hiders::Walls,
};

/// A cast of two: our human with all its clips, and with two of them, in fewer levels.
fn cast() -> &'static [CrowdAsset] {
    static CAST: OnceLock<Vec<CrowdAsset>> = OnceLock::new();
    CAST.get_or_init(make_cast)
}

fn make_cast() -> Vec<CrowdAsset> {
    let all = asset_of(human(), &CrowdOptions::default());
    let two = all.clips().iter().take(2).map(|c| c.name.clone()).collect();
    let few = CrowdOptions {
        clips: two,
        pose_cache: true,
        ..CrowdOptions::default()
    };
    vec![all, asset_of(human(), &few)]
}

fn members<'a>(cast: &'a [CrowdAsset], names: &[&'a str]) -> Vec<CharacterEntry<'a>> {
    let each = cast.iter().zip(names);
    each.map(|(asset, name)| CharacterEntry {
        name,
        file: None,
        clips: asset.clips(),
    })
    .collect()
}

fn clips(cast: &[CrowdAsset]) -> Vec<usize> {
    cast.iter().map(|asset| asset.clips().len()).collect()
}

/// The members of one character of a scene, as a scene of a cast of one.
fn alone(scene: &Scene, character: u16) -> Scene {
    let own = scene.members.iter().filter(|m| m.character == character);
    let own = own.map(|m| articula_build::SceneCharacter { character: 0, ..*m });
    Scene {
        members: own.collect(),
        ..scene.clone()
    }
}

#[test]
fn each_character_of_a_cast_is_played_as_it_would_be_alone() {
    let cast = cast();
    let scene = plaza(60, &clips(cast), 3, Plaza::Moving);
    let scene = Arc::new(scene);
    let mut both = ScenePlayer::new(cast, scene.clone(), OPTIONS).unwrap();
    let mut each = [0, 1].map(|c| {
        let half = alone(&scene, c as u16);
        ScenePlayer::new(&cast[c..=c], half, OPTIONS).unwrap()
    });
    for _ in 0..90 {
        let together = both.plan(1.0 / 60.0).unwrap();
        both.crowds_mut().iter_mut().for_each(|c| c.evaluate());
        let mut apart = articula::crowd::CrowdReport::default();
        for one in &mut each {
            apart = apart.and(one.plan(1.0 / 60.0).unwrap());
            one.crowds_mut()[0].evaluate();
        }
        assert_eq!(together, apart);
    }
    assert!(both.crowds().iter().all(|c| c.positions().len() > 15));
    for (c, one) in each.iter().enumerate() {
        let (crowd, lone) = (&both.crowds()[c], &one.crowds()[0]);
        assert_eq!(crowd.palettes(), lone.palettes());
        for character in 0..crowd.positions().len() {
            let member = both.member(c, character);
            assert_eq!(both.place(member), (c, character));
            assert_eq!(crowd.positions()[character], scene.members[member].position);
            assert_eq!(
                crowd.crowd().level(character),
                lone.crowd().level(character)
            );
        }
    }
}

/// A session of a server or a component of an engine holds crowds from frame to frame.
#[test]
fn players_of_crowds_and_scenes_borrow_nothing() {
    fn is_owned<T: Send + Sync + 'static>() {}
    is_owned::<CrowdAsset>();
    is_owned::<CrowdPlayer>();
    is_owned::<ScenePlayer>();
}

#[test]
fn a_character_that_nobody_plays_changes_nothing() {
    let cast = cast();
    let scene = plaza(9, &clips(&cast[..1]), 3, Plaza::Still);
    let scene = Arc::new(scene);
    let mut with = ScenePlayer::new(cast, scene.clone(), OPTIONS).unwrap();
    let mut without = ScenePlayer::new(&cast[..1], scene, OPTIONS).unwrap();
    for _ in 0..3 {
        assert_eq!(with.plan(0.1).unwrap(), without.plan(0.1).unwrap());
        with.crowds_mut().iter_mut().for_each(|c| c.evaluate());
        without.crowds_mut()[0].evaluate();
    }
    assert_eq!(with.crowds()[0].palettes(), without.crowds()[0].palettes());
    let stray = plaza(9, &[1, 1], 3, Plaza::Still);
    let why = ScenePlayer::new(&cast[..1], stray, OPTIONS).unwrap_err();
    assert!(why.to_string().contains("of a cast of 1"), "{why}");
}

/// Three in a row along -Z, the farthest close to a second camera that looks back; a wall stands before
/// the others.
fn two_views(clip: &str, more: &str) -> String {
    let member = |z: f32| format!(r#"{{"position": [0, 0, {z}], "clip": "{clip}"}}"#);
    format!(
        r#"{{"camera": [{{"t": 0, "eye": [0, 1.2, 0], "target": [0, 1.2, -1]}}], {more}
        "walls": [{{"centre": [0, 1, -35], "size": [30, 8, 0.5]}}],
        "members": [{}, {}, {}]}}"#,
        member(-30.0),
        member(-40.0),
        member(-60.0)
    )
}

#[test]
fn what_one_of_two_views_sees_is_shown_as_the_nearer_one_needs() {
    let cast = &cast()[..1];
    let names = members(cast, &["human"]);
    let clip = &cast[0].clips()[0].name;
    let back = r#""views": [{"viewport": [960, 540],
        "camera": [{"t": 0, "eye": [0, 1.2, -64], "target": [0, 1.2, -60]}]}],"#;
    let one = read_scene(two_views(clip, "").as_bytes(), &names, 60.0).unwrap();
    let two = read_scene(two_views(clip, back).as_bytes(), &names, 60.0).unwrap();
    assert_eq!((one.views.len(), two.views.len()), (1, 2));
    let levels = |scene: &Scene| {
        let mut player = ScenePlayer::new(cast, scene.clone(), OPTIONS).unwrap();
        player.plan(0.0).unwrap();
        let crowd = player.crowds()[0].crowd();
        ([0, 1, 2].map(|c| crowd.level(c)), player.hidden())
    };
    let (front, hidden) = levels(&one);
    assert_eq!(
        (front[1], front[2], hidden),
        (None, None, 2),
        "behind the wall"
    );
    let (both, hidden) = levels(&two);
    assert_eq!(both[0], front[0], "behind the wall of the other view");
    assert!(
        both[2] < both[1] && both[1].is_some(),
        "4 m and 24 m away: {both:?}"
    );
    assert_eq!(hidden, 0);
}

#[test]
fn one_budget_serves_all_characters() {
    let cast = cast();
    let scene = plaza(200, &clips(cast), 3, Plaza::Still);
    let detail = DetailGoal::Budget {
        ms: 1.0,
        cap_px: 1.0,
    };
    let mut player = ScenePlayer::new(cast, scene, SceneOptions { detail, ..OPTIONS }).unwrap();
    let demand_ns = |player: &mut ScenePlayer, limit_ns: f64| {
        let mut budget = Budget::new(limit_ns, 1.0);
        let mut last = None;
        for _ in 0..40 {
            player.allow(budget.allowance());
            let report = player.plan(1.0 / 60.0).unwrap();
            player.add_to(&mut budget);
            let found = budget.observe(1.0, 100.0 * report.work.matrices as f64 + 1.0);
            last = Some((report.work.matrices, found.shown.px));
        }
        last.unwrap()
    };
    let (all, fine) = demand_ns(&mut player, 1e9);
    let (half, coarse) = demand_ns(&mut player, 50.0 * all as f64);
    assert!(coarse > fine, "{coarse} px, {fine} px");
    assert!(half * 10 < all * 6, "{half} matrices of {all}");
    // Neither of the two pays for the other: both are within the same tolerance.
    let bounds = player.crowds().iter().map(|c| {
        let shown = (0..c.positions().len()).filter_map(|i| {
            let level = c.crowd().level(i)?;
            let clip = c.crowd().state(i).clip_state().clip();
            let metres = c.asset().model().error_metres(clip, clip, level);
            Some(metres * c.crowd().cull_result(i).pixels_per_metre)
        });
        shown.fold(0.0, f32::max)
    });
    let bounds: Vec<f32> = bounds.collect();
    assert!(
        bounds.iter().all(|px| *px <= coarse * 1.25 && *px > fine),
        "{bounds:?}"
    );
}

#[test]
fn casts_and_views_are_written_as_they_were_read() {
    let cast = cast();
    let clip = &cast[1].clips()[1].name;
    let text = format!(
        r#"{{"characters": [{{"name": "king", "file": "king.glb"}}, {{"name": "man", "file": "../man.glb"}}],
        "camera": [{{"t": 0, "eye": [0, 1.2, 9], "target": [0, 1.2, 0]}}],
        "views": [{{"viewport": [640, 480], "fov_deg": 60, "camera_loops": true,
                    "camera": [{{"t": 0, "eye": [9, 1, 0], "target": [0, 1, 0]}}]}}],
        "clip_importance": {{"{clip}": 2}},
        "members": [{{"character": "man", "position": [0, 0, 0], "clip": "{clip}"}},
                    {{"character": "king", "position": [1, 0, 0], "scale": 0.5, "clip": "{clip}"}}]}}"#
    );
    let parsed = ParsedScene::parse(text.as_bytes()).unwrap();
    let files: Vec<_> = parsed.characters().collect();
    assert_eq!(files, [("king", "king.glb"), ("man", "../man.glb")]);
    let mut names = members(cast, &["king", "man"]);
    let scene = parsed.resolve(&names, 60.0).unwrap();
    assert_eq!([0, 1].map(|m| scene.members[m].character), [1, 0]);
    let member = &scene.members[0];
    assert_eq!(cast[1].clips()[member.play.clip].name, *clip);
    assert_eq!(scene.importance.of(member, None), 2.0);
    names[0].file = Some("king.glb");
    names[1].file = Some("../man.glb");
    let written = write_scene(&scene, &names);
    assert_eq!(ParsedScene::parse(&written).unwrap().characters().len(), 2);
    let again = read_scene(&written, &names, 60.0).unwrap();
    assert_eq!(again.members, scene.members);
    assert_eq!(again.importance, scene.importance);
    let player = ScenePlayer::new(cast, again.clone(), OPTIONS).unwrap();
    assert_eq!([0, 1].map(|c| player.crowds()[c].scale(0)), [0.5, 1.0]);
    assert_eq!(again.views.len(), 2);
    assert!((again.views[1].viewport.fov_y_radians - 60f32.to_radians()).abs() < 1e-6);
    assert!(again.views[1].camera_loops && !again.views[0].camera_loops);
}

#[test]
fn mistakes_in_casts_and_views_are_named_with_their_place() {
    let cast = cast();
    let names = members(cast, &["king", "man"]);
    let clip = &cast[0].clips()[0].name;
    let camera = r#""camera": [{"t": 0, "eye": [0, 1, 5], "target": [0, 1, 0]}]"#;
    let why = |more: &str, who: &str| {
        let member = format!(r#"{{{who} "position": [0, 0, 0], "clip": "{clip}"}}"#);
        let text = format!(r#"{{{camera}, {more} "members": [{member}]}}"#);
        read_scene(text.as_bytes(), &names, 60.0)
            .unwrap_err()
            .to_string()
    };
    let king = r#""character": "king","#;
    let nine = format!(
        r#""views": [{}],"#,
        vec![format!("{{{camera}}}"); 8].join(",")
    );
    for (more, who, says) in [
        (
            "",
            "",
            "members[0]: character: give one of \"king\", \"man\"",
        ),
        ("", r#""character": "queen","#, "\"king\""),
        (
            r#""characters": [{"name": "", "file": "a"}],"#,
            king,
            "characters[0]: give a name",
        ),
        (
            r#""characters": [{"name": "a", "file": "a"}, {"name": "a", "file": "b"}],"#,
            king,
            "characters[1]: \"a\" is named twice",
        ),
        (r#""views": [{"camera": []}],"#, king, "views[0]: camera"),
        (
            r#""views": [{"camera": [{"t": 1, "eye": [0,0,1], "target": [0,0,0]}]}],"#,
            king,
            "views[0]: camera[0].t",
        ),
        (&nine, king, "views: 8 more; give at most 7"),
        (r#""views": [{"fov_deg": 45}],"#, king, "camera"),
    ] {
        let found = why(more, who);
        assert!(found.contains(says), "{says}: {found}");
    }
}

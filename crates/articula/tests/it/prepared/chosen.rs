//! Crowds that play some of the clips of a prepared asset.

use super::{asset, opened};
use articula::crowd::{
    CacheUse, ClipEvent, CrowdAsset, CrowdEvent, CrowdOptions, CrowdPlayer, Culling,
    RootMotionPolicy, events_by_clip,
};
use articula::{Executor, Figure};

fn crowd(figure: &Figure, options: &CrowdOptions) -> CrowdAsset {
    CrowdAsset::new(figure, options, &Executor::default()).unwrap()
}

#[test]
fn a_choice_of_clips_reads_what_is_stored_for_all() {
    let figure = Figure::new(opened(asset())).unwrap();
    let whole = crowd(&figure, &CrowdOptions::default());
    let options = CrowdOptions {
        clips: vec![figure.asset.clips[1].name.clone()],
        ..CrowdOptions::default()
    };
    let chosen = crowd(&figure, &options);
    assert!(chosen.warnings().is_empty(), "{:?}", chosen.warnings());
    assert_eq!(chosen.clips().len(), 1);
    let (all, one) = (whole.model().parts(), chosen.model().parts());
    assert_eq!(one.errors.clips[..], all.errors.clips[1..]);
    assert_eq!(one.bounds.clips[..], all.bounds.clips[1..]);
    assert_eq!(chosen.levels(), whole.levels());
    for level in 0..whole.levels() {
        assert_eq!(chosen.level(level), whole.level(level));
    }
    // The poses that are cached are those of the clip: both crowds show the same.
    let palettes = |asset: &CrowdAsset, clip: usize| {
        let mut player = CrowdPlayer::new(asset, 3).unwrap();
        player.cache = CacheUse::Cpu;
        (0..3).for_each(|i| player.play(i, clip, 0.11 * i as f32));
        player.plan(0.02, Culling::Off, &mut |_| {});
        player.evaluate();
        player.palettes().bytes().to_vec()
    };
    assert_eq!(palettes(&chosen, 0), palettes(&whole, 1));
    // As authored the levels are made for the clip alone.
    let authored = CrowdOptions {
        root_motion: RootMotionPolicy::AsAuthored,
        ..options
    };
    assert_eq!(crowd(&figure, &authored).clips().len(), 1);
}

#[test]
fn events_of_clips_are_told_by_their_names() {
    let figure = Figure::new(opened(asset())).unwrap();
    let name = figure.asset.clips[1].name.clone();
    let event = |secs, id| (name.clone(), ClipEvent { secs, id });
    let options = CrowdOptions {
        clips: vec![name.clone()],
        events: vec![event(0.25, 7), event(0.0, 8)],
        ..CrowdOptions::default()
    };
    let mut player = CrowdPlayer::new(&crowd(&figure, &options), 2).unwrap();
    player.play(1, 0, 0.2);
    let mut told = Vec::new();
    let report = player.plan(0.1, Culling::Off, &mut |event| {
        if let CrowdEvent::Clip { character, id, .. } = event {
            told.push((character, id));
        }
    });
    assert_eq!((told, report.visible), (vec![(0, 8), (1, 7)], 2));

    let refused = |events: &[(String, ClipEvent)]| {
        let clips = &figure.asset.clips[1..2];
        events_by_clip(events, clips).unwrap_err().to_string()
    };
    let late = refused(&[event(60.0, 1)]);
    assert!(late.contains(&name) && late.contains("60 s"), "{late}");
    let other = refused(&[("fly".to_owned(), ClipEvent { secs: 0.0, id: 1 })]);
    assert!(other.contains("there is no clip \"fly\""), "{other}");
}

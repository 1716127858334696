//! Items played over traces of bandwidth. The judge of what a client shows shares no code with the player
//! but the codecs.

use crate::promised_errors::{Judged, man, robot};
use articula::item::{
    AdaptedItem, Item, TraceOptions, TracePlayback, TracePlayer, TracePolicy, adapt, decide,
};
use articula_stream::decide::BandwidthTrace;
use articula_stream::description::Context;

fn options(secs: f64) -> TraceOptions {
    TraceOptions {
        secs,
        clip_secs: 3.0,
        sample_secs: 0.5,
        ..TraceOptions::default()
    }
}

fn near() -> Context {
    let mut context = Context::default();
    context.view.distance_m = Some(3.0);
    context.preferences.tolerance_px = Some(0.0);
    context
}

/// Traces that do not carry everything at once.
fn traces() -> [BandwidthTrace; 4] {
    [
        BandwidthTrace::step(24e3, 160e3, 6.0),
        BandwidthTrace::drop_to_zero(96e3, 3.0, 9.0),
        BandwidthTrace::square(72e3, 12e3, 6.0, 20.0),
        BandwidthTrace::noisy(5, 48e3, 20.0),
    ]
}

#[test]
fn the_joint_choice_stalls_no_more_and_errs_less_than_the_ratio_of_the_thesis() {
    for (_, item) in [robot(), man()].into_iter().flatten() {
        let mut player = TracePlayer::new(item, &near(), &options(20.0)).unwrap();
        for (number, trace) in traces().iter().enumerate() {
            let mut play = |policy| player.play(trace, policy).unwrap();
            let (ours, thesis) = (play(TracePolicy::Joint), play(TracePolicy::Thesis));
            let name = &item.manifest.name;
            assert_eq!(ours.stalls, 0, "{name} {number}");
            assert!(ours.startup_secs <= thesis.startup_secs, "{name} {number}");
            let both = [ours, thesis];
            let from = TracePlayback::all_shown_secs(&both);
            let [ours, thesis] = both.map(|p| p.errors_from(from).unwrap()[0]);
            assert!(ours < thesis, "{name} {number}: {ours} {thesis}");
        }
    }
}

#[test]
fn playbacks_are_sound() {
    let Some((_, item)) = robot() else { return };
    let mut player = TracePlayer::new(item, &near(), &options(12.0)).unwrap();
    let trace = BandwidthTrace::drop_to_zero(96e3, 2.0, 5.0);
    let whole = item.sent_bytes();
    for policy in TracePolicy::ALL {
        let played = player.play(&trace, policy).unwrap();
        assert_eq!(played, player.play(&trace, policy).unwrap(), "{policy:?}");
        assert_eq!(played.samples.len(), 25);
        let bytes: Vec<u64> = played.samples.iter().map(|s| s.bytes).collect();
        assert!(bytes.is_sorted());
        for sample in &played.samples {
            // No more than the trace carried; nothing twice; the manifest comes too.
            assert!(sample.bytes as f64 <= trace.bits(0.0, sample.secs) / 8.0 + 1.0);
            let gives_up = [TracePolicy::Rate, TracePolicy::Buffer].contains(&policy);
            assert!(gives_up || sample.bytes < whole + 4000, "{}", sample.bytes);
            let begun = played.startup_secs.is_some_and(|secs| secs <= sample.secs);
            assert_eq!(
                begun,
                sample.error_px.is_some(),
                "{policy:?} {}",
                sample.secs
            );
            assert_eq!(
                begun && sample.is_playing,
                sample.level > 0 && sample.is_playing
            );
        }
        // Everything came, and is shown as it is.
        let last = played.samples.last().unwrap();
        let is_all = last.level == played.levels && last.mesh_level == Some(0);
        if policy == TracePolicy::Joint {
            assert!(is_all && last.error_px.unwrap() == 0.0, "{last:?}");
        }
    }
}

#[test]
fn what_is_measured_is_what_an_adapted_item_shows() {
    let Some((original, item)) = robot() else {
        return;
    };
    let mut context = near();
    context.preferences.mesh_level = Some(1);
    context.preferences.body_loa = Some(0);
    let mut player = TracePlayer::new(item, &context, &options(9.0)).unwrap();
    let fast = BandwidthTrace::constant(4e6);
    let played = player.play(&fast, TracePolicy::Joint).unwrap();
    let decided = decide(item, &context, &Default::default()).unwrap();
    let AdaptedItem::Layers(cut) = adapt(item, decided.cut.as_ref().unwrap()).unwrap() else {
        panic!("there is no form in 2D");
    };
    let judge = Judged::new(original, &cut);
    let k = decided.decision.request.pixels_per_metre;
    let mut compared = 0;
    for sample in played
        .samples
        .iter()
        .filter(|s| s.level == played.levels)
        .step_by(3)
    {
        // Both clips play in rounds of whole frames, in the order of the item.
        let Some((clip, secs)) = clip_at(item, sample.position_secs, 3.0) else {
            continue;
        };
        let found = k * judge.shown_m(&clip, secs);
        let measured = sample.skin_px.unwrap();
        // Ours follows each vertex; the judge takes the nearest point of what is shown.
        assert!(
            measured >= found - 0.3,
            "{} s: {measured} {found}",
            sample.secs
        );
        assert!(measured <= decided.decision.error_px + 0.3, "{measured}");
        assert!(measured > 1.0);
        compared += 1;
    }
    assert!(compared >= 3, "{compared}");
}

/// Name of the clip that plays at a time, and the time in it, at the frame that is shown.
fn clip_at(item: &Item, at: f64, clip_secs: f64) -> Option<(String, f64)> {
    let mut start = 0.0;
    loop {
        for part in &item.manifest.parts {
            let (Some(rate), Some(duration)) = (part.rate_hz, part.duration_secs) else {
                continue;
            };
            // A round shows each frame for as long as a frame takes.
            let round = duration + 1.0 / rate;
            let end = start + round * (clip_secs / round).ceil();
            if at < end {
                let secs = (at - start) % round;
                let frame = (secs * rate + 1e-6).floor();
                let is_near_border = secs < 0.01 || secs > round - 0.01;
                return (!is_near_border).then(|| (part.name.clone(), frame / rate));
            }
            start = end;
        }
    }
}

#[test]
fn regions_that_are_not_sent_count_in_what_is_shown() {
    let Some((_, item)) = robot() else { return };
    let mut context = near();
    // Face, arms, torso and hands.
    context.preferences.body_regions = Some(71);
    let mut player = TracePlayer::new(item, &context, &options(6.0)).unwrap();
    let played = player
        .play(&BandwidthTrace::constant(1e6), TracePolicy::Joint)
        .unwrap();
    let last = played.samples.last().unwrap();
    assert_eq!(last.level, played.levels);
    assert!(last.skin_px.unwrap() > 10.0, "{last:?}");
}

#[test]
fn without_bandwidth_nothing_is_shown() {
    let Some((_, item)) = robot() else { return };
    let mut player = TracePlayer::new(item, &near(), &options(3.0)).unwrap();
    for policy in TracePolicy::ALL {
        let silent = BandwidthTrace::constant(0.0);
        let played = player.play(&silent, policy).unwrap();
        assert_eq!((played.startup_secs, played.errors_from(0.0)), (None, None));
        assert_eq!((played.stalls, played.bytes), (0, 0));
    }
}

#[test]
fn what_cannot_be_played_is_named() {
    let Some((_, item)) = robot() else { return };
    let why = |item: &Item, options: &TraceOptions| {
        let made = TracePlayer::new(item, &near(), options);
        made.unwrap_err().to_string()
    };
    let bad = TraceOptions {
        secs: f64::NAN,
        ..options(1.0)
    };
    assert_eq!(why(item, &bad), "secs: found NaN, expected 0.1 to 3600");
    let mut older = item.clone();
    for part in &mut older.manifest.parts {
        part.base_ranges.clear();
    }
    let what = why(&older, &options(1.0));
    assert!(
        what.contains("mesh.ams: the manifest has no ranges"),
        "{what}"
    );
    let mut still = item.clone();
    still
        .manifest
        .parts
        .retain(|part| part.duration_secs.is_none());
    let what = why(&still, &options(1.0));
    assert!(what.contains("no motion to play"), "{what}");
}

//! The plaza by ranks of distance, as it is thinned out elsewhere: what it costs and what it shows.

use super::access::Access;
use super::ours::Batched;
use super::{Bench, Report, SEED};
use crate::measure::race;
use crate::peers::ranks::{Beyond, Moment, Rank, Ranks};
use anyhow::{Context, Result};
use articula_build::evaluate::Points;
use articula_build::scene::{Member, PLAZA_COUNT, Scene, plaza};
use articula_core::clip_set::{ClipSet, Storage};
use articula_core::ladder::Ladder;
use articula_core::palette::{PaletteForm, PaletteMap};
use articula_core::view::Camera;
use glam::Vec3;

/// Skin points of a character that are watched.
const POINTS: usize = 200;

/// Nearer than this a character is near.
const NEAR_METRES: f32 = 20.0;

/// A policy and its name.
type Policy = (&'static str, Ranks);

fn policies() -> Vec<Policy> {
    let baked = |hz| Ranks {
        beyond: Beyond::Baked { hz },
        ..Ranks::default()
    };
    let reduced = |full, hz| Ranks {
        full,
        reduced: PLAZA_COUNT,
        reduced_hz: hz,
        ..Ranks::default()
    };
    vec![
        ("8 full, 32 at 20 Hz, the rest frozen", Ranks::default()),
        ("8 full, 32 at 20 Hz, the rest baked at 30 Hz", baked(30.0)),
        ("8 full, all others at 20 Hz", reduced(8, 20.0)),
        ("200 full, all others at 20 Hz", reduced(200, 20.0)),
        ("1000 full, all others at 20 Hz", reduced(1000, 20.0)),
        ("1000 full, all others at 30 Hz", reduced(1000, 30.0)),
        ("everyone full", reduced(PLAZA_COUNT, 20.0)),
    ]
}

/// What a policy does to the picture.
struct Seen {
    /// Evaluations a frame, mean over the frames.
    evaluations: f64,
    /// 95th percentile over the visible characters that were looked at.
    p95_px: f32,
    /// Greatest among those that are near.
    near_px: f32,
}

/// Adds the section.
pub(super) fn add(bench: &Bench, report: &mut Report) -> Result<()> {
    let count = if bench.small { 400 } else { PLAZA_COUNT };
    let scene = plaza(count, bench.asset.clips.len(), SEED);
    let pose_ns = pose_ns(bench)?;
    report.heading(
        "The plaza by ranks of distance",
        &format!(
            "{count} characters with all clips of the file; evaluations with our own batched evaluator \
             ({pose_ns:.0} ns each), the choice of ranks not counted. Error: 95th percentile over {POINTS} \
             skin points of the distance on the screen between what is shown and the clip, then over \
             the visible characters that were drawn for it; near: the greatest of those nearer than \
             {NEAR_METRES} m."
        ),
    );
    report.head(&["policy", "evaluations a frame", "ms", "p95, px", "near, px"]);
    for (name, ranks) in policies() {
        let seen = seen(bench, &scene, &ranks)?;
        report.row(&[
            name.to_owned(),
            format!("{:.0}", seen.evaluations),
            format!("{:.3}", 1e-6 * seen.evaluations * pose_ns),
            format!("{:.2}", seen.p95_px),
            format!("{:.2}", seen.near_px),
        ]);
        report.csv.push_str(&format!(
            "ranks,{},{count},{:.1} evaluations; p95 {:.3} px; near {:.3} px,{:.1},,\n",
            name.replace(',', ";"),
            seen.evaluations,
            seen.p95_px,
            seen.near_px,
            seen.evaluations * pose_ns
        ));
    }
    Ok(())
}

/// Nanoseconds of one full evaluation in a batch.
fn pose_ns(bench: &Bench) -> Result<f64> {
    let (count, frames) = bench.usual();
    let rig = &bench.asset.rig;
    let ladder = Ladder::whole(rig)?;
    let map = PaletteMap::joints(&ladder);
    let clips = ClipSet::new(rig, ladder, &bench.asset.clips, Storage::Float)?;
    let ours = Batched {
        clips: &clips,
        map: &map,
        clip: bench.clip,
        level: 0,
    };
    let mut contestants = [ours.stored("ours, 3x4 f32", PaletteForm::Matrix, count)?];
    let times = Access::Forward.frames(bench, count, frames);
    Ok(race(&mut contestants, &times, bench.rounds())[0].median_ns)
}

/// Plays the policy for a while and looks at some of the characters.
fn seen(bench: &Bench, scene: &Scene, ranks: &Ranks) -> Result<Seen> {
    let frames = if bench.small { 2 } else { 12 };
    let look_at_one_of = if bench.small { 40 } else { 97 };
    let points = Points::draw(&bench.asset, POINTS, SEED);
    let positions: Vec<Vec3> = scene.members.iter().map(|m| m.position).collect();
    let mut errors = Vec::new();
    let mut near_px = 0.0f32;
    let mut evaluations = 0;
    let mut before: Option<Vec<Moment>> = None;
    for frame in 0..=frames {
        // Late enough that frozen ones have been so for a while.
        let secs = 5.0 + f64::from(frame) / 60.0;
        let camera = scene.camera_at(secs).context("the plaza has a camera")?;
        let now = ranks.moments(&camera, &positions, secs);
        if let Some(before) = &before {
            evaluations += now
                .iter()
                .zip(before)
                .filter(|(n, b)| is_evaluated(n, b))
                .count();
            for (member, moment) in scene
                .members
                .iter()
                .zip(&now)
                .skip(frame as usize)
                .step_by(look_at_one_of)
            {
                if moment.rank == Rank::Hidden {
                    continue;
                }
                let error = error_px(bench, &points, &camera, member, (moment.secs, secs));
                errors.push(error);
                if member.position.distance(camera.eye) < NEAR_METRES {
                    near_px = near_px.max(error);
                }
            }
        }
        before = Some(now);
    }
    Ok(Seen {
        evaluations: evaluations as f64 / f64::from(frames),
        p95_px: percentile_95(&mut errors),
        near_px,
    })
}

/// Whether a pose was worked out for this frame.
fn is_evaluated(now: &Moment, before: &Moment) -> bool {
    match now.rank {
        Rank::Full => true,
        Rank::Reduced => now.secs != before.secs,
        Rank::Hidden | Rank::Beyond => false,
    }
}

/// How far the skin of a character is off on the screen that shows one time of the scene for another.
fn error_px(
    bench: &Bench,
    points: &Points,
    camera: &Camera,
    member: &Member,
    (shown, truth): (f64, f64),
) -> f32 {
    let clip = &bench.asset.clips[member.play.clip];
    let place = member.world_from_model();
    let at = |secs: f64| {
        let duration = clip.duration_secs();
        let secs = member.play.clip_secs(secs, duration);
        let secs = if duration > 0.0 {
            secs.rem_euclid(f64::from(duration))
        } else {
            0.0
        };
        points.at(&bench.asset, clip, secs)
    };
    let mut distances: Vec<f32> = at(shown)
        .into_iter()
        .zip(at(truth))
        .map(|(s, t)| {
            (
                camera.project(place.transform_point3(s)),
                camera.project(place.transform_point3(t)),
            )
        })
        .map(|((s, _), (t, _))| s.distance(t))
        .collect();
    percentile_95(&mut distances)
}

/// 95th percentile, the value at or above it; 0 of nothing.
fn percentile_95(values: &mut [f32]) -> f32 {
    values.sort_by(f32::total_cmp);
    let at = (0.95 * values.len().saturating_sub(1) as f32).ceil() as usize;
    values.get(at).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_95th_of_a_hundred() {
        let mut values: Vec<f32> = (0..=100).rev().map(|i| i as f32).collect();
        assert_eq!(percentile_95(&mut values), 95.0);
        assert_eq!(percentile_95(&mut []), 0.0);
        assert_eq!(percentile_95(&mut [3.0]), 3.0);
    }
}

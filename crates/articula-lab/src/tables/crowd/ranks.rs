//! The plaza with update rates by rank of distance: cost and error.

use super::frame_order::Access;
use super::ours::Batched;
use super::plaza::AtOnePixel;
use super::screen_error::{Errors, distance_px, p95_px};
use super::{Bench, CrowdTables, SEED};
use crate::measure::race;
use crate::peers::ranks::{Beyond, Moment, Rank, Ranks};
use anyhow::{Context, Result};
use articula::crowd::NEAR_METRES;
use articula_build::draw_vertices;
use articula_build::{PLAZA_COUNT, Plaza, Scene, SceneCharacter, plaza};
use articula_core::{
    Camera, ClipSet, ClipStorage, JointLods, PaletteForm, PaletteMap, PosedMesh, Wrap,
};
use glam::Vec3;

/// Number of measured skin points of a character.
const POINTS: usize = 200;

/// Maximum errors in pixels: 95th percentile over visible characters, maximum within 20 m.
const GOAL_PX: (f32, f32) = (1.0, 2.0);

/// Cost and error of a policy.
struct PolicyOutcome {
    /// Evaluations per frame, mean over the frames.
    evaluations: f64,
    /// 95th percentile of the error over the sampled visible characters.
    p95_px: f32,
    /// Maximum error of characters within 20 m.
    near_px: f32,
}

/// The crowd on which policies are tried.
struct Trial<'a> {
    bench: &'a Bench,
    scene: Scene,
    /// Nanoseconds of one evaluation.
    pose_ns: f64,
    vertices: Vec<u32>,
}

/// Adds the section.
pub(super) fn add(bench: &Bench, report: &mut CrowdTables, ours: &AtOnePixel) -> Result<()> {
    let count = if bench.small { 400 } else { PLAZA_COUNT };
    let trial = Trial {
        bench,
        scene: plaza(count, &[bench.asset.clips.len()], SEED, Plaza::Still),
        pose_ns: pose_ns(bench)?,
        vertices: draw_vertices(bench.asset.mesh.len(), POINTS, SEED),
    };
    report.heading(
        "The plaza by ranks of distance",
        &format!(
            "Update rates by rank of distance, as in several engines: {count} characters; an evaluated \
             character has all joints and is evaluated in Articula's batches ({:.0} ns each); the time \
             for ranking is not included, and baked poses cost nothing. Errors as above, between the \
             shown pose and the clip. *Equal error*: the cheapest policy with a number of fully \
             updated characters and all others held that stays within {} px, and within {} px nearer \
             than {NEAR_METRES} m. *Equal time*: the policy with the least error in the time of \
             Articula's merged levels.",
            trial.pose_ns, GOAL_PX.0, GOAL_PX.1
        ),
    );
    report.head(&[
        "policy",
        "evaluations per frame",
        "ms",
        "p95, px",
        "max within 20 m, px",
    ]);
    report.row(&[
        "Articula: merged levels within 1 px, whole frame".to_owned(),
        "–".to_owned(),
        format!("{:.3}", ours.ms),
        format!("{:.2}", ours.p95_px),
        format!("{:.2}", ours.near_px),
    ]);
    let baked = Ranks {
        beyond: Beyond::Baked { hz: 30.0 },
        ..Ranks::default()
    };
    for (name, ranks) in [
        ("8 full, 32 at 20 Hz, the rest frozen", Ranks::default()),
        ("8 full, 32 at 20 Hz, the rest baked at 30 Hz", baked),
    ] {
        let seen = trial.seen(&ranks)?;
        trial.row(report, name, &seen);
    }
    let mut tried = Vec::new();
    for full in [8, 128, 512, 1024, 2048, 4096, PLAZA_COUNT] {
        for reduced_hz in [5.0, 10.0, 15.0, 20.0, 30.0] {
            let ranks = Ranks {
                full,
                reduced: PLAZA_COUNT,
                reduced_hz,
                ..Ranks::default()
            };
            let name = format!("{full} full, all others at {reduced_hz} Hz");
            tried.push((name, trial.seen(&ranks)?));
        }
    }
    let good = |s: &PolicyOutcome| s.p95_px <= GOAL_PX.0 && s.near_px <= GOAL_PX.1;
    let cheap = tried.iter().filter(|(_, s)| good(s));
    let cheap = cheap.min_by(|a, b| a.1.evaluations.total_cmp(&b.1.evaluations));
    let fast = |s: &PolicyOutcome| trial.ms(s) <= ours.ms;
    let sharp = tried.iter().filter(|(_, s)| fast(s));
    let sharp = sharp.min_by(|a, b| a.1.p95_px.total_cmp(&b.1.p95_px));
    for (what, found) in [("equal error", cheap), ("equal time", sharp)] {
        match found {
            Some((name, seen)) => trial.row(report, &format!("{what}: {name}"), seen),
            None => report.row(&[format!("{what}: none of those tried")]),
        }
    }
    Ok(())
}

/// Nanoseconds of one full evaluation in a batch.
fn pose_ns(bench: &Bench) -> Result<f64> {
    let (count, frames) = bench.usual();
    let rig = &bench.asset.rig;
    let joint_lods = JointLods::whole(rig)?;
    let map = PaletteMap::joints(&joint_lods);
    let clips = ClipSet::new(rig, joint_lods, &bench.asset.clips, ClipStorage::Float)?;
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

impl Trial<'_> {
    fn ms(&self, seen: &PolicyOutcome) -> f64 {
        1e-6 * seen.evaluations * self.pose_ns
    }

    fn row(&self, report: &mut CrowdTables, name: &str, seen: &PolicyOutcome) {
        report.row(&[
            name.to_owned(),
            format!("{:.0}", seen.evaluations),
            format!("{:.3}", self.ms(seen)),
            format!("{:.2}", seen.p95_px),
            format!("{:.2}", seen.near_px),
        ]);
        report.csv.push_str(&format!(
            "ranks,{},{},{:.1} evaluations; p95 {:.3} px; near {:.3} px,{:.1},,\n",
            name.replace(',', ";"),
            self.scene.members.len(),
            seen.evaluations,
            seen.p95_px,
            seen.near_px,
            1e6 * self.ms(seen)
        ));
    }

    /// Plays the policy for a while and measures a sample of the characters and all within 20 m.
    fn seen(&self, ranks: &Ranks) -> Result<PolicyOutcome> {
        let members = &self.scene.members;
        let frames = if self.bench.small { 2 } else { 12 };
        let one_of = if self.bench.small { 40 } else { 97 };
        let positions: Vec<Vec3> = members.iter().map(|m| m.position).collect();
        let mut errors = Errors::default();
        let mut evaluations = 0;
        let mut before: Option<Vec<Moment>> = None;
        for frame in 0..=frames {
            // Late enough for frozen characters to have been frozen for a while.
            let secs = 5.0 + frame as f64 / 60.0;
            let camera = self.scene.camera_at(secs);
            let camera = camera.context("the plaza has a camera")?;
            let now = ranks.moments(&camera, &positions, secs);
            if let Some(before) = &before {
                let pairs = now.iter().zip(before);
                evaluations += pairs.filter(|(n, b)| is_evaluated(n, b)).count();
                for (i, (member, moment)) in members.iter().zip(&now).enumerate() {
                    let metres = member.position.distance(camera.eye);
                    let drawn = i % one_of == frame % one_of;
                    let looked = metres < NEAR_METRES || drawn;
                    if looked && moment.rank != Rank::Hidden {
                        let px = self.error_px(&camera, member, (moment.secs, secs));
                        errors.add(px, metres, drawn);
                    }
                }
            }
            before = Some(now);
        }
        Ok(PolicyOutcome {
            evaluations: evaluations as f64 / frames as f64,
            p95_px: p95_px(errors.drawn),
            near_px: errors.near_px,
        })
    }

    /// Error of a character's skin that shows one time of the scene instead of another.
    fn error_px(
        &self,
        camera: &Camera,
        member: &SceneCharacter,
        (shown, truth): (f64, f64),
    ) -> f32 {
        if shown == truth {
            return 0.0;
        }
        let asset = &self.bench.asset;
        let clip = &asset.clips[member.play.clip];
        let duration = clip.duration_secs();
        let at = |secs: f64| {
            let secs = member.play.clip_secs(secs, duration);
            let secs = secs.rem_euclid(f64::from(duration.max(1e-3)));
            let mut points = vec![Vec3::ZERO; self.vertices.len()];
            PosedMesh::new(&asset.rig, &asset.mesh)
                .pose_at(clip, secs, Wrap::Clamp)
                .points(&self.vertices, &mut points);
            points
        };
        distance_px(camera, member, &at(shown), &at(truth))
    }
}

/// Whether a pose was evaluated for this frame.
fn is_evaluated(now: &Moment, before: &Moment) -> bool {
    match now.rank {
        Rank::Full => true,
        Rank::Reduced => now.secs != before.secs,
        Rank::Hidden | Rank::Beyond => false,
    }
}

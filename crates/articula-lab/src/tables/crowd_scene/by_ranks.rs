//! What update rates by rank of distance show of the mixed scene.

use super::stage::Stage;
use super::{Played, SEED, of_main};
use crate::measure::median;
use crate::peers::ranks::{Moment, Rank, Ranks, is_visible};
use anyhow::{Context, Result};
use articula::crowd::{
    CharacterError, CrowdAsset, CrowdPlayer, Culling, DISPLAY_HZ, Detail, ErrorSample,
};
use articula_build::{SceneCharacter, draw_vertices};
use articula_core::{Camera, PosedMesh, Wrap, percentile_at_or_above};
use articula_report::thread_ns;
use glam::{Vec2, Vec3};

/// Number of measured skin points of a character.
const POINTS: usize = 400;
/// Characters whose evaluation is timed, and rounds.
const TIMED: usize = 500;
const ROUNDS: usize = 15;

/// The characters of the scene, and what one evaluation costs.
pub(super) struct Held<'a> {
    stage: &'a Stage,
    assets: &'a [CrowdAsset],
    /// Nanoseconds of evaluating every joint once, for each character of the cast.
    pose_ns: Vec<f64>,
    vertices: Vec<Vec<u32>>,
}

impl<'a> Held<'a> {
    pub(super) fn new(stage: &'a Stage, assets: &'a [CrowdAsset]) -> Result<Self> {
        let pose_ns = assets.iter().map(pose_ns).collect::<Result<_>>()?;
        let draw = |a: &CrowdAsset| draw_vertices(a.full().mesh.len(), POINTS, SEED);
        Ok(Self {
            stage,
            assets,
            pose_ns,
            vertices: assets.iter().map(draw).collect(),
        })
    }

    /// The policy with as many evaluations, in the same proportion, as a time allows.
    pub(super) fn within(&self, ranks: Ranks, ms: f64) -> Ranks {
        let mean_ns = self.pose_ns.iter().sum::<f64>() / self.pose_ns.len() as f64;
        let rate = ranks.reduced_hz / DISPLAY_HZ;
        let evaluated = ranks.full as f64 + rate * ranks.reduced as f64;
        let factor = 1e6 * ms / mean_ns / evaluated;
        let times = |count: usize| (count as f64 * factor) as usize;
        Ranks {
            full: times(ranks.full),
            reduced: times(ranks.reduced),
            ..ranks
        }
    }

    /// Plays a policy and measures it where others were measured.
    pub(super) fn play(
        &self,
        (name, ranks): (&str, Ranks),
        seen: &[ErrorSample],
        frames: usize,
    ) -> Result<Played> {
        let members = &self.stage.scene.members;
        let (mut ms, mut evaluated, mut looks) = (Vec::new(), 0, Vec::new());
        let mut before = self.moments(&ranks, -1.0 / DISPLAY_HZ)?;
        for frame in 0..frames {
            let secs = frame as f64 / DISPLAY_HZ;
            let now = self.moments(&ranks, secs)?;
            let mut ns = 0.0;
            for ((member, now), before) in members.iter().zip(&now).zip(&before) {
                let is_due = match now.rank {
                    Rank::Full => true,
                    Rank::Reduced => now.secs != before.secs,
                    Rank::Hidden | Rank::Beyond => false,
                };
                if is_due {
                    evaluated += 1;
                    ns += self.pose_ns[usize::from(member.character)];
                }
            }
            ms.push(1e-6 * ns);
            let is_now = |sample: &&ErrorSample| (sample.secs * DISPLAY_HZ).round() == frame as f64;
            if let Some(look) = seen.iter().find(is_now) {
                looks.push(self.look(look, &now, secs)?);
            }
            before = now;
        }
        Ok(Played {
            name: name.to_owned(),
            ms: [0.5, 0.95].map(|share| percentile_at_or_above(&mut ms.clone(), share)),
            shown: evaluated as f64 / frames as f64,
            main: of_main(self.stage, &looks),
            looks,
            overrun: None,
        })
    }

    /// Rank and shown time of each member, by the distance from the nearest camera that sees it.
    fn moments(&self, ranks: &Ranks, secs: f64) -> Result<Vec<Moment>> {
        let cameras = self.cameras(secs)?;
        let members = self.stage.scene.members.iter();
        let nearest = members.map(|m| {
            let seen = cameras.iter().filter(|c| is_visible(c, m.position));
            seen.map(|c| m.position.distance_squared(c.eye))
                .reduce(f32::min)
        });
        Ok(ranks.moments_of(nearest, secs))
    }

    fn cameras(&self, secs: f64) -> Result<Vec<Camera>> {
        let views = self.stage.scene.views.iter();
        let cameras = views.map(|v| v.camera_at(secs.max(0.0)).context("the view has a camera"));
        cameras.collect()
    }

    /// Errors of the members that were measured before.
    fn look(&self, seen: &ErrorSample, now: &[Moment], secs: f64) -> Result<ErrorSample> {
        let cameras = self.cameras(secs)?;
        let characters = seen.characters.iter().filter_map(|of| {
            let (member, moment) = (&self.stage.scene.members[of.character], now[of.character]);
            let mut px = self.errors_px(member, &cameras, [moment.secs, secs]);
            if px.is_empty() {
                return None;
            }
            Some(CharacterError {
                p95_px: percentile_at_or_above(&mut px, 0.95),
                worst_px: percentile_at_or_above(&mut px, 1.0),
                ..*of
            })
        });
        Ok(ErrorSample {
            secs,
            characters: characters.collect(),
        })
    }

    /// Pixels between the skins at two times of the scene, of each point in a picture.
    fn errors_px(&self, member: &SceneCharacter, cameras: &[Camera], times: [f64; 2]) -> Vec<f64> {
        let character = usize::from(member.character);
        let (asset, vertices) = (&self.assets[character], &self.vertices[character]);
        let full = asset.full();
        let clip = &full.clips[member.play.clip];
        let duration = clip.duration_secs();
        let skin = |secs: f64| {
            let secs = member.play.clip_secs(secs, duration);
            let secs = secs.rem_euclid(f64::from(duration.max(1e-3)));
            let mut points = vec![Vec3::ZERO; vertices.len()];
            PosedMesh::new(&full.rig, &full.mesh)
                .pose_at(clip, secs, Wrap::Clamp)
                .points(vertices, &mut points);
            points
        };
        let world = member.world_from_model();
        let [shown, truth] = times.map(skin);
        let each = shown.iter().zip(&truth).filter_map(|(shown, truth)| {
            let ends = [shown, truth].map(|p| world.transform_point3(*p));
            let px = cameras.iter().filter_map(|camera| apart_px(camera, ends));
            px.reduce(f64::max)
        });
        each.collect()
    }
}

/// Pixels between two points of which the second is in the picture.
fn apart_px(camera: &Camera, [shown, truth]: [Vec3; 2]) -> Option<f64> {
    let size = Vec2::new(camera.viewport.width_px, camera.viewport.height_px);
    let (shown, near) = camera.project(shown);
    let (truth, depth) = camera.project(truth);
    let is_seen = truth.cmpge(Vec2::ZERO).all() && truth.cmple(size).all();
    (near.min(depth) > 0.1 && is_seen).then(|| f64::from(shown.distance(truth)))
}

/// Nanoseconds of evaluating every joint of a character once, in batches.
fn pose_ns(asset: &CrowdAsset) -> Result<f64> {
    let mut crowd = CrowdPlayer::new(asset, TIMED)?;
    crowd.detail = Detail::Full;
    let clips = asset.clips();
    for character in 0..TIMED {
        let clip = character % clips.len();
        let secs = clips[clip].duration_secs() * character as f32 / TIMED as f32;
        crowd.play(character, clip, secs);
    }
    let mut times = Vec::new();
    for _ in 0..ROUNDS {
        crowd.plan(1.0 / DISPLAY_HZ as f32, Culling::Off, &mut |_| ());
        let start = thread_ns();
        crowd.evaluate();
        times.push((thread_ns() - start) as f64 / TIMED as f64);
    }
    Ok(median(&mut times))
}

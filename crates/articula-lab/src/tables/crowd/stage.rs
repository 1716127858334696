//! A crowd of Articula on a scene: played frame by frame, timed and measured.

use super::Bench;
use crate::measure::thread_ns;
use anyhow::{Context, Result};
use articula::Executor;
use articula::crowd::{
    Budget, CacheUse, Camera, CrowdAsset, CrowdOptions, CrowdPlayer, CrowdReport, Culling, Detail,
    PoseSource, View,
};
use articula_build::{Scene, SceneCharacter};
use articula_core::crowd::{CharacterState, ClipState, Crowd};
use articula_core::{PosedMesh, Wrap, blend, percentile_at_or_above, sample, skin_points};
use glam::{Vec2, Vec3};

/// Time step between frames.
const STEP_SECS: f32 = 1.0 / 60.0;

/// Frames before the first one that counts.
const WARM_UP: usize = 10;

/// Number of measured skin points of a character.
const POINTS: usize = 200;

/// Points nearer to the camera's plane than this are not drawn.
const NEAR_PLANE_METRES: f32 = 0.1;

/// Characters nearer than this count as near.
pub(super) const NEAR_METRES: f32 = 20.0;

/// Inputs of all runs on scenes.
pub(super) struct SceneBench<'a> {
    bench: &'a Bench,
    asset: CrowdAsset,
    vertices: Vec<u32>,
}

/// Results of one run on a scene.
#[derive(Default)]
pub(super) struct Outcome {
    /// Milliseconds of selection in each frame.
    pub(super) select_ms: Vec<f64>,
    pub(super) evaluate_ms: Vec<f64>,
    /// Visible characters, mean over frames.
    pub(super) visible: f64,
    /// Evaluated poses, mean over frames.
    pub(super) poses: f64,
    /// Megabytes of palettes written per frame, mean.
    pub(super) written_mb: f64,
    /// Megabytes of clips, characters and palettes.
    pub(super) resident_mb: f64,
    /// 95th percentile of the error over the sampled visible characters.
    pub(super) p95_px: f32,
    /// Maximum error of characters within 20 m.
    pub(super) near_px: f32,
}

impl Outcome {
    /// A percentile of the milliseconds of the whole frame.
    pub(super) fn frame_ms(&self, share: f64) -> f64 {
        let whole = self.select_ms.iter().zip(&self.evaluate_ms);
        let mut whole: Vec<f64> = whole.map(|(a, b)| a + b).collect();
        percentile_at_or_above(&mut whole, share)
    }

    /// Selection as a fraction of the evaluation, medians.
    pub(super) fn selection_share(&self) -> f64 {
        let evaluate = percentile_at_or_above(&mut self.evaluate_ms.clone(), 0.5);
        percentile_at_or_above(&mut self.select_ms.clone(), 0.5) / evaluate.max(1e-9)
    }
}

/// Options for playing a scene.
#[derive(Clone, Copy)]
pub(super) struct Play {
    pub(super) detail: Detail,
    /// Milliseconds of a whole frame, for which the tolerance is chosen instead.
    pub(super) budget_ms: Option<f64>,
    pub(super) cache: CacheUse,
    pub(super) frames: usize,
    /// One of this many characters is measured in every eighth frame.
    pub(super) look_at_one_of: usize,
}

/// A frame on the screen.
#[derive(Clone, Copy)]
struct DisplayedFrame<'a> {
    /// Number of the frame among the measured ones.
    number: usize,
    player: &'a CrowdPlayer,
    camera: Camera,
}

/// Errors of the measured characters, pixels.
#[derive(Default)]
pub(super) struct Errors {
    /// Errors of the random sample.
    pub(super) drawn: Vec<f32>,
    /// Maximum error of characters within 20 m, in the sample or not.
    pub(super) near_px: f32,
}

impl Errors {
    /// Adds a character at a distance from the camera.
    pub(super) fn add(&mut self, px: f32, metres: f32, drawn: bool) {
        if metres < NEAR_METRES {
            self.near_px = self.near_px.max(px);
        }
        if drawn {
            self.drawn.push(px);
        }
    }
}

impl<'a> SceneBench<'a> {
    /// Levels, skins, errors and bounds of the bench's character with all its clips.
    pub(super) fn new(bench: &'a Bench) -> Result<Self> {
        let asset = &bench.asset;
        let step = (asset.mesh.len() / POINTS).max(1);
        let options = CrowdOptions {
            pose_cache: true,
            ..CrowdOptions::default()
        };
        Ok(Self {
            bench,
            vertices: (0..asset.mesh.len() as u32).step_by(step).collect(),
            asset: CrowdAsset::from_asset(asset.clone(), &options, &Executor::default())?,
        })
    }

    /// Number of joints that each level keeps.
    pub(super) fn kept(&self) -> Vec<usize> {
        let all = 0..self.asset.levels();
        all.map(|l| self.asset.level(l).joints).collect()
    }

    /// Plays a scene from its beginning.
    pub(super) fn play(&self, scene: &Scene, play: Play) -> Result<Outcome> {
        let count = scene.members.len();
        let model = self.asset.model();
        let mut player = self.player(scene)?;
        player.cache = play.cache;
        player.detail = play.detail;
        let mut budget = play.budget_ms.map(|ms| Budget::new(1e6 * ms, 1.0));
        let mut most_bytes = 0;
        let mut outcome = Outcome::default();
        let mut errors = Errors::default();
        for number in 0..WARM_UP + play.frames {
            let secs = number as f64 * f64::from(STEP_SECS);
            self.follow_fades(scene, player.crowd_mut());
            let camera = scene.camera_at(secs).context("the scene has a camera")?;
            let views = [View::of(&camera)];
            let dt_secs = if number == 0 { 0.0 } else { STEP_SECS };
            if let Some(budget) = &budget {
                player.detail = budget.detail();
            }
            let start = thread_ns();
            let report = player.plan(dt_secs, Culling::Views(&views), &mut |_| {});
            if let Some(budget) = &mut budget {
                player.add_to(budget);
            }
            let selected = thread_ns();
            player.evaluate();
            let evaluated = thread_ns();
            let bytes = player.crowd().draw_list().matrices * model.parts().form.bytes();
            most_bytes = most_bytes.max(bytes);
            if let Some(budget) = &mut budget {
                budget.observe((selected - start) as f64, (evaluated - selected) as f64);
            }
            if number < WARM_UP {
                continue;
            }
            outcome.select_ms.push(1e-6 * (selected - start) as f64);
            let evaluate_ns = evaluated - selected;
            outcome.evaluate_ms.push(1e-6 * evaluate_ns as f64);
            let drawn = size_of_val(player.records()) + size_of_val(player.stepped());
            outcome.add(&report, bytes + drawn, play.frames);
            if number.is_multiple_of(8) {
                let now = DisplayedFrame {
                    number: number / 8,
                    player: &player,
                    camera,
                };
                self.look(&now, (scene, play.look_at_one_of), &mut errors);
            }
        }
        let mut state = Crowd::BYTES_PER_CHARACTER * count + model.parts().clips.bytes();
        if let (true, Some(cache)) = (play.cache != CacheUse::Never, model.parts().cache.as_ref()) {
            state += cache.bytes();
        }
        outcome.resident_mb = 1e-6 * (state + most_bytes) as f64;
        outcome.near_px = errors.near_px;
        outcome.p95_px = p95_px(errors.drawn);
        Ok(outcome)
    }

    /// The crowd of a scene at time 0.
    pub(super) fn player(&self, scene: &Scene) -> Result<CrowdPlayer> {
        let mut crowd = CrowdPlayer::new(&self.asset, scene.members.len())?;
        for (i, member) in scene.members.iter().enumerate() {
            crowd.place(i, member.position, member.yaw_radians);
            let clip_state = self.clip_state(member.play, 0.0);
            let mut player = CharacterState::from(clip_state);
            if let Some(fade) = member.cross_fade {
                // Fades in progress began at different times.
                let left = fade.fade_secs * (1.0 - fade.start);
                player.fade_to(self.clip_state(fade.other, 0.0), left.max(STEP_SECS));
            }
            crowd.crowd_mut().play(i, player);
        }
        Ok(crowd)
    }

    fn clip_state(&self, play: articula_build::ClipPlayback, secs: f64) -> ClipState {
        let clips = &self.asset.model().parts().clips;
        let duration = clips.duration_secs(play.clip);
        let at = play
            .clip_secs(secs, duration)
            .rem_euclid(f64::from(duration.max(1e-3)));
        ClipState::new(clips, play.clip)
            .at_speed(play.speed)
            .at_secs(clips, at as f32)
    }

    /// Starts the reverse cross-fade of characters whose fade has ended.
    fn follow_fades(&self, scene: &Scene, crowd: &mut Crowd) {
        for (i, member) in scene.members.iter().enumerate() {
            if let Some(fade) = member.cross_fade
                && crowd.state(i).next().is_none()
            {
                let there = crowd.state(i).clip_state().clip() == fade.other.clip;
                let next = if there { member.play } else { fade.other };
                crowd.fade_to(i, self.clip_state(next, 0.0), fade.fade_secs);
            }
        }
    }

    /// Measures all characters within 20 m and a sample of the others.
    fn look(
        &self,
        now: &DisplayedFrame<'_>,
        (scene, one_of): (&Scene, usize),
        errors: &mut Errors,
    ) {
        for (who, source) in now.player.sources().iter().enumerate() {
            let (Some(source), Some(level)) = (source, now.player.crowd().level(who)) else {
                continue;
            };
            let member = &scene.members[who];
            let metres = member.position.distance(now.camera.eye);
            let drawn = who % one_of == now.number % one_of;
            if metres < NEAR_METRES || drawn {
                let shown = self.shown_points(now.player, level, source);
                let truth = self.true_points(&now.player.crowd().state(who));
                let px = distance_px(&now.camera, member, &shown, &truth);
                errors.add(px, metres, drawn);
            }
        }
    }

    /// Measured points as posed by the palette of a level.
    fn shown_points(&self, player: &CrowdPlayer, level: usize, source: &PoseSource) -> Vec<Vec3> {
        let mut matrices = Vec::new();
        player.skin_matrices(level, source, &mut matrices);
        let mut points = vec![Vec3::ZERO; self.vertices.len()];
        skin_points(
            self.asset.mesh(level),
            &matrices,
            &self.vertices,
            &mut points,
        );
        points
    }

    /// The same points in the full pose of the character's clips, by the plain path.
    fn true_points(&self, player: &CharacterState) -> Vec<Vec3> {
        let asset = &self.bench.asset;
        let pose = |clip_state: &ClipState| {
            let mut pose = asset.rig.rest_pose().clone();
            let clip = &asset.clips[clip_state.clip()];
            let secs = f64::from(clip_state.secs());
            sample(clip, secs, Wrap::Clamp, &asset.rig.all(), &mut pose);
            pose
        };
        let mut local = pose(player.clip_state());
        if let Some(other) = player.next() {
            blend(&mut local, &pose(other), player.fade(), &asset.rig.all());
        }
        let mut points = vec![Vec3::ZERO; self.vertices.len()];
        let mut posed = PosedMesh::new(&asset.rig, &asset.mesh);
        posed.pose(&local).points(&self.vertices, &mut points);
        points
    }
}

impl Outcome {
    fn add(&mut self, report: &CrowdReport, written: usize, frames: usize) {
        let frames = frames as f64;
        self.visible += report.visible as f64 / frames;
        self.poses += report.own as f64 / frames;
        self.written_mb += 1e-6 * written as f64 / frames;
    }
}

/// 95th percentile, over the points on the screen, of the distance in pixels between two skins of
/// a character.
pub(super) fn distance_px(
    camera: &Camera,
    member: &SceneCharacter,
    shown: &[Vec3],
    truth: &[Vec3],
) -> f32 {
    let place = member.world_from_model();
    let size = Vec2::new(camera.viewport.width_px, camera.viewport.height_px);
    let apart = shown.iter().zip(truth).filter_map(|(shown, truth)| {
        let (shown, _) = camera.project(place.transform_point3(*shown));
        let (truth, depth) = camera.project(place.transform_point3(*truth));
        let on_screen = truth.cmpge(Vec2::ZERO).all() && truth.cmple(size).all();
        (depth > NEAR_PLANE_METRES && on_screen).then(|| shown.distance(truth))
    });
    p95_px(apart.collect())
}

/// 95th percentile, the value at or above it; 0 without values.
pub(super) fn p95_px(values: Vec<f32>) -> f32 {
    let mut values: Vec<f64> = values.into_iter().map(f64::from).collect();
    percentile_at_or_above(&mut values, 0.95) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_off_the_screen_does_not_count() {
        use articula_build::{Plaza, plaza};
        let scene = plaza(4, &[1], 1, Plaza::Still);
        let camera = scene.camera_at(0.0).unwrap();
        let member = SceneCharacter {
            position: Vec3::ZERO,
            yaw_radians: 0.0,
            ..scene.members[0]
        };
        // 10 m ahead at the height of the camera, and beside it.
        let ahead = camera.eye + 10.0 * camera.forward();
        let (beside, moved) = (camera.eye + Vec3::X, 0.01 * Vec3::X);
        let both = [ahead, beside];
        let px = distance_px(&camera, &member, &both.map(|p| p + moved), &both);
        let expected = 0.01 * camera.viewport.pixels_per_metre(10.0);
        assert!((px - expected).abs() < 1e-2, "{px} px, {expected} expected");
    }

    #[test]
    fn the_95th_of_a_hundred() {
        let values: Vec<f32> = (0..=100).rev().map(|i| i as f32).collect();
        assert_eq!(p95_px(values), 95.0);
        assert_eq!(p95_px(Vec::new()), 0.0);
    }
}

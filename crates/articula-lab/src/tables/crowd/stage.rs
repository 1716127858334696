//! A crowd of ours on a scene: the parts put together, played frame by frame, timed and judged.

use super::Bench;
use crate::measure::thread_ns;
use anyhow::{Context, Result};
use articula_build::motion_bounds;
use articula_build::scene::{Member, Scene};
use articula_build::{CacheOptions, cached_poses};
use articula_build::{LevelOptions, merged_levels};
use articula_core::budget::{CostModel, Policy};
use articula_core::crowd::{
    CacheUse, Crowd, CrowdModel, CrowdParts, CrowdReport, Detail, Frame, Player, Sight, Voice,
};
use articula_core::visibility::View;
use articula_core::{
    Backend, CachedRows, Camera, ClipSet, Mesh, ModelPose, PaletteForm, PaletteRows, Storage, Wrap,
    blend, local_to_model, palette, sample, skin_points,
};
use glam::{Affine3A, Quat, Vec2, Vec3};

/// Time from frame to frame.
const STEP_SECS: f32 = 1.0 / 60.0;

/// Frames before anything counts.
const WARM_UP: usize = 10;

/// Skin points of a character that are watched.
const POINTS: usize = 200;

/// What is nearer to the camera's plane is not drawn.
const NEAR_PLANE_METRES: f32 = 0.1;

/// Nearer than this a character is near.
pub(super) const NEAR_METRES: f32 = 20.0;

/// Everyone is posed in every frame, so nobody waits.
const NOBODY_WAITS: Policy = Policy {
    cap_px: 1.0,
    enough_px: 0.0,
    patience_frames: 0,
    hold_frames: 0,
};

/// What all runs on scenes share.
pub(super) struct Stage<'a> {
    bench: &'a Bench,
    model: CrowdModel,
    /// The mesh of each level.
    meshes: Vec<Mesh>,
    vertices: Vec<u32>,
}

/// What one run on a scene gave.
#[derive(Default)]
pub(super) struct Outcome {
    /// Milliseconds of each frame: selection and evaluation.
    pub(super) select_ms: Vec<f64>,
    pub(super) evaluate_ms: Vec<f64>,
    /// Characters seen, mean.
    pub(super) visible: f64,
    /// Poses evaluated, mean.
    pub(super) poses: f64,
    /// Megabytes of palettes written in a frame, mean.
    pub(super) written_mb: f64,
    /// Bytes of clips, characters and palettes.
    pub(super) resident_mb: f64,
    /// 95th percentile of the error over the visible characters that were looked at.
    pub(super) p95_px: f32,
    /// Greatest error of those that are near.
    pub(super) near_px: f32,
}

impl Outcome {
    /// A percentile of the whole frame's milliseconds.
    pub(super) fn frame_ms(&self, share: f64) -> f64 {
        let whole = self.select_ms.iter().zip(&self.evaluate_ms);
        percentile(whole.map(|(a, b)| a + b).collect(), share)
    }

    /// Selection as a share of the evaluation that it governs, medians.
    pub(super) fn selection_share(&self) -> f64 {
        let evaluate = percentile(self.evaluate_ms.clone(), 0.5);
        percentile(self.select_ms.clone(), 0.5) / evaluate.max(1e-9)
    }
}

/// How a scene is played.
#[derive(Clone, Copy)]
pub(super) struct Play {
    pub(super) detail: Detail,
    pub(super) share: bool,
    pub(super) cache: CacheUse,
    pub(super) frames: usize,
    /// Characters that are looked at in every eighth frame: one of so many.
    pub(super) look_at_one_of: usize,
}

/// What is on the screen in a frame.
#[derive(Clone, Copy)]
struct Shown<'a> {
    /// Which of the frames that are looked at.
    number: usize,
    crowd: &'a Crowd,
    camera: Camera,
    rows: &'a [[f32; 4]],
}

/// Errors of the characters that were looked at, pixels.
#[derive(Default)]
pub(super) struct Errors {
    /// Of those that were drawn from all.
    pub(super) drawn: Vec<f32>,
    /// Greatest of those that are near, drawn or not.
    pub(super) near_px: f32,
}

impl Errors {
    /// Adds a character that is so far from the camera.
    pub(super) fn add(&mut self, px: f32, metres: f32, drawn: bool) {
        if metres < NEAR_METRES {
            self.near_px = self.near_px.max(px);
        }
        if drawn {
            self.drawn.push(px);
        }
    }
}

impl<'a> Stage<'a> {
    /// Levels, skins, errors and bounds of the bench's character with all its clips.
    pub(super) fn new(bench: &'a Bench) -> Result<Self> {
        let asset = &bench.asset;
        let levels = merged_levels(asset, &LevelOptions::default())?;
        let count = levels.ladder.levels();
        let meshes = (0..count).map(|l| levels.skins.mesh(l, &asset.mesh));
        let step = (asset.mesh.len() / POINTS).max(1);
        let clips = ClipSet::new(
            &asset.rig,
            levels.ladder.clone(),
            &asset.clips,
            Storage::Float,
        )?;
        let cached = cached_poses(asset, &levels, &clips, &CacheOptions::default())?;
        let model = CrowdModel::new(CrowdParts {
            clips,
            palette: levels.skins.palette.clone(),
            form: PaletteForm::Matrix,
            backend: Backend::best(),
            errors: levels.errors.clone(),
            bounds: motion_bounds(asset, 0.0)?,
        })?;
        Ok(Self {
            bench,
            meshes: meshes.collect(),
            vertices: (0..asset.mesh.len() as u32).step_by(step).collect(),
            model: model.with_cache(cached.cache)?,
        })
    }

    /// Joints that each level keeps.
    pub(super) fn kept(&self) -> Vec<usize> {
        let ladder = self.model.clips().ladder();
        (0..ladder.levels()).map(|l| ladder.kept(l)).collect()
    }

    /// Plays a scene from its beginning.
    pub(super) fn play(&self, scene: &Scene, play: Play) -> Result<Outcome> {
        let count = scene.members.len();
        let mut crowd = self.crowd(scene);
        let mut costs = CostModel::default();
        if matches!(play.detail, Detail::Budget { .. }) {
            crowd.set_budget(&self.model, NOBODY_WAITS, &costs)?;
        }
        let positions: Vec<Vec3> = scene.members.iter().map(|m| m.position).collect();
        let turn = |m: &Member| Quat::from_rotation_y(m.yaw_radians);
        let rotations: Vec<Quat> = scene.members.iter().map(turn).collect();
        let mut rows = Vec::new();
        let mut scratch = self.model.evaluator().scratch();
        let mut outcome = Outcome::default();
        let mut errors = Errors::default();
        for number in 0..WARM_UP + play.frames {
            let secs = number as f64 * f64::from(STEP_SECS);
            self.follow_fades(scene, &mut crowd);
            let camera = scene.camera_at(secs).context("the scene has a camera")?;
            let views = [View::of(&camera)];
            let frame = Frame {
                dt_secs: if number == 0 { 0.0 } else { STEP_SECS },
                positions: &positions,
                rotations: &rotations,
                scales: &[],
                wake_metres: &[],
                importance: &[],
                sight: Sight::Views(&views),
                detail: within(play.detail, &costs),
                share: play.share,
                cache: play.cache,
            };
            let start = thread_ns();
            let report = crowd.tick(&self.model, &frame, &mut |_| {});
            let selected = thread_ns();
            let wanted = crowd.matrices() * PaletteForm::Matrix.rows();
            if rows.len() < wanted {
                rows.resize(wanted, [0.0; 4]);
            }
            let ready = thread_ns();
            let batches = 0..crowd.batches().len();
            let out = PaletteRows::Float(&mut rows[..wanted]);
            crowd.evaluate(&self.model, batches, out, &mut scratch);
            let evaluated = thread_ns();
            costs.observe(&report.work, (evaluated - ready) as f64);
            if matches!(play.detail, Detail::Budget { .. }) && number % WARM_UP == WARM_UP - 1 {
                crowd.reprice(&self.model, &costs);
            }
            if number < WARM_UP {
                continue;
            }
            outcome.select_ms.push(1e-6 * (selected - start) as f64);
            outcome.evaluate_ms.push(1e-6 * (evaluated - ready) as f64);
            let records = size_of_val(crowd.records());
            outcome.add(&report, 16 * wanted + records, play.frames);
            if number.is_multiple_of(8) {
                let now = Shown {
                    number: number / 8,
                    crowd: &crowd,
                    camera,
                    rows: &rows,
                };
                self.look(scene, &now, play.look_at_one_of, &mut errors);
                self.look_at_records(scene, &now, play.look_at_one_of, &mut errors);
            }
        }
        let mut state = Crowd::BYTES_PER_CHARACTER * count + self.model.clips().bytes();
        if let (true, Some(cache)) = (play.cache != CacheUse::Never, self.model.cache()) {
            state += cache.bytes();
        }
        outcome.resident_mb = 1e-6 * (state + 16 * rows.len()) as f64;
        outcome.near_px = errors.near_px;
        outcome.p95_px = percentile_px(errors.drawn);
        Ok(outcome)
    }

    fn crowd(&self, scene: &Scene) -> Crowd {
        let mut crowd = Crowd::new(&self.model, scene.members.len());
        for (i, member) in scene.members.iter().enumerate() {
            let voice = self.voice(member.play, 0.0);
            let mut player = Player::from(voice);
            if let Some(fade) = member.cross_fade {
                // Fades that are under way begin at different times.
                let left = fade.fade_secs * (1.0 - fade.start);
                player.fade_to(self.voice(fade.other, 0.0), left.max(STEP_SECS));
            }
            crowd.play(i, player);
        }
        crowd
    }

    fn voice(&self, play: articula_build::scene::Play, secs: f64) -> Voice {
        let clips = self.model.clips();
        let duration = clips.duration_secs(play.clip);
        let at = play
            .clip_secs(secs, duration)
            .rem_euclid(f64::from(duration.max(1e-3)));
        Voice::new(clips, play.clip)
            .at_speed(play.speed)
            .at_secs(clips, at as f32)
    }

    /// Whoever has finished a fade starts the way back.
    fn follow_fades(&self, scene: &Scene, crowd: &mut Crowd) {
        for (i, member) in scene.members.iter().enumerate() {
            if let Some(fade) = member.cross_fade
                && !crowd.player(i).is_fading()
            {
                let there = crowd.player(i).voice().clip() == fade.other.clip;
                let next = if there { member.play } else { fade.other };
                crowd.fade_to(i, self.voice(next, 0.0), fade.fade_secs);
            }
        }
    }

    /// Looks at all characters that are near and at one of so many of all.
    fn look(&self, scene: &Scene, now: &Shown<'_>, look_at_one_of: usize, errors: &mut Errors) {
        for group in now.crowd.groups() {
            for draw in &now.crowd.draws()[group.draws.clone()] {
                let who = draw.character as usize;
                let member = &scene.members[who];
                let metres = member.position.distance(now.camera.eye);
                let drawn = who % look_at_one_of == now.number % look_at_one_of;
                if metres < NEAR_METRES || drawn {
                    let from = 3 * draw.first_matrix as usize;
                    let matrices = &now.rows[from..from + 3 * group.matrices];
                    let shown = self.shown_points(group.level, matrices);
                    let truth = self.true_points(now.crowd.player(who));
                    let px = distance_px(&now.camera, member, &shown, &truth);
                    errors.add(px, metres, drawn);
                }
            }
        }
    }

    /// The same of those that the GPU blends.
    fn look_at_records(
        &self,
        scene: &Scene,
        now: &Shown<'_>,
        look_at_one_of: usize,
        errors: &mut Errors,
    ) {
        let Some(CachedRows::Float(cached)) = self.model.cache().map(|c| c.rows()) else {
            return;
        };
        for group in now.crowd.record_groups() {
            for record in &now.crowd.records()[group.records.clone()] {
                let who = record.character as usize;
                let member = &scene.members[who];
                let metres = member.position.distance(now.camera.eye);
                let drawn = who % look_at_one_of == now.number % look_at_one_of;
                if metres < NEAR_METRES || drawn {
                    let of = |first: u32| &cached[3 * first as usize..][..3 * group.matrices];
                    let ends = of(record.before).iter().zip(of(record.after));
                    let mix = |(a, b): (&[f32; 4], &[f32; 4])| {
                        std::array::from_fn(|i| a[i] + (b[i] - a[i]) * record.blend)
                    };
                    let blended: Vec<[f32; 4]> = ends.map(mix).collect();
                    let shown = self.shown_points(group.level, &blended);
                    let truth = self.true_points(now.crowd.player(who));
                    let px = distance_px(&now.camera, member, &shown, &truth);
                    errors.add(px, metres, drawn);
                }
            }
        }
    }

    /// Watched points as the palette of a level shows them.
    fn shown_points(&self, level: usize, rows: &[[f32; 4]]) -> Vec<Vec3> {
        let mesh = &self.meshes[level];
        let mut matrices = vec![Affine3A::IDENTITY; mesh.bindings.len()];
        for (matrix, rows) in matrices.iter_mut().zip(rows.as_chunks::<3>().0) {
            let column = |c: usize| Vec3::new(rows[0][c], rows[1][c], rows[2][c]);
            let linear = glam::Mat3::from_cols(column(0), column(1), column(2));
            *matrix = Affine3A::from_mat3_translation(linear, column(3));
        }
        let mut points = vec![Vec3::ZERO; self.vertices.len()];
        skin_points(mesh, &matrices, &self.vertices, &mut points);
        points
    }

    /// The same points in the full pose of what a character plays, by the plain path.
    fn true_points(&self, player: &Player) -> Vec<Vec3> {
        let asset = &self.bench.asset;
        let pose = |voice: &Voice| {
            let mut pose = asset.rig.rest_pose().clone();
            let clip = &asset.clips[voice.clip()];
            let secs = f64::from(voice.secs());
            sample(clip, secs, Wrap::Clamp, &asset.rig.all(), &mut pose);
            pose
        };
        let mut local = pose(player.voice());
        if let Some(other) = player.next() {
            blend(&mut local, &pose(other), player.fade(), &asset.rig.all());
        }
        let mut model = ModelPose::new(asset.rig.len());
        local_to_model(&asset.rig, &local, &mut model);
        let mut matrices = vec![Affine3A::IDENTITY; asset.mesh.bindings.len()];
        palette(&asset.mesh, &model, &mut matrices);
        let mut points = vec![Vec3::ZERO; self.vertices.len()];
        skin_points(&asset.mesh, &matrices, &self.vertices, &mut points);
        points
    }
}

impl Outcome {
    fn add(&mut self, report: &CrowdReport, written: usize, frames: usize) {
        let frames = frames as f64;
        self.visible += report.visible as f64 / frames;
        self.poses += (report.own + report.leaders) as f64 / frames;
        self.written_mb += 1e-6 * written as f64 / frames;
    }
}

/// A budget with room for late frames.
fn within(detail: Detail, costs: &CostModel) -> Detail {
    match detail {
        Detail::Budget { cost } => Detail::Budget {
            cost: costs.spendable_ns(f64::from(cost)) as f32,
        },
        other => other,
    }
}

/// 95th percentile, over the points that are on the screen, of how far two skins of a character
/// are apart there.
pub(super) fn distance_px(camera: &Camera, member: &Member, shown: &[Vec3], truth: &[Vec3]) -> f32 {
    let place = member.world_from_model();
    let size = Vec2::new(camera.viewport.width_px, camera.viewport.height_px);
    let apart = shown.iter().zip(truth).filter_map(|(shown, truth)| {
        let (shown, _) = camera.project(place.transform_point3(*shown));
        let (truth, depth) = camera.project(place.transform_point3(*truth));
        let on_screen = truth.cmpge(Vec2::ZERO).all() && truth.cmple(size).all();
        (depth > NEAR_PLANE_METRES && on_screen).then(|| shown.distance(truth))
    });
    percentile_px(apart.collect())
}

/// 95th percentile, the value at or above it; 0 of nothing.
pub(super) fn percentile_px(values: Vec<f32>) -> f32 {
    percentile(values.into_iter().map(f64::from).collect(), 0.95) as f32
}

/// A percentile, the value at or above it; 0 of nothing.
pub(super) fn percentile(mut values: Vec<f64>, share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let at = (share * values.len().saturating_sub(1) as f64).ceil() as usize;
    values.get(at).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_off_the_screen_does_not_count() {
        use articula_build::scene::plaza;
        let scene = plaza(4, 1, 1);
        let camera = scene.camera_at(0.0).unwrap();
        let member = Member {
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
        assert_eq!(percentile_px(values), 95.0);
        assert_eq!(percentile_px(Vec::new()), 0.0);
        assert_eq!(percentile(vec![3.0, 1.0, 2.0], 0.5), 2.0);
    }
}

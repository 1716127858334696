//! One frame of a scene after the other: tick, then every batch into one output.
//!
//! Stands on `articula_core::crowd`; what is added is what a game has to bring: places, cameras,
//! the turns of endless cross-fades, and threads.

use super::cast::{Cast, Matrices};
use super::output::{Output, split};
use super::purse::Decision;
use super::timing::thread_ns;
use anyhow::{Context, bail};
use articula_build::scene::{CrossFade, Play, Scene};
use articula_core::batch::Scratch;
use articula_core::budget::{CostModel, Policy};
use articula_core::crowd::{CacheUse, Crowd, CrowdReport, Detail, Frame, Player, Sight, Voice};
use articula_core::visibility::View;
use articula_core::{BlendRecord, Camera, ClipSet, PaletteRows};
use glam::{Affine3A, Quat, Vec3};
use rayon::ThreadPool;
use rayon::prelude::*;
use std::ops::Range;

/// Frames a second of the display.
pub(crate) const DISPLAY_HZ: f64 = 60.0;

/// How far ahead the camera's way is looked at, so that characters wake before they are seen.
const AHEAD_SECS: f64 = 0.25;

/// Parts of a frame for each thread: more than one, so that none waits long for the others.
const PARTS_PER_THREAD: usize = 4;

/// Most bytes of palettes: what a program may ask for at once.
const MOST_BYTES: usize = 16 << 30;

/// How much detail the crowd gets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Wanted {
    /// Every joint of everyone, seen or not.
    Full,
    /// One level for everyone who is seen.
    Level(usize),
    /// The coarsest level within so many pixels.
    Tolerance(f32),
    /// The least visible error for so many milliseconds a frame; errors above so many pixels
    /// are mended first.
    Budget { ms: f32, cap_px: f32 },
}

/// How a scene is played.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Settings {
    pub(crate) wanted: Wanted,
    /// Whether characters may share poses within their tolerance.
    pub(crate) share: bool,
    /// Who blends cached poses.
    pub(crate) cache: CacheUse,
    pub(crate) threads: usize,
    /// Frames that count.
    pub(crate) frames: usize,
}

/// The members of a scene as a crowd, and the memory for their palettes.
#[derive(Debug)]
pub(crate) struct Stage<'a> {
    pub(crate) cast: &'a Cast,
    pub(crate) scene: &'a Scene,
    pub(crate) crowd: Crowd,
    pub(crate) output: Output,
    pub(crate) positions: Vec<Vec3>,
    pub(crate) rotations: Vec<Quat>,
    /// Time of the scene.
    pub(crate) secs: f64,
    settings: Settings,
    fades: Vec<Turning>,
    scratches: Vec<Scratch>,
    pool: Option<ThreadPool>,
}

/// From where a character is shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Source {
    /// From the palettes of the frame: index of its first matrix.
    Written(usize),
    /// From the cache, by the GPU.
    Record(BlendRecord),
}

/// A cross-fade that goes to and fro.
#[derive(Debug, Clone, Copy)]
struct Turning {
    character: usize,
    own: Play,
    fade: CrossFade,
    /// Whether it goes to the other clip, or comes back.
    goes: bool,
}

/// A range of batches with what a thread needs for it.
struct Part<'a> {
    batches: Range<usize>,
    rows: PaletteRows<'a>,
    scratch: &'a mut Scratch,
    ns: u64,
}

impl<'a> Stage<'a> {
    /// Puts everyone in place at time 0.
    pub(crate) fn new(
        cast: &'a Cast,
        scene: &'a Scene,
        settings: Settings,
    ) -> anyhow::Result<Self> {
        let model = &cast.model;
        let mut crowd = Crowd::new(model, scene.members.len());
        let mut fades = Vec::new();
        for (character, member) in scene.members.iter().enumerate() {
            let own = voice(model.clips(), &member.play, 0.0);
            let Some(fade) = member.cross_fade else {
                crowd.play(character, own.into());
                continue;
            };
            let turning = Turning {
                character,
                own: member.play,
                fade,
                goes: fade.start.rem_euclid(1.0) < 0.5,
            };
            crowd.play(character, turning.start(model.clips()));
            if fade.fade_secs > 0.0 {
                fades.push(turning);
            }
        }
        if let Wanted::Budget { cap_px, .. } = settings.wanted {
            let policy = Policy {
                cap_px,
                // Everyone is posed in every frame, so nobody waits.
                patience_frames: 0,
                ..Policy::default()
            };
            crowd.set_budget(model, policy, &CostModel::default())?;
        }
        let parts = if settings.threads > 1 {
            PARTS_PER_THREAD * settings.threads
        } else {
            1
        };
        let pool = (settings.threads > 1).then(|| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(settings.threads);
            pool.build().context("threads")
        });
        let turn = |yaw: f32| Quat::from_rotation_y(yaw);
        Ok(Self {
            output: Output::new(model.form(), room(cast, scene.members.len())?),
            positions: scene.members.iter().map(|m| m.position).collect(),
            rotations: scene.members.iter().map(|m| turn(m.yaw_radians)).collect(),
            scratches: (0..parts).map(|_| model.evaluator().scratch()).collect(),
            pool: pool.transpose()?,
            secs: 0.0,
            cast,
            scene,
            crowd,
            settings,
            fades,
        })
    }

    /// The camera of this moment.
    pub(crate) fn camera(&self) -> anyhow::Result<Camera> {
        self.scene
            .camera_at(self.secs)
            .context("the scene has no camera")
    }

    /// Goes on by some time and plans the frame.
    pub(crate) fn tick(
        &mut self,
        dt_secs: f64,
        decision: Option<&Decision>,
    ) -> anyhow::Result<CrowdReport> {
        self.secs += dt_secs;
        let camera = self.camera()?;
        let (way, turn) = self.ahead(&camera);
        let views = [View::of(&camera).moving(way, turn)];
        let model = &self.cast.model;
        if let Some(decision) = decision {
            decision.apply(&mut self.crowd, model);
        }
        self.turn_fades();
        let frame = Frame {
            dt_secs: dt_secs as f32,
            positions: &self.positions,
            rotations: &self.rotations,
            scales: &[],
            wake_metres: &[],
            importance: &[],
            sight: match self.settings.wanted {
                Wanted::Full => Sight::Everyone,
                _ => Sight::Views(&views),
            },
            detail: match self.settings.wanted {
                Wanted::Full => Detail::Full,
                Wanted::Level(level) => Detail::Level(level),
                Wanted::Tolerance(px) => Detail::Tolerance { px },
                Wanted::Budget { .. } => Detail::Budget {
                    cost: decision.map_or(0.0, |d| d.cost),
                },
            },
            share: self.settings.share,
            cache: self.settings.cache,
        };
        Ok(self.crowd.tick(model, &frame, &mut |_| ()))
    }

    /// Writes all palettes; gives the processor time that it took, on all threads together.
    pub(crate) fn evaluate(&mut self) -> u64 {
        let model = &self.cast.model;
        let crowd = &self.crowd;
        let rows = self.output.first(crowd.matrices());
        let all = 0..crowd.batches().len();
        let (Some(pool), [_, _, ..]) = (&self.pool, &self.scratches[..]) else {
            let start = thread_ns();
            crowd.evaluate(model, all, rows, &mut self.scratches[0]);
            return thread_ns() - start;
        };
        let mut parts = parts_of(crowd, model.form().rows(), rows, &mut self.scratches);
        pool.install(|| {
            parts.par_iter_mut().for_each(|part| {
                let start = thread_ns();
                let count = part.rows.len();
                let rows = part.rows.part(0..count);
                crowd.evaluate(model, part.batches.clone(), rows, part.scratch);
                part.ns = thread_ns() - start;
            });
        });
        parts.iter().map(|p| p.ns).sum()
    }

    /// From where each character is shown; `None` for those who are not.
    pub(crate) fn sources(&self) -> Vec<Option<Source>> {
        let mut sources = vec![None; self.positions.len()];
        for draw in self.crowd.draws() {
            let first = draw.first_matrix as usize;
            sources[draw.character as usize] = Some(Source::Written(first));
        }
        for record in self.crowd.records() {
            sources[record.character as usize] = Some(Source::Record(*record));
        }
        sources
    }

    /// The matrices of a level's bindings as a character shows them.
    pub(crate) fn shown_palette(&self, level: usize, source: &Source, out: &mut Vec<Affine3A>) {
        let cast = self.cast;
        let blended;
        let (rows, first) = match source {
            Source::Written(first) => (&self.output, *first),
            Source::Record(record) => {
                blended = self.blended(level, *record);
                (&blended, 0)
            }
        };
        out.clear();
        let bindings = cast.meshes[level].bindings.iter().enumerate();
        out.extend(bindings.map(|(b, binding)| match cast.matrices {
            Matrices::Skin => rows.matrix(first + b),
            Matrices::Joints => {
                let place = cast.ladder().place(usize::from(binding.joint));
                rows.matrix(first + place) * binding.inverse_bind
            }
        }));
    }

    /// What a vertex shader makes of a record.
    fn blended(&self, level: usize, record: BlendRecord) -> Output {
        let model = &self.cast.model;
        let matrices = model.palette().len(level);
        let mut rows = Output::new(model.form(), matrices);
        if let Some(cache) = model.cache() {
            cache.blend(level, &[record], model.backend(), rows.first(matrices));
        }
        rows
    }

    /// How far the camera goes and turns in the time ahead, metres and radians.
    fn ahead(&self, camera: &Camera) -> (f32, f32) {
        let Some(later) = self.scene.camera_at(self.secs + AHEAD_SECS) else {
            return (0.0, 0.0);
        };
        if later.eye == camera.eye && later.orientation == camera.orientation {
            return (0.0, 0.0);
        }
        let way = later.eye.distance(camera.eye);
        (way, later.orientation.angle_between(camera.orientation))
    }

    /// Sends cross-fades that have arrived the other way.
    fn turn_fades(&mut self) {
        for turning in &mut self.fades {
            if !self.crowd.player(turning.character).is_fading() {
                turning.goes = !turning.goes;
                let next = turning.next(self.cast.model.clips(), self.secs);
                let fade_secs = turning.fade.fade_secs;
                self.crowd.fade_to(turning.character, next, fade_secs);
            }
        }
    }
}

impl Turning {
    /// What it plays at time 0.
    fn start(&self, clips: &ClipSet) -> Player {
        let own = voice(clips, &self.own, 0.0);
        let other = voice(clips, &self.fade.other, 0.0);
        let share = self.fade.share(0.0);
        if self.fade.fade_secs > 0.0 && self.goes {
            Player::fading(own, other, share, self.fade.fade_secs)
        } else if self.fade.fade_secs > 0.0 {
            Player::fading(other, own, 1.0 - share, self.fade.fade_secs)
        } else {
            Player::blend(own, other, share)
        }
    }

    /// Where it goes to now.
    fn next(&self, clips: &ClipSet, secs: f64) -> Voice {
        let play = if self.goes {
            &self.fade.other
        } else {
            &self.own
        };
        voice(clips, play, secs)
    }
}

/// A clip at a time of the scene.
fn voice(clips: &ClipSet, play: &Play, secs: f64) -> Voice {
    let duration = clips.duration_secs(play.clip);
    let secs = play.clip_secs(secs, duration) as f32;
    Voice::new(clips, play.clip)
        .at_speed(play.speed)
        .at_secs(clips, secs)
}

/// Matrices that a frame may need: everyone in full detail.
fn room(cast: &Cast, characters: usize) -> anyhow::Result<usize> {
    let matrices = characters.saturating_mul(cast.model.palette().len(0));
    let bytes = matrices.saturating_mul(cast.model.form().bytes());
    if bytes > MOST_BYTES {
        bail!(
            "--count {characters}: {:.1} GB of palettes, the limit is {:.1}; lower the count or choose a smaller --form",
            bytes as f64 / 1e9,
            MOST_BYTES as f64 / 1e9
        );
    }
    Ok(matrices)
}

/// Cuts a frame into one part for each scratch at most.
fn parts_of<'s>(
    crowd: &Crowd,
    rows_per_matrix: usize,
    mut rows: PaletteRows<'s>,
    scratches: &'s mut [Scratch],
) -> Vec<Part<'s>> {
    let (count, all) = (scratches.len(), crowd.batches().len());
    let mut parts = Vec::with_capacity(count);
    let mut first = 0;
    for (i, scratch) in scratches.iter_mut().enumerate() {
        let mut batches = crowd.share_of_batches(first, count);
        if i + 1 == count {
            batches.end = all;
        }
        if batches.is_empty() {
            break;
        }
        first = batches.end;
        let matrices = crowd.matrices_of(batches.clone()).len();
        let (mine, rest) = split(rows, matrices * rows_per_matrix);
        rows = rest;
        parts.push(Part {
            batches,
            rows: mine,
            scratch,
            ns: 0,
        });
    }
    parts
}

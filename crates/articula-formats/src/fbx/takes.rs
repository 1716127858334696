//! Takes at the frames of the file's own rate, and between them where a blend of frames would be far off.
//!
//! Curves of Euler angles are evaluated, never blended over more than a frame. A constant curve changes within
//! [`JUMP_SECS`].

use super::scene::{Moment, Scene, Stack};
use super::source::Reader;
use crate::error::ReadError;
use crate::limits::Limits;
use articula_core::LibmQuat;
use articula_core::source::JUMP_SECS;
use articula_core::{Transform, angle_between, same_hemisphere};
use glam::{Affine3A, Quat, Vec3};

/// Ticks per second, to which the times of keys are rounded.
const TICKS: f64 = 46_186_158_000.0;

/// Rates at which a take is read; others are multiplied or divided by whole numbers.
const LEAST_HZ: f64 = 20.0;
const MOST_HZ: f64 = 120.0;

/// Work of evaluating all takes: this much, and more for each key.
const WORK: usize = 1 << 20;
const WORK_PER_KEY: usize = 64;

/// Differences up to this size are no motion.
pub(super) const STILL: f32 = 1e-6;

/// Distance in metres of a node from the blend of two frames, half way between them, from which there are
/// frames between them too.
const OFF_METRES: f32 = 0.02;
/// How often a frame is halved at most.
const HALVES: i32 = 2;
/// Turn in radians off that blend which is no motion, but an accident of angles that stand for one rotation.
const ACCIDENT: f32 = 1.5;

/// A take: all nodes and channels of blend shapes at its frames.
pub(super) struct Take {
    pub(super) stack: Stack,
    pub(super) duration_secs: f32,
    pub(super) frames: Vec<Frame>,
    /// By node of the scene.
    pub(super) tracks: Vec<Track>,
    /// By channel of the scene.
    pub(super) amounts: Vec<Vec<f64>>,
}

/// A moment of a take.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    pub(super) secs: f32,
    /// Whether it is between those of the rate.
    pub(super) is_extra: bool,
    /// The next one of the rate.
    pub(super) next: Option<usize>,
}

/// The motion of a node: one value for each frame, or a single one.
#[derive(Default)]
pub(super) struct Track {
    pub(super) translations: Vec<Vec3>,
    pub(super) rotations: Vec<Quat>,
    pub(super) scales: Vec<Vec3>,
}

impl Track {
    /// Whether the node moves.
    pub(super) fn moves(&self) -> bool {
        self.translations.len() > 1 || self.rotations.len() > 1 || self.scales.len() > 1
    }

    /// Whether the node has no transform of its own at any time.
    pub(super) fn is_identity(&self) -> bool {
        let is_unturned = |r: &Quat| angle_between(*r, Quat::IDENTITY) <= STILL;
        !self.moves()
            && self.translations.iter().all(|t| t.length() <= STILL)
            && self.rotations.iter().all(is_unturned)
            && self.scales.iter().all(|s| s.distance(Vec3::ONE) <= STILL)
    }

    fn add(&mut self, local: Transform) {
        let turned = match self.rotations.last() {
            Some(last) => same_hemisphere(*last, local.rotation),
            None => local.rotation,
        };
        self.translations.push(local.translation);
        self.rotations.push(turned);
        self.scales.push(local.scale);
    }

    /// Leaves one value where all are equal.
    fn settle(&mut self) {
        let near = |a: &Vec3, b: &Vec3| a.distance(*b) <= STILL * a.length().max(1.0);
        settle(&mut self.translations, near);
        settle(&mut self.rotations, |a, b| angle_between(*a, *b) <= STILL);
        settle(&mut self.scales, near);
    }
}

fn settle<T>(values: &mut Vec<T>, near: impl Fn(&T, &T) -> bool) {
    if values.iter().all(|value| near(&values[0], value)) {
        values.truncate(1);
    }
}

/// Evaluates the takes that move anything.
pub(super) fn sampled(reader: &mut Reader<'_>) -> Result<Vec<Take>, ReadError> {
    let stacks = reader.scene.stacks()?;
    let keys: usize = stacks.iter().map(|stack| stack.key_count).sum();
    let mut work = keys.saturating_mul(WORK_PER_KEY).saturating_add(WORK);
    let mut takes = Vec::new();
    for (index, stack) in stacks.into_iter().enumerate() {
        let Some(keys) = stack.keys else {
            let what = "a take moves nothing that is read; left out";
            reader.kinds.note(|| place(&stack), what);
            continue;
        };
        takes.push(sample(reader, index, stack, keys, &mut work)?);
    }
    Ok(takes)
}

/// The place of a take in errors and warnings.
pub(super) fn place(stack: &Stack) -> String {
    format!("take \"{}\"", stack.name)
}

fn sample(
    reader: &Reader<'_>,
    index: usize,
    stack: Stack,
    keys: (f64, f64),
    work: &mut usize,
) -> Result<Take, ReadError> {
    let span = match stack.end > stack.begin && (stack.end - stack.begin).is_finite() {
        true => (stack.begin, stack.end),
        false => keys,
    };
    let rate_hz = rate(reader.scene.rate_hz());
    let count = ((span.1 - span.0) * rate_hz).max(0.0);
    // A number too large for 64 bits becomes the largest.
    Limits::check(place(&stack), "frames", count as u64, reader.limits.frames)?;
    let keys = if stack.goes_on { span } else { keys };
    let mut player = Player {
        scene: reader.scene,
        index,
        stack: &stack,
        begin: span.0,
        work,
        rows: Vec::new(),
    };
    player.play(&frames(span, keys, rate_hz), false)?;
    for halved in 0..HALVES {
        let between = player.far_off(1.5 / rate_hz * 0.5_f64.powi(halved))?;
        player.play(&between, true)?;
    }
    let jumps = player.jumps(span.1);
    player.play(&jumps, true)?;
    let rows = rising(player.rows);
    let scene = reader.scene;
    let mut take = Take {
        duration_secs: (span.1 - span.0) as f32,
        frames: Vec::with_capacity(rows.len()),
        tracks: scene.nodes.iter().map(|_| Track::default()).collect(),
        amounts: vec![Vec::with_capacity(rows.len()); scene.channel_count()],
        stack,
    };
    for row in rows {
        take.frames.push(Frame {
            secs: row.secs as f32,
            is_extra: row.is_extra,
            next: None,
        });
        for (track, local) in take.tracks.iter_mut().zip(row.locals) {
            track.add(local);
        }
        for (list, amount) in take.amounts.iter_mut().zip(row.amounts) {
            list.push(amount);
        }
    }
    let mut next = None;
    for (index, frame) in take.frames.iter_mut().enumerate().rev() {
        frame.next = next;
        if !frame.is_extra {
            next = Some(index);
        }
    }
    take.tracks.iter_mut().for_each(Track::settle);
    Ok(take)
}

/// The rate at which takes are read, of the one by which the file is shown.
fn rate(shown_hz: f64) -> f64 {
    match shown_hz {
        hz if !(1e-3..=1e6).contains(&hz) => 30.0,
        hz if hz < LEAST_HZ => hz * (LEAST_HZ / hz).ceil(),
        hz if hz > MOST_HZ => hz / (hz / MOST_HZ).ceil(),
        hz => hz,
    }
}

/// Seconds after the begin of the frames of a take. Nothing moves outside of the keys, so there only the first
/// and the last frame are.
fn frames((begin, end): (f64, f64), keys: (f64, f64), rate_hz: f64) -> Vec<f64> {
    let last = ((end - begin) * rate_hz + 1e-4).floor().max(0.0);
    let from = ((keys.0 - begin) * rate_hz).floor().clamp(0.0, last);
    let to = ((keys.1 - begin) * rate_hz).ceil().clamp(from, last);
    // Within the limits, so the numbers are exact.
    let moving = (from as u64..=to as u64).map(|frame| frame as f64);
    let all = [0.0].into_iter().chain(moving).chain([last]);
    let length = end - begin;
    let mut secs: Vec<f64> = all.map(|frame| (frame / rate_hz).min(length)).collect();
    secs.push(length);
    secs.dedup_by(|b, a| *b - *a < 0.1 * f64::from(JUMP_SECS));
    secs
}

/// A take while it is evaluated.
struct Player<'p> {
    scene: &'p Scene,
    index: usize,
    stack: &'p Stack,
    begin: f64,
    work: &'p mut usize,
    rows: Vec<Row>,
}

/// All that moves at one time.
struct Row {
    secs: f64,
    is_extra: bool,
    locals: Vec<Transform>,
    amounts: Vec<f64>,
}

impl Player<'_> {
    fn play(&mut self, times: &[f64], is_extra: bool) -> Result<(), ReadError> {
        self.charge(times.len())?;
        for &secs in times {
            let moment = self.moment(secs)?;
            let amounts = (0..self.scene.channel_count()).map(|c| moment.amount(c));
            let row = Row {
                secs,
                is_extra,
                locals: self.locals(&moment),
                amounts: amounts.collect(),
            };
            self.rows.push(row);
        }
        Ok(())
    }

    fn charge(&mut self, moments: usize) -> Result<(), ReadError> {
        let cost = moments.saturating_mul(self.stack.work);
        let at = place(self.stack);
        Limits::check(at, "evaluations of nodes", cost as u64, *self.work as u64)?;
        *self.work -= cost;
        Ok(())
    }

    fn moment(&self, secs: f64) -> Result<Moment, ReadError> {
        let secs = ((self.begin + secs) * TICKS).round() / TICKS;
        self.scene.moment(self.index, secs)
    }

    /// Local transforms; where the evaluated one has other than finite numbers, the stored one.
    fn locals(&self, moment: &Moment) -> Vec<Transform> {
        let nodes = self.scene.nodes.iter().enumerate();
        nodes
            .map(|(index, node)| {
                let both = [moment.local(index), node.local].map(|l| l.transform());
                let known = both.into_iter().find(Transform::is_finite);
                known.unwrap_or_default()
            })
            .collect()
    }

    /// Times half way between frames at most `gap` seconds apart whose blend is far off.
    fn far_off(&mut self, gap: f64) -> Result<Vec<f64>, ReadError> {
        let mut times = Vec::new();
        self.rows.sort_by(|a, b| a.secs.total_cmp(&b.secs));
        for next in 1..self.rows.len() {
            let [from, to] = [self.rows[next - 1].secs, self.rows[next].secs];
            if to - from > gap {
                continue;
            }
            self.charge(1)?;
            let half = 0.5 * (from + to);
            let wanted = self.locals(&self.moment(half)?);
            let (a, b) = (&self.rows[next - 1].locals, &self.rows[next].locals);
            if self.is_far_off(a, b, &wanted) {
                times.push(half);
            }
        }
        Ok(times)
    }

    /// Whether any node is far off half way between two frames.
    fn is_far_off(&self, a: &[Transform], b: &[Transform], wanted: &[Transform]) -> bool {
        let mut worlds: Vec<[Affine3A; 2]> = Vec::with_capacity(a.len());
        for (index, node) in self.scene.nodes.iter().enumerate() {
            let (from, to) = (a[index], b[index]);
            let turn = same_hemisphere(from.rotation, to.rotation);
            let blend = Transform {
                translation: from.translation.lerp(to.translation, 0.5),
                rotation: from.rotation.libm_slerp(turn, 0.5),
                scale: from.scale.lerp(to.scale, 0.5),
            };
            let is_accident = angle_between(blend.rotation, wanted[index].rotation) > ACCIDENT;
            let wanted = if is_accident { blend } else { wanted[index] };
            let above = node.parent.and_then(|p| worlds.get(p)).copied();
            let [x, y] = above.unwrap_or([Affine3A::IDENTITY; 2]);
            let pair = [x * blend.to_affine(), y * wanted.to_affine()];
            if pair[0].translation.distance(pair[1].translation) > OFF_METRES {
                return true;
            }
            worlds.push(pair);
        }
        false
    }

    /// Times around changes at once.
    fn jumps(&self, end: f64) -> Vec<f64> {
        let pairs = self.stack.jumps.iter();
        let pairs = pairs.flat_map(|jump| [*jump, *jump + f64::from(JUMP_SECS)]);
        let pairs = pairs.map(|secs| secs - self.begin);
        let mut times: Vec<f64> = pairs
            .filter(|t| (0.0..=end - self.begin).contains(t))
            .collect();
        times.sort_by(f64::total_cmp);
        times.dedup();
        times
    }
}

/// Rows in the order of their times; of two at one time, the one of the rate.
fn rising(mut rows: Vec<Row>) -> Vec<Row> {
    rows.sort_by(|a, b| a.secs.total_cmp(&b.secs));
    let mut rising: Vec<Row> = Vec::with_capacity(rows.len());
    for row in rows {
        match rising.last_mut() {
            Some(last)
                if row.secs - last.secs < 0.1 * f64::from(JUMP_SECS)
                    || row.secs as f32 <= last.secs as f32 =>
            {
                if last.is_extra && !row.is_extra {
                    *last = row;
                }
            }
            _ => rising.push(row),
        }
    }
    rising
}

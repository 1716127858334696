//! Finds the part of a clip whose end continues into its start with the smallest jump.
//!
//! Source: the distance between frames of Kovar, Gleicher and Pighin, Motion Graphs, SIGGRAPH 2002:
//! joint positions around both frames, after the ground is aligned. Differs: each frame is aligned
//! to its own trajectory once, instead of every pair to each other, and the neighbourhood of a
//! frame is represented by its velocity. A pair then costs about a hundred floats, so that all
//! pairs can be compared.

use super::super::root_motion::trajectory::Trajectory;
use super::super::subject::EditSubject;
use crate::clip::steps_at;
use crate::sampling_rate::source_rate_hz;
use articula_core::LibmQuat;
use articula_core::source::RawClip;
use articula_core::{Mismatch, Region};
use glam::{Quat, Vec3};

/// Maximum number of frames that are compared with each other; longer clips are sampled at a lower
/// rate.
const MAX_FRAMES: usize = 2048;

/// Highest rate at which frames are compared.
const COMPARED_HZ: f32 = 60.0;

/// Weight of a velocity difference: it counts as the distance covered in this time.
const VELOCITY_SECS: f32 = 0.1;

/// Velocities are central differences over this time to both sides.
const AROUND_SECS: f32 = 1.0 / 60.0;

/// A loop must leave its first pose by at least this share of the clip's overall spread.
const MIN_REACH: f32 = 0.5;

/// A clip whose end poses differ nowhere by more than this share of the figure's height is a loop
/// as it is: 1 cm for an adult.
const WHOLE_SEAM: f32 = 0.006;

/// A shorter loop is preferred over a better one up to this factor in distance.
const NEARLY: f32 = 1.5;

/// Minimum [score](LoopCycle::score) of a loop: the ends differ by at most a fifth of the typical
/// distance between poses of the clip.
pub const MIN_SCORE: f32 = 0.8;

/// Subdivisions of a frame to which the ends of a loop are refined.
const PARTS: usize = 4;

/// Minimum length of a loop.
const MIN_SECS: f32 = 0.4;

/// A part of a clip and the jump from its end to its start. Root motion does not count: both frames
/// are aligned to the position and heading of the hips.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoopCycle {
    /// Start of the part, seconds.
    pub start_secs: f32,
    /// End of the part, seconds; playback continues from the start.
    pub end_secs: f32,
    /// Maximum jump of a joint at the seam, metres.
    pub seam_metres: f32,
    /// Root mean square of the jumps of the joints, metres.
    pub seam_rms_metres: f32,
    /// Root mean square of the velocity differences of the joints, metres per second.
    pub seam_metres_per_sec: f32,
    /// Quality of the seam: 1 if neither poses nor velocities jump, 0 if they differ as much as two
    /// very different frames of the clip. For a whole clip, at whose ends velocities are one-sided,
    /// the score is of the poses alone.
    pub score: f32,
    /// Whether the part qualifies as a loop: its score is at least [`MIN_SCORE`], or it is the
    /// whole clip and its ends meet.
    pub is_loop: bool,
    /// Whether the part is the whole clip, whose ends meet within 0.6 % of the figure's height.
    pub is_whole: bool,
}

/// Poses of a clip aligned to their trajectory, for comparison.
struct Frames {
    times: Vec<f32>,
    joints: usize,
    /// For each frame the positions of all joints, then their displacements in [`VELOCITY_SECS`].
    points: Vec<Vec3>,
}

impl Frames {
    fn at(subject: &EditSubject<'_>, clip: &RawClip, around_secs: f32, times: Vec<f32>) -> Self {
        let joints = compared(subject);
        let trajectory = Trajectory::new(subject, clip, 0.0);
        let mut posed = subject.rest();
        let mut points = Vec::with_capacity(2 * times.len() * joints.len());
        let hips = subject.hips();
        let mut world = |secs: f32| -> (Vec3, Vec<Vec3>) {
            subject.pose(clip, secs, &mut posed);
            let ground = posed.model.position(hips) * Vec3::new(1.0, 0.0, 1.0);
            let joints = joints.iter().map(|j| posed.model.position(*j));
            (ground, joints.collect())
        };
        for key in trajectory.keys(&times) {
            let back = Quat::libm_rotation_y(-key.yaw_radians);
            let from = (key.secs - around_secs).max(0.0);
            let to = (key.secs + around_secs).min(clip.duration_secs);
            let ((_, before), (_, after)) = (world(from), world(to));
            let (ground, now) = world(key.secs);
            points.extend(now.iter().map(|p| back * (*p - ground)));
            let ways = before.iter().zip(&after);
            let secs = VELOCITY_SECS / (to - from).max(1e-6);
            points.extend(ways.map(|(a, b)| back * (*b - *a) * secs));
        }
        Self {
            times,
            joints: joints.len(),
            points,
        }
    }

    fn frame(&self, i: usize) -> (&[Vec3], &[Vec3]) {
        let at = 2 * i * self.joints;
        let (middle, end) = (at + self.joints, at + 2 * self.joints);
        (&self.points[at..middle], &self.points[middle..end])
    }

    /// Difference of two frames, velocities included; metres.
    fn distance(&self, i: usize, j: usize) -> f32 {
        let ((p, v), (q, w)) = (self.frame(i), self.frame(j));
        let squares = |a: &[Vec3], b: &[Vec3]| -> f32 {
            let pairs = a.iter().zip(b);
            pairs.map(|(a, b)| a.distance_squared(*b)).sum()
        };
        ((squares(p, q) + squares(v, w)) / self.joints as f32).sqrt()
    }

    /// Typical distance between the poses of the clip: the median, over some frames, of the
    /// distance that one in ten of the other frames exceeds. Single odd frames, such as a T-pose
    /// before a capture, have no effect.
    fn spread(&self) -> f32 {
        let frames = self.times.len();
        let at = |mut sorted: Vec<f32>, part: f32| {
            sorted.sort_by(f32::total_cmp);
            sorted[((sorted.len() - 1) as f32 * part) as usize]
        };
        let far = |i: usize| at((0..frames).map(|j| self.distance(i, j)).collect(), 0.9);
        at(
            (0..frames).step_by(frames.div_ceil(64)).map(far).collect(),
            0.5,
        )
    }

    fn cycle(&self, i: usize, j: usize, spread: f32) -> LoopCycle {
        let ((p, v), (q, w)) = (self.frame(i), self.frame(j));
        let mean = |a: &[Vec3], b: &[Vec3]| -> f32 {
            let pairs = a.iter().zip(b);
            let squares = pairs.map(|(a, b)| a.distance_squared(*b));
            (squares.sum::<f32>() / self.joints as f32).sqrt()
        };
        let apart = p.iter().zip(q).map(|(a, b)| a.distance(*b));
        let score = 1.0 - self.distance(i, j) / spread.max(1e-9);
        LoopCycle {
            start_secs: self.times[i],
            end_secs: self.times[j],
            seam_metres: apart.fold(0.0, f32::max),
            seam_rms_metres: mean(p, q),
            seam_metres_per_sec: mean(v, w) / VELOCITY_SECS,
            score,
            is_loop: score >= MIN_SCORE,
            is_whole: false,
        }
    }
}

/// The joints whose positions are compared: those mapped to H-Anim, except hands and face, which
/// are many and small. Where fewer than four are known, all joints of the skin.
fn compared(subject: &EditSubject<'_>) -> Vec<usize> {
    let articulation = &subject.rig.articulation().joints;
    let body = |j: &usize| {
        let joint = &articulation[*j];
        joint.hanim.is_some() && !matches!(joint.region, Region::Hands | Region::Face)
    };
    let body: Vec<usize> = (0..subject.rig.len()).filter(body).collect();
    if body.len() >= 4 {
        return body;
    }
    let skin: Vec<usize> = subject.rig.skin_joints().iter().collect();
    if skin.is_empty() {
        (0..subject.rig.len()).collect()
    } else {
        skin
    }
}

/// The best part for every length: its first frame and the distance across its seam.
fn by_length(frames: &Frames, least: usize, spread: f32) -> Vec<Option<(usize, f32)>> {
    let count = frames.times.len();
    let mut best: Vec<Option<(usize, f32)>> = vec![None; count];
    for i in 0..count {
        // A part that hardly moves is no loop, however well its ends meet.
        let mut reach = 0.0f32;
        for j in i + 1..count {
            let distance = frames.distance(i, j);
            reach = reach.max(distance);
            let slot = &mut best[j - i];
            if j - i >= least
                && reach >= MIN_REACH * spread
                && slot.is_none_or(|(_, d)| distance < d)
            {
                *slot = Some((i, distance));
            }
        }
    }
    best
}

/// Finds the part of a clip that repeats best: the whole clip if its ends meet, otherwise the
/// shortest part that is nearly as good as the best. Returns `None` if the clip is shorter than the
/// shortest loop or never leaves its first pose.
///
/// # Errors
/// A [`Mismatch`] if the clip does not belong to this character or is too long to be analysed.
pub fn find_loop(subject: &EditSubject<'_>, clip: &RawClip) -> Result<Option<LoopCycle>, Mismatch> {
    subject.check(clip)?;
    let source_hz = source_rate_hz(clip);
    let rate = source_hz.min(COMPARED_HZ);
    let steps = steps_at(clip, clip.duration_secs, rate, 1)?;
    let rate = rate * (MAX_FRAMES as f32 / steps.max(1) as f32).min(1.0);
    let least = (MIN_SECS * rate).ceil() as usize;
    let count = (clip.duration_secs * rate) as usize + 1;
    if count < 3 || count <= least {
        return Ok(None);
    }
    let around = (1.0 / source_hz).max(AROUND_SECS);
    let at = |times: Vec<f32>| Frames::at(subject, clip, around, times);
    let frames = at((0..count).map(|i| i as f32 / rate).collect());
    let spread = frames.spread();
    let whole = at(vec![0.0, clip.duration_secs]).cycle(0, 1, spread);
    if whole.seam_metres <= WHOLE_SEAM * height(subject) {
        let score = 1.0 - whole.seam_rms_metres / spread.max(1e-9);
        return Ok(Some(LoopCycle {
            score,
            is_loop: true,
            is_whole: true,
            ..whole
        }));
    }
    let Some((i, j)) = shortest(&by_length(&frames, least, spread)) else {
        return Ok(None);
    };
    let cycle = refined(&frames, i, j, spread, clip.duration_secs, at);
    Ok(Some(cycle))
}

/// First and last frame of the shortest part that is nearly as good as the best: the first local
/// minimum of that quality over the length.
fn shortest(best: &[Option<(usize, f32)>]) -> Option<(usize, usize)> {
    let distance = |length: usize| best[length].map_or(f32::INFINITY, |(_, d)| d);
    let least = (0..best.len()).map(distance).fold(f32::INFINITY, f32::min);
    let first = (0..best.len()).find(|l| distance(*l) <= NEARLY * least)?;
    let valley = first..best.len().min(first + first / 4 + 2);
    let length = valley.min_by(|a, b| distance(*a).total_cmp(&distance(*b)))?;
    best[length].map(|(start, _)| (start, start + length))
}

/// The same part with its ends refined by less than a frame.
fn refined(
    frames: &Frames,
    i: usize,
    j: usize,
    spread: f32,
    end_secs: f32,
    at: impl Fn(Vec<f32>) -> Frames,
) -> LoopCycle {
    let step = (frames.times[1] - frames.times[0]) / PARTS as f32;
    let near = |k: usize| {
        let time = frames.times[k];
        let around = (0..2 * PARTS + 1).map(move |p| time + (p as f32 - PARTS as f32) * step);
        around.filter(move |t| (0.0..=end_secs).contains(t))
    };
    let starts = near(i).count();
    let fine = at(near(i).chain(near(j)).collect());
    let pairs = (0..starts).flat_map(|a| (starts..fine.times.len()).map(move |b| (a, b)));
    let best = pairs.min_by(|x, y| {
        let distance = |p: &(usize, usize)| fine.distance(p.0, p.1);
        distance(x).total_cmp(&distance(y))
    });
    best.map_or_else(
        || frames.cycle(i, j, spread),
        |(a, b)| fine.cycle(a, b, spread),
    )
}

/// Height of the compared joints, at rest.
fn height(subject: &EditSubject<'_>) -> f32 {
    let rest = subject.rest();
    let heights = compared(subject)
        .into_iter()
        .map(|j| rest.model.position(j).y);
    let (low, high) = heights.fold((f32::MAX, f32::MIN), |(l, h), y| (l.min(y), h.max(y)));
    (high - low).max(0.0)
}

//! The floor: a minimal evaluator of one clip for eight characters at once.
//!
//! Source: `docs/methods/runtime.md` part 3, without options: no scales, no blending, no looping,
//! no levels, one clip for all characters. Uniform f32 rows, constant channels dropped, joints
//! breadth first, the chain in quaternions and translations, then 3x4 matrices. A scale of a joint
//! without children, which affects no other joint, is ignored; any other is refused. All other
//! times are stated as ratios to this one, so it is written to be fast: [`avx2`] where the machine
//! has it, plain arrays elsewhere.
//!
//! Alternatives, on one Xeon of 2023, ns per character and frame of 67 joints, stored / consumed in
//! tiles: plain arrays 900 / – without features and 470 / 340 as a clone with AVX2 and `mul_add`
//! (680 / 470 with AVX-512: the compiler finds no good transposition); rows by intrinsics and
//! arithmetic on arrays 310 / 175 (the compiler splits registers into halves); intrinsics
//! throughout 200 / 145; the same without constant channels 190 / 115, kept (AVX-512 on eight lanes
//! 15 slower / the same). Writing the tile and transposing it afterwards costs 60 to 140 more,
//! streaming stores 550.

mod arrays;
#[cfg(target_arch = "x86_64")]
#[expect(
    unsafe_code,
    reason = "loads and stores of vectors, and the call once the machine is known to have them"
)]
mod avx2;

use anyhow::{Result, ensure};
use articula_core::{Clip, JointSet, Rig, Track};
use glam::{Quat, Vec3};

/// Characters in a batch.
pub(crate) const LANES: usize = 8;

/// One number for each character of a batch.
pub(crate) type Lanes = [f32; LANES];

/// A 3x4 matrix, row by row, for each character of a batch.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(32))]
pub(crate) struct Tile(pub(crate) [Lanes; 12]);

/// A 3x4 matrix, row by row.
pub(crate) type Matrix = [f32; 12];

/// Model-space transform of a joint, for each character of a batch, as the chain carries it.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(32))]
struct Link {
    rotation: [Lanes; 4],
    translation: [Lanes; 3],
}

/// Source of a joint's rotation or translation.
#[derive(Debug, Clone, Copy)]
enum Channel {
    /// Constant value; the fourth number of a translation is 0.
    Still([f32; 4]),
    /// Column of the rows.
    Moving(usize),
}

/// The channels to sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sampled {
    /// Channels that move in the clip.
    Moving,
    /// Additionally all rotations, as if every joint moved.
    AllRotations,
}

/// A joint in breadth-first order.
#[derive(Debug, Clone, Copy)]
struct Joint {
    /// Index of the parent in the order; for a root, the number of joints.
    parent: usize,
    rotation: Channel,
    translation: Channel,
}

/// Frame of each character of a batch, and the fraction towards the next frame.
#[derive(Debug, Clone, Copy)]
struct Batch {
    frame: [usize; LANES],
    blend: Lanes,
}

/// One rig with one clip, and the buffers of a batch.
pub(crate) struct Floor {
    clip: Rows,
    chain: Vec<Link>,
    tile: Vec<Tile>,
    /// Matrices of the characters that pad the last batch.
    spare: Vec<Matrix>,
    kernel: Kernel,
}

/// The clip: for each frame a row of the moving rotations and one of the moving translations.
struct Rows {
    joints: Vec<Joint>,
    rotations: Columns,
    translations: Columns,
    frames: usize,
    rate_hz: f32,
}

/// Moving channels, row by row.
#[derive(Default)]
struct Columns {
    /// Number of channels in a row.
    width: usize,
    rows: Vec<[f32; 4]>,
}

/// Instruction set that evaluates a batch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kernel {
    /// The instruction set of the build.
    Arrays,
    /// AVX2 and FMA; [`Floor::with`] refuses it on machines without them.
    Avx2,
    /// The same, with a rounding after each multiplication as on a machine without FMA: what is left to
    /// evaluators with equal bits on all machines.
    Avx2Unfused,
}

impl Kernel {
    /// The fastest kernel of this machine without fused operations.
    pub(crate) fn unfused() -> Self {
        if Self::Avx2Unfused.is_here() {
            Self::Avx2Unfused
        } else {
            Self::Arrays
        }
    }

    /// The fastest kernel of this machine.
    pub(crate) fn best() -> Self {
        if Self::Avx2.is_here() {
            Self::Avx2
        } else {
            Self::Arrays
        }
    }

    fn is_here(self) -> bool {
        #[cfg(target_arch = "x86_64")]
        let avx2 = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
        #[cfg(not(target_arch = "x86_64"))]
        let avx2 = false;
        self == Self::Arrays || avx2
    }
}

impl Floor {
    /// Converts the clip into rows, for the fastest kernel of this machine.
    pub(crate) fn new(rig: &Rig, clip: &Clip, sampled: Sampled) -> Result<Self> {
        Self::with(rig, clip, sampled, Kernel::best())
    }

    /// As [`Floor::new`], for a given kernel.
    pub(crate) fn with(rig: &Rig, clip: &Clip, sampled: Sampled, kernel: Kernel) -> Result<Self> {
        ensure!(kernel.is_here(), "this machine has no {kernel:?}");
        let clip = Rows::new(rig, clip, sampled)?;
        let joints = clip.joints.len();
        let link = Link {
            rotation: [[0.0; LANES]; 4],
            translation: [[0.0; LANES]; 3],
        };
        Ok(Self {
            clip,
            chain: vec![link; joints],
            tile: vec![Tile([[0.0; LANES]; 12]); joints],
            spare: vec![[0.0; 12]; LANES * joints],
            kernel,
        })
    }

    /// Number of joints, and thus of matrices, of a character.
    pub(crate) fn joints(&self) -> usize {
        self.clip.joints.len()
    }

    /// Bytes of the clip.
    pub(crate) fn clip_bytes(&self) -> usize {
        16 * (self.clip.rotations.rows.len() + self.clip.translations.rows.len())
    }

    /// Writes the matrices of characters at times within the clip, character by character.
    pub(crate) fn store(&mut self, secs: &[f32], out: &mut [Matrix]) {
        let joints = self.joints();
        let mut rest = &mut out[..secs.len() * joints];
        let mut spare = self.spare.as_mut_slice();
        for times in secs.chunks(LANES) {
            let mut places: [&mut [Matrix]; LANES] = Default::default();
            for (lane, place) in places.iter_mut().enumerate() {
                let from = if lane < times.len() {
                    &mut rest
                } else {
                    &mut spare
                };
                let (head, tail) = std::mem::take(from).split_at_mut(joints);
                (*place, *from) = (head, tail);
            }
            let at = self.clip.batch(times);
            evaluate(
                self.kernel,
                &self.clip,
                &at,
                &mut self.chain,
                Out::Stored(places),
            );
        }
    }

    /// Passes the matrices to `consume`, eight characters at a time, in one buffer that stays in
    /// the first-level cache. The padding of the last batch is included.
    pub(crate) fn tiles(&mut self, secs: &[f32], mut consume: impl FnMut(&[Tile])) {
        for times in secs.chunks(LANES) {
            let (at, tile) = (self.clip.batch(times), &mut self.tile);
            evaluate(
                self.kernel,
                &self.clip,
                &at,
                &mut self.chain,
                Out::Tile(tile),
            );
            consume(tile);
        }
    }
}

/// Destination of the matrices of a batch.
enum Out<'a> {
    /// One slice for each character.
    Stored([&'a mut [Matrix]; LANES]),
    Tile(&'a mut [Tile]),
}

/// Samples a batch, applies the hierarchy and writes the matrices.
fn evaluate(kernel: Kernel, clip: &Rows, at: &Batch, chain: &mut [Link], out: Out<'_>) {
    match kernel {
        #[cfg(target_arch = "x86_64")]
        Kernel::Avx2 => avx2::evaluate::<true>(clip, at, chain, out),
        #[cfg(target_arch = "x86_64")]
        Kernel::Avx2Unfused => avx2::evaluate::<false>(clip, at, chain, out),
        _ => arrays::evaluate(clip, at, chain, out),
    }
}

impl Rows {
    fn new(rig: &Rig, clip: &Clip, sampled: Sampled) -> Result<Self> {
        ensure!(clip.joints() == rig.len(), "the clip is of another rig");
        let scaled = scaled(rig, clip);
        let chained = (0..rig.len()).any(|j| rig.parent(j).is_some_and(|p| scaled.contains(p)));
        ensure!(!chained, "the floor has no scales");
        let order = breadth_first(rig);
        let mut place = vec![0; rig.len()];
        for (at, joint) in order.iter().enumerate() {
            place[*joint] = at;
        }
        // A clip of one frame is constant between two equal frames.
        let frames = clip.frames().max(2);
        let (mut rotations, mut translations) = (Vec::new(), Vec::new());
        let joints = order.iter().map(|&joint| {
            let rest = rig.rest_pose().get(joint);
            let turned = column(&clip.tracks().rotations, joint, rest.rotation, |q: Quat| {
                q.to_array()
            });
            let moved = column(&clip.tracks().translations, joint, rest.translation, |v| {
                v.extend(0.0).to_array()
            });
            Joint {
                parent: rig.parent(joint).map_or(order.len(), |p| place[p]),
                rotation: channel(turned, sampled == Sampled::AllRotations, &mut rotations),
                translation: channel(moved, false, &mut translations),
            }
        });
        Ok(Self {
            joints: joints.collect(),
            rotations: Columns::new(&rotations, frames),
            translations: Columns::new(&translations, frames),
            frames,
            rate_hz: clip.rate_hz(),
        })
    }

    /// Position of a batch in the clip; missing characters repeat the last time.
    fn batch(&self, secs: &[f32]) -> Batch {
        let mut at = Batch {
            frame: [0; LANES],
            blend: [0.0; LANES],
        };
        for lane in 0..LANES {
            let time = secs[lane.min(secs.len() - 1)] * self.rate_hz;
            let frame = (time as usize).min(self.frames - 2);
            at.frame[lane] = frame;
            at.blend[lane] = time - frame as f32;
        }
        at
    }
}

/// Joints with a scale, at rest or in the clip.
fn scaled(rig: &Rig, clip: &Clip) -> JointSet {
    let is_one = |scale: &Vec3| scale.distance(Vec3::ONE) < 1e-5;
    let tracks = clip.tracks().scales.iter();
    let moved = tracks.filter(|t| !t.values.iter().all(is_one));
    let rest = rig.rest_pose().scales.iter().enumerate();
    let rest = rest.filter(|(_, scale)| !is_one(scale));
    moved
        .map(|t| usize::from(t.target))
        .chain(rest.map(|(joint, _)| joint))
        .collect()
}

/// The joints of a rig in breadth-first order, in which matrices are written.
pub(super) fn breadth_first(rig: &Rig) -> Vec<usize> {
    let mut depths = vec![0; rig.len()];
    for joint in 0..rig.len() {
        depths[joint] = rig.parent(joint).map_or(0, |p| depths[p] + 1);
    }
    let mut order: Vec<usize> = (0..rig.len()).collect();
    order.sort_by_key(|joint| depths[*joint]);
    order
}

/// Values of a joint from the clip or the rest pose: one, or one for each frame.
fn column<T: Copy>(
    tracks: &[Track<T>],
    joint: usize,
    rest: T,
    row: impl Fn(T) -> [f32; 4],
) -> Vec<[f32; 4]> {
    match tracks.iter().find(|t| usize::from(t.target) == joint) {
        Some(track) => track.values.iter().map(|v| row(*v)).collect(),
        None => vec![row(rest)],
    }
}

/// Keeps a column that moves, or that is to be sampled although it is constant.
fn channel(column: Vec<[f32; 4]>, always: bool, kept: &mut Vec<Vec<[f32; 4]>>) -> Channel {
    if !always && column.iter().all(|row| *row == column[0]) {
        return Channel::Still(column[0]);
    }
    kept.push(column);
    Channel::Moving(kept.len() - 1)
}

impl Columns {
    fn new(columns: &[Vec<[f32; 4]>], frames: usize) -> Self {
        let row = |frame: usize| columns.iter().map(move |c| c[frame.min(c.len() - 1)]);
        Self {
            width: columns.len(),
            rows: (0..frames).flat_map(row).collect(),
        }
    }
}

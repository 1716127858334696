//! The first step of the thesis' metric, a baseline: the error matrix.
//!
//! Source: thesis 5.2; reconstruction of the damaged formula and the decisions taken in
//! `docs/methods/motion-lod.md` 3.1.

use crate::character::Asset;
use crate::motion_error::bounds::moving_joints;
use crate::motion_error::tables::table_hashes;
use articula_core::Libm;
use articula_core::playback::{ErrorMatrix, ErrorMatrixTable};
use articula_core::{Clip, JointSet, ModelPose, Rig, Wrap, angle_between, local_to_model, sample};
use glam::{Quat, Vec3};

/// Direction whose angular change gives the position term of the thesis metric.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BoneDirection {
    /// From the joint to the mean of its children.
    #[default]
    Bone,
    /// Along the path of the joint, as the text says; undefined while the joint rests.
    Path,
}

/// Lever arm of a joint in the thesis metric, from the lengths of the segments below it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SegmentRadius {
    /// `sum l^2 / sum l`: a length-weighted mean, in metres.
    #[default]
    Mean,
    /// `sum l`: grows with the number of children, as the prose suggests.
    Sum,
}

/// Parameters of the thesis metric, which computes a matrix of errors by frame and joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThesisMetricOptions {
    /// Weight of the angle terms against the position term, metres per radian.
    pub alpha: f32,
    /// Blend of the angle terms, 0 to 1: 1 is orientation only, 0 angular velocity only.
    pub beta: f32,
    /// Direction of the position term.
    pub direction: BoneDirection,
    /// Lever arm of the position term.
    pub radius: SegmentRadius,
    /// Whether the clip's first frame follows its last.
    pub looping: bool,
}

impl Default for ThesisMetricOptions {
    fn default() -> Self {
        Self {
            alpha: 1.0,
            beta: 0.5,
            direction: BoneDirection::Bone,
            radius: SegmentRadius::Mean,
            looping: false,
        }
    }
}

/// Lever arm `r(j)` of every joint over all its descendants, at rest; 0 for a leaf.
pub(crate) fn radii(rig: &Rig, kind: SegmentRadius) -> Vec<f32> {
    let mut model = ModelPose::new(rig.len());
    local_to_model(rig, rig.rest_pose(), &mut model);
    (0..rig.len())
        .map(|j| {
            let lengths = (j + 1..rig.len())
                .filter(|c| rig.is_at_or_below(*c, j))
                .map(|c| model.position(j).distance(model.position(c)));
            let (squares, sum) = lengths.fold((0.0, 0.0), |(q, s), l| (q + l * l, s + l));
            match kind {
                SegmentRadius::Sum => sum,
                SegmentRadius::Mean if sum > 0.0 => squares / sum,
                SegmentRadius::Mean => 0.0,
            }
        })
        .collect()
}

/// Computes the error matrix of a clip at the rate of its keys, with default options: the table that
/// an asset stores.
pub fn error_matrix_table(asset: &Asset, clip: &Clip) -> ErrorMatrixTable {
    ErrorMatrixTable {
        hashes: table_hashes(&asset.rig, clip, &asset.mesh),
        rate_hz: clip.at_key_rate().rate_hz(),
        matrix: error_matrix_with(asset, clip, &ThesisMetricOptions::default()),
    }
}

/// Computes the error matrix of a clip at the rate of its keys.
pub fn error_matrix_with(asset: &Asset, clip: &Clip, options: &ThesisMetricOptions) -> ErrorMatrix {
    let played = clip.at_key_rate();
    let moving = moving_joints(asset, &played);
    error_matrix(asset, &played, &moving, options)
}

/// The normalised matrix over all frames of a clip; the maximum over the joints of `moving`
/// normalises it.
///
/// # Panics
/// Never: a rig has joints, so the matrix consists of whole frames.
pub(crate) fn error_matrix(
    asset: &Asset,
    clip: &Clip,
    moving: &JointSet,
    opts: &ThesisMetricOptions,
) -> ErrorMatrix {
    let rig = &asset.rig;
    let radii = radii(rig, opts.radius);
    let frames = clip.frames();
    let (rotations, directions) = play(rig, clip, opts.direction);
    let before = |i: usize, steps: usize| match (i >= steps, opts.looping) {
        (true, _) => Some(i - steps),
        // The last frame of a loop equals the first, so it is not counted twice.
        (false, true) if frames > 2 => Some(i + frames - 1 - steps),
        _ => None,
    };
    let mut values = vec![0.0f32; frames * rig.len()];
    for i in 0..frames {
        let Some(i1) = before(i, 1) else { continue };
        for j in moving.iter() {
            let turn = |to: usize, from: usize| rotations[from][j].conjugate() * rotations[to][j];
            let orientation = angle_between(rotations[i1][j], rotations[i][j]);
            let velocity = before(i, 2).map_or(0.0, |i2| angle_between(turn(i1, i2), turn(i, i1)));
            let arc = radii[j] * angle(directions[i][j], directions[i1][j]);
            values[i * rig.len() + j] =
                opts.alpha * (opts.beta * orientation + (1.0 - opts.beta) * velocity) + arc;
        }
    }
    let greatest = values.iter().copied().fold(0.0, f32::max);
    if greatest > 0.0 {
        values.iter_mut().for_each(|v| *v /= greatest);
    }
    ErrorMatrix::new(rig.len(), values)
        .expect("the values must form whole frames, and the rig must have joints")
}

/// Angle between two directions, 0 where one is undefined. Computed from both sine and cosine: the
/// arc cosine alone loses all angles below some 3e-4 radians, more than the tight threshold.
fn angle(a: Vec3, b: Vec3) -> f32 {
    a.cross(b).length().libm_atan2(a.dot(b))
}

/// Local rotations and model-space directions of all frames.
fn play(rig: &Rig, clip: &Clip, direction: BoneDirection) -> (Vec<Vec<Quat>>, Vec<Vec<Vec3>>) {
    let mut pose = rig.rest_pose().clone();
    let mut model = ModelPose::new(rig.len());
    let mut rotations = Vec::with_capacity(clip.frames());
    let mut positions: Vec<Vec<Vec3>> = Vec::with_capacity(clip.frames());
    for i in 0..clip.frames() {
        let secs = i as f64 / f64::from(clip.rate_hz());
        sample(clip, secs, Wrap::Clamp, &rig.all(), &mut pose);
        local_to_model(rig, &pose, &mut model);
        rotations.push(pose.rotations.clone());
        // The viewer follows the root, so its travel over the ground does not count as motion.
        let ground = model.position(rig.root()) * Vec3::new(1.0, 0.0, 1.0);
        positions.push((0..rig.len()).map(|j| model.position(j) - ground).collect());
    }
    let directions = match direction {
        BoneDirection::Bone => positions.iter().map(|p| bones(rig, p)).collect(),
        BoneDirection::Path => (0..positions.len())
            .map(|i| {
                let from = &positions[i.saturating_sub(1)];
                let steps = positions[i].iter().zip(from).map(|(to, from)| *to - *from);
                steps.map(Vec3::normalize_or_zero).collect()
            })
            .collect(),
    };
    (rotations, directions)
}

fn bones(rig: &Rig, positions: &[Vec3]) -> Vec<Vec3> {
    let mut sums = vec![Vec3::ZERO; rig.len()];
    for j in 0..rig.len() {
        if let Some(p) = rig.parent(j) {
            sums[p] += positions[j] - positions[p];
        }
    }
    sums.into_iter().map(Vec3::normalize_or_zero).collect()
}

//! How far a clip that is played is from the keys of its file, measured by an evaluation of its own.

mod reference;

use crate::split_mix::SplitMix;
use articula_core::source::{Channel, Character, RawClip};
use articula_core::{Clip, Mesh};
use glam::{DAffine3, DVec3};
use reference::{Pose, Reference};

/// What is played in place of the keys of a file.
#[derive(Debug, Clone, Copy)]
pub enum Played<'a> {
    /// A clip of uniform rate.
    Frames(&'a Clip),
    /// Keys at a rate, in frames per second.
    Keys {
        /// The clip.
        clip: &'a RawClip,
        /// Number of keys per second.
        rate_hz: f32,
    },
}

/// The greatest displacement of a clip from its file.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ResamplingError {
    /// Displacement of the skin in metres; of joints where there is no mesh.
    pub metres: f64,
    /// Time in seconds at which it was measured.
    pub secs: f64,
}

/// Number of random times, and the maximum number of others.
const RANDOM_TIMES: usize = 64;
const MAX_TIMES: usize = 4096;
const SEED: u64 = 0xf11e;

/// Displacement in metres below which the skin's bound is reported, and maximum number of times at
/// which all vertices are posed.
const FINE_METRES: f64 = 1e-5;
const POSED_TIMES: usize = 24;

/// Least rate at which the frame of a jump is not measured.
const JUMP_HZ: f64 = 119.9;

/// Measures the greatest displacement between the keys of a clip and what is played in their place: at
/// the key times, at the midpoints between them, and at seeded random times. Within a frame of a jump
/// nothing is measured if a frame is no longer than 1/120 s.
///
/// Displacements below 0.01 mm are upper bounds. `mesh` is that of the character. O(keys * joints), and
/// O(vertices) at the worst times.
///
/// # Panics
/// If the clip or the mesh is of another character.
pub fn resampling_error(
    character: &Character,
    mesh: &Mesh,
    file: &RawClip,
    played: Played<'_>,
) -> ResamplingError {
    let reference = Reference { character, mesh };
    let skin = Skin::new(mesh, character.skeleton.joints.len());
    let at = |secs: f64| (reference.keys(file, secs), reference.played(&played, secs));
    let mut bounds: Vec<ResamplingError> = times(file, played.rate_hz())
        .into_iter()
        .map(|secs| {
            let (wanted, shown) = at(secs);
            let metres = skin.bound(&wanted, &shown);
            ResamplingError { metres, secs }
        })
        .collect();
    bounds.sort_by(|a, b| {
        b.metres
            .total_cmp(&a.metres)
            .then(a.secs.total_cmp(&b.secs))
    });
    let mut worst = ResamplingError::default();
    for (i, bound) in bounds.iter().enumerate() {
        if bound.metres <= worst.metres {
            break;
        }
        if bound.metres <= FINE_METRES || i == POSED_TIMES || mesh.is_empty() {
            return *bound;
        }
        let (wanted, shown) = at(bound.secs);
        let metres = skin.displacement(&wanted, &shown);
        if metres > worst.metres {
            worst = ResamplingError { metres, ..*bound };
        }
    }
    worst
}

impl Played<'_> {
    fn rate_hz(&self) -> f64 {
        f64::from(match self {
            Self::Frames(clip) => clip.rate_hz(),
            Self::Keys { rate_hz, .. } => *rate_hz,
        })
    }
}

/// The times at which a clip is measured.
fn times(file: &RawClip, rate_hz: f64) -> Vec<f64> {
    let keys = file.channels.iter().flat_map(|c| &c.times_secs);
    let mut times: Vec<f64> = keys.map(|t| f64::from(*t)).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    let middles: Vec<f64> = times.windows(2).map(|w| 0.5 * (w[0] + w[1])).collect();
    times.extend(middles);
    let mut random = SplitMix(SEED);
    for i in 0..times.len().min(MAX_TIMES) {
        let other = i + random.below(times.len() - i);
        times.swap(i, other);
    }
    times.truncate(MAX_TIMES);
    let end = f64::from(file.duration_secs);
    times.extend((0..RANDOM_TIMES).map(|_| end * f64::from(random.unit())));
    times.retain(|t| t.is_finite());
    if rate_hz >= JUMP_HZ {
        let jumps = file.channels.iter().flat_map(Channel::jump_times);
        let mut jumps: Vec<f64> = jumps.map(f64::from).collect();
        jumps.sort_by(f64::total_cmp);
        let near = 1.001 / rate_hz;
        times.retain(|t| {
            let next = jumps.partition_point(|j| *j <= t - near);
            jumps.get(next).is_none_or(|j| *j >= t + near)
        });
    }
    times
}

/// The skin of a character, and a box around that of each joint in its own space.
struct Skin<'a> {
    mesh: &'a Mesh,
    boxes: Vec<Option<(DVec3, DVec3)>>,
    /// Greatest displacement by each morph slot at full weight.
    reaches: Vec<f64>,
    binds: Vec<DAffine3>,
}

impl<'a> Skin<'a> {
    fn new(mesh: &'a Mesh, joints: usize) -> Self {
        let mut reaches = vec![0.0f64; mesh.morph_weights.len()];
        for morph in &mesh.morphs {
            let farthest = morph.positions.iter().map(|p| f64::from(p.length()));
            let reach = &mut reaches[usize::from(morph.slot)];
            *reach = farthest.fold(*reach, f64::max);
        }
        let margin = DVec3::splat(reaches.iter().copied().fold(0.0, f64::max));
        let binds: Vec<DAffine3> = mesh
            .bindings
            .iter()
            .map(|b| b.inverse_bind.as_daffine3())
            .collect();
        let mut boxes: Vec<Option<(DVec3, DVec3)>> = vec![None; joints];
        let rows = mesh.binding_indices.chunks_exact(mesh.influences.max(1));
        let rows = rows.zip(mesh.weights.chunks_exact(mesh.influences.max(1)));
        for (position, (bindings, weights)) in mesh.positions.iter().zip(rows) {
            for (binding, weight) in bindings.iter().map(|b| usize::from(*b)).zip(weights) {
                if *weight > 0.0 {
                    let point = binds[binding].transform_point3(position.as_dvec3());
                    let of_joint = &mut boxes[usize::from(mesh.bindings[binding].joint)];
                    let (low, high) = of_joint.unwrap_or((point, point));
                    *of_joint = Some((low.min(point), high.max(point)));
                }
            }
        }
        for (low, high) in boxes.iter_mut().flatten() {
            (*low, *high) = (*low - margin, *high + margin);
        }
        Self {
            mesh,
            boxes,
            reaches,
            binds,
        }
    }

    /// An upper bound of the displacement of the skin: a vertex is a mean of its positions under each
    /// of its joints. Without a mesh, the displacement of the joints.
    fn bound(&self, wanted: &Pose, shown: &Pose) -> f64 {
        let weights = wanted.weights.iter().zip(&shown.weights);
        let morphs = weights
            .zip(&self.reaches)
            .map(|((a, b), r)| (a - b).abs() * r);
        let morphs: f64 = morphs.sum();
        let joints = wanted.model.iter().zip(&shown.model).zip(&self.boxes);
        let moved = joints.map(|((a, b), skin)| {
            let by = b.matrix3 - a.matrix3;
            let offset = b.translation - a.translation;
            let Some((low, high)) = skin else {
                return if self.mesh.is_empty() {
                    offset.length()
                } else {
                    0.0
                };
            };
            let (centre, half) = (0.5 * (*low + *high), 0.5 * (*high - *low));
            let spread = half.x * by.x_axis.length()
                + half.y * by.y_axis.length()
                + half.z * by.z_axis.length();
            (by * centre + offset).length() + spread
        });
        moved.fold(0.0, f64::max) + morphs
    }

    fn displacement(&self, wanted: &Pose, shown: &Pose) -> f64 {
        let (a, b) = (self.posed(wanted), self.posed(shown));
        a.iter()
            .zip(&b)
            .map(|(a, b)| a.distance(*b))
            .fold(0.0, f64::max)
    }

    fn posed(&self, pose: &Pose) -> Vec<DVec3> {
        let mesh = self.mesh;
        let mut at: Vec<DVec3> = mesh.positions.iter().map(|p| p.as_dvec3()).collect();
        for morph in &mesh.morphs {
            let weight = pose.weights[usize::from(morph.slot)];
            for (vertex, offset) in morph.vertices.iter().zip(&morph.positions) {
                at[*vertex as usize] += weight * offset.as_dvec3();
            }
        }
        let joints = mesh.bindings.iter().map(|b| usize::from(b.joint));
        let palette = joints
            .zip(&self.binds)
            .map(|(j, bind)| pose.model[j] * *bind);
        let palette: Vec<DAffine3> = palette.collect();
        let influences = mesh.influences.max(1);
        for (v, point) in at.iter_mut().enumerate() {
            let of_vertex = v * influences..(v + 1) * influences;
            let bindings = mesh.binding_indices[of_vertex.clone()].iter();
            let pairs = bindings.zip(&mesh.weights[of_vertex]);
            let terms = pairs
                .map(|(b, w)| f64::from(*w) * palette[usize::from(*b)].transform_point3(*point));
            *point = terms.sum();
        }
        at
    }
}

//! Reach of the skin from its joints, and its maximum travel between frames.
//!
//! Lengths are added along the joints, each at its maximum over all clips, so that they hold in
//! every pose and in every blend of poses.

use crate::character::Asset;
use crate::motion_error::joint_lever::JointLever;
use articula_core::Libm;
use articula_core::{Clip, Rig, Track, angle_between};
use glam::Vec3;

/// Lengths of one character, over all its clips.
pub(crate) struct Reach {
    /// Maximum distance of skin at or below each joint from the joint, in the joint's own unscaled
    /// space; `None` where it carries no skin.
    local: Vec<Option<f32>>,
    /// Maximum scale of each joint's own space relative to the model.
    scales: Vec<f32>,
    anchor: Option<usize>,
    anchor_metres: f32,
    /// Maximum distance of skin from the origin of the model, in metres.
    origin_metres: f32,
    /// Maximum displacement of a vertex by each morph slot at weight 1, in model space.
    morphs: Vec<f32>,
}

impl Reach {
    pub(crate) fn new(asset: &Asset) -> Self {
        let rig = &asset.rig;
        let lengths = greatest(
            rig,
            asset,
            |clip| &clip.tracks().translations,
            |j| rig.rest_pose().translations[j].length(),
            |v| v.length(),
        );
        let own_scales = greatest(
            rig,
            asset,
            |clip| &clip.tracks().scales,
            |j| rig.rest_pose().scales[j].abs().max_element(),
            |v| v.abs().max_element(),
        );
        let mut scales = own_scales.clone();
        for joint in 0..rig.len() {
            if let Some(parent) = rig.parent(joint) {
                scales[joint] *= scales[parent];
            }
        }
        let mut local = own_skin(asset);
        let mut from_origin = 0.0f32;
        for joint in (0..rig.len()).rev() {
            let Some(below) = local[joint] else { continue };
            let way = lengths[joint] + own_scales[joint] * below;
            match rig.parent(joint) {
                Some(parent) => local[parent] = Some(local[parent].map_or(way, |l| l.max(way))),
                None => from_origin = from_origin.max(way),
            }
        }
        let anchor = anchor(asset, &local);
        let anchor_metres = match anchor {
            Some(joint) => scales[joint] * local[joint].unwrap_or(0.0),
            None => from_origin,
        };
        Self {
            morphs: morph_ways(asset, &scales),
            local,
            scales,
            anchor,
            anchor_metres,
            origin_metres: from_origin,
        }
    }

    /// The joint from which all skin hangs and whose position blends linearly; `None` for the
    /// origin of the model.
    pub(super) fn anchor(&self) -> Option<usize> {
        self.anchor
    }

    /// Maximum distance of skin from the anchor, in metres.
    pub(super) fn anchor_metres(&self) -> f32 {
        self.anchor_metres
    }

    /// Maximum distance of skin from the origin of the model, in any pose, in metres.
    pub(super) fn origin_metres(&self) -> f32 {
        self.origin_metres
    }

    /// Maximum travel of any skin from one frame to the next, in metres.
    pub(super) fn way(&self, asset: &Asset, clip: &Clip, frame: usize) -> f32 {
        let ways = self.ways(asset, clip, frame);
        let carried = ways.iter().zip(&self.local).filter(|(_, l)| l.is_some());
        carried.map(|(way, _)| *way).fold(0.0, f32::max)
    }

    /// Maximum travel of the skin that each joint itself moves, in metres; 0 at the last frame.
    pub(crate) fn ways(&self, asset: &Asset, clip: &Clip, frame: usize) -> Vec<f32> {
        let rig = &asset.rig;
        let mut ways = vec![0.0f32; rig.len()];
        if frame + 1 >= clip.frames() {
            return ways;
        }
        let above = |joint: usize| rig.parent(joint).map_or(1.0, |p| self.scales[p]);
        for (joint, [a, b]) in moved(&clip.tracks().rotations, frame) {
            // A normalised blend is fastest in its middle: as if the angle were 4 tan(angle / 4).
            let turn = 4.0 * (0.25 * angle_between(a, b)).libm_tan();
            ways[joint] += turn * self.scales[joint] * self.local[joint].unwrap_or(0.0);
        }
        for (joint, [a, b]) in moved(&clip.tracks().translations, frame) {
            ways[joint] += above(joint) * a.distance(b);
        }
        for (joint, [a, b]) in moved(&clip.tracks().scales, frame) {
            let change = (b - a).abs().max_element();
            ways[joint] += above(joint) * change * self.local[joint].unwrap_or(0.0);
        }
        for joint in 0..rig.len() {
            ways[joint] += rig.parent(joint).map_or(0.0, |p| ways[p]);
        }
        let morphs = moved(&clip.tracks().morphs, frame);
        let morph = morphs
            .map(|(slot, [a, b])| (b - a).abs() * self.morphs.get(slot).copied().unwrap_or(0.0))
            .sum::<f32>();
        ways.iter_mut().for_each(|way| *way += morph);
        ways
    }
}

/// Values of the non-constant tracks at a frame and the next one, with their targets.
fn moved<T: Copy>(tracks: &[Track<T>], frame: usize) -> impl Iterator<Item = (usize, [T; 2])> {
    let blends = |track: &&Track<T>| !track.step && track.values.len() > 1;
    let tracks = tracks.iter().filter(blends);
    tracks.map(move |t| {
        (
            usize::from(t.target),
            [t.values[frame], t.values[frame + 1]],
        )
    })
}

/// Maximum size of a property of each joint, at rest and in all clips.
fn greatest<'a>(
    rig: &Rig,
    asset: &'a Asset,
    tracks: impl Fn(&'a Clip) -> &'a [Track<Vec3>],
    at_rest: impl Fn(usize) -> f32,
    size: impl Fn(Vec3) -> f32,
) -> Vec<f32> {
    let mut sizes: Vec<f32> = (0..rig.len()).map(at_rest).collect();
    for track in asset.clips.iter().flat_map(tracks) {
        let of = &mut sizes[usize::from(track.target)];
        *of = track.values.iter().map(|v| size(*v)).fold(*of, f32::max);
    }
    sizes
}

/// Distance of the farthest vertex that each joint itself moves, in the joint's own space.
fn own_skin(asset: &Asset) -> Vec<Option<f32>> {
    let mesh = &asset.mesh;
    if mesh.is_empty() {
        return vec![Some(JointLever::FLOOR_METRES); asset.rig.len()];
    }
    // Maximum displacement of each vertex by morphs, in the space of its mesh.
    let mut morphed = vec![0.0f32; mesh.len()];
    let weights = morph_weights(asset);
    for morph in &mesh.morphs {
        for (v, offset) in morph.vertices.iter().zip(&morph.positions) {
            morphed[*v as usize] += weights[usize::from(morph.slot)] * offset.length();
        }
    }
    let mut own = vec![None; asset.rig.len()];
    for (v, morphed) in morphed.iter().enumerate() {
        for i in v * mesh.influences..(v + 1) * mesh.influences {
            if mesh.weights[i] == 0.0 {
                continue;
            }
            let binding = &mesh.bindings[usize::from(mesh.binding_indices[i])];
            let at = binding.inverse_bind.transform_point3(mesh.positions[v]);
            let far = at.length() + stretch(&binding.inverse_bind) * morphed;
            let of: &mut Option<f32> = &mut own[usize::from(binding.joint)];
            *of = Some(of.map_or(far, |o| o.max(far)));
        }
    }
    own
}

/// Maximum absolute weight of each morph slot, at rest and in all clips.
fn morph_weights(asset: &Asset) -> Vec<f32> {
    let mut weights: Vec<f32> = asset.mesh.morph_weights.iter().map(|w| w.abs()).collect();
    for track in asset.clips.iter().flat_map(|c| &c.tracks().morphs) {
        if let Some(of) = weights.get_mut(usize::from(track.target)) {
            *of = track.values.iter().map(|v| v.abs()).fold(*of, f32::max);
        }
    }
    weights
}

fn morph_ways(asset: &Asset, scales: &[f32]) -> Vec<f32> {
    let mesh = &asset.mesh;
    let bindings = mesh.bindings.iter();
    let stretches = bindings.map(|b| scales[usize::from(b.joint)] * stretch(&b.inverse_bind));
    let stretch = stretches.fold(0.0, f32::max);
    let mut ways = vec![0.0f32; mesh.morph_weights.len()];
    for morph in &mesh.morphs {
        let longest = morph
            .positions
            .iter()
            .map(|p| p.length())
            .fold(0.0, f32::max);
        let of = &mut ways[usize::from(morph.slot)];
        // A vertex belongs to one mesh, so the largest offset of the slot bounds its travel.
        *of = of.max(longest * stretch);
    }
    ways
}

/// Upper bound on the factor by which a matrix lengthens a vector: its Frobenius norm.
fn stretch(matrix: &glam::Affine3A) -> f32 {
    let m = matrix.matrix3;
    let squares = m.x_axis.length_squared() + m.y_axis.length_squared() + m.z_axis.length_squared();
    squares.sqrt()
}

/// Descends from the root while a joint has no rotation or scale track and no skin of its own, and
/// one child carries everything.
fn anchor(asset: &Asset, carries: &[Option<f32>]) -> Option<usize> {
    let rig = &asset.rig;
    let only_child = |of: Option<usize>| {
        let mut below = (0..rig.len()).filter(|j| rig.parent(*j) == of && carries[*j].is_some());
        below.next().filter(|_| below.next().is_none())
    };
    let turns = |joint: usize| {
        asset.clips.iter().any(|clip| {
            let mut rotations = clip.tracks().rotations.iter().map(|t| t.target);
            let mut scales = clip.tracks().scales.iter().map(|t| t.target);
            let is = |target: u16| usize::from(target) == joint;
            rotations.any(is) || scales.any(is)
        })
    };
    let own = own_skin(asset);
    let mut at = only_child(None)?;
    while own[at].is_none() && !turns(at) {
        match only_child(Some(at)) {
            Some(child) => at = child,
            None => break,
        }
    }
    Some(at)
}

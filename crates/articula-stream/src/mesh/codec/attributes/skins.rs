//! Skins of points: joints first, then their weights.
//!
//! Source: `docs/methods/clustered-mesh.md` part 8.1 (f). Each joint of the neighbours is one
//! decision, the most likely joint first; then follow the number of other joints and their ids.

use super::Walk;
use super::blend::{Blend, Sample};
use super::residual::{BOTH, Misses, NEAR, Residuals, SIZES, both, class_of, sign_of};
use super::stencil::{CLASSES, FRACTION, PREDICTORS};
use crate::mesh::codec::mixing::{MixedNatural, Weights, decide};
use crate::range_coder::{Bit, Coder};

/// Maximum number of neighbours' joints tried.
const MAX_ASKED: usize = 24;
/// Sum of all weights.
const WHOLE: i32 = 255;

type Skin = Vec<(u16, u8)>;

/// A joint of a neighbour.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    joint: u16,
    /// Predicted weight by each predictor.
    predictions: [[i32; 1]; PREDICTORS],
    /// Predicted weight, from 0 to [`WHOLE`], in 1/2^[`FRACTION`].
    weight: i32,
    /// Number of neighbours that have the joint.
    users: usize,
    /// Minimum and maximum weight of the joint at the neighbours.
    range: (u8, u8),
}

fn weight_of(skin: &Skin, joint: u16) -> u8 {
    skin.iter().find(|i| i.0 == joint).map_or(0, |i| i.1)
}

/// The joints of a point's neighbours, the most likely first.
fn candidates(
    walk: &Walk<'_>,
    skins: &[Skin],
    p: u32,
    blend: Option<&Blend<PREDICTORS>>,
) -> Vec<Candidate> {
    let mut out: Vec<Candidate> = Vec::new();
    let stencils = &walk.of_points;
    let class = stencils.class(p);
    for u in stencils.neighbours(p) {
        for &(joint, weight) in &skins[u as usize] {
            if let Some(found) = out.iter_mut().find(|c| c.joint == joint) {
                found.users += 1;
                found.range = (found.range.0.min(weight), found.range.1.max(weight));
            } else if out.len() < MAX_ASKED {
                out.push(Candidate {
                    joint,
                    predictions: [[0]; PREDICTORS],
                    weight: 0,
                    users: 1,
                    range: (weight, weight),
                });
            }
        }
    }
    let neighbours = stencils.neighbours(p).count();
    for c in &mut out {
        let value = |u: u32| [i32::from(weight_of(&skins[u as usize], c.joint))];
        c.predictions = stencils.predict(p, value);
        let predicted = blend.map_or(c.predictions[0], |b| b.predict(class, &c.predictions));
        c.weight = predicted[0].clamp(0, WHOLE << FRACTION);
        if c.users < neighbours {
            c.range.0 = 0;
        }
    }
    out.sort_by_key(|c| (-c.weight, c.joint));
    out
}

/// Joints that no neighbour has, coded by the bits of their ids with models.
#[derive(Debug)]
struct Strangers {
    bits: u32,
    tree: Vec<Bit>,
}

impl Strangers {
    fn new(joints: u16) -> Self {
        let bits = (u32::from(joints.max(1)) - 1)
            .checked_ilog2()
            .map_or(0, |b| b + 1);
        Self {
            bits,
            tree: vec![Bit::default(); 1 << bits],
        }
    }

    fn code(&mut self, coder: &mut impl Coder, joint: u16) -> u16 {
        let mut node = 1usize;
        for i in (0..self.bits).rev() {
            let bit = coder.bit(&mut self.tree[node], joint >> i & 1 == 1);
            node = node << 1 | usize::from(bit);
        }
        (node - (1 << self.bits)) as u16
    }
}

struct Models {
    by_weight: Vec<[Bit; 8]>,
    by_rank: Vec<[Bit; 32]>,
    by_range: Vec<[Bit; 4]>,
    by_joint: Vec<[Bit; 16]>,
    presence: Weights<4>,
    more: MixedNatural<2>,
    strangers: Strangers,
    weights: Residuals,
}

impl Models {
    fn new(joints: u16) -> Self {
        Self {
            by_weight: vec![[Bit::default(); 8]; 32],
            by_rank: vec![[Bit::default(); 32]; 16],
            by_range: vec![[Bit::default(); 4]; SIZES * SIZES],
            by_joint: vec![[Bit::default(); 16]; usize::from(joints)],
            presence: Weights::default(),
            more: MixedNatural::new([8, 8]),
            strangers: Strangers::new(joints),
            weights: Residuals::new([SIZES * 3, NEAR, 64, BOTH], 3),
        }
    }

    /// Codes whether the point has a joint of its neighbours.
    fn has(
        &mut self,
        coder: &mut impl Coder,
        c: &Candidate,
        (rank, found, neighbours): (usize, usize, usize),
        given: bool,
    ) -> bool {
        let share = c.users * 4 / neighbours.max(1);
        let weight = (class_of(c.weight as u32) * 3 / 2).min(31);
        let near = neighbours.min(3) * 8 + found.min(7);
        let range = class_of(u32::from(c.range.0)) * SIZES + class_of(u32::from(c.range.1));
        let models = [
            &mut self.by_weight[weight][share.min(4)],
            &mut self.by_rank[rank.min(15)][near],
            &mut self.by_range[range][found.min(3)],
            &mut self.by_joint[usize::from(c.joint)][weight / 2],
        ];
        decide(coder, models, &mut self.presence, given)
    }
}

/// Codes the joints of one point: candidates first, then others.
fn code_joints(
    coder: &mut impl Coder,
    models: &mut Models,
    all: &[Candidate],
    (given, neighbours, joints): (&Skin, usize, u16),
) -> Vec<(u16, i32, (u8, u8))> {
    let mut out = Vec::with_capacity(4);
    for (rank, c) in all.iter().enumerate() {
        let is_given = given.iter().any(|i| i.0 == c.joint);
        let at = (rank, out.len(), neighbours);
        if models.has(coder, c, at, is_given) {
            out.push((c.joint, c.weight, c.range));
        }
    }
    let is_stranger = |i: &&(u16, u8)| all.iter().all(|c| c.joint != i.0);
    let strangers: Vec<u16> = given.iter().filter(is_stranger).map(|i| i.0).collect();
    // At least one joint in all; at most the number of joints, and of weights that fit.
    let room = usize::from(joints)
        .min(WHOLE as usize)
        .saturating_sub(out.len());
    let least = usize::from(out.is_empty());
    let given = (strangers.len().max(least) - least) as u32;
    let more = models
        .more
        .code(coder, [out.len().min(7), all.len().min(7)], given);
    let more = (more as usize + least).min(room);
    for i in 0..more {
        let given = strangers.get(i).copied().unwrap_or(0);
        let joint = models.strangers.code(coder, given).min(joints.max(1) - 1);
        // Only a broken stream has a joint twice.
        if out.iter().all(|o: &(u16, i32, (u8, u8))| o.0 != joint) {
            out.push((joint, 0, (0, 0)));
        }
    }
    out
}

/// Codes the skins of all new points.
pub(super) fn code<C: Coder>(coder: &mut C, walk: &Walk<'_>, skins: &mut [Skin], joints: u16) {
    let first = walk.known_points as u32;
    let mut samples: Vec<Sample<PREDICTORS, 1>> = Vec::new();
    if !C::READS {
        for p in first..skins.len() as u32 {
            let all = candidates(walk, skins, p, None);
            let given = &skins[p as usize];
            if given.len() < 2 && all.len() < 2 {
                continue;
            }
            for c in all {
                let truth = i32::from(weight_of(given, c.joint)) << FRACTION;
                if truth > 0 {
                    samples.push((walk.of_points.class(p), c.predictions, [truth]));
                }
            }
        }
    }
    let blend = Blend::code(coder, CLASSES, &samples);
    let mut models = Models::new(joints);
    let mut misses = Misses::new(walk.known_points, skins.len());
    for p in first..skins.len() as u32 {
        let given = std::mem::take(&mut skins[p as usize]);
        let all = candidates(walk, skins, p, Some(&blend));
        let neighbours = walk.of_points.neighbours(p);
        let near = (&given, neighbours.clone().count(), joints);
        let mut chosen = code_joints(coder, &mut models, &all, near);
        let near = misses.near(neighbours);
        let missed = code_weights(coder, &mut models, &mut chosen, (&given, near));
        misses.note(p, &[missed]);
        let mut skin: Skin = chosen.iter().map(|c| (c.0, c.1 as u8)).collect();
        skin.sort_by_key(|&(joint, weight)| (std::cmp::Reverse(weight), joint));
        skins[p as usize] = skin;
    }
}

/// Codes weights in place of predictions; returns the sum of the prediction errors.
fn code_weights(
    coder: &mut impl Coder,
    models: &mut Models,
    chosen: &mut [(u16, i32, (u8, u8))],
    (given, near): (&Skin, usize),
) -> i32 {
    let count = chosen.len();
    let (mut left, mut off, mut last) = (WHOLE, 0, 0i32);
    // Joints without a prediction get a small share.
    for c in chosen.iter_mut() {
        c.1 = c.1.max(8);
    }
    for i in 0..count {
        let rest = (count - 1 - i) as i32;
        if rest == 0 {
            chosen[i].1 = left;
            break;
        }
        let (joint, predicted, range) = chosen[i];
        let sum: i32 = chosen[i..].iter().map(|c| c.1).sum();
        let expected = (predicted * left + sum / 2) / sum.max(1);
        let expected = expected.clamp(1, left - rest);
        let spread = class_of(u32::from(range.1 - range.0));
        let apart = class_of(sum.abs_diff(left << FRACTION) >> 3);
        let size = (class_of(expected.min(left - expected) as u32) / 2).min(7);
        let contexts = [
            spread + SIZES * i.min(2),
            near,
            (apart / 3).min(7) + 8 * size,
            both(spread, near),
        ];
        let residual = i32::from(weight_of(given, joint)) - expected;
        let got = models
            .weights
            .code(coder, contexts, sign_of(last), residual);
        let weight = expected.saturating_add(got).clamp(1, left - rest);
        last = got;
        off += got.abs().min(255);
        chosen[i].1 = weight;
        left -= weight;
    }
    off
}

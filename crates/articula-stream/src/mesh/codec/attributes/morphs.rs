//! Morph targets: the points (and wedges) that they move, and the offsets.
//!
//! Most targets move few points, close to each other, so whether a point moves is predicted from
//! its neighbours.

use super::blend::{Blend, Sample};
use super::residual::{BOTH, Misses, NEAR, Residuals, SIZES, both, class_of, sign_of};
use super::stencil::{CLASSES, FRACTION, PREDICTORS, Stencils};
use crate::mesh::codec::mixing::{Weights, decide};
use crate::range_coder::{Bit, Coder};

/// Models for all targets.
struct Models {
    blend: Blend<PREDICTORS>,
    is_used: Bit,
    by_share: [[Bit; 8]; 8],
    by_size: [[Bit; 3]; SIZES],
    presence: Weights<2>,
    residuals: [Residuals; 3],
}

/// Fraction of an element's known neighbours that move, in quarters; 5 if none is known.
fn share(stencils: &Stencils, values: &[[i32; 3]], v: u32) -> (usize, u32) {
    let neighbours = stencils.neighbours(v);
    let (mut moved, mut count, mut size) = (0, 0, 0);
    for u in neighbours {
        let value = values[u as usize];
        count += 1;
        moved += usize::from(value != [0; 3]);
        size = size.max(value.iter().map(|x| x.unsigned_abs()).max().unwrap_or(0));
    }
    let share = match moved {
        _ if count == 0 => 5,
        0 => 0,
        n if n == count => 4,
        n => 1 + (n * 3 - 1) / count,
    };
    (share, size)
}

/// Codes the vectors of the elements from `from` on for all targets; coordinates are at most
/// `largest`.
pub(super) fn code<C: Coder>(
    coder: &mut C,
    (stencils, from): (&Stencils, usize),
    (targets, largest): (&mut [Vec<[i32; 3]>], i32),
) {
    if targets.iter().all(Vec::is_empty) {
        return;
    }
    let mut samples: Vec<Sample<PREDICTORS, 3>> = Vec::new();
    if !C::READS {
        let moved: usize = targets
            .iter()
            .flat_map(|t| t.iter().skip(from))
            .filter(|v| **v != [0; 3])
            .count();
        let step = moved / 20_000 + 1;
        let mut index = 0;
        for values in targets.iter() {
            for v in from as u32..values.len() as u32 {
                let value = values[v as usize];
                index += usize::from(value != [0; 3]);
                if value == [0; 3] || index % step != 0 {
                    continue;
                }
                let found = stencils.predict(v, |u| values[u as usize]);
                samples.push((stencils.class(v), found, value.map(|x| x << FRACTION)));
            }
        }
    }
    let contexts = [SIZES * 3, NEAR, SIZES * 4, BOTH];
    let mut models = Models {
        blend: Blend::code(coder, CLASSES, &samples),
        is_used: Bit::default(),
        by_share: Default::default(),
        by_size: [[Bit::default(); 3]; SIZES],
        presence: Weights::default(),
        residuals: [(); 3].map(|()| Residuals::new(contexts, 3)),
    };
    for values in targets.iter_mut().filter(|t| !t.is_empty()) {
        let is_used = values[from..].iter().any(|v| *v != [0; 3]);
        if coder.bit(&mut models.is_used, is_used) {
            code_target(coder, &mut models, (stencils, from), (values, largest));
        } else {
            values[from..].fill([0; 3]);
        }
    }
}

fn code_target(
    coder: &mut impl Coder,
    models: &mut Models,
    (stencils, from): (&Stencils, usize),
    (values, largest): (&mut [[i32; 3]], i32),
) {
    let mut misses = Misses::new(from, values.len());
    let mut latest = 0;
    for v in from as u32..values.len() as u32 {
        let at = v as usize;
        let (share, size) = share(stencils, values, v);
        let neighbours = stencils.neighbours(v);
        let count = neighbours.clone().count();
        let is_moved = values[at] != [0; 3];
        let ask = [
            &mut models.by_share[share][count.min(7)],
            &mut models.by_size[class_of(size)][if share == 5 { latest } else { share.min(1) * 2 }],
        ];
        if !decide(coder, ask, &mut models.presence, is_moved) {
            values[at] = [0; 3];
            latest = 0;
            continue;
        }
        latest = 1;
        let found = stencils.predict(v, |u| values[u as usize]);
        let predicted = models.blend.predict(stencils.class(v), &found);
        let near = misses.near(neighbours);
        let mut got = [0i32; 3];
        for i in 0..3 {
            let expected = (predicted[i] + (1 << (FRACTION - 1))) >> FRACTION;
            let expected = expected.clamp(-largest, largest);
            let apart = found[0][i].abs_diff(found[2][i]);
            let before = if i == 0 {
                0
            } else {
                class_of(got[i - 1].unsigned_abs())
            };
            let contexts = [
                class_of(apart >> 2) + SIZES * i,
                near,
                class_of(size) + SIZES * (before.min(6) / 2),
                both(class_of(apart >> 2), near),
            ];
            let sign = sign_of(expected);
            let given = values[at][i].wrapping_sub(expected);
            got[i] = models.residuals[i].code(coder, contexts, sign, given);
            values[at][i] = expected.saturating_add(got[i]).clamp(-largest, largest);
        }
        misses.note(v, &got);
    }
}

//! Colours of wedges.

use super::blend::{Blend, Sample};
use super::residual::{Residuals, SIZES, class_of};
use super::siblings::SameValue;
use super::stencil::{CLASSES, FRACTION, PREDICTORS};
use super::{Place, Walk};
use crate::range_coder::Coder;

/// Codes the colours of all new wedges. `agree` returns in which earlier kinds two wedges agree.
pub(super) fn code<C: Coder>(
    coder: &mut C,
    walk: &Walk<'_>,
    values: &mut [[u8; 4]],
    agree: impl Fn(u32, u32) -> usize,
) {
    let predict = |values: &[[u8; 4]], w: u32| {
        let value = |u: u32| values[u as usize].map(i32::from);
        walk.of_wedges.predict(w, value)
    };
    let mut samples: Vec<Sample<PREDICTORS, 4>> = Vec::new();
    if !C::READS {
        for w in walk.known_wedges as u32..values.len() as u32 {
            let class = walk.of_wedges.class(w);
            let truth = values[w as usize].map(|x| i32::from(x) << FRACTION);
            if class > 0 {
                samples.push((class, predict(values, w), truth));
            }
        }
    }
    let blend = Blend::code(coder, CLASSES, &samples);
    let mut same = SameValue::default();
    let mut residuals = [(); 4].map(|()| Residuals::new([SIZES, SIZES, CLASSES, 1], 1));
    for w in walk.known_wedges as u32..values.len() as u32 {
        let at = w as usize;
        let ask: Place<'_, '_> = (&walk.wedges, &walk.siblings);
        if let Some(found) = same.code(coder, ask, (values, w), &agree) {
            values[at] = found;
            continue;
        }
        let class = walk.of_wedges.class(w);
        let found = predict(values, w);
        let expected = if class == 0 {
            w.checked_sub(1)
                .map_or([255; 4], |u| values[u as usize].map(i32::from))
        } else {
            let round = |x: i32| ((x + (1 << (FRACTION - 1))) >> FRACTION).clamp(0, 255);
            blend.predict(class, &found).map(round)
        };
        let mut before = 0;
        for i in 0..4 {
            let neighbours = walk.of_wedges.neighbours(w);
            let (low, high) = neighbours.fold((255, 0), |(low, high), u| {
                let value = values[u as usize][i];
                (value.min(low), value.max(high))
            });
            let spread = class_of(u32::from(high.saturating_sub(low)));
            let contexts = [spread, class_of(before), class, 0];
            let given = i32::from(values[at][i]) - expected[i];
            let got = residuals[i].code(coder, contexts, 0, given);
            values[at][i] = expected[i].saturating_add(got).clamp(0, 255) as u8;
            before = got.unsigned_abs();
        }
    }
}

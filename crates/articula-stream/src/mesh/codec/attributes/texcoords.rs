//! Texture coordinates of wedges, predicted over wedges of the same chart.
//!
//! One candidate follows Draco's portable texture coordinate predictor: the triangle over a known
//! edge keeps its shape in space. Differs from Draco: the side is that of the face beyond the edge,
//! and the mean over all such edges is taken.

use super::blend::{Blend, Sample};
use super::residual::{BOTH, Misses, NEAR, Residuals, SIZES, both, class_of, sign_of};
use super::siblings::{SameAround, SameValue};
use super::stencil::{self, CLASSES, FRACTION, PREDICTORS};
use super::{Place, Walk};
use crate::range_coder::Coder;

const CANDIDATES: usize = PREDICTORS + 1;

/// The candidates of a wedge.
fn candidates(walk: &Walk<'_>, values: &[[i32; 2]], w: u32) -> [[i32; 2]; CANDIDATES] {
    let linear = walk.of_wedges.predict(w, |u| values[u as usize]);
    let mut out = [[0; 2]; CANDIDATES];
    out[..PREDICTORS].copy_from_slice(&linear);
    out[PREDICTORS] = shaped(walk, values, w).unwrap_or(linear[2]);
    out
}

/// Mean of the positions given by known edges and the shape of their faces.
fn shaped(walk: &Walk<'_>, values: &[[i32; 2]], w: u32) -> Option<[i32; 2]> {
    let at = |u: u32| walk.positions[walk.siblings.point(u) as usize].map(i64::from);
    let uv = |u: u32| values[u as usize].map(i64::from);
    let (mut sum, mut count) = ([0i64; 2], 0);
    for [a, b] in walk.wedges.edges(w).filter(|e| e[0] < w && e[1] < w) {
        let Some(o) = walk.wedges.across(a, b).filter(|o| *o < w) else {
            continue;
        };
        let (pa, pb, pc) = (at(a), at(b), at(w));
        let (ua, ub, uo) = (uv(a), uv(b), uv(o));
        let along: [i64; 3] = std::array::from_fn(|d| pb[d] - pa[d]);
        let up: [i64; 3] = std::array::from_fn(|d| pc[d] - pa[d]);
        let square: i64 = along.iter().map(|x| x * x).sum();
        if square == 0 {
            continue;
        }
        let dot: i64 = (0..3).map(|d| along[d] * up[d]).sum();
        let up_square: i64 = up.iter().map(|x| x * x).sum();
        let area = (i128::from(up_square) * i128::from(square) - i128::from(dot).pow(2)).max(0);
        let area = (area as u128).isqrt() as i64;
        let edge = [ub[0] - ua[0], ub[1] - ua[1]];
        let beyond = [uo[0] - ua[0], uo[1] - ua[1]];
        let side = if edge[0] * beyond[1] - edge[1] * beyond[0] > 0 {
            -1
        } else {
            1
        };
        let turned = [-edge[1], edge[0]];
        for d in 0..2 {
            let wide = i128::from(edge[d]) * i128::from(dot)
                + i128::from(side * turned[d]) * i128::from(area);
            let step = (wide << FRACTION) / i128::from(square);
            let limit = i128::from(stencil::REACH);
            sum[d] += (ua[d] << FRACTION) + step.clamp(-limit, limit) as i64;
        }
        count += 1;
    }
    let mean = |x: i64| (x / count.max(1)).clamp(-stencil::REACH, stencil::REACH) as i32;
    (count > 0).then(|| sum.map(mean))
}

/// Substitute if no wedge of the same chart is known: the value of a sibling, or the latest.
fn stand_in(walk: &Walk<'_>, values: &[[i32; 2]], w: u32) -> [i32; 2] {
    let sibling = walk.siblings.known(w).next();
    let latest = w.checked_sub(1);
    sibling.or(latest).map_or([0; 2], |u| values[u as usize])
}

/// Codes the texture coordinates of all new wedges. `agree` returns in which earlier kinds two
/// wedges agree.
pub(super) fn code<C: Coder>(
    coder: &mut C,
    walk: &Walk<'_>,
    (values, bits): (&mut [[i32; 2]], u8),
    agree: impl Fn(u32, u32) -> usize,
) {
    let most = (1 << bits) - 1;
    let mut samples: Vec<Sample<CANDIDATES, 2>> = Vec::new();
    if !C::READS {
        for w in walk.known_wedges as u32..values.len() as u32 {
            let class = walk.of_wedges.class(w);
            let value = values[w as usize];
            if class > 0 && walk.siblings.known(w).all(|s| values[s as usize] != value) {
                let truth = value.map(|x| x << FRACTION);
                samples.push((class, candidates(walk, values, w), truth));
            }
        }
    }
    let blend = Blend::code(coder, CLASSES, &samples);
    let mut same = SameValue::default();
    let mut around = SameAround::default();
    let contexts = [SIZES * 3, NEAR, CLASSES * 4, BOTH];
    let mut residuals = [(); 2].map(|()| Residuals::new(contexts, 3));
    let mut misses = Misses::new(walk.known_wedges, values.len());
    for w in walk.known_wedges as u32..values.len() as u32 {
        let at = w as usize;
        let ask: Place<'_, '_> = (&walk.wedges, &walk.siblings);
        if let Some(found) = same.code(coder, ask, (values, w), &agree) {
            values[at] = found;
            continue;
        }
        let latest_first = |u: u32| u64::from(u32::MAX - u);
        let near = (&walk.wedges, &walk.points, &walk.siblings);
        if let Some(found) = around.code(coder, near, (values, w), latest_first) {
            values[at] = found;
            continue;
        }
        let class = walk.of_wedges.class(w);
        let (expected, apart) = if class == 0 {
            (stand_in(walk, values, w), 0)
        } else {
            let found = candidates(walk, values, w);
            let predicted = blend.predict(class, &found);
            let apart: u32 = (0..2)
                .map(|d| found[2][d].abs_diff(found[4][d]) + found[0][d].abs_diff(found[2][d]) / 4)
                .sum();
            let round = |x: i32| ((x + (1 << (FRACTION - 1))) >> FRACTION).clamp(0, most);
            (predicted.map(round), apart)
        };
        let near = misses.near(walk.of_wedges.neighbours(w));
        let spread = class_of(apart >> 3);
        let mut got = [0i32; 2];
        for i in 0..2 {
            let other = match (i, got[0].unsigned_abs()) {
                (0, _) => 0,
                (_, n) => 1 + class_of(n).min(6) / 3,
            };
            let contexts = [
                spread + SIZES * other.min(2),
                near,
                class * 4 + other,
                both(spread, near),
            ];
            let sign = if i == 0 { 1 } else { sign_of(got[0]) };
            got[i] = residuals[i].code(
                coder,
                contexts,
                sign,
                values[at][i].wrapping_sub(expected[i]),
            );
            values[at][i] = expected[i].saturating_add(got[i]).clamp(0, most);
        }
        misses.note(w, &got);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::codec::surface::Surface;

    #[test]
    fn a_face_keeps_its_shape() {
        let positions = [[0, 0, 0], [10, 0, 0], [0, 10, 0], [13, 9, 0]];
        let surface = Surface {
            faces: &[[0, 1, 2], [1, 3, 2]],
            wedge_points: &[0, 1, 2, 3],
            known_points: 0,
            known_wedges: 0,
        };
        let walk = Walk::new(&surface, &positions);
        // Similar charts, scaled by 2: upright, mirrored, and turned by a right angle.
        let charts: [fn([i32; 3]) -> [i32; 2]; 3] = [
            |p| [20 + 2 * p[0], 30 + 2 * p[1]],
            |p| [60 - 2 * p[0], 30 + 2 * p[1]],
            |p| [50 - 2 * p[1], 30 + 2 * p[0]],
        ];
        for chart in charts {
            let mut values = positions.map(chart);
            let expected = values[3].map(|x| x << FRACTION);
            values[3] = [0; 2];
            assert_eq!(shaped(&walk, &values, 3), Some(expected));
            assert_eq!(candidates(&walk, &values, 3)[PREDICTORS], expected);
            // The third wedge has known neighbours, but no face beyond them.
            assert_eq!(shaped(&walk, &values, 2), None);
            assert_eq!(stand_in(&walk, &values, 2), values[1]);
        }
    }
}

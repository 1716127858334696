//! Normals of wedges, predicted from faces and from the deviation of neighbouring normals.

use super::blend::{Blend, Sample};
use super::geometry::{self, Normals};
use super::residual::{BOTH, Misses, NEAR, Residuals, SIZES, both, class_of, sign_of};
use super::siblings::{SameAround, SameValue};
use super::{Place, Walk};
use crate::range_coder::Coder;

/// Candidates: by angle and by area over the wedge's faces, by angle and area over the point's, the
/// mean correction of the neighbours, its affine fit, the mean of the neighbours, its affine fit,
/// and by angle over all faces of the point's neighbours.
const CANDIDATES: usize = 9;
/// Classes of surroundings: whether a neighbour is known, whether the point has other wedges.
const CLASSES: usize = 6;

/// Geometric normals of a whole level.
pub(super) struct Geometry {
    of_wedges: Normals,
    of_points: Normals,
    /// Normals of points weighted by angle, over all neighbours.
    smoothed: Vec<[i32; 3]>,
}

impl Geometry {
    pub(super) fn new(walk: &Walk<'_>) -> Self {
        let at = |w: u32| walk.positions[walk.siblings.point(w) as usize];
        let of_points = Normals::new(&walk.points, |p| walk.positions[p as usize]);
        let smooth = |p: u32| {
            let mut sum = of_points.by_angle[p as usize].map(i64::from);
            for u in walk.points.edges(p).flatten() {
                let normal = of_points.by_angle[u as usize];
                for d in 0..3 {
                    sum[d] += i64::from(normal[d]);
                }
            }
            geometry::unit(sum)
        };
        Self {
            of_wedges: Normals::new(&walk.wedges, at),
            smoothed: (0..walk.points.len() as u32).map(smooth).collect(),
            of_points,
        }
    }
}

struct Predictor<'a> {
    walk: &'a Walk<'a>,
    geometry: &'a Geometry,
    bits: u8,
}

impl Predictor<'_> {
    fn class(&self, w: u32) -> usize {
        let known = match self.walk.of_wedges.class(w) {
            0 => 0,
            5 => 2,
            _ => 1,
        };
        known + 3 * usize::from(self.walk.siblings.all(w).len() > 1)
    }

    /// The candidates, and the spread of the neighbours' corrections.
    fn candidates(&self, w: u32, vectors: &[[i32; 3]]) -> ([[i32; 3]; CANDIDATES], u32) {
        let (stencils, geometry) = (&self.walk.of_wedges, self.geometry);
        let by_angle = &geometry.of_wedges.by_angle;
        let point = self.walk.siblings.point(w) as usize;
        let base = by_angle[w as usize];
        let correction = |u: u32| -> [i32; 3] {
            let (found, shape) = (vectors[u as usize], by_angle[u as usize]);
            std::array::from_fn(|d| found[d] - shape[d])
        };
        let corrections = stencils.predict(w, correction);
        let means = stencils.predict(w, |u| vectors[u as usize]);
        let whole = |v: [i32; 3]| v.map(|x| x >> super::stencil::FRACTION);
        let off = |by: [i32; 3]| -> [i32; 3] { std::array::from_fn(|d| base[d] + by[d]) };
        let mean = whole(corrections[0]);
        let has_none = stencils.class(w) == 0;
        let neighbours = stencils.neighbours(w);
        let count = neighbours.clone().count().max(1) as u32;
        let apart: u32 = neighbours
            .map(|u| {
                let c = correction(u);
                (0..3).map(|d| c[d].abs_diff(mean[d])).sum::<u32>()
            })
            .sum();
        let candidates = [
            base,
            geometry.of_wedges.by_area[w as usize],
            geometry.of_points.by_angle[point],
            geometry.of_points.by_area[point],
            off(mean),
            off(whole(corrections[2])),
            if has_none { base } else { whole(means[0]) },
            if has_none { base } else { whole(means[2]) },
            geometry.smoothed[point],
        ];
        (candidates, apart / count)
    }
}

/// Models of normals.
struct Models {
    blend: Blend<CANDIDATES>,
    same: SameValue,
    around: SameAround,
    residuals: [Residuals; 2],
    misses: Misses,
}

/// Codes the normals of all new wedges.
pub(super) fn code<C: Coder>(
    coder: &mut C,
    walk: &Walk<'_>,
    geometry: &Geometry,
    (normals, bits): (&mut [[i32; 2]], u8),
) {
    let predictor = Predictor {
        walk,
        geometry,
        bits,
    };
    let first = walk.known_wedges as u32;
    let vector = |place: &[i32; 2]| geometry::of_octahedron(*place, bits);
    let samples = if C::READS {
        Vec::new()
    } else {
        predictor.samples(normals)
    };
    let mut vectors: Vec<[i32; 3]> = normals[..walk.known_wedges].iter().map(vector).collect();
    vectors.resize(normals.len(), [0; 3]);
    let contexts = [SIZES * 2, NEAR, CLASSES * 2 * 3, BOTH];
    let mut models = Models {
        blend: Blend::code(coder, CLASSES, &samples),
        same: SameValue::default(),
        around: SameAround::default(),
        residuals: [(); 2].map(|()| Residuals::new(contexts, 3)),
        misses: Misses::new(walk.known_wedges, normals.len()),
    };
    for w in first..normals.len() as u32 {
        let ask: Place<'_, '_> = (&walk.wedges, &walk.siblings);
        let at = w as usize;
        if let Some(found) = models.same.code(coder, ask, (normals, w), |_, _| 0) {
            normals[at] = found;
            if let Some(sibling) = walk.siblings.known(w).next() {
                models.misses.copy(w, sibling);
            }
            vectors[at] = vector(&normals[at]);
            continue;
        }
        let shape = geometry.of_wedges.by_angle[at];
        let far = |u: u32| {
            let other = vectors[u as usize];
            (0..3)
                .map(|d| u64::from(shape[d].abs_diff(other[d])).pow(2))
                .sum()
        };
        let around = (&walk.wedges, &walk.points, &walk.siblings);
        if let Some(found) = models.around.code(coder, around, (normals, w), far) {
            normals[at] = found;
        } else {
            normals[at] = predictor.code(coder, &mut models, w, (&vectors, normals[at]));
        }
        vectors[at] = vector(&normals[at]);
    }
}

impl Predictor<'_> {
    /// Samples for fitting: normals that differ from all siblings.
    fn samples(&self, normals: &[[i32; 2]]) -> Vec<Sample<CANDIDATES, 3>> {
        let vector = |place: &[i32; 2]| geometry::of_octahedron(*place, self.bits);
        let vectors: Vec<[i32; 3]> = normals.iter().map(vector).collect();
        let siblings = &self.walk.siblings;
        let is_new = |w: &u32| {
            let value = normals[*w as usize];
            siblings.known(*w).all(|s| normals[s as usize] != value)
        };
        let all = self.walk.known_wedges as u32..normals.len() as u32;
        let sample = |w: u32| {
            let candidates = self.candidates(w, &vectors).0;
            (self.class(w), candidates, vectors[w as usize])
        };
        all.filter(is_new).map(sample).collect()
    }

    /// Codes one normal that differs from all siblings.
    fn code(
        &self,
        coder: &mut impl Coder,
        models: &mut Models,
        w: u32,
        (vectors, given): (&[[i32; 3]], [i32; 2]),
    ) -> [i32; 2] {
        let bits = self.bits;
        // Approximate lengths in octahedral steps.
        let scale = |x: u32| x >> (15 - bits.min(14));
        let class = self.class(w);
        let (candidates, apart) = self.candidates(w, vectors);
        let predicted = models.blend.predict(class, &candidates);
        let expected = geometry::on_octahedron(predicted, bits);
        let near = models.misses.near(self.walk.of_wedges.neighbours(w));
        let spread = class_of(scale(4 * apart));
        let between = |i: usize, j: usize| -> u32 {
            let (a, b) = (candidates[i], candidates[j]);
            (0..3).map(|d| a[d].abs_diff(b[d])).sum()
        };
        let is_bent = class_of(scale(between(1, 2) + between(0, 6))) > 6;
        let name = geometry::nearest_name(given, expected, bits);
        let mut got = [0i32; 2];
        for i in 0..2 {
            let missed = got[0].unsigned_abs();
            let other = if i == 0 {
                0
            } else {
                1 + usize::from(missed > 1)
            };
            let contexts = [
                spread + SIZES * usize::from(missed > 2),
                near,
                (class * 3 + other) * 2 + usize::from(is_bent),
                both(spread, near),
            ];
            let sign = if i == 0 { 1 } else { sign_of(got[0]) };
            got[i] = models.residuals[i].code(coder, contexts, sign, name[i] - expected[i]);
        }
        models.misses.note(w, &got);
        let last = geometry::last(bits);
        let place = |i: usize| expected[i].saturating_add(got[i]).clamp(-last, 2 * last);
        geometry::folded([place(0), place(1)], bits)
    }
}

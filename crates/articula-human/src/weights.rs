//! Skin weights of the reference human, computed from the position of a point in the body.
//!
//! Along a limb every joint has a plane; the weight of a point passes from one bone to the next
//! over a band around that plane, about as wide as the limb is thick. Weights are smooth, sum to 1
//! and depend on the position only, so that all levels of the surface, and both sides of the body,
//! deform equally.

use crate::body::Body;
use crate::skeleton::{FINGER_POINTS, FINGERS, centers, hand_axes, hand_point, joint};
use articula_core::hanim_table::{BODY_JOINTS, JOINTS};
use glam::Vec3;

/// Maximum number of influences of a skin vertex.
pub(crate) const INFLUENCES: usize = 4;

/// Joints and weights of one vertex, largest first; unused ones have weight 0.
pub(crate) type Influences = [(u16, f32); INFLUENCES];

/// Computes weights of points on or near the skin.
pub(crate) struct Weigher<'a> {
    body: &'a Body,
    centers: Vec<Vec3>,
    /// The same joint on the other side; for a joint in the middle, the joint itself.
    twins: Vec<usize>,
    /// Vertebrae from the lowest to the highest, with the height at which each takes over.
    spine: Vec<(usize, f32)>,
}

/// Accumulates weights by joint.
#[derive(Default)]
struct Sum(Vec<(usize, f32)>);

impl Sum {
    fn add(&mut self, joint: usize, weight: f32) {
        if weight > 0.0 {
            match self.0.iter_mut().find(|(j, _)| *j == joint) {
                Some((_, w)) => *w += weight,
                None => self.0.push((joint, weight)),
            }
        }
    }

    /// The largest influences, normalised to a sum of 1.
    fn heaviest(mut self) -> Influences {
        self.0
            .sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        self.0.truncate(INFLUENCES);
        let total: f32 = self.0.iter().map(|(_, w)| w).sum();
        std::array::from_fn(|i| match self.0.get(i) {
            Some((j, w)) => (*j as u16, w / total),
            None => (self.0[0].0 as u16, 0.0),
        })
    }
}

impl<'a> Weigher<'a> {
    /// Prepares the weights of a body.
    pub(crate) fn new(body: &'a Body) -> Self {
        let centers = centers();
        let twin = |name: &str| {
            let (side, rest) = name.split_at(2.min(name.len()));
            match side {
                "l_" => joint(&format!("r_{rest}")),
                "r_" => joint(&format!("l_{rest}")),
                _ => joint(name),
            }
        };
        let first = joint("vl5");
        let spine = (first..joint("skullbase"))
            .map(|j| (j, centers[j].y))
            .collect();
        Self {
            body,
            twins: JOINTS[..BODY_JOINTS].iter().map(|j| twin(j.name)).collect(),
            centers,
            spine,
        }
    }

    /// Influences at a point of the skin.
    pub(crate) fn at(&self, p: Vec3) -> Influences {
        let left = Vec3::new(p.x.abs(), p.y, p.z);
        let mut sum = Sum::default();
        let arm = self.arm_share(left);
        let leg = self.leg_share(left) * (1.0 - arm);
        self.arm(left, arm, &mut sum);
        self.legs(left, leg, &mut sum);
        self.core(left, 1.0 - arm - leg, &mut sum);
        if p.x < 0.0 {
            for (j, _) in &mut sum.0 {
                *j = self.twins[*j];
            }
        }
        sum.heaviest()
    }

    /// Share of a point beyond the plane of a joint; `band` is half the width of the transition.
    fn behind(&self, name: &str, normal: Vec3, band: f32, p: Vec3) -> f32 {
        let along = (p - self.centers[joint(name)]).dot(normal.normalize());
        smooth_step(-band, band, along)
    }

    fn arm_share(&self, p: Vec3) -> f32 {
        let core = self.body.trunk.distance(p).min(self.body.leg.distance(p));
        let nearer = core - self.body.upper_limb(p);
        let plane = self.behind("l_shoulder", Vec3::new(0.88, -0.47, 0.0), 0.07, p);
        // In the armpit the transition is sharp, so that the flank stays with the trunk.
        let band = 0.004 + 0.026 * smooth_step(1.28, 1.4, p.y);
        plane * smooth_step(-band, band, nearer)
    }

    fn leg_share(&self, p: Vec3) -> f32 {
        self.behind("l_hip", Vec3::new(0.3, -0.95, 0.0), 0.075, p)
    }

    fn legs(&self, p: Vec3, share: f32, sum: &mut Sum) {
        let knee = self.behind("l_knee", Vec3::NEG_Y, 0.05, p);
        let ankle = self.behind("l_ankle", Vec3::new(0.0, -0.92, 0.4), 0.03, p);
        let heel = self.behind("l_subtalar", Vec3::NEG_Y, 0.025, p) * ankle;
        let middle = self.behind("l_midtarsal", Vec3::Z, 0.03, p);
        let toes = self.behind("l_metatarsal", Vec3::new(0.35, 0.0, 0.94), 0.016, p);
        // Between the legs both sides weigh the same.
        let own = smooth_step(-0.02, 0.02, p.x);
        sum.add(joint("l_hip"), share * (1.0 - knee) * own);
        sum.add(joint("r_hip"), share * (1.0 - knee) * (1.0 - own));
        let shin = share * knee;
        sum.add(joint("l_knee"), shin * (1.0 - ankle));
        sum.add(joint("l_ankle"), shin * (ankle - heel) * (1.0 - middle));
        sum.add(joint("l_subtalar"), shin * heel * (1.0 - middle));
        sum.add(joint("l_midtarsal"), shin * ankle * middle * (1.0 - toes));
        sum.add(joint("l_metatarsal"), shin * ankle * middle * toes);
    }

    fn arm(&self, p: Vec3, share: f32, sum: &mut Sum) {
        if share <= 0.0 {
            return;
        }
        let elbow = self.behind("l_elbow", Vec3::new(0.11, -1.0, 0.02), 0.045, p);
        let wrist = self.behind("l_wrist", hand_axes().y_axis, 0.022, p);
        sum.add(joint("l_shoulder"), share * (1.0 - elbow));
        sum.add(joint("l_elbow"), share * elbow * (1.0 - wrist));
        self.hand(p, share * elbow * wrist, sum);
    }

    fn hand(&self, p: Vec3, share: f32, sum: &mut Sum) {
        if share <= 0.0 {
            return;
        }
        let gaps = self
            .body
            .fingers
            .each_ref()
            .map(|finger| finger.distance(p));
        let nearest = (0..5).fold(0, |best, f| if gaps[f] < gaps[best] { f } else { best });
        let second = (0..5)
            .filter(|f| *f != nearest)
            .map(|f| gaps[f])
            .fold(f32::MAX, f32::min);
        // Where two fingers are equally near, the skin stays with the palm.
        let own = smooth_step(0.0, 0.003, second - gaps[nearest]);
        let thumb = if nearest == 0 { own } else { 0.0 };
        let near_thumb =
            smooth_step(0.02, 0.003, gaps[0]).min(if nearest == 0 { 1.0 } else { thumb });
        let knuckle = match nearest {
            0 => near_thumb * self.phalanx(p, 0, 1, 0.02),
            f => own * self.phalanx(p, f, 1, 0.009) * smooth_step(0.012, 0.002, gaps[f]),
        };
        self.palm(p, share * (1.0 - knuckle), sum);
        let middle = self.phalanx(p, nearest, 2, 0.007);
        let end = self.phalanx(p, nearest, 3, 0.006);
        let name = |digit: usize| joint(&format!("l_{}{digit}", FINGERS[nearest]));
        sum.add(name(1), share * knuckle * (1.0 - middle));
        sum.add(name(2), share * knuckle * middle * (1.0 - end));
        sum.add(name(3), share * knuckle * middle * end);
    }

    /// Share beyond a joint of a finger, along the mean direction of its two bones.
    fn phalanx(&self, p: Vec3, finger: usize, digit: usize, band: f32) -> f32 {
        let points = FINGER_POINTS[finger].map(hand_point);
        let before = (points[digit] - points[digit - 1]).normalize_or_zero();
        let after = (points[digit + 1] - points[digit]).normalize();
        smooth_step(
            -band,
            band,
            (p - points[digit]).dot((before + after).normalize()),
        )
    }

    /// Wrist and metacarpals: weight between the two knuckles nearest to the point.
    fn palm(&self, p: Vec3, share: f32, sum: &mut Sum) {
        let local = hand_axes().transpose() * (p - self.centers[joint("l_wrist")]);
        let forward = smooth_step(0.03, 0.075, local.y) * share;
        sum.add(joint("l_wrist"), share - forward);
        let sides: [f32; 4] = std::array::from_fn(|f| FINGER_POINTS[f + 1][1][2]);
        let place = (0..3)
            .map(|f| ((sides[f] - local.z) / (sides[f] - sides[f + 1])).clamp(0.0, 1.0))
            .sum::<f32>();
        for f in 0..4 {
            let weight = (1.0 - (place - f as f32).abs()).max(0.0);
            sum.add(joint(&format!("l_{}0", FINGERS[f + 1])), forward * weight);
        }
    }

    /// Pelvis, spine, skull and collar joints.
    fn core(&self, p: Vec3, share: f32, sum: &mut Sum) {
        let ahead = p.z + 0.01;
        let skull = smooth_step(
            1.57,
            1.614,
            p.y + 0.9 * ahead.max(0.0) + 0.2 * ahead.min(0.0),
        );
        sum.add(joint("skullbase"), share * skull);
        let rest = share * (1.0 - skull);
        let collar = smooth_step(0.03, 0.16, p.x) * smooth_step(1.34, 1.45, p.y) * 0.9;
        let outer = smooth_step(0.09, 0.17, p.x);
        sum.add(joint("l_sternoclavicular"), rest * collar * (1.0 - outer));
        sum.add(joint("l_acromioclavicular"), rest * collar * outer);
        self.spine(
            p.y + 0.35 * ahead.max(0.0) * smooth_step(1.45, 1.52, p.y),
            rest * (1.0 - collar),
            sum,
        );
    }

    fn spine(&self, height: f32, share: f32, sum: &mut Sum) {
        let waist = smooth_step(0.94, 1.01, height);
        sum.add(joint("sacroiliac"), share * (1.0 - waist));
        let mut left = share * waist;
        // The belly between pelvis and spine is on the root, the parent of both.
        let first = smooth_step(0.99, self.spine[0].1 + 0.02, height);
        sum.add(joint("humanoid_root"), left * (1.0 - first));
        left *= first;
        let mut passed = 1.0;
        for (i, (at, _)) in self.spine.iter().enumerate() {
            let next = match self.spine.get(i + 1) {
                Some((_, center)) => smooth_step(-1.0, 1.0, (height - center) / self.spine_band(i)),
                None => 0.0,
            };
            let next = next.min(passed);
            sum.add(*at, left * (passed - next));
            passed = next;
        }
    }

    /// Half the height of the transition between two vertebrae. Large at the waist, where a few
    /// joints often take a whole bend; smaller where the collar joints need influences too.
    fn spine_band(&self, i: usize) -> f32 {
        let ((_, low), (_, high)) = (self.spine[i], self.spine[i + 1]);
        (high - low) * if high < 1.37 { 1.5 } else { 1.0 }
    }
}

/// Cubic step from 0 at `from` to 1 at `to`; `to` may be the smaller one.
pub(crate) fn smooth_step(from: f32, to: f32, x: f32) -> f32 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

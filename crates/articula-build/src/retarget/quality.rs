//! Quality measures of a retargeted motion, independent of the size of the figure.

use super::contacts::Contact;
use super::frames;
use super::planted::Planted;
use super::pose::Pose;
use super::steps::{Sole, rest_floor};
use super::transfer::Transfer;
use articula_core::Libm;
use glam::Vec3;

/// Sine of the angle up to which a knee or elbow may bend to its wrong side: straight limbs do, by
/// measurement noise.
const WRONG_SINE: f32 = 0.1;

/// Distances by which feet moved during contacts.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FootSlide {
    /// Number of contacts of heels and toes.
    pub contacts: usize,
    /// Mean over the contacts of the maximum distance of a point from where it began, metres.
    pub mean_metres: f32,
    /// Maximum of that distance over all contacts, metres.
    pub max_metres: f32,
}

/// Error of limb end positions relative to the start of the limb, compared with the source; in
/// lengths of the limb.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EndEffectorError {
    /// Mean over frames and sides.
    pub mean: f32,
    /// Maximum over frames and sides.
    pub max: f32,
}

/// Quality measures of one retargeted clip.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RetargetQuality {
    /// Foot slide after the transfer of rotations alone, before pinning.
    pub slide_before: FootSlide,
    /// Foot slide in the result.
    pub slide: FootSlide,
    /// Foot slide of the source, scaled to the target.
    pub slide_source: FootSlide,
    /// Maximum depth of a sole below the floor after the transfer of rotations alone, metres.
    pub below_floor_before_metres: f32,
    /// Maximum depth of a sole below the floor in the result, metres.
    pub below_floor_metres: f32,
    /// Error of the wrists, relative to the shoulders.
    pub hands: EndEffectorError,
    /// Error of the ankles, relative to the hips.
    pub feet: EndEffectorError,
    /// Error of the head, relative to the hips.
    pub head: EndEffectorError,
    /// Share of frames and sides in which a knee bends forward or an elbow backward.
    pub hinge_wrong_share: f32,
}

/// Accumulates the measures while frames are processed.
#[derive(Debug)]
pub(super) struct Gauge<'a> {
    limbs: &'a [Planted],
    ends: Vec<End>,
    before: Feet,
    after: Feet,
    source: Feet,
    errors: [Error; 3],
    hinges: Vec<(usize, usize, usize, Vec3, f32)>,
    wrong: usize,
    frames: usize,
}

/// An end of a limb in both figures.
#[derive(Debug)]
struct End {
    kind: usize,
    source: [usize; 2],
    target: [usize; 2],
    lengths: [f32; 2],
}

#[derive(Debug, Clone, Copy, Default)]
struct Error {
    sum: f32,
    count: usize,
    max: f32,
}

/// Start positions and slide of the contacts of all feet; depth of the soles.
#[derive(Debug, Default)]
struct Feet {
    starts: Vec<Option<Vec3>>,
    slides: Vec<f32>,
    below: f32,
}

impl Feet {
    /// Adds the points of one frame: the position of each point and its contacts.
    fn push<'p>(
        &mut self,
        frame: usize,
        floor: f32,
        points: impl Iterator<Item = (Vec3, &'p [Contact])>,
    ) {
        let mut slot = 0;
        for (place, contacts) in points {
            self.below = self.below.max(floor - place.y);
            for contact in contacts {
                if self.starts.len() <= slot {
                    self.starts.push(None);
                    self.slides.push(0.0);
                }
                if contact.frames.contains(&frame) {
                    let start = *self.starts[slot].get_or_insert(place);
                    let way = place - start;
                    let slide = &mut self.slides[slot];
                    *slide = slide.max(way.x.libm_hypot(way.z));
                }
                slot += 1;
            }
        }
    }

    fn slide(&self, scale: f32) -> FootSlide {
        let contacts = self.slides.len();
        FootSlide {
            contacts,
            mean_metres: scale * self.slides.iter().sum::<f32>() / contacts.max(1) as f32,
            max_metres: scale * self.slides.iter().copied().fold(0.0, f32::max),
        }
    }
}

impl<'a> Gauge<'a> {
    pub(super) fn new(transfer: &Transfer<'_>, limbs: &'a [Planted]) -> Self {
        Self {
            limbs,
            ends: ends(transfer),
            before: Feet::default(),
            after: Feet::default(),
            source: Feet::default(),
            errors: [Error::default(); 3],
            hinges: hinges(transfer),
            wrong: 0,
            frames: 0,
        }
    }

    /// Measures a pose before limbs are bent.
    pub(super) fn before(&mut self, transfer: &Transfer<'_>, frame: usize, pose: &Pose) {
        let floor = rest_floor(transfer.target);
        self.before.push(frame, floor, points(self.limbs, pose));
    }

    /// Measures a finished pose.
    pub(super) fn after(&mut self, transfer: &Transfer<'_>, frame: usize, pose: &Pose) {
        let floor = rest_floor(transfer.target);
        self.after.push(frame, floor, points(self.limbs, pose));
        self.frames += 1;
        let (places, deltas) = (
            transfer.motion.positions(frame),
            transfer.motion.deltas(frame),
        );
        let feet = transfer.source.body.legs.iter().zip(&transfer.steps.feet);
        let own = feet.filter_map(|(leg, foot)| {
            let [heel, toe] = super::steps::soles(transfer.source, leg)?;
            let ankle = leg.ankle?;
            let at = |sole: Sole| sole.at(places[ankle], deltas[ankle]);
            Some([(at(heel), &foot.heel[..]), (at(toe), &foot.toe[..])])
        });
        self.source.push(frame, transfer.steps.floor, own.flatten());
        for end in &self.ends {
            let way = |[a, b]: [usize; 2], at: &[Vec3]| at[b] - at[a];
            let wanted = transfer.plan.world * way(end.source, places) / end.lengths[0];
            let found = way(end.target, &pose.positions) / end.lengths[1];
            let off = wanted.distance(found);
            let error = &mut self.errors[end.kind];
            error.sum += off;
            error.count += 1;
            error.max = error.max.max(off);
        }
        for (upper, middle, end, front, sign) in &self.hinges {
            let at = |j: usize| pose.positions[j];
            let lower = (at(*end) - at(*middle)).normalize_or_zero();
            let front = pose.deltas[*upper] * *front;
            self.wrong += usize::from(sign * lower.dot(front) < -WRONG_SINE);
        }
    }

    /// For each contact of the feet, in the order of the limbs' points, whether its point slides
    /// farther in the result than before, by more than `noise_metres`.
    pub(super) fn slides_farther(&self, noise_metres: f32) -> Vec<bool> {
        let pairs = self.before.slides.iter().zip(&self.after.slides);
        pairs
            .map(|(before, after)| *after > before + noise_metres)
            .collect()
    }

    /// Returns the accumulated measures.
    pub(super) fn quality(&self, scale: f32) -> RetargetQuality {
        let error = |e: &Error| EndEffectorError {
            mean: e.sum / e.count.max(1) as f32,
            max: e.max,
        };
        let [hands, feet, head] = &self.errors;
        let hinges = self.hinges.len() * self.frames;
        RetargetQuality {
            slide_before: self.before.slide(1.0),
            slide: self.after.slide(1.0),
            slide_source: self.source.slide(scale),
            below_floor_before_metres: self.before.below,
            below_floor_metres: self.after.below,
            hands: error(hands),
            feet: error(feet),
            head: error(head),
            hinge_wrong_share: self.wrong as f32 / hinges.max(1) as f32,
        }
    }
}

/// Soles of a pose with their contacts, legs only.
fn points<'p>(limbs: &'p [Planted], pose: &'p Pose) -> impl Iterator<Item = (Vec3, &'p [Contact])> {
    let legs = limbs.iter().filter(|l| l.is_leg);
    legs.flat_map(move |planted| {
        let end = planted.limb.end;
        let at = move |sole: &Sole| sole.at(pose.positions[end], pose.deltas[end]);
        planted
            .points
            .iter()
            .map(move |(sole, c)| (at(sole), &c[..]))
    })
}

/// Wrists, ankles and head that both figures have.
fn ends(transfer: &Transfer<'_>) -> Vec<End> {
    let (source, target) = (&transfer.source.rest, &transfer.target.rest);
    let mut ends = Vec::new();
    let mut add = |kind: usize, names: &[String]| {
        let all = |rest: &super::rest::Rest| -> Option<Vec<usize>> {
            names.iter().map(|n| rest.find(n)).collect()
        };
        let Some((s, t)) = all(source).zip(all(target)) else {
            return;
        };
        let length = |rest: &super::rest::Rest, joints: &[usize]| {
            let ways = joints.windows(2).map(|w| rest.way(w[0], w[1]).length());
            ways.sum::<f32>().max(1e-4)
        };
        let lengths = [length(source, &s), length(target, &t)];
        let outer = |joints: &[usize]| [joints[0], joints[joints.len() - 1]];
        ends.push(End {
            kind,
            source: outer(&s),
            target: outer(&t),
            lengths,
        });
    };
    for side in ['l', 'r'] {
        let titles = |names: [&str; 3]| names.map(|n| format!("{side}_{n}"));
        add(0, &titles(["shoulder", "elbow", "wrist"]));
        add(1, &titles(["hip", "knee", "ankle"]));
    }
    for side in ['l', 'r'] {
        add(2, &[format!("{side}_hip"), "skullbase".to_owned()]);
    }
    ends
}

/// Elbows and knees: the three joints of the limb, its front at rest, and the sign of the side to
/// which the lower segment bends.
fn hinges(transfer: &Transfer<'_>) -> Vec<(usize, usize, usize, Vec3, f32)> {
    let target = transfer.target;
    let mut hinges = Vec::new();
    for side in ['l', 'r'] {
        for (names, sign) in [
            (["shoulder", "elbow", "wrist"], 1.0),
            (["hip", "knee", "ankle"], -1.0),
        ] {
            let joints = names.map(|n| target.rest.sided(side, n));
            if let [Some(upper), Some(middle), Some(end)] = joints {
                let frames::Frames { own, part } = &target.frames;
                let frame = own[upper].unwrap_or(part[upper]);
                hinges.push((upper, middle, end, frame * Vec3::Y, sign));
            }
        }
    }
    hinges
}

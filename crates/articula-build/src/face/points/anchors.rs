//! Feature points that the geometry of a face shows by itself: nose, lips, chin and eyes.

use super::eyes::{EyeOpening, Eyeball, eyeballs, opening};
use super::profile::Profile;
use super::sockets::{Socket, sockets};
use super::surface::{FaceSurface, SurfacePart};
use articula_core::feature_points::PointId;
use glam::Vec3;

/// Steps of the profile between the tip of the nose and the top of the skull.
const STEPS: f32 = 400.0;
/// Least depth of a turn of the profile, tried in this order, as fractions of that height.
const PROMINENCES: [f32; 3] = [0.0022, 0.0012, 0.0006];
/// Tilts of the profile that are tried, depth by height.
const TILTS: [f32; 5] = [0.0, 0.15, -0.15, 0.3, -0.3];
/// Least area of the skin, as a fraction of that of the largest part.
const LARGE: f32 = 0.1;
/// Least depth of a head with a back, as a fraction of its height.
const MASK: f32 = 0.6;
/// How far below the nose the chin is sought at most, as a fraction of that height.
const BELOW: f32 = 0.7;
/// Least depth of the line between the lips, as a fraction of that height.
const SEAM: f32 = 0.0024;
/// How far the line may rise or fall from one step sideways to the next, as a fraction of that height.
const WANDER: f32 = 0.008;
/// Reach from that line to the fullest places of the lips, as a fraction of that height.
const LIP: f32 = 0.03;
/// Number of steps sideways over which that line may vanish before it ends.
const BRIDGED: usize = 12;
/// Depth behind the lips from which the mouth counts as open.
const OPEN: f32 = 0.05;

/// Pupil, upper and lower rim, and the corners towards +X and -X, of the left and the right eye.
const EYES: [[PointId; 5]; 2] = [
    [(3, 5), (3, 1), (3, 3), (3, 7), (3, 11)],
    [(3, 6), (3, 2), (3, 4), (3, 8), (3, 12)],
];

/// What was found, and the sizes that scale further searches.
#[derive(Debug, Clone)]
pub(super) struct Anchors {
    /// Points and places, the nose first.
    pub(super) points: Vec<(PointId, Vec3)>,
    /// Index of the part that has the nose.
    pub(super) skin: usize,
    /// The eyeballs: left and right.
    pub(super) eyeballs: Option<[Eyeball; 2]>,
    /// Centres of the eyeballs that only joints tell: left and right.
    pub(super) eye_centres: Option<[Vec3; 2]>,
    /// Points that blend shapes show.
    pub(super) shown: Vec<(PointId, Vec3)>,
    /// Sides of the skull and outer rims of the ears, as [`WIDTHS`](super::template::WIDTHS).
    pub(super) widths: Vec<(usize, Vec3)>,
    /// Sideways place of the plane of symmetry.
    middle_x: f32,
}

impl Anchors {
    /// The place of a point, if it was found.
    pub(super) fn get(&self, point: PointId) -> Option<Vec3> {
        self.points.iter().find(|p| p.0 == point).map(|p| p.1)
    }

    /// Searches a surface. `None` if its foremost large part has no nose.
    pub(super) fn find(surface: &FaceSurface, parts: &[SurfacePart]) -> Option<Self> {
        let skin = foremost(surface, parts)?;
        let part = &parts[skin];
        let middle_x = middle(surface, part)?;
        let head = head(surface, parts, skin);
        let of_head = || head.iter().flat_map(|p| places(surface, p));
        let width = 2.0
            * of_head()
                .map(|p| (p.x - middle_x).abs())
                .fold(0.0, f32::max);
        let near = places(surface, part).filter(|p| (p.x - middle_x).abs() < 0.1 * width);
        let nose = near.max_by(|a, b| a.z.total_cmp(&b.z))?;
        let top = of_head().max_by(|a, b| a.y.total_cmp(&b.y))?;
        let skull = top.y - nose.y;
        if skull < 0.2 * width {
            return None;
        }
        let mut found = Self {
            points: vec![((9, 3), nose), ((11, 4), top)],
            skin,
            eyeballs: eyeballs(surface, parts, middle_x, 2.0 * skull),
            eye_centres: None,
            shown: Vec::new(),
            widths: widths(of_head, middle_x, nose.y, skull),
            middle_x,
        };
        found.eyes(surface, parts, skull / STEPS);
        if found.eyeballs.is_none() {
            found.eye_centres = surface.eyes;
            let seen = sockets(surface, part, nose, middle_x, skull, skull / STEPS);
            match seen {
                Some(seen) => found.openings(&seen),
                None => found.lids(surface),
            }
        }
        found.mouth(surface, part, skull);
        Some(found)
    }

    fn eyes(&mut self, surface: &FaceSurface, parts: &[SurfacePart], step: f32) {
        let Some(balls) = self.eyeballs else {
            return;
        };
        for (ball, [pupil, rims @ ..]) in balls.iter().zip(EYES) {
            let front = ball.centre + Vec3::Z * ball.radius;
            self.points.push((pupil, front));
            let skin = &parts[self.skin];
            if let Some(seen) = opening(surface, skin, &parts[ball.part], ball, step) {
                self.rims(rims, &seen);
            }
        }
    }

    /// Openings of the lids without eyeballs.
    fn openings(&mut self, seen: &[Socket; 2]) {
        for (seen, [pupil, rims @ ..]) in seen.iter().zip(EYES) {
            self.points.push((pupil, seen.pupil));
            self.rims(rims, &seen.opening);
        }
    }

    fn rims(&mut self, [top, bottom, left, right]: [PointId; 4], seen: &EyeOpening) {
        self.points.extend([
            (top, seen.top),
            (bottom, seen.bottom),
            (left, seen.left),
            (right, seen.right),
        ]);
    }

    /// Rims of the lids, by where blinking moves the upper ones most, and where they stop.
    fn lids(&mut self, surface: &FaceSurface) {
        let sides = [
            ("eyeBlinkLeft", (3, 1), (3, 3)),
            ("eyeBlinkRight", (3, 2), (3, 4)),
        ];
        for (shape, upper, lower) in sides {
            let offsets = surface.shapes.iter().find(|(name, _)| *name == shape);
            let Some((_, offsets)) = offsets else {
                continue;
            };
            let most = offsets.iter().map(|d| -d.y).fold(0.0, f32::max);
            let of_rim = |v: &usize| -offsets[*v].y > 0.9 * most;
            let rim: Vec<usize> = (0..offsets.len()).filter(of_rim).collect();
            if most <= 0.0 {
                continue;
            }
            let rim = rim.iter().map(|v| (surface.positions[*v], offsets[*v]));
            let rim = rim.fold((Vec3::ZERO, Vec3::ZERO, 0.0), |sum, (at, offset)| {
                (sum.0 + at, sum.1 + offset, sum.2 + 1.0)
            });
            let (rim, drop) = (rim.0 / rim.2, rim.1 / rim.2);
            self.shown.push((upper, rim));
            // The lower rim is the highest place below that stays, at the depth of the closed lid.
            let closed = rim + drop;
            let stays = |v: &usize| {
                let at = surface.positions[*v];
                offsets[*v].length() < 0.3 * most
                    && (0.2..1.5).contains(&((rim.y - at.y) / most))
                    && (at.x - rim.x).abs() < 0.3 * most
                    && (at.z - closed.z).abs() < 0.5 * most
            };
            let below = (0..offsets.len()).filter(stays);
            let places = below.map(|v| surface.positions[v]);
            if let Some(highest) = places.max_by(|a, b| a.y.total_cmp(&b.y)) {
                self.shown.push((lower, highest));
            }
        }
    }

    fn mouth(&mut self, surface: &FaceSurface, skin: &SurfacePart, skull: f32) {
        let nose = self.points[0].1;
        let step = skull / STEPS;
        let heights = nose.y - BELOW * skull..nose.y + 0.3 * skull;
        let cut = |x: f32| Profile::cut(surface, skin, x, heights.clone(), step);
        let Some(profile) = cut(self.middle_x) else {
            return;
        };
        let near = profile.index(nose.y - 0.1 * skull)..profile.index(nose.y + 0.1 * skull);
        let Some(tip) = profile.most(near, |i| profile.z[i]) else {
            return;
        };
        self.points[0].1 = profile.place(tip);
        let tried = PROMINENCES
            .iter()
            .flat_map(|p| TILTS.iter().map(move |t| (*p, *t)));
        let mut turns =
            tried.filter_map(|(p, tilt)| profile.extrema_below(tip, 6, p * skull, tilt));
        let Some(turns) = turns.next() else {
            return;
        };
        let [hollow, upper, seam, lower, below, chin] = turns[..] else {
            return;
        };
        let chord = profile.place(upper) - profile.place(tip);
        let behind = |i: usize| {
            let to = profile.place(i) - profile.place(tip);
            // Distance below the chord, in the plane of the profile.
            chord.y * to.z - chord.z * to.y
        };
        let base = profile.most(upper..tip, behind).unwrap_or(hollow);
        let reach = (0.02 * STEPS) as usize;
        let bulge = |i: usize| -profile.bend(i, reach);
        let upper_rim = profile.most(upper + 1..hollow, bulge).unwrap_or(upper);
        let lower_rim = profile.most(below + 1..lower, bulge).unwrap_or(lower);
        let lips = profile.z[upper].min(profile.z[lower]);
        let (above_seam, below_seam) = if lips - profile.z[seam] > OPEN * skull {
            let inside = lips - 0.5 * OPEN * skull;
            let top = (seam..upper).find(|i| profile.z[*i] > inside);
            let bottom = (lower..seam).rev().find(|i| profile.z[*i] > inside);
            (top.unwrap_or(seam), bottom.unwrap_or(seam))
        } else {
            (seam, seam)
        };
        let start = chin.saturating_sub((0.35 * STEPS) as usize);
        let under = profile.most(start..chin + 1, |i| profile.z[i] - profile.height(i));
        for (point, index) in [
            ((9, 15), base),
            ((8, 1), upper_rim),
            ((8, 2), lower_rim),
            ((2, 2), above_seam),
            ((2, 3), below_seam),
            ((2, 10), chin),
            ((2, 1), under.unwrap_or(chin)),
        ] {
            self.points.push((point, profile.place(index)));
        }
        for (point, side) in [((2, 4), 1.0), ((2, 5), -1.0)] {
            let at = |k: usize| cut(self.middle_x + side * k as f32 * step);
            let corner = corner(at, profile.place(seam), skull);
            self.points.push((point, corner));
        }
    }
}

/// Follows the line between the lips from the middle, from one cut beside it to the next, to its end.
fn corner(cut: impl Fn(usize) -> Option<Profile>, middle: Vec3, skull: f32) -> Vec3 {
    let mut corner = middle;
    let mut shallow = 0;
    let wander = WANDER * skull;
    for beside in (1..(0.6 * STEPS) as usize).map_while(cut) {
        let near = beside.index(corner.y - wander)..beside.index(corner.y + wander) + 1;
        let Some(deepest) = beside.most(near, |i| -beside.z[i]) else {
            break;
        };
        let reach = (LIP * STEPS) as usize;
        if beside.groove(deepest, reach, &TILTS) < SEAM * skull {
            // A triangle may bridge the line for a while.
            shallow += 1;
            if shallow > BRIDGED {
                break;
            }
            continue;
        }
        shallow = 0;
        corner = beside.place(deepest);
    }
    corner
}

/// Index of the part that reaches farthest to the front, of those with a share of the surface.
fn foremost(surface: &FaceSurface, parts: &[SurfacePart]) -> Option<usize> {
    let largest = parts.first()?.area;
    let large = parts.iter().take_while(|p| p.area > LARGE * largest);
    let front = |part: &SurfacePart| {
        let depths = places(surface, part).map(|p| p.z);
        depths.fold(f32::NEG_INFINITY, f32::max)
    };
    let fronts = large.map(front).enumerate();
    fronts
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(index, _)| index)
}

/// The parts that make up the head: the skin alone or, if it is a mask without a back, all large
/// ones.
fn head<'a>(surface: &FaceSurface, parts: &'a [SurfacePart], skin: usize) -> Vec<&'a SurfacePart> {
    let extent = |axis: usize, part: &SurfacePart| {
        let along = places(surface, part).map(|p| p[axis]);
        let (low, high) = along.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), x| {
            (low.min(x), high.max(x))
        });
        high - low
    };
    if extent(2, &parts[skin]) > MASK * extent(1, &parts[skin]) {
        return vec![&parts[skin]];
    }
    let large = |p: &&SurfacePart| p.area > LARGE * parts[0].area;
    parts.iter().filter(large).collect()
}

/// The outermost places at both sides in two ranges of height: of the skull, and of the ears.
fn widths<I: Iterator<Item = Vec3>>(
    of_head: impl Fn() -> I,
    middle_x: f32,
    nose_y: f32,
    skull: f32,
) -> Vec<(usize, Vec3)> {
    let mut found = Vec::new();
    for (range, heights) in [0.5..0.8, -0.2..0.4].into_iter().enumerate() {
        for (index, side) in [1.0, -1.0].into_iter().enumerate() {
            let inside = of_head().filter(|p| heights.contains(&((p.y - nose_y) / skull)));
            let out = |p: &Vec3| side * (p.x - middle_x);
            let outermost = inside.max_by(|a, b| out(a).total_cmp(&out(b)));
            found.extend(outermost.map(|at| (2 * range + index, at)));
        }
    }
    found
}

fn places(surface: &FaceSurface, part: &SurfacePart) -> impl Iterator<Item = Vec3> {
    part.vertices.iter().map(|v| surface.positions[*v as usize])
}

/// Sideways place of the plane of symmetry: the median of the middles at several heights.
fn middle(surface: &FaceSurface, part: &SurfacePart) -> Option<f32> {
    const SLICES: usize = 64;
    let places = || places(surface, part);
    let low = places().map(|p| p.y).fold(f32::INFINITY, f32::min);
    let high = places().map(|p| p.y).fold(f32::NEG_INFINITY, f32::max);
    if high <= low {
        return None;
    }
    let mut slices = [(f32::INFINITY, f32::NEG_INFINITY); SLICES];
    for p in places() {
        let slice = ((p.y - low) / (high - low) * SLICES as f32) as usize;
        let (least, most) = &mut slices[slice.min(SLICES - 1)];
        *least = least.min(p.x);
        *most = most.max(p.x);
    }
    let filled = slices.iter().filter(|(least, most)| least <= most);
    let mut middles: Vec<f32> = filled.map(|(least, most)| 0.5 * (least + most)).collect();
    middles.sort_by(f32::total_cmp);
    middles.get(middles.len() / 2).copied()
}

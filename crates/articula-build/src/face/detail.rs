//! Error of a face clip under levels of articulation, and the coarsest choice within a tolerance.
//!
//! The error is measured on the face at hand: the weights that show the parameters that are left,
//! against those that show all of them, at every frame and every vertex, as a distance in 3D.

use super::bridge::{FaceBridge, FaceSolver};
use super::fap_values::FapValues;
use super::fields::FaceFields;
use articula_core::arkit_table::twin_lip;
use articula_core::face_levels::{FaceLevel, FaceLevels, FaceRegion, FapRole, FapRoles};
use articula_core::fap_table::{FAP_COUNT, LOW_FAP_COUNT, LOW_FAPS};
use glam::Vec3;
use std::cell::Cell;
use std::ops::RangeInclusive;

/// Index of FAP 3.
const FIRST: usize = *LOW_FAPS.start();
/// The jaw and the height of the lips beside it: what opens the mouth.
const MOUTH: [usize; 7] = [3, 4, 5, 8, 9, 10, 11];
/// The upper eyelids, of which one is kept longer, the right one if it moves.
const EYELIDS: [usize; 2] = [20, 19];
/// The parameters that the body animation has too, which no choice removes.
const HEAD: RangeInclusive<usize> = 48..=50;
/// Share of the tolerance for the mouth and one blink.
const CONSPICUOUS: f32 = 0.5;

/// The frames of a face clip.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FaceFrames {
    /// Low-level parameters of each frame.
    pub low: Vec<FapValues>,
    /// What viseme and expression of each frame add to them.
    pub high: Vec<FapValues>,
}

const INNER_LIPS: RangeInclusive<usize> = 4..=13;
const OUTER_LIPS: RangeInclusive<usize> = 51..=60;

impl FaceFrames {
    /// Returns the values of a frame, those of viseme and expression included.
    pub fn values(&self, frame: usize) -> FapValues {
        self.low[frame].plus(&self.high[frame], 1.0)
    }

    /// Returns which low-level parameters other than the neutral face a frame has.
    pub fn moving(&self) -> [bool; LOW_FAP_COUNT] {
        std::array::from_fn(|index| self.low.iter().any(|frame| frame.0[index] != 0.0))
    }

    /// Returns which parameters (FAP 3 at index 0) count when the frames are shown: all but those of
    /// a contour of the lips of which none moves while the other one does; it follows that one.
    pub fn counted(&self) -> [bool; LOW_FAP_COUNT] {
        counted(&self.shown_moving())
    }

    /// Which parameters move, those of visemes and expressions included.
    fn shown_moving(&self) -> [bool; LOW_FAP_COUNT] {
        let frames: Vec<FapValues> = (0..self.low.len()).map(|f| self.values(f)).collect();
        std::array::from_fn(|index| frames.iter().any(|frame| frame.0[index] != 0.0))
    }
}

/// See [`FaceFrames::counted`].
fn counted(moving: &[bool; LOW_FAP_COUNT]) -> [bool; LOW_FAP_COUNT] {
    let moves = |mut lips: RangeInclusive<usize>| lips.any(|fap| moving[fap - FIRST]);
    let [inner, outer] = [moves(INNER_LIPS), moves(OUTER_LIPS)];
    std::array::from_fn(|index| {
        let fap = FIRST + index;
        let follows = OUTER_LIPS.contains(&fap) && inner && !outer
            || INNER_LIPS.contains(&fap) && outer && !inner;
        !follows
    })
}

/// Measures a face clip under levels of articulation.
#[derive(Debug, Clone)]
pub struct FaceDetail<'a> {
    bridge: &'a FaceBridge,
    fields: &'a FaceFields,
    frames: &'a FaceFrames,
    moving: [bool; LOW_FAP_COUNT],
    /// The parameters that count where all are shown.
    counted: [bool; LOW_FAP_COUNT],
    /// Values and weights of each frame with all parameters.
    shown: Vec<(FapValues, Vec<f32>)>,
    /// The frame in which a choice exceeded its limit last, measured first the next time.
    worst: Cell<usize>,
}

impl<'a> FaceDetail<'a> {
    /// Solves all frames with all parameters.
    ///
    /// # Panics
    /// If the fields have another number of controls than the bridge, or the frames of
    /// [`FaceFrames::low`] and [`FaceFrames::high`] differ in number.
    pub fn new(bridge: &'a FaceBridge, fields: &'a FaceFields, frames: &'a FaceFrames) -> Self {
        assert_eq!(frames.low.len(), frames.high.len(), "the same frames");
        let counted = frames.counted();
        let mut solver = bridge.solver(counted);
        let solved = |frame: usize| {
            let values = frames.values(frame);
            let weights = solver.solve(&values).weights;
            (values, weights)
        };
        Self {
            bridge,
            fields,
            frames,
            moving: frames.moving(),
            counted,
            shown: (0..frames.low.len()).map(solved).collect(),
            worst: Cell::new(0),
        }
    }

    /// Returns the number of low-level parameters with values of their own that matter in the clip:
    /// those that move, and those of the lips that rest while their twin on the other contour moves.
    pub fn kept(&self, roles: &FapRoles) -> usize {
        let matter = LOW_FAPS.filter(|fap| self.matters(*fap));
        matter.filter(|fap| roles.keeps(*fap)).count()
    }

    fn matters(&self, fap: usize) -> bool {
        let moves = |fap: usize| self.moving[fap - FIRST];
        let rests = self.counted[fap - FIRST] && twin_lip(fap).is_some_and(moves);
        moves(fap) || rests
    }

    /// Returns the greatest distance of a vertex from its place with all parameters, over all
    /// frames, in metres.
    pub fn error_m(&self, roles: &FapRoles) -> f32 {
        let mut error = 0.0_f32;
        self.measure(roles, |_, distance| {
            error = error.max(distance);
            true
        });
        error
    }

    /// Whether the error of roles is within a limit in metres. Ends at the first frame beyond it.
    fn is_within(&self, roles: &FapRoles, limit_m: f32) -> bool {
        let mut is_within = true;
        self.measure(roles, |frame, distance| {
            is_within = distance <= limit_m;
            if !is_within {
                self.worst.set(frame);
            }
            is_within
        });
        is_within
    }

    /// The parameters that count under roles: a lip that is removed follows its twin on the other
    /// contour, if that is not.
    fn counted_under(&self, roles: &FapRoles) -> [bool; LOW_FAP_COUNT] {
        let is_removed = |fap: usize| roles.role(fap) == FapRole::Removed;
        std::array::from_fn(|index| {
            let fap = FIRST + index;
            let follows = |twin: usize| is_removed(fap) && !is_removed(twin);
            self.counted[index] && !twin_lip(fap).is_some_and(follows)
        })
    }

    /// Tells the greatest distance in each frame, until `tell` returns false.
    fn measure(&self, roles: &FapRoles, mut tell: impl FnMut(usize, f32) -> bool) {
        let counts = self.counted_under(roles);
        let mut solver: FaceSolver = self.bridge.solver(counts);
        let mut moved: Vec<Vec3> = Vec::new();
        let first = self.worst.get();
        let others = (0..self.shown.len()).filter(|frame| *frame != first);
        for frame in std::iter::once(first).chain(others) {
            let Some((values, weights)) = self.shown.get(frame) else {
                continue;
            };
            let mut low = self.frames.low[frame];
            roles.expand(&mut low.0);
            let reduced = low.plus(&self.frames.high[frame], 1.0);
            let distance = if reduced == *values && counts == self.counted {
                0.0
            } else {
                let shown = solver.solve(&reduced).weights;
                let (from, to) = ((&**weights, values), (&*shown, &reduced));
                self.fields.distance(from, to, &mut moved)
            };
            if !tell(frame, distance) {
                return;
            }
        }
    }

    /// Returns the lever of each low-level parameter (FAP 3 at index 0): the greatest displacement
    /// of a vertex per unit, in metres, when the parameter alone has its greatest value of the clip;
    /// 0 for those that do not move. Parameters of the lips have it on both contours.
    pub fn levers(&self) -> [f32; LOW_FAP_COUNT] {
        let mut solver = self.bridge.solver([true; LOW_FAP_COUNT]);
        let (still, neutral) = (vec![0.0; self.bridge.controls()], FapValues::default());
        let mut moved = Vec::new();
        std::array::from_fn(|index| {
            let largest = self.largest(index, None);
            if largest == 0.0 {
                return 0.0;
            }
            let mut values = FapValues::default();
            values.0[index] = largest;
            if let Some(twin) = twin_lip(FIRST + index) {
                values.0[twin - FIRST] = largest;
            }
            let weights = solver.solve(&values).weights;
            let alone = (&*weights, &values);
            let distance = self.fields.distance((&still, &neutral), alone, &mut moved);
            distance / largest.abs()
        })
    }

    /// The value of greatest magnitude of a parameter, by its index, or of its difference to
    /// another one.
    fn largest(&self, index: usize, other: Option<usize>) -> f32 {
        let value = |frame: &FapValues| frame.0[index] - other.map_or(0.0, |o| frame.0[o]);
        let values = self.frames.low.iter().map(value);
        values.fold(
            0.0,
            |most: f32, v| if v.abs() > most.abs() { v } else { most },
        )
    }

    /// Returns the coarsest level of each region, no finer than in `from`, with which the error
    /// stays within a limit in metres.
    ///
    /// All regions are tried at medium, then at low, then at very low, in their order, each with
    /// the levels that the others have by then.
    pub fn levels_within(&self, from: FaceLevels, limit_m: f32) -> FaceLevels {
        let mut levels = from;
        for level in [FaceLevel::Medium, FaceLevel::Low, FaceLevel::VeryLow] {
            for region in FaceRegion::ALL {
                let coarser = levels.with(region, level);
                let is_coarser = level > levels.level(region);
                if is_coarser && self.is_within(&coarser.roles(), limit_m) {
                    levels = coarser;
                }
            }
        }
        levels
    }

    /// Returns the roles of the moving parameters that must be kept for an error within a limit in
    /// metres, of those that `from` keeps.
    ///
    /// Parameters are tried in the order of their lever times their greatest value, the smallest
    /// first, and removed where the error of all that are removed stays within the limit. Those that
    /// open the mouth and close one eye are removed where the error of these alone stays within half
    /// of it too. A parameter of the lips whose twin on the other contour is kept follows that one.
    /// The head's rotation is kept.
    pub fn faps_within(&self, from: &FapRoles, limit_m: f32) -> FapRoles {
        let levers = self.levers();
        let moves = |fap: &usize| self.matters(*fap);
        let mut sized: Vec<(f32, usize)> = LOW_FAPS
            .filter(|fap| moves(fap) && from.keeps(*fap) && !HEAD.contains(fap))
            .map(|fap| {
                let index = fap - FIRST;
                // An outer lip that is not kept follows the inner one.
                let twin = twin_lip(fap).filter(|twin| *twin < fap && moves(twin));
                let largest = self.largest(index, twin.map(|twin| twin - FIRST));
                (levers[index] * largest.abs(), fap)
            })
            .collect();
        sized.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
        let blink = EYELIDS.into_iter().find(moves);
        let is_conspicuous = |fap: usize| MOUTH.contains(&fap) || blink == Some(fap);

        let mut kept = [true; FAP_COUNT];
        let mut conspicuous = [true; FAP_COUNT];
        for fap in LOW_FAPS.filter(|fap| !from.keeps(*fap) || !moves(fap)) {
            kept[fap - 1] = false;
            conspicuous[fap - 1] = !(is_conspicuous(fap) && moves(&fap));
        }
        for (_, fap) in sized {
            let without = |faps: &[bool; FAP_COUNT]| {
                let mut faps = *faps;
                faps[fap - 1] = false;
                faps
            };
            let fewer = without(&kept);
            let half = CONSPICUOUS * limit_m;
            let is_seen = is_conspicuous(fap)
                && !self.is_within(&FapRoles::keeping(&without(&conspicuous)), half);
            if is_seen || !self.is_within(&FapRoles::keeping(&fewer), limit_m) {
                continue;
            }
            kept = fewer;
            if is_conspicuous(fap) {
                conspicuous = without(&conspicuous);
            }
        }
        FapRoles::keeping(&kept)
    }
}

#[cfg(test)]
mod tests {
    use super::super::controls::blend_shape;
    use super::*;

    /// A face of one vertex per shape, which moves by 1 cm at full weight.
    fn face(names: &[&str]) -> (FaceBridge, FaceFields) {
        let columns = names.iter().map(|name| blend_shape(name).unwrap());
        let field = |shape: usize| {
            let offset = |vertex| if vertex == shape { 0.01 } else { 0.0 };
            (0..names.len()).map(|v| offset(v) * Vec3::Y).collect()
        };
        let fields: Vec<Vec<Vec3>> = (0..names.len()).map(field).collect();
        (FaceBridge::new(columns.collect()), FaceFields::new(&fields))
    }

    fn frames(values: &[&[(usize, f32)]]) -> FaceFrames {
        let frame = |list: &&[(usize, f32)]| {
            let mut frame = FapValues::default();
            for (fap, value) in *list {
                frame.0[fap - FIRST] = *value;
            }
            frame
        };
        FaceFrames {
            low: values.iter().map(frame).collect(),
            high: vec![FapValues::default(); values.len()],
        }
    }

    fn roles(level: FaceLevel) -> FapRoles {
        FaceLevels::all(level).roles()
    }

    const BROWS: [&str; 2] = ["browOuterUpLeft", "browOuterUpRight"];

    #[test]
    fn errors_of_levels_by_hand() {
        let (bridge, fields) = face(&BROWS);
        // The left brow rises by half of its shape (FAP 33 and 35), the right one stays.
        let frames = frames(&[&[], &[(33, 90.0), (35, 175.0)], &[(33, 18.0), (35, 35.0)]]);
        let detail = FaceDetail::new(&bridge, &fields, &frames);
        assert_eq!(detail.error_m(&roles(FaceLevel::High)), 0.0);
        // FAP 33 copies 35, of which the shape has twice as much: a little more of the shape.
        let medium = detail.error_m(&roles(FaceLevel::Medium));
        assert!(medium > 0.0005 && medium < 0.003, "{medium}");
        // The left brow copies the right one: all of the motion, half of 1 cm, is lost.
        let low = detail.error_m(&roles(FaceLevel::Low));
        assert!((low - 0.005).abs() < 3e-4, "{low}");
        assert!((detail.error_m(&roles(FaceLevel::VeryLow)) - low).abs() < 1e-7);
        assert_eq!(detail.kept(&roles(FaceLevel::High)), 2);
        assert_eq!(detail.kept(&roles(FaceLevel::Medium)), 1);
        // Levers: all of the shape per its value, for either parameter alone a part of it.
        let levers = detail.levers();
        assert!(levers[33 - FIRST] > 0.0 && levers[35 - FIRST] > levers[33 - FIRST]);
        assert_eq!(levers[36 - FIRST], 0.0);
    }

    #[test]
    fn regions_get_the_coarsest_level_within_the_limit() {
        let (bridge, fields) = face(&[
            "browOuterUpLeft",
            "browOuterUpRight",
            "jawOpen",
            "cheekPuff",
        ]);
        let puff = [(39, 80.0), (40, 80.0)];
        let still = frames(&[&puff]);
        let detail = FaceDetail::new(&bridge, &fields, &still);
        let from = FaceLevels::all(FaceLevel::High);
        let tight = detail.levels_within(from, 1e-4);
        // Both cheeks are alike, so one leads; nothing else moves.
        let puffed =
            FaceLevels::all(FaceLevel::VeryLow).with(FaceRegion::Cheeks, FaceLevel::Medium);
        assert_eq!(tight, puffed);
        // A puff of 0.2 moves the face by 2 mm.
        let loose = detail.levels_within(tight, 0.0025);
        assert_eq!(loose, FaceLevels::all(FaceLevel::VeryLow));
        assert!(detail.is_within(&loose.roles(), 0.0025));
    }

    #[test]
    fn parameters_fall_out_while_the_error_stays_within_the_limit() {
        let names = [
            "jawOpen",
            "eyeBlinkRight",
            "cheekPuff",
            "browOuterUpLeft",
            "browOuterUpRight",
        ];
        let (bridge, fields) = face(&names);
        // Jaw 1 mm, blink 1 mm, puff 2 mm, brows 5 mm and 0.5 mm.
        let frames = frames(&[
            &[
                (3, 100.0),
                (5, -85.0),
                (10, -70.0),
                (11, -70.0),
                (52, -85.0),
                (57, -70.0),
                (58, -70.0),
            ],
            &[(20, 95.0), (22, 7.0), (39, 80.0), (40, 80.0)],
            &[(33, 90.0), (35, 175.0), (34, 9.0), (36, 17.5)],
        ]);
        let detail = FaceDetail::new(&bridge, &fields, &frames);
        let all = FapRoles::keeping(&[true; FAP_COUNT]);
        let mut last = all;
        let mut keeps = Vec::new();
        for limit in [1e-4, 0.001, 0.0015, 0.0025, 0.01] {
            let roles = detail.faps_within(&last, limit);
            assert!(detail.error_m(&roles) <= limit, "{limit}");
            assert!(detail.kept(&roles) <= detail.kept(&last));
            keeps.push([3, 20, 39, 35, 36].map(|fap| roles.keeps(fap)));
            last = roles;
        }
        // FAP 3 falls out first, as the lips open the jaw alone; then the other brow, the puff, and
        // last what the face moves most. Jaw and blink of 1 mm stay to a limit of 2 mm.
        assert_eq!(keeps[0][1..], [true; 4]);
        assert_eq!(keeps[1][1..], [true, true, true, false]);
        assert!(keeps[2][1] && keeps[2][3] && !keeps[2][4]);
        assert_eq!(keeps[3][1..], [false, false, true, false]);
        assert_eq!(keeps[4], [false; 5]);
    }

    #[test]
    fn a_lip_that_is_removed_follows_its_twin() {
        let (bridge, fields) = face(&["mouthSmileLeft"]);
        let smile = [
            (6, 250.0),
            (12, 250.0),
            (53, 250.0),
            (59, 250.0),
            (41, 150.0),
        ];
        let frames = frames(&[&smile]);
        let detail = FaceDetail::new(&bridge, &fields, &frames);
        let mut kept = [true; FAP_COUNT];
        for outer in OUTER_LIPS {
            kept[outer - 1] = false;
        }
        assert!(detail.error_m(&FapRoles::keeping(&kept)) < 1e-4);
        let few = detail.faps_within(&FapRoles::keeping(&[true; FAP_COUNT]), 1e-3);
        assert!(detail.kept(&few) < 5 && detail.error_m(&few) <= 1e-3);
        for inner in INNER_LIPS {
            kept[inner - 1] = false;
        }
        // Half of the smile is in the cheek.
        assert!(detail.error_m(&FapRoles::keeping(&kept)) > 0.005);
    }

    #[test]
    fn lips_that_do_not_move_follow() {
        let with = |moved: usize| {
            let counted = frames(&[&[(moved, 10.0)]]).counted();
            (counted[5 - 3], counted[52 - 3], counted[3 - 3])
        };
        assert_eq!(with(5), (true, false, true));
        assert_eq!(with(52), (false, true, true));
        assert_eq!(with(19), (true, true, true));
        let both = frames(&[&[(5, 10.0), (52, 10.0)]]).counted();
        assert!(both.iter().all(|c| *c));
    }

    #[test]
    fn a_clip_without_frames_has_no_error() {
        let (bridge, fields) = face(&BROWS);
        let frames = FaceFrames::default();
        let detail = FaceDetail::new(&bridge, &fields, &frames);
        assert_eq!(detail.error_m(&roles(FaceLevel::VeryLow)), 0.0);
        assert_eq!(
            detail.kept(&detail.faps_within(&roles(FaceLevel::High), 1.0)),
            0
        );
    }
}

//! Drift control: a joint is held while the error that it shows stays within the tolerance.
//!
//! Source: `docs/methods/motion-lod.md` parts 4.2 to 4.5. It works on any pose (clips, blends,
//! inverse kinematics), because it only compares the shown transform with the wanted one; a bound
//! on the speed at which a joint moves its skin limits how long the joint may be left untested.
//!
//! A joint that must be corrected before the dwell time is over shows the wanted transform and
//! stays passive, so that it neither chatters nor exceeds its bound; a transition that would exceed
//! the bound is cut short. The passive policy of the options is ignored: joints always hold the
//! last transform, since a fade to rest would exceed the bound unnoticed.

use crate::attention::tolerance_metres;
use crate::joint_set::JointSet;
use crate::joint_state::{JointState, JointStates, PassivePolicy, TransitionOptions};
use crate::math::angle_between;
use crate::pose::{LocalPose, ModelPose};
use crate::second_moment::SecondMoment;
use glam::{Mat3A, Vec3, Vec3A};

/// Tolerance and timing of a [`DriftController`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriftOptions {
    /// Tolerated displacement in pixels.
    pub epsilon_px: f32,
    /// Hysteresis `h`: a joint is corrected above `epsilon (1 + h)` and may become passive below
    /// `epsilon (1 - h)`.
    pub hysteresis: f32,
    /// Minimum time in seconds between two changes of a joint between active and passive.
    pub dwell_secs: f32,
    /// Largest jump, in pixels, that is shown at once; larger ones are shown in a transition.
    pub pop_px: f32,
    /// Transitions between active and passive; the policy is ignored.
    pub transition: TransitionOptions,
}

impl Default for DriftOptions {
    /// One pixel, hysteresis 0.25, 100 ms, transitions of 200 ms.
    fn default() -> Self {
        Self {
            epsilon_px: 1.0,
            hysteresis: 0.25,
            dwell_secs: 0.1,
            pop_px: 1.0,
            transition: TransitionOptions::default(),
        }
    }
}

impl DriftOptions {
    /// Returns the maximum error in pixels: `epsilon (1 + h)`.
    pub fn bound_px(&self) -> f32 {
        self.epsilon_px * (1.0 + self.hysteresis)
    }
}

/// Lever arm, speed bound and tolerance share of one joint; constant while a clip plays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointErrorBounds {
    /// Skin displacement in metres per radian of error.
    pub lever_metres: f32,
    /// Upper bound on the speed, in m/s, at which the joint's own motion moves its skin.
    pub speed_metres_per_sec: f32,
    /// Share of the tolerance that this joint may use, 0 to 1: less than 1 where errors add up
    /// along a chain.
    pub share: f32,
}

/// Pixels per metre and tolerance factor of each joint in the current frame.
#[derive(Debug, Clone, Copy)]
pub struct JointViewScales<'a> {
    /// Pixels per metre at the depth of each joint; the maximum over all cameras.
    pub pixels_per_metre: &'a [f32],
    /// Tolerance factor of each joint (below 1 during contacts, above 1 without attention).
    pub attention: &'a [f32],
}

#[derive(Debug, Clone, Copy)]
struct Judged {
    due_secs: f64,
    tolerance_metres: f32,
    changed_secs: f64,
    last_sample_secs: f64,
}

/// Chooses the joints of one character to sample each frame, and holds the others for as long as
/// their error stays within the tolerance.
#[derive(Debug, Clone)]
pub struct DriftController {
    opts: DriftOptions,
    bounds: Vec<JointErrorBounds>,
    states: JointStates,
    judged: Vec<Judged>,
    last: LocalPose,
    updates: u64,
    updated: JointSet,
    seen: Option<SeenParts>,
}

/// What the view-dependent error needs of each joint.
#[derive(Debug, Clone)]
struct SeenParts {
    moments: Vec<SecondMoment>,
    /// Model-from-joint matrix of each joint as last shown.
    joints: Vec<Mat3A>,
    /// Unit directions from the figure to each view, in model space; without any, errors count
    /// whole.
    views: [Vec3; MAX_VIEWS],
    count: usize,
}

/// Maximum number of view directions that are told apart; with more views errors count whole.
pub(crate) const MAX_VIEWS: usize = 8;

impl DriftController {
    /// Creates a controller with every joint active and due.
    ///
    /// # Panics
    /// Unless `bounds` has one entry for each joint of the pose.
    pub fn new(rest: &LocalPose, bounds: Vec<JointErrorBounds>, opts: DriftOptions) -> Self {
        assert_eq!(
            bounds.len(),
            rest.rotations.len(),
            "expected one entry for each joint"
        );
        let start = Judged {
            due_secs: f64::NEG_INFINITY,
            tolerance_metres: f32::INFINITY,
            changed_secs: f64::NEG_INFINITY,
            last_sample_secs: f64::NEG_INFINITY,
        };
        let hold_last = TransitionOptions {
            policy: PassivePolicy::HoldLast,
            ..opts.transition
        };
        Self {
            opts,
            judged: vec![start; bounds.len()],
            bounds,
            states: JointStates::new(rest, hold_last),
            last: rest.clone(),
            updates: 0,
            updated: JointSet::EMPTY,
            seen: None,
        }
    }

    /// Makes the error view-dependent: the part of a displacement along the line of sight does not
    /// count. `moments` has the second moment of the skin of each joint. Allocates.
    ///
    /// # Panics
    /// Unless there is one entry for each joint.
    #[must_use]
    pub fn with_second_moments(mut self, moments: Vec<SecondMoment>) -> Self {
        assert_eq!(
            moments.len(),
            self.bounds.len(),
            "expected one entry for each joint"
        );
        self.seen = Some(SeenParts {
            joints: vec![Mat3A::IDENTITY; moments.len()],
            moments,
            views: [Vec3::ZERO; MAX_VIEWS],
            count: 0,
        });
        self
    }

    /// Sets the unit directions from the figure to each view, in model space, and the pose in which
    /// joints are seen. Has no effect without second moments.
    ///
    /// # Panics
    /// If the pose belongs to another rig.
    pub fn set_view_directions(&mut self, directions: &[Vec3], model: &ModelPose) {
        let Some(seen) = &mut self.seen else { return };
        assert_eq!(
            model.matrices.len(),
            seen.joints.len(),
            "the pose must belong to this rig"
        );
        seen.count = if directions.len() > MAX_VIEWS {
            0
        } else {
            directions.len()
        };
        for (view, direction) in seen.views.iter_mut().zip(directions) {
            *view = *direction;
        }
        for (joint, matrix) in seen.joints.iter_mut().zip(&model.matrices) {
            *joint = matrix.matrix3;
        }
    }

    /// Returns the states of the joints and the shown pose.
    pub fn states(&self) -> &JointStates {
        &self.states
    }

    /// Returns the number of joint updates shown since the start.
    pub fn updates(&self) -> u64 {
        self.updates
    }

    /// Returns the joints whose transform was updated by the last step.
    pub fn updated(&self) -> &JointSet {
        &self.updated
    }

    /// Returns the options.
    pub fn options(&self) -> &DriftOptions {
        &self.opts
    }

    /// Makes every joint due, as needed after a cut of the camera or of the clip.
    pub fn invalidate(&mut self) {
        for judged in &mut self.judged {
            judged.due_secs = f64::NEG_INFINITY;
        }
    }

    /// Returns the joints whose wanted transform is needed now: those that are not passive, those
    /// whose wait is over, and those whose tolerance has shrunk by more than the hysteresis allows,
    /// because they have come closer or need more care.
    pub fn due(&self, now_secs: f64, views: JointViewScales<'_>) -> JointSet {
        let growth = 1.0 + self.opts.hysteresis;
        let is_due = |j: &usize| {
            let judged = &self.judged[*j];
            self.states.state(*j) != JointState::Passive
                || judged.due_secs <= now_secs
                || self.tolerance(*j, views) * growth < judged.tolerance_metres
        };
        (0..self.bounds.len()).filter(is_due).collect()
    }

    /// Tests the joints of `due` against their wanted transforms and returns the shown pose. The
    /// entries of `wanted` for other joints are not read. Does not allocate.
    pub fn step(
        &mut self,
        now_secs: f64,
        views: JointViewScales<'_>,
        due: &JointSet,
        wanted: &LocalPose,
    ) -> &LocalPose {
        let due = due.intersection(&JointSet::first(self.bounds.len()));
        self.updated = JointSet::EMPTY;
        for joint in due.iter() {
            self.judge(joint, now_secs, views, wanted);
        }
        self.states.step(now_secs, wanted);
        for joint in due.iter() {
            self.bound(joint, now_secs, views, wanted);
        }
        self.states.shown()
    }

    /// Error by the rotation and by the translation of a joint, metres.
    fn errors_metres(&self, joint: usize, wanted: &LocalPose) -> [f32; 2] {
        let shown = self.states.shown();
        let turned = angle_between(shown.rotations[joint], wanted.rotations[joint]);
        let moved = shown.translations[joint].distance(wanted.translations[joint]);
        [self.bounds[joint].lever_metres * turned, moved]
    }

    fn error_metres(&self, joint: usize, wanted: &LocalPose) -> f32 {
        let [turned, moved] = self.errors_metres(joint, wanted);
        turned + moved
    }

    /// The greatest part of the error by rotation that any view sees, 0 to 1.
    fn seen_part(&self, joint: usize, wanted: &LocalPose) -> f32 {
        let Some(seen) = self.seen.as_ref().filter(|s| s.count > 0) else {
            return 1.0;
        };
        let (shown, wanted) = (
            self.states.shown().rotations[joint],
            wanted.rotations[joint],
        );
        let into_joint = seen.joints[joint].transpose();
        let parts = seen.views[..seen.count].iter().map(|view| {
            let view = into_joint * Vec3A::from(*view);
            match Vec3::from(view).try_normalize() {
                Some(view) => seen.moments[joint].seen_fraction(shown, wanted, view),
                None => 1.0,
            }
        });
        parts.fold(0.0, f32::max)
    }

    fn tolerance(&self, joint: usize, views: JointViewScales<'_>) -> f32 {
        let attention = views.attention[joint] * self.bounds[joint].share;
        tolerance_metres(
            self.opts.epsilon_px,
            attention,
            views.pixels_per_metre[joint],
        )
    }

    fn judge(&mut self, joint: usize, now: f64, views: JointViewScales<'_>, wanted: &LocalPose) {
        let tolerance = self.tolerance(joint, views);
        let high = tolerance * (1.0 + self.opts.hysteresis);
        let settled = now - self.judged[joint].changed_secs >= f64::from(self.opts.dwell_secs);
        match self.states.state(joint) {
            JointState::Active if settled => {
                let low = tolerance * (1.0 - self.opts.hysteresis);
                if self.predicted_hold_secs(joint, now, low, wanted) >= self.opts.dwell_secs {
                    // The held transform is the one shown, so no transition is needed.
                    self.states.show(joint, wanted.get(joint), now);
                    self.judged[joint].changed_secs = now;
                }
            }
            JointState::Passive => {
                let [turned, moved] = self.errors_metres(joint, wanted);
                let mut error = turned + moved;
                if error > high {
                    error = turned * self.seen_part(joint, wanted) + moved;
                }
                if error > high {
                    let pixels = error * views.pixels_per_metre[joint];
                    if pixels > self.opts.pop_px && settled {
                        self.states.activate(joint, now);
                        self.judged[joint].changed_secs = now;
                    } else {
                        self.states.show(joint, wanted.get(joint), now);
                    }
                    self.count_update(joint);
                }
            }
            _ => {}
        }
        self.judged[joint].tolerance_metres = tolerance;
    }

    /// Time for which the joint would stay within `low` metres at its current speed.
    fn predicted_hold_secs(&self, joint: usize, now: f64, low: f32, wanted: &LocalPose) -> f32 {
        let elapsed = (now - self.judged[joint].last_sample_secs) as f32;
        if !elapsed.is_finite() || elapsed <= 0.0 {
            return 0.0;
        }
        let bounds = &self.bounds[joint];
        let turned = angle_between(self.last.rotations[joint], wanted.rotations[joint]);
        let moved = self.last.translations[joint].distance(wanted.translations[joint]);
        let metres_per_sec = (bounds.lever_metres * turned + moved) / elapsed;
        if metres_per_sec <= 0.0 {
            f32::INFINITY
        } else {
            low / metres_per_sec
        }
    }

    fn count_update(&mut self, joint: usize) {
        self.updates += 1;
        self.updated.insert(joint);
    }

    /// Keeps the shown error within the bound, counts updates, and sets the time of the next test.
    fn bound(&mut self, joint: usize, now: f64, views: JointViewScales<'_>, wanted: &LocalPose) {
        let tolerance = self.tolerance(joint, views);
        let mut error = self.error_metres(joint, wanted);
        match self.states.state(joint) {
            JointState::ToActive | JointState::ToPassive => {
                self.count_update(joint);
                if error > tolerance * (1.0 + self.opts.hysteresis) {
                    self.states.show(joint, wanted.get(joint), now);
                    error = 0.0;
                }
            }
            JointState::Active => self.count_update(joint),
            JointState::Passive => {}
        }
        let speed = self.bounds[joint].speed_metres_per_sec.max(1e-9);
        let judged = &mut self.judged[joint];
        judged.due_secs = now + f64::from((tolerance - error).max(0.0) / speed);
        judged.last_sample_secs = now;
        self.last.set(joint, wanted.get(joint));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Transform;
    use glam::{Affine3A, Quat};

    /// The unit of these tests, exact in f32: with [`VIEW`], one pixel of tolerance is 4 units; with
    /// the hysteresis of a quarter, a joint is corrected above 5 units and may rest below 3.
    const UNIT: f32 = 1.0 / 256.0;

    /// 64 pixels per metre; attention 2 and the share 0.5 cancel out.
    const VIEW: JointViewScales<'_> = JointViewScales {
        pixels_per_metre: &[64.0],
        attention: &[2.0],
    };

    /// Two units per second at most, and a lever of 1 m.
    const BOUNDS: JointErrorBounds = JointErrorBounds {
        lever_metres: 1.0,
        speed_metres_per_sec: 2.0 * UNIT,
        share: 0.5,
    };

    fn options() -> DriftOptions {
        DriftOptions {
            epsilon_px: 1.0,
            hysteresis: 0.25,
            dwell_secs: 0.125,
            pop_px: 1.5,
            transition: TransitionOptions {
                secs: 0.0,
                ..TransitionOptions::default()
            },
        }
    }

    /// A joint moved by a number of units along x.
    fn moved(units: f32) -> LocalPose {
        turned(0.0, units * UNIT)
    }

    /// A joint rotated about z, in radians, and moved along x, in metres.
    fn turned(radians: f32, metres: f32) -> LocalPose {
        LocalPose::from_iter([Transform {
            translation: Vec3::new(metres, 0.0, 0.0),
            rotation: Quat::from_rotation_z(radians),
            ..Transform::IDENTITY
        }])
    }

    /// A controller of one joint, tested at 0 s; still for 2 s, so that it holds the rest pose
    /// since 2 s.
    fn held(opts: DriftOptions) -> DriftController {
        let mut drift = DriftController::new(&moved(0.0), vec![BOUNDS], opts);
        assert_eq!(frame(&mut drift, 0.0, &moved(0.0)), JointState::Active);
        assert_eq!(frame(&mut drift, 2.0, &moved(0.0)), JointState::Passive);
        drift
    }

    /// Steps with every joint due and returns the state of the first.
    fn frame(drift: &mut DriftController, secs: f64, wanted: &LocalPose) -> JointState {
        let shown = drift.step(secs, VIEW, &JointSet::first(1), wanted).clone();
        assert_eq!(shown, *drift.states().shown());
        assert_eq!(shown.rotations.len(), 1);
        drift.states().state(0)
    }

    fn shown_units(drift: &DriftController) -> f32 {
        drift.states().shown().translations[0].x / UNIT
    }

    #[test]
    fn the_bound_is_the_tolerance_with_its_hysteresis() {
        let opts = DriftOptions {
            epsilon_px: 2.0,
            ..options()
        };
        // 2 (1 + 0.25)
        assert_eq!(opts.bound_px(), 2.5);
        assert_eq!(*held(opts).options(), opts);
    }

    #[test]
    fn a_joint_rests_if_it_would_stay_near_for_the_dwell_time() {
        // At 24 units per second, 3 units last 0.125 s, the dwell time.
        for (units, state) in [
            (48.0, JointState::Passive),
            (48.5, JointState::Active),
            (-48.0, JointState::Passive),
        ] {
            let mut drift = DriftController::new(&moved(0.0), vec![BOUNDS], options());
            frame(&mut drift, 0.0, &moved(0.0));
            assert_eq!(frame(&mut drift, 2.0, &moved(units)), state, "{units}");
            assert_eq!(shown_units(&drift), units);
        }
    }

    #[test]
    fn the_time_of_a_hold_follows_from_rotation_and_translation() {
        let bounds = JointErrorBounds {
            lever_metres: 0.1,
            ..BOUNDS
        };
        let mut drift = DriftController::new(&moved(0.0), vec![bounds], options());
        let predicted = |drift: &DriftController, now, pose: &LocalPose| {
            drift.predicted_hold_secs(0, now, 0.02, pose)
        };
        // Never tested before.
        assert_eq!(predicted(&drift, 1.0, &moved(0.0)), 0.0);
        frame(&mut drift, 1.0, &moved(0.0));
        // (0.1 m * 0.5 + 0.03 m) in 2 s are 0.04 m/s.
        let secs = predicted(&drift, 3.0, &turned(0.5, 0.03));
        assert!((secs - 0.5).abs() < 1e-4, "{secs} s");
        assert_eq!(predicted(&drift, 3.0, &moved(0.0)), f32::INFINITY);
        // No time has passed, or it went backwards.
        assert_eq!(predicted(&drift, 1.0, &moved(0.0)), 0.0);
        assert_eq!(predicted(&drift, 0.5, &moved(0.0)), 0.0);
    }

    #[test]
    fn a_held_joint_is_shown_anew_above_the_bound_only() {
        for (units, shown, updates) in [(4.5, 0.0, 0), (5.0, 0.0, 0), (5.5, 5.5, 1)] {
            let mut drift = held(options());
            let before = drift.updates();
            // 5.5 units are 1.375 pixels, less than a pop, so that there is no transition.
            let state = frame(&mut drift, 3.0, &moved(units));
            assert_eq!(state, JointState::Passive, "{units}");
            assert_eq!(shown_units(&drift), shown);
            assert_eq!(drift.updates() - before, updates);
            assert_eq!(drift.updated().contains(0), updates > 0);
        }
    }

    #[test]
    fn an_active_joint_is_an_update_in_each_frame() {
        let mut drift = DriftController::new(&moved(0.0), vec![BOUNDS], options());
        assert_eq!((drift.updates(), drift.updated().contains(0)), (0, false));
        for i in 1..=4u8 {
            // 64 units per second: too fast to rest.
            frame(&mut drift, f64::from(i), &moved(64.0 * f32::from(i)));
            assert_eq!(drift.updates(), u64::from(i));
            assert!(drift.updated().contains(0));
        }
    }

    #[test]
    fn a_pop_changes_the_state_if_the_last_change_is_a_dwell_time_ago() {
        let opts = |pop_px| DriftOptions {
            pop_px,
            ..options()
        };
        // 6 units are 1.5 pixels. The joint rests since 2 s; the dwell time is 0.125 s.
        for (pop_px, secs, state) in [
            (1.5, 2.5, JointState::Passive),
            (1.25, 2.5, JointState::Active),
            (1.25, 2.125, JointState::Active),
            (1.25, 2.0625, JointState::Passive),
        ] {
            let mut drift = held(opts(pop_px));
            assert_eq!(
                frame(&mut drift, secs, &moved(6.0)),
                state,
                "{pop_px} {secs}"
            );
            assert_eq!(shown_units(&drift), 6.0);
        }
        // Back to rest, a dwell time after the change and not before, although it stands still.
        let mut drift = held(opts(1.25));
        for (secs, state) in [
            (2.125, JointState::Active),
            (2.1875, JointState::Active),
            (2.25, JointState::Passive),
        ] {
            assert_eq!(frame(&mut drift, secs, &moved(6.0)), state, "{secs}");
        }
    }

    #[test]
    fn a_transition_is_cut_short_above_the_bound_only() {
        let opts = DriftOptions {
            transition: TransitionOptions {
                secs: 1.0,
                ..TransitionOptions::default()
            },
            ..options()
        };
        for (units, state, shown) in [
            (4.5, JointState::ToActive, 0.0),
            (5.0, JointState::ToActive, 0.0),
            (5.5, JointState::Passive, 5.5),
        ] {
            let mut drift = held(opts);
            drift.states.activate(0, 3.0);
            let state_then = frame(&mut drift, 3.0, &moved(units));
            assert_eq!((state_then, shown_units(&drift)), (state, shown), "{units}");
        }
    }

    #[test]
    fn the_next_test_is_when_the_joint_could_have_left_the_tolerance() {
        let mut drift = held(options());
        let is_due = |drift: &DriftController, secs| drift.due(secs, VIEW).contains(0);
        // The shown transform is the wanted one: 4 units at 2 units per second, from 2 s on.
        assert!(!is_due(&drift, 3.999) && is_due(&drift, 4.0));
        // At 3 s it is 2 units away: 2 more take one second.
        frame(&mut drift, 3.0, &moved(2.0));
        assert!(!is_due(&drift, 3.999) && is_due(&drift, 4.0));
        // At 3.5 s it is 4.5 units away, more than the tolerance.
        frame(&mut drift, 3.5, &moved(4.5));
        assert!(is_due(&drift, 3.5));
    }

    #[test]
    fn all_joints_are_due_after_a_cut() {
        let mut drift = held(options());
        assert!(!drift.due(2.5, VIEW).contains(0));
        drift.invalidate();
        assert!(drift.due(2.5, VIEW).contains(0));
    }

    #[test]
    fn a_joint_is_due_if_its_tolerance_shrinks_beyond_the_hysteresis() {
        let opts = DriftOptions {
            hysteresis: 1.0,
            ..options()
        };
        let drift = held(opts);
        for (pixels_per_metre, is_due) in [
            (32.0, false),
            (64.0, false),
            (100.0, false),
            (128.0, false),
            (129.0, true),
        ] {
            let views = JointViewScales {
                pixels_per_metre: &[pixels_per_metre],
                ..VIEW
            };
            assert_eq!(
                drift.due(2.5, views).contains(0),
                is_due,
                "{pixels_per_metre}"
            );
        }
        // An active joint is always due.
        let mut drift = DriftController::new(&moved(0.0), vec![BOUNDS], opts);
        frame(&mut drift, 0.0, &moved(0.0));
        assert!(drift.due(0.0, VIEW).contains(0));
    }

    /// A joint whose skin lies along x is moved along y by a rotation about z; from directions at
    /// 53 degrees to y, sine 0.8 of the angle to x and z, 0.6 of that is seen.
    #[test]
    fn of_a_rotation_the_part_seen_counts_and_of_a_translation_all() {
        let oblique = Vec3::new(0.0, 0.8, 0.6);
        // In the joint's frame; the joint is rotated by a quarter about x.
        let matrix = Affine3A::from_rotation_x(std::f32::consts::FRAC_PI_2);
        let oblique_in_model = matrix.transform_vector3(oblique);
        // 0.1 rad at a lever of 1 m, of which 0.06 m are seen, and 0.02 m: 0.08 m of 0.12 m.
        let wanted = turned(0.1, 0.02);
        let shows = |bound_metres: f32, views: &[Vec3]| {
            let opts = DriftOptions {
                epsilon_px: bound_metres / 1.25 * 64.0,
                pop_px: f32::INFINITY,
                ..options()
            };
            let moment = SecondMoment::of([(Vec3::X, 1.0), (-Vec3::X, 1.0)]);
            let mut drift = held(opts).with_second_moments(vec![moment]);
            if !views.is_empty() {
                let model = ModelPose {
                    matrices: vec![matrix],
                };
                drift.set_view_directions(views, &model);
            }
            frame(&mut drift, 3.0, &wanted);
            drift.states().shown() == &wanted
        };
        assert!(!shows(0.09, &[oblique_in_model]));
        assert!(shows(0.07, &[oblique_in_model]));
        // The view that sees most counts.
        let along_z = matrix.transform_vector3(Vec3::Z);
        assert!(shows(0.09, &[oblique_in_model, along_z]));
        // Without views, or with more than are told apart, the error counts whole.
        assert!(shows(0.09, &[]));
        assert!(!shows(0.13, &[]));
        assert!(!shows(0.09, &[oblique_in_model; MAX_VIEWS]));
        assert!(shows(0.09, &[oblique_in_model; MAX_VIEWS + 1]));
    }
}

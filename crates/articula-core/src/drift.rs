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
    pub fn look_from(&mut self, directions: &[Vec3], model: &ModelPose) {
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

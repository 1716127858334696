//! Retargeting of any number of clips between two figures that are compared once.

use super::driven::{NotDriven, not_driven};
use super::findings::findings;
use super::frames::Fronts;
use super::hinge;
use super::limb::Limb;
use super::motion::Motion;
use super::pass::{Pass, pinned};
use super::plan::Plan;
use super::planted::limbs;
use super::report::report;
use super::rest::Rest;
use super::side::Side;
use super::steps::Steps;
use super::transfer::Transfer;
use super::{RetargetFigure, RetargetOptions, RetargetReport, Retargeted};
use articula_core::Mismatch;
use articula_core::source::RawClip;

/// A prepared pair of figures that retargets any number of clips from one to the other.
#[derive(Debug, Clone)]
pub struct Retargeter<'a> {
    figure: RetargetFigure<'a>,
    /// Rest pose of the source as in its file.
    file_rest: Rest,
    source: Side,
    target: Side,
}

impl<'a> Retargeter<'a> {
    /// Compares two figures. The rest pose of each counts if it is that of a standing figure;
    /// otherwise a standing pose is found from the figure's clips, unless both are of one rig with
    /// one rest pose.
    ///
    /// # Errors
    /// A [`Mismatch`] if an articulation does not fit its skeleton, if no joint is mapped to the
    /// root or a hip, or if a rest transform is not finite.
    pub fn new(source: RetargetFigure<'a>, target: RetargetFigure<'_>) -> Result<Self, Mismatch> {
        let mut from = Side::new(&source, "source")?;
        let mut onto = Side::new(&target, "target")?;
        let file_rest = from.rest.clone();
        if !onto.is_of_rig(&from) {
            if !from.stands() {
                from = from.standing(&source, "source")?;
            }
            if !onto.stands() {
                onto = onto.standing(&target, "target")?;
            }
        }
        Ok(Self {
            figure: source,
            file_rest,
            source: from,
            target: onto,
        })
    }

    /// The main joints of the target that the source does not drive: hips, spine, head, shoulders,
    /// elbows, knees and ankles.
    pub fn not_driven(&self) -> NotDriven {
        let plan = Plan::new(&self.source, &self.target);
        not_driven(&self.target, &plan)
    }

    /// Retargets one clip of the source to the target.
    ///
    /// # Errors
    /// A [`Mismatch`] if a channel names a joint that does not exist or lacks values, if a pose is
    /// not finite, or if the clip has more frames than the memory limit allows.
    pub fn retarget(
        &self,
        clip: &RawClip,
        options: &RetargetOptions,
    ) -> Result<Retargeted, Mismatch> {
        let target = &self.target;
        let skeleton = self.figure.skeleton;
        let mut motion = Motion::new(clip, skeleton, &self.file_rest, options.rate_hz)?;
        if let Some(found) = &self.source.found {
            motion = motion.relative_to(&found.turns);
        }
        let seen = self.seen(&motion);
        let source = &self.source.with_fronts(&seen);
        let plan = &Plan::new(source, target);
        let steps = Steps::new(source, &motion, options.floor_metres, &|j| self.alike(j));
        let hinged: Vec<Limb> = (0..2)
            .flat_map(|i| [Limb::leg(target, i), Limb::arm(target, i)])
            .flatten()
            .collect();
        let transfer = Transfer {
            source,
            target,
            plan,
            motion: &motion,
            steps: &steps,
            limbs: &hinged,
        };
        let limbs = limbs(&transfer);
        let Pass {
            tracks,
            twists,
            quality,
            contacts_left,
            ..
        } = pinned(&transfer, &limbs, options);
        let mut report = RetargetReport {
            fastest: tracks.fastest(motion.rate_hz),
            fastest_source: motion.fastest(&source.rest),
            first_frame_jump: motion.first_frame_jump(&source.rest),
            contacts_left,
            quality,
            ..report(source, target, plan, &twists)
        };
        report.findings = findings(&report, target.body.leg_metres);
        Ok(Retargeted {
            clip: tracks.clip(&clip.name, &motion.times_secs),
            report,
        })
    }

    /// Fronts that a motion shows of the source's limbs, for limbs that differ in the target.
    fn seen(&self, motion: &Motion) -> Fronts {
        let mut seen = hinge::seen(&self.source, motion);
        seen.retain(|upper, _| !self.alike(*upper));
        seen
    }

    /// Whether the target has a twin of the joint with the same name and rest transform.
    fn alike(&self, joint: usize) -> bool {
        let twin = self.target.rest.find(self.source.rest.title(joint));
        twin.is_some_and(|t| self.source.alike(joint, &self.target, t))
    }
}

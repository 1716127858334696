//! Transfers one frame of the source to the target: rotations by the plan, the hips scaled by leg
//! length.

use super::limb::Limb;
use super::motion::Motion;
use super::plan::{Drive, Plan, RotationSource, swing};
use super::pose::Pose;
use super::side::Side;
use super::steps::{Steps, rest_floor};
use articula_core::LibmQuat;
use articula_core::same_hemisphere;
use glam::{Quat, Vec3};

/// Everything needed to transfer the frames of one clip.
#[derive(Debug, Clone, Copy)]
pub(super) struct Transfer<'a> {
    pub(super) source: &'a Side,
    pub(super) target: &'a Side,
    pub(super) plan: &'a Plan,
    pub(super) motion: &'a Motion,
    pub(super) steps: &'a Steps,
    /// Arms and legs of the target.
    pub(super) limbs: &'a [Limb],
}

/// Distance in leg lengths by which a foot may move without sliding.
const NOISE: f32 = 0.001;

impl Transfer<'_> {
    /// Distance by which a foot of the target may move without sliding, metres.
    pub(super) fn noise_metres(&self) -> f32 {
        NOISE * self.target.body.leg_metres
    }

    /// Poses the target like the source at a frame, without pinning.
    pub(super) fn pose(&self, frame: usize, pose: &mut Pose) {
        self.turn(frame, pose);
        let target = self.target;
        let root = target.rest.positions[target.body.root];
        pose.place(self.plan, target, root);
        let root = root + self.middle(frame) - target.body.middle(&pose.positions);
        pose.place(self.plan, target, root);
        // Captures overstretch knees and elbows by a few degrees.
        let stretched = self.limbs.iter().filter(|l| l.unstretch(pose)).count();
        if stretched > 0 {
            pose.place(self.plan, target, root);
        }
    }

    /// Rotates every joint by the plan.
    fn turn(&self, frame: usize, pose: &mut Pose) {
        let target = self.target;
        for (j, drive) in self.plan.drives.iter().enumerate() {
            pose.deltas[j] = match drive {
                Drive::Held => target.rest.parents[j].map_or(Quat::IDENTITY, |p| pose.deltas[p]),
                Drive::Twin(s) => self.read(frame, s),
                Drive::Between(a, b, share) => {
                    let (a, b) = (self.read(frame, a), self.read(frame, b));
                    a.libm_slerp(same_hemisphere(a, b), *share)
                }
            };
        }
    }

    fn read(&self, frame: usize, from: &RotationSource) -> Quat {
        let mut delta = self.motion.deltas(frame)[from.joint];
        if let Some((upper, lower)) = from.along {
            let places = self.motion.positions(frame);
            let rest = self.source.rest.way(upper, lower);
            delta = swing(delta, rest, places[lower] - places[upper]);
        }
        self.plan.world * delta * self.steps.level[from.joint] * from.frame
    }

    /// Target position of the midpoint of the hips.
    fn middle(&self, frame: usize) -> Vec3 {
        let (source, target) = (self.source, self.target);
        let scale = self.plan.scale;
        let rest = source.body.middle(&source.rest.positions);
        let now = source.body.middle(self.motion.positions(frame));
        let home = target.body.middle(&target.rest.positions);
        let along = self.plan.world * (scale * (now - rest));
        let above = now.y - self.steps.floor - source.body.ankle_height;
        let height = scale * above + target.body.ankle_height + rest_floor(target);
        Vec3::new(home.x + along.x, height, home.z + along.z)
    }
}

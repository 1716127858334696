//! What a viewer would notice in a transferred clip, in words.

use articula_build::retarget::{BodyEnd, RetargetFinding};
use articula_core::source::Skeleton;
use serde::Serialize;

/// Something in a transferred clip that a viewer would notice, or that its quality depends on.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct FitFinding {
    /// Its kind.
    pub kind: FitFindingKind,
    /// What was found, with names and numbers.
    pub what: String,
}

/// Kinds of findings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FitFindingKind {
    /// Main joints of the character keep their rest pose.
    NotDriven,
    /// The rest pose of the motion's figure is no standing one.
    SourceRest,
    /// The rest pose of the character is no standing one.
    TargetRest,
    /// The motion begins with a frame of another pose.
    FirstFrame,
    /// Knees or elbows bend the wrong way.
    Hinges,
    /// A joint turns much faster than any of the motion.
    Speed,
    /// Hands, feet or head are far from where the motion has them.
    Ends,
    /// Feet slide.
    Slide,
    /// Soles are below the floor.
    Floor,
    /// Contacts are out of reach.
    Contacts,
}

impl FitFindingKind {
    /// Whether it explains the numbers and is no fault of the motion.
    pub fn is_note(self) -> bool {
        matches!(self, Self::SourceRest | Self::TargetRest | Self::Contacts)
    }
}

/// The findings of a report in words; joints are named by the skeletons.
pub(super) fn in_words(
    findings: &[RetargetFinding],
    source: &Skeleton,
    target: &Skeleton,
) -> Vec<FitFinding> {
    use FitFindingKind as Kind;
    let name = |skeleton: &Skeleton, joint: usize| {
        let joint = skeleton.joints.get(joint);
        joint.map_or_else(String::new, |joint| joint.name.clone())
    };
    let worded = |finding: &RetargetFinding| {
        let (kind, what) = match finding {
            RetargetFinding::NotDriven(joints) => {
                let what = format!(
                    "nothing drives {}: they keep their rest pose",
                    joints.join(", ")
                );
                (Kind::NotDriven, what)
            }
            RetargetFinding::SourceRestFound => {
                let what = "the rest pose of the motion is no standing figure; its standing pose was \
                            found from its frames";
                (Kind::SourceRest, what.to_owned())
            }
            RetargetFinding::TargetRestFound => {
                let what = "the rest pose of the character is no standing figure; its standing pose \
                            was found from its clips and proportions";
                (Kind::TargetRest, what.to_owned())
            }
            RetargetFinding::FirstFrameJumps(joint, radians) => {
                let what = format!(
                    "the first frame is of another pose: {} jumps by {:.0} degrees",
                    name(source, *joint),
                    radians.to_degrees()
                );
                (Kind::FirstFrame, what)
            }
            RetargetFinding::HingesWrong(share) => {
                let percent = 100.0 * share;
                let what =
                    format!("knees or elbows bend the wrong way in {percent:.0} % of the frames");
                (Kind::Hinges, what)
            }
            RetargetFinding::TurnsFast(joint, speed) => {
                let what = format!(
                    "{} turns by up to {:.0} degrees per second, much faster than any joint of the \
                     motion",
                    name(target, *joint),
                    speed.to_degrees()
                );
                (Kind::Speed, what)
            }
            RetargetFinding::EndsOff(end, error) => {
                let (who, limb) = match end {
                    BodyEnd::Hands => ("hands are", "arm's length"),
                    BodyEnd::Feet => ("feet are", "leg's length"),
                    BodyEnd::Head => ("the head is", "distance to the hips"),
                };
                let percent = 100.0 * error;
                let what =
                    format!("{who} {percent:.0} % of the {limb} from where the motion has them");
                (Kind::Ends, what)
            }
            RetargetFinding::FeetSlide(metres) => {
                let what = format!("planted feet slide by {:.0} mm on average", 1e3 * metres);
                (Kind::Slide, what)
            }
            RetargetFinding::BelowFloor(metres) => {
                let what = format!("soles are up to {:.0} mm below the floor", 1e3 * metres);
                (Kind::Floor, what)
            }
            RetargetFinding::ContactsLeft(count) => {
                let what =
                    format!("{count} contacts of feet are out of reach and were left as they are");
                (Kind::Contacts, what)
            }
        };
        FitFinding { kind, what }
    };
    findings.iter().map(worded).collect()
}

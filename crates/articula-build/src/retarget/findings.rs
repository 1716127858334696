//! Judgement of a report: what of it a viewer would notice.

use super::finding::{BodyEnd, RetargetFinding};
use super::report::{RestPose, RetargetReport};

/// Share of frames in which a knee or elbow bends the wrong way, from which it is seen.
const HINGE_SHARE: f32 = 0.01;
/// Greatest usual angular speed of a joint: a factor of the source's and an addition, radians per
/// second.
const SPEED: (f32, f32) = (1.3, 5.0);
/// Usual error of hands, feet and head, in lengths of the limb: proportions of game characters
/// explain 0.22.
const END_ERROR: f32 = 0.3;
/// Foot slide that is seen, and depth below the floor, in leg lengths: 20 and 5 mm of an adult.
const SLIDE: f32 = 0.025;
const BELOW_FLOOR: f32 = 0.006;

/// The findings of a report that has its numbers; `leg_metres` is the length of the target's legs.
pub(super) fn findings(report: &RetargetReport, leg_metres: f32) -> Vec<RetargetFinding> {
    use RetargetFinding as Finding;
    let quality = &report.quality;
    let mut found = Vec::new();
    if !report.not_driven.is_empty() {
        found.push(Finding::NotDriven(report.not_driven.clone()));
    }
    if report.source_rest != RestPose::OfFile {
        found.push(Finding::SourceRestFound);
    }
    if report.target_rest != RestPose::OfFile {
        found.push(Finding::TargetRestFound);
    }
    if let Some((joint, radians)) = report.first_frame_jump {
        found.push(Finding::FirstFrameJumps(joint, radians));
    }
    if quality.hinge_wrong_share > HINGE_SHARE {
        found.push(Finding::HingesWrong(quality.hinge_wrong_share));
    }
    let (factor, more) = SPEED;
    let source = report.fastest_source.map_or(0.0, |(_, speed)| speed);
    if let Some((joint, speed)) = report.fastest
        && speed > factor * source + more
    {
        found.push(Finding::TurnsFast(joint, speed));
    }
    let ends = [
        (BodyEnd::Hands, quality.hands),
        (BodyEnd::Feet, quality.feet),
        (BodyEnd::Head, quality.head),
    ];
    for (end, error) in ends {
        if error.mean > END_ERROR {
            found.push(Finding::EndsOff(end, error.mean));
        }
    }
    if quality.slide.mean_metres > SLIDE * leg_metres {
        found.push(Finding::FeetSlide(quality.slide.mean_metres));
    }
    if quality.below_floor_metres > BELOW_FLOOR * leg_metres {
        found.push(Finding::BelowFloor(quality.below_floor_metres));
    }
    if report.contacts_left > 0 {
        found.push(Finding::ContactsLeft(report.contacts_left));
    }
    found
}

//! Side of a rig that is a single hand.
//!
//! Source: WebXR Hand Input, where a joint's -Z points to the finger tip and +Y out of the back of
//! the hand; seen from above, the thumb of a left hand is then at +X of its wrist.

use articula_core::joint_names::{Side, folded};
use articula_core::source::Skeleton;

/// The side according to the rest pose of a hand with the joint names of WebXR; left if there is no
/// wrist or no thumb.
pub(super) fn side(skeleton: &Skeleton) -> Side {
    let find = |wanted: &str| {
        skeleton
            .joints
            .iter()
            .position(|j| folded(&j.name) == wanted)
    };
    side_of(skeleton, find("wrist"), find("thumbphalanxproximal"))
}

/// The side according to wrist and thumb at rest; left if one of them is unknown.
pub(super) fn side_of(skeleton: &Skeleton, wrist: Option<usize>, thumb: Option<usize>) -> Side {
    let (Some(wrist), Some(thumb)) = (wrist, thumb) else {
        return Side::Left;
    };
    let matrices = skeleton.model_rest();
    let wrist_from_model = matrices[wrist].inverse();
    let thumb_in_wrist = wrist_from_model.transform_point3a(matrices[thumb].translation);
    if thumb_in_wrist.x < 0.0 {
        Side::Right
    } else {
        Side::Left
    }
}

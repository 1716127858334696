//! One pass over the frames of a motion: transfer, pinning, twist, keys and quality.

use super::RetargetOptions;
use super::planted::{ContactPinning, Goals, Planted};
use super::pose::Pose;
use super::quality::{Gauge, RetargetQuality};
use super::touch::Touches;
use super::tracks::Tracks;
use super::transfer::Transfer;
use super::twist::Twists;

/// Maximum number of passes in which contacts are left out.
const MOST_PASSES: usize = 3;

/// Result of one pass.
#[derive(Debug)]
pub(super) struct Pass {
    pub(super) tracks: Tracks,
    pub(super) twists: Twists,
    pub(super) quality: RetargetQuality,
    /// Number of contacts of feet that are not pinned although pinning was asked for.
    pub(super) contacts_left: usize,
    /// For each contact of a foot, whether it slides farther than without pinning.
    slides_farther: Vec<bool>,
}

/// Retargets all frames. Contacts that slide farther with pinning than without, because the limb
/// does not reach them, are left as they are; so are all, if feet slide farther on average.
pub(super) fn pinned(
    transfer: &Transfer<'_>,
    limbs: &[Planted],
    options: &RetargetOptions,
) -> Pass {
    let hands = options.self_contact.then(|| Touches::new(transfer));
    let hands = hands.as_ref();
    let pinning = options.pinning;
    let mut pass = Pass::new(transfer, limbs, limbs, pinning, hands);
    let mut left = vec![false; pass.slides_farther.len()];
    for _ in 1..MOST_PASSES {
        let mut more = false;
        for (left, farther) in left.iter_mut().zip(&pass.slides_farther) {
            more |= *farther && !*left;
            *left |= *farther;
        }
        if !more {
            break;
        }
        let kept = without(limbs, &left);
        pass = Pass::new(transfer, limbs, &kept, pinning, hands);
    }
    pass.contacts_left = left.iter().filter(|left| **left).count();
    let quality = &pass.quality;
    if quality.slide.mean_metres > quality.slide_before.mean_metres + transfer.noise_metres() {
        pass = Pass::new(transfer, limbs, limbs, ContactPinning::Nothing, hands);
        pass.contacts_left = pass.quality.slide.contacts;
    }
    pass
}

/// The limbs without some contacts of their feet, counted over all points of all legs.
fn without(limbs: &[Planted], left: &[bool]) -> Vec<Planted> {
    let mut left = left.iter();
    let mut kept = limbs.to_vec();
    for (_, contacts) in kept
        .iter_mut()
        .filter(|l| l.is_leg)
        .flat_map(|l| &mut l.points)
    {
        contacts.retain(|_| left.next() != Some(&true));
    }
    kept
}

impl Pass {
    /// Retargets all frames with the contacts of `kept` pinned, and with `hands` on the body; the
    /// contacts of `limbs` are measured.
    fn new(
        transfer: &Transfer<'_>,
        limbs: &[Planted],
        kept: &[Planted],
        pinning: ContactPinning,
        hands: Option<&Touches>,
    ) -> Self {
        let (plan, target, frames) = (transfer.plan, transfer.target, transfer.motion.frames());
        let goals = Goals::new(transfer, kept, pinning);
        let mut gauge = Gauge::new(transfer, limbs);
        let mut twists = Twists::new(plan, target);
        let mut keyed = twists.joints();
        keyed.extend(target.reposed());
        let mut tracks = Tracks::new(plan, target, &keyed, frames);
        let mut pose = Pose::new(target);
        for frame in 0..frames {
            transfer.pose(frame, &mut pose);
            gauge.before(transfer, frame, &pose);
            goals.apply(transfer, kept, frame, &mut pose);
            if let Some(hands) = hands {
                hands.apply(transfer, limbs, frame, &mut pose);
            }
            twists.spread(plan, target, &mut pose);
            gauge.after(transfer, frame, &pose);
            tracks.push(target, &pose);
        }
        Self {
            slides_farther: gauge.slides_farther(transfer.noise_metres()),
            quality: gauge.quality(plan.scale),
            tracks,
            twists,
            contacts_left: 0,
        }
    }
}

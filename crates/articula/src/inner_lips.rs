//! Motion of the inner lips where only the outer ones move.

use articula_core::arkit_table::outer_lip;
use articula_core::fap_table::{FAP_COUNT, LOW_FAPS};
use articula_formats::mpeg4::fap::FapClip;
use std::borrow::Cow;

/// A clip in which the inner lips have the motion of the outer ones, where only those move: the
/// inner lips lead at every level.
pub(crate) fn with_inner_lips(clip: &FapClip) -> Cow<'_, FapClip> {
    let moving = clip.moving();
    let pairs = || (1..=FAP_COUNT).filter_map(|inner| Some((inner, outer_lip(inner)?)));
    let [inner, outer] = [
        pairs().any(|(inner, _)| moving[inner - 1]),
        pairs().any(|(_, outer)| moving[outer - 1]),
    ];
    if inner || !outer {
        return Cow::Borrowed(clip);
    }
    let mut clip = clip.clone();
    let first = *LOW_FAPS.start();
    for (inner, outer) in pairs() {
        clip.coded[inner - 1] = clip.coded[outer - 1];
        for frame in &mut clip.frames {
            frame.low[inner - first] = frame.low[outer - first];
        }
    }
    Cow::Owned(clip)
}

//! FAP clips at levels of articulation.

use crate::inner_lips::with_inner_lips;
use articula_core::face_levels::{FaceLevels, FaceRegion, FapRoles};
use articula_core::fap_table::{FAP_COUNT, LOW_FAPS};
use articula_formats::mpeg4::fap::FapClip;
use serde::Serialize;
use std::collections::BTreeMap;

/// What a level of articulation leaves of a FAP clip.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FaceLevelReport {
    /// The levels, as they are written on a command line.
    pub level: String,
    /// Name of the level of each region.
    pub regions: BTreeMap<&'static str, &'static str>,
    /// Number of parameters that the level keeps, of 68.
    pub parameters: usize,
    /// Number of the parameters that move in the clip.
    pub moving: usize,
    /// Number of those that the level keeps.
    pub moving_kept: usize,
}

impl FaceLevelReport {
    /// The report of a clip, as it was before it was reduced.
    pub fn new(clip: &FapClip, levels: &FaceLevels) -> Self {
        let (roles, moving) = (levels.roles(), clip.moving());
        let moving = (1..=FAP_COUNT).filter(|fap| moving[fap - 1]);
        Self {
            level: levels.to_string(),
            regions: names(levels),
            parameters: roles.kept(),
            moving: moving.clone().count(),
            moving_kept: moving.filter(|fap| roles.keeps(*fap)).count(),
        }
    }
}

/// Name of the level of each region.
pub(super) fn names(levels: &FaceLevels) -> BTreeMap<&'static str, &'static str> {
    let name = |region: FaceRegion| (region.name(), levels.level(region).name());
    FaceRegion::ALL.into_iter().map(name).collect()
}

/// Returns a clip as it is sent at a level: parameters that the level does not keep are neutral and
/// not in its masks. A receiver restores the others with [`expand_face`].
pub fn reduce_face(clip: &FapClip, roles: &FapRoles) -> FapClip {
    let mut clip = with_inner_lips(clip).into_owned();
    for fap in (1..=FAP_COUNT).filter(|fap| !roles.keeps(*fap)) {
        clip.coded[fap - 1] = false;
        for frame in &mut clip.frames {
            match fap {
                1 => frame.viseme = Default::default(),
                2 => frame.expression = Default::default(),
                _ => frame.low[fap - LOW_FAPS.start()] = 0,
            }
        }
    }
    clip
}

/// Returns a clip as a receiver shows it at a level: parameters that the level does not keep have
/// the values that they copy, or are neutral. The same for a clip and for what [`reduce_face`]
/// leaves of it.
pub fn expand_face(clip: &FapClip, roles: &FapRoles) -> FapClip {
    let mut clip = reduce_face(clip, roles);
    for frame in &mut clip.frames {
        roles.expand(&mut frame.low);
    }
    let moving = clip.moving();
    for (coded, moves) in clip.coded.iter_mut().zip(moving) {
        *coded |= moves;
    }
    clip
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::face_levels::FaceLevel;
    use articula_formats::mpeg4::fap::FapFrame;

    fn clip(values: &[(usize, i32)]) -> FapClip {
        let mut frame = FapFrame::default();
        for (fap, value) in values {
            frame.low[fap - 3] = *value;
        }
        FapClip {
            name: "one frame".to_owned(),
            rate_hz: 25.0,
            coded: [true; FAP_COUNT],
            frames: vec![frame],
            bridge: None,
        }
    }

    #[test]
    fn what_is_sent_is_shown_as_the_whole() {
        let all: Vec<(usize, i32)> = (3..=68).map(|fap| (fap, 10 * fap as i32)).collect();
        let clip = clip(&all);
        for level in FaceLevel::ALL {
            let roles = FaceLevels::all(level).roles();
            let sent = reduce_face(&clip, &roles);
            assert_eq!(sent.coded.iter().filter(|c| **c).count(), roles.kept());
            // All but visemes and expressions move.
            let moving = sent.moving().iter().filter(|m| **m).count();
            assert_eq!(moving, roles.kept() - 2);
            assert_eq!(
                expand_face(&sent, &roles).frames,
                expand_face(&clip, &roles).frames
            );
            let report = FaceLevelReport::new(&clip, &FaceLevels::all(level));
            assert_eq!((report.parameters, report.moving), (roles.kept(), 66));
            assert_eq!(report.moving_kept, roles.kept() - 2);
        }
        let low = expand_face(&clip, &FaceLevels::all(FaceLevel::Low).roles());
        let of = |fap: usize| low.frames[0].low[fap - 3];
        assert_eq!((of(8), of(21), of(51), of(68)), (40, 190, 40, 0));
        assert!(low.coded[51 - 1] && !low.coded[68 - 1]);
    }

    #[test]
    fn outer_lips_alone_lead() {
        let clip = clip(&[(52, -80), (54, 30)]);
        let coarse = expand_face(&clip, &FaceLevels::all(FaceLevel::VeryLow).roles());
        let of = |fap: usize| coarse.frames[0].low[fap - 3];
        assert_eq!(
            (of(5), of(52), of(10), of(6), of(54)),
            (-80, -80, -80, 30, 30)
        );
    }
}

//! Which joints share units: groups by level of articulation, region, or one joint each.
//!
//! Form: `docs/formats/abp2.md`, part 2.

use articula_core::{Region, Rig};

/// What the joints of one unit have in common; the finer, the more can be cut, for more bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
pub enum Grouping {
    /// The level of articulation.
    #[default]
    Loa,
    /// The level of articulation and the body region.
    LoaRegion,
    /// One joint.
    Joint,
}

impl Grouping {
    /// All groupings, by their numbers in a stream.
    pub const ALL: [Self; 3] = [Self::Loa, Self::LoaRegion, Self::Joint];
}

/// The labels of a group of joints or morph targets.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Group {
    /// Level of articulation: of joints 0 (coarsest) to 5, of morph targets 0 (very low) to 3 (high).
    pub loa: u8,
    /// Number of the region: of the body 1 to 7 as in [`Region::ALL`], 0 if the group is of several; of
    /// morph targets that of the face, 0 to 7.
    pub region: u8,
    /// The joint of a group of one.
    pub joint: Option<u16>,
}

/// Number of a region in a stream, 1 to 7.
pub(super) fn region_number(region: Region) -> u8 {
    1 + region as u8
}

/// Returns the groups of a rig's joints in the order of their numbers, with their joints in the
/// order of the rig.
pub(super) fn groups(grouping: Grouping, rig: &Rig) -> Vec<(Group, Vec<u16>)> {
    let mut groups: Vec<(Group, Vec<u16>)> = Vec::new();
    for (j, joint) in rig.articulation().joints.iter().enumerate() {
        let region = region_number(joint.region);
        let group = match grouping {
            Grouping::Loa => Group {
                loa: joint.level,
                region: 0,
                joint: None,
            },
            Grouping::LoaRegion => Group {
                loa: joint.level,
                region,
                joint: None,
            },
            Grouping::Joint => Group {
                loa: joint.level,
                region,
                joint: Some(j as u16),
            },
        };
        match groups.iter_mut().find(|(g, _)| *g == group) {
            Some((_, joints)) => joints.push(j as u16),
            None => groups.push((group, vec![j as u16])),
        }
    }
    groups.sort_by_key(|(group, _)| *group);
    if grouping == Grouping::Joint {
        // In the order of the rig.
        groups.sort_by_key(|(group, _)| group.joint);
    }
    groups
}

//! Any bytes as a motion stream of the rig that its head describes: a clip, or an error. Version 1, which has
//! no checksums, leads deep into the decoder.
#![no_main]

use articula_core::source::{Joint, Skeleton};
use articula_core::{Articulation, JointArticulation, Region, Rig, Transform};
use articula_stream::abp2::{CarriedSkeleton, MotionHead, MotionReceiver, motion_map, prefix_map};
use articula_stream::{CutRule, StreamLimits, cut};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let limits = StreamLimits {
        bytes: 1 << 16,
        elements: 1 << 18,
    };
    if let Ok(map) = motion_map(bytes, &limits) {
        let rule = CutRule::default().at_least("tier", 1).at_most("loa", 2);
        let part = cut(bytes, &map, |unit| rule.keeps(unit)).unwrap();
        assert_eq!(motion_map(&part.bytes, &limits), Ok(part.unit));
        assert_eq!(prefix_map(bytes, &limits), Ok(map));
    }
    if let Ok(Some(carried)) = CarriedSkeleton::open(bytes, &limits) {
        Rig::new(&carried.skeleton, carried.articulation).unwrap();
    }
    let Ok(head) = MotionHead::open(bytes, &limits) else {
        return;
    };
    let joint = Joint {
        name: String::new(),
        parent: None,
        rest: Transform::default(),
        in_skin: true,
    };
    let region = |number: u8| {
        let index = usize::from(number).wrapping_sub(1);
        Region::ALL.get(index).copied().unwrap_or(Region::Torso)
    };
    let mut groups = head.groups.iter().cycle();
    let known = (0..head.joints).filter_map(|_| groups.next()).map(|group| JointArticulation {
        hanim: None,
        level: group.loa,
        region: region(group.region),
    });
    let articulation = Articulation {
        profile: String::new(),
        joints: known.collect(),
    };
    let skeleton = Skeleton {
        joints: vec![joint; head.joints],
    };
    let Ok(rig) = Rig::new(&skeleton, articulation) else {
        return;
    };
    if let Ok(received) = MotionReceiver::read(bytes, &rig, &limits) {
        assert_eq!(received.clip().unwrap().joints(), head.joints);
    }
});

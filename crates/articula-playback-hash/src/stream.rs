//! A stored motion stream: its whole numbers, and the rotations and translations made of them.

use crate::fnv::Fnv;
use articula_core::source::{Joint, Skeleton};
use articula_core::{Articulation, JointArticulation, Mismatch, Region, Rig, Transform};
use articula_stream::abp2::{MotionHead, MotionReceiver};
use articula_stream::{StreamError, StreamLimits};

const STREAM: &[u8] = include_bytes!("../../articula-stream/tests/golden/walk.abp");

pub(crate) fn decode(sum: &mut Fnv) -> Result<(), Mismatch> {
    let limits = StreamLimits::default();
    let wrong = |e: StreamError| Mismatch::new("the stored stream", e.to_string());
    let head = MotionHead::open(STREAM, &limits).map_err(wrong)?;
    let received = MotionReceiver::read(STREAM, &rig(&head)?, &limits).map_err(wrong)?;
    sum.bytes(&received.hash().to_le_bytes());
    let clip = received.clip()?;
    for track in &clip.tracks().rotations {
        track.values.iter().for_each(|q| sum.floats(&q.to_array()));
    }
    for track in &clip.tracks().translations {
        track.values.iter().for_each(|t| sum.floats(&t.to_array()));
    }
    Ok(())
}

/// A rig with the groups of the stream, whose units are of one joint each. What is decoded does not
/// depend on its shape.
fn rig(head: &MotionHead) -> Result<Rig, Mismatch> {
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
    let known = head.groups.iter().map(|group| JointArticulation {
        hanim: None,
        level: group.loa,
        region: region(group.region),
    });
    let articulation = Articulation {
        profile: String::new(),
        joints: known.collect(),
    };
    let joints = vec![joint; head.joints];
    Rig::new(&Skeleton { joints }, articulation)
}

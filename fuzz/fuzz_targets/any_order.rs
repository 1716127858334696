//! Any bytes as a motion, face or mesh stream that is received in another order than that of its bytes. What
//! reads in order shows the same in any order; what does not ends in values or errors. The first two bytes
//! choose the order.
#![no_main]

use articula_core::source::{Joint, Skeleton};
use articula_core::{Articulation, Clip, JointArticulation, Region, Rig, Transform};
use articula_stream::abp2::{MotionHead, MotionReceiver, motion_map};
use articula_stream::afp2::FaceReceiver;
use articula_stream::mesh::{MeshStream, Receiver};
use articula_stream::{CutRule, FaceReadOptions, StreamLimits, Unit, cut, difference, selected};
use libfuzzer_sys::fuzz_target;
use std::ops::Range;

const LIMITS: StreamLimits = StreamLimits {
    bytes: 1 << 16,
    elements: 1 << 18,
};

fuzz_target!(|bytes: &[u8]| {
    let Some(([stride, start], stream)) = bytes.split_first_chunk::<2>() else {
        return;
    };
    let order = (usize::from(*stride), usize::from(*start));
    if stream.starts_with(b"AMSH") {
        mesh(stream, order);
    } else if let Ok(head) = MotionHead::open(stream, &LIMITS) {
        match head.face {
            Some(_) => face(stream, order),
            None => motion(stream, &head, order),
        }
    }
});

/// The ranges of a stream: those of its coarse tiers, then the others, each from another one on.
fn ranges(map: &Unit, (stride, start): (usize, usize)) -> Vec<Range<u64>> {
    let coarse = CutRule::default()
        .at_least("tier", 2)
        .at_least("level", 1)
        .at_most("pose_loa", 1);
    let first = selected(map, |unit| coarse.keeps(unit)).unwrap();
    let all = selected(map, |_| true).unwrap();
    let rest = difference(&first, &all);
    assert_eq!(first.bytes() + rest.bytes(), all.bytes());
    let mut list: Vec<Range<u64>> = first
        .ranges()
        .iter()
        .chain(rest.ranges())
        .cloned()
        .collect();
    let others = list.len().max(2) - 1;
    if list.len() > 1 {
        list[1..].rotate_left(start % others);
    }
    // The first range has the head.
    let step = stride % 7 + 1;
    let mut found: Vec<Range<u64>> = list.first().cloned().into_iter().collect();
    for first in 0..step {
        found.extend(list.iter().skip(1 + first).step_by(step).cloned());
    }
    found
}

/// Pieces where the map is not known: anything at all.
fn pieces(length: usize, (stride, start): (usize, usize)) -> impl Iterator<Item = Range<usize>> {
    let size = stride + 1;
    let count = length / size + 1;
    (0..count).map(move |i| {
        let from = (i + start) % count * size;
        from.min(length)..(from + size + start).min(length)
    })
}

fn motion(stream: &[u8], head: &MotionHead, order: (usize, usize)) {
    let Some(rig) = rig(head) else {
        return;
    };
    let mut any = MotionReceiver::new(&rig, &LIMITS);
    let whole = MotionReceiver::read(stream, &rig, &LIMITS);
    match (motion_map(stream, &LIMITS), whole) {
        (Ok(map), Ok(whole)) => {
            for range in ranges(&map, order) {
                let bytes = &stream[range.start as usize..range.end as usize];
                any.receive_at(range.start, bytes).unwrap();
            }
            assert_eq!(bits(&any.clip().unwrap()), bits(&whole.clip().unwrap()));
            assert_eq!((any.hash(), any.is_whole()), (whole.hash(), true));
        }
        _ => {
            let _ = any.receive_at(0, stream);
            for piece in pieces(stream.len(), order) {
                let _ = any.receive_at(piece.start as u64, &stream[piece.clone()]);
                let _ = any.receive_units(order.0, &stream[piece]);
            }
            let _ = any.clip();
        }
    }
}

fn face(stream: &[u8], order: (usize, usize)) {
    let new = || FaceReceiver::new(&FaceReadOptions::default(), &LIMITS).unwrap();
    let (mut any, mut whole) = (new(), new());
    match (motion_map(stream, &LIMITS), whole.receive(stream)) {
        (Ok(map), Ok(_)) => {
            for range in ranges(&map, order) {
                let bytes = &stream[range.start as usize..range.end as usize];
                any.receive_at(range.start, bytes).unwrap();
            }
            assert_eq!(any.decoded(), whole.decoded());
        }
        _ => {
            for piece in pieces(stream.len(), order) {
                let _ = any.receive_at(piece.start as u64, &stream[piece.clone()]);
                let _ = any.receive_units(order.0, &stream[piece]);
            }
            let _ = any.decoded();
        }
    }
}

fn mesh(stream: &[u8], order: (usize, usize)) {
    let Ok(head) = MeshStream::open(stream, &LIMITS) else {
        return;
    };
    let Ok(mut any) = Receiver::read(&stream[..head.head_bytes], &LIMITS) else {
        return;
    };
    let map = head.unit();
    for range in ranges(&map, order) {
        let start = (range.start as usize).max(head.head_bytes);
        if let Some(bytes) = stream.get(start..range.end as usize) {
            let _ = any.receive_at(start as u64, bytes);
        }
    }
    if let Ok(whole) = Receiver::read(stream, &LIMITS)
        && cut(stream, &map, |_| true).is_ok()
    {
        for object in 0..head.objects.len() {
            assert_eq!(any.mesh(object), whole.mesh(object));
        }
    }
}

/// The bits of all values.
fn bits(clip: &Clip) -> Vec<u32> {
    let tracks = clip.tracks();
    let rotations = tracks.rotations.iter().flat_map(|track| &track.values);
    let mut bits: Vec<u32> = rotations
        .flat_map(|q| q.to_array().map(f32::to_bits))
        .collect();
    let vectors = tracks.translations.iter().chain(&tracks.scales);
    let vectors = vectors.flat_map(|track| &track.values);
    bits.extend(vectors.flat_map(|v| v.to_array().map(f32::to_bits)));
    let weights = tracks.morphs.iter().flat_map(|track| &track.values);
    bits.extend(weights.map(|w| w.to_bits()));
    bits
}

/// The rig that a head describes.
fn rig(head: &MotionHead) -> Option<Rig> {
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
    let known = (0..head.joints)
        .filter_map(|_| groups.next())
        .map(|group| JointArticulation {
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
    Rig::new(&skeleton, articulation).ok()
}

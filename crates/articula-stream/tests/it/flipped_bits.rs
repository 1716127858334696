//! A stream with one flipped bit is refused, or known to end early: never shown as another motion.

use crate::small_human::asset;
use articula_mutate::Dice;
use articula_stream::abp2::{Grouping, MotionOptions, MotionReceiver, UnitOrder, encode};
use articula_stream::afp2::FaceReceiver;
use articula_stream::{FaceReadOptions, StreamKind, StreamLimits, mp4};

const FLIPS: usize = 1000;
const LIMITS: StreamLimits = StreamLimits {
    bytes: 1 << 20,
    elements: 1 << 20,
};
const MOTION: &[u8] = include_bytes!("../golden/walk.abp");
const FACE: &[u8] = include_bytes!("../golden/wave2.afp");

/// Flips bits one at a time; `is_accepted` tells whether the bytes read as if nothing was missing. Returns
/// how many flips were found for certain.
fn check(stream: &[u8], is_accepted: impl Fn(&[u8]) -> Option<bool>) -> usize {
    assert_eq!(
        is_accepted(stream),
        Some(true),
        "the unharmed stream is good"
    );
    let mut dice = Dice::new(41);
    let mut refused = 0;
    for _ in 0..FLIPS {
        let bit = dice.roll(8 * stream.len());
        let mut bytes = stream.to_vec();
        bytes[bit / 8] ^= 1 << (bit % 8);
        match is_accepted(&bytes) {
            None => refused += 1,
            Some(is_whole) => assert!(!is_whole, "bit {bit} of {} is not found", 8 * stream.len()),
        }
    }
    refused
}

/// `None` if a motion is refused, else whether it is whole.
fn motion(bytes: &[u8]) -> Option<bool> {
    let read = MotionReceiver::read(bytes, &asset().rig, &LIMITS).ok()?;
    read.clip().ok()?;
    Some(read.is_whole())
}

/// The same of a face.
fn face(bytes: &[u8]) -> Option<bool> {
    let mut receiver = FaceReceiver::new(&FaceReadOptions::default(), &LIMITS).ok()?;
    receiver.receive(bytes).ok()?;
    receiver.decoded().ok()?;
    Some(receiver.is_whole())
}

#[test]
fn no_flipped_bit_of_a_motion_is_accepted() {
    assert!(check(MOTION, motion) > FLIPS * 95 / 100);
    let options = MotionOptions {
        grouping: Grouping::LoaRegion,
        order: UnitOrder::Value,
        skeleton: true,
        ..MotionOptions::default()
    };
    let asset = asset();
    let walk = asset.clips.iter().find(|clip| clip.name == "walk").unwrap();
    let coded = encode(&asset.rig, &asset.mesh, walk, &options).unwrap();
    assert!(check(&coded.bytes, motion) > FLIPS * 95 / 100);
}

#[test]
fn no_flipped_bit_of_a_face_is_accepted() {
    assert!(check(FACE, face) > FLIPS * 95 / 100);
}

#[test]
fn no_flipped_bit_of_an_mp4_file_is_accepted() {
    let file = mp4::write(&[MOTION, FACE], &LIMITS).unwrap();
    let refused = check(&file, |bytes| {
        let tracks = mp4::read(bytes, &LIMITS).ok()?;
        let mut is_whole = true;
        for track in &tracks {
            let stream = track.stream(bytes).ok()?;
            is_whole &= match track.kind? {
                StreamKind::Afp2 => face(&stream)?,
                _ => motion(&stream)?,
            };
        }
        Some(is_whole)
    });
    assert_eq!(refused, FLIPS);
}

#[test]
fn a_flipped_bit_in_an_mp4_file_is_found_whatever_the_stream() {
    // ABP-1 and AFP-1 have no checksums of their own.
    let [bones, parameters] = [
        &include_bytes!("../golden/wave.abp")[..],
        include_bytes!("../golden/wave.afp"),
    ];
    let file = mp4::write(&[bones, parameters], &LIMITS).unwrap();
    let refused = check(&file, |bytes| mp4::read(bytes, &LIMITS).ok().map(|_| true));
    assert_eq!(refused, FLIPS);
}

//! A client that fetches what it lacks of a growing selection shows what that selection, cut from the whole
//! stream, shows: of motions and faces, in any order of arrival.

use crate::cut_streams::as_version_1;
use crate::small_human::asset;
use articula_core::{Clip, Mesh, Track, Tracks};
use articula_mutate::{Dice, Edit, Mutations};
use articula_stream::abp2::{
    EncodedMotion, Grouping, MotionOptions, MotionReceiver, UnitOrder, encode, motion_map,
};
use articula_stream::afp2::{Afp2Options, FaceReceiver, write as write_face};
use articula_stream::{
    ByteRanges, CutRule, FaceClip, FaceFrame, FaceReadOptions, FrameRate, StreamError,
    StreamLimits, Unit, cut, difference, selected,
};
use glam::Quat;
use proptest::prelude::*;
use std::ops::Range;
use std::sync::OnceLock;

const LIMITS: StreamLimits = StreamLimits {
    bytes: 1 << 20,
    elements: 1 << 20,
};

/// A stream of a motion or a face, with its map.
struct Stream {
    bytes: Vec<u8>,
    map: Unit,
    of_face: bool,
}

/// A walk in the groupings and orders, a joint that spins by several turns, a face.
fn streams() -> &'static [Stream] {
    static STREAMS: OnceLock<Vec<Stream>> = OnceLock::new();
    STREAMS.get_or_init(|| {
        let asset = asset();
        let walk = asset.clips.iter().find(|clip| clip.name == "walk").unwrap();
        let options = |grouping, order| MotionOptions {
            grouping,
            order,
            access_unit_secs: if grouping == Grouping::Joint {
                0.5
            } else {
                0.2
            },
            skeleton: grouping != Grouping::Joint,
            ..MotionOptions::default()
        };
        let by_region = options(Grouping::LoaRegion, UnitOrder::Value);
        let by_joint = options(Grouping::Joint, UnitOrder::Tier);
        let of_motion = |coded: EncodedMotion| Stream {
            bytes: coded.bytes,
            map: coded.unit,
            of_face: false,
        };
        let mesh = Mesh::default();
        let walks = [&by_region, &by_joint];
        let walks = walks.map(|options| encode(&asset.rig, &mesh, walk, options).unwrap());
        let mut streams: Vec<Stream> = walks.into_iter().map(of_motion).collect();
        let old = as_version_1(&streams[1].bytes);
        streams.push(Stream {
            map: motion_map(&old, &LIMITS).unwrap(),
            bytes: old,
            of_face: false,
        });
        let spin = encode(&asset.rig, &mesh, &spin(), &by_region).unwrap();
        streams.push(of_motion(spin));
        let face = write_face(&face(), &face_options()).unwrap();
        streams.push(Stream {
            bytes: face.bytes,
            map: face.unit,
            of_face: true,
        });
        streams
    })
}

/// Joints turn by up to three turns about slanted axes, so that signs of rotations flip wherever
/// something is missing.
fn spin() -> Clip {
    let track = |(joint, speed): (u16, f32)| Track {
        target: joint,
        step: false,
        values: (0..60)
            .map(|i| Quat::from_axis_angle(glam::vec3(0.6, 0.8, 0.0), i as f32 * speed))
            .collect(),
    };
    let tracks = Tracks {
        rotations: [(0, 0.3), (3, 0.17), (20, -0.23)].map(track).into(),
        ..Tracks::default()
    };
    Clip::new("spin", 30.0, 60, asset().rig.len(), tracks).unwrap()
}

fn face() -> FaceClip {
    let frame = |f: usize| {
        let value = |i: usize| (80.0 * (0.2 * f as f32 + i as f32).sin()) as i32;
        FaceFrame {
            low: std::array::from_fn(value),
            ..FaceFrame::NEUTRAL
        }
    };
    FaceClip {
        name: "face".into(),
        bridge: None,
        rate: FrameRate::nearest(25.0).unwrap(),
        frames: (0..60).map(frame).collect(),
    }
}

/// Access units shorter than a fade.
fn face_options() -> Afp2Options {
    Afp2Options {
        access_unit_secs: 0.16,
        ..Afp2Options::default()
    }
}

/// A receiver of one of the streams.
#[derive(Clone)]
enum Client {
    Motion(MotionReceiver),
    Face(FaceReceiver),
}

impl Client {
    fn of(stream: &Stream) -> Self {
        if stream.of_face {
            Self::Face(FaceReceiver::new(&FaceReadOptions::default(), &LIMITS).unwrap())
        } else {
            Self::Motion(MotionReceiver::new(&asset().rig, &LIMITS))
        }
    }

    fn receive(&mut self, bytes: &[u8]) -> Result<Range<usize>, StreamError> {
        match self {
            Self::Motion(motion) => motion.receive(bytes),
            Self::Face(face) => face.receive(bytes),
        }
    }

    fn receive_at(&mut self, offset: u64, bytes: &[u8]) -> Result<Range<usize>, StreamError> {
        match self {
            Self::Motion(motion) => motion.receive_at(offset, bytes),
            Self::Face(face) => face.receive_at(offset, bytes),
        }
    }

    fn receive_units(
        &mut self,
        access_unit: usize,
        units: &[u8],
    ) -> Result<Range<usize>, StreamError> {
        match self {
            Self::Motion(motion) => motion.receive_units(access_unit, units),
            Self::Face(face) => face.receive_units(access_unit, units),
        }
    }

    /// The bits of all values at each frame; nothing before the head.
    fn shown(&self) -> Vec<Vec<u32>> {
        match self {
            Self::Motion(motion) => motion.clip().map_or(Vec::new(), |clip| bits_of(&clip)),
            Self::Face(face) => face.decoded().map_or(Vec::new(), |face| {
                let bits = |frame: &FaceFrame| frame.low.map(|value| value as u32).into();
                face.clip.frames.iter().map(bits).collect()
            }),
        }
    }

    /// What else it tells of what it has.
    fn told(&self) -> (usize, bool, u64) {
        match self {
            Self::Motion(motion) => (motion.frames(), motion.is_whole(), motion.hash()),
            Self::Face(face) => (face.frames(), face.is_whole(), 0),
        }
    }
}

fn bits_of(clip: &Clip) -> Vec<Vec<u32>> {
    fn add<T: Copy>(rows: &mut [Vec<u32>], tracks: &[Track<T>], bits: impl Fn(T, &mut Vec<u32>)) {
        for track in tracks {
            for (frame, row) in rows.iter_mut().enumerate() {
                let at = if track.values.len() > 1 { frame } else { 0 };
                row.push(u32::from(track.target));
                bits(track.values[at], row);
            }
        }
    }
    let mut rows = vec![Vec::new(); clip.frames()];
    let tracks = clip.tracks();
    add(&mut rows, &tracks.rotations, |q, row| {
        row.extend(q.to_array().map(f32::to_bits));
    });
    for vectors in [&tracks.translations, &tracks.scales] {
        add(&mut rows, vectors, |v, row| {
            row.extend(v.to_array().map(f32::to_bits))
        });
    }
    add(&mut rows, &tracks.morphs, |w: f32, row| {
        row.push(w.to_bits())
    });
    rows
}

pub(crate) fn bytes_of(unit: &Unit) -> Range<u64> {
    unit.bits.start / 8..unit.bits.end / 8
}

pub(crate) fn part<'a>(bytes: &'a [u8], range: &Range<u64>) -> &'a [u8] {
    &bytes[range.start as usize..range.end as usize]
}

/// Whether all bytes of a range are among some.
pub(crate) fn has(have: &ByteRanges, range: &Range<u64>) -> bool {
    let all = std::iter::once(range.clone()).collect();
    difference(have, &all).bytes() == 0
}

/// Whether the bytes that a unit has besides its parts are among some.
fn has_own(have: &ByteRanges, unit: &Unit) -> bool {
    let range = bytes_of(unit);
    let first = unit.children.iter().find(|child| child.label != "frames");
    let end = first.map_or(range.end, |child| bytes_of(child).start);
    has(have, &(range.start..end))
}

/// What is cut from the whole stream by what a client has.
fn cut_by(stream: &[u8], map: &Unit, have: &ByteRanges) -> Vec<u8> {
    cut(stream, map, |unit| has_own(have, unit)).unwrap().bytes
}

/// Rules of which any union is a stream.
fn rule() -> impl Strategy<Value = CutRule> {
    let numbers = (0_u32..6, 0_u32..7, any::<u8>(), 0_u32..20, any::<bool>());
    numbers.prop_map(|(tier, loa, regions, access_units, has_all)| {
        let rule = CutRule::default()
            .at_least("tier", tier)
            .at_most("loa", loa)
            .at_most("pose_loa", loa)
            .at_most("face_loa", loa)
            .in_mask("region", u64::from(regions))
            .in_mask("face_region", u64::from(regions));
        match has_all {
            true => rule,
            false => rule.at_most("access_unit", access_units),
        }
    })
}

pub(crate) fn shuffled<T>(mut list: Vec<T>, dice: &mut Dice) -> Vec<T> {
    for i in (1..list.len()).rev() {
        list.swap(i, dice.roll(i + 1));
    }
    list
}

/// Receives and checks that frames outside of those told to have changed have not.
fn checked(
    client: &mut Client,
    receive: impl FnOnce(&mut Client) -> Result<Range<usize>, StreamError>,
) {
    let before = client.shown();
    let changed = receive(client).unwrap();
    let after = client.shown();
    for frame in (0..after.len()).filter(|frame| !changed.contains(frame)) {
        // A face has no frames before its first access unit.
        let was = before.get(frame);
        assert!(
            was == Some(&after[frame]) || before.is_empty(),
            "frame {frame}, told {changed:?}"
        );
    }
}

/// A client of what was fetched, in another order.
fn resumed(stream: &Stream, fetched: &[Range<u64>], dice: &mut Dice) -> Client {
    let mut client = Client::of(stream);
    for range in shuffled(fetched.to_vec(), dice) {
        client
            .receive_at(range.start, part(&stream.bytes, &range))
            .unwrap();
    }
    client
}

/// A client of whole units in any order, each with the number of its access unit alone.
fn of_units(stream: &Stream, have: &ByteRanges, dice: &mut Dice) -> Client {
    let mut client = Client::of(stream);
    let head = &stream.map.children[0];
    let mut own = ByteRanges::default();
    if has_own(have, head) {
        let first = head
            .children
            .first()
            .map_or(bytes_of(head).end, |unit| bytes_of(unit).start);
        own = std::iter::once(0..first).collect();
    }
    let poses = head
        .children
        .iter()
        .map(bytes_of)
        .filter(|pose| has(have, pose));
    for range in own.ranges().iter().cloned().chain(poses) {
        client
            .receive_at(range.start, part(&stream.bytes, &range))
            .unwrap();
    }
    let mut all = Vec::new();
    for (number, access_unit) in stream.map.children[1..].iter().enumerate() {
        if has_own(have, access_unit) {
            all.push((number, 0..0));
        }
        let units = access_unit
            .children
            .iter()
            .filter(|unit| unit.label == "unit");
        let there = units.map(bytes_of).filter(|unit| has(have, unit));
        all.extend(there.map(|unit| (number, unit)));
    }
    for (number, unit) in shuffled(all, dice) {
        client
            .receive_units(number, part(&stream.bytes, &unit))
            .unwrap();
    }
    client
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]
    #[test]
    fn a_client_of_increments_shows_what_the_cut_shows(
        which in 0_usize..5,
        rules in prop::collection::vec(rule(), 1..5),
        seed: u64,
    ) {
        let stream = &streams()[which];
        let mut dice = Dice::new(seed);
        let mut client = Client::of(stream);
        let mut have = ByteRanges::default();
        let mut fetched = Vec::new();
        for rule in rules {
            let want = selected(&stream.map, |unit| rule.keeps(unit)).unwrap();
            let more = difference(&have, &want);
            let union = have.union(&want);
            prop_assert_eq!(have.bytes() + more.bytes(), union.bytes(), "a byte was fetched again");
            // The first range has the head.
            let mut ranges = more.ranges().to_vec();
            if fetched.is_empty() {
                let first = ranges.remove(0);
                checked(&mut client, |client| client.receive_at(first.start, part(&stream.bytes, &first)));
                fetched.push(first);
            }
            for range in shuffled(ranges, &mut dice) {
                let bytes = part(&stream.bytes, &range);
                checked(&mut client, |client| client.receive_at(range.start, bytes));
                fetched.push(range);
            }
            have = union;
            // The client is killed, and goes on from what it fetched.
            let again = resumed(stream, &fetched, &mut dice);
            prop_assert_eq!(client.shown(), again.shown());
            if dice.roll(2) == 0 {
                client = again;
            }
            let by_units = of_units(stream, &have, &mut dice);
            prop_assert_eq!(client.shown(), by_units.shown());
            prop_assert_eq!(client.told(), by_units.told());
            let mut of_cut = Client::of(stream);
            of_cut.receive(&cut_by(&stream.bytes, &stream.map, &have)).unwrap();
            prop_assert_eq!(client.shown(), of_cut.shown());
            prop_assert_eq!(client.told(), of_cut.told());
        }
    }
}

/// The head of a stream, and its units: access unit, group and tier in rising order, bytes.
fn head_and_units(stream: &Stream) -> (Range<u64>, Vec<(usize, Range<u64>)>) {
    let mut units = Vec::new();
    for (number, access_unit) in stream.map.children[1..].iter().enumerate() {
        let of_unit = access_unit
            .children
            .iter()
            .filter(|unit| unit.label == "unit");
        units.extend(of_unit.map(|unit| (number, bytes_of(unit))));
    }
    (bytes_of(&stream.map.children[0]), units)
}

/// A client that has the head.
fn with_head(stream: &Stream) -> Client {
    let (head, _) = head_and_units(stream);
    let mut client = Client::of(stream);
    client.receive_at(0, part(&stream.bytes, &head)).unwrap();
    client
}

fn motion(client: &Client) -> &MotionReceiver {
    match client {
        Client::Motion(motion) => motion,
        Client::Face(_) => panic!("a motion"),
    }
}

#[test]
fn a_played_access_unit_refines_and_no_other_frame_changes() {
    let stream = &streams()[0];
    let tier = |tier| {
        let rule = CutRule::default().at_least("tier", tier);
        selected(&stream.map, |unit| rule.keeps(unit)).unwrap()
    };
    let mut client = Client::of(stream);
    for range in tier(4).ranges() {
        client
            .receive_at(range.start, part(&stream.bytes, range))
            .unwrap();
    }
    let head = motion(&client).head().unwrap().clone();
    assert!(client.told().1 && head.access_units > 4);
    // The finest tier of the second access unit alone.
    let of_second = bytes_of(&stream.map.children[2]);
    let finer = difference(&tier(4), &tier(0));
    let finer = finer
        .ranges()
        .iter()
        .filter(|r| of_second.contains(&r.start));
    for range in finer {
        let before = client.shown();
        let changed = client
            .receive_at(range.start, part(&stream.bytes, range))
            .unwrap();
        assert_eq!(changed, head.frames_of(1));
        let differs = |frame: usize| client.shown()[frame] != before[frame];
        assert!(changed.clone().any(differs));
    }
    let mut whole = Client::of(stream);
    whole.receive(&stream.bytes).unwrap();
    assert_eq!(
        client.shown()[head.frames_of(1)],
        whole.shown()[head.frames_of(1)]
    );
}

#[test]
fn what_is_not_there_rests_or_holds() {
    let stream = &streams()[1];
    let (_, units) = head_and_units(stream);
    let mut client = with_head(stream);
    let reference = client.shown();
    assert!(reference.iter().all(|frame| *frame == reference[0]));
    let head = motion(&client).head().unwrap().clone();
    assert_eq!((client.told().0, client.told().1), (0, false));
    // An access unit in the middle: before it the reference, after it its last frame.
    let of_middle = units.iter().filter(|(number, _)| *number == 1);
    for (number, unit) in of_middle.clone() {
        client
            .receive_units(*number, part(&stream.bytes, unit))
            .unwrap();
    }
    let shown = client.shown();
    let middle = head.frames_of(1);
    assert_eq!(shown[..middle.start], reference[..middle.start]);
    assert!(
        shown[middle.end..]
            .iter()
            .all(|frame| *frame == shown[middle.end - 1])
    );
    assert_ne!(shown[middle.start], reference[0]);
    // An access unit that is there without units rests, and with it what follows.
    assert_eq!(
        client.receive_units(2, &[]).unwrap(),
        head.frames_of(2).start..head.frames
    );
    assert_eq!(client.shown()[middle.end..], reference[middle.end..]);
    assert_eq!(client.receive_units(2, &[]).unwrap(), 0..0);
    assert!(client.receive_units(head.access_units, &[]).is_err());
    // A tier waits for the coarser one.
    let first = |tier| {
        let of_first = stream.map.children[1].children.iter();
        let unit = of_first
            .clone()
            .find(|u| u.marker("tier") == Some(tier) && u.marker("joint") == Some(0));
        part(&stream.bytes, &bytes_of(unit.unwrap())).to_vec()
    };
    let (mut rising, mut falling) = (with_head(stream), with_head(stream));
    for tier in [4, 3] {
        rising.receive_units(0, &first(tier)).unwrap();
    }
    falling.receive_units(0, &first(3)).unwrap();
    assert_eq!(falling.shown(), reference);
    falling.receive_units(0, &first(4)).unwrap();
    assert_eq!(falling.shown(), rising.shown());
    assert_ne!(falling.shown(), reference);
}

#[test]
fn access_units_from_the_last_to_the_first_turn_the_signs_of_those_after_them() {
    let stream = &streams()[3];
    let (_, units) = head_and_units(stream);
    let mut client = with_head(stream);
    let head = motion(&client).head().unwrap().clone();
    let mut turned = 0;
    for (number, unit) in units.iter().rev() {
        let mut frames = 0..0;
        checked(&mut client, |client| {
            let changed = client.receive_units(*number, part(&stream.bytes, unit))?;
            frames = changed.clone();
            Ok(changed)
        });
        assert_eq!(frames.start, head.frames_of(*number).start);
        turned += usize::from(frames.end > head.frames_of(*number).end);
    }
    // Some access units after one followed it with another sign.
    assert!(turned > 2, "{turned} of {}", units.len());
    let mut whole = Client::of(stream);
    whole.receive(&stream.bytes).unwrap();
    assert_eq!(client.shown(), whole.shown());
    // Neighbours have the nearest sign, so that they can be blended.
    let clip = motion(&client).clip().unwrap();
    for track in &clip.tracks().rotations {
        assert!(
            track
                .values
                .windows(2)
                .all(|pair| pair[0].dot(pair[1]) >= 0.0)
        );
    }
}

#[test]
fn bytes_wait_for_the_lengths_before_them_and_may_come_again() {
    let stream = &streams()[0];
    let mut client = Client::of(stream);
    let parts = &stream.map.children;
    // From the last access unit to the first, and the head.
    for access_unit in parts[1..].iter().rev() {
        let range = bytes_of(access_unit);
        let (first, second) = (range.start..range.start + 9, range.start + 9..range.end);
        for piece in [first, second] {
            let changed = client
                .receive_at(piece.start, part(&stream.bytes, &piece))
                .unwrap();
            assert!(changed.is_empty() && client.shown().is_empty());
        }
    }
    let head = bytes_of(&parts[0]);
    let first = bytes_of(&parts[0].children[0]).start;
    let early = client.clone();
    assert!(
        client
            .receive_at(0, &stream.bytes[..first as usize - 1])
            .is_err()
    );
    assert_eq!(client.told(), early.told());
    client.receive_at(0, part(&stream.bytes, &head)).unwrap();
    let mut whole = Client::of(stream);
    whole.receive(&stream.bytes).unwrap();
    assert_eq!(
        (client.shown(), client.told()),
        (whole.shown(), whole.told())
    );
    for bytes in [&stream.bytes[..], part(&stream.bytes, &bytes_of(&parts[2]))] {
        let offset = if bytes.len() == stream.bytes.len() {
            0
        } else {
            bytes_of(&parts[2]).start
        };
        assert_eq!(client.receive_at(offset, bytes).unwrap(), 0..0);
    }
    assert_eq!(client.shown(), whole.shown());
    let behind = client.receive_at(stream.bytes.len() as u64, &[1]);
    assert!(
        behind
            .unwrap_err()
            .to_string()
            .contains("after the last access unit")
    );
}

#[test]
fn in_order_and_in_any_order_are_one_state() {
    let stream = &streams()[0];
    let parts = &stream.map.children;
    let middle = bytes_of(&parts[3]);
    let mut client = Client::of(stream);
    let half = (middle.start + middle.end) as usize / 2;
    client.receive(&stream.bytes[..half]).unwrap();
    // What is still to come in order comes otherwise, and then again.
    for access_unit in parts[3..].iter() {
        client
            .receive_at(
                bytes_of(access_unit).start,
                part(&stream.bytes, &bytes_of(access_unit)),
            )
            .unwrap();
    }
    assert!(!client.told().1, "one is still arriving");
    client.receive(&stream.bytes[half..]).unwrap();
    let mut whole = Client::of(stream);
    whole.receive(&stream.bytes).unwrap();
    assert_eq!(
        (client.shown(), client.told()),
        (whole.shown(), whole.told())
    );
}

#[test]
fn a_damaged_unit_changes_nothing_and_its_byte_is_told() {
    for stream in [&streams()[0], &streams()[4]] {
        let (_, units) = head_and_units(stream);
        let mut client = with_head(stream);
        let mut dice = Dice::new(7);
        for (number, unit) in shuffled(units, &mut dice).into_iter().take(60) {
            let good = part(&stream.bytes, &unit);
            let before = (client.shown(), client.told());
            let mut bad = good.to_vec();
            bad[dice.roll(good.len())] ^= 1 << dice.roll(8);
            let refused = client.receive_units(number, &bad).unwrap_err();
            let place = format!("(access unit {number})");
            let refused = refused.to_string();
            assert!(refused.starts_with("byte ") && refused.contains(&place));
            // The checksum is also of the access unit.
            assert!(client.receive_units(number + 1, good).is_err());
            let early = client.receive_units(number, &good[..good.len() - 1]);
            assert!(early.is_err());
            assert_eq!((client.shown(), client.told()), before);
            client.receive_units(number, good).unwrap();
        }
    }
}

#[test]
fn another_unit_of_the_same_number_is_refused() {
    // Version 1 has no checksums.
    let stream = &streams()[2];
    let (_, units) = head_and_units(stream);
    let mut client = with_head(stream);
    let mut refused = 0;
    for (number, unit) in &units {
        let good = part(&stream.bytes, unit);
        client.receive_units(*number, good).unwrap();
        let before = client.shown();
        let mut other = good.to_vec();
        *other.last_mut().unwrap() ^= 0x10;
        if good.len() > 3 {
            let why = client
                .receive_units(*number, &other)
                .unwrap_err()
                .to_string();
            assert!(why.contains("other bytes"), "{why}");
            refused += 1;
        }
        assert!(client.receive_units(*number, good).unwrap().is_empty());
        assert_eq!(client.shown(), before);
    }
    assert!(refused > 20);
}

#[test]
fn bytes_that_wait_are_limited() {
    let stream = &streams()[0];
    let limits = StreamLimits {
        bytes: stream.bytes.len() as u64 + 2,
        ..LIMITS
    };
    let mut client = MotionReceiver::new(&asset().rig, &limits);
    let middle = stream.bytes.len() / 2;
    // The same bytes wait once, others until the limit.
    for _ in 0..3 {
        client
            .receive_at(middle as u64, &stream.bytes[middle..])
            .unwrap();
    }
    let more = client.receive_at(middle as u64 - 5, &stream.bytes[middle - 5..]);
    assert!(
        matches!(more, Err(StreamError::LimitExceeded { .. })),
        "{more:?}"
    );
    let far = client.receive_at(limits.bytes, &[0]);
    assert!(
        matches!(far, Err(StreamError::LimitExceeded { .. })),
        "{far:?}"
    );
}

#[test]
fn mutated_units_in_any_order_never_panic() {
    let mutations = Mutations {
        edits: &[
            Edit::SetByte,
            Edit::FlipBit,
            Edit::Repeat(30),
            Edit::Delete(30),
        ],
        most: 3,
    };
    for stream in streams() {
        let ranges: Vec<Range<u64>> = {
            let mut all = ByteRanges::default();
            let mut ranges = Vec::new();
            for rule in [2, 1, 0].map(|tier| CutRule::default().at_least("tier", tier)) {
                let want = selected(&stream.map, |unit| rule.keeps(unit)).unwrap();
                ranges.extend(difference(&all, &want).ranges().iter().cloned());
                all = all.union(&want);
            }
            ranges
        };
        let mut dice = Dice::new(3);
        let read = |bytes: &[u8]| {
            let mut client = Client::of(stream);
            let mut is_good = true;
            for range in shuffled(ranges.clone(), &mut dice) {
                let end = (range.end as usize).min(bytes.len());
                let piece = bytes.get(range.start as usize..end).unwrap_or_default();
                is_good &= client.receive_at(range.start, piece).is_ok();
            }
            client.shown();
            is_good && client.told().1
        };
        assert!(mutations.read_of(&stream.bytes, 60, read) < 60);
    }
}

//! MP4 files around streams: layout, round trips, files of other writers, hostile files.

use crate::cut_streams::check_golden;
use articula_core::fap_table::FAP_COUNT;
use articula_mutate::{Edit, Mutations, cut_off};
use articula_stream::fba::{FbaClip, FbaFrame, FbaOptions};
use articula_stream::mp4::{Mp4Track, is_mp4, read, write};
use articula_stream::{CutRule, FaceFrame, FrameRate, StreamKind, StreamLimits, Unit, cut};
use articula_stream::{abp1, abp2, afp1};
use std::ops::Range;

const LIMITS: StreamLimits = StreamLimits {
    bytes: 1 << 20,
    elements: 1 << 20,
};
const ABP1: &[u8] = include_bytes!("../golden/wave.abp");
const ABP2: &[u8] = include_bytes!("../golden/walk.abp");
const AFP1: &[u8] = include_bytes!("../golden/wave.afp");
const AFP2: &[u8] = include_bytes!("../golden/wave2.afp");

/// Two frames of a face that opens its jaw, with three numbers between them.
fn fba() -> Vec<u8> {
    let frame = |number: u32| {
        let mut face = FaceFrame::NEUTRAL;
        face.low[0] = 40 * number as i32;
        FbaFrame { number, face }
    };
    let clip = FbaClip {
        rate: FrameRate::nearest(29.97).unwrap(),
        time_code: None,
        coded: std::array::from_fn::<bool, FAP_COUNT, _>(|i| i == 2),
        frames: vec![frame(0), frame(4)],
    };
    articula_stream::fba::write(&clip, &FbaOptions::default()).unwrap()
}

/// The content of the first box at a path, by its own walk through the bytes.
fn inside(file: &[u8], path: &str) -> Range<usize> {
    let mut within = 0..file.len();
    for name in path.split('/') {
        let mut at = within.start;
        within = loop {
            let mut size = u32::from_be_bytes(file[at..at + 4].try_into().unwrap()) as usize;
            let mut head = 8;
            if size == 1 {
                let large = file[at + 8..at + 16].try_into().unwrap();
                (size, head) = (u64::from_be_bytes(large) as usize, 16);
            }
            if file[at + 4..at + 8] == *name.as_bytes() {
                break at + head..at + size;
            }
            at += size;
            assert!(at < within.end, "no box {name} of {path}");
        };
    }
    within
}

/// A file as other programs write it: without the box of checksums, and without the brand that
/// promises it. Offsets into the data move.
fn by_another_writer(streams: &[&[u8]]) -> Vec<u8> {
    let file = write(streams, &LIMITS).unwrap();
    let checksums = inside(&file, "uuid");
    let brands = inside(&file, "ftyp");
    let shift = checksums.len() + 8 + 4;
    let mut ftyp = file[..brands.end - 4].to_vec();
    assert_eq!(file[brands.end - 4..brands.end], *b"artc");
    ftyp[3] -= 4;
    let mut moov = file[brands.end..checksums.start - 8].to_vec();
    // Each track has one table of offsets.
    let tables: Vec<usize> = (4..moov.len())
        .filter(|at| moov[at - 4..].starts_with(b"stco"))
        .collect();
    assert_eq!(tables.len(), streams.len());
    for at in tables {
        let number =
            |moov: &[u8], at: usize| u32::from_be_bytes(moov[at..at + 4].try_into().unwrap());
        let count = number(&moov, at + 4) as usize;
        for row in (0..count).map(|row| at + 8 + 4 * row) {
            let offset = number(&moov, row) - shift as u32;
            moov[row..row + 4].copy_from_slice(&offset.to_be_bytes());
        }
    }
    [ftyp, moov, file[checksums.end..].to_vec()].concat()
}

const STBL: &str = "moov/trak/mdia/minf/stbl";

/// The whole numbers of a table of a file with one track, from its `first` one.
fn table(file: &[u8], name: &str, first: usize) -> Vec<u32> {
    let body = &file[inside(file, &format!("{STBL}/{name}"))];
    let (numbers, _) = body[4 * first..].as_chunks::<4>();
    numbers.iter().map(|n| u32::from_be_bytes(*n)).collect()
}

/// A file of which one number of a box is another.
fn with(file: &[u8], path: &str, number: usize, value: u32) -> Vec<u8> {
    let at = inside(file, path).start + 4 * number;
    let mut file = file.to_vec();
    file[at..at + 4].copy_from_slice(&value.to_be_bytes());
    file
}

fn refused(file: &[u8]) -> String {
    let tracks = match read(file, &LIMITS) {
        Err(why) => return why.to_string(),
        Ok(tracks) => tracks,
    };
    tracks[0].stream(file).unwrap_err().to_string()
}

fn only_track(file: &[u8]) -> Mp4Track {
    let tracks = read(file, &LIMITS).unwrap();
    let [track] = &tracks[..] else {
        panic!("{} tracks", tracks.len());
    };
    track.clone()
}

#[test]
fn every_stream_comes_back_to_the_byte() {
    let fba = fba();
    let expected = [
        (ABP1, StreamKind::Abp1, "urn:articula:abp1"),
        (ABP2, StreamKind::Abp2, "urn:articula:abp2"),
        (AFP1, StreamKind::Afp1, "urn:articula:afp1"),
        (AFP2, StreamKind::Afp2, "urn:articula:afp2"),
        (&fba, StreamKind::Fba, "urn:articula:fba"),
    ];
    for (stream, kind, uri) in expected {
        let file = write(&[stream], &LIMITS).unwrap();
        assert!(is_mp4(&file));
        let track = only_track(&file);
        assert_eq!((track.kind, track.form.as_str()), (Some(kind), uri));
        assert_eq!((track.id, track.bytes()), (1, stream.len()));
        assert!(track.stream(&file).unwrap() == stream, "{kind:?}");
        assert_eq!(StreamKind::of(stream), Some(kind));
    }
    let streams = expected.map(|(stream, ..)| stream);
    let file = write(&streams, &LIMITS).unwrap();
    let tracks = read(&file, &LIMITS).unwrap();
    for (i, (track, (stream, kind, _))) in tracks.iter().zip(expected).enumerate() {
        assert_eq!((track.id, track.kind), (i as u32 + 1, Some(kind)));
        assert!(track.stream(&file).unwrap() == stream, "{kind:?} of five");
    }
}

#[test]
fn samples_are_the_access_units_of_the_map() {
    let maps = [
        (ABP1, abp1::unit(ABP1, &LIMITS)),
        (ABP2, abp2::motion_map(ABP2, &LIMITS)),
        (AFP1, afp1::unit(AFP1, &LIMITS)),
        (AFP2, abp2::motion_map(AFP2, &LIMITS)),
    ];
    for (stream, map) in maps {
        let units = map.unwrap().children;
        let file = write(&[stream], &LIMITS).unwrap();
        let bytes = |unit: &Unit| (unit.bits.end - unit.bits.start) as u32 / 8;
        let sizes: Vec<u32> = units[1..].iter().map(bytes).collect();
        // Version and flags, a common size of 0, the number of samples.
        assert_eq!(table(&file, "stsz", 1)[..2], [0, sizes.len() as u32]);
        assert_eq!(table(&file, "stsz", 3), sizes);
        let track = only_track(&file);
        assert_eq!(track.samples, sizes.len() as u64);
        assert_eq!(track.bytes_head() as u32, bytes(&units[0]));
        // One chunk has them all.
        let first = inside(&file, "mdat").start as u32;
        assert_eq!(table(&file, "stco", 1), [1, first]);
        assert_eq!(table(&file, "stsc", 1), [1, 1, sizes.len() as u32, 1]);
        assert!(file[first as usize..] == stream[track.bytes_head()..]);
    }
}

#[test]
fn durations_are_the_frames_in_an_exact_timescale() {
    let timed = |stream: &[u8]| {
        let file = write(&[stream], &LIMITS).unwrap();
        let track = only_track(&file);
        let sum = (track.timescale, track.duration_ticks);
        (sum, table(&file, "stts", 2))
    };
    let head = abp2::MotionHead::open(ABP2, &LIMITS).unwrap();
    let ((timescale, ticks), _) = timed(ABP2);
    assert_eq!(f64::from(timescale), f64::from(head.rate_hz));
    assert_eq!(ticks, head.frames as u64);
    // 16 frames in all access units but the last.
    let read = afp1::read(AFP1, &Default::default(), &LIMITS).unwrap().clip;
    let [per_sec, secs] = read.rate.fraction();
    let frames = read.frames.len() as u32;
    let ((timescale, ticks), table) = timed(AFP1);
    assert_eq!((timescale, ticks), (per_sec, u64::from(frames * secs)));
    assert_eq!(
        table,
        [frames / 16, 16 * secs, 1, frames % 16 * secs],
        "{frames} frames"
    );
    // Frames 0 to 4 of a face at 30000/1001 frames per second.
    assert_eq!(timed(&fba()), ((30_000, 5 * 1001), vec![1, 5 * 1001]));
}

/// A motion of a bone that turns.
fn abp1_clip(frames: usize) -> abp1::Abp1Clip {
    let turns = (0..frames).map(|f| [0.01 * f as f32, 0.0, 0.0]).collect();
    abp1::Abp1Clip {
        name: "turn".into(),
        bones: vec![abp1::Bone {
            name: "root".into(),
            parent: None,
            center: [0.0; 3],
            loa: 0,
            region: 4,
        }],
        rate: FrameRate::nearest(24.5).unwrap(),
        frames,
        tracks: vec![abp1::BoneTracks::default().with(abp1::TrackKind::Rotation, turns)],
    }
}

#[test]
fn interpolated_frames_count_and_repeated_ones_do_not() {
    for frames in [1, 2, 47, 48, 49, 96, 97, 200] {
        for interpolated in [0, 2] {
            let options = abp1::Abp1Options {
                interpolated,
                ..abp1::Abp1Options::default()
            };
            let stream = abp1::write(&abp1_clip(frames), &options).unwrap();
            let file = write(&[&stream], &LIMITS).unwrap();
            let track = only_track(&file);
            let place = format!("{frames} frames, {interpolated} interpolated");
            // 24.5 frames per second are 49 in 2 s.
            assert_eq!(track.timescale, 49, "{place}");
            assert_eq!(track.duration_ticks, 2 * frames as u64, "{place}");
            // Two coded frames with the interpolated ones between them.
            let stride = u64::from(interpolated) + 1;
            let coded = (frames as u64 - 1).div_ceil(stride) + 1;
            assert_eq!(track.samples, coded.div_ceil(16), "{place}");
        }
    }
}

#[test]
fn a_stream_that_was_cut_is_boxed_like_any_other() {
    let map = abp2::motion_map(ABP2, &LIMITS).unwrap();
    let rule = CutRule::default().at_least("tier", 2);
    let cut = cut(ABP2, &map, |unit| rule.keeps(unit)).unwrap();
    let file = write(&[&cut.bytes], &LIMITS).unwrap();
    let track = only_track(&file);
    assert!(track.stream(&file).unwrap() == cut.bytes);
    let whole = only_track(&write(&[ABP2], &LIMITS).unwrap());
    assert_eq!(track.duration_ticks, whole.duration_ticks);
    // Of a stream whose access units have been removed the head is left.
    let head = &AFP1[..map_head(AFP1)];
    let file = write(&[head], &LIMITS).unwrap();
    let track = only_track(&file);
    assert_eq!((track.samples, track.duration_ticks), (0, 0));
    assert!(track.stream(&file).unwrap() == head);
}

fn map_head(stream: &[u8]) -> usize {
    let map = afp1::unit(stream, &LIMITS).unwrap();
    map.children[0].bits.end as usize / 8
}

#[test]
fn samples_of_two_tracks_follow_each_other_in_time() {
    let file = write(&[ABP2, AFP1], &LIMITS).unwrap();
    let data = inside(&file, "mdat");
    // The walk has a second, each access unit of the face 0.64 s: the first samples of both tracks
    // come before the second of either.
    let map = abp2::motion_map(ABP2, &LIMITS).unwrap();
    let first =
        &ABP2[(map.children[1].bits.start / 8) as usize..(map.children[1].bits.end / 8) as usize];
    assert!(file[data.clone()].starts_with(first));
    let face = &AFP1[map_head(AFP1)..];
    assert!(file[data][first.len()..].starts_with(&face[..40]));
}

#[test]
fn the_layout_is_the_stored_one() {
    check_golden("walk.mp4", &write(&[ABP2, AFP2], &LIMITS).unwrap());
}

#[test]
fn a_file_without_checksums_is_still_read() {
    // Written before there were any, of streams of version 1.
    let file = include_bytes!("../golden/walk-1.mp4");
    let tracks = read(file, &LIMITS).unwrap();
    let streams = [
        &include_bytes!("../golden/walk-1.abp")[..],
        include_bytes!("../golden/wave2-1.afp"),
    ];
    assert_eq!(tracks.len(), streams.len());
    for (track, stream) in tracks.iter().zip(streams) {
        assert!(track.stream(file).unwrap() == stream);
    }
    let file = by_another_writer(&[ABP2]);
    assert!(only_track(&file).stream(&file).unwrap() == ABP2);
}

#[test]
fn checksums_of_a_file_are_in_a_box_of_their_own() {
    let file = write(&[ABP2], &LIMITS).unwrap();
    let checksums = inside(&file, "uuid");
    let moov = inside(&file, "moov");
    let mdat = inside(&file, "mdat");
    assert_eq!(
        (checksums.start, checksums.end),
        (moov.end + 8, mdat.start - 8)
    );
    // CRC-32 bit by bit, reflected, of all that is no sample, and of the samples.
    let crc32 = |bytes: &[u8]| {
        let bits = |crc: u32, byte: &u8| {
            let shifted = |crc: u32, _| crc >> 1 ^ if crc & 1 == 1 { 0xedb8_8320 } else { 0 };
            (0..8).fold(crc ^ u32::from(*byte), shifted)
        };
        !bytes.iter().fold(u32::MAX, bits)
    };
    let others = [&file[..moov.end], &file[mdat.start - 8..mdat.start]].concat();
    let told = &file[checksums.end - 8..checksums.end];
    assert_eq!(told[..4], crc32(&others).to_be_bytes());
    assert_eq!(told[4..], crc32(&file[mdat]).to_be_bytes());
    // Without the box the brand is a promise that is not kept; twice is once too often.
    let box_ = checksums.start - 8..checksums.end;
    let without = [&file[..box_.start], &file[box_.end..]].concat();
    assert!(refused(&without).contains("but there is none"));
    let twice = [&file[..box_.end], &file[box_.start..]].concat();
    assert!(refused(&twice).contains("a second box with checksums"));
    let mut short = file.clone();
    short[box_.start + 3] -= 4;
    short.drain(box_.end - 4..box_.end);
    assert!(refused(&short).contains("another size"));
    // A further box is one that the checksum does not know.
    let free = [&file[..], &boxed("free", &[0; 5])].concat();
    assert!(refused(&free).contains("the checksum of the boxes"));
}

/// A box around a content.
fn boxed(name: &str, body: &[u8]) -> Vec<u8> {
    let size = (8 + body.len()) as u32;
    [&size.to_be_bytes(), name.as_bytes(), body].concat()
}

/// Replaces a box by others; the sizes of those around it are renewed.
fn replaced(file: &[u8], path: &str, new: &[u8]) -> Vec<u8> {
    let old = inside(file, path);
    let mut out = file.to_vec();
    out.splice(old.start - 8..old.end, new.iter().copied());
    let parents: Vec<usize> = path.match_indices('/').map(|(at, _)| at).collect();
    for end in parents {
        let start = inside(file, &path[..end]).start - 8;
        let size = u32::from_be_bytes(file[start..start + 4].try_into().unwrap());
        let size = size + new.len() as u32 - (old.len() + 8) as u32;
        out[start..start + 4].copy_from_slice(&size.to_be_bytes());
    }
    out
}

#[test]
fn other_writers_may_arrange_boxes_in_other_ways() {
    let file = by_another_writer(&[ABP2]);
    let [ftyp, moov, mdat] = ["ftyp", "moov", "mdat"].map(|name| {
        let body = inside(&file, name);
        file[body.start - 8..body.end].to_vec()
    });
    let chunk = format!("{STBL}/stco");
    let back = |file: &[u8]| only_track(file).stream(file).unwrap() == ABP2;
    // The data first, in a box with a size of 64 bits, and free space between.
    let large = [
        &[0, 0, 0, 1][..],
        b"mdat",
        &(mdat.len() as u64 + 8).to_be_bytes(),
        &mdat[8..],
    ]
    .concat();
    let free = boxed("free", &[0; 5]);
    let first = [&ftyp[..], &free, &large, &moov].concat();
    let start = (ftyp.len() + free.len() + 16) as u32;
    assert!(back(&with(&first, &chunk, 2, start)));
    // The data last, in a box that goes to the end of the file.
    let mut open = file.clone();
    let at = inside(&file, "mdat").start - 8;
    open[at..at + 4].fill(0);
    assert!(back(&open));
    // Offsets of 64 bits.
    let shift = 4;
    let start = (inside(&file, "mdat").start + shift) as u64;
    let co64 = [&[0, 0, 0, 0, 0, 0, 0, 1][..], &start.to_be_bytes()].concat();
    assert!(back(&replaced(&file, &chunk, &boxed("co64", &co64))));
    // A track of a video beside it, which has no data of ours.
    let mut video = file[inside(&file, "moov/trak")].to_vec();
    let entry = inside(&boxed("trak", &video), "trak/mdia/minf/stbl/stsd").start;
    video[entry + 4..entry + 8].copy_from_slice(b"abcd");
    let trak = inside(&file, "moov/trak");
    let both = [&boxed("trak", &video), &file[trak.start - 8..trak.end]].concat();
    let both = replaced(&file, "moov/trak", &both);
    let tracks = read(&both, &LIMITS).unwrap();
    assert_eq!((tracks[0].kind, tracks[0].form.as_str()), (None, "abcd"));
    assert!(
        tracks[0]
            .stream(&both)
            .unwrap_err()
            .to_string()
            .contains("abcd")
    );
    assert_eq!(tracks[1].kind, Some(StreamKind::Abp2));
}

#[test]
fn samples_of_equal_size_may_have_one_number() {
    // FBA is one sample, so its table can say the size of all.
    let stream = fba();
    let file = by_another_writer(&[&stream]);
    let size = format!("{STBL}/stsz");
    let one = boxed(
        "stsz",
        &[[0; 4], (stream.len() as u32).to_be_bytes(), [0, 0, 0, 1]].concat(),
    );
    let fixed = replaced(&file, &size, &one);
    let start = inside(&fixed, "mdat").start as u32;
    let fixed = with(&fixed, &format!("{STBL}/stco"), 2, start);
    assert!(only_track(&fixed).stream(&fixed).unwrap() == stream);
    // The same in a table that says there are four thousand million of them.
    let many = with(&fixed, &size, 2, u32::MAX - 1);
    let many = with(&many, &format!("{STBL}/stts"), 2, u32::MAX - 1);
    let many = with(&many, &format!("{STBL}/stsc"), 3, u32::MAX - 1);
    let why = refused(&many);
    assert!(why.starts_with("track 1: chunk 1 of"), "{why}");
}

#[test]
fn lying_tables_are_refused() {
    let file = by_another_writer(&[ABP2]);
    let at = |name: &str| format!("{STBL}/{name}");
    let at_dref = "moov/trak/mdia/minf/dinf/dref";
    let url = boxed("url ", b"\0\0\0\0a.mp4\0");
    let elsewhere = boxed("dref", &[&[0, 0, 0, 0, 0, 0, 0, 1][..], &url].concat());
    let cases = [
        (with(&file, &at("stsz"), 3, u32::MAX), "chunk 1 of"),
        (
            with(&file, &at("stsz"), 2, u32::MAX),
            "box stsz: the box ends early",
        ),
        (with(&file, &at("stsz"), 1, 1 << 31), "chunk 1 of"),
        (
            with(&file, &at("stco"), 1, u32::MAX),
            "box stco: the box ends early",
        ),
        (with(&file, &at("stco"), 2, u32::MAX), "the file has"),
        (
            with(&file, &at("stsc"), 1, u32::MAX),
            "box stsc: the box ends early",
        ),
        (with(&file, &at("stsc"), 2, 0), "box stsc"),
        (with(&file, &at("stsc"), 2, 2), "expected to be 1"),
        (with(&file, &at("stsc"), 3, u32::MAX), "Sample count"),
        (with(&file, &at("stsc"), 4, 7), "missing sample entry"),
        (with(&file, &at("stts"), 2, u32::MAX), "overflows u32"),
        (with(&file, &at("stsd"), 1, 2), "box stsd"),
        (with(&file, "moov/trak/mdia/mdhd", 3, 0), "box mdhd"),
        (replaced(&file, at_dref, &elsewhere), "another file"),
    ];
    for (number, (file, expected)) in cases.into_iter().enumerate() {
        let why = refused(&file);
        assert!(why.contains(expected), "case {number}: {why}");
    }
}

#[test]
fn samples_elsewhere_in_the_file_are_a_matter_of_the_decoder() {
    let file = by_another_writer(&[ABP2]);
    let file = with(&file, &format!("{STBL}/stco"), 2, 0);
    let stream = only_track(&file).stream(&file).unwrap();
    assert!(stream != ABP2 && stream.len() == ABP2.len());
    assert!(abp2::motion_map(&stream, &LIMITS).is_err());
}

#[test]
fn sizes_and_forms_of_files_are_checked() {
    let file = by_another_writer(&[ABP2]);
    let moov = inside(&file, "moov");
    let cases = [
        (Vec::new(), "no box moov"),
        (file[..moov.start - 8].to_vec(), "no box moov"),
        (file[..file.len() - 1].to_vec(), "box mdat of"),
        (
            [&file[..], &file[moov.start - 8..moov.end]].concat(),
            "a second box moov",
        ),
        ([&file[..], &boxed("moof", &[])].concat(), "fragments"),
        (
            [&file[..], &[0, 0, 0, 7], b"free"].concat(),
            "cut off or malformed",
        ),
        ([&file[..], &[0; 3]].concat(), "cut off or malformed"),
    ];
    for (number, (file, expected)) in cases.into_iter().enumerate() {
        let why = refused(&file);
        assert!(why.contains(expected), "case {number}: {why}");
    }
    let small = StreamLimits {
        bytes: 100,
        ..LIMITS
    };
    assert!(read(&file, &small).is_err());
    // Another stream than the URI says.
    let uri = inside(&file, "moov/trak/mdia/minf/stbl/stsd").start + 16;
    let at = file[uri..]
        .windows(9)
        .position(|w| w == b"ula:abp2\0")
        .unwrap()
        + uri;
    let mut other = file.clone();
    other[at + 7] = b'1';
    let why = refused(&other);
    assert!(why.contains("says ABP-1"), "{why}");
    // A URI of somebody else.
    other[at + 7] = b'9';
    let track = only_track(&other);
    assert_eq!(
        (track.kind, track.form.as_str()),
        (None, "urn:articula:abp9")
    );
}

#[test]
fn tracks_that_share_bytes_are_refused() {
    let file = by_another_writer(&[ABP2]);
    let trak = inside(&file, "moov/trak");
    let trak = &file[trak.start - 8..trak.end];
    let many = replaced(&file, "moov/trak", &trak.repeat(40));
    let why = read(&many, &LIMITS).unwrap_err().to_string();
    assert!(
        why.contains("together exceed the file") || why.contains("the file has"),
        "{why}"
    );
}

#[test]
fn what_is_no_stream_is_not_boxed() {
    for (streams, expected) in [
        (&[][..], "at least one"),
        (&[&b"RIFF"[..]], "none of the streams"),
        (&[b""], "none of the streams"),
        (&[&ABP2[..ABP2.len() - 1]], "unexpected end"),
        (&[&AFP1[..AFP1.len() - 1]], "byte"),
    ] {
        let why = write(streams, &LIMITS).unwrap_err().to_string();
        assert!(why.contains(expected), "{why}");
    }
}

#[test]
fn any_bytes_end_with_tracks_or_an_error() {
    let file = by_another_writer(&[ABP2, AFP2]);
    let check = |bytes: &[u8]| {
        let Ok(tracks) = read(bytes, &LIMITS) else {
            return false;
        };
        let of_all: usize = tracks.iter().map(Mp4Track::bytes).sum();
        assert!(
            of_all <= 2 * bytes.len(),
            "samples and heads are bytes of the file"
        );
        for track in &tracks {
            if let Ok(stream) = track.stream(bytes) {
                assert_eq!(stream.len(), track.bytes());
                assert_eq!(StreamKind::of(&stream), track.kind);
            }
        }
        true
    };
    let moov = inside(&file, "moov");
    // Every length up to the data, and then a few.
    let lengths = cut_off(&file).enumerate();
    for (length, cut) in lengths {
        if length < moov.end || length % 97 == 0 {
            check(cut);
        }
    }
    let mutations = Mutations {
        edits: &[
            Edit::FlipBit,
            Edit::SetByte,
            Edit::SetOf(&[0, 1, 0x7f, 0xff]),
            Edit::Delete(20),
            Edit::Repeat(20),
            Edit::Truncate,
        ],
        most: 3,
    };
    // Most of a file is data, of which a reader sees nothing: the head alone is mutated.
    let mut good = 0;
    let read_of = |head: &[u8]| {
        let whole = [head, &file[moov.end..]].concat();
        let is_good = check(&whole);
        good += usize::from(is_good);
        is_good
    };
    mutations.read_of(&file[..moov.end], 4000, read_of);
    assert!(good > 100 && good < 3900, "{good}");
}

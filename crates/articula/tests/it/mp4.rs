//! MP4 files with streams, opened by the library: by their bytes, and harmed.

use crate::crowd::human;
use articula::clip_streams::mp4::{is_mp4, take, tracks, write};
use articula::clip_streams::{StreamKind, clip_name};
use articula::convert::{AbpProfile, AfpProfile, ConvertOptions, write_faps};
use articula::{
    CharacterFile, Data, DataFormat, Executor, Format, OpenOptions, Result, convert, open,
    open_data,
};
use articula_formats::Limits;
use articula_formats::mpeg4::fap::{FapClip, FapFrame};
use articula_mutate::{Edit, Mutations, cut_off};
use articula_stream::abp1::Abp1Options;

fn opened(bytes: &[u8], name: &str) -> Result<CharacterFile> {
    let nothing = &mut |_: &str| Err("nothing lies beside it".into());
    open(bytes, name, &OpenOptions::default(), nothing)
}

/// The walk of the reference human as ABP-1, in a file.
fn walk() -> Vec<u8> {
    let options = ConvertOptions {
        abp: Some(AbpProfile::Abp1(Abp1Options::default())),
        ..ConvertOptions::default()
    };
    let written = convert(human(), Format::Mp4, &options, &Executor::default());
    written.unwrap().written.bytes
}

/// A face that opens its jaw, as AFP-2, in a file.
fn face() -> (FapClip, Vec<u8>) {
    let frame = |number: u32| {
        let mut frame = FapFrame {
            number,
            ..FapFrame::default()
        };
        frame.low[0] = 20 * number as i32;
        frame
    };
    let clip = FapClip {
        name: "jaw".into(),
        rate_hz: 25.0,
        coded: std::array::from_fn(|i| i == 2),
        frames: (0..40).map(frame).collect(),
        bridge: None,
    };
    let written = write_faps(&clip, DataFormat::Mp4, &AfpProfile::default());
    let bytes = written.unwrap().bytes;
    (clip, bytes)
}

fn faps(file: &[u8]) -> Result<(FapClip, usize)> {
    let read = open_data(file, "a.mp4", DataFormat::Mp4, &OpenOptions::default())?;
    let Data::Fap(clip) = read.data else {
        panic!("another kind of data");
    };
    Ok((clip, read.warnings.len()))
}

#[test]
fn bytes_tell_an_mp4_file_and_what_moves_in_it() {
    let (walk, (clip, face)) = (walk(), face());
    let limits = Limits::default();
    assert!(is_mp4(&walk) && is_mp4(&face));
    for name in ["a.mp4", "a", "a.abp"] {
        let opened = opened(&walk, name).unwrap();
        assert_eq!((opened.format(), opened.bytes()), (Format::Mp4, walk.len()));
        assert_eq!(opened.character().clips.len(), 1);
        assert!(opened.warnings().is_empty());
    }
    assert_eq!(DataFormat::of_mp4(&walk, &limits), None);
    assert_eq!(DataFormat::of_mp4(&face, &limits), Some(DataFormat::Mp4));
    let why = opened(&face, "a.mp4").unwrap_err().to_string();
    assert!(
        why.starts_with("a.mp4: the MP4 file has a stream of a face"),
        "{why}"
    );
    let why = faps(&walk).unwrap_err().to_string();
    assert!(
        why.contains("no track of the MP4 file is a stream of a face"),
        "{why}"
    );
    let (read, warnings) = faps(&face).unwrap();
    assert_eq!(
        (read.name, read.frames.len(), warnings),
        ("jaw".into(), clip.frames.len(), 0)
    );
}

#[test]
fn what_fits_is_taken_and_the_rest_is_told() {
    let (walk, (_, face)) = (walk(), face());
    let limits = Limits::default();
    let both = write(&[("walk.mp4", &walk), ("face.mp4", &face)], &limits).unwrap();
    assert_eq!(tracks(&both, &limits).unwrap().len(), 2);
    let body = opened(&both, "both.mp4").unwrap();
    assert_eq!(body.warnings().len(), 1);
    let warning = &body.warnings()[0];
    assert_eq!(warning.at, "track 2");
    assert!(
        warning.what.starts_with("AFP-2 is left out"),
        "{}",
        warning.what
    );
    assert_eq!(faps(&both).unwrap().1, 1);
    let taken = take(&both, &limits, StreamKind::is_of_face)
        .unwrap()
        .unwrap();
    assert_eq!(clip_name(&taken.bytes, &limits).unwrap(), "jaw");
    let fba = |kind| kind == StreamKind::Fba;
    assert!(take(&both, &limits, fba).unwrap().is_none());
    // An error names the part that is none.
    let why = write(&[("walk.mp4", &walk), ("b.glb", b"glTF")], &limits);
    let why = why.unwrap_err().to_string();
    assert!(why.starts_with("b.glb: byte 0"), "{why}");
}

#[test]
fn harmed_files_open_or_end_with_an_error() {
    let (walk, (_, face)) = (walk(), face());
    let limits = Limits::default();
    let both = write(&[("walk.mp4", &walk), ("face.mp4", &face)], &limits).unwrap();
    let read = |bytes: &[u8]| {
        let body = opened(bytes, "a.mp4").is_ok();
        body | faps(bytes).is_ok()
    };
    for (length, cut) in cut_off(&both).enumerate() {
        if length < 300 || length % 211 == 0 {
            assert!(!read(cut), "{length}");
        }
    }
    let mutations = Mutations {
        edits: &[
            Edit::FlipBit,
            Edit::SetOf(&[0, 1, 0x7f, 0xff]),
            Edit::Delete(9),
            Edit::Repeat(9),
        ],
        most: 2,
    };
    let good = mutations.read_of(&both, 300, read);
    assert!(good > 0 && good < 300, "{good}");
}

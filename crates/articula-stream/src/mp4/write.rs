//! Streams to a file: the movie box, then the samples in the order of time.

use super::checksums;
use super::samples::Samples;
use super::urim::Urim;
use crate::error::StreamError;
use crate::kind::StreamKind;
use crate::limits::StreamLimits;
use articula_core::Mismatch;
use shiguredo_mp4::boxes::{
    Brand, DinfBox, DrefBox, FtypBox, HdlrBox, MdhdBox, MdiaBox, MediaHeader, MinfBox, MoovBox,
    MvhdBox, NmhdBox, StblBox, StcoBox, StscBox, StscEntry, StsdBox, StszBox, SttsBox, SttsEntry,
    TkhdBox, TrakBox,
};
use shiguredo_mp4::{Either, Encode, FixedPointNumber, LanguageCode, Mp4FileTime};
use std::num::NonZeroU32;

/// Bytes of the header of the box `mdat`.
const MDAT_HEADER: usize = 8;
const ONE: NonZeroU32 = NonZeroU32::MIN;

/// Writes an MP4 file of streams: each is a track, in the given order, and comes back with the same
/// bytes ([`super::Mp4Track::stream`]).
///
/// The movie box comes first, then the samples in the order of time, so that what has arrived of a
/// file can be played.
///
/// # Errors
/// [`StreamError::Malformed`] if the bytes are none of the streams, or malformed,
/// [`StreamError::Unsupported`] for a frame rate that no timescale has exactly, and a [`Mismatch`] if
/// there is no stream or all together exceed 4 GiB.
pub fn write(streams: &[&[u8]], limits: &StreamLimits) -> Result<Vec<u8>, StreamError> {
    let tracks = streams.iter().map(|stream| Samples::of(stream, limits));
    let tracks = tracks.collect::<Result<Vec<_>, StreamError>>()?;
    if tracks.is_empty() {
        return Err(Mismatch::new("streams", "none, expected at least one").into());
    }
    let chunks = chunks(&tracks);
    let bytes = tracks.iter().flat_map(|track| &track.samples);
    let bytes: usize = bytes.map(|sample| sample.bytes.len()).sum();
    let ftyp = encoded(&FtypBox {
        major_brand: Brand::ISO6,
        minor_version: 0,
        compatible_brands: vec![
            Brand::ISO6,
            Brand::ISOM,
            Brand::new(*b"mp42"),
            checksums::BRAND,
        ],
    })?;
    // Offsets have a fixed width, so they do not move what they point to.
    let boxes = ftyp.len() + encoded(&moov(&tracks, &chunks, 0))?.len();
    let head = boxes + checksums::BYTES + MDAT_HEADER;
    let whole = u32::try_from(head + bytes);
    whole.map_err(|_| Mismatch::new("streams", "more than 4 GiB, which a file cannot hold"))?;
    let moov = encoded(&moov(&tracks, &chunks, head as u32))?;
    let mut mdat = ((MDAT_HEADER + bytes) as u32).to_be_bytes().to_vec();
    mdat.extend(b"mdat");
    for chunk in &chunks {
        for sample in &tracks[chunk.track].samples[chunk.first..][..chunk.samples] {
            mdat.extend(sample.bytes);
        }
    }
    let (header, samples) = mdat.split_at(MDAT_HEADER);
    let checksums = checksums::write(&[&ftyp, &moov, header], &[samples]);
    Ok([ftyp, moov, checksums, mdat].concat())
}

/// Samples of a track that are stored one after another.
struct Chunk {
    track: usize,
    first: usize,
    samples: usize,
    /// First byte, from the first of all samples.
    start: usize,
}

/// The chunks of all tracks in the order of the file: that of the times of the samples.
fn chunks(tracks: &[Samples<'_>]) -> Vec<Chunk> {
    let mut samples = Vec::new();
    for (number, track) in tracks.iter().enumerate() {
        let mut ticks = 0;
        for (index, sample) in track.samples.iter().enumerate() {
            samples.push((ticks, number, index));
            ticks += u64::from(sample.ticks);
        }
    }
    // Times are compared as fractions of a second.
    let scale = |track: usize| u128::from(tracks[track].timescale);
    samples.sort_by(|(a, of_a, _), (b, of_b, _)| {
        let [a, b] = [u128::from(*a) * scale(*of_b), u128::from(*b) * scale(*of_a)];
        a.cmp(&b).then(of_a.cmp(of_b))
    });
    let mut chunks: Vec<Chunk> = Vec::new();
    let mut start = 0;
    for (_, track, index) in samples {
        match chunks.last_mut().filter(|last| last.track == track) {
            Some(last) => last.samples += 1,
            None => chunks.push(Chunk {
                track,
                first: index,
                samples: 1,
                start,
            }),
        }
        start += tracks[track].samples[index].bytes.len();
    }
    chunks
}

/// The movie box; `first` is the offset of the first sample in the file.
fn moov(tracks: &[Samples<'_>], chunks: &[Chunk], first: u32) -> MoovBox {
    let timescale = scale_of(&tracks[0]);
    // In ticks of the movie, rounded up.
    let duration = |track: &Samples<'_>| {
        let ticks = u128::from(duration(track)) * u128::from(timescale.get());
        ticks.div_ceil(u128::from(track.timescale)) as u64
    };
    let trak = |(number, track): (usize, &Samples<'_>)| {
        let chunks = chunks.iter().filter(|chunk| chunk.track == number);
        trak(track, number as u32 + 1, duration(track), chunks, first)
    };
    MoovBox {
        mvhd_box: MvhdBox {
            creation_time: Mp4FileTime::default(),
            modification_time: Mp4FileTime::default(),
            timescale,
            duration: tracks.iter().map(duration).max().unwrap_or(0),
            rate: MvhdBox::DEFAULT_RATE,
            volume: MvhdBox::DEFAULT_VOLUME,
            matrix: MvhdBox::DEFAULT_MATRIX,
            next_track_id: tracks.len() as u32 + 1,
        },
        trak_boxes: tracks.iter().enumerate().map(trak).collect(),
        mvex_box: None,
        unknown_boxes: Vec::new(),
    }
}

fn trak<'a>(
    track: &Samples<'_>,
    track_id: u32,
    duration_in_movie: u64,
    chunks: impl Iterator<Item = &'a Chunk>,
    first: u32,
) -> TrakBox {
    TrakBox {
        tkhd_box: TkhdBox {
            flag_track_enabled: true,
            flag_track_in_movie: true,
            flag_track_in_preview: false,
            flag_track_size_is_aspect_ratio: false,
            creation_time: Mp4FileTime::default(),
            modification_time: Mp4FileTime::default(),
            track_id,
            duration: duration_in_movie,
            layer: TkhdBox::DEFAULT_LAYER,
            alternate_group: TkhdBox::DEFAULT_ALTERNATE_GROUP,
            volume: TkhdBox::DEFAULT_VIDEO_VOLUME,
            matrix: TkhdBox::DEFAULT_MATRIX,
            width: FixedPointNumber::new(0, 0),
            height: FixedPointNumber::new(0, 0),
        },
        edts_box: None,
        mdia_box: MdiaBox {
            mdhd_box: MdhdBox {
                creation_time: Mp4FileTime::default(),
                modification_time: Mp4FileTime::default(),
                timescale: scale_of(track),
                duration: duration(track),
                language: LanguageCode::UNDEFINED,
            },
            hdlr_box: HdlrBox {
                handler_type: *b"meta",
                name: [handler_name(track.kind).as_bytes(), &[0]].concat(),
            },
            minf_box: MinfBox {
                media_header: Some(MediaHeader::Nmhd(NmhdBox)),
                dinf_box: DinfBox {
                    dref_box: DrefBox::LOCAL_FILE,
                    unknown_boxes: Vec::new(),
                },
                stbl_box: stbl(track, chunks, first),
                unknown_boxes: Vec::new(),
            },
            unknown_boxes: Vec::new(),
        },
        unknown_boxes: Vec::new(),
    }
}

fn stbl<'a>(track: &Samples<'_>, chunks: impl Iterator<Item = &'a Chunk>, first: u32) -> StblBox {
    let mut stts: Vec<SttsEntry> = Vec::new();
    for sample in &track.samples {
        match stts
            .last_mut()
            .filter(|last| last.sample_delta == sample.ticks)
        {
            Some(last) => last.sample_count += 1,
            None => stts.push(SttsEntry {
                sample_count: 1,
                sample_delta: sample.ticks,
            }),
        }
    }
    let (mut stsc, mut chunk_offsets) = (Vec::<StscEntry>::new(), Vec::new());
    for (first_chunk, chunk) in (1..).filter_map(NonZeroU32::new).zip(chunks) {
        let sample_per_chunk = chunk.samples as u32;
        if stsc
            .last()
            .is_none_or(|last| last.sample_per_chunk != sample_per_chunk)
        {
            stsc.push(StscEntry {
                first_chunk,
                sample_per_chunk,
                sample_description_index: ONE,
            });
        }
        chunk_offsets.push(first.saturating_add(chunk.start as u32));
    }
    let sizes = track.samples.iter().map(|sample| sample.bytes.len() as u32);
    StblBox {
        stsd_box: StsdBox {
            entries: vec![Urim::of(track.kind, track.head).entry()],
        },
        stts_box: SttsBox { entries: stts },
        ctts_box: None,
        cslg_box: None,
        stsc_box: StscBox { entries: stsc },
        stsz_box: StszBox::Variable {
            entry_sizes: sizes.collect(),
        },
        stco_or_co64_box: Either::A(StcoBox { chunk_offsets }),
        // Without the box, every sample is a sync sample.
        stss_box: None,
        sdtp_box: None,
        unknown_boxes: Vec::new(),
    }
}

/// Duration of a track in its ticks.
fn duration(track: &Samples<'_>) -> u64 {
    track
        .samples
        .iter()
        .map(|sample| u64::from(sample.ticks))
        .sum()
}

fn scale_of(track: &Samples<'_>) -> NonZeroU32 {
    NonZeroU32::new(track.timescale).unwrap_or(ONE)
}

/// Name of the handler, for people who look into a file.
fn handler_name(kind: StreamKind) -> String {
    format!("Articula {}", kind.name())
}

fn encoded(written: &impl Encode) -> Result<Vec<u8>, StreamError> {
    let bytes = written.encode_to_vec();
    bytes.map_err(|e| Mismatch::new("boxes", e.reason).into())
}

//! The tracks of a file, and the streams in them.

use super::checksums::{self, TopBox};
use super::urim::Urim;
use crate::error::StreamError;
use crate::kind::StreamKind;
use crate::limits::StreamLimits;
use shiguredo_mp4::aux::SampleTableAccessor;
use shiguredo_mp4::boxes::{MoovBox, SampleEntry, StblBox, StszBox, TrakBox, UnknownBox};
use shiguredo_mp4::{BaseBox, BoxHeader, BoxSize, Decode, Error, ErrorKind};
use std::ops::Range;

/// A track of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Mp4Track {
    /// Its number in the file.
    pub id: u32,
    /// The stream in it; `None` if it holds something else.
    pub kind: Option<StreamKind>,
    /// What it holds: the URI of timed metadata, else the four letters of the sample entry, such as
    /// `avc1`.
    pub form: String,
    /// Number of samples.
    pub samples: u64,
    /// Ticks in a second, at least 1.
    pub timescale: u32,
    /// Sum of the durations of all samples, in ticks.
    pub duration_ticks: u64,
    /// What comes before the samples.
    head: Vec<u8>,
    /// Bytes of the file that hold its samples, in their order; none if it holds no stream.
    chunks: Vec<Range<usize>>,
}

/// Returns whether a file begins as an MP4 file does, with the box `ftyp`.
pub fn is_mp4(bytes: &[u8]) -> bool {
    bytes.get(4..8) == Some(b"ftyp")
}

/// Reads the tracks of a file, also those that hold none of the streams.
///
/// Tables of samples may have any form that the standard allows, except fragments of movies; edit
/// lists and composition offsets are ignored. A file that has checksums must agree with them. Memory is in proportion to the size of the file, also
/// that of the tables.
///
/// # Errors
/// [`StreamError::Malformed`] that names the byte or track and the box, [`StreamError::Unsupported`]
/// for movie fragments and samples that are in other files, [`StreamError::LimitExceeded`].
pub fn read(bytes: &[u8], limits: &StreamLimits) -> Result<Vec<Mp4Track>, StreamError> {
    StreamLimits::check("byte 0", "bytes", bytes.len() as u64, limits.bytes)?;
    let moov = moov(bytes)?;
    let mut left = bytes.len();
    let mut tracks = Vec::with_capacity(moov.trak_boxes.len());
    for trak in moov.trak_boxes {
        let track = track(trak, bytes.len())?;
        let of_track: usize = track.chunks.iter().map(Range::len).sum();
        // Tracks that share bytes could need far more memory than the file has.
        left = left.checked_sub(of_track).ok_or_else(|| {
            let at = format!("track {}", track.id);
            StreamError::malformed(at, "the samples of all tracks together exceed the file")
        })?;
        tracks.push(track);
    }
    Ok(tracks)
}

impl Mp4Track {
    /// Returns the duration in seconds.
    pub fn secs(&self) -> f64 {
        self.duration_ticks as f64 / f64::from(self.timescale)
    }

    /// Returns the number of bytes of the stream.
    pub fn bytes(&self) -> usize {
        self.head.len() + self.chunks.iter().map(Range::len).sum::<usize>()
    }

    /// Returns the number of bytes before the samples.
    pub fn bytes_head(&self) -> usize {
        self.head.len()
    }

    /// Returns the bytes of the stream; `file` is the file that the track was read from.
    ///
    /// # Errors
    /// [`StreamError::Malformed`] if the track holds no stream, or the bytes begin as another one
    /// than the URI says.
    pub fn stream(&self, file: &[u8]) -> Result<Vec<u8>, StreamError> {
        let bad = |what: String| StreamError::malformed(format!("track {}", self.id), what);
        let Some(kind) = self.kind else {
            return Err(bad(format!("{}, not a stream of an animation", self.form)));
        };
        let mut stream = Vec::with_capacity(self.bytes());
        stream.extend(&self.head);
        for chunk in &self.chunks {
            let bytes = file.get(chunk.clone());
            stream.extend(bytes.ok_or_else(|| bad("samples beyond the end of the file".into()))?);
        }
        if StreamKind::of(&stream) != Some(kind) {
            return Err(bad(format!(
                "the sample entry says {}, but the stream does not begin like one",
                kind.name()
            )));
        }
        Ok(stream)
    }
}

/// Finds the boxes that are in no other.
fn top_boxes(bytes: &[u8]) -> Result<Vec<TopBox>, StreamError> {
    let mut found = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let rest = &bytes[at..];
        let bad = |what: String| StreamError::malformed(format!("byte {at}"), what);
        let (header, _) = BoxHeader::decode(rest)
            .map_err(|_| bad("the header of a box is cut off or malformed".into()))?;
        let size = if header.box_size == BoxSize::VARIABLE_SIZE {
            rest.len() as u64
        } else {
            header.box_size.get()
        };
        if size > rest.len() as u64 || size < header.external_size() as u64 {
            return Err(bad(format!(
                "box {} of {size} bytes, {} are left in the file",
                header.box_type,
                rest.len()
            )));
        }
        let end = at + size as usize;
        found.push(TopBox {
            header,
            bytes: at..end,
        });
        at = end;
    }
    Ok(found)
}

/// Finds and reads the movie box.
fn moov(bytes: &[u8]) -> Result<MoovBox, StreamError> {
    let boxes = top_boxes(bytes)?;
    checksums::check(bytes, &boxes)?;
    if let Some(fragment) = boxes.iter().find(|b| b.is(b"moof")) {
        return Err(fragments(fragment.bytes.start));
    }
    let mut movies = boxes.iter().filter(|b| b.is(b"moov"));
    let none = || StreamError::malformed("file", "no box moov, which every MP4 file has");
    let at = movies.next().ok_or_else(none)?.bytes.start;
    if let Some(second) = movies.next() {
        let at = format!("byte {}", second.bytes.start);
        return Err(StreamError::malformed(at, "a second box moov"));
    }
    let (moov, _) = MoovBox::decode(&bytes[at..]).map_err(|e| error(at, &e))?;
    match moov.mvex_box {
        Some(_) => Err(fragments(at)),
        None => Ok(moov),
    }
}

fn fragments(at: usize) -> StreamError {
    StreamError::Unsupported {
        at: format!("byte {at}"),
        what: "a movie in fragments (boxes mvex and moof)".into(),
        mend: "write the file as a whole, with one box moov".into(),
    }
}

/// An error of the library in the words of ours; `at` is the byte of the outermost box.
fn error(at: usize, error: &Error) -> StreamError {
    let place = match error.box_type {
        Some(name) => format!("byte {at}, box {name}"),
        None => format!("byte {at}, box moov"),
    };
    let what = match error.kind {
        ErrorKind::InsufficientBuffer => "the box ends early".to_owned(),
        _ if error.reason.is_empty() => "malformed".to_owned(),
        _ => error.reason.clone(),
    };
    StreamError::malformed(place, what)
}

/// Reads a track of a file of `size` bytes.
fn track(trak: TrakBox, size: usize) -> Result<Mp4Track, StreamError> {
    let id = trak.tkhd_box.track_id;
    let media = trak.mdia_box;
    let minf = media.minf_box;
    let bad = |what: String| StreamError::malformed(format!("track {id}"), what);
    let entries = &minf.stbl_box.stsd_box.entries;
    let urim = match &entries[..] {
        [entry] => Urim::read(entry).map_err(bad)?,
        // A stream has one form throughout.
        _ => None,
    };
    let kind = urim.as_ref().and_then(Urim::kind);
    let is_here = minf.dinf_box.dref_box.url_box;
    let is_here = is_here.is_some_and(|url| url.location.is_none());
    if kind.is_some() && !is_here {
        return Err(StreamError::Unsupported {
            at: format!("track {id}"),
            what: "a track whose samples are in another file".into(),
            mend: "write the file with its samples".into(),
        });
    }
    let form = match &urim {
        Some(urim) => urim.uri.clone(),
        None => entries.first().map_or_else(String::new, four_letters),
    };
    let sum = |(samples, ticks): (u64, u64), entry: &shiguredo_mp4::boxes::SttsEntry| {
        let [count, delta] = [entry.sample_count, entry.sample_delta].map(u64::from);
        (
            samples.saturating_add(count),
            ticks.saturating_add(count * delta),
        )
    };
    let durations = minf.stbl_box.stts_box.entries.iter();
    let (samples, duration_ticks) = durations.fold((0, 0), sum);
    let chunks = match kind {
        Some(_) => chunks(minf.stbl_box, size).map_err(bad)?,
        None => Vec::new(),
    };
    Ok(Mp4Track {
        id,
        kind,
        form,
        samples,
        timescale: media.mdhd_box.timescale.get(),
        duration_ticks,
        head: urim
            .filter(|_| kind.is_some())
            .map_or_else(Vec::new, |urim| urim.init),
        chunks,
    })
}

/// The name of a sample entry.
fn four_letters(entry: &SampleEntry) -> String {
    let name = match entry {
        SampleEntry::Unknown(UnknownBox { box_type, .. }) => *box_type,
        known => known.box_type(),
    };
    String::from_utf8_lossy(name.as_bytes()).into_owned()
}

/// The bytes of the chunks of a track, in the order of its samples.
fn chunks(stbl: StblBox, size: usize) -> Result<Vec<Range<usize>>, String> {
    let fixed = match &stbl.stsz_box {
        StszBox::Fixed { sample_size, .. } => Some(u64::from(sample_size.get())),
        StszBox::Variable { .. } => None,
    };
    let table = SampleTableAccessor::new(Boxed(stbl)).map_err(|e| e.to_string())?;
    let mut chunks = Vec::new();
    let mut left = size as u64;
    for chunk in table.chunks() {
        let bytes = match fixed {
            Some(each) => u64::from(chunk.sample_count()).saturating_mul(each),
            None => chunk
                .samples()
                .map(|sample| u64::from(sample.data_size()))
                .sum(),
        };
        let start = chunk.offset();
        let end = start.checked_add(bytes).filter(|end| *end <= size as u64);
        let end = end.ok_or_else(|| {
            format!(
                "chunk {} of {bytes} bytes at byte {start}, the file has {size}",
                chunk.index()
            )
        })?;
        // Chunks that overlap could need far more memory than the file has.
        let rest = left.checked_sub(bytes);
        left = rest.ok_or("the samples together exceed the file")?;
        chunks.push(start as usize..end as usize);
    }
    Ok(chunks)
}

/// The sample table, as the accessor takes it.
struct Boxed(StblBox);

impl AsRef<StblBox> for Boxed {
    fn as_ref(&self) -> &StblBox {
        &self.0
    }
}

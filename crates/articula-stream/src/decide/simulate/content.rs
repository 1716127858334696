//! Content of a simulation: segments of layers, with their sizes and errors.

use articula_core::Mismatch;

/// A stretch of content.
#[derive(Debug, Clone, PartialEq)]
pub struct Segment {
    /// Bytes of one layer, of two and so on together, rising.
    pub layered_bytes: Vec<u64>,
    /// Bytes of a version of the same quality that is coded alone, for each number of layers.
    pub version_bytes: Vec<u64>,
    /// Error in pixels with no layer (the last pose stands still), with one, two and so on.
    pub error_px: Vec<f64>,
}

/// What is played.
#[derive(Debug, Clone, PartialEq)]
pub struct Content {
    segment_secs: f64,
    segments: Vec<Segment>,
    frame_ns: Vec<f64>,
}

impl Content {
    /// Checks and keeps segments of equal length. `frame_ns[k]` is the time per frame with `k + 1`
    /// layers on an idle device, nanoseconds.
    ///
    /// # Errors
    /// If there is no segment or no layer, segments have different numbers of layers, bytes of layers
    /// fall, or a number is negative, NaN or infinite.
    pub fn new(
        segment_secs: f64,
        segments: Vec<Segment>,
        frame_ns: Vec<f64>,
    ) -> Result<Self, Mismatch> {
        let layers = frame_ns.len();
        if !(segment_secs > 0.0 && segment_secs < 1e6) {
            let what = format!("{segment_secs}, expected more than 0");
            return Err(Mismatch::new("segment_secs", what));
        }
        if segments.is_empty() || layers == 0 {
            let what = format!("{} segments of {layers} layers", segments.len());
            return Err(Mismatch::new("segments", what));
        }
        let finite = |all: &[f64]| all.iter().all(|v| *v >= 0.0 && v.is_finite());
        if !finite(&frame_ns) {
            return Err(Mismatch::new("frame_ns", "a time is negative or no number"));
        }
        for (i, segment) in segments.iter().enumerate() {
            let lengths = [segment.layered_bytes.len(), segment.version_bytes.len()];
            if lengths != [layers; 2] || segment.error_px.len() != layers + 1 {
                let what = format!("expected sizes of {layers} layers and an error more");
                return Err(Mismatch::new(format!("segments[{i}]"), what));
            }
            let sizes = segment.layered_bytes.iter().chain(&segment.version_bytes);
            let most = sizes.max().copied().unwrap_or(0);
            if !segment.layered_bytes.is_sorted() || most > 1 << 48 || !finite(&segment.error_px) {
                let what =
                    "bytes must rise with the layers and errors must be numbers of at least 0";
                return Err(Mismatch::new(format!("segments[{i}]"), what));
            }
        }
        Ok(Self {
            segment_secs,
            segments,
            frame_ns,
        })
    }

    /// Length of a segment, seconds.
    pub fn segment_secs(&self) -> f64 {
        self.segment_secs
    }

    /// The segments in order; at least one.
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// The number of layers of each segment; at least one.
    pub fn layers(&self) -> usize {
        self.frame_ns.len()
    }

    /// Time per frame with a number of layers on an idle device, nanoseconds.
    pub fn frame_ns(&self, layers: usize) -> f64 {
        match layers.min(self.frame_ns.len()) {
            0 => 0.0,
            layers => self.frame_ns[layers - 1],
        }
    }

    /// Length of all segments, seconds.
    pub fn secs(&self) -> f64 {
        self.segment_secs * self.segments.len() as f64
    }

    /// Mean bits per second of one layer, of two and so on together, over up to five segments.
    pub fn layered_rates(&self, from_segment: usize) -> Vec<f64> {
        self.rates(from_segment, |segment| &segment.layered_bytes)
    }

    /// The same of versions.
    pub fn version_rates(&self, from_segment: usize) -> Vec<f64> {
        self.rates(from_segment, |segment| &segment.version_bytes)
    }

    fn rates(&self, from: usize, bytes: impl Fn(&Segment) -> &Vec<u64>) -> Vec<f64> {
        let from = from.min(self.segments.len() - 1);
        let next = &self.segments[from..self.segments.len().min(from + 5)];
        let secs = self.segment_secs * next.len() as f64;
        let rate = |layer: usize| {
            let sum: u64 = next.iter().map(|s| bytes(s)[layer]).sum();
            8.0 * sum as f64 / secs
        };
        (0..self.layers()).map(rate).collect()
    }
}

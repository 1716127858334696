//! What is told of a converted file: its size, its error, and what it can stand for.

use super::reference_frames::ImageError;
use crate::planar::PlanarError;
use flate2::Compression;
use flate2::write::GzEncoder;
use std::io::Write;

/// Files above so many bytes are compressed a little less.
const LARGE: usize = 4 << 20;

/// Sizes of a file on its way to the viewer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Sizes {
    /// As it lies on a disk.
    pub raw: u64,
    /// Compressed by gzip, level 9.
    pub gzip: u64,
    /// Compressed by brotli, quality 11; 9 for files above 4 MB, which take minutes otherwise.
    pub brotli: u64,
}

impl Sizes {
    /// Measures bytes.
    ///
    /// # Errors
    /// [`PlanarError::Mismatch`] if a compressor fails, which memory alone can cause.
    pub fn of(bytes: &[u8]) -> Result<Self, PlanarError> {
        let fault = |e: std::io::Error| PlanarError::Mismatch {
            at: "compression",
            what: e.to_string(),
        };
        let mut gzip = GzEncoder::new(Vec::new(), Compression::best());
        gzip.write_all(bytes).map_err(fault)?;
        let gzip = gzip.finish().map_err(fault)?;
        let options = brotli::enc::BrotliEncoderParams {
            quality: if bytes.len() > LARGE { 9 } else { 11 },
            lgwin: 22,
            ..Default::default()
        };
        let mut brotli = Vec::new();
        brotli::BrotliCompress(&mut &*bytes, &mut brotli, &options).map_err(fault)?;
        Ok(Self {
            raw: bytes.len() as u64,
            gzip: gzip.len() as u64,
            brotli: brotli.len() as u64,
        })
    }
}

/// How far a converted file is off.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Errors {
    /// Root mean square distance of corners from where they should be, pixels.
    pub position_rmse_px: f64,
    /// Pictures against the truth.
    pub image: ImageError,
    /// Pixels that show a triangle that another should cover, share of the character's; percent.
    pub wrong_pixels_percent: f64,
    /// The same if every frame were sorted by depth.
    pub wrong_pixels_percent_depth_sort: f64,
}

/// A thing that can stand for a character, so that a decision may fall from 3D to 2D.
///
/// Source: design, part 4: every output describes itself by these four.
#[derive(Debug, Clone, PartialEq)]
pub struct Representation {
    /// What kind of thing it is, such as `vector/smil`.
    pub modality: String,
    /// Its size, bytes.
    pub bytes: u64,
    /// How far it is off, pixels.
    pub error_px: f64,
    /// What the client must be able to do.
    pub needs: Vec<&'static str>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_that_repeats_shrinks() {
        let text = "m1 2l3 4 5 6z".repeat(200);
        let sizes = Sizes::of(text.as_bytes()).unwrap();
        assert_eq!(sizes.raw, 2600);
        assert!(sizes.gzip < 100 && sizes.brotli < sizes.gzip);
        assert_eq!(Sizes::of(&[]).unwrap().raw, 0);
    }
}

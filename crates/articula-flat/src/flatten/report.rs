//! Report on a converted file: size, error and representation.

use super::reference_frames::ImageError;
use super::settings::Profile;
use crate::planar::PlanarError;
use flate2::Compression;
use flate2::write::GzEncoder;
use std::io::Write;

/// Files above this size, bytes, are compressed by brotli at a lower quality.
const LARGE: usize = 4 << 20;

/// Size of a file, raw and compressed, in bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FileSize {
    /// Uncompressed.
    pub raw: u64,
    /// Compressed by gzip, level 9.
    pub gzip: u64,
    /// Compressed by brotli, quality 11; 9 for files above 4 MiB, which would take minutes.
    pub brotli: u64,
}

impl FileSize {
    /// Measures the sizes of a file.
    ///
    /// # Errors
    /// [`PlanarError::Mismatch`] if a compressor fails, which only lack of memory can cause.
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

/// Errors of a converted file.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FileErrors {
    /// Root mean square distance of corners from their exact positions, pixels.
    pub position_rmse_px: f64,
    /// Error of its pictures against the reference.
    pub image: ImageError,
    /// Pixels at twice the size that lie outside of the silhouette, or have a colour that none of
    /// the triangles around them has, percent of the character's; `None` where the profile is not
    /// measured (player, thesis) or the picture is large.
    pub stray_pixels_percent: Option<f64>,
    /// Pixels that show a triangle which another one should cover, percent of the character's.
    pub wrong_pixels_percent: f64,
    /// Wrong pixels of a depth sort per frame, percent of the character's.
    pub wrong_pixels_percent_depth_sort: f64,
}

/// Size, error and client requirements of one 3D or 2D encoding of a character, for choosing
/// between encodings.
#[derive(Debug, Clone, PartialEq)]
pub struct Representation {
    /// Kind of encoding, such as `vector/smil`.
    pub modality: String,
    /// Size, bytes.
    pub bytes: u64,
    /// Error, pixels.
    pub error_px: f64,
    /// Features that the client must support.
    pub needs: Vec<&'static str>,
}

impl Representation {
    /// That of a file of a profile.
    pub(super) fn new(profile: Profile, bytes: u64, error_px: f64) -> Self {
        Self {
            modality: format!("vector/{profile}"),
            bytes,
            error_px,
            needs: profile.needs(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_that_repeats_shrinks() {
        let text = "m1 2l3 4 5 6z".repeat(200);
        let sizes = FileSize::of(text.as_bytes()).unwrap();
        assert_eq!(sizes.raw, 2600);
        assert!(sizes.gzip < 100 && sizes.brotli < sizes.gzip);
        assert_eq!(FileSize::of(&[]).unwrap().raw, 0);
    }
}

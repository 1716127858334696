//! Formats of picture files that textures are read from and written in.

use articula_flat::{Picture, PictureError};

/// A format of pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PictureFormat {
    Png,
    Jpeg,
    Webp,
}

impl PictureFormat {
    /// The format of a file, by its first bytes.
    pub(super) fn of(bytes: &[u8]) -> Option<Self> {
        match bytes {
            [0x89, b'P', b'N', b'G', ..] => Some(Self::Png),
            [0xff, 0xd8, ..] => Some(Self::Jpeg),
            _ if Picture::is_known_format(bytes) => Some(Self::Webp),
            _ => None,
        }
    }

    pub(super) fn media_type(self) -> &'static str {
        match self {
            Self::Png => "image/png",
            Self::Jpeg => "image/jpeg",
            Self::Webp => "image/webp",
        }
    }

    /// Whether a file lost something when it was coded: JPEG, and WebP with a part that has.
    pub(super) fn is_lossy(bytes: &[u8]) -> bool {
        match Self::of(bytes) {
            Some(Self::Jpeg) => true,
            Some(Self::Webp) => {
                let mut at = 12;
                while let Some(head) = bytes.get(at..at + 8) {
                    if head.starts_with(b"VP8 ") {
                        return true;
                    }
                    let size = head.last_chunk::<4>().map_or(0, |b| u32::from_le_bytes(*b));
                    let size = size as usize;
                    at = at.saturating_add(8).saturating_add(size + size % 2);
                    if at >= bytes.len() {
                        break;
                    }
                }
                false
            }
            _ => false,
        }
    }
}

/// A picture as a file: of a quality, or lossless. `None` if the format has no such file.
pub(super) fn encoded(
    picture: &Picture,
    format: PictureFormat,
    quality: Option<u8>,
) -> Result<Option<Vec<u8>>, PictureError> {
    match (format, quality) {
        (PictureFormat::Png, None) => picture.to_small_png().map(Some),
        (PictureFormat::Webp, None) => picture.to_lossless_webp().map(Some),
        (PictureFormat::Webp, Some(quality)) => picture.to_webp(quality).map(Some),
        (PictureFormat::Jpeg, Some(quality)) if picture.is_opaque() => {
            picture.to_jpeg(quality).map(Some)
        }
        (PictureFormat::Jpeg, _) | (PictureFormat::Png, Some(_)) => Ok(None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_known_by_their_bytes_and_lossy_webp_by_its_parts() {
        let picture = Picture::new(20, 20, [10, 200, 30, 255]).unwrap();
        let clear = Picture::new(20, 20, [10, 200, 30, 100]).unwrap();
        for (picture, format, quality, is_lossy) in [
            (&picture, PictureFormat::Png, None, false),
            (&picture, PictureFormat::Jpeg, Some(90), true),
            (&picture, PictureFormat::Webp, Some(90), true),
            (&clear, PictureFormat::Webp, Some(90), true),
            (&clear, PictureFormat::Webp, None, false),
        ] {
            let bytes = encoded(picture, format, quality).unwrap().unwrap();
            assert_eq!(PictureFormat::of(&bytes), Some(format));
            assert_eq!(PictureFormat::is_lossy(&bytes), is_lossy, "{format:?}");
        }
        assert_eq!(encoded(&clear, PictureFormat::Jpeg, Some(90)), Ok(None));
        assert_eq!(PictureFormat::of(b"GIF89a"), None);
        let mut endless = b"RIFF\0\0\0\0WEBPEXIF".to_vec();
        endless.extend([0xff; 8]);
        assert!(!PictureFormat::is_lossy(&endless));
    }
}

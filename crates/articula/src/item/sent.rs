//! How the files of an item travel: their size when compressed, and their hash.

use crate::error::{Error, Result};
use brotli::enc::BrotliEncoderParams;
use serde::{Deserialize, Serialize};
use std::io::Read;

/// Files above this size in bytes are compressed at the lower quality, as the higher one takes about two
/// seconds a megabyte.
const LARGE: usize = 1 << 18;
const QUALITY: i32 = 11;
const QUALITY_OF_LARGE: i32 = 9;

/// A file of an item as it travels.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct FileEntry {
    /// Its size in bytes.
    pub bytes: u64,
    /// Its size in bytes with the content coding `br` (RFC 7932): quality 11, of files above 256 KiB 9,
    /// window 22. `None` if that is not smaller, or its own form is compressed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub compressed_bytes: Option<u64>,
    /// Its BLAKE3 as 64 hexadecimal digits.
    pub hash: String,
}

impl FileEntry {
    /// Describes a file.
    pub(super) fn of(name: &str, bytes: &[u8]) -> Self {
        Self {
            bytes: bytes.len() as u64,
            compressed_bytes: compressed(name, bytes).map(|short| short.len() as u64),
            hash: hash(bytes),
        }
    }

    /// Returns whether these are the bytes of the file.
    pub(super) fn is_of(&self, bytes: &[u8]) -> bool {
        self.bytes == bytes.len() as u64 && self.hash == hash(bytes)
    }

    /// Returns the bytes that are sent.
    pub fn sent_bytes(&self) -> u64 {
        self.compressed_bytes.unwrap_or(self.bytes)
    }
}

fn hash(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}

/// Returns a file with the content coding `br`, as [`FileEntry::compressed_bytes`] counts it; `None` if
/// that is not shorter, or its own form is compressed.
pub fn compressed(name: &str, bytes: &[u8]) -> Option<Vec<u8>> {
    if is_compressed(name) {
        return None;
    }
    let options = BrotliEncoderParams {
        quality: match bytes.len() {
            LARGE.. => QUALITY_OF_LARGE,
            _ => QUALITY,
        },
        lgwin: 22,
        ..BrotliEncoderParams::default()
    };
    let mut made = Vec::new();
    brotli::BrotliCompress(&mut &*bytes, &mut made, &options).ok()?;
    (made.len() < bytes.len()).then_some(made)
}

/// Returns the file of which these are the bytes with the content coding `br`.
///
/// # Errors
/// An [`Error`] for bytes that are not of this coding, and more than `most` bytes in all.
pub fn decompressed(bytes: &[u8], most: u64) -> Result<Vec<u8>> {
    let mut made = Vec::new();
    let reader = brotli::Decompressor::new(bytes, 4096);
    let read = reader.take(most.saturating_add(1)).read_to_end(&mut made);
    if let Err(error) = read {
        return Err(Error::unsuited(format!(
            "it is not compressed with br: {error}"
        )));
    }
    match made.len() as u64 > most {
        true => Err(Error::unsuited(format!(
            "more than {most} bytes when decompressed"
        ))),
        false => Ok(made),
    }
}

/// Whether a file is of a form that is compressed by itself.
fn is_compressed(name: &str) -> bool {
    const FORMS: [&str; 18] = [
        "abp", "afp", "ams", "png", "jpg", "jpeg", "webp", "avif", "ktx2", "mp3", "ogg", "oga",
        "opus", "m4a", "aac", "flac", "mp4", "webm",
    ];
    let extension = name.rsplit_once('.').map_or("", |(_, extension)| extension);
    FORMS.contains(&extension)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_is_sent_compressed_and_a_stream_as_it_is() {
        let bytes = b"<svg></svg>".repeat(100);
        let text = FileEntry::of("2d/walk.svg", &bytes);
        assert!(text.sent_bytes() < text.bytes / 10);
        let stream = FileEntry::of("clips/walk.abp", &bytes);
        assert_eq!((stream.sent_bytes(), &stream.hash), (1100, &text.hash));
        assert!(text.is_of(&bytes) && !text.is_of(&bytes[1..]));
        let mut other = bytes;
        other[7] ^= 1;
        assert!(!text.is_of(&other));
        // The published test vector of no input.
        let none = FileEntry::of("a.txt", b"");
        assert!(none.hash.starts_with("af1349b9f5f9a1a6"));
        assert_eq!((none.hash.len(), none.sent_bytes()), (64, 0));
    }
}

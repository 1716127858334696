//! The box with the checksums of a file, and the brand that says that the file has it.
//!
//! Form: `docs/formats/mp4.md`, part 4.

use crate::error::StreamError;
use crc::{CRC_32_ISO_HDLC, Crc};
use shiguredo_mp4::boxes::Brand;
use shiguredo_mp4::{BoxHeader, BoxType};
use std::ops::Range;

/// A file with this brand has the box.
pub(super) const BRAND: Brand = Brand::new(LETTERS);
const LETTERS: [u8; 4] = *b"artc";
/// The extended type of the box, drawn at random as RFC 9562 says.
const UUID: [u8; 16] = [
    0x3d, 0x5a, 0x0e, 0xc1, 0x8b, 0x27, 0x4f, 0x36, 0x9e, 0x1c, 0x52, 0xf4, 0x70, 0xa9, 0xd8, 0x6b,
];
/// Bytes of the box: header, and two checksums.
pub(super) const BYTES: usize = 8 + UUID.len() + 8;

static CHECKSUM: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// A box of the file that is in no other.
pub(super) struct TopBox {
    pub(super) header: BoxHeader,
    /// All its bytes.
    pub(super) bytes: Range<usize>,
}

impl TopBox {
    pub(super) fn is(&self, name: &[u8; 4]) -> bool {
        self.header.box_type == BoxType::Normal(*name)
    }

    fn content(&self) -> Range<usize> {
        self.bytes.start + self.header.external_size()..self.bytes.end
    }
}

/// Returns the box for a file of some bytes: those in `structure` are not media data, those in `media`
/// are.
pub(super) fn write(structure: &[&[u8]], media: &[&[u8]]) -> Vec<u8> {
    let mut out = (BYTES as u32).to_be_bytes().to_vec();
    out.extend(b"uuid");
    out.extend(UUID);
    for parts in [structure, media] {
        out.extend(sum(parts.iter().copied()).to_be_bytes());
    }
    out
}

/// Checks the file by its box. A file that neither has the box nor says so is by another writer.
///
/// # Errors
/// [`StreamError::Malformed`] if a checksum is another one, or the box is missing, short or there twice.
pub(super) fn check(file: &[u8], boxes: &[TopBox]) -> Result<(), StreamError> {
    let ours = |b: &&TopBox| b.header.box_type == BoxType::Uuid(UUID);
    let mut found = boxes.iter().filter(ours);
    let Some(own) = found.next() else {
        let ftyp = boxes.iter().find(|b| b.is(b"ftyp"));
        return match ftyp.filter(|ftyp| has_brand(&file[ftyp.content()])) {
            None => Ok(()),
            Some(ftyp) => Err(StreamError::malformed(
                format!("byte {}", ftyp.bytes.start),
                "box ftyp says that there is a box with checksums (uuid), but there is none",
            )),
        };
    };
    let bad = |what: &str| StreamError::malformed(format!("byte {}", own.bytes.start), what);
    let [structure, media] = match file[own.content()].as_chunks::<4>() {
        ([structure, media], []) => [structure, media].map(|sum| u32::from_be_bytes(*sum)),
        _ => return Err(bad("the box with checksums (uuid) has another size")),
    };
    if found.next().is_some() {
        return Err(bad("a second box with checksums (uuid)"));
    }
    let others = || boxes.iter().filter(|b| !ours(b));
    let of_structure = others().map(|b| match b.is(b"mdat") {
        true => &file[b.bytes.start..b.content().start],
        false => &file[b.bytes.clone()],
    });
    if sum(of_structure) != structure {
        return Err(bad(
            "the checksum of the boxes is another one: one of them was changed",
        ));
    }
    let of_media = others().filter(|b| b.is(b"mdat"));
    if sum(of_media.map(|b| &file[b.content()])) != media {
        return Err(bad(
            "the checksum of the samples is another one: box mdat was changed",
        ));
    }
    Ok(())
}

/// Whether the content of `ftyp` lists the brand, after the major one and its version.
fn has_brand(ftyp: &[u8]) -> bool {
    ftyp.as_chunks::<4>()
        .0
        .iter()
        .skip(2)
        .any(|brand| *brand == LETTERS)
}

fn sum<'a>(parts: impl Iterator<Item = &'a [u8]>) -> u32 {
    let mut digest = CHECKSUM.digest();
    parts.for_each(|part| digest.update(part));
    digest.finalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checksum_is_the_one_of_the_catalogue() {
        // The check values of the CRC catalogue (reveng) are those of these nine characters.
        assert_eq!(sum([&b"12345"[..], b"6789"].into_iter()), 0xcbf4_3926);
    }

    #[test]
    fn the_box_lies_as_the_page_says() {
        let made = write(&[b"123456789"], &[b"1234", b"56789"]);
        assert_eq!(made[..8], *b"\0\0\0\x20uuid");
        assert_eq!(made[8..24], UUID);
        // Version 4, variant 10.
        assert_eq!((UUID[6] >> 4, UUID[8] >> 6), (4, 2));
        assert_eq!(made[24..], [0xcb, 0xf4, 0x39, 0x26].repeat(2));
    }
}

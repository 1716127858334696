//! The sample entry of timed metadata that a URI identifies: `urim`, with the boxes `uri ` and `uriI`.
//!
//! Source: ISO/IEC 14496-12, timed metadata, `URIMetaSampleEntry`.

use crate::kind::StreamKind;
use shiguredo_mp4::boxes::{SampleEntry, UnknownBox};
use shiguredo_mp4::{BoxHeader, BoxSize, BoxType};

const URIM: BoxType = BoxType::Normal(*b"urim");
const URI: BoxType = BoxType::Normal(*b"uri ");
const INIT: BoxType = BoxType::Normal(*b"uriI");
/// Reserved bytes and the index of the data reference.
const SAMPLE_ENTRY: usize = 8;
/// Version and flags.
const FULL_BOX: usize = 4;

/// The sample entry of a stream.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Urim {
    /// Identifies the form of the data.
    pub(super) uri: String,
    /// Initialisation data; empty if there is none.
    pub(super) init: Vec<u8>,
}

impl Urim {
    pub(super) fn of(kind: StreamKind, head: &[u8]) -> Self {
        Self {
            uri: uri(kind),
            init: head.to_vec(),
        }
    }

    /// The stream that the URI names.
    pub(super) fn kind(&self) -> Option<StreamKind> {
        StreamKind::ALL
            .into_iter()
            .find(|kind| uri(*kind) == self.uri)
    }

    pub(super) fn entry(&self) -> SampleEntry {
        // The data are in the same file, which the first data reference says.
        let mut payload = vec![0, 0, 0, 0, 0, 0, 0, 1];
        push_full_box(&mut payload, URI, &[self.uri.as_bytes(), &[0]].concat());
        if !self.init.is_empty() {
            push_full_box(&mut payload, INIT, &self.init);
        }
        SampleEntry::Unknown(UnknownBox {
            box_type: URIM,
            box_size: BoxSize::with_payload_size(URIM, payload.len() as u64),
            payload,
        })
    }

    /// Reads an entry; `None` if it has another type, an error if a box in it is malformed.
    pub(super) fn read(entry: &SampleEntry) -> Result<Option<Self>, String> {
        let SampleEntry::Unknown(UnknownBox {
            box_type: URIM,
            payload,
            ..
        }) = entry
        else {
            return Ok(None);
        };
        let (mut uri, mut init) = (None, None);
        let mut rest = payload.get(SAMPLE_ENTRY..).unwrap_or_default();
        while !rest.is_empty() {
            let (header, body) = BoxHeader::decode_header_and_payload(rest)
                .map_err(|_| "a box in urim is longer than urim".to_owned())?;
            let known = match header.box_type {
                URI => Some(&mut uri),
                INIT => Some(&mut init),
                _ => None,
            };
            if let Some(known) = known.filter(|known| known.is_none()) {
                let short = || format!("box {}: {} bytes", header.box_type, body.len());
                *known = Some(body.get(FULL_BOX..).ok_or_else(short)?);
            }
            rest = &rest[header.external_size() + body.len()..];
        }
        let uri = uri.ok_or("urim without a box uri")?;
        let text = uri.split(|byte| *byte == 0).next().unwrap_or_default();
        let text = str::from_utf8(text).map_err(|_| "box uri: not UTF-8".to_owned())?;
        Ok(Some(Self {
            uri: text.to_owned(),
            init: init.unwrap_or_default().to_vec(),
        }))
    }
}

/// The URI of a stream.
fn uri(kind: StreamKind) -> String {
    let name = kind.name().replace('-', "").to_lowercase();
    format!("urn:articula:{name}")
}

fn push_full_box(out: &mut Vec<u8>, name: BoxType, body: &[u8]) {
    out.extend(((8 + FULL_BOX + body.len()) as u32).to_be_bytes());
    out.extend(name.as_bytes());
    out.extend([0; FULL_BOX]);
    out.extend(body);
}

#[cfg(test)]
mod tests {
    use super::*;
    use shiguredo_mp4::Encode;

    #[test]
    fn an_entry_lies_as_the_standard_says() {
        let entry = Urim::of(StreamKind::Abp2, b"HEAD").entry();
        let bytes = entry.encode_to_vec().unwrap();
        // 8 bytes of the box, 8 of the entry; 12 and the URI with its end; 12 and the data.
        assert_eq!(bytes.len(), 16 + 12 + 18 + 12 + 4);
        assert_eq!(bytes[..16], *b"\0\0\0\x3eurim\0\0\0\0\0\0\0\x01");
        assert_eq!(bytes[16..46], *b"\0\0\0\x1euri \0\0\0\0urn:articula:abp2\0");
        assert_eq!(bytes[46..], *b"\0\0\0\x10uriI\0\0\0\0HEAD");
        for kind in StreamKind::ALL {
            for head in [&b""[..], b"1"] {
                let made = Urim::of(kind, head);
                let read = Urim::read(&made.entry()).unwrap().unwrap();
                assert_eq!((read.kind(), &read), (Some(kind), &made));
            }
        }
    }
}

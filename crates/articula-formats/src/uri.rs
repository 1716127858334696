//! URIs of external or embedded data: decoding of data URIs and of percent-encoding.
//!
//! Source: RFC 2397 (data URIs), RFC 3986 2.1 (percent-encoding).

use crate::error::ReadError;
use crate::limits::Limits;
use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};

/// Exporters disagree on padding and on zero trailing bits; both are harmless.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

/// Returns media type and bytes of a data URI; `None` if the URI has another scheme.
pub(crate) fn decode_data_uri(
    uri: &str,
    at: &str,
    limits: &Limits,
) -> Result<Option<(String, Vec<u8>)>, ReadError> {
    let Some(rest) = strip_scheme(uri) else {
        return Ok(None);
    };
    let Some((head, payload)) = rest.split_once(',') else {
        return Err(ReadError::malformed(at, "the data URI has no comma"));
    };
    Limits::check(
        at,
        "bytes of a data URI",
        payload.len() as u64 / 4 * 3,
        limits.bytes,
    )?;
    let mime = head.split(';').next().unwrap_or("").to_owned();
    let is_base64 = head
        .rsplit(';')
        .next()
        .is_some_and(|last| last.trim().eq_ignore_ascii_case("base64"));
    let mut bytes = percent_decoded(payload);
    if !is_base64 {
        return Ok(Some((mime, bytes)));
    }
    // Some encoders break the lines.
    bytes.retain(|byte| !byte.is_ascii_whitespace());
    let bytes = BASE64.decode(bytes).map_err(|e| {
        ReadError::malformed(at, format!("the base64 of the data URI is malformed: {e}"))
    })?;
    Ok(Some((mime, bytes)))
}

/// Returns the file name that a relative URI denotes.
pub(crate) fn file_name(uri: &str) -> String {
    String::from_utf8(percent_decoded(uri)).unwrap_or_else(|_| uri.to_owned())
}

/// Returns the media type detected from the bytes, else the declared one.
pub(crate) fn mime_type(declared: &str, bytes: &[u8]) -> String {
    let seen = match bytes {
        [0x89, b'P', b'N', b'G', ..] => "image/png",
        [0xFF, 0xD8, 0xFF, ..] => "image/jpeg",
        [
            b'R',
            b'I',
            b'F',
            b'F',
            _,
            _,
            _,
            _,
            b'W',
            b'E',
            b'B',
            b'P',
            ..,
        ] => "image/webp",
        [
            _,
            _,
            _,
            _,
            b'f',
            b't',
            b'y',
            b'p',
            b'a',
            b'v',
            b'i',
            b'f' | b's',
            ..,
        ] => "image/avif",
        [0xAB, b'K', b'T', b'X', b' ', b'2', b'0', 0xBB, ..] => "image/ktx2",
        [b'D', b'D', b'S', b' ', ..] => "image/vnd-ms.dds",
        _ => declared,
    };
    seen.to_owned()
}

fn strip_scheme(uri: &str) -> Option<&str> {
    let scheme = uri.get(..5)?;
    scheme.eq_ignore_ascii_case("data:").then(|| &uri[5..])
}

/// Replaces `%41` by `A`; a `%` that two hexadecimal digits do not follow is kept.
fn percent_decoded(text: &str) -> Vec<u8> {
    let bytes = text.as_bytes();
    let mut out = Vec::with_capacity(bytes.len());
    let mut i = 0;
    while i < bytes.len() {
        let escaped = (bytes[i] == b'%')
            .then(|| Some(hex(*bytes.get(i + 1)?)? * 16 + hex(*bytes.get(i + 2)?)?))
            .flatten();
        out.push(escaped.unwrap_or(bytes[i]));
        i += if escaped.is_some() { 3 } else { 1 };
    }
    out
}

fn hex(digit: u8) -> Option<u8> {
    char::from(digit).to_digit(16).map(|d| d as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decoded(uri: &str) -> (String, Vec<u8>) {
        decode_data_uri(uri, "uri", &Limits::default())
            .unwrap()
            .unwrap()
    }

    #[test]
    fn base64_and_percent_encoding_by_hand() {
        // "Man" is TWFu, "Ma" is TWE= (RFC 4648).
        assert_eq!(
            decoded("data:image/png;base64,TWFu"),
            ("image/png".into(), b"Man".to_vec())
        );
        assert_eq!(decoded("data:;base64,TWE").1, b"Ma");
        assert_eq!(decoded("DATA:;base64,TWE%3D").1, b"Ma");
        assert_eq!(decoded("data:;base64,T%0AW\r\n F\tu").1, b"Man");
        assert_eq!(decoded("data:,a%20b%").1, b"a b%");
    }

    #[test]
    fn other_schemes_and_broken_ones() {
        let limits = Limits::default();
        assert_eq!(decode_data_uri("a b.bin", "uri", &limits), Ok(None));
        assert_eq!(decode_data_uri("d\u{e4}ta:", "uri", &limits), Ok(None));
        assert!(decode_data_uri("data:no comma", "uri", &limits).is_err());
        assert!(decode_data_uri("data:;base64,!!!!", "uri", &limits).is_err());
        let tight = Limits { bytes: 2, ..limits };
        assert!(decode_data_uri("data:;base64,TWFu", "uri", &tight).is_err());
        assert_eq!(file_name("my%20hero.bin"), "my hero.bin");
        assert_eq!(file_name("%FF.bin"), "%FF.bin");
    }
}

//! Container of a glTF file: GLB chunks or JSON text, up to a parsed document.
//!
//! Source: glTF 2.0, chapter 4 (GLB) and 3.2 (JSON).

use super::reader::Notes;
use crate::error::ReadError;
use crate::limits::Limits;
use serde_json::Value;

/// First bytes of a GLB.
const MAGIC: &[u8] = b"glTF";
/// Chunk types, as little-endian numbers.
const JSON: u32 = 0x4E4F_534A;
const BIN: u32 = 0x004E_4942;
/// The JSON parser rejects deeper nesting, so a larger limit has no effect.
const PARSER_DEPTH: u64 = 127;

/// Splits a file into its JSON document and, for a GLB, its binary chunk.
pub(super) fn open<'a>(
    bytes: &'a [u8],
    limits: &Limits,
    notes: &mut Notes,
) -> Result<(Value, Option<&'a [u8]>), ReadError> {
    Limits::check("file", "bytes", bytes.len() as u64, limits.bytes)?;
    if !bytes.starts_with(MAGIC) {
        return Ok((parse(bytes, 0, limits)?, None));
    }
    let (json, binary) = chunks(bytes, notes)?;
    Ok((parse(json, 20, limits)?, binary))
}

fn chunks<'a>(
    file: &'a [u8],
    notes: &mut Notes,
) -> Result<(&'a [u8], Option<&'a [u8]>), ReadError> {
    let file = declared_part(file, notes)?;
    let mut json = None;
    let mut binary = None;
    let mut at = 12;
    while at < file.len() {
        let place = format!("byte {at}");
        let (Some(length), Some(kind)) = (word(file, at), word(file, at + 4)) else {
            return Err(ReadError::malformed(place, "a chunk header is cut off"));
        };
        let start = at + 8;
        let rest = &file[start..];
        let Some(chunk) = rest.get(..length as usize) else {
            let what = format!(
                "a chunk of {length} bytes exceeds the {} bytes left",
                rest.len()
            );
            return Err(ReadError::malformed(place, what));
        };
        match kind {
            JSON if json.is_none() && start == 20 => json = Some(chunk),
            BIN if json.is_some() && binary.is_none() => binary = Some(chunk),
            _ => notes.add(place, format!("chunk of type {kind:#010x} left out")),
        }
        at = start + chunk.len();
    }
    let json =
        json.ok_or_else(|| ReadError::malformed("byte 12", "the first chunk is not JSON"))?;
    Ok((json, binary))
}

/// Checks the header and cuts the file to the declared length.
fn declared_part<'a>(file: &'a [u8], notes: &mut Notes) -> Result<&'a [u8], ReadError> {
    let (Some(version), Some(length)) = (word(file, 4), word(file, 8)) else {
        let what = format!("a GLB header has 12 bytes, the file has {}", file.len());
        return Err(ReadError::malformed("byte 0", what));
    };
    if version != 2 {
        return Err(ReadError::Unsupported {
            at: "byte 4".to_owned(),
            what: format!("GLB version {version}"),
            mend: "export as glTF 2.0".to_owned(),
        });
    }
    let length = length as usize;
    if length > file.len() || length < 12 {
        let what = format!(
            "the header says {length} bytes, the file has {}",
            file.len()
        );
        return Err(ReadError::malformed("byte 8", what));
    }
    if length < file.len() {
        let what = format!("{} bytes after the end are ignored", file.len() - length);
        notes.add(format!("byte {length}"), what);
    }
    Ok(&file[..length])
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    let four = bytes.get(at..)?.first_chunk::<4>()?;
    Some(u32::from_le_bytes(*four))
}

fn parse(text: &[u8], offset: usize, limits: &Limits) -> Result<Value, ReadError> {
    let text = text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(text);
    let parsed = serde_json::from_slice(text);
    // What the parser accepts is within its own depth; what it refuses may be too deep.
    if parsed.is_err() || limits.depth < PARSER_DEPTH {
        check_depth(text, offset, limits.depth.min(PARSER_DEPTH))?;
    }
    let json: Value = parsed.map_err(|e| {
        let place = format!("JSON line {} column {}", e.line(), e.column());
        ReadError::malformed(place, format!("neither GLB nor well-formed JSON: {e}"))
    })?;
    if !json.is_object() {
        return Err(ReadError::malformed("JSON", "expected an object"));
    }
    Ok(json)
}

/// Returns an error that names the byte where nesting exceeds the limit.
fn check_depth(text: &[u8], offset: usize, limit: u64) -> Result<(), ReadError> {
    let mut depth = 0u64;
    let mut in_string = false;
    let mut escaped = false;
    for (i, byte) in text.iter().enumerate() {
        match byte {
            _ if escaped => escaped = false,
            b'\\' if in_string => escaped = true,
            b'"' => in_string = !in_string,
            _ if in_string => {}
            b'[' | b'{' => {
                depth += 1;
                if depth > limit {
                    let at = format!("byte {}", offset + i);
                    return Limits::check(&at, "levels of JSON nesting", depth, limit);
                }
            }
            b']' | b'}' => depth = depth.saturating_sub(1),
            _ => {}
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn glb(chunks: &[(u32, &[u8])]) -> Vec<u8> {
        let mut out = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
        for (kind, bytes) in chunks {
            out.extend((bytes.len() as u32).to_le_bytes());
            out.extend(kind.to_le_bytes());
            out.extend(*bytes);
        }
        let length = (out.len() as u32).to_le_bytes();
        out[8..12].copy_from_slice(&length);
        out
    }

    fn open_all(bytes: &[u8]) -> Result<(Value, Option<Vec<u8>>, usize), ReadError> {
        let mut notes = Notes::default();
        let (json, binary) = open(bytes, &Limits::default(), &mut notes)?;
        Ok((json, binary.map(<[u8]>::to_vec), notes.into_list().len()))
    }

    #[test]
    fn chunks_of_unknown_type_are_left_out_with_a_warning() {
        let file = glb(&[
            (JSON, b"{}  "),
            (BIN, &[1, 2, 3, 4]),
            (0x4141_4141, b"else"),
        ]);
        let (json, binary, warnings) = open_all(&file).unwrap();
        assert_eq!(json, serde_json::json!({}));
        assert_eq!(binary.unwrap(), [1, 2, 3, 4]);
        assert_eq!(warnings, 1);
    }

    #[test]
    fn hostile_containers() {
        let good = glb(&[(JSON, b"{}  ")]);
        for end in 4..good.len() {
            assert!(open_all(&good[..end]).is_err(), "cut at {end}");
        }
        let mut long = good.clone();
        long[12] = 0xFF;
        assert!(open_all(&long).unwrap_err().to_string().contains("byte 12"));
        let mut old = good.clone();
        old[4] = 1;
        assert!(
            open_all(&old)
                .unwrap_err()
                .to_string()
                .contains("version 1")
        );
        assert!(open_all(&glb(&[(BIN, b"1234")])).is_err());
        assert!(open_all(b"[1]").is_err());
        assert!(open_all(b"solid cube").is_err());
    }

    #[test]
    fn deep_json_is_refused_by_byte() {
        let deep = format!("{{\"a\":{}", "[".repeat(100_000));
        let error = open_all(deep.as_bytes()).unwrap_err().to_string();
        assert_eq!(
            error,
            "byte 131: 128 levels of JSON nesting, the limit is 127"
        );
        // Brackets inside strings do not nest.
        let flat = format!("{{\"a\":\"\\\"{}\"}}", "[".repeat(1000));
        assert!(open_all(flat.as_bytes()).is_ok());
        // The check and the parser agree on the maximum.
        let most = format!("{{\"a\":{}{}}}", "[".repeat(126), "]".repeat(126));
        assert!(open_all(most.as_bytes()).is_ok());
    }
}

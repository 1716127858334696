//! Records of an FBX file as bytes: what a repair needs of both encodings, without a tree.
//!
//! A record has a name, values and records within it. A walk visits those that [`Level`] tells apart, each
//! before the records within it, and ends where the bytes follow no rule: the crate that reads them then says
//! what is wrong, and the walk says where.

use std::ops::Range;

/// Signature of the binary encoding, followed by 0x1A, 0 and the byte order.
const BINARY: &[u8] = b"Kaydara FBX Binary  \0";

/// Maximum number of values of a record that are kept.
pub(super) const MOST_VALUES: usize = 64;

/// What a record is to the repair, by its name and those above it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Level {
    Other,
    /// `GlobalSettings`.
    Settings,
    /// `Objects`.
    Objects,
    /// An object.
    Object,
    /// A list in an object: points or polygons of a mesh, or the mode of a cluster.
    Part,
    /// `Connections`.
    Connections,
    Connection,
    /// `Properties70` or `Properties60`.
    Properties {
        of_settings: bool,
    },
    /// A property.
    Entry {
        of_settings: bool,
    },
    /// Binary data of a property.
    Blob,
}

impl Level {
    /// The level of a record by its name and the level of the record around it; `None` for a file.
    pub(super) fn of(around: Option<Self>, name: &[u8]) -> Self {
        match (around, name) {
            (None, b"Objects") => Self::Objects,
            (None, b"Connections") => Self::Connections,
            (Some(Self::Connections), b"C" | b"Connect") => Self::Connection,
            (Some(Self::Properties { of_settings }), _) => Self::Entry { of_settings },
            (Some(around), b"Properties70" | b"Properties60") => Self::Properties {
                of_settings: around == Self::Settings,
            },
            (Some(Self::Entry { .. }), b"BinaryData") => Self::Blob,
            (None | Some(Self::Objects), b"GlobalSettings") => Self::Settings,
            (Some(Self::Objects), _) => Self::Object,
            (Some(Self::Object), b"Vertices" | b"PolygonVertexIndex" | b"Mode") => Self::Part,
            _ => Self::Other,
        }
    }

    /// Whether a repair looks at the values of such records.
    pub(super) fn has_values(self) -> bool {
        matches!(
            self,
            Self::Object | Self::Part | Self::Connection | Self::Entry { .. }
        )
    }
}

/// A value of a record.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value {
    /// Bytes of a text, without quotes.
    Text(Range<usize>),
    /// Bytes that are no text, and the place of the byte that says so.
    Raw {
        tag: usize,
        bytes: Range<usize>,
    },
    Integer(i64),
    Real(f64),
    /// Number of elements of an array.
    List(u64),
}

impl Value {
    pub(super) fn number(&self) -> Option<f64> {
        match self {
            Self::Integer(value) => Some(*value as f64),
            Self::Real(value) => Some(*value),
            _ => None,
        }
    }

    pub(super) fn text<'b>(&self, bytes: &'b [u8]) -> Option<&'b [u8]> {
        match self {
            Self::Text(range) => bytes.get(range.clone()),
            _ => None,
        }
    }
}

/// A record, without those within it.
#[derive(Debug)]
pub(super) struct Record<'a> {
    pub(super) level: Level,
    /// Bytes of the name.
    pub(super) name: Range<usize>,
    /// The first values, if the repair looks at them.
    pub(super) values: &'a [Value],
}

/// Where a walk ended before the end of the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Place {
    Byte(usize),
    Line(usize),
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Byte(at) => write!(f, "byte {at}"),
            Self::Line(at) => write!(f, "line {at}"),
        }
    }
}

/// Whether bytes begin like those of the binary encoding.
pub(super) fn is_binary(bytes: &[u8]) -> bool {
    bytes.starts_with(BINARY)
}

/// The version that the file states, times 1000: 7400 for 7.4. Text states it in its first comment or in its
/// header.
pub(super) fn version(bytes: &[u8]) -> Option<u32> {
    if is_binary(bytes) {
        let stated = bytes.get(23..27)?.try_into().ok()?;
        return Some(match bytes.get(22) {
            Some(1) => u32::from_be_bytes(stated),
            _ => u32::from_le_bytes(stated),
        });
    }
    let start = &bytes[..bytes.len().min(2048)];
    let behind = |key: &[u8]| {
        let at = start.windows(key.len()).position(|w| w == key)?;
        Some(start[at + key.len()..].trim_ascii_start())
    };
    if let Some([major, b'.', minor, b'.', patch, ..]) = behind(b"; FBX") {
        let digit = |byte: &u8| char::from(*byte).to_digit(10);
        return Some(digit(major)? * 1000 + digit(minor)? * 100 + digit(patch)? * 10);
    }
    let digits = behind(b"FBXVersion:")?;
    let length = digits.iter().take_while(|b| b.is_ascii_digit()).count();
    std::str::from_utf8(&digits[..length]).ok()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::version;

    #[test]
    fn versions_stand_in_comments_and_headers() {
        assert_eq!(version(b"; FBX 6.1.0 project file\n"), Some(6100));
        let header = b"FBXHeaderExtension:  {\n\tFBXHeaderVersion: 1003\n\tFBXVersion: 7300\n";
        assert_eq!(version(header), Some(7300));
        assert_eq!(version(b"Objects:  {\n"), None);
        let big = b"Kaydara FBX Binary  \0\x1a\x01\0\0\x1c\xe8";
        assert_eq!(version(big), Some(7400));
    }
}

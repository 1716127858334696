//! The meshopt codec: compressed glTF buffer views.
//!
//! Attributes (bitstreams v0 and v1), triangles, index sequences, and the filters that are applied
//! afterwards.
//!
//! - `stream`: cursor over the bytes before the tail
//! - `attributes`, `triangles`, `sequence`: the three modes
//! - `filter`: octahedral, quaternion, exponential, color
//! - `encode`: the encoder
//!
//! Source: KHR_meshopt_compression, appendices A and B; EXT_meshopt_compression is the same without
//! bitstream v1 and the color filter. Differs: triangles of header 0xe0, which meshoptimizer wrote
//! before the extension was final, are also read; a reference to an edge or vertex that does not
//! exist yet is an error, as the text of the extension requires and the library does not.

mod attributes;
pub(crate) mod encode;
pub(crate) mod filter;
mod sequence;
mod stream;
mod triangles;

use crate::Limits;
use crate::error::ReadError;

/// Bitstream type of a buffer view compressed with meshoptimizer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Elements of any type, stored by byte lanes.
    Attributes,
    /// Indices of a triangle list.
    Triangles,
    /// Any other indices.
    Indices,
}

/// Filter that is applied after the bitstream; only for [`Mode::Attributes`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Filter {
    /// Elements are the output of the bitstream.
    #[default]
    None,
    /// Unit vectors as two coordinates on an octahedron.
    Octahedral,
    /// Unit quaternions as their three smaller components.
    Quaternion,
    /// Floats as mantissa and exponent.
    Exponential,
    /// Colours as luma, two chroma values and alpha.
    Color,
}

/// Element count, stride and encoding of a compressed buffer view, as the glTF file declares them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ViewLayout {
    /// Bitstream type.
    pub mode: Mode,
    /// Filter.
    pub filter: Filter,
    /// Number of elements; for triangles, of indices.
    pub count: u64,
    /// Size of one element in bytes.
    pub stride: u64,
}

impl ViewLayout {
    /// Returns the size of all elements in bytes, or a description of an invalid layout.
    fn checked_len(&self) -> Result<u64, String> {
        let stride = self.stride;
        let fits = match self.mode {
            Mode::Attributes => stride.is_multiple_of(4) && (4..=256).contains(&stride),
            Mode::Triangles | Mode::Indices => matches!(stride, 2 | 4),
        };
        if !fits {
            return Err(format!(
                "elements of mode {:?} cannot have {stride} bytes",
                self.mode
            ));
        }
        if self.mode == Mode::Triangles && !self.count.is_multiple_of(3) {
            return Err(format!("{} indices are not a multiple of 3", self.count));
        }
        if self.mode != Mode::Attributes && self.filter != Filter::None {
            return Err(format!(
                "indices cannot have a filter, found {:?}",
                self.filter
            ));
        }
        let fits = match self.filter {
            Filter::None | Filter::Exponential => true,
            Filter::Octahedral | Filter::Color => matches!(stride, 4 | 8),
            Filter::Quaternion => stride == 8,
        };
        if !fits {
            let what = format!("{:?} elements cannot have {stride} bytes", self.filter);
            return Err(what);
        }
        let len = self.count.checked_mul(stride);
        len.ok_or_else(|| format!("{} elements of {stride} bytes are too many", self.count))
    }
}

/// Decodes one compressed buffer view into `count * stride` bytes.
///
/// Memory grows with the input: at most about a thousand times its length, and never beyond
/// `limits.bytes`.
///
/// # Errors
/// [`ReadError::Malformed`] with the byte of the fault for a stream that ends early, has bytes left
/// or breaks the rules of its mode; [`ReadError::LimitExceeded`].
pub fn decode(bytes: &[u8], shape: &ViewLayout, limits: &Limits) -> Result<Vec<u8>, ReadError> {
    let len = shape.checked_len();
    let len = len.map_err(|what| ReadError::malformed("shape", what))?;
    Limits::check("shape", "decoded bytes", len, limits.bytes)?;
    let count = usize::try_from(shape.count).unwrap_or(usize::MAX);
    let stride = shape.stride as usize;
    let mut out = match shape.mode {
        Mode::Attributes => attributes::decode(bytes, count, stride)?,
        Mode::Triangles => index_bytes(&triangles::decode(bytes, count)?, stride),
        Mode::Indices => index_bytes(&sequence::decode(bytes, count)?, stride),
    };
    filter::undo(shape.filter, stride, &mut out);
    Ok(out)
}

/// Returns indices as 2 or 4 bytes each; 2-byte ones wrap, as the format specifies.
fn index_bytes(indices: &[u32], stride: usize) -> Vec<u8> {
    let each = indices.iter().map(|i| i.to_le_bytes());
    each.flat_map(|four| four.into_iter().take(stride))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shape(mode: Mode, filter: Filter, count: u64, stride: u64) -> ViewLayout {
        ViewLayout {
            mode,
            filter,
            count,
            stride,
        }
    }

    #[test]
    fn shapes_that_the_format_forbids() {
        use {Filter as F, Mode as M};
        let bad = [
            shape(M::Attributes, F::None, 1, 0),
            shape(M::Attributes, F::None, 1, 6),
            shape(M::Attributes, F::None, 1, 260),
            shape(M::Attributes, F::Octahedral, 1, 12),
            shape(M::Attributes, F::Quaternion, 1, 4),
            shape(M::Attributes, F::Color, 1, 16),
            shape(M::Attributes, F::None, u64::MAX, 8),
            shape(M::Triangles, F::None, 4, 2),
            shape(M::Triangles, F::None, 3, 1),
            shape(M::Indices, F::Exponential, 3, 4),
            shape(M::Indices, F::None, 3, 8),
        ];
        for shape in bad {
            assert!(shape.checked_len().is_err(), "{shape:?}");
        }
        let good = shape(M::Attributes, F::Exponential, 3, 12);
        assert_eq!(good.checked_len(), Ok(36));
    }

    #[test]
    fn more_than_the_limit_is_refused_before_it_is_decoded() {
        let limits = Limits {
            bytes: 100,
            ..Limits::default()
        };
        let shape = shape(Mode::Indices, Filter::None, 26, 4);
        let error = decode(&[], &shape, &limits).unwrap_err();
        assert_eq!(
            error.to_string(),
            "shape: 104 decoded bytes, the limit is 100"
        );
    }

    #[test]
    fn short_indices_wrap() {
        assert_eq!(index_bytes(&[0x1_0002], 2), [2, 0]);
        assert_eq!(index_bytes(&[0x1_0002], 4), [2, 0, 1, 0]);
    }
}

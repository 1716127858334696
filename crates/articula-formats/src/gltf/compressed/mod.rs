//! Writing of a document whose arrays are rounded and compressed.
//!
//! - `role`: what each array is used for
//! - `element`: arrays as elements of few digits, in front of a filter
//! - `array`: an array of a document, or a part of it
//! - `clip`: keys and size of a clip without writing it
//! - `influences`: weights that still sum to 1
//! - `offsets`: offsets by morph targets, rounded with the positions that they move
//! - `sparse`: offsets that are mostly zero as sparse accessors
//! - `stored_classes`: vertices that are equal as they are stored
//! - `streams`: arrays of one layout as one compressed view
//!
//! Source: EXT_meshopt_compression, KHR_meshopt_compression, KHR_mesh_quantization.

mod array;
mod clip;
mod element;
mod influences;
mod offsets;
mod role;
mod sparse;
mod stored_classes;
mod streams;

pub use clip::{compressed_clip_bytes, rounded_clip};
pub(super) use offsets::moved_multiples;
pub(super) use stored_classes::stored_classes;

use super::document::Document;
use super::prune::has_unknown_extension;
use crate::written::WriteError;

/// Extension that holds compressed arrays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Compression {
    /// EXT_meshopt_compression, which viewers and engines read.
    #[default]
    Ext,
    /// KHR_meshopt_compression: fewer bytes, and a release candidate.
    Khr,
    /// Arrays are not compressed; positions of skinned meshes may be integers (KHR_mesh_quantization).
    Quantized,
    /// Arrays are rounded and not compressed.
    None,
}

impl Compression {
    /// Whether arrays are compressed.
    #[must_use]
    pub fn is_of_arrays(self) -> bool {
        matches!(self, Self::Ext | Self::Khr)
    }
}

/// Precision of the arrays of a compressed document. What has none is kept to the bit.
#[derive(Debug, Clone, PartialEq)]
pub struct ArrayPrecision {
    /// For each mesh of the document, the step of positions, in its units. A morph target at a weight of 0
    /// to 1, by itself, leaves them within half of it.
    pub positions: Vec<f32>,
    /// For each animation, the steps of the keys of each of its samplers. Samplers without steps keep
    /// theirs.
    pub samplers: Vec<Vec<Option<KeySteps>>>,
    /// Step of texture coordinates, which are 1 over the width of a texture.
    pub texcoords: f32,
    /// Storage of the weights of influences.
    pub weights: WeightPrecision,
}

/// Precision of the keys of a channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KeySteps {
    /// Step of the values: in radians for rotations, else in their unit. Splines keep their values.
    pub values: f32,
    /// Step of the times, in seconds; a 32nd of the shortest time between two keys, if that is less.
    pub times_secs: f32,
}

/// Storage of the weights of influences. The weights of each vertex sum to 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum WeightPrecision {
    /// 8 bits.
    #[default]
    Byte,
    /// Multiples of 1/1024, as floats: integers of 16 bits need nearly twice their bytes.
    TenBits,
    /// As they are.
    Exact,
}

impl Document {
    /// Whether [`write_compressed`](Self::write_compressed) compresses: not where an unknown extension
    /// may refer to arrays by their place.
    pub fn is_compressible(&self) -> bool {
        !has_unknown_extension(&self.json)
    }

    /// Writes the document as one GLB, as [`write_glb`](Self::write_glb) does, with rounded and
    /// compressed arrays.
    ///
    /// Values are within half of their step, offsets by morph targets together with their position; components of rotations within one. Normals and tangents
    /// have 8 bits; colours have 8 bits. Sparse arrays become dense, and
    /// offsets by morph targets that are mostly zero sparse, but not with KHR_meshopt_compression, which has zeros for next to nothing. Arrays that are integers already, and
    /// pictures, are kept to the bit. A document that is not [compressible](Self::is_compressible) is
    /// written as it is.
    ///
    /// # Errors
    /// Those of `write_glb`; [`WriteError::Mismatch`] if an array cannot be read.
    pub fn write_compressed(
        &self,
        compression: Compression,
        precision: &ArrayPrecision,
    ) -> Result<Vec<u8>, WriteError> {
        if !self.is_compressible() {
            return self.write_glb();
        }
        streams::write(self, compression, precision)
    }
}

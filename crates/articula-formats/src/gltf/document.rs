//! The whole glTF document: its unmodified JSON, its buffers and its pictures.
//!
//! Nothing is discarded, so unknown extensions and extras pass through untouched. The only change
//! is that compressed buffer views are decoded when the document is opened.

use serde_json::Value;

/// A glTF 2.0 document with all data that it refers to.
#[derive(Debug, Clone, PartialEq)]
pub struct Document {
    /// The JSON document, an object; key order as in the file. Compressed views are decoded, and
    /// their extension is removed.
    pub json: Value,
    /// Bytes of each entry of `buffers`, with the length given by its `byteLength`.
    pub buffers: Vec<Vec<u8>>,
    /// Bytes of each entry of `images` that has a URI; `None` if it is in a buffer or could not be
    /// fetched.
    pub pictures: Vec<Option<Vec<u8>>>,
}

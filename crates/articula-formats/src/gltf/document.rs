//! The whole glTF document: its JSON as it stands, its buffers and its pictures.
//!
//! Nothing is thrown away, so unknown extensions and extras pass through untouched. Compressed
//! buffer views alone become plain ones as the document is opened.

use serde_json::Value;

/// A glTF 2.0 document with everything that it refers to.
#[derive(Debug, Clone, PartialEq)]
pub struct Document {
    /// The JSON document, an object; key order as in the file. Views that were compressed are
    /// plain here, and the extension that said so is gone.
    pub json: Value,
    /// Bytes of each entry of `buffers`, as many as its `byteLength` says.
    pub buffers: Vec<Vec<u8>>,
    /// Bytes of each entry of `images` that names a URI; `None` where it lies in a buffer or
    /// could not be had.
    pub pictures: Vec<Option<Vec<u8>>>,
}

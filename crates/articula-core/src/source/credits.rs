//! Authors, origin and licence of a character.
//!
//! Sources: `meta` of VRM 0.x and 1.0, `asset` of glTF 2.0, Dublin Core in `KHR_xmp_json_ld`.

/// Authors, origin and licence as stated by a file. Texts are kept verbatim and are not
/// interpreted.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Credits {
    /// Title of the work, or empty.
    pub title: String,
    /// Version of the work, or empty.
    pub version: String,
    /// Names of the authors.
    pub authors: Vec<String>,
    /// Contact information of the authors, or empty.
    pub contact: String,
    /// Copyright notice, or empty.
    pub copyright: String,
    /// Works from which this one is derived.
    pub references: Vec<String>,
    /// Name of the licence as spelled in the file, or empty.
    pub licence_name: String,
    /// URL of the licence, or empty.
    pub licence_url: String,
    /// Further terms of use: name and value as stored in the file.
    pub terms: Vec<(String, String)>,
    /// Program that wrote the file, or empty.
    pub generator: String,
}

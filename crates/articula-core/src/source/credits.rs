//! Who made a character and what may be done with it.
//!
//! Source: `meta` of VRM 0.x and 1.0, `asset` of glTF 2.0, Dublin Core in `KHR_xmp_json_ld`.

/// What a file says of its origin and licence. Nothing is judged: words stay as they stand.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Credits {
    /// Name of the work, or empty.
    pub title: String,
    /// Version of the work, or empty.
    pub version: String,
    /// Who made it.
    pub authors: Vec<String>,
    /// How to reach them, or empty.
    pub contact: String,
    /// The copyright notice, or empty.
    pub copyright: String,
    /// Works that this one goes back to.
    pub references: Vec<String>,
    /// Name of the licence as the file spells it, or empty.
    pub licence_name: String,
    /// Address of the licence, or empty.
    pub licence_url: String,
    /// Terms beyond the name of the licence: name and value as the file has them.
    pub terms: Vec<(String, String)>,
    /// The program that wrote the file, or empty.
    pub generator: String,
}

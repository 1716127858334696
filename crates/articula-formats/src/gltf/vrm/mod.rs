//! VRM 0.x, VRM 1.0 and VRM animation files: their human data beyond glTF.
//!
//! - `nodes`: nodes that are human bones or carry an expression track
//! - `expression_clip`: a clip of expressions as a VRM animation
//! - `expressions`: named bindings to morph targets, and overrides between expressions
//! - `meta`: authors, licence and terms
//! - `kept`: data that stays in the document but is not simulated
//!
//! The extensions are not part of the core format, so a broken entry is a warning. Source: the VRM
//! specification (vrm-c/vrm-specification). See `docs/formats/vrm.md`.

mod expression_clip;
mod expressions;
mod kept;
mod meta;
mod nodes;

pub use kept::PassThrough;

pub(super) use expressions::{expression_nodes, read as read_expressions};
pub(super) use kept::read as read_kept;
pub(super) use meta::read as read_meta;
pub(super) use nodes::read as read_nodes;

use super::place::Place;

/// Extensions of the three formats, and their names in reports.
const FORMATS: [(&str, &str); 3] = [
    ("VRMC_vrm", "VRM"),
    ("VRM", "VRM"),
    ("VRMC_vrm_animation", "VRM animation"),
];

/// Returns the format's extension of highest precedence that the document has.
fn extension<'a>(root: &Place<'a>) -> Option<Place<'a>> {
    let mut all = FORMATS.iter();
    all.find_map(|(extension, _)| root.dig(&["extensions", extension]))
}

/// Returns format and version, such as `VRM 1.0`; `None` without any of the extensions.
pub(super) fn version(root: &Place<'_>) -> Option<String> {
    let mut all = FORMATS.iter();
    let (key, name) = all.find(|(key, _)| root.dig(&["extensions", key]).is_some())?;
    let said = extension(root)?.text("specVersion");
    let said: String = said.chars().take(40).collect();
    // The first exporters of VRM 0.x wrote no version.
    let version = match (said.as_str(), *key) {
        ("", "VRM") => "0.x",
        ("", _) => "1.0",
        (said, _) => said,
    };
    Some(format!("{name} {version}"))
}

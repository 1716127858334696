//! The manifest of an item.

use super::part::{ItemPart, PartKind};
use super::sent::FileEntry;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Value of the member `format`.
pub(super) const FORMAT: &str = "articula-item";
/// Version of the form.
pub(super) const VERSION: u32 = 2;
/// The version before, which says nothing of how files travel; it is read.
pub(super) const VERSION_WITHOUT_FILES: u32 = 1;

/// What an item holds: its files with their bytes, and the errors of leaving parts of them out.
///
/// Form: `docs/formats/item.md`. Unknown members are ignored.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// `articula-item`.
    pub format: String,
    /// Version of the form, 2, or 1 of older items.
    pub version: u32,
    /// Program that wrote it.
    pub generator: String,
    /// Name of the item.
    pub name: String,
    /// The character without geometry, clips and large pictures.
    pub figure: FigureEntry,
    /// Parts that can be cut.
    pub parts: Vec<ItemPart>,
    /// Forms in 2D, each a whole file.
    #[serde(default)]
    pub flat: Vec<FlatEntry>,
    /// Files that are carried whole, such as sound.
    #[serde(default)]
    pub whole: Vec<WholeFile>,
    /// How each file travels, by its name, without the manifest and the unit indices. Empty in version 1.
    #[serde(default)]
    pub files: BTreeMap<String, FileEntry>,
    /// What was lost or could not be measured, as text for people.
    #[serde(default)]
    pub warnings: Vec<String>,
}

/// The figure of an item.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FigureEntry {
    /// Its file, a GLB.
    pub file: String,
    /// Bytes of the file.
    pub bytes: u64,
    /// Number of joints.
    pub joints: u64,
    /// Number of vertices of the packaged meshes.
    pub vertices: u64,
    /// Number of triangles of the packaged meshes.
    pub triangles: u64,
    /// Most morph targets that a vertex has.
    #[serde(default)]
    pub morph_targets: u64,
    /// Longest side of the bounding box at rest in metres.
    pub size_m: f64,
}

/// A form of the character in 2D, which stands for all of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FlatEntry {
    /// Kind of form, such as `vector/smil`.
    pub modality: String,
    /// Its file.
    pub file: String,
    /// Bytes of the file.
    pub bytes: u64,
    /// Its error in pixels at `size_px`.
    pub error_px: f64,
    /// Size for which it was made, in pixels.
    pub size_px: [u32; 2],
    /// Name of the motion that it shows; `None` for a still.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clip: Option<String>,
    /// What a client must support.
    pub needs: Vec<String>,
}

/// A file that is never cut.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WholeFile {
    /// Its name in the item.
    pub file: String,
    /// Bytes of the file.
    pub bytes: u64,
    /// Media type such as `audio/mpeg`; `application/octet-stream` if unknown.
    pub mime: String,
}

impl Manifest {
    /// Returns names and bytes of all files of the item, without the manifest and the unit indices, in the
    /// order of the manifest.
    pub fn sizes(&self) -> Vec<(&str, u64)> {
        let mut files = vec![(self.figure.file.as_str(), self.figure.bytes)];
        for part in &self.parts {
            files.extend(part.file.as_deref().map(|file| (file, part.bytes)));
            let sizes = part.layers.iter();
            files.extend(sizes.filter_map(|l| Some((l.file.as_deref()?, l.bytes))));
        }
        files.extend(self.flat.iter().map(|f| (f.file.as_str(), f.bytes)));
        files.extend(self.whole.iter().map(|f| (f.file.as_str(), f.bytes)));
        files
    }

    /// Returns the bytes of a file as it is sent: compressed if that is shorter. Of an item of version 1
    /// all files count as they are.
    pub fn sent_bytes(&self, file: &str) -> u64 {
        match self.files.get(file) {
            Some(entry) => entry.sent_bytes(),
            None => {
                let mut sizes = self.sizes().into_iter();
                sizes
                    .find(|(name, _)| *name == file)
                    .map_or(0, |(_, bytes)| bytes)
            }
        }
    }

    /// Whether a part comes with these of its layers. A motion without a layer stays out, and comes with the
    /// layers of a later choice; the first motion of the body is there from the beginning, be it at rest.
    pub(super) fn has_part(&self, part: usize, kept: &[bool]) -> bool {
        let Some(of) = self.parts.get(part) else {
            return false;
        };
        let can_come_later = of.kind.is_motion() && !of.layers.is_empty();
        !can_come_later || kept.contains(&true) || self.first_motion() == Some(part)
    }

    /// The first motion of the body.
    pub(super) fn first_motion(&self) -> Option<usize> {
        let is_body = |part: &ItemPart| part.kind == PartKind::BodyMotion;
        self.parts.iter().position(is_body)
    }

    /// Writes the manifest as JSON, on one line: clients fetch it first.
    pub(super) fn to_json(&self) -> Vec<u8> {
        // Strings, numbers and lists of them cannot fail.
        let mut text = serde_json::to_vec(self).unwrap_or_default();
        text.push(b'\n');
        text
    }
}

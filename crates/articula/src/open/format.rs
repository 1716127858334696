//! File formats, their extensions and signatures.
//!
//! **A new format is one variant, one row of [`ROWS`] and one opener in this folder.**

use super::extension::extension;
use super::{Opener, acclaim, bap, bva, bvh, document, fbx, streams, x3d};
use serde::Serialize;

/// A character file format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Format {
    /// Binary glTF 2.0.
    Glb,
    /// glTF 2.0 as a JSON file.
    Gltf,
    /// VRM 0.x or 1.0.
    Vrm,
    /// VRM animation.
    Vrma,
    /// Autodesk FBX, binary or text.
    Fbx,
    /// Biovision hierarchical motion, BVH.
    Bvh,
    /// H-Anim in X3D, XML encoding.
    X3d,
    /// H-Anim in X3D, classic VRML encoding.
    X3dv,
    /// H-Anim in VRML97.
    Wrl,
    /// Biovision animation without a hierarchy, BVA.
    Bva,
    /// Acclaim skeleton.
    Asf,
    /// Acclaim motion.
    Amc,
    /// MPEG-4 body animation parameters.
    Bap,
    /// Motion as a stream of which bones can be cut.
    Abp,
    /// Text of such a stream.
    Abpt,
    /// MP4 file with such a stream.
    Mp4,
}

/// Properties of a format.
struct Row {
    format: Format,
    /// Name used in reports, which is also the file extension.
    name: &'static str,
    open: Opener,
    /// Which characters can be written in the format.
    writes: WriteSupport,
}

/// Which characters can be written in a format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WriteSupport {
    /// Any character.
    Any,
    /// Only characters read from the same format.
    SameFormat,
    /// None; the format is only read.
    Never,
}

const ROWS: &[Row] = &[
    Row {
        format: Format::Glb,
        name: "glb",
        open: document::open,
        writes: WriteSupport::Any,
    },
    Row {
        format: Format::Gltf,
        name: "gltf",
        open: document::open,
        writes: WriteSupport::Never,
    },
    Row {
        format: Format::Vrm,
        name: "vrm",
        open: document::open,
        writes: WriteSupport::SameFormat,
    },
    Row {
        format: Format::Vrma,
        name: "vrma",
        open: document::open,
        writes: WriteSupport::SameFormat,
    },
    Row {
        format: Format::Fbx,
        name: "fbx",
        open: fbx::open,
        writes: WriteSupport::Never,
    },
    Row {
        format: Format::Bvh,
        name: "bvh",
        open: bvh::open,
        writes: WriteSupport::Any,
    },
    Row {
        format: Format::X3d,
        name: "x3d",
        open: x3d::open,
        writes: WriteSupport::Any,
    },
    Row {
        format: Format::X3dv,
        name: "x3dv",
        open: x3d::open,
        writes: WriteSupport::Never,
    },
    Row {
        format: Format::Wrl,
        name: "wrl",
        open: x3d::open,
        writes: WriteSupport::Never,
    },
    Row {
        format: Format::Bva,
        name: "bva",
        open: bva::open,
        writes: WriteSupport::Never,
    },
    Row {
        format: Format::Asf,
        name: "asf",
        open: acclaim::open_skeleton,
        writes: WriteSupport::Any,
    },
    Row {
        format: Format::Amc,
        name: "amc",
        open: acclaim::open_motion,
        writes: WriteSupport::Any,
    },
    Row {
        format: Format::Bap,
        name: "bap",
        open: bap::open,
        writes: WriteSupport::Any,
    },
    Row {
        format: Format::Abp,
        name: "abp",
        open: streams::open,
        writes: WriteSupport::Any,
    },
    Row {
        format: Format::Abpt,
        name: "abpt",
        open: streams::open_text,
        writes: WriteSupport::Any,
    },
    Row {
        format: Format::Mp4,
        name: "mp4",
        open: streams::open_mp4,
        writes: WriteSupport::Any,
    },
];

impl Format {
    /// Returns the format for a file name's extension.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::of_extension(extension(name)?)
    }

    /// Returns the format for a file extension, in upper or lower case, with or without the dot.
    pub fn of_extension(extension: &str) -> Option<Self> {
        let wanted = extension.trim_start_matches('.').to_ascii_lowercase();
        let row = ROWS.iter().find(|row| row.name == wanted)?;
        Some(row.format)
    }

    /// Detects the format from the first bytes; `name` distinguishes the formats that are glTF
    /// containers.
    pub fn from_bytes(bytes: &[u8], name: &str) -> Option<Self> {
        let named = Self::from_name(name);
        let first = bytes.iter().position(|b| !b.is_ascii_whitespace());
        let text = &bytes[first.unwrap_or(bytes.len())..];
        // Some editors put a byte order mark in front of text.
        let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
        let gltf = |usual| match named {
            Some(Self::Vrm | Self::Vrma) => named,
            _ => Some(usual),
        };
        if bytes.starts_with(b"glTF") {
            gltf(Self::Glb)
        } else if bytes.starts_with(b"ABPF") || bytes.starts_with(b"ABP2") {
            Some(Self::Abp)
        } else if bytes.get(4..8) == Some(b"ftyp") {
            Some(Self::Mp4)
        } else if text.starts_with(b"abpt ") {
            Some(Self::Abpt)
        } else if text.starts_with(b"{") {
            gltf(Self::Gltf)
        } else if is_fbx(bytes, text) {
            Some(Self::Fbx)
        } else if text.starts_with(b"HIERARCHY") {
            Some(Self::Bvh)
        } else if text.starts_with(b"Segment:") {
            Some(Self::Bva)
        } else if text.starts_with(b"#VRML") {
            Some(Self::Wrl)
        } else if text.starts_with(b"#X3D") {
            Some(Self::X3dv)
        } else if is_x3d(text) {
            Some(Self::X3d)
        } else {
            // The reader of the named format gives the most useful error.
            named
        }
    }

    /// Returns the name used in reports, which is also the file extension.
    pub fn name(self) -> &'static str {
        self.row().name
    }

    /// Returns whether the format is glTF 2.0 or built on it.
    pub fn is_gltf(self) -> bool {
        matches!(self, Self::Glb | Self::Gltf | Self::Vrm | Self::Vrma)
    }

    /// Returns which characters can be written in the format.
    pub fn writes(self) -> WriteSupport {
        self.row().writes
    }

    /// Returns whether a file holds a single clip, as frames of a fixed rate.
    pub fn holds_one_clip(self) -> bool {
        self.needs_a_clip() || self == Self::Asf
    }

    /// Returns whether a file has every joint in every frame, also those that rest.
    pub fn stores_every_joint(self) -> bool {
        self.holds_one_clip() && !matches!(self, Self::Abp | Self::Abpt | Self::Mp4)
    }

    /// Returns whether a file needs a clip.
    pub fn needs_a_clip(self) -> bool {
        matches!(
            self,
            Self::Bvh | Self::Amc | Self::Bap | Self::Abp | Self::Abpt | Self::Mp4
        )
    }

    pub(super) fn opener(self) -> Opener {
        self.row().open
    }

    fn row(self) -> &'static Row {
        ROWS.iter()
            .find(|row| row.format == self)
            .unwrap_or(&ROWS[0])
    }
}

/// Returns whether bytes begin like FBX; the comment at the start of its text encoding may be missing.
fn is_fbx(bytes: &[u8], text: &[u8]) -> bool {
    let line = text.split(|b| *b == b'\n').next().unwrap_or_default();
    let has = |bytes: &[u8], word: &[u8]| bytes.windows(word.len()).any(|w| w == word);
    let near = &text[..text.len().min(2048)];
    bytes.starts_with(b"Kaydara FBX Binary")
        || line.starts_with(b";") && has(line, b"FBX")
        || has(near, b"FBXHeaderExtension:")
}

/// Returns whether the bytes begin like an X3D document, or like a compressed one.
fn is_x3d(start: &[u8]) -> bool {
    const PACKED: [&[u8]; 2] = [b"\x1f\x8b", b"\xe0\x00\x00\x01"];
    // The root element follows a declaration, a document type and comments.
    let near = &start[..start.len().min(4096)];
    let names_it = near.windows(4).any(|w| w == b"<X3D");
    start.starts_with(b"<") && names_it || PACKED.iter().any(|p| start.starts_with(p))
}

/// Returns the extensions of all readable formats, as text.
pub fn readable() -> String {
    listed(ROWS.iter().map(|row| format!(".{}", row.name)))
}

/// Returns the supported conversions, as text.
pub fn conversions() -> String {
    let named = |writes| {
        let rows = ROWS.iter().filter(move |row| row.writes == writes);
        rows.map(|row| row.name.to_owned())
    };
    let back = named(WriteSupport::SameFormat).map(|name| format!("{name} to {name}"));
    format!(
        "{} to {}; {}",
        listed(ROWS.iter().map(|row| row.name.to_owned())),
        listed(named(WriteSupport::Any)),
        back.collect::<Vec<_>>().join("; ")
    )
}

fn listed(names: impl Iterator<Item = String>) -> String {
    let mut names: Vec<String> = names.collect();
    let last = names.pop().unwrap_or_default();
    if names.is_empty() {
        return last;
    }
    format!("{} or {last}", names.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_decide_and_names_refine() {
        let of = |bytes: &[u8], name: &str| Format::from_bytes(bytes, name);
        assert_eq!(of(b"glTF....", "a.bvh"), Some(Format::Glb));
        assert_eq!(of(b"glTF....", "a.VRM"), Some(Format::Vrm));
        assert_eq!(of(b" \n{\"asset\"", "a"), Some(Format::Gltf));
        assert_eq!(of(b"\xef\xbb\xbfHIERARCHY", "a.txt"), Some(Format::Bvh));
        assert_eq!(of(b"Kaydara FBX Binary  \0", "a"), Some(Format::Fbx));
        assert_eq!(of(b"; FBX 7.4.0 project file", "a"), Some(Format::Fbx));
        assert_eq!(of(b"\nFBXHeaderExtension:  {", "a"), Some(Format::Fbx));
        assert_eq!(of(b"; no such word", "a"), None);
        assert_eq!(of(b"", "a.bvh"), Some(Format::Bvh));
        assert_eq!(of(b"Segment: Hips", "a.txt"), Some(Format::Bva));
        let x3d = b"<?xml version='1.0'?>\n<X3D version='4.0'>";
        assert_eq!(of(x3d, "a.xml"), Some(Format::X3d));
        assert_eq!(of(b"<svg>", "a.svg"), None);
        assert_eq!(of(b"#VRML V2.0 utf8", "a"), Some(Format::Wrl));
        assert_eq!(of(b"#X3D V3.3 utf8", "a.x3d"), Some(Format::X3dv));
        assert_eq!(of(b"\x1f\x8b", "a.x3dz"), Some(Format::X3d));
        assert_eq!(of(b"\x89PNG", "a.png"), None);
        assert_eq!(of(b"ABPF\0\0", "a"), Some(Format::Abp));
        assert_eq!(of(b"ABP2\0\0", "a"), Some(Format::Abp));
        assert_eq!(of(b"\0\0\0\x1cftypiso6", "a"), Some(Format::Mp4));
        assert_eq!(of(b"abpt 1\n", "a.txt"), Some(Format::Abpt));
    }

    #[test]
    fn every_format_has_one_row() {
        for row in ROWS {
            assert_eq!(row.format.name(), row.name);
            let file = format!("a.{}", row.name.to_uppercase());
            assert_eq!(Format::from_name(&file), Some(row.format));
        }
        assert!(conversions().starts_with("glb, gltf"));
        assert!(conversions().ends_with("vrma to vrma"));
        assert!(readable().contains(".vrma"));
    }
}

//! Supported versions and required extensions.

use super::place::Place;
use super::reader::Notes;
use super::texture_source::is_of_textures;
use crate::error::ReadError;

/// The one extension of primitives that refers to materials alone, and not to vertices.
pub(super) const VARIANTS: &str = "KHR_materials_variants";

/// Name of the extension of skins and animations with H-Anim articulation.
pub(super) const ARTICULATION: &str = "ARTICULA_articulation";

/// Name of the extension of primitives with levels, and of the document with their table.
pub(super) const CLUSTERED_MESH: &str = "ARTICULA_clustered_mesh";

/// Name of the extension of the document with the feature points of a face.
pub(super) const FACE: &str = "ARTICULA_face";

/// Name of the extension of the document with data that is computed once.
pub(super) const PREPARED: &str = "ARTICULA_prepared";

/// Extensions that are read, or that do not affect what is read.
const READ: &[&str] = &[
    ARTICULATION,
    CLUSTERED_MESH,
    FACE,
    PREPARED,
    "EXT_meshopt_compression",
    "KHR_animation_pointer",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "MSFT_lod",
    "VRM",
];
const READ_FAMILIES: &[&str] = &[
    "KHR_avatar",
    "KHR_character",
    "KHR_materials_",
    "KHR_node_",
    "KHR_xmp",
    "VRMC_",
];

/// Returns an error for a document with an unsupported required extension, with advice to the user.
pub(super) fn check(root: &Place<'_>, notes: &mut Notes) -> Result<(), ReadError> {
    check_version(root, notes)?;
    for required in root.entries("extensionsRequired")? {
        let Some(name) = required.value().as_str() else {
            return Err(required.malformed("expected a name"));
        };
        let is_read = READ.contains(&name) || READ_FAMILIES.iter().any(|f| name.starts_with(f));
        if !is_read && !is_of_textures(root.value(), name) {
            return Err(ReadError::Unsupported {
                at: required.at(),
                what: name.to_owned(),
                mend: mend(name),
            });
        }
    }
    Ok(())
}

fn check_version(root: &Place<'_>, notes: &mut Notes) -> Result<(), ReadError> {
    if root.get("asset").is_some_and(|asset| !asset.is_object()) {
        return Err(ReadError::malformed(
            "asset",
            "expected an object such as {\"version\": \"2.0\"}",
        ));
    }
    let version = root.get("asset").map_or("", |asset| asset.text("version"));
    let least = root
        .get("asset")
        .map_or("", |asset| asset.text("minVersion"));
    if version.is_empty() {
        notes.add("asset.version", "missing; read as 2.0");
        return Ok(());
    }
    if version.starts_with("2.") && matches!(least, "" | "2.0") {
        return Ok(());
    }
    let wanted = if version.starts_with("2.") {
        least
    } else {
        version
    };
    Err(ReadError::Unsupported {
        at: "asset".to_owned(),
        what: format!(
            "glTF version {}",
            wanted.chars().take(40).collect::<String>()
        ),
        mend: "export as glTF 2.0".to_owned(),
    })
}

fn mend(name: &str) -> String {
    if name != "KHR_draco_mesh_compression" {
        let name: String = name.chars().take(80).collect();
        return format!("re-export without {name}");
    }
    // Verified: `copy` of glTF-Transform decodes the extension and removes it.
    "re-export without Draco, or run `gltf-transform copy in.glb out.glb`".to_owned()
}

//! Whether an asset is whole, and whether its parts belong to the character beside them.

use super::part::PreparedPart;
use super::write::can_be_paired;
use crate::error::Result;
use crate::figure::Figure;
use crate::motion_tables::MotionTables;
use crate::open::CharacterFile;
use crate::prepared::stored::Stored;
use articula_formats::gltf::PreparedState;
use serde::Serialize;

/// State of one part of an asset.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum PartState {
    /// It is stored and belongs to the character.
    Current,
    /// It is not stored.
    Missing,
    /// It is stored and cannot be used: damaged, of another version, or of another character.
    Stale,
    /// The character has nothing that this part describes.
    NotNeeded,
}

/// Result of checking an asset.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PreparedCheck {
    /// Program that computed the parts; empty if there are none.
    pub generator: String,
    /// State and size in bytes of each part.
    pub parts: Vec<CheckedPart>,
    /// What is wrong with the parts that are stale.
    pub warnings: Vec<String>,
}

/// A part with its state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct CheckedPart {
    /// Name of the part.
    pub part: &'static str,
    /// Its state.
    pub state: PartState,
    /// Number of bytes that it takes in the file, over all clips.
    pub bytes: usize,
}

impl PreparedCheck {
    /// Whether every part that the character needs is stored and current.
    pub fn is_whole(&self) -> bool {
        let is_good =
            |p: &CheckedPart| matches!(p.state, PartState::Current | PartState::NotNeeded);
        self.parts.iter().all(is_good)
    }
}

/// Reads every part that a file stores and checks it against the character beside it.
///
/// # Errors
/// As [`Figure::new`].
pub fn check_prepared(opened: CharacterFile) -> Result<PreparedCheck> {
    let known = opened.warnings().len();
    let figure = Figure::new(opened)?;
    let mut warnings: Vec<String> = Vec::new();
    let told = figure.opened.warnings()[known..].iter();
    warnings.extend(told.map(|w| format!("{}: {}", w.at, w.what)));
    let header = figure.opened.gltf().map(|g| g.document.prepared());
    let generator = match header {
        Some(PreparedState::Present(header)) => header.generator,
        _ => String::new(),
    };
    let stored = figure.stored();
    let usable = usable(&figure, stored.as_ref());
    let tables: Vec<MotionTables> = (0..figure.asset.clips.len())
        .map(|clip| MotionTables::stored(&figure, clip))
        .collect();
    let parts = PreparedPart::ALL.into_iter().map(|part| {
        let bytes = stored_bytes(&figure, part);
        let is_usable = match part {
            PreparedPart::JointKeys => tables.iter().all(|t| t.joint_keys.is_some()),
            PreparedPart::PoseKeys => tables.iter().all(|t| t.pose_keys.is_some()),
            PreparedPart::ErrorMatrix => tables.iter().all(|t| t.error_matrix.is_some()),
            PreparedPart::Contacts => tables.iter().all(|t| t.contacts.is_some()),
            PreparedPart::CompactClips => tables.iter().all(|t| t.compact.is_some()),
            part => usable.contains(&part),
        };
        let state = match () {
            () if !is_needed(&figure, part) => PartState::NotNeeded,
            () if bytes == 0 => PartState::Missing,
            () if is_usable => PartState::Current,
            () => PartState::Stale,
        };
        CheckedPart {
            part: part.name(),
            state,
            bytes,
        }
    });
    let parts = parts.collect();
    warnings.extend(tables.into_iter().flat_map(|t| t.warnings));
    warnings.extend(stored.map(Stored::into_warnings).into_iter().flatten());
    Ok(PreparedCheck {
        generator,
        parts,
        warnings,
    })
}

/// Whether a character has what a part describes.
fn is_needed(figure: &Figure, part: PreparedPart) -> bool {
    let asset = &figure.asset;
    let levels = figure.stored_mesh_levels();
    match part {
        _ if asset.clips.is_empty() => false,
        // It is stored where it is asked for.
        PreparedPart::CompactClips => stored_bytes(figure, part) > 0,
        PreparedPart::PairedLevels => {
            levels.is_some_and(|levels| can_be_paired(&levels)) && !asset.mesh.is_empty()
        }
        PreparedPart::JointLevels | PreparedPart::Skins | PreparedPart::PoseCache => {
            !asset.mesh.is_empty()
        }
        _ => true,
    }
}

/// Number of bytes of a part in the document.
fn stored_bytes(figure: &Figure, part: PreparedPart) -> usize {
    let Some(gltf) = figure.opened.gltf() else {
        return 0;
    };
    let document = &gltf.document;
    if let Some(table) = part.table() {
        let clips = 0..figure.asset.clips.len();
        return clips
            .filter_map(|c| document.motion_table(c, table))
            .map(<[u8]>::len)
            .sum();
    }
    let entries = part.entries().iter();
    entries
        .filter_map(|name| document.prepared_part(name))
        .map(|p| p.bytes.len())
        .sum()
}

/// Parts of `ARTICULA_prepared` that can be decoded.
fn usable(figure: &Figure, stored: Option<&Stored<'_>>) -> Vec<PreparedPart> {
    let Some(stored) = stored else {
        return Vec::new();
    };
    let asset = &figure.asset;
    let clips = asset.clips.len();
    let mut found = Vec::new();
    let has_clips = stored
        .clips(&figure.opened.character().clips, &asset.rig, &asset.mesh)
        .and_then(|own| stored.clips_in_place(&own, &asset.rig, &asset.mesh));
    found.extend(has_clips.map(|_| PreparedPart::Clips));
    if let Some(levels) = stored.joint_levels(&asset.rig, clips) {
        found.push(PreparedPart::JointLevels);
        let skins = stored.skins(&asset.mesh, &levels.joint_lods);
        found.extend(skins.map(|_| PreparedPart::Skins));
        let mesh_levels = stored.mesh_levels();
        let paired = stored.paired_levels(&levels.joint_lods, clips, mesh_levels);
        let paired_count = paired.as_ref().map(|paired| paired.levels.len());
        found.extend(paired.map(|_| PreparedPart::PairedLevels));
        let own = stored.cache_keys(false, (clips, levels.joint_lods.levels()));
        let is_paired_cached = match paired_count {
            Some(count) => stored.cache_keys(true, (clips, count)).is_some(),
            None => mesh_levels == 0,
        };
        if own.is_some() && is_paired_cached {
            found.push(PreparedPart::PoseCache);
        }
    }
    found.extend(stored.bounds(&asset.clips).map(|_| PreparedPart::Bounds));
    found
}

//! Reading characters from bytes; the format is detected from the bytes, then from the name.

#[cfg(feature = "formats")]
mod acclaim;
#[cfg(feature = "formats")]
mod bap;
#[cfg(feature = "formats")]
mod bva;
#[cfg(feature = "formats")]
mod bvh;
mod clips;
mod data;
mod data_format;
mod document;
mod edits;
mod extension;
#[cfg(feature = "fbx")]
mod fbx;
mod fitted;
mod format;
mod human;
mod keep_meshes;
mod keep_morphs;
mod mapped_joints;
mod motion;
#[cfg(feature = "streams")]
mod motion_stream;
#[cfg(not(feature = "fbx"))]
mod no_fbx;
#[cfg(not(feature = "formats"))]
mod no_formats;
#[cfg(not(feature = "streams"))]
mod no_streams;
mod options;
mod partial_skin;
#[cfg(feature = "flat")]
mod pictures;
mod size;
#[cfg(feature = "streams")]
mod streams;
#[cfg(feature = "formats")]
mod x3d;

pub use data::{Data, DataFile, open_data};
pub use data_format::DataFormat;
pub use document::GltfSource;
pub use fitted::{ClipProvenance, FittedClip, NameTransfer};
pub use format::{Format, WriteSupport, conversions, readable};
pub use human::{reference_human, reference_mannequin};
pub use options::OpenOptions;

#[cfg(not(feature = "fbx"))]
use no_fbx as fbx;
#[cfg(not(feature = "formats"))]
use no_formats::{self as acclaim, self as bap, self as bva, self as bvh, self as x3d};
#[cfg(not(feature = "streams"))]
use no_streams as streams;

use crate::error::{Context, Error, Result};
use crate::prepared::state::StoredState;
use crate::prepared::stored::Stored;
use articula_build::joint_names::JointMapping;
use articula_core::Articulation;
use articula_core::face_control::FaceMap;
use articula_core::joint_names::JointMap;
use articula_core::source::Character;
use articula_formats::mpeg4::bap::BapClip;
use articula_formats::{Resolver, Warning};
use mapped_joints::MappedJoints;

/// An opened file: its character, and the data needed to write it back.
///
/// The fields are read by the methods that have their names and changed by named edits, each of which
/// changes all that depends on it: the clips and [whether they are those of the
/// file](Self::clips_changed), the document of a glTF file, the mapping of the joints.
#[derive(Debug, Clone)]
pub struct CharacterFile {
    name: String,
    format: Format,
    bytes: usize,
    character: Character,
    clips_changed: bool,
    mapping: MappedJoints,
    gltf: Option<GltfSource>,
    end_sites: Vec<(usize, glam::Vec3)>,
    parameters: Option<BapClip>,
    warnings: Vec<Warning>,
}

/// Opens a character, or a motion with its skeleton, from bytes.
///
/// What is odd about the file is told by [`CharacterFile::warnings`]: what its reader repaired, the size
/// of the figure, pictures that are not decoded, clips whose first frame is of another pose
/// ([`CharacterFile::skip_first_frames`] leaves it out) or that turn each time they repeat.
///
/// `name` identifies the file in errors; its extension helps to detect the format. `beside`
/// resolves relative URIs of other files (buffers, pictures).
///
/// # Errors
/// An [`Error`] that names the file and the position in it: an unknown format, a malformed or
/// unsupported file, a missing referenced file, or a file without a character ([`open_data`] opens
/// MPEG-4 face files).
pub fn open(
    bytes: &[u8],
    name: &str,
    options: &OpenOptions,
    beside: &mut Resolver<'_>,
) -> Result<CharacterFile> {
    if let Some(data) = DataFormat::from_name(name) {
        return Err(Error::unsuited(data.advice())).context(name);
    }
    let Some(format) = Format::from_bytes(bytes, name) else {
        let what = format!(
            "the file format is not supported; give a {} file",
            readable()
        );
        return Err(Error::unsuited(what)).context(name);
    };
    let mut input = Input {
        name,
        format,
        bytes,
        options,
        joint_maps: &options.joint_maps,
        beside,
    };
    let mut opened = format.opener()(&mut input).context(name)?;
    #[cfg(feature = "flat")]
    let unknown = pictures::of_unknown_format(&opened);
    #[cfg(not(feature = "flat"))]
    let unknown = None;
    opened.warnings.extend(unknown);
    if let Some(map) = &options.face_map {
        let unused = tell_controls(&mut opened.character, map);
        opened.warnings.extend(unused);
    }
    let odd = clips::oddities(&opened);
    opened.warnings.extend(odd);
    if options.unit_metres.is_none() {
        let unusual = size::unusual(&opened);
        opened.warnings.extend(unusual);
    }
    Ok(opened)
}

/// Gives the names of a character the meanings of a face map; a warning if it has none of them.
fn tell_controls(character: &mut Character, map: &FaceMap) -> Option<Warning> {
    let named = |name: &String| {
        let mut meshes = character.meshes.iter();
        meshes.any(|mesh| mesh.morph_names.contains(name))
            || character.expressions.iter().any(|e| e.name == *name)
    };
    let is_used = map.controls.keys().any(named);
    character.told_controls.clone_from(&map.controls);
    (!is_used).then(|| Warning {
        at: "face map".to_owned(),
        what: "no morph target or expression of the file has a name of the face map, which is not \
               used; names are compared letter by letter"
            .to_owned(),
        guess: None,
    })
}

/// Arguments of an opener.
struct Input<'a, 'r> {
    name: &'a str,
    format: Format,
    bytes: &'a [u8],
    options: &'a OpenOptions,
    /// The caller's own joint maps.
    joint_maps: &'a [JointMap],
    beside: &'a mut Resolver<'r>,
}

/// Reads a character from one format; the caller adds the file name to errors.
type Opener = fn(&mut Input<'_, '_>) -> Result<CharacterFile>;

impl Input<'_, '_> {
    /// Creates the opened file; `given` is the map to VRM human bones, if the file has one.
    fn opened(
        &self,
        character: Character,
        warnings: Vec<Warning>,
        given: Option<&[(usize, String)]>,
    ) -> CharacterFile {
        CharacterFile {
            name: self.name.to_owned(),
            format: self.format,
            bytes: self.bytes.len(),
            mapping: MappedJoints::of_file(&character.skeleton, self.joint_maps, given),
            character,
            clips_changed: false,
            gltf: None,
            end_sites: Vec::new(),
            parameters: None,
            warnings,
        }
    }
}

impl CharacterFile {
    /// Converts the lengths of a file whose reader takes them for metres.
    #[cfg(any(feature = "formats", feature = "streams"))]
    fn scale_lengths(&mut self, unit_metres: Option<f32>) {
        let Some(factor) = unit_metres else {
            return;
        };
        self.character.scale_lengths(factor);
        self.end_sites
            .iter_mut()
            .for_each(|(_, offset)| *offset *= factor);
    }

    /// Wraps a character that was created by a program; its joints are identified by name.
    pub fn from_character(name: &str, character: Character) -> Self {
        Self {
            name: name.to_owned(),
            format: Format::Glb,
            bytes: 0,
            mapping: MappedJoints::by_name(&character.skeleton),
            character,
            clips_changed: false,
            gltf: None,
            end_sites: Vec::new(),
            parameters: None,
            warnings: Vec::new(),
        }
    }

    /// Returns the name of the file in errors and reports.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the format of the file.
    pub fn format(&self) -> Format {
        self.format
    }

    /// Returns the size of the file in bytes; 0 for a character that was created by a program.
    pub fn bytes(&self) -> usize {
        self.bytes
    }

    /// Returns skeleton, meshes, clips and expressions, in metres, +Y up, facing +Z.
    pub fn character(&self) -> &Character {
        &self.character
    }

    /// Returns skeleton, meshes, clips and expressions without the file.
    pub fn into_character(self) -> Character {
        self.character
    }

    /// Returns whether the clips differ from those in the glTF document or the BAP parameters, which
    /// are then written from those of the character.
    pub fn clips_changed(&self) -> bool {
        self.clips_changed
    }

    /// Returns the H-Anim joint, level and region of the joints, from the file's own map or from joint
    /// names.
    ///
    /// It is found when it is first asked for, of the joints as they were when the file was opened.
    pub fn mapping(&self) -> &JointMapping {
        self.mapping.get()
    }

    /// Returns the document of a glTF file, which is preserved when it is written; `None` for other
    /// formats.
    pub fn gltf(&self) -> Option<&GltfSource> {
        self.gltf.as_ref()
    }

    /// Whether the data that the document stores belong to the character; of a character without all of
    /// its meshes, whether they did before these were removed.
    pub(crate) fn stored_state(&self) -> StoredState {
        let Some(gltf) = &self.gltf else {
            return StoredState::default();
        };
        if let Some(kept) = &gltf.kept_meshes {
            return kept.state.clone();
        }
        let articulation = self.articulation();
        StoredState::of(
            &gltf.document,
            &self.character,
            &articulation,
            self.clips_changed,
        )
    }

    /// The prepared data that the document stores, if it can be read.
    pub(crate) fn stored(&self) -> Option<Stored<'_>> {
        let gltf = self.gltf.as_ref()?;
        Stored::of(&gltf.document, &self.character.meshes)
    }

    /// Returns the joint index and the offset in metres of each end site of a BVH, ASF or X3D file.
    pub fn end_sites(&self) -> &[(usize, glam::Vec3)] {
        &self.end_sites
    }

    /// Returns the parameters of a BAP file.
    pub fn parameters(&self) -> Option<&BapClip> {
        self.parameters.as_ref()
    }

    /// Returns the warnings about the file.
    pub fn warnings(&self) -> &[Warning] {
        &self.warnings
    }

    /// Returns the H-Anim joint, level and region of every joint, as stored in the file or derived
    /// from joint names.
    pub fn articulation(&self) -> Articulation {
        let stored = self.character.articulation.clone();
        stored.unwrap_or_else(|| self.mapping().articulation.clone())
    }
}

/// Returns the index of `wanted` among the given names; `what` names their kind in the error.
///
/// # Errors
/// [`Error::Argument`] that lists the names, if it is not among them.
pub fn choose<'a>(
    what: &str,
    wanted: &str,
    names: impl Iterator<Item = &'a str> + Clone,
) -> Result<usize> {
    if let Some(found) = names.clone().position(|n| n == wanted) {
        return Ok(found);
    }
    let mut known: Vec<String> = names.map(|n| format!("\"{n}\"")).collect();
    let count = known.len();
    known.truncate(30);
    if count > known.len() {
        known.push(format!(
            "and {} more (inspect lists them)",
            count - known.len()
        ));
    }
    let known = if count == 0 {
        "the file has none".to_owned()
    } else {
        format!("the file has {}", known.join(", "))
    };
    Err(Error::argument(format!(
        "there is no {what} \"{wanted}\"; {known}"
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_name_is_answered_with_the_right_ones() {
        let names = ["walk", "run"];
        assert_eq!(choose("clip", "run", names.into_iter()).unwrap(), 1);
        let why = choose("clip", "fly", names.into_iter()).unwrap_err();
        assert!(why.to_string().contains("the file has \"walk\", \"run\""));
        assert!(why.is_argument());
    }
}

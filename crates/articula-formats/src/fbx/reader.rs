//! Conversion of the bytes of a file to a character.

use super::kinds::Kinds;
use super::look::Looks;
use super::repair::repair;
use super::scene::Scene;
use super::source::Reader;
use super::{clips, skeleton, surface, takes};
use crate::Resolver;
use crate::error::{Parsed, ReadError};
use crate::limits::Limits;
use crate::motion_file::ReadOptions;
use crate::notes::Notes;
use articula_core::source::{Character, Credits};

/// Content of an FBX file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FbxFile {
    /// Skeleton, meshes, clips and materials, in metres, +Y up; the nodes of bones are `in_skin`.
    pub character: Character,
    /// Frames per second by which the program that wrote the file shows it.
    pub rate_hz: f32,
}

/// Reads an FBX file, in the binary or the text encoding, of version 5.8 to 7.7.
///
/// The resolver is called for pictures with their paths relative to the file, with the last part of their
/// paths, and with that in the folder `<stem>.fbm`, where `stem` is the file's name without its extension; it
/// alone decides what may be opened.
///
/// - *Rest pose*: the one in which the skins were bound; where the file's fields define another pose, each clip
///   holds it, and without a clip it is a clip of its own, `pose`. Without a skin it is the one of the fields.
/// - *Clips*: one for each take that moves anything, as frames of the file's own rate.
///
/// ```
/// use articula_formats::{Limits, ReadOptions, fbx};
///
/// let file = br#"; FBX 7.4.0 project file
/// Objects:  {
///     NodeAttribute: 1, "NodeAttribute::", "LimbNode" {
///     }
///     Model: 2, "Model::mixamorig:Hips", "LimbNode" {
///         Properties70:  {
///             P: "Lcl Translation", "Lcl Translation", "", "A",0,98,0
///         }
///     }
/// }
/// Connections:  {
///     C: "OO",1,2
///     C: "OO",2,0
/// }
/// "#;
/// let mut nothing_beside = |name: &str| Err(format!("{name}: no such file"));
/// let options = ReadOptions::default();
/// let read = fbx::read(file, "hero", &options, &Limits::default(), &mut nothing_beside)?;
/// let hips = &read.value.character.skeleton.joints[0];
/// assert_eq!(hips.name, "mixamorig:Hips");
/// assert!((hips.rest.translation.y - 0.98).abs() < 1e-6);
/// # Ok::<(), articula_formats::ReadError>(())
/// ```
///
/// # Errors
/// [`ReadError::Malformed`] that names the byte or line, or the object; [`ReadError::Unsupported`] for other
/// versions and files without a node; [`ReadError::LimitExceeded`].
pub fn read(
    bytes: &[u8],
    stem: &str,
    options: &ReadOptions,
    limits: &Limits,
    resolver: &mut Resolver<'_>,
) -> Result<Parsed<FbxFile>, ReadError> {
    Limits::check("file", "bytes", bytes.len() as u64, limits.bytes)?;
    let mut kinds = Kinds::default();
    let depth = usize::try_from(limits.depth).unwrap_or(usize::MAX);
    let repaired = repair(bytes, depth, &mut kinds);
    let at = repaired
        .odd
        .map_or_else(|| "file".to_owned(), |place| place.to_string());
    let scene = Scene::load(&repaired.bytes, limits, &at)?;
    let mut reader = Reader::new(&scene, limits, kinds);
    tell(&mut reader);
    let takes = takes::sampled(&mut reader)?;
    let bones = skeleton::bones(&mut reader, &takes)?;
    let mut looks = Looks::new(resolver, stem);
    let shown = surface::meshes(&mut reader, &bones, &repaired.geometric, &mut looks)?;
    let clips = clips::finished(&mut reader, &bones, &shown, takes)?;
    let creator = scene.creator();
    let mut character = Character {
        skeleton: bones.skeleton,
        meshes: shown.meshes,
        clips,
        materials: looks.materials,
        images: looks.images,
        credits: (!creator.is_empty()).then(|| Credits {
            generator: creator.to_owned(),
            ..Credits::default()
        }),
        ..Character::default()
    };
    if let Some(wanted) = options.scale_to_metres {
        let stated = repaired.unit_metres.unwrap_or(0.01);
        character.scale_lengths((f64::from(wanted) / stated) as f32);
    }
    let mut notes = Notes::default();
    reader.kinds.tell(&mut notes);
    Ok(Parsed {
        value: FbxFile {
            rate_hz: scene.rate_hz() as f32,
            character,
        },
        warnings: notes.into_list(),
    })
}

/// Notes what is not read.
fn tell(reader: &mut Reader<'_>) {
    let place = || "scene".to_owned();
    let (scene, kinds) = (reader.scene, &mut reader.kinds);
    for what in scene.left_out() {
        kinds.note(place, what);
    }
    let [cameras, lights] = scene.cameras_and_lights();
    kinds.note_all(place, "a camera is not read", cameras);
    kinds.note_all(place, "a light is not read", lights);
    let what = "a mesh or a material cannot be read whole; what can be is";
    kinds.note_all(place, what, scene.faults());
}

//! Conversion of the bytes of a file to a character.

use super::fields::Reader;
use super::look::Looks;
use super::scene::Builder;
use super::{classic, clips, credits, figure, frames, meshes, xml};
use crate::Resolver;
use crate::error::{Parsed, ReadError};
use crate::limits::Limits;
use articula_core::source::Character;
use glam::Vec3;

/// A named position on a joint, such as a finger tip.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Site {
    /// Joint of the character's skeleton.
    pub joint: usize,
    /// Name as in the file.
    pub name: String,
    /// Offset from the joint in metres, in the joint's space.
    pub offset: Vec3,
}

/// Content of an X3D file: its first humanoid.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct X3dFile {
    /// Skeleton, meshes, clips and materials; every H-Anim joint is `in_skin`.
    pub character: Character,
    /// Sites, in the order of the file.
    pub sites: Vec<Site>,
}

/// Reads the first humanoid of an X3D or VRML97 file, in the XML or the classic encoding.
///
/// The resolver is called for pictures with the names that the file gives, and with the last part
/// of a remote address; it alone decides what may be opened. Nothing else is ever fetched.
///
/// - *Rest pose*: that of the standard, every joint at its center and unrotated. Where the file's
///   fields define another pose, each clip holds it; without a clip it is the rest pose.
/// - *Meshes*: one for each segment with triangles, then one for the skin.
/// - *Clips*: `HAnimMotion`s, then time sensors that move the figure, then `HAnimPose`s.
///
/// ```
/// use articula_formats::{Limits, x3d};
///
/// let file = br#"<X3D version="4.0"><Scene><HAnimHumanoid name="Ann">
///     <HAnimJoint name="humanoid_root" center="0 0.9 0" containerField="skeleton">
///         <HAnimJoint name="l_hip" center="0.1 0.8 0"/>
///     </HAnimJoint></HAnimHumanoid></Scene></X3D>"#;
/// let mut nothing_beside = |name: &str| Err(format!("{name}: no such file"));
/// let read = x3d::read(file, &Limits::default(), &mut nothing_beside)?;
/// let hip = &read.value.character.skeleton.joints[1];
/// assert_eq!((hip.name.as_str(), hip.parent), ("l_hip", Some(0)));
/// assert!((hip.rest.translation.y + 0.1).abs() < 1e-6);
/// # Ok::<(), articula_formats::ReadError>(())
/// ```
///
/// # Errors
/// [`ReadError::Malformed`] naming the line and node, [`ReadError::Unsupported`] for other
/// encodings, for XML with an internal document type and for scenes without a humanoid,
/// [`ReadError::LimitExceeded`].
pub fn read(
    bytes: &[u8],
    limits: &Limits,
    resolver: &mut Resolver<'_>,
) -> Result<Parsed<X3dFile>, ReadError> {
    Limits::check("file", "bytes", bytes.len() as u64, limits.bytes)?;
    refuse_other_encodings(bytes)?;
    let text = String::from_utf8_lossy(bytes);
    let text = text.trim_start_matches('\u{feff}');
    let Builder { scene, notes, .. } = match text.trim_start().starts_with('<') {
        true => xml::parse(text, limits)?,
        false => classic::parse(text, limits)?,
    };
    let mut reader = Reader::new(&scene, limits, notes);
    let figure = figure::find(&mut reader)?;
    let mut frames = frames::Frames::new(&mut reader, &figure)?;
    let mut looks = Looks::new(resolver);
    let shown = meshes::read_all(&mut reader, &figure, &frames, &mut looks)?;
    let (materials, images) = (looks.materials, looks.images);
    let clips = clips::read_all(&mut reader, &figure, &frames, &shown)?;
    if clips.is_empty() {
        frames.rest_as_stored();
    }
    let offset = |site: &figure::FigureSite| {
        let in_model = figure.world.transform_point3(site.position).as_vec3();
        frames.rigid[site.joint].transform_point3(in_model)
    };
    let sites = figure.sites.iter().map(|site| Site {
        joint: site.joint + frames.first,
        name: site.name.clone(),
        offset: offset(site),
    });
    let value = X3dFile {
        sites: sites.collect(),
        character: Character {
            name: reader.spelled_name(figure.id),
            skeleton: frames.skeleton,
            meshes: shown.meshes,
            clips,
            credits: credits::read(&mut reader, figure.id)?,
            materials,
            images,
            ..Character::default()
        },
    };
    Ok(Parsed {
        value,
        warnings: reader.notes.into_list(),
    })
}

/// Returns an error with advice for files in other encodings of X3D.
fn refuse_other_encodings(bytes: &[u8]) -> Result<(), ReadError> {
    let (what, mend) = match bytes {
        [0x1f, 0x8b, ..] => ("a compressed file", "decompress it with gunzip first"),
        [0xe0, 0x00, 0x00, 0x01, ..] => (
            "the binary encoding of X3D",
            "save it as .x3d (XML) or .x3dv (classic)",
        ),
        [0xfe, 0xff, ..] | [0xff, 0xfe, ..] => ("text in UTF-16", "save it as UTF-8"),
        _ => return Ok(()),
    };
    Err(ReadError::Unsupported {
        at: "the start of the file".to_owned(),
        what: what.to_owned(),
        mend: mend.to_owned(),
    })
}

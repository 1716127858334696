//! Encoding of motions and faces as streams, alone, as text or in MP4 files.

use super::left_out::{EncodedFile, LossyPart, meshes};
use super::{ConvertOptions, faps};
use crate::clip_streams::{abp1, abp2, afp1, afp2, fba};
use crate::error::{Error, Result};
use crate::open::{CharacterFile, DataFormat, Format};
use articula_core::face_levels::FaceLevels;
use articula_formats::mpeg4::fap::FapClip;
use articula_stream::StreamLimits;
use articula_stream::abp1::Abp1Options;
use articula_stream::abp2::MotionOptions;
use articula_stream::afp1::Afp1Options;
use articula_stream::afp2::Afp2Options;
use articula_stream::fba::FbaOptions;

/// Profile of an `.abp` file or of the stream in an `.mp4` file, with its options.
#[derive(Debug, Clone, PartialEq)]
pub enum AbpProfile {
    /// ABP-1: bones, BBA-style.
    Abp1(Abp1Options),
    /// ABP-2: a motion within a tolerance of the skin.
    Abp2(MotionOptions),
}

/// Profile of an `.afp` file or of the stream in an `.mp4` file, with its options.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AfpProfile {
    /// AFP-1: parameters that can be cut one by one, in steps of the standard's table.
    Afp1(Afp1Options),
    /// AFP-2: parameters within a tolerance of feature points.
    Afp2(Afp2Options),
}

/// AFP-2 with its defaults.
impl Default for AfpProfile {
    fn default() -> Self {
        Self::Afp2(Afp2Options::default())
    }
}

impl AfpProfile {
    /// Returns this profile with the parameters that these levels keep.
    #[must_use]
    pub fn with_levels(self, levels: FaceLevels) -> Self {
        match self {
            Self::Afp1(options) => Self::Afp1(Afp1Options { levels, ..options }),
            Self::Afp2(options) => Self::Afp2(Afp2Options { levels, ..options }),
        }
    }
}

impl ConvertOptions {
    /// Whether a file of a format holds a motion stream (ABP-2), whose clip a receiver plays as that of
    /// an asset.
    pub(super) fn writes_motion_stream(&self, format: Format) -> bool {
        let is_stream = matches!(format, Format::Abp | Format::Mp4);
        is_stream && !matches!(self.abp, Some(AbpProfile::Abp1(_)))
    }

    /// Checks that a file of a format has a stream, if a profile was given.
    pub(super) fn check_profile(&self, to: Format) -> Result<()> {
        if self.abp.is_some() && !matches!(to, Format::Abp | Format::Mp4) {
            return Err(Error::argument(format!(
                "the profile of a stream needs an .abp or .mp4 file, not .{}",
                to.name()
            )));
        }
        Ok(())
    }
}

/// Writes a FAP clip as a FAP file, an FBA stream, or an AFP stream of the given profile, which alone
/// has options, as such or in an MP4 file.
///
/// # Errors
/// An [`Error`] if the rate, the frames or a value cannot be written, or the format is of another
/// kind of data.
pub fn write_faps(clip: &FapClip, format: DataFormat, profile: &AfpProfile) -> Result<EncodedFile> {
    if format == DataFormat::Mp4 {
        return boxed(write_faps(clip, DataFormat::Afp, profile)?);
    }
    let mut tiers = Vec::new();
    let (bytes, left_out) = match (format, profile) {
        (DataFormat::Fap, _) => return Ok(faps::written(clip)),
        (DataFormat::Fba, _) => (fba::write(clip, &FbaOptions::default())?, columns(clip)),
        (DataFormat::Afp, AfpProfile::Afp1(options)) => (afp1::write(clip, options)?, None),
        (DataFormat::Afp, AfpProfile::Afp2(options)) => {
            let coded = afp2::write(clip, options)?;
            tiers = abp2::tiers(&coded, options.tolerance_metres)?;
            (coded.bytes, None)
        }
        _ => return Err(Error::unsuited(format.advice())),
    };
    Ok(EncodedFile {
        tiers,
        ..EncodedFile::new(bytes, left_out)
    })
}

/// Writes a motion as a stream, its text, or an MP4 file with it.
pub(super) fn written(
    opened: &CharacterFile,
    format: Format,
    options: &ConvertOptions,
) -> Result<EncodedFile> {
    match format {
        Format::Mp4 => boxed(stream(opened, Format::Abp, options)?),
        _ => stream(opened, format, options),
    }
}

/// The name of the columns by which blend shapes became parameters, which FBA cannot hold.
fn columns(clip: &FapClip) -> Option<LossyPart> {
    let name = clip.bridge.as_ref()?;
    let what =
        format!("the name of the columns of the blend shapes, {name} (.fap and .afp hold it)");
    Some(LossyPart::Note(what))
}

/// A stream of the first clip, or its text.
fn stream(opened: &CharacterFile, format: Format, options: &ConvertOptions) -> Result<EncodedFile> {
    let plain = AbpProfile::Abp2(MotionOptions::default());
    match (format, options.abp.as_ref().unwrap_or(&plain)) {
        (Format::Abpt, _) => {
            let clip = abp1::from_character(opened.character(), &opened.articulation(), 0)?;
            let bytes = articula_stream::abp1::write_text(&clip)?.into_bytes();
            Ok(bones(opened, bytes))
        }
        (_, AbpProfile::Abp1(options)) => {
            let articulation = opened.articulation();
            let bytes = abp1::write(opened.character(), &articulation, 0, options)?;
            Ok(bones(opened, bytes))
        }
        (_, AbpProfile::Abp2(options)) => {
            let coded = abp2::write(opened.character(), &opened.articulation(), 0, options)?;
            Ok(EncodedFile {
                tiers: abp2::tiers(&coded, options.tolerance_metres)?,
                bytes: coded.bytes,
                ..EncodedFile::default()
            })
        }
    }
}

/// A stream in an MP4 file.
fn boxed(stream: EncodedFile) -> Result<EncodedFile> {
    let bytes = articula_stream::mp4::write(&[&stream.bytes], &StreamLimits::default())?;
    Ok(EncodedFile { bytes, ..stream })
}

/// A stream of bones, with what it cannot hold.
fn bones(opened: &CharacterFile, bytes: Vec<u8>) -> EncodedFile {
    let sites = opened.end_sites().len();
    let sites = (sites > 0).then(|| format!("the ends of {sites} joints"));
    let channels = opened
        .character()
        .clips
        .iter()
        .flat_map(|clip| &clip.channels);
    let others = channels.filter(|c| !c.property.is_of_joint()).count();
    let others = (others > 0).then(|| "motion of morph targets and expressions".to_owned());
    let notes = sites.into_iter().chain(others).map(LossyPart::Note);
    EncodedFile::new(bytes, meshes(opened).into_iter().chain(notes))
}

//! BAP files: humanoid motion as MPEG-4 body animation parameters.

use super::left_out::{EncodedFile, LossyPart, meshes};
use crate::error::Result;
use crate::open::CharacterFile;
use crate::resampling::first_clip_rate_hz;
use articula_build::retarget::{RetargetFigure, RetargetOptions, Retargeter};
use articula_core::source::Character;
use articula_formats::joint_map;
use articula_formats::mpeg4::bap::{self, BapResidual};

/// Writes the first clip as a BAP file; parameters that were read from one are written unchanged.
pub(super) fn written(opened: &CharacterFile) -> Result<EncodedFile> {
    if let Some(parameters) = opened.parameters() {
        if !opened.clips_changed() {
            return Ok(EncodedFile {
                bytes: bap::write(parameters),
                ..EncodedFile::default()
            });
        }
        return parameters_of(opened.character(), opened);
    }
    let mut figure = bap::figure();
    let standard = articula_build::joint_names::map(&figure.skeleton, joint_map::builtin(), None);
    let clip = &opened.character().clips[0];
    let source = RetargetFigure {
        skeleton: &opened.character().skeleton,
        articulation: &opened.mapping().articulation,
        clips: &opened.character().clips,
    };
    let target = RetargetFigure {
        skeleton: &figure.skeleton,
        articulation: &standard.articulation,
        clips: &[],
    };
    let moved = Retargeter::new(source, target)?.retarget(clip, &RetargetOptions::default())?;
    figure.clips.push(moved.clip);
    parameters_of(&figure, opened)
}

/// Converts the motion of the standard humanoid to a BAP file; `source` has the data that BAP
/// cannot hold.
fn parameters_of(figure: &Character, source: &CharacterFile) -> Result<EncodedFile> {
    let standard = articula_build::joint_names::map(&figure.skeleton, joint_map::builtin(), None);
    let sampled = bap::sample(
        figure,
        &standard.articulation,
        0,
        first_clip_rate_hz(source.character()),
    )?;
    let unsaid = unsaid(&sampled.residuals);
    let left_out = meshes(source).into_iter().chain(unsaid);
    Ok(EncodedFile::new(bap::write(&sampled.clip), left_out))
}

/// Rotations that no parameter represents.
fn unsaid(residuals: &[BapResidual]) -> Option<LossyPart> {
    let worst = residuals.first()?;
    Some(LossyPart::Rotations {
        joints: residuals.len(),
        most: worst.joint.to_owned(),
        max_radians: worst.max_radians,
    })
}

//! BAP files: any humanoid's motion as body animation parameters.

use super::written::left;
use crate::load::Loaded;
use crate::table::counted;
use articula_build::retarget::{self, Figure, RetargetOptions};
use articula_build::source_rate_hz;
use articula_core::source::Character;
use articula_formats::mpeg4::bap::{self, Residual};
use articula_formats::profile;

/// A BAP file of the first clip; parameters that were read are written as they were.
pub(super) fn written(
    loaded: &Loaded,
    clips_changed: bool,
) -> anyhow::Result<(Vec<u8>, Vec<String>)> {
    if let Some(parameters) = &loaded.parameters {
        if !clips_changed {
            return Ok((bap::write(parameters), Vec::new()));
        }
        return parameters_of(&loaded.character, &loaded.character);
    }
    let mut figure = bap::figure();
    let standard = articula_build::joint_names::map(&figure.skeleton, profile::builtin(), None);
    let clip = &loaded.character.clips[0];
    let source = Figure {
        skeleton: &loaded.character.skeleton,
        articulation: &loaded.mapping.articulation,
    };
    let target = Figure {
        skeleton: &figure.skeleton,
        articulation: &standard.articulation,
    };
    let moved = retarget::retarget(source, target, clip, &RetargetOptions::default())?;
    figure.clips.push(moved.clip);
    parameters_of(&figure, &loaded.character)
}

/// What the standard humanoid does as a BAP file; `source` has what no BAP file holds.
fn parameters_of(figure: &Character, source: &Character) -> anyhow::Result<(Vec<u8>, Vec<String>)> {
    let standard = articula_build::joint_names::map(&figure.skeleton, profile::builtin(), None);
    let rate_hz = source.clips.first().map_or(30.0, source_rate_hz);
    let sampled = bap::sample(figure, &standard.articulation, 0, rate_hz)?;
    let meshes = source.meshes.len();
    let meshes = left((meshes, "mesh", "meshes"), "BAP holds one clip of a body");
    let unsaid = unsaid(&sampled.residuals);
    Ok((
        bap::write(&sampled.clip),
        meshes.into_iter().chain(unsaid).collect(),
    ))
}

/// Turns that no parameter says.
fn unsaid(residuals: &[Residual]) -> Option<String> {
    let worst = residuals.first()?;
    Some(format!(
        "turns of {} of up to {:.1} degrees, most at {} (BAP has no parameter for them)",
        counted(residuals.len(), "joint", "joints"),
        worst.max_radians.to_degrees(),
        worst.joint
    ))
}

//! Facial animation parameters read off a moving face.
//!
//! A parameter is the displacement of one feature point along one direction, whatever moves it: joints,
//! morph targets or both.

use super::found::FoundFace;
use super::frames::{file_name, rounded};
use super::rig::NOT_MEASURED;
use super::turns::turns;
use crate::error::{Context, Error, Result};
use crate::figure::Figure;
use articula_core::fap_table::FAP_COUNT;
use articula_core::{
    LocalPose, ModelPose, PosedMesh, SkinnedMesh, Wrap, local_to_model, sample, sample_morphs,
};
use articula_formats::mpeg4::fap::{FapClip, FapFrame};
use glam::{Affine3A, Vec3};

/// Reads the parameters of a face off its feature points in each frame of one of the figure's clips,
/// relative to the rest pose and in units of the face; those of head and eyes off their joints. `name`
/// becomes that of the FAP clip.
///
/// Tongue, pupils and thrust of the eyeballs are not measured.
///
/// # Errors
/// [`Error::Unsupported`] that names the file, if it shows too little of a face, its feature points may
/// be wrong, or the clip moves nothing of it.
///
/// # Panics
/// If there is no such clip.
pub fn measure_faps(figure: &Figure, clip: usize, name: &str) -> Result<FapClip> {
    measured(figure, clip, name).context(figure.opened.name())
}

fn measured(figure: &Figure, clip: usize, name: &str) -> Result<FapClip> {
    let asset = &figure.asset;
    let face = FoundFace::of(figure, &[])?;
    let doubtful = face.doubtful();
    if !doubtful.is_empty() {
        let what = format!(
            "face: the units {} may be wrong, so its motion is not measured; give the asset the right feature points",
            doubtful.join(", ")
        );
        return Err(Error::unsuited(what));
    }
    let table = face.table()?;
    let turns = turns(&figure.opened, true);
    let head = asset.rig.articulation().find("skullbase");
    let to_head = face.head.model_from_head.inverse();
    let mut posed = PosedMesh::new(&asset.rig, &asset.mesh);
    let mut rest_model = ModelPose::new(asset.rig.len());
    local_to_model(&asset.rig, asset.rig.rest_pose(), &mut rest_model);
    let rest = posed
        .pose(asset.rig.rest_pose())
        .skinned(&vec![0.0; asset.mesh.morph_weights.len()]);
    let of_rest = head.map_or(Affine3A::IDENTITY, |head| rest_model.matrices[head]);

    let clip = &asset.clips[clip];
    let mut local: LocalPose = asset.rig.rest_pose().clone();
    let mut weights = asset.mesh.morph_weights.clone();
    let mut skinned = SkinnedMesh::new(&asset.mesh);
    let frame = |index: usize| {
        let secs = index as f64 / f64::from(clip.rate_hz());
        local.copy_from(asset.rig.rest_pose());
        weights.copy_from_slice(&asset.mesh.morph_weights);
        sample(clip, secs, Wrap::Clamp, &asset.rig.all(), &mut local);
        sample_morphs(clip, secs, Wrap::Clamp, &mut weights);
        posed.pose(&local).skin(&weights, &mut skinned);
        // Back to where the head is at rest.
        let now = head.map_or(Affine3A::IDENTITY, |head| posed.model.matrices[head]);
        let back = of_rest * now.inverse();
        let offset = |vertex: &u32| {
            let at = back.transform_point3(skinned.positions[*vertex as usize]);
            to_head * (at - rest.positions[*vertex as usize])
        };
        let offsets: Vec<Vec3> = face.head.vertices.iter().map(offset).collect();
        let mut values = table.values(&face.points, &offsets);
        for fap in NOT_MEASURED.into_iter().flatten().chain(48..=50) {
            values.set(fap, 0.0);
        }
        for turn in &turns {
            turn.read(local.rotations[turn.joint()], &mut values);
        }
        FapFrame {
            number: index as u32,
            low: rounded(&values),
            ..FapFrame::default()
        }
    };
    let mut made = FapClip {
        name: file_name(name),
        rate_hz: clip.rate_hz(),
        coded: [false; FAP_COUNT],
        frames: (0..clip.frames()).map(frame).collect(),
        bridge: None,
    };
    made.coded = made.moving();
    if !made.coded.contains(&true) {
        let what = format!("clip \"{}\" moves nothing of the face", clip.name);
        return Err(Error::unsuited(what));
    }
    Ok(made)
}

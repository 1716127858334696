//! The levels of a crowd that show morph targets, and the errors of those whose faces rest.
//!
//! A level whose error is at least twice what a face at rest adds leaves the morph targets out, and
//! so do the coarser ones. Their errors then include the face, so that a tolerance holds for it too:
//! at most half as much again.

use articula_build::Asset;
use articula_core::crowd::MorphClips;
use articula_core::{
    Clip, LodErrors, Mesh, Mismatch, ModelPose, Wrap, local_to_model, lod_error_metres, palette,
    percentile, sample_morphs,
};
use glam::{Affine3A, Mat3A, Vec3, Vec3A};

/// Share of a level's error that a face at rest may add.
const REST_SHARE: f32 = 0.5;

/// Maximum number of frames of a clip at which faces are compared with a face at rest.
const FRAMES: usize = 24;

/// Lays out the morph target weights of the clips, and adds the error of faces at rest to the levels
/// that show none. `None` if no clip moves a morph target.
pub(super) fn morph_clips(
    asset: &Asset,
    errors: &mut LodErrors,
) -> Result<Option<MorphClips>, Mismatch> {
    let moves = |clip: &Clip| !clip.tracks().morphs.is_empty();
    if asset.mesh.morphs.is_empty() || !asset.clips.iter().any(moves) {
        return Ok(None);
    }
    let faces = RestingFaces::new(asset);
    let at_rest: Vec<RestError> = asset.clips.iter().map(|c| faces.error(c)).collect();
    let levels = errors.clips.first().map_or(1, |c| c.levels_metres.len());
    let rests = |level: &usize| {
        errors.clips.iter().zip(&at_rest).all(|(clip, face)| {
            let own = lod_error_metres(clip.levels_metres[*level], clip.worst_metres[*level]);
            let face = lod_error_metres(face.p95_metres, face.worst_metres);
            face <= REST_SHARE * own
        })
    };
    // Level 0 is the full character.
    let shown = (1..levels).find(rests).unwrap_or(levels);
    for (clip, face) in errors.clips.iter_mut().zip(&at_rest) {
        for level in shown..levels {
            clip.levels_metres[level] += face.p95_metres;
            clip.worst_metres[level] += face.worst_metres;
        }
    }
    let morphs = MorphClips::new(&asset.clips, &asset.mesh.morph_weights, shown)?;
    Ok(Some(morphs).filter(|m| m.levels() > 0))
}

/// Distance of a skin with morph targets at rest from one that shows them, over a clip.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct RestError {
    /// Per frame the 95th percentile over vertices, then the maximum over frames.
    p95_metres: f32,
    /// Maximum over vertices and frames.
    worst_metres: f32,
}

/// The skin of a character in its rest pose, to see what morph targets add to it.
struct RestingFaces<'a> {
    mesh: &'a Mesh,
    /// Linear part of each vertex's skinning matrix.
    skins: Vec<Mat3A>,
}

impl<'a> RestingFaces<'a> {
    fn new(asset: &'a Asset) -> Self {
        let mesh = &asset.mesh;
        let mut model = ModelPose::new(asset.rig.len());
        local_to_model(&asset.rig, asset.rig.rest_pose(), &mut model);
        let mut matrices = vec![Affine3A::IDENTITY; mesh.bindings.len()];
        palette(mesh, &model, &mut matrices);
        let skins = (0..mesh.len()).map(|v| {
            let of = v * mesh.influences..(v + 1) * mesh.influences;
            let each = mesh.binding_indices[of.clone()]
                .iter()
                .zip(&mesh.weights[of]);
            let parts = each.map(|(b, weight)| matrices[usize::from(*b)].matrix3 * *weight);
            parts.fold(Mat3A::ZERO, |sum, part| sum + part)
        });
        Self {
            skins: skins.collect(),
            mesh,
        }
    }

    fn error(&self, clip: &Clip) -> RestError {
        let mut found = RestError::default();
        if clip.tracks().morphs.is_empty() {
            return found;
        }
        let rest = &self.mesh.morph_weights;
        let count = clip.frames().min(FRAMES);
        for i in 0..count {
            let frame = i * (clip.frames() - 1) / (count - 1).max(1);
            let secs = frame as f64 / f64::from(clip.rate_hz());
            let mut weights = rest.clone();
            sample_morphs(clip, secs, Wrap::Clamp, &mut weights);
            let mut offsets = vec![Vec3::ZERO; self.mesh.len()];
            for morph in &self.mesh.morphs {
                let slot = usize::from(morph.slot);
                let more = weights[slot] - rest[slot];
                if more != 0.0 {
                    for (v, offset) in morph.vertices.iter().zip(&morph.positions) {
                        offsets[*v as usize] += *offset * more;
                    }
                }
            }
            let lengths = offsets.iter().zip(&self.skins);
            let mut lengths: Vec<f32> = lengths
                .map(|(offset, skin)| (*skin * Vec3A::from(*offset)).length())
                .collect();
            found.worst_metres = lengths.iter().copied().fold(found.worst_metres, f32::max);
            found.p95_metres = found.p95_metres.max(percentile(&mut lengths, 0.95));
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::source::{Joint, Skeleton};
    use articula_core::{
        Articulation, Binding, ClipLodErrors, JointArticulation, Morph, Region, Rig, Track, Tracks,
        Transform,
    };

    /// A thousand vertices on one joint, in centimetres, of which a target moves the first ten by
    /// 2 cm, with a clip that drives it from `from` to `to`, and one without morph tracks.
    fn asset(from: f32, to: f32) -> Asset {
        let skeleton = Skeleton {
            joints: vec![Joint {
                name: "head".into(),
                parent: None,
                rest: Transform::IDENTITY,
                in_skin: true,
            }],
        };
        let articulation = Articulation {
            profile: String::new(),
            joints: vec![JointArticulation {
                hanim: None,
                level: 0,
                region: Region::Torso,
            }],
        };
        let mesh = Mesh {
            positions: vec![Vec3::ZERO; 1000],
            normals: vec![Vec3::Y; 1000],
            influences: 1,
            binding_indices: vec![0; 1000],
            weights: vec![1.0; 1000],
            bindings: vec![Binding {
                joint: 0,
                inverse_bind: Affine3A::from_scale(Vec3::splat(0.01)),
            }],
            morphs: vec![Morph {
                slot: 0,
                vertices: (0..10).collect(),
                positions: vec![Vec3::X * 2.0; 10],
                normals: vec![Vec3::ZERO; 10],
            }],
            morph_weights: vec![0.25],
            morph_slots: vec![0],
            ..Mesh::default()
        };
        let clip = |morphs| {
            let tracks = Tracks {
                morphs,
                ..Tracks::default()
            };
            Clip::new("clip", 30.0, 101, 1, tracks).unwrap()
        };
        let weight = |f: usize| from + (to - from) * f as f32 / 100.0;
        let track = Track {
            target: 0,
            step: false,
            values: (0..101).map(weight).collect(),
        };
        Asset {
            rig: Rig::new(&skeleton, articulation).unwrap(),
            mesh,
            clips: vec![clip(vec![track]), clip(Vec::new())],
        }
    }

    /// Levels with the given errors in both clips.
    fn errors(levels_metres: &[f32]) -> LodErrors {
        let clip = ClipLodErrors {
            levels_metres: levels_metres.to_vec(),
            worst_metres: levels_metres.to_vec(),
            ..ClipLodErrors::default()
        };
        LodErrors {
            clips: vec![clip; 2],
        }
    }

    #[test]
    fn a_face_rests_where_it_adds_at_most_half_of_the_error() {
        // At weight 1 the vertices are 0.75 * 2 cm from where they rest: 15 mm, which counts half,
        // since less than 5 % of the vertices move.
        let asset = asset(0.25, 1.0);
        let own = [0.0, 0.004, 0.014, 0.016, 0.5];
        let mut found = errors(&own);
        let morphs = morph_clips(&asset, &mut found).unwrap().unwrap();
        assert_eq!((morphs.levels(), morphs.targets()), (3, 1));
        let rest = &found.clips[0];
        assert_eq!(rest.levels_metres, own);
        for (level, worst) in rest.worst_metres.iter().enumerate() {
            let face = if level < 3 { 0.0 } else { 0.015 };
            assert!((worst - own[level] - face).abs() < 1e-6, "level {level}");
        }
        assert_eq!(
            found.clips[1],
            errors(&own).clips[1],
            "its face rests anyway"
        );
        // No level is coarse enough.
        let mut found = errors(&own[..3]);
        let morphs = morph_clips(&asset, &mut found).unwrap().unwrap();
        assert_eq!((morphs.levels(), found), (3, errors(&own[..3])));
    }

    #[test]
    fn without_tracks_or_targets_nothing_changes() {
        let own = [0.0, 0.5];
        let mut found = errors(&own);
        let mut still = asset(0.0, 1.0);
        still.clips.swap_remove(0);
        assert_eq!(morph_clips(&still, &mut found), Ok(None));
        let mut plain = asset(0.0, 1.0);
        plain.mesh.morphs.clear();
        assert_eq!(morph_clips(&plain, &mut found), Ok(None));
        assert_eq!(found, errors(&own));
    }
}

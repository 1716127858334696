//! The levels of a crowd that show morph targets, the morph levels of their faces, and the errors of
//! those whose faces rest.
//!
//! A level whose error is at least twice what a face at rest adds leaves the morph targets out, and
//! so do the coarser ones. Their errors then include the face, so that a tolerance holds for it too:
//! at most half as much again.
//!
//! The other levels have morph levels, which leave out the targets that cost least. Their errors are
//! powers of two below that of a face at rest, so that each is for half of the distance.

use super::morph_order::{Dropped, FRAMES as ORDER_FRAMES, MovedFaces, VERTICES};
use articula_build::Asset;
use articula_core::crowd::{MorphClips, MorphLods};
use articula_core::{
    Clip, LodErrors, Mesh, Mismatch, ModelPose, Morph, Wrap, local_to_model, lod_error_metres,
    palette, percentile, sample_morphs,
};
use glam::{Affine3A, Mat3A, Vec3, Vec3A};

/// Share of a level's error that a face at rest may add.
const REST_SHARE: f32 = 0.5;

/// Maximum number of frames of a clip at which faces are compared with a face at rest.
const FRAMES: usize = 24;

/// Errors of the morph levels between all targets and none, as shares of the error at rest.
const LADDER: [f32; 4] = [1.0 / 16.0, 1.0 / 8.0, 1.0 / 4.0, 1.0 / 2.0];

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
    let rest = &asset.mesh.morph_weights;
    let moving = MorphClips::moving(&asset.clips, rest)?;
    if moving.is_empty() {
        return Ok(None);
    }
    let faces = RestingFaces::new(asset);
    let dropped = faces.moved(&asset.clips, &moving).order();
    let order: Vec<u16> = dropped.iter().rev().map(|d| moving[d.target]).collect();
    let counts = counts(&dropped);
    let clips = asset.clips.iter();
    let found: Vec<Vec<LeftOutError>> = clips.map(|c| faces.errors(c, &order, &counts)).collect();
    let at_rest: Vec<LeftOutError> = found
        .iter()
        .map(|levels| levels.last().copied().unwrap_or_default())
        .collect();
    let levels = errors.clips.first().map_or(1, |c| c.levels_metres.len());
    let rests = |level: &usize| {
        errors.clips.iter().zip(&at_rest).all(|(clip, face)| {
            let own = lod_error_metres(clip.levels_metres[*level], clip.worst_metres[*level]);
            face.judged() <= REST_SHARE * own
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
    let judged: Vec<Vec<f32>> = found.iter().map(|levels| rising(levels)).collect();
    let lods = MorphLods::new(order, counts, &judged)?;
    let morphs = MorphClips::with_lods(&asset.clips, rest, shown, lods)?;
    Ok(Some(morphs).filter(|m| m.levels() > 0))
}

/// Numbers of targets of the morph levels: all, the least within each error of the ladder, none.
fn counts(dropped: &[Dropped]) -> Vec<u16> {
    let all = dropped.len();
    // Targets that cancel others may lower the error again; it counts as the greatest so far.
    let mut most = 0.0_f32;
    let errors = dropped.iter().map(|d| {
        most = most.max(d.error_metres);
        most
    });
    let errors: Vec<f32> = errors.collect();
    let at_rest = errors.last().copied().unwrap_or_default();
    let within = |share: &f32| {
        let left_out = errors.partition_point(|e| *e <= share * at_rest);
        all - left_out
    };
    let between = LADDER.iter().map(within);
    let all = [all].into_iter().chain(between).chain([0]);
    let mut counts: Vec<u16> = all.map(|count| count as u16).collect();
    counts.dedup();
    counts
}

/// The errors by which morph levels are chosen, none less than that of a finer level.
fn rising(levels: &[LeftOutError]) -> Vec<f32> {
    let mut most = 0.0_f32;
    let judged = levels.iter().map(|error| {
        most = most.max(error.judged());
        most
    });
    judged.collect()
}

/// Distance of a skin without some of its morph targets from one that shows all, over a clip.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct LeftOutError {
    /// Per frame the 95th percentile over vertices, then the maximum over frames.
    p95_metres: f32,
    /// Maximum over vertices and frames.
    worst_metres: f32,
}

impl LeftOutError {
    fn judged(self) -> f32 {
        lod_error_metres(self.p95_metres, self.worst_metres)
    }
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

    /// Difference of all weights to their defaults at the sampled frames of a clip.
    fn sampled(&self, clip: &Clip) -> impl Iterator<Item = Vec<f32>> {
        let is_still = clip.tracks().morphs.is_empty();
        let count = if is_still {
            0
        } else {
            clip.frames().min(FRAMES)
        };
        (0..count).map(move |i| {
            let frame = i * (clip.frames() - 1) / (count - 1).max(1);
            let secs = frame as f64 / f64::from(clip.rate_hz());
            let mut weights = self.mesh.morph_weights.clone();
            sample_morphs(clip, secs, Wrap::Clamp, &mut weights);
            let defaults = self.mesh.morph_weights.iter();
            weights.iter_mut().zip(defaults).for_each(|(w, d)| *w -= d);
            weights
        })
    }

    /// Errors in a clip of leaving out all but the first of the targets in an order, for each of some
    /// falling numbers of these.
    fn errors(&self, clip: &Clip, order: &[u16], counts: &[u16]) -> Vec<LeftOutError> {
        let mut found = vec![LeftOutError::default(); counts.len()];
        for weights in self.sampled(clip) {
            let mut offsets = vec![Vec3::ZERO; self.mesh.len()];
            let mut shown = order.len();
            for (count, found) in counts.iter().zip(&mut found) {
                let count = usize::from(*count);
                let left_out = &order[count..shown];
                shown = count;
                for morph in self.morphs(left_out) {
                    let more = weights[usize::from(morph.slot)];
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
        }
        found
    }

    /// The morph targets of some slots.
    fn morphs(&self, slots: &[u16]) -> impl Iterator<Item = &'a Morph> {
        let mesh = self.mesh;
        let morphs = mesh.morphs.iter();
        morphs.filter(move |m| slots.contains(&m.slot))
    }

    /// Samples what the moving targets do in the clips: frames and vertices spread evenly.
    fn moved(&self, clips: &[Clip], moving: &[u16]) -> MovedFaces {
        let weights: Vec<Vec<f32>> = clips.iter().flat_map(|c| self.sampled(c)).collect();
        let of_moving = |w: &Vec<f32>| moving.iter().map(|t| w[usize::from(*t)]).collect();
        let step = weights.len().div_ceil(ORDER_FRAMES).max(1);
        let frames = weights.iter().step_by(step).map(of_moving).collect();
        let mut is_moved = vec![false; self.mesh.len()];
        for morph in self.morphs(moving) {
            for v in &morph.vertices {
                is_moved[*v as usize] = true;
            }
        }
        let moved = is_moved.iter().filter(|is| **is).count();
        let step = moved.div_ceil(VERTICES).max(1);
        // Place of each vertex in the sample.
        let mut places = vec![None; self.mesh.len()];
        let vertices = is_moved.iter().enumerate().filter(|(_, is)| **is);
        for (place, (v, _)) in vertices.step_by(step).enumerate() {
            places[v] = Some(place as u32);
        }
        let field = |target: &u16| {
            let morphs = self.morphs(std::slice::from_ref(target));
            let offsets = morphs.flat_map(|m| m.vertices.iter().zip(&m.positions));
            let placed = offsets.filter_map(|(v, offset)| {
                let v = *v as usize;
                Some((places[v]?, self.skins[v] * Vec3A::from(*offset)))
            });
            placed.collect()
        };
        MovedFaces {
            fields: moving.iter().map(field).collect(),
            frames,
            moved: moved.div_ceil(step),
            vertices: self.mesh.len() as f32 / step as f32,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::source::{Joint, Skeleton};
    use articula_core::{
        Articulation, Binding, ClipLodErrors, JointArticulation, Region, Rig, Track, Tracks,
        Transform,
    };
    use proptest::prelude::*;
    use std::sync::Arc;

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
            rig: Rig::new(&skeleton, articulation).unwrap().into(),
            mesh: mesh.into(),
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
        let near = |found: &[f32], expected: [f32; 2]| {
            let pairs = found.iter().zip(expected);
            pairs.fold(found.len() == 2, |all, (a, b)| all && (a - b).abs() < 1e-6)
        };
        assert!(near(morphs.lods().errors_metres(0), [0.0, 0.0075]));
        assert!(near(morphs.lods().errors_metres(1), [0.0, 0.0]));
        // No level is coarse enough.
        let mut found = errors(&own[..3]);
        let morphs = morph_clips(&asset, &mut found).unwrap().unwrap();
        assert_eq!((morphs.levels(), found), (3, errors(&own[..3])));
    }

    /// The same with two more targets, of which the second moves its own ten vertices by 5 mm, the
    /// third by half a millimetre.
    fn of_three() -> Asset {
        let mut asset = asset(0.25, 1.0);
        let mesh = Arc::make_mut(&mut asset.mesh);
        for (slot, centimetres) in [(1, 0.5), (2, 0.05)] {
            let first = 10 * u32::from(slot);
            mesh.morphs.push(Morph {
                slot,
                vertices: (first..first + 10).collect(),
                positions: vec![Vec3::Y * centimetres; 10],
                normals: vec![Vec3::ZERO; 10],
            });
            mesh.morph_weights.push(0.0);
        }
        let clip = &asset.clips[0];
        let mut tracks = clip.tracks().clone();
        for target in [2, 1] {
            tracks.morphs.push(Track {
                target,
                step: false,
                values: (0..101).map(|f| f as f32 / 100.0).collect(),
            });
        }
        asset.clips[0] = Clip::new("clip", 30.0, 101, 1, tracks).unwrap();
        asset
    }

    #[test]
    fn morph_levels_leave_out_what_costs_least() {
        let mut found = errors(&[0.0]);
        let morphs = morph_clips(&of_three(), &mut found).unwrap().unwrap();
        let lods = morphs.lods();
        assert_eq!(lods.order(), [0, 1, 2]);
        // At rest the error is half of 15 mm. Half a millimetre is less than a sixteenth of it, 5 mm
        // are a third: less than a half.
        let counts: Vec<usize> = (0..lods.levels()).map(|l| lods.count(l)).collect();
        assert_eq!(counts, [3, 2, 1, 0]);
        let expected = [0.0, 0.00025, 0.0025, 0.0075];
        for (found, expected) in lods.errors_metres(0).iter().zip(expected) {
            assert!((found - expected).abs() < 1e-6, "{found} {expected}");
        }
        assert_eq!(lods.errors_metres(1), [0.0; 4], "its face rests anyway");
        assert_eq!(found, errors(&[0.0]));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        /// Whatever the targets do, errors rise, and the last is that of a face at rest.
        #[test]
        fn errors_of_morph_levels_rise_to_that_at_rest(
            offsets in prop::collection::vec((0usize..40, -2.0f32..2.0), 1..12),
            ends in prop::collection::vec(-1.0f32..1.0, 12),
        ) {
            let mut asset = asset(0.25, 1.0);
            let mut tracks = asset.clips[0].tracks().clone();
            let mesh = Arc::make_mut(&mut asset.mesh);
            for (i, (first, centimetres)) in offsets.iter().enumerate() {
                let slot = i as u16 + 1;
                mesh.morphs.push(Morph {
                    slot,
                    vertices: (*first as u32..*first as u32 + 60).collect(),
                    positions: vec![Vec3::X * *centimetres; 60],
                    normals: vec![Vec3::ZERO; 60],
                });
                mesh.morph_weights.push(0.0);
                let values = (0..101).map(|f| ends[i] * f as f32 / 100.0).collect();
                tracks.morphs.push(Track { target: slot, step: false, values });
            }
            asset.clips[0] = Clip::new("clip", 30.0, 101, 1, tracks).unwrap();
            let morphs = morph_clips(&asset, &mut errors(&[0.0])).unwrap().unwrap();
            let lods = morphs.lods();
            let found = lods.errors_metres(0);
            prop_assert_eq!(found[0], 0.0);
            prop_assert!(found.windows(2).all(|pair| pair[0] <= pair[1]));
            prop_assert_eq!(lods.count(lods.levels() - 1), 0);
            prop_assert!(lods.levels() <= LADDER.len() + 2);
            // The plain way: each prefix by itself.
            let faces = RestingFaces::new(&asset);
            let mut most = 0.0_f32;
            for (level, found) in found.iter().enumerate() {
                let count = lods.count(level) as u16;
                let plain = faces.errors(&asset.clips[0], lods.order(), &[count]);
                most = most.max(plain[0].judged());
                prop_assert!((found - most).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn without_tracks_or_targets_nothing_changes() {
        let own = [0.0, 0.5];
        let mut found = errors(&own);
        let mut still = asset(0.0, 1.0);
        still.clips.swap_remove(0);
        assert_eq!(morph_clips(&still, &mut found), Ok(None));
        let mut plain = asset(0.0, 1.0);
        Arc::make_mut(&mut plain.mesh).morphs.clear();
        assert_eq!(morph_clips(&plain, &mut found), Ok(None));
        assert_eq!(found, errors(&own));
    }
}

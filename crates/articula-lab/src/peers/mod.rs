//! Evaluators, simplifiers and codecs for comparison, each small and implemented fairly.
//!
//! - [`floor`]: a minimal evaluator of poses, a lower bound for the time on this machine
//! - [`structs`]: arrays of structs, as in a hand-written evaluator
//! - [`three`]: three.js in node
//! - [`node`]: whether node and its packages are there
//! - [`ranks`]: update rates by rank of distance
//! - [`draco`]: Draco's codec in node
//! - [`meshopt`]: meshoptimizer's simplifier and codecs
//! - [`optimisers`]: gltfpack, glTF-Transform and the judge of their files, in node
//! - [`quoted`]: published times that are quoted, not measured here

pub(crate) mod draco;
pub(crate) mod floor;
pub(crate) mod meshopt;
pub(crate) mod node;
pub(crate) mod optimisers;
pub(crate) mod quoted;
pub(crate) mod ranks;
pub(crate) mod structs;
pub(crate) mod three;

#[cfg(test)]
mod tests {
    use super::floor::{Floor, Kernel, LANES, Matrix, Sampled, breadth_first};
    use super::structs::Structs;
    use crate::small::human;
    use articula_build::Asset;
    use articula_core::{Clip, ModelPose, Tracks, Wrap, local_to_model, sample};
    use glam::Mat4;

    /// Bound for a chain of twenty joints with some twenty roundings of 6e-8 each, two metres from
    /// the origin: the maximum difference between two orders of the same sums.
    const ROUNDING: f32 = 5e-5;

    /// Maximum difference of a matrix element from the scalar path's, over all joints.
    fn gap(asset: &Asset, clip: &Clip, secs: f32, found: impl Fn(usize) -> Mat4) -> f32 {
        let rig = &asset.rig;
        let mut local = rig.rest_pose().clone();
        let mut model = ModelPose::new(rig.len());
        sample(clip, f64::from(secs), Wrap::Clamp, &rig.all(), &mut local);
        local_to_model(rig, &local, &mut model);
        let gaps = (0..rig.len()).flat_map(|j| {
            let gap = Mat4::from(model.matrices[j]) - found(j);
            gap.to_cols_array().map(f32::abs)
        });
        gaps.fold(0.0, f32::max)
    }

    fn from_rows(m: &Matrix) -> Mat4 {
        let row = |r: usize| glam::Vec4::new(m[4 * r], m[4 * r + 1], m[4 * r + 2], m[4 * r + 3]);
        Mat4::from_cols(row(0), row(1), row(2), glam::Vec4::W).transpose()
    }

    /// Index of each joint in the output of the floor.
    fn places(asset: &Asset) -> Vec<usize> {
        let order = breadth_first(&asset.rig);
        let at = |joint| order.iter().position(|j| *j == joint).unwrap();
        (0..asset.rig.len()).map(at).collect()
    }

    fn kernels() -> [(Sampled, Kernel); 4] {
        [
            (Sampled::Moving, Kernel::Arrays),
            (Sampled::Moving, Kernel::best()),
            (Sampled::Moving, Kernel::unfused()),
            (Sampled::AllRotations, Kernel::best()),
        ]
    }

    #[test]
    fn the_floor_shows_what_the_scalar_path_shows() {
        let asset = human();
        let every = asset.clips.iter().flat_map(|c| kernels().map(|k| (c, k)));
        for (clip, (sampled, kernel)) in every {
            let mut floor = Floor::with(&asset.rig, clip, sampled, kernel).unwrap();
            let joints = floor.joints();
            // Eleven characters: one whole batch and three of the next.
            let secs: Vec<f32> = (0..11)
                .map(|i| clip.duration_secs() * i as f32 / 10.0)
                .collect();
            let mut out = vec![[f32::NAN; 12]; secs.len() * joints];
            floor.store(&secs, &mut out);
            let places = places(asset);
            for (secs, matrices) in secs.iter().zip(out.chunks(joints)) {
                let found = |j: usize| from_rows(&matrices[places[j]]);
                let gap = gap(asset, clip, *secs, found);
                assert!(
                    gap < ROUNDING,
                    "{kernel:?}, {} at {secs} s: {gap}",
                    clip.name
                );
            }
            let mut batch = 0;
            floor.tiles(&secs, |tile| {
                for (lane, matrices) in out
                    .chunks(joints)
                    .skip(batch * LANES)
                    .take(LANES)
                    .enumerate()
                {
                    for (joint, tile) in matrices.iter().zip(tile) {
                        assert_eq!(*joint, tile.0.map(|row| row[lane]));
                    }
                }
                batch += 1;
            });
            assert_eq!(batch, 2);
        }
    }

    #[test]
    fn structs_show_the_keys_of_the_clip() {
        let asset = human();
        for clip in &asset.clips {
            let structs = Structs::new(&asset.rig, clip).unwrap();
            let mut character = structs.character();
            for frame in [0, 1, clip.frames() / 2, clip.frames() - 1] {
                let secs = frame as f32 / clip.rate_hz();
                structs.evaluate(secs, &mut character);
                let gap = gap(asset, clip, secs, |j| character.model[j]);
                assert!(gap < ROUNDING, "{} at {secs} s: {gap}", clip.name);
            }
        }
    }

    #[test]
    fn a_clip_of_one_pose_stands_still_and_scales_are_refused() {
        let asset = human();
        let joints = asset.rig.len();
        let still = Clip::new("still", 30.0, 1, joints, Tracks::default()).unwrap();
        let mut floor = Floor::new(&asset.rig, &still, Sampled::Moving).unwrap();
        assert_eq!(floor.clip_bytes(), 0, "nothing moves");
        let mut out = vec![[0.0; 12]; joints];
        floor.store(&[0.0], &mut out);
        let places = places(asset);
        assert!(gap(asset, &still, 0.0, |j| from_rows(&out[places[j]])) < ROUNDING);
        let tracks = Tracks {
            scales: vec![articula_core::Track {
                target: 0,
                step: false,
                values: vec![glam::Vec3::splat(2.0)],
            }],
            ..Tracks::default()
        };
        let scaled = Clip::new("scaled", 30.0, 1, joints, tracks).unwrap();
        assert!(
            Floor::new(&asset.rig, &scaled, Sampled::Moving).is_err(),
            "a root's scale"
        );
    }
}

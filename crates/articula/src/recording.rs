//! Poses as they were shown, as a clip of their character.

use crate::error::{Context, Error, Result};
use crate::open::CharacterFile;
use articula_core::Transform;
use articula_core::source::{Channel, Interpolation, Property, RawClip, Skeleton};
use glam::{Affine3A, Mat4};

/// Numbers of a matrix of three rows.
const ROWS: usize = 12;
/// Difference of a component up to which a joint keeps its rest pose: below what 32-bit matrices hold.
const STILL: f32 = 1e-5;

/// What a character showed over some time, whatever moved it: a clip, levels of articulation, expressions, or
/// a camera, before which it is as if it had moved itself.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// Name of the clip that it becomes.
    pub name: String,
    /// Time of each frame in seconds; the first is 0, and they rise.
    pub times_secs: Vec<f32>,
    /// For each frame the matrix of each joint in model space, three rows of four numbers, in metres.
    pub joints: Vec<f32>,
    /// For each frame the weights of the morph targets of all meshes.
    pub morphs: Vec<f32>,
}

impl CharacterFile {
    /// Adds a recording as a clip, in place of one of the same name. Joints that stayed at rest have no keys.
    ///
    /// # Errors
    /// An [`Error`] that says which list has a wrong length, a time that does not rise, or a number that is not finite.
    pub fn put_recording(&mut self, recording: &Recording) -> Result<()> {
        let clip = self
            .recorded(recording)
            .with_context(|| self.name().to_owned())?;
        let clips = self.clips_mut();
        clips.retain(|other| other.name != clip.name);
        clips.push(clip);
        Ok(())
    }

    fn recorded(&self, recording: &Recording) -> Result<RawClip> {
        let character = self.character();
        let skeleton = &character.skeleton;
        let counts = character.meshes.iter().map(|mesh| mesh.morph_weights.len());
        let counts: Vec<usize> = counts.collect();
        recording.check(skeleton.joints.len(), counts.iter().sum())?;
        let mut channels = recording.of_joints(skeleton);
        let mut first = 0;
        for (mesh, count) in counts.into_iter().enumerate() {
            channels.extend(recording.of_mesh(mesh, first, count));
            first += count;
        }
        Ok(RawClip {
            name: recording.name.clone(),
            duration_secs: recording.times_secs.last().copied().unwrap_or_default(),
            channels,
        })
    }
}

impl Recording {
    fn check(&self, joints: usize, morphs: usize) -> Result<()> {
        let frames = self.times_secs.len();
        let rises = self.times_secs.windows(2).all(|t| t[0] < t[1]);
        if frames < 2 || !rises || self.times_secs[0] != 0.0 {
            let what = "times: at least two that rise from 0 are expected";
            return Err(Error::argument(format!("recording: {what}")));
        }
        let lists = [
            ("joints", &self.joints, ROWS * joints),
            ("morphs", &self.morphs, morphs),
        ];
        for (name, list, each) in lists {
            let (found, wanted) = (list.len(), frames * each);
            if found != wanted {
                let what = format!("{found} numbers, {wanted} for {frames} frames are expected");
                return Err(Error::argument(format!("recording: {name}: {what}")));
            }
        }
        let mut all = self
            .times_secs
            .iter()
            .chain(&self.joints)
            .chain(&self.morphs);
        match all.all(|number| number.is_finite()) {
            true => Ok(()),
            false => Err(Error::argument("recording: a number is not finite")),
        }
    }

    /// Keys of the joints that do not stay at rest.
    fn of_joints(&self, skeleton: &Skeleton) -> Vec<Channel> {
        let count = skeleton.joints.len();
        let mut channels = Vec::new();
        for (joint, of) in skeleton.joints.iter().enumerate() {
            let mut local: Vec<Transform> = Vec::with_capacity(self.times_secs.len());
            for frame in 0..self.times_secs.len() {
                let model = |joint: usize| matrix(&self.joints, frame * count + joint);
                let above = of.parent.map_or(Affine3A::IDENTITY, model);
                let (scale, rotation, translation) =
                    (above.inverse() * model(joint)).to_scale_rotation_translation();
                // Neighbouring quaternions on one side, for readers that blend their components.
                let before = local.last().map_or(of.rest.rotation, |t| t.rotation);
                local.push(Transform {
                    translation,
                    rotation: if before.dot(rotation) < 0.0 {
                        -rotation
                    } else {
                        rotation
                    },
                    scale,
                });
            }
            let rest = &of.rest;
            let keys = |value: fn(&Transform) -> Vec<f32>| -> Option<Vec<f32>> {
                let rest = value(rest);
                let all: Vec<f32> = local.iter().flat_map(value).collect();
                let is_off = |(i, x): (usize, &f32)| (x - rest[i % rest.len()]).abs() > STILL;
                all.iter().enumerate().any(is_off).then_some(all)
            };
            let of_joint = [
                (
                    Property::Translation,
                    keys(|t| t.translation.to_array().to_vec()),
                ),
                (Property::Rotation, keys(|t| t.rotation.to_array().to_vec())),
                (Property::Scale, keys(|t| t.scale.to_array().to_vec())),
            ];
            let moved = of_joint.into_iter();
            channels.extend(
                moved.filter_map(|(property, keys)| Some(self.channel(joint, property, keys?))),
            );
        }
        channels
    }

    /// Keys of the morph targets of a mesh, the first of which is `first` among all; none without targets.
    fn of_mesh(&self, mesh: usize, first: usize, count: usize) -> Option<Channel> {
        let all = self.morphs.len() / self.times_secs.len();
        let frames = (0..self.times_secs.len()).map(|frame| frame * all + first);
        let keys = frames.flat_map(|at| self.morphs[at..at + count].iter().copied());
        (count > 0).then(|| self.channel(mesh, Property::Weights, keys.collect()))
    }

    fn channel(&self, target: usize, property: Property, values: Vec<f32>) -> Channel {
        Channel {
            target,
            property,
            interpolation: Interpolation::Linear,
            times_secs: self.times_secs.clone(),
            values,
        }
    }
}

/// The matrix at an index among matrices of three rows.
fn matrix(rows: &[f32], index: usize) -> Affine3A {
    let mut all = [0.0; 16];
    all[..ROWS].copy_from_slice(&rows[ROWS * index..ROWS * (index + 1)]);
    all[15] = 1.0;
    Affine3A::from_mat4(Mat4::from_cols_array(&all).transpose())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::Figure;
    use crate::open::reference_mannequin;
    use articula_core::{ModelPose, Wrap, local_to_model, sample};

    /// Model-space matrices of a clip of the mannequin at the times of a recording.
    fn shown(figure: &Figure, clip: usize, times_secs: &[f32]) -> Vec<f32> {
        let rig = &figure.asset.rig;
        let mut local = rig.rest_pose().clone();
        let mut model = ModelPose::new(rig.len());
        let mut rows = Vec::new();
        for secs in times_secs {
            let secs = f64::from(*secs);
            sample(
                &figure.asset.clips[clip],
                secs,
                Wrap::Clamp,
                &rig.all(),
                &mut local,
            );
            local_to_model(rig, &local, &mut model);
            for joint in 0..rig.len() {
                let matrix = Mat4::from(model.matrices[joint]).transpose();
                rows.extend_from_slice(&matrix.to_cols_array()[..ROWS]);
            }
        }
        rows
    }

    #[test]
    fn what_was_shown_is_shown_again() {
        let mut opened = reference_mannequin().unwrap();
        let figure = Figure::new(opened.clone()).unwrap();
        let times_secs: Vec<f32> = (0..12).map(|frame| frame as f32 / 30.0).collect();
        let clip = figure.clip(Some("walk")).unwrap().unwrap();
        let morphs = figure.asset.mesh.morph_weights.len() * times_secs.len();
        let recording = Recording {
            name: "shown".into(),
            joints: shown(&figure, clip, &times_secs),
            morphs: vec![0.0; morphs],
            times_secs: times_secs.clone(),
        };
        opened.put_recording(&recording).unwrap();
        opened.put_recording(&recording).unwrap();
        let again = Figure::new(opened).unwrap();
        assert_eq!(again.asset.clips.len(), figure.asset.clips.len() + 1);
        let clip = again.clip(Some("shown")).unwrap().unwrap();
        let found = shown(&again, clip, &times_secs);
        let off = found
            .iter()
            .zip(&recording.joints)
            .map(|(a, b)| (a - b).abs());
        let worst = off.fold(0.0, f32::max);
        assert!(worst < 1e-4, "{worst}");
    }

    #[test]
    fn lists_of_wrong_lengths_are_refused() {
        let mut opened = reference_mannequin().unwrap();
        let joints = opened.character().skeleton.joints.len();
        let morphs = opened
            .character()
            .meshes
            .iter()
            .map(|m| m.morph_weights.len());
        let good = Recording {
            name: "still".into(),
            times_secs: vec![0.0, 0.5],
            joints: vec![0.5; 2 * ROWS * joints],
            morphs: vec![0.0; 2 * morphs.sum::<usize>()],
        };
        let mut told = |bad: Recording| opened.put_recording(&bad).unwrap_err().to_string();
        let short = Recording {
            joints: vec![0.0; 5],
            ..good.clone()
        };
        assert!(told(short).contains("joints: 5 numbers"));
        let back = Recording {
            times_secs: vec![0.0, 0.0],
            ..good.clone()
        };
        assert!(told(back).contains("rise from 0"));
        let mut odd = good;
        odd.joints[3] = f32::NAN;
        assert!(told(odd).contains("not finite"));
    }
}

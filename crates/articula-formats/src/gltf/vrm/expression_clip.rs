//! A clip of expressions as a VRM animation.
//!
//! Source: VRMC_vrm_animation 1.0: an expression is a node whose translation along x is its weight.

use super::super::document::Document;
use crate::written::WriteError;
use articula_core::Transform;
use articula_core::source::{
    Channel, Character, Interpolation, Joint, Property, RawClip, Skeleton,
};
use glam::Vec3;
use serde_json::{Map, Value, json};

const EXTENSION: &str = "VRMC_vrm_animation";
/// Height of the hips, metres; players take the size of the figure from it.
const HIPS_M: f32 = 1.0;

impl Document {
    /// Creates a VRM animation of the weights of preset expressions, without motion of the body.
    ///
    /// Each of `tracks` is the name of a preset of VRM 1.0 and one weight for each of `times_secs`.
    ///
    /// # Errors
    /// [`WriteError::Mismatch`] if a track has another number of weights than there are times.
    pub fn from_expressions(
        name: &str,
        times_secs: &[f32],
        tracks: &[(&str, Vec<f32>)],
    ) -> Result<Self, WriteError> {
        let joint = |name: &str, y: f32, parent: Option<usize>| Joint {
            name: name.to_owned(),
            parent,
            rest: Transform {
                translation: Vec3::new(0.0, y, 0.0),
                ..Transform::IDENTITY
            },
            in_skin: false,
        };
        let mut joints = vec![joint("hips", HIPS_M, None)];
        joints.extend(tracks.iter().map(|(name, _)| joint(name, 0.0, None)));
        let channel = |(index, (_, weights)): (usize, &(&str, Vec<f32>))| Channel {
            target: index + 1,
            property: Property::Translation,
            interpolation: Interpolation::Linear,
            times_secs: times_secs.to_vec(),
            values: weights.iter().flat_map(|w| [*w, 0.0, 0.0]).collect(),
        };
        let clip = RawClip {
            name: name.to_owned(),
            duration_secs: times_secs.last().copied().unwrap_or(0.0),
            channels: tracks.iter().enumerate().map(channel).collect(),
        };
        let mut document = Self::from_character(&Character {
            name: name.to_owned(),
            skeleton: Skeleton { joints },
            clips: vec![clip],
            ..Character::default()
        })?;
        let presets = tracks.iter().enumerate();
        let presets = presets.map(|(i, (name, _))| ((*name).to_owned(), json!({"node": i + 1})));
        let presets: Map<String, Value> = presets.collect();
        document.json["extensionsUsed"] = json!([EXTENSION]);
        document.json["extensions"] = json!({EXTENSION: {
            "specVersion": "1.0",
            "humanoid": {"humanBones": {"hips": {"node": 0}}},
            "expressions": {"preset": presets},
        }});
        Ok(document)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Limits;
    use crate::gltf::read_document;

    #[test]
    fn weights_come_back() {
        let tracks = [
            ("aa", vec![0.0, 0.5, 1.0]),
            ("blinkLeft", vec![1.0, 0.0, 0.25]),
        ];
        let made = Document::from_expressions("talk", &[0.0, 0.5, 1.0], &tracks).unwrap();
        let read = read_document(made, &Limits::default()).unwrap();
        assert_eq!(read.warnings, []);
        let character = read.value.character;
        let names: Vec<&str> = character
            .expressions
            .iter()
            .map(|e| e.name.as_str())
            .collect();
        assert_eq!(names, ["aa", "blinkLeft"]);
        let clip = &character.clips[0];
        assert_eq!((clip.name.as_str(), clip.duration_secs), ("talk", 1.0));
        for (index, (_, weights)) in tracks.iter().enumerate() {
            let of = |c: &&Channel| c.property == Property::Expression && c.target == index;
            let channel = clip.channels.iter().find(of).unwrap();
            assert_eq!(
                (&channel.times_secs[..], &channel.values),
                (&[0.0, 0.5, 1.0][..], weights)
            );
        }
        let uneven = [("aa", vec![0.0])];
        assert!(Document::from_expressions("", &[0.0, 1.0], &uneven).is_err());
    }
}

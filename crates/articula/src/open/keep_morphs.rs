//! Leaving morph targets out of a character.

use super::CharacterFile;
use articula_core::source::{Character, Property};

impl CharacterFile {
    /// Keeps the morph targets whose names `keeps` takes; those without a name have the empty one. Clips and
    /// expressions drive those that stay, and the document of a glTF file follows.
    pub fn keep_morph_targets(&mut self, keeps: impl Fn(&str) -> bool) {
        let kept_of = |names: &Vec<String>| names.iter().map(|name| keeps(name)).collect();
        let meshes = self.character.meshes.iter();
        let kept: Vec<Vec<bool>> = meshes.map(|mesh| kept_of(&mesh.morph_names)).collect();
        if kept.iter().flatten().all(|kept| *kept) {
            return;
        }
        let mut character = self.character.clone();
        keep(&mut character, &kept);
        let mut gltf = self.gltf.take();
        if let Some(gltf) = &mut gltf {
            gltf.document.keep_morph_targets(&keeps);
        }
        self.set_meshes(character, gltf);
    }
}

/// Keeps some targets of each mesh.
fn keep(character: &mut Character, kept: &[Vec<bool>]) {
    for (mesh, kept) in character.meshes.iter_mut().zip(kept) {
        retain(&mut mesh.morph_names, kept);
        retain(&mut mesh.morph_weights, kept);
        for primitive in &mut mesh.primitives {
            retain(&mut primitive.morphs, kept);
        }
    }
    for expression in &mut character.expressions {
        expression.morphs.retain_mut(|morph| {
            let Some(kept) = kept.get(morph.mesh) else {
                return false;
            };
            let is_kept = kept.get(morph.target) == Some(&true);
            let before = kept.iter().take(morph.target).filter(|kept| **kept);
            morph.target = before.count();
            is_kept
        });
    }
    for clip in &mut character.clips {
        clip.channels.retain_mut(|channel| {
            let kept = kept.get(channel.target);
            let Some(kept) = kept.filter(|_| channel.property == Property::Weights) else {
                return true;
            };
            // Values, and tangents of cubic splines, are rows of one number for each target.
            let mut of_row = kept.iter().cycle();
            (channel.values).retain(|_| *of_row.next().unwrap_or(&true));
            !channel.values.is_empty()
        });
    }
}

fn retain<T>(list: &mut Vec<T>, kept: &[bool]) {
    let mut kept = kept.iter();
    list.retain(|_| *kept.next().unwrap_or(&true));
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::source::{
        Channel, Expression, Interpolation, MorphBinding, RawClip, RawMesh,
    };

    #[test]
    fn clips_and_expressions_drive_the_targets_that_stay() {
        let mesh = RawMesh {
            morph_names: ["a", "b", "c"].map(str::to_owned).to_vec(),
            morph_weights: vec![0.1, 0.2, 0.3],
            ..RawMesh::default()
        };
        let binding = |target| MorphBinding {
            mesh: 0,
            target,
            weight: 1.0,
        };
        let channel = Channel {
            target: 0,
            property: Property::Weights,
            interpolation: Interpolation::Linear,
            times_secs: vec![0.0, 1.0],
            values: vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0],
        };
        let character = Character {
            meshes: vec![mesh],
            expressions: vec![Expression {
                morphs: vec![binding(0), binding(2)],
                ..Expression::default()
            }],
            clips: vec![RawClip {
                channels: vec![channel],
                ..RawClip::default()
            }],
            ..Character::default()
        };
        let mut file = CharacterFile::from_character("face", character);
        file.keep_morph_targets(|name| name != "a");
        let made = file.character();
        assert_eq!(made.meshes[0].morph_names, ["b", "c"]);
        assert_eq!(made.meshes[0].morph_weights, [0.2, 0.3]);
        assert_eq!(made.expressions[0].morphs, [binding(1)]);
        assert_eq!(made.clips[0].channels[0].values, [2.0, 3.0, 5.0, 6.0]);
        assert!(file.clips_changed());
        file.keep_morph_targets(|_| false);
        assert!(file.character().clips[0].channels.is_empty());
    }
}

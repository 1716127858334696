//! Leaving meshes out of a character.

use super::{CharacterFile, choose};
use crate::error::{Context, Result};
use crate::prepared::state::KeptMeshes;
use articula_core::source::{Character, Property};

impl CharacterFile {
    /// Keeps the meshes named in `only` (all if empty) that are not named in `hide`; channels and
    /// expressions of a removed mesh are removed too. Returns the new index of every mesh that there
    /// was, `None` for those removed. The document of a glTF file keeps them all.
    ///
    /// # Errors
    /// [`Error::Argument`](crate::Error::Argument) if no mesh has one of the names; the message lists the
    /// meshes. The file is then unchanged.
    pub fn keep_meshes(&mut self, only: &[String], hide: &[String]) -> Result<Vec<Option<usize>>> {
        let meshes = &self.character.meshes;
        for name in only.iter().chain(hide) {
            let names = meshes.iter().map(|m| m.name.as_str());
            choose("mesh", name, names).with_context(|| &self.name)?;
        }
        let kept: Vec<bool> = meshes
            .iter()
            .map(|m| is_kept(&m.name, only, hide))
            .collect();
        if kept.contains(&false) {
            let state = self.stored_state();
            if let Some(gltf) = &mut self.gltf {
                let (before, meshes) = (gltf.kept_meshes.take(), &self.character.meshes);
                gltf.kept_meshes = Some(KeptMeshes::of(before.as_ref(), state, meshes, &kept));
                let mut kept = kept.iter();
                gltf.node_of_mesh.retain(|_| *kept.next().unwrap_or(&false));
            }
        }
        Ok(keep_meshes(&mut self.character, &kept))
    }
}

fn is_kept(name: &str, only: &[String], hide: &[String]) -> bool {
    let has = |names: &[String]| names.iter().any(|n| n == name);
    (only.is_empty() || has(only)) && !has(hide)
}

fn keep_meshes(character: &mut Character, kept: &[bool]) -> Vec<Option<usize>> {
    let mut next = 0;
    let number = |kept: &bool| {
        next += usize::from(*kept);
        kept.then(|| next - 1)
    };
    let new_index: Vec<Option<usize>> = kept.iter().map(number).collect();
    let mut kept = kept.iter();
    let meshes = &mut character.meshes;
    meshes.retain(|_| *kept.next().unwrap_or(&false));
    for expression in &mut character.expressions {
        expression.morphs.retain_mut(|morph| {
            let index = new_index.get(morph.mesh).copied().flatten();
            morph.mesh = index.unwrap_or(morph.mesh);
            index.is_some()
        });
    }
    for clip in &mut character.clips {
        clip.channels.retain_mut(|channel| {
            if channel.property != Property::Weights {
                return true;
            }
            let index = new_index.get(channel.target).copied().flatten();
            channel.target = index.unwrap_or(channel.target);
            index.is_some()
        });
    }
    new_index
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::source::{
        Channel, Expression, Interpolation, MorphBinding, RawClip, RawMesh,
    };

    fn three_meshes() -> Character {
        let channel = |target| Channel {
            target,
            property: Property::Weights,
            interpolation: Interpolation::Linear,
            times_secs: vec![0.0],
            values: vec![0.0],
        };
        let morph = |mesh| MorphBinding {
            mesh,
            target: 0,
            weight: 1.0,
        };
        let mesh = |name: &str| RawMesh {
            name: name.into(),
            ..RawMesh::default()
        };
        Character {
            meshes: vec![mesh("body"), mesh("sword"), mesh("hat")],
            clips: vec![RawClip {
                channels: vec![channel(0), channel(1), channel(2)],
                ..RawClip::default()
            }],
            expressions: vec![Expression {
                morphs: vec![morph(1), morph(2)],
                ..Expression::default()
            }],
            ..Character::default()
        }
    }

    fn names(character: &Character) -> Vec<&str> {
        character.meshes.iter().map(|m| m.name.as_str()).collect()
    }

    #[test]
    fn hidden_meshes_go_with_their_channels() {
        let mut file = CharacterFile::from_character("three", three_meshes());
        let new_index = file.keep_meshes(&[], &["sword".into()]).unwrap();
        assert_eq!(new_index, [Some(0), None, Some(1)]);
        let c = file.character();
        assert_eq!(names(c), ["body", "hat"]);
        let targets: Vec<_> = c.clips[0].channels.iter().map(|c| c.target).collect();
        assert_eq!(targets, [0, 1]);
        let driven: Vec<_> = c.expressions[0].morphs.iter().map(|m| m.mesh).collect();
        assert_eq!(driven, [1]);
    }

    #[test]
    fn only_keeps_the_named_and_a_wrong_name_is_refused() {
        let mut file = CharacterFile::from_character("three", three_meshes());
        file.keep_meshes(&["hat".into()], &[]).unwrap();
        assert_eq!(names(file.character()), ["hat"]);
        assert_eq!(file.character().clips[0].channels[0].target, 0);
        assert!(file.keep_meshes(&[], &["cape".into()]).is_err());
    }
}

//! Leaving meshes out of a character.

use crate::error::{Context, Result};
use crate::open::{CharacterFile, choose};
use crate::prepared::state::KeptMeshes;
use articula_core::source::{Character, Property};

impl CharacterFile {
    /// Keeps the meshes named in `only` (all if empty) that are not named in `hide`; channels and
    /// expressions of a removed mesh are removed too.
    ///
    /// # Errors
    /// [`Error::Argument`](crate::Error::Argument) if no mesh has one of the names; the message lists the meshes.
    pub fn keep_meshes(&mut self, only: &[String], hide: &[String]) -> Result<()> {
        let names = self.character.meshes.iter().map(|m| m.name.clone());
        let names: Vec<String> = names.collect();
        if names.iter().any(|name| !is_kept(name, only, hide)) {
            let kept = KeptMeshes::of(self, |name| is_kept(name, only, hide));
            if let Some(gltf) = &mut self.gltf {
                gltf.kept_meshes = Some(kept);
            }
        }
        keep_meshes(&mut self.character, only, hide).context(&self.name)?;
        if let Some(gltf) = &mut self.gltf {
            let mut kept = names.iter().map(|name| is_kept(name, only, hide));
            gltf.node_of_mesh.retain(|_| kept.next().unwrap_or(false));
        }
        Ok(())
    }
}

fn is_kept(name: &str, only: &[String], hide: &[String]) -> bool {
    let has = |names: &[String]| names.iter().any(|n| n == name);
    (only.is_empty() || has(only)) && !has(hide)
}

fn keep_meshes(character: &mut Character, only: &[String], hide: &[String]) -> Result<()> {
    for name in only.iter().chain(hide) {
        let names = character.meshes.iter().map(|m| m.name.as_str());
        choose("mesh", name, names)?;
    }
    let kept = |name: &str| is_kept(name, only, hide);
    let mut new_index = Vec::with_capacity(character.meshes.len());
    let mut next = 0;
    for mesh in &character.meshes {
        new_index.push(kept(&mesh.name).then_some(next));
        next += usize::from(kept(&mesh.name));
    }
    character.meshes.retain(|m| kept(&m.name));
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
    Ok(())
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

    #[test]
    fn hidden_meshes_go_with_their_channels() {
        let mut c = three_meshes();
        keep_meshes(&mut c, &[], &["sword".into()]).unwrap();
        let names: Vec<_> = c.meshes.iter().map(|m| m.name.as_str()).collect();
        assert_eq!(names, ["body", "hat"]);
        let targets: Vec<_> = c.clips[0].channels.iter().map(|c| c.target).collect();
        assert_eq!(targets, [0, 1]);
        let driven: Vec<_> = c.expressions[0].morphs.iter().map(|m| m.mesh).collect();
        assert_eq!(driven, [1]);
    }

    #[test]
    fn only_keeps_the_named_and_a_wrong_name_is_refused() {
        let mut c = three_meshes();
        keep_meshes(&mut c, &["hat".into()], &[]).unwrap();
        assert_eq!(c.meshes.len(), 1);
        assert_eq!(c.clips[0].channels[0].target, 0);
        assert!(keep_meshes(&mut c, &[], &["cape".into()]).is_err());
    }
}

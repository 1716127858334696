//! A character ready to be played: meshes chosen, rig and clips built, one clip picked.

use crate::arguments::CharacterArgs;
use crate::load::{self, Loaded};
use anyhow::Context;
use articula_build::ClipOptions;
use articula_build::{Asset, character};
use articula_core::source::{Character, Property};

/// A character that was read, and what the frame needs of it.
#[derive(Debug)]
pub(crate) struct Prepared {
    pub(crate) loaded: Loaded,
    pub(crate) asset: Asset,
}

impl Prepared {
    /// Reads the file, leaves out the meshes that are not wanted, builds the rest.
    pub(crate) fn new(args: &CharacterArgs) -> anyhow::Result<Self> {
        let mut loaded = load::character(&args.file, &args.names)?;
        let place = loaded.place();
        choose_meshes(&mut loaded.character, &args.only, &args.hide).context(place.clone())?;
        Self::from_loaded(loaded)
    }

    /// Builds a character as it was read.
    pub(crate) fn from_loaded(loaded: Loaded) -> anyhow::Result<Self> {
        if loaded.character.skeleton.joints.is_empty() {
            let what = "no joint and no mesh; give a file that shows a character";
            anyhow::bail!("{}: nodes: {what}", loaded.place());
        }
        let articulation = articulation_of(&loaded);
        let asset = character(
            &loaded.character,
            Some(articulation),
            &ClipOptions::default(),
        )
        .with_context(|| loaded.place())?;
        Ok(Self { loaded, asset })
    }

    /// The index of the clip of this name, or of the first; `None` if there is no clip.
    pub(crate) fn clip(&self, name: Option<&str>) -> anyhow::Result<Option<usize>> {
        let names = self.loaded.character.clips.iter().map(|c| c.name.as_str());
        match name {
            Some(name) => load::choose("clip", name, names)
                .with_context(|| self.loaded.place())
                .map(Some),
            None => Ok((!self.asset.clips.is_empty()).then_some(0)),
        }
    }
}

/// What the file stores of itself, else what its names say.
pub(crate) fn articulation_of(loaded: &Loaded) -> articula_core::Articulation {
    let stored = loaded.character.articulation.clone();
    stored.unwrap_or_else(|| loaded.mapping.articulation.clone())
}

/// Keeps the meshes named in `only` (all if empty) that are not named in `hide`; channels and
/// expressions that drive a mesh follow it.
fn choose_meshes(
    character: &mut Character,
    only: &[String],
    hide: &[String],
) -> anyhow::Result<()> {
    for name in only.iter().chain(hide) {
        let names = character.meshes.iter().map(|m| m.name.as_str());
        load::choose("mesh", name, names)?;
    }
    let kept = |name: &String| (only.is_empty() || only.contains(name)) && !hide.contains(name);
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
    use articula_core::source::{Channel, Clip, Expression, Interpolation, Mesh, MorphBinding};

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
        let mesh = |name: &str| Mesh {
            name: name.into(),
            ..Mesh::default()
        };
        Character {
            meshes: vec![mesh("body"), mesh("sword"), mesh("hat")],
            clips: vec![Clip {
                channels: vec![channel(0), channel(1), channel(2)],
                ..Clip::default()
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
        choose_meshes(&mut c, &[], &["sword".into()]).unwrap();
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
        choose_meshes(&mut c, &["hat".into()], &[]).unwrap();
        assert_eq!(c.meshes.len(), 1);
        assert_eq!(c.clips[0].channels[0].target, 0);
        assert!(choose_meshes(&mut c, &[], &["cape".into()]).is_err());
    }
}

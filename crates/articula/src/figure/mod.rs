//! A character ready for playback: rig, mesh and clips built from an opened file.

mod draw_materials;
#[cfg(feature = "prepare")]
pub(crate) mod source;

use crate::error::{Context, Error, Result};
use crate::open::{CharacterFile, choose};
use crate::prepared::state::StoredState;
use crate::prepared::stored::Stored;
use crate::resampling::{ClipResampling, of_frames};
use articula_build::{Asset, ClipOptions, character, rig_and_mesh};
use articula_core::source::{Character, RawMesh};
use articula_formats::Warning;
use articula_formats::prepared::SourceOrder;
use draw_materials::draw_materials;
use std::sync::Arc;

/// An opened character with its runtime data: rig, mesh and clips.
///
/// Of an asset that was [prepared](crate::prepare()), the clips are read as stored, and the mesh has
/// the vertices of the file that the asset was made from, in the order of that file. So a figure is
/// the same before and after preparation.
#[derive(Debug)]
pub struct Figure {
    /// The editable character and the file that it was read from. Stored data that cannot be used
    /// is among its warnings.
    pub opened: CharacterFile,
    /// Rig, mesh and uniformly sampled clips, which players and crowds share without a copy.
    pub asset: Asset,
    state: StoredState,
    /// Order of the source file, if mesh levels have reordered the vertices of the document.
    orders: Option<Vec<SourceOrder>>,
    source_meshes: Option<Vec<RawMesh>>,
}

impl Figure {
    /// Builds rig, mesh and clips.
    ///
    /// # Errors
    /// An [`Error`] that names the file and the cause: neither joint nor mesh, a cycle in the node
    /// hierarchy, or more motion than fits in memory.
    pub fn new(opened: CharacterFile) -> Result<Self> {
        let state = opened.stored_state();
        Self::with_stored(opened, state)
    }

    fn with_stored(mut opened: CharacterFile, mut state: StoredState) -> Result<Self> {
        if opened.character().skeleton.joints.is_empty() {
            let what = "nodes: the file has no joint and no mesh; give a file with a character";
            return Err(Error::unsuited(what)).context(opened.name());
        }
        let mut told = std::mem::take(&mut state.stale);
        let stored = opened.stored();
        let reordered = stored
            .as_ref()
            .filter(|s| state.has_order && s.is_reordered());
        let meshes = &opened.character().meshes;
        let kept = opened.gltf().and_then(|g| g.kept_meshes.as_ref());
        let restored = reordered.and_then(|stored| stored.source_meshes(meshes, kept));
        let (orders, restored) = restored.unzip();
        if reordered.is_some() && restored.is_none() {
            // Everything else is stored for the order of the source.
            state = StoredState::default();
        }
        let current = stored.as_ref().filter(|_| state.is_current);
        let asset = assembled(&opened, restored.as_deref(), current);
        let asset = asset.with_context(|| opened.name())?;
        told.extend(stored.map(Stored::into_warnings).into_iter().flatten());
        let warning = |what| Warning {
            at: "extensions.ARTICULA_prepared".to_owned(),
            what,
            guess: None,
        };
        opened.warnings_mut().extend(told.into_iter().map(warning));
        Ok(Self {
            orders,
            source_meshes: restored,
            opened,
            asset,
            state,
        })
    }

    /// Returns whether the file stores [prepared](crate::prepare()) data that belong to the character: then
    /// a [`CrowdAsset`](crate::crowd::CrowdAsset) reads what it else computes.
    pub fn is_prepared(&self) -> bool {
        self.stored().is_some()
    }

    /// Measures the clips of the figure against the keys of its file.
    pub fn resampling(&self) -> Vec<ClipResampling> {
        let clips = 0..self.asset.clips.len();
        clips.map(|clip| self.resampling_of(clip)).collect()
    }

    /// Measures one clip of the figure against the keys of its file.
    pub(crate) fn resampling_of(&self, clip: usize) -> ClipResampling {
        let (character, asset) = (self.opened.character(), &self.asset);
        of_frames(
            character,
            &asset.mesh,
            &character.clips[clip],
            &asset.clips[clip],
        )
    }

    #[cfg(feature = "prepare")]
    /// Order of the vertices in the source, for each primitive, if the document has another.
    pub(crate) fn orders(&self) -> Option<&[SourceOrder]> {
        self.orders.as_deref()
    }

    /// The vertices of the character's meshes, counted over all primitives, that are these vertices of
    /// the figure's mesh.
    pub(crate) fn in_character(&self, vertices: &[u32]) -> Result<Vec<u32>> {
        let Some(orders) = &self.orders else {
            return Ok(vertices.to_vec());
        };
        let mut stored = vec![0; self.asset.mesh.len()];
        for (part, order) in self.asset.mesh.parts.iter().zip(orders) {
            let first = part.vertices.start as u32;
            let places = order.places(part.vertices.len())?;
            let of_part = stored[part.vertices.clone()].iter_mut();
            of_part.zip(places).for_each(|(s, p)| *s = first + p);
        }
        Ok(vertices.iter().map(|v| stored[*v as usize]).collect())
    }

    /// The data that the file stores, if it belongs to the character.
    pub(crate) fn stored(&self) -> Option<Stored<'_>> {
        self.opened.stored().filter(|_| self.state.is_current)
    }

    /// The character with its meshes in the order of the source.
    pub(crate) fn source_character(&self) -> Character {
        let mut character = self.opened.character().clone();
        if let Some(meshes) = &self.source_meshes {
            character.meshes.clone_from(meshes);
        }
        character
    }

    /// Returns the number of mesh levels that the file stores, 0 without levels.
    pub fn stored_mesh_level_count(&self) -> usize {
        let table = self.opened.character().mesh_levels.as_ref();
        table.map_or(0, |table| table.levels.len())
    }

    /// Triangles of each mesh level of the file over the vertices of the mesh; `None` without
    /// levels, or if they do not cover the mesh.
    pub(crate) fn stored_mesh_levels(&self) -> Option<Vec<Vec<[u32; 3]>>> {
        let levels = self.stored_mesh_level_count();
        if levels == 0 {
            return None;
        }
        let mut out = vec![Vec::new(); levels];
        let mut parts = self.asset.mesh.parts.iter();
        let mut orders = self.orders.iter().flatten();
        for mesh in &self.opened.character().meshes {
            if mesh.clustered.len() != mesh.primitives.len() {
                return None;
            }
            for object in &mesh.clustered {
                let first = parts.next()?.vertices.start as u32;
                let order = orders.next();
                let source = |v: u32| match order {
                    Some(order) => order.vertices.get(v as usize).map(|v| first + v),
                    None => Some(first + v),
                };
                for (level, out) in out.iter_mut().enumerate() {
                    for range in object.clusters.ranges(level) {
                        for t in object
                            .triangles
                            .get(range.start as usize..range.end as usize)?
                        {
                            out.push([source(t[0])?, source(t[1])?, source(t[2])?]);
                        }
                    }
                }
            }
        }
        Some(out)
    }

    /// Returns the index of the clip called `name`, or of the first clip if `name` is `None`;
    /// `None` if there is no clip.
    ///
    /// # Errors
    /// [`Error::Argument`] if no clip has this name; the message lists the clips.
    pub fn clip(&self, name: Option<&str>) -> Result<Option<usize>> {
        let names = self
            .opened
            .character()
            .clips
            .iter()
            .map(|c| c.name.as_str());
        match name {
            Some(name) => choose("clip", name, names)
                .with_context(|| self.opened.name())
                .map(Some),
            None => Ok((!self.asset.clips.is_empty()).then_some(0)),
        }
    }
}

/// Rig, mesh and clips of a character, with its meshes in the order of the source.
fn assembled(
    opened: &CharacterFile,
    meshes: Option<&[RawMesh]>,
    stored: Option<&Stored<'_>>,
) -> Result<Asset> {
    let mut asset = with_own_materials(opened, meshes, stored)?;
    let drawn = draw_materials(opened);
    for part in &mut Arc::make_mut(&mut asset.mesh).parts {
        part.draw_material = part.material.map(|m| drawn.get(m).copied().unwrap_or(m));
    }
    Ok(asset)
}

fn with_own_materials(
    opened: &CharacterFile,
    meshes: Option<&[RawMesh]>,
    stored: Option<&Stored<'_>>,
) -> Result<Asset> {
    let source = opened.character();
    let articulation = opened.articulation();
    let shown = meshes.unwrap_or(&source.meshes);
    if let Some(stored) = stored {
        let (rig, mesh) = rig_and_mesh(&source.skeleton, shown, articulation.clone())?;
        if let Some(clips) = stored.clips(&source.clips, &rig, &mesh) {
            return Ok(Asset {
                rig: rig.into(),
                mesh: mesh.into(),
                clips,
            });
        }
    }
    let options = ClipOptions::default();
    Ok(match meshes {
        None => character(source, Some(articulation), &options)?,
        Some(meshes) => {
            let restored = Character {
                meshes: meshes.to_vec(),
                ..source.clone()
            };
            character(&restored, Some(articulation), &options)?
        }
    })
}

//! What a renderer draws of a crowd's frame.

use super::material_ranges::MaterialRange;
use super::player::CrowdPlayer;
use articula_core::crowd::{Draw, DrawGroup, DrawKind, ImpostorDraw};
use articula_core::{BlendRecord, Mesh};
use std::ops::Range;

/// Characters of one level whose poses are read alike: one instanced draw for each material of the mesh, or for several
/// that differ in colour alone ([`MaterialRange::joins_previous`]).
#[derive(Debug, Clone)]
pub struct InstancedDraw<'a> {
    /// The level; 0 is full detail. Of impostors, which have none, the coarsest.
    pub level: usize,
    /// Mesh of the level; `None` for impostors, whose pictures are those of
    /// [`CrowdAsset::impostors`](super::CrowdAsset::impostors).
    pub mesh: Option<&'a Mesh>,
    /// Triangles of the mesh by material; none of impostors.
    pub ranges: &'a [MaterialRange],
    /// Number of matrices in one palette.
    pub matrices: usize,
    /// The characters.
    pub instances: Instances<'a>,
    /// Sets of [`CrowdPlayer::morph_weights`] of the first characters, one each; the faces of the others
    /// have the default weights of the mesh.
    pub morph_sets: Range<usize>,
}

/// Characters of an [`InstancedDraw`], with what a renderer reads of each.
#[derive(Debug, Clone, Copy)]
pub enum Instances<'a> {
    /// Index in [`CrowdPlayer::palettes`] of the first matrix of each.
    Palettes(&'a [Draw]),
    /// Two palettes of the [pose cache](articula_core::PoseCache::rows), which the GPU blends.
    Records(&'a [BlendRecord]),
    /// Index in the [pose cache](articula_core::PoseCache::rows) of the first matrix of each.
    Steps(&'a [Draw]),
    /// Index of the pose of each among those of the impostors.
    Impostors(&'a [ImpostorDraw]),
}

impl Instances<'_> {
    /// Returns what is read of each.
    pub fn kind(&self) -> DrawKind {
        match self {
            Self::Palettes(_) => DrawKind::Palette,
            Self::Records(_) => DrawKind::Record,
            Self::Steps(_) => DrawKind::Step,
            Self::Impostors(_) => DrawKind::Impostor,
        }
    }

    /// Returns the index of each character in the crowd.
    pub fn characters(&self) -> impl ExactSizeIterator<Item = usize> + '_ {
        let character = |i: usize| match self {
            Self::Palettes(draws) | Self::Steps(draws) => draws[i].character as usize,
            Self::Records(records) => records[i].character as usize,
            Self::Impostors(draws) => draws[i].character as usize,
        };
        (0..self.len()).map(character)
    }

    /// Returns the number of characters, at least 1.
    #[expect(clippy::len_without_is_empty, reason = "a draw has a character")]
    pub fn len(&self) -> usize {
        match self {
            Self::Palettes(draws) | Self::Steps(draws) => draws.len(),
            Self::Records(records) => records.len(),
            Self::Impostors(draws) => draws.len(),
        }
    }
}

impl CrowdPlayer {
    /// Returns all that is to be drawn: every visible character once, by level and then by what a
    /// renderer reads.
    pub fn draws(&self) -> impl Iterator<Item = InstancedDraw<'_>> {
        let groups = self.crowd().draw_list().groups.iter();
        groups.map(|group| self.instanced(group))
    }

    fn instanced(&self, group: &DrawGroup) -> InstancedDraw<'_> {
        let list = self.crowd().draw_list();
        let (kind, range) = (group.kind, group.range.clone());
        let first_set = list.first_morph_set(kind);
        let sets = range.start..list.with_morphs(kind).clamp(range.start, range.end);
        let mesh = (kind != DrawKind::Impostor).then(|| self.asset().mesh(group.level));
        InstancedDraw {
            level: group.level,
            ranges: mesh.map_or(&[], |_| self.asset().material_ranges(group.level)),
            mesh,
            matrices: group.matrices,
            instances: match kind {
                DrawKind::Palette => Instances::Palettes(&list.draws[range]),
                DrawKind::Record => Instances::Records(&self.records()[range]),
                DrawKind::Step => Instances::Steps(&self.stepped()[range]),
                DrawKind::Impostor => Instances::Impostors(&self.impostors()[range]),
            },
            morph_sets: first_set + sets.start..first_set + sets.end,
        }
    }
}

//! Statistics of the levels in use: number of characters, error and rendering cost.

use super::asset::{CrowdAsset, CrowdLevel};
use super::impostors::CrowdImpostors;
use super::lod_error::{CharacterError, ErrorSample};
use super::player::CrowdPlayer;
use articula_core::crowd::{Draw, DrawKind, ImpostorDraw};
use articula_core::{BlendRecord, percentile};
use serde::Serialize;

/// Statistics of one level over all frames; counts of characters and poses are means per frame.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LevelStatistics {
    /// The level; 0 is full detail. The number of levels stands for impostors.
    pub level: usize,
    /// Whether these are the characters that are shown by impostors.
    pub is_impostor: bool,
    /// Number of joints that the level keeps.
    pub joints: usize,
    /// Number of matrices in one palette.
    pub matrices: usize,
    /// Number of triangles drawn per character.
    pub triangles: usize,
    /// Maximum number of influences per vertex.
    pub influences: usize,
    /// Number of characters at this level.
    pub characters: f64,
    /// Number of palettes evaluated for them.
    pub poses: f64,
    /// Number of characters in a cross-fade.
    pub blended: f64,
    /// Number of characters whose cached palettes the GPU blends from 16-byte records.
    pub records: f64,
    /// Number of characters that show a cached palette as it is, from 8-byte draws.
    pub steps: f64,
    /// Greatest error of the level over the clips, in millimetres: 95th percentile over vertices.
    pub error_mm: f32,
    /// The same error in pixels for the nearest character at this level over all frames, with that of
    /// its morph level; null if all characters are shown in full, visible or not.
    pub error_bound_px: Option<f32>,
    /// Errors measured on the sampled characters.
    pub error_px: Option<MeasuredError>,
    /// Rendering cost.
    pub renderer: DrawCost,
}

/// Measured errors of a level.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MeasuredError {
    /// 95th percentile over characters and frames, in pixels.
    pub p95: f64,
    /// Maximum, in pixels.
    pub max: f64,
}

/// Rendering cost, mean per frame except for resident memory.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct DrawCost {
    /// Number of instanced draws: one for each material of the mesh.
    pub draw_groups: f64,
    /// Bytes of palettes that the CPU writes.
    pub palette_bytes: f64,
    /// Bytes of blend records.
    pub record_bytes: f64,
    /// Bytes of the draws of cached palettes.
    pub step_bytes: f64,
    /// Bytes of the draws of impostors.
    pub impostor_bytes: f64,
    /// Number of skinned vertices.
    pub skinned_vertices: f64,
    /// Number of triangles drawn.
    pub triangles: f64,
    /// Number of triangles if every character had the original mesh.
    pub triangles_full: f64,
    /// Bytes of the level's mesh in memory: positions, normals, texture coordinates, influences;
    /// triangles once; of impostors the pixels.
    pub resident_bytes: usize,
}

impl DrawCost {
    /// Sums the costs of all levels.
    pub fn sum<'a>(tiers: impl IntoIterator<Item = &'a LevelStatistics>) -> Self {
        tiers.into_iter().fold(Self::default(), |sum, tier| Self {
            draw_groups: sum.draw_groups + tier.renderer.draw_groups,
            palette_bytes: sum.palette_bytes + tier.renderer.palette_bytes,
            record_bytes: sum.record_bytes + tier.renderer.record_bytes,
            step_bytes: sum.step_bytes + tier.renderer.step_bytes,
            impostor_bytes: sum.impostor_bytes + tier.renderer.impostor_bytes,
            skinned_vertices: sum.skinned_vertices + tier.renderer.skinned_vertices,
            triangles: sum.triangles + tier.renderer.triangles,
            triangles_full: sum.triangles_full + tier.renderer.triangles_full,
            resident_bytes: sum.resident_bytes + tier.renderer.resident_bytes,
        })
    }
}

/// Accumulates level statistics over frames.
#[derive(Debug)]
pub struct LevelTally {
    frames: usize,
    levels: Vec<Sums>,
}

#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    characters: usize,
    /// Characters by what a renderer reads.
    drawn: [usize; DrawKind::ALL.len()],
    blended: usize,
    groups: usize,
    most_px: f32,
    is_unbounded: bool,
}

impl Sums {
    /// Adds one shown character.
    fn see(&mut self, player: &CrowdPlayer, level: usize, character: usize) {
        let state = player.crowd().state(character);
        self.blended += usize::from(state.fade() > 0.0);
        let from = state.clip_state().clip();
        let to = state.next().map_or(from, |v| v.clip());
        let model = player.asset().model();
        let morph_level = player.crowd().morph_level(model, character);
        let face = morph_level.map_or(0.0, |level| model.morph_error_metres(from, to, level));
        let error = model.error_metres(from, to, level) + face;
        let density = player.crowd().cull_result(character).pixels_per_metre;
        self.is_unbounded |= density == f32::MAX;
        self.most_px = self.most_px.max(error * density);
    }

    /// Adds a character that is shown by an impostor.
    fn see_impostor(&mut self, player: &CrowdPlayer, character: usize) {
        let clip = player.crowd().state(character).clip_state().clip();
        let impostors = player.asset().model().parts().impostors.as_ref();
        let error = impostors.and_then(|i| i.error_metres(clip)).unwrap_or(0.0);
        let density = player.crowd().cull_result(character).pixels_per_metre;
        self.most_px = self.most_px.max(error * density);
    }
}

impl LevelTally {
    /// Creates an empty tally.
    pub fn new(asset: &CrowdAsset) -> Self {
        Self {
            frames: 0,
            levels: vec![Sums::default(); asset.levels() + 1],
        }
    }

    /// Adds a frame.
    pub fn add(&mut self, player: &CrowdPlayer) {
        self.frames += 1;
        for draw in player.draws() {
            let count = draw.instances.len();
            let kind = draw.instances.kind();
            let is_impostor = kind == DrawKind::Impostor;
            let level = if is_impostor {
                self.levels.len() - 1
            } else {
                draw.level
            };
            let sums = &mut self.levels[level];
            sums.groups += 1;
            sums.characters += count;
            sums.drawn[kind as usize] += count;
            for character in draw.instances.characters() {
                if is_impostor {
                    sums.see_impostor(player, character);
                } else {
                    sums.see(player, level, character);
                }
            }
        }
    }

    /// Returns statistics of every level that was used, and of impostors.
    pub fn levels(&self, asset: &CrowdAsset, samples: &[ErrorSample]) -> Vec<LevelStatistics> {
        let levels = self.levels.iter().enumerate();
        let shown = levels.filter(|(_, sums)| sums.characters > 0);
        shown
            .map(|(l, s)| self.level(asset, l, s, samples))
            .collect()
    }

    fn level(
        &self,
        asset: &CrowdAsset,
        level: usize,
        sums: &Sums,
        samples: &[ErrorSample],
    ) -> LevelStatistics {
        let mean = |count: usize| count as f64 / self.frames.max(1) as f64;
        let drawn = |kind| mean(sums.drawn[kind as usize]);
        let model = asset.model();
        let is_impostor = level == asset.levels();
        let made = match is_impostor {
            true => CrowdLevel::IMPOSTOR,
            false => asset.level(level),
        };
        let clips = model.parts().errors.clips.iter();
        let of_levels = clips.filter_map(|c| c.levels_metres.get(level).copied());
        let impostors = asset.own_impostors().filter(|_| is_impostor);
        let of_impostors = impostors.map(CrowdImpostors::error_metres);
        let error_metres = of_levels.chain(of_impostors).fold(0.0, f32::max);
        let of_level = |c: &&CharacterError| c.level == level;
        let looked = samples.iter().flat_map(|l| &l.characters).filter(of_level);
        let mut errors: Vec<f64> = looked.map(|c| c.p95_px).collect();
        let p95 = percentile(&mut errors, 0.95);
        LevelStatistics {
            level,
            is_impostor,
            joints: made.joints,
            matrices: made.matrices,
            triangles: made.triangles,
            influences: made.influences,
            characters: mean(sums.characters),
            poses: drawn(DrawKind::Palette),
            blended: mean(sums.blended),
            records: drawn(DrawKind::Record),
            steps: drawn(DrawKind::Step),
            error_mm: 1e3 * error_metres,
            error_bound_px: (!sums.is_unbounded).then_some(sums.most_px),
            error_px: (!errors.is_empty()).then(|| MeasuredError {
                p95,
                max: percentile(&mut errors, 1.0),
            }),
            renderer: DrawCost {
                draw_groups: mean(match is_impostor {
                    true => sums.groups,
                    // Without a mesh there is nothing to draw, and a draw is what it would be.
                    false => sums.groups * asset.draws(level).max(1),
                }),
                palette_bytes: drawn(DrawKind::Palette)
                    * (made.matrices * model.parts().form.bytes()) as f64,
                record_bytes: drawn(DrawKind::Record) * size_of::<BlendRecord>() as f64,
                step_bytes: drawn(DrawKind::Step) * size_of::<Draw>() as f64,
                impostor_bytes: match is_impostor {
                    true => mean(sums.characters) * size_of::<ImpostorDraw>() as f64,
                    false => 0.0,
                },
                skinned_vertices: mean(sums.characters) * made.vertices as f64,
                triangles: mean(sums.characters) * made.triangles as f64,
                triangles_full: mean(sums.characters) * asset.full().mesh.triangles.len() as f64,
                resident_bytes: impostors
                    .map_or_else(|| resident_bytes(asset, level), CrowdImpostors::bytes),
            },
        }
    }
}

/// Bytes of a level's vertices, and of each mesh level's triangles once.
fn resident_bytes(asset: &CrowdAsset, level: usize) -> usize {
    let made = asset.level(level);
    // Position, normal, texture coordinates; per influence an index of 2 and a weight of 4 bytes.
    let vertex = 12 + 12 + 8 + 6 * asset.mesh(level).influences;
    let is_known = level > 0 && asset.level(level - 1).triangles == made.triangles;
    let triangles = if is_known { 0 } else { made.triangles };
    made.vertices * vertex + triangles * 12
}

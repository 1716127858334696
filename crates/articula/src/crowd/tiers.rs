//! Who is shown at which level, what it was expected to cost the viewer, and what a renderer pays.

use super::cast::Cast;
use super::pixel_error::{CharacterError, Looked};
use super::stage::Stage;
use articula_core::percentile;
use serde::Serialize;

/// One level over all frames; counts of characters and poses are means over frames.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Tier {
    pub(crate) level: usize,
    pub(crate) joints: usize,
    /// Matrices of one palette.
    pub(crate) matrices: usize,
    /// Triangles that one character is drawn with.
    pub(crate) triangles: usize,
    /// Most influences of a vertex.
    pub(crate) influences: usize,
    pub(crate) characters: f64,
    /// Palettes that are written for them.
    pub(crate) poses: f64,
    /// Characters that show a palette which another one shows too.
    pub(crate) shared: f64,
    /// Characters between two clips.
    pub(crate) blended: f64,
    /// Characters whose cached palettes the GPU blends, by 16 bytes each.
    pub(crate) records: f64,
    /// Greatest error of the level over the clips, millimetres: 95th percentile over vertices.
    pub(crate) error_mm: f32,
    /// The same in pixels for the nearest who shows it, over all frames; null where everyone is
    /// shown in full, seen or not.
    pub(crate) error_bound_px: Option<f32>,
    /// What was measured on those who were looked at.
    pub(crate) error_px: Option<TierError>,
    pub(crate) renderer: Renderer,
}

/// Measured errors of a level.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct TierError {
    pub(crate) p95: f64,
    pub(crate) max: f64,
}

/// What a renderer pays, a frame on average but for what stays in its memory.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub(crate) struct Renderer {
    /// Instanced draws: one for each part of the mesh.
    pub(crate) draw_groups: f64,
    pub(crate) palette_bytes: f64,
    pub(crate) skinned_vertices: f64,
    pub(crate) triangles: f64,
    /// Had everyone the original mesh.
    pub(crate) triangles_full: f64,
    /// Of the level's mesh: positions, normals, texture coordinates, influences; triangles once.
    pub(crate) resident_bytes: usize,
}

impl Renderer {
    /// Of all levels together.
    pub(crate) fn sum(tiers: &[Tier]) -> Self {
        tiers.iter().fold(Self::default(), |sum, tier| Self {
            draw_groups: sum.draw_groups + tier.renderer.draw_groups,
            palette_bytes: sum.palette_bytes + tier.renderer.palette_bytes,
            skinned_vertices: sum.skinned_vertices + tier.renderer.skinned_vertices,
            triangles: sum.triangles + tier.renderer.triangles,
            triangles_full: sum.triangles_full + tier.renderer.triangles_full,
            resident_bytes: sum.resident_bytes + tier.renderer.resident_bytes,
        })
    }
}

/// Sums over frames, by level.
#[derive(Debug)]
pub(crate) struct Tally {
    frames: usize,
    levels: Vec<Sums>,
    palettes: Vec<u32>,
}

#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    characters: usize,
    poses: usize,
    shared: usize,
    blended: usize,
    records: usize,
    groups: usize,
    most_px: f32,
    is_unbounded: bool,
}

impl Sums {
    /// Adds what one character shows.
    fn see(&mut self, stage: &Stage<'_>, level: usize, character: usize) {
        let player = stage.crowd.player(character);
        self.blended += usize::from(player.fade() > 0.0);
        let from = player.voice().clip();
        let to = player.next().map_or(from, |v| v.clip());
        let error = stage.cast.model.error_metres(from, to, level);
        let density = stage.crowd.seen(character).pixels_per_metre;
        self.is_unbounded |= density == f32::MAX;
        self.most_px = self.most_px.max(error * density);
    }
}

impl Tally {
    /// Nothing yet.
    pub(crate) fn new(cast: &Cast) -> Self {
        Self {
            frames: 0,
            levels: vec![Sums::default(); cast.model.levels()],
            palettes: Vec::new(),
        }
    }

    /// Adds a frame.
    pub(crate) fn add(&mut self, stage: &Stage<'_>) {
        self.frames += 1;
        let crowd = &stage.crowd;
        for group in crowd.groups() {
            let draws = &crowd.draws()[group.draws.clone()];
            let sums = &mut self.levels[group.level];
            self.palettes.clear();
            self.palettes.extend(draws.iter().map(|d| d.first_matrix));
            self.palettes.sort_unstable();
            let runs = || self.palettes.chunk_by(|a, b| a == b);
            sums.groups += 1;
            sums.characters += draws.len();
            sums.poses += runs().count();
            let several = runs().map(<[u32]>::len).filter(|n| *n > 1);
            sums.shared += several.sum::<usize>();
            for draw in draws {
                sums.see(stage, group.level, draw.character as usize);
            }
        }
        for group in crowd.record_groups() {
            let sums = &mut self.levels[group.level];
            sums.groups += 1;
            sums.records += group.records.len();
            sums.characters += group.records.len();
            for record in &crowd.records()[group.records.clone()] {
                sums.see(stage, group.level, record.character as usize);
            }
        }
    }

    /// Every level that someone was shown at.
    pub(crate) fn tiers(&self, cast: &Cast, looks: &[Looked]) -> Vec<Tier> {
        let levels = self.levels.iter().enumerate();
        let shown = levels.filter(|(_, sums)| sums.characters > 0);
        shown.map(|(l, s)| self.tier(cast, l, s, looks)).collect()
    }

    fn tier(&self, cast: &Cast, level: usize, sums: &Sums, looks: &[Looked]) -> Tier {
        let mean = |count: usize| count as f64 / self.frames.max(1) as f64;
        let model = &cast.model;
        let matrices = model.palette().len(level);
        let clips = model.errors().clips.iter();
        let error_metres = clips.map(|c| c.levels_metres[level]).fold(0.0, f32::max);
        let of_level = |c: &&CharacterError| c.level == level;
        let looked = looks.iter().flat_map(|l| &l.characters).filter(of_level);
        let mut errors: Vec<f64> = looked.map(|c| c.p95_px).collect();
        let p95 = percentile(&mut errors, 0.95);
        let [vertices, triangles] = drawn(cast, level);
        let parts = cast.asset.mesh.parts.len().max(1);
        Tier {
            level,
            joints: cast.ladder().kept(level),
            matrices,
            triangles,
            influences: cast.skins.levels[level].influences,
            characters: mean(sums.characters),
            poses: mean(sums.poses),
            shared: mean(sums.shared),
            blended: mean(sums.blended),
            records: mean(sums.records),
            error_mm: 1e3 * error_metres,
            error_bound_px: (!sums.is_unbounded).then_some(sums.most_px),
            error_px: errors.last().map(|max| TierError { p95, max: *max }),
            renderer: Renderer {
                draw_groups: mean(sums.groups * parts),
                palette_bytes: mean(sums.poses) * (matrices * model.form().bytes()) as f64,
                skinned_vertices: mean(sums.characters) * vertices as f64,
                triangles: mean(sums.characters) * triangles as f64,
                triangles_full: mean(sums.characters) * cast.asset.mesh.triangles.len() as f64,
                resident_bytes: resident_bytes(cast, level),
            },
        }
    }
}

/// Vertices and triangles of one character at a level.
fn drawn(cast: &Cast, level: usize) -> [usize; 2] {
    match &cast.figure {
        _ if !cast.has_mesh => [0; 2],
        Some(figure) => {
            let found = figure.levels[level];
            [found.vertices, found.triangles]
        }
        None => [cast.asset.mesh.len(), cast.asset.mesh.triangles.len()],
    }
}

/// Bytes of a level's vertices, and of each mesh level's triangles once.
fn resident_bytes(cast: &Cast, level: usize) -> usize {
    let [vertices, triangles] = drawn(cast, level);
    // Position, normal, texture coordinates; an index of 2 and a weight of 4 bytes each.
    let vertex = 12 + 12 + 8 + 6 * cast.meshes[level].influences;
    let is_known = level > 0 && drawn(cast, level - 1)[1] == triangles;
    let triangles = if is_known { 0 } else { triangles };
    vertices * vertex + triangles * 12
}

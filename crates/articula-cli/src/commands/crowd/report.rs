//! The report of `crowd`; its field names are stable (`docs/commands.md`).

use super::{CrowdArgs, Piece};
use crate::crowd::faces::MorphUse;
use crate::crowd::roles::RoleError;
use crate::crowd::run::{BudgetFound, Memory, Poses, Run};
use crate::crowd::timing::Spread;
use crate::fault::clean;
use crate::files;
use crate::table::Table;
use articula::crowd::{DrawCost, ErrorSummary, LevelStatistics};
use clap::ValueEnum;
use serde::{Serialize, Serializer};

/// Report of one run.
#[derive(Debug, Serialize)]
pub(super) struct CrowdRunReport {
    pub(super) file: String,
    /// The characters, if there are several.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) cast: Vec<CastReport>,
    pub(super) scene: String,
    pub(super) views: usize,
    pub(super) level: String,
    pub(super) mesh_levels: Option<usize>,
    pub(super) clips: Vec<String>,
    pub(super) characters: usize,
    /// Median over frames, as are the next two fields.
    pub(super) visible: usize,
    pub(super) in_cull_margin: usize,
    pub(super) hidden: usize,
    /// Wholly hidden by others or by walls.
    pub(super) occluded: usize,
    pub(super) frames: usize,
    pub(super) display_hz: f64,
    pub(super) threads: usize,
    pub(super) source: String,
    pub(super) root_motion: bool,
    /// Travelling clips that are played in place.
    pub(super) clips_in_place: Vec<String>,
    pub(super) epsilon_px: f32,
    pub(super) viewport_px: [f32; 2],
    pub(super) fov_deg: f32,
    pub(super) seed: u64,
    pub(super) backend: String,
    pub(super) storage: String,
    pub(super) form: String,
    pub(super) palette: String,
    /// Time from opening the file to the first frame: reading, and preparing what is not stored.
    pub(super) ready_ms: f64,
    pub(super) ns_per_character: Spread,
    pub(super) characters_per_ms: f64,
    /// Processor time of a whole frame, all threads together.
    pub(super) frame_ms: Spread,
    pub(super) wall_ms: Spread,
    pub(super) tick_ms: Spread,
    pub(super) written_mb: Spread,
    pub(super) working_set: Memory,
    pub(super) poses: Poses,
    pub(super) morphs: MorphUse,
    pub(super) error_px: ErrorSummary,
    /// Errors by role, if any character has one.
    pub(super) roles: Vec<RoleError>,
    pub(super) error_bound_px: Option<f32>,
    pub(super) budget_ms: Option<f32>,
    /// Time beyond the budget as a fraction of it, 95th percentile.
    pub(super) overrun_p95: Option<f64>,
    pub(super) budget: Option<BudgetFound>,
    /// Levels of the character; of several, in `cast`.
    #[serde(serialize_with = "by_level")]
    pub(super) tiers: Vec<LevelStatistics>,
    pub(super) renderer: DrawCost,
    pub(super) palette_hash: String,
    /// Files written.
    pub(super) written: Vec<String>,
    pub(super) warnings: Vec<String>,
}

/// One of several characters of a run.
#[derive(Debug, Serialize)]
pub(super) struct CastReport {
    /// Its name in scene files.
    pub(super) name: String,
    pub(super) file: String,
    pub(super) characters: usize,
    pub(super) clips: Vec<String>,
    #[serde(serialize_with = "by_level")]
    pub(super) tiers: Vec<LevelStatistics>,
    pub(super) renderer: DrawCost,
}

/// Serialises levels as an object, keyed by name in the order of the levels.
fn by_level<S: Serializer>(tiers: &[LevelStatistics], out: S) -> Result<S::Ok, S::Error> {
    let name = |t: &LevelStatistics| match t.is_impostor {
        true => "impostors".to_owned(),
        false => format!("level_{}", t.level),
    };
    out.collect_map(tiers.iter().map(|t| (name(t), t)))
}

fn name_of(value: impl ValueEnum) -> String {
    let value = value.to_possible_value();
    value.map_or(String::new(), |v| v.get_name().to_owned())
}

impl CrowdRunReport {
    /// Makes the report of a run.
    pub(super) fn new(args: &CrowdArgs, piece: &Piece, run: &Run) -> Self {
        let characters = piece.scene.members.len();
        let frame_ns = |ms: f64| ms * 1e6 / characters.max(1) as f64;
        let visible = run.visible.median.round() as usize;
        let occluded = run.occluded.median.round() as usize;
        let in_cull_margin = run.in_cull_margin.median.round() as usize;
        // Who is occluded counts as in the margin for a frame.
        let in_cull_margin = in_cull_margin.saturating_sub(occluded);
        let viewport = piece.scene.views[0].viewport;
        let all = || run.tiers.iter().flatten();
        let cast = cast_of(piece, run);
        Self {
            file: listed(cast.iter().map(|c| &c.file)).join(", "),
            clips: listed(cast.iter().flat_map(|c| &c.clips)),
            clips_in_place: listed(piece.cast.iter().flat_map(|c| {
                let clips = c.asset.clips().iter().enumerate();
                let travelling = clips.filter(|(i, _)| c.asset.travels(*i));
                travelling.map(|(_, clip)| &clip.name)
            })),
            warnings: warnings(piece),
            tiers: match &run.tiers[..] {
                [tiers] => tiers.clone(),
                _ => Vec::new(),
            },
            renderer: DrawCost::sum(all()),
            cast: if cast.len() > 1 { cast } else { Vec::new() },
            views: piece.scene.views.len(),
            scene: piece.scene_name.clone(),
            level: args.level.clone(),
            mesh_levels: args.mesh_levels,
            characters,
            visible,
            in_cull_margin,
            hidden: characters.saturating_sub(visible + in_cull_margin + occluded),
            occluded,
            frames: run.frames,
            display_hz: super::DISPLAY_HZ,
            threads: args.threads,
            source: name_of(args.storage.source),
            root_motion: args.root_motion,
            epsilon_px: args.epsilon_px,
            viewport_px: [viewport.width_px, viewport.height_px],
            fov_deg: viewport.fov_y_radians.to_degrees(),
            seed: args.seed,
            backend: args
                .storage
                .backend
                .unwrap_or_else(articula::core::Backend::best)
                .to_string(),
            ready_ms: 0.0,
            storage: name_of(args.storage.storage),
            form: name_of(args.storage.form),
            palette: name_of(args.palette()),
            ns_per_character: Spread {
                median: frame_ns(run.frame_ms.median),
                p95: frame_ns(run.frame_ms.p95),
            },
            characters_per_ms: characters as f64 / run.frame_ms.median.max(1e-9),
            frame_ms: run.frame_ms,
            wall_ms: run.wall_ms,
            tick_ms: run.tick_ms,
            written_mb: run.written_mb,
            working_set: run.memory,
            poses: run.poses,
            morphs: run.morphs.clone(),
            error_px: run.error,
            roles: run.roles.clone(),
            error_bound_px: run.bound_px,
            budget_ms: args.budget_ms,
            overrun_p95: run.overrun_p95,
            budget: run.budget,
            palette_hash: run.hash.clone(),
            written: Vec::new(),
        }
    }

    /// Formats the report for people.
    pub(super) fn text(&self) -> String {
        let mut text = self.heading();
        text.push('\n');
        if self.cast.is_empty() {
            text.push_str(&tier_table(&self.tiers).text());
        }
        for (i, character) in self.cast.iter().enumerate() {
            let count = character.characters;
            let name = clean(&character.name);
            let gap = if i > 0 { "\n" } else { "" };
            text.push_str(&format!("{gap}{name}: {count} characters\n"));
            text.push_str(&tier_table(&character.tiers).text());
        }
        text.push_str(&self.sums());
        for warning in &self.warnings {
            text.push_str(&format!("warning: {}\n", clean(warning)));
        }
        for file in &self.written {
            text.push_str(&format!("wrote {}\n", clean(file)));
        }
        text
    }

    fn heading(&self) -> String {
        let name = match self.cast.len() {
            0 => self.file.rsplit(['/', '\\']).next().unwrap_or(&self.file),
            count => &format!("{count} different characters"),
        };
        let views = match self.views {
            1 => String::new(),
            count => format!("{count} views, the first "),
        };
        let threads = crate::table::counted(self.threads, "thread", "threads");
        let clips = crate::table::counted(self.clips.len(), "clip", "clips");
        format!(
            "{}, {} characters, scene {}, level {}, {clips}\n\
             {} frames at {} Hz, {threads}, {}, {views}{} x {} px, {:.0} degrees\n\
             characters: {} visible, {} in the cull margin, {} hidden{}\n\
             ready in {:.0} ms\n",
            clean(name),
            self.characters,
            clean(&self.scene),
            clean(&self.level),
            self.frames,
            self.display_hz,
            self.backend,
            self.viewport_px[0],
            self.viewport_px[1],
            self.fov_deg,
            self.visible,
            self.in_cull_margin,
            self.hidden,
            match self.occluded {
                0 => String::new(),
                occluded => format!(", {occluded} occluded"),
            },
            self.ready_ms
        )
    }

    /// Errors of small parts of the body and of roles.
    fn error_parts(&self) -> String {
        let mut text = String::new();
        let parts = self.error_px.parts;
        let parts = [
            ("hands", parts.hands),
            ("face", parts.face),
            ("feet", parts.feet),
        ];
        let parts = parts
            .into_iter()
            .filter_map(|(name, px)| Some(format!("{name} {:.2} px", px?)));
        let parts: Vec<String> = parts.collect();
        if !parts.is_empty() {
            text.push_str(&format!("       worst vertex of {}\n", parts.join(", ")));
        }
        for role in &self.roles {
            text.push_str(&format!(
                "       {} (importance {}): p95 {:.2} px, max {:.2} px\n",
                clean(&role.role),
                role.importance,
                role.p95_px,
                role.max_px
            ));
        }
        text
    }

    fn sums(&self) -> String {
        let mut text = format!(
            "\ntime   median {:.3} ms per frame (p95 {:.3}), {:.1} ns per character, {:.0} characters per ms; before evaluation {:.3} ms; wall clock {:.3} ms\n",
            self.frame_ms.median,
            self.frame_ms.p95,
            self.ns_per_character.median,
            self.characters_per_ms,
            self.tick_ms.median,
            self.wall_ms.median
        );
        text.push_str(&format!(
            "error  p95 {:.2} px, max {:.2} px, max within 20 m {:.2} px, worst vertex {:.2} px ({} characters sampled, {} within 20 m)\n",
            self.error_px.p95,
            self.error_px.max,
            self.error_px.near_max,
            self.error_px.worst_vertex,
            self.error_px.drawn,
            self.error_px.near
        ));
        text.push_str(&self.error_parts());
        text.push_str(&format!(
            "poses  {:.0} per frame evaluated ({:.0} blend two clips), {:.0} blended from the cache, {:.0} shown from it as they are\n",
            self.poses.own,
            self.poses.blended,
            self.poses.cached,
            self.poses.stepped
        ));
        if !self.morphs.levels.is_empty() {
            text.push_str(&format!(
                "faces  {:.0} characters per frame with morph target weights, {:.3} MB; characters by targets shown: {}\n",
                self.morphs.characters,
                self.morphs.bytes as f64 / 1e6,
                self.morphs.by_level()
            ));
        }
        text.push_str(&format!(
            "draw   {:.0} groups, {:.2} M vertices, {:.2} M triangles ({:.2} M in full detail); palettes {:.2} MB, records {:.2} MB, draws of cached palettes {:.2} MB, of impostors {:.2} MB\n",
            self.renderer.draw_groups,
            self.renderer.skinned_vertices / 1e6,
            self.renderer.triangles / 1e6,
            self.renderer.triangles_full / 1e6,
            self.renderer.palette_bytes / 1e6,
            self.renderer.record_bytes / 1e6,
            self.renderer.step_bytes / 1e6,
            self.renderer.impostor_bytes / 1e6
        ));
        text.push_str(&format!(
            "memory {:.2} MB written per frame; clips {:.2} MB, pose cache {:.2} MB, palettes {:.2} MB, state {:.2} MB ({} bytes per character), meshes {:.2} MB\n",
            self.written_mb.median,
            self.working_set.clips_bytes as f64 / 1e6,
            self.working_set.cache_bytes as f64 / 1e6,
            self.working_set.output_bytes as f64 / 1e6,
            self.working_set.state_bytes as f64 / 1e6,
            self.working_set.state_bytes_per_character,
            self.renderer.resident_bytes as f64 / 1e6
        ));
        if let (Some(ms), Some(over), Some(b)) = (self.budget_ms, self.overrun_p95, self.budget) {
            text.push_str(&format!(
                "budget {ms} ms, overrun p95 {:.1}%; {:.3} ms expected; tolerance median {:.2} px, max {:.2} px\n",
                100.0 * over, b.expected_ms, b.tolerance_px.median, b.worst_px
            ));
            if b.overloaded > 0 {
                text.push_str(&format!(
                    "overload: {} frames needed more than {} px; --epsilon-px {:.2} would fit\n",
                    b.overloaded, self.epsilon_px, b.worst_px
                ));
            }
        }
        text
    }
}

/// The levels of a character.
fn tier_table(tiers: &[LevelStatistics]) -> Table {
    let mut table = Table::new(&[
        "level",
        "joints",
        "triangles",
        "influences",
        "characters",
        "poses",
        "error mm",
        "bound px",
        "p95 px",
        "max px",
        "draw groups",
        "palettes",
        "records",
        "steps",
        "vertices",
    ]);
    for t in tiers {
        let px = |value: Option<f64>| value.map_or("-".to_owned(), |v| format!("{v:.2}"));
        table.row([
            match t.is_impostor {
                true => "impostor".to_owned(),
                false => t.level.to_string(),
            },
            t.joints.to_string(),
            t.triangles.to_string(),
            t.influences.to_string(),
            format!("{:.0}", t.characters),
            format!("{:.0}", t.poses),
            format!("{:.1}", t.error_mm),
            px(t.error_bound_px.map(f64::from)),
            px(t.error_px.map(|e| e.p95)),
            px(t.error_px.map(|e| e.max)),
            format!("{:.0}", t.renderer.draw_groups),
            format!("{:.2} MB", t.renderer.palette_bytes / 1e6),
            format!("{:.2} MB", t.renderer.record_bytes / 1e6),
            format!("{:.0}", t.steps),
            format!("{:.2} M", t.renderer.skinned_vertices / 1e6),
        ]);
    }
    table
}

/// The characters of a run.
fn cast_of(piece: &Piece, run: &Run) -> Vec<CastReport> {
    let each = piece.cast.iter().zip(&run.tiers).enumerate();
    let cast = each.map(|(i, (character, tiers))| {
        let members = piece.scene.members.iter();
        let clips = character.asset.clips().iter();
        CastReport {
            name: character.file.name.clone(),
            file: files::shown(&character.file.path),
            characters: members.filter(|m| usize::from(m.character) == i).count(),
            clips: clips.map(|c| c.name.clone()).collect(),
            renderer: DrawCost::sum(tiers),
            tiers: tiers.clone(),
        }
    });
    cast.collect()
}

/// The warnings about all characters; of several, each with the name of its character.
fn warnings(piece: &Piece) -> Vec<String> {
    let all = piece.cast.iter().flat_map(|c| {
        let name = &c.file.name;
        c.warnings.iter().map(move |w| match piece.cast.len() {
            1 => w.clone(),
            _ => format!("{name}: {w}"),
        })
    });
    all.collect()
}

/// Each text once, in their order.
fn listed<'a>(all: impl Iterator<Item = &'a String>) -> Vec<String> {
    let mut listed: Vec<String> = Vec::new();
    for text in all {
        if !listed.contains(text) {
            listed.push(text.clone());
        }
    }
    listed
}

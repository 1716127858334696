//! The report of `crowd`; its field names are stable (`docs/commands.md`).

use super::{CrowdArgs, Piece};
use crate::fault::clean;
use crate::files;
use crate::table::{Table, counted};
use articula::crowd::{
    DrawCost, FrameSummary, LevelStatistics, MorphUse, PaletteMatrices, SceneMeasurement,
};
use clap::ValueEnum;
use serde::{Serialize, Serializer};

/// Report of one run.
#[derive(Debug, Serialize)]
pub(super) struct CrowdRunReport {
    /// What a whole frame costs, and how far it is off.
    frame: FrameSummary,
    file: String,
    /// The characters, if there are several.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    cast: Vec<CastReport>,
    scene: String,
    views: usize,
    level: String,
    mesh_levels: Option<usize>,
    clips: Vec<String>,
    source: String,
    root_motion: bool,
    /// Travelling clips that are played in place.
    clips_in_place: Vec<String>,
    epsilon_px: f32,
    viewport_px: [f32; 2],
    fov_deg: f32,
    seed: u64,
    backend: String,
    palette: &'static str,
    /// Time from opening the file to a first frame in full detail: reading alone.
    first_frame_ms: f64,
    /// Time from opening the file until all is prepared: reading, and preparing what is not stored.
    ready_ms: f64,
    #[serde(flatten)]
    pub(super) measured: SceneMeasurement,
    /// Levels of the character; of several, in `cast`.
    #[serde(serialize_with = "by_level")]
    tiers: Vec<LevelStatistics>,
    /// Files written.
    pub(super) written: Vec<String>,
    warnings: Vec<String>,
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

impl CrowdRunReport {
    /// Makes the report of a run.
    pub(super) fn new(
        args: &CrowdArgs,
        piece: &Piece,
        ready_ms: f64,
        measured: SceneMeasurement,
    ) -> Self {
        let viewport = piece.scene.views[0].viewport;
        let cast = cast_of(piece, &measured);
        let source = args.source.to_possible_value();
        Self {
            frame: measured.frame(),
            file: listed(cast.iter().map(|c| &c.file)).join(", "),
            clips: listed(cast.iter().flat_map(|c| &c.clips)),
            clips_in_place: listed(piece.cast.iter().flat_map(|c| {
                let clips = c.asset.clips().iter().enumerate();
                let travelling = clips.filter(|(i, _)| c.asset.travels(*i));
                travelling.map(|(_, clip)| &clip.name)
            })),
            warnings: warnings(piece),
            tiers: match &measured.levels[..] {
                [tiers] => tiers.clone(),
                _ => Vec::new(),
            },
            cast: if cast.len() > 1 { cast } else { Vec::new() },
            views: piece.scene.views.len(),
            scene: args.scene.clone(),
            level: args.level.clone(),
            mesh_levels: args.mesh_levels,
            source: source.map_or(String::new(), |s| s.get_name().to_owned()),
            root_motion: args.root_motion,
            epsilon_px: args.epsilon_px,
            viewport_px: [viewport.width_px, viewport.height_px],
            fov_deg: viewport.fov_y_radians.to_degrees(),
            seed: args.seed,
            backend: articula::core::Backend::best().to_string(),
            palette: match args.matrices() {
                PaletteMatrices::Joints => "joints",
                PaletteMatrices::Skin => "skin",
            },
            first_frame_ms: piece.cast.iter().map(|c| c.first_frame_ms).sum(),
            ready_ms,
            measured,
            written: Vec::new(),
        }
    }

    /// Formats the report for people.
    pub(super) fn text(&self) -> String {
        let mut text = self.whole_frame();
        text.push_str(&self.heading());
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

    /// What a whole frame costs, and how far it is off.
    fn whole_frame(&self) -> String {
        let frame = &self.frame;
        format!(
            "frame  {:.3} ms, {:.2} M triangles in {:.0} draws, {:.2} MB written; error p95 {:.2} px, within 20 m {:.2} px, worst vertex {:.2} px\n\n",
            frame.ms,
            frame.triangles / 1e6,
            frame.draws,
            frame.bytes / 1e6,
            frame.error_p95_px,
            frame.error_near_px,
            frame.worst_vertex_px
        )
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
        let threads = counted(self.measured.threads, "thread", "threads");
        let clips = counted(self.clips.len(), "clip", "clips");
        format!(
            "{}, {} characters, scene {}, level {}, {clips}\n\
             {} frames at {} Hz, {threads}, {}, {views}{} x {} px, {:.0} degrees\n\
             characters: {} visible, {} in the cull margin, {} hidden{}\n\
             first frame in {:.0} ms, in full detail; all prepared in {:.0} ms\n",
            clean(name),
            self.measured.characters,
            clean(&self.scene),
            clean(&self.level),
            self.measured.frames,
            self.measured.display_hz,
            self.backend,
            self.viewport_px[0],
            self.viewport_px[1],
            self.fov_deg,
            self.measured.visible,
            self.measured.in_cull_margin,
            self.measured.hidden,
            match self.measured.occluded {
                0 => String::new(),
                occluded => format!(", {occluded} occluded"),
            },
            self.first_frame_ms,
            self.ready_ms
        )
    }

    /// Errors of small parts of the body and of roles.
    fn error_parts(&self) -> String {
        let mut text = String::new();
        let parts = self.measured.error_px.parts;
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
        for role in &self.measured.roles {
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

    /// Whether the budget was kept, and what was given up for it; empty without one.
    fn budget_text(&self) -> String {
        let (Some(ms), Some(over), Some(b)) = (
            self.measured.budget_ms,
            self.measured.overrun_p95,
            self.measured.budget,
        ) else {
            return String::new();
        };
        let mut text = format!(
            "budget {ms} ms, overrun p95 {:.1}%; {:.3} ms expected, {:.3} ms at least; tolerance median {:.2} px, max {:.2} px, near {:.2} px\n",
            100.0 * over,
            b.expected_ms,
            b.floor_ms,
            b.tolerance_px.median,
            b.worst_px,
            b.near_px
        );
        if b.budget_satisfied {
            text.push_str("budget satisfied\n");
            return text;
        }
        let (frames, gave) = (self.measured.frames, b.sacrificed);
        text.push_str(&format!(
            "budget satisfied in {} of {frames} frames; given up: more triangles in {}, error above {} px in {}, time in {}\n",
            b.satisfied, gave.triangles, self.epsilon_px, gave.pixels, gave.time
        ));
        if gave.time > 0 {
            text.push_str(&format!(
                "floor: these characters need {:.3} ms, whatever the error; raise --budget-ms or lower --count\n",
                b.floor_ms
            ));
        } else if b.overloaded > 0 {
            text.push_str(&format!(
                "overload: {} frames needed more than {} px; --epsilon-px {:.2} would fit\n",
                b.overloaded, self.epsilon_px, b.worst_px
            ));
        }
        text
    }

    fn sums(&self) -> String {
        let mut text = format!(
            "\ntime   median {:.3} ms per frame (p95 {:.3}), {:.1} ns per character, {:.0} characters per ms; before evaluation {:.3} ms; wall clock {:.3} ms\n",
            self.measured.frame_ms.median,
            self.measured.frame_ms.p95,
            self.measured.ns_per_character.median,
            self.measured.characters_per_ms,
            self.measured.tick_ms.median,
            self.measured.wall_ms.median
        );
        text.push_str(&format!(
            "error  p95 {:.2} px, max {:.2} px, max within 20 m {:.2} px, worst vertex {:.2} px ({} characters sampled, {} within 20 m)\n",
            self.measured.error_px.p95,
            self.measured.error_px.max,
            self.measured.error_px.near_max,
            self.measured.error_px.worst_vertex,
            self.measured.error_px.drawn,
            self.measured.error_px.near
        ));
        text.push_str(&self.error_parts());
        text.push_str(&format!(
            "poses  {:.0} per frame evaluated ({:.0} blend two clips), {:.0} blended from the cache, {:.0} shown from it as they are\n",
            self.measured.poses.own,
            self.measured.poses.blended,
            self.measured.poses.cached,
            self.measured.poses.stepped
        ));
        if !self.measured.morphs.levels.is_empty() {
            text.push_str(&format!(
                "faces  {:.0} characters per frame with morph target weights, {:.3} MB; characters by targets shown: {}\n",
                self.measured.morphs.characters,
                self.measured.morphs.bytes as f64 / 1e6,
                by_targets(&self.measured.morphs)
            ));
        }
        text.push_str(&format!(
            "draw   {:.0} groups, {:.2} M vertices, {:.2} M triangles ({:.2} M in full detail); palettes {:.2} MB, records {:.2} MB, draws of cached palettes {:.2} MB, of impostors {:.2} MB\n",
            self.measured.renderer.draw_groups,
            self.measured.renderer.skinned_vertices / 1e6,
            self.measured.renderer.triangles / 1e6,
            self.measured.renderer.triangles_full / 1e6,
            self.measured.renderer.palette_bytes / 1e6,
            self.measured.renderer.record_bytes / 1e6,
            self.measured.renderer.step_bytes / 1e6,
            self.measured.renderer.impostor_bytes / 1e6
        ));
        text.push_str(&format!(
            "memory {:.2} MB written per frame; clips {:.2} MB, pose cache {:.2} MB, palettes {:.2} MB, state {:.2} MB ({} bytes per character), meshes {:.2} MB\n",
            self.measured.written_mb.median,
            self.measured.working_set.clips_bytes as f64 / 1e6,
            self.measured.working_set.cache_bytes as f64 / 1e6,
            self.measured.working_set.output_bytes as f64 / 1e6,
            self.measured.working_set.state_bytes as f64 / 1e6,
            self.measured.working_set.state_bytes_per_character,
            self.measured.renderer.resident_bytes as f64 / 1e6
        ));
        text.push_str(&self.budget_text());
        text
    }
}

/// Number of characters by targets shown.
fn by_targets(morphs: &MorphUse) -> String {
    let levels = morphs.levels.iter();
    let each = levels.map(|l| format!("{:.0} of {}", l.characters, l.targets));
    each.collect::<Vec<_>>().join(", ")
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
fn cast_of(piece: &Piece, measured: &SceneMeasurement) -> Vec<CastReport> {
    let each = piece.cast.iter().zip(&measured.levels).enumerate();
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

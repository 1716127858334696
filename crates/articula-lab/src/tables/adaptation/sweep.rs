//! The joint choice over budgets, beside cuts of one part and equal cuts.

use super::cases::Packaged;
use crate::measure::median;
use crate::tables::Run;
use anyhow::Result;
use articula::item::{AdaptOptions, AdaptedItem, ItemDecision, adapt, assemble, decide};
use articula::{Figure, OpenOptions};
use articula_build::{DistanceOptions, surface_distances};
use articula_core::{Clip, Mesh, PosedMesh, Rig, Wrap, sample_morphs};
use articula_report::{PlotOptions, Scale, Series, ValueFormat, line_plot};
use articula_stream::decide::{Choice, Outcome, choose_exhaustively, cut_equally, cut_one};
use articula_stream::description::Context;
use glam::Vec3;
use std::fmt::Write as _;

/// Budgets of a sweep.
const BUDGETS: usize = 24;
/// Distances in metres.
const DISTANCES_M: [f64; 2] = [2.0, 8.0];
/// Most combinations for exhaustive search.
const MOST: u64 = 3_000_000;
/// Relative difference above which an error counts as another one.
const LESS: f64 = 1e-6;

/// What all sweeps found.
#[derive(Debug, Default)]
pub(super) struct Sweeps {
    /// Points where another way has less error.
    pub(super) worse: usize,
    /// Points where some other way meets the budget.
    points: usize,
    /// Points where the joint choice has strictly less error than all of them.
    less: usize,
    /// Points where the joint choice alone meets the budget.
    alone: usize,
    pub(super) above_exhaustive_percent: f64,
    pub(super) posed_above_bound_percent: f64,
    /// Error of the joint choice divided by that of the best of the others, for each item.
    ratios: Vec<(String, Vec<f64>)>,
}

impl Sweeps {
    /// Share of the points at which the joint choice has strictly less error, where others meet the
    /// budget at all and not everything fits.
    pub(super) fn strictly_percent(&self) -> f64 {
        100.0 * self.less as f64 / self.points.max(1) as f64
    }

    /// Compares a choice with the best of all combinations, where these are not too many.
    fn compare_exhaustively(&mut self, decision: &ItemDecision, joint: &Choice) -> Result<()> {
        let parts = &decision.parts.parts;
        let combinations = parts.iter().map(|p| p.options.len() as u64);
        if combinations.fold(1, u64::saturating_mul) > MOST {
            return Ok(());
        }
        let exact = choose_exhaustively(parts, &decision.decision.request, MOST)?;
        if let Some(exact) = exact {
            let above = 100.0 * (joint.error_px / exact.error_px.max(1e-9) - 1.0);
            self.above_exhaustive_percent = self.above_exhaustive_percent.max(above);
        }
        Ok(())
    }

    /// In words.
    pub(super) fn summary(&self) -> String {
        let mut all: Vec<f64> = Vec::new();
        all.extend(self.ratios.iter().flat_map(|(_, ratios)| ratios));
        let of_item = |(item, ratios): &(String, Vec<f64>)| {
            format!("{item} {:.2}", median(&mut ratios.clone()))
        };
        let of_items: Vec<String> = self.ratios.iter().map(of_item).collect();
        format!(
            "at {} points others meet the budget, and at {} of these the joint choice has strictly less \
             error, in the median {:.2} times that of the best of them (by item: {}); at {} points it \
             alone meets the budget",
            self.points,
            self.less,
            median(&mut all),
            of_items.join(", "),
            self.alone
        )
    }
}

pub(super) fn write(
    run: &Run,
    items: &[Packaged],
    page: &mut String,
    csv: &mut String,
) -> Result<Sweeps> {
    page.push_str(SWEEP);
    let mut sweeps = Sweeps::default();
    for packaged in items {
        let name = packaged.case.name.to_owned();
        sweeps.ratios.push((name, Vec::new()));
        for distance_m in DISTANCES_M {
            let lines = sweep(packaged, distance_m, page, csv, &mut sweeps)?;
            let name = format!(
                "adaptation-{}-{distance_m:.0}m",
                packaged.case.name.to_lowercase().replace(' ', "-")
            );
            let options = PlotOptions {
                title: format!("{}, {distance_m:.0} m", packaged.case.name),
                x_label: "bytes for what can be cut".into(),
                y_label: "error, px".into(),
                x: Scale::Logarithmic,
                y_scale: Scale::Logarithmic,
                y: ValueFormat::Plain,
                target: None,
            };
            run.save_text(&name, "svg", &line_plot(&options, &lines))?;
        }
    }
    page.push_str("\nPlots, error over bytes:\n\n");
    for packaged in items {
        for distance_m in DISTANCES_M {
            let slug = packaged.case.name.to_lowercase().replace(' ', "-");
            writeln!(
                page,
                "![{0}, {distance_m:.0} m](adaptation-{slug}-{distance_m:.0}m.svg)",
                packaged.case.name
            )?;
        }
    }
    Ok(sweeps)
}

/// Bytes of the coarsest of everything.
fn coarsest_bytes(decision: &ItemDecision) -> u64 {
    let parts = decision.parts.parts.iter();
    let least = parts.map(|part| part.options.iter().map(|o| o.bytes_once).min());
    least.flatten().sum()
}

/// The lines of a plot.
#[derive(Default)]
struct Lines(Vec<Series>);

impl Lines {
    fn add(&mut self, name: &str, point: (f64, f64), dashed: bool) {
        match self.0.iter_mut().find(|line| line.name == name) {
            Some(line) => line.points.push(point),
            None => self.0.push(Series {
                name: name.to_owned(),
                points: vec![point],
                dashed,
            }),
        }
    }
}

/// The name of a way of cutting, and its choice at a budget.
type Ways = Vec<(String, Option<Choice>)>;

fn ways(decision: &ItemDecision) -> Result<Ways> {
    let (parts, request) = (&decision.parts.parts, &decision.decision.request);
    let mut all = Vec::new();
    for (i, part) in parts.iter().enumerate() {
        all.push((format!("{} alone", part.name), cut_one(parts, request, i)?));
    }
    all.push(("equal shares".to_owned(), cut_equally(parts, request)?));
    Ok(all)
}

fn sweep(
    packaged: &Packaged,
    distance_m: f64,
    page: &mut String,
    csv: &mut String,
    sweeps: &mut Sweeps,
) -> Result<Vec<Series>> {
    let name = packaged.case.name;
    let mut context = Context::default();
    context.view.distance_m = Some(distance_m);
    // Every error counts.
    context.preferences.tolerance_px = Some(0.0);
    let at = |max_bytes: Option<u64>| {
        let options = AdaptOptions {
            max_bytes,
            ..AdaptOptions::default()
        };
        decide(&packaged.item, &context, &options)
    };
    let full = at(None)?;
    let least = coarsest_bytes(&full);
    let most = full.decision.bytes;
    let mut lines = Lines::default();
    let mut row = Vec::new();
    for step in 0..BUDGETS {
        // From the coarsest of everything up to everything, each as many times the one before.
        let share = step as f64 / (BUDGETS - 1) as f64;
        let bytes = least as f64 * (most as f64 / least as f64).powf(share);
        let budget = bytes.ceil() as u64;
        let decision = at(Some(budget + full.bytes_always))?;
        let Outcome::Parts(joint) = &decision.decision.outcome else {
            continue;
        };
        writeln!(
            csv,
            "{name},{distance_m},{budget},joint,{:.6}",
            joint.error_px
        )?;
        lines.add("joint choice", (bytes, joint.error_px), false);
        let mut best = f64::INFINITY;
        for (way, choice) in ways(&decision)? {
            let error = choice.map_or(f64::NAN, |choice| choice.error_px);
            writeln!(csv, "{name},{distance_m},{budget},{way},{error:.6}")?;
            lines.add(&way, (bytes, error), true);
            if error < best {
                best = error;
            }
        }
        if step % 4 == 1 {
            sweeps.compare_exhaustively(&decision, joint)?;
        }
        if step + 1 < BUDGETS {
            if best.is_finite() {
                sweeps.points += 1;
                if let Some((_, ratios)) = sweeps.ratios.last_mut() {
                    ratios.push(joint.error_px / best);
                }
                sweeps.less += usize::from(joint.error_px < best * (1.0 - LESS));
            } else {
                sweeps.alone += 1;
            }
        }
        sweeps.worse += usize::from(joint.error_px > best * (1.0 + LESS));
        if [6, 12, 18].contains(&step) {
            let posed = posed_px(packaged, &decision)?;
            let above = 100.0 * (posed / metric_px(&decision).max(1e-9) - 1.0);
            sweeps.posed_above_bound_percent = sweeps.posed_above_bound_percent.max(above);
            let best = if best.is_finite() {
                format!("{best:.2}")
            } else {
                "–".to_owned()
            };
            row.push(format!(
                "{budget}: {:.2} ({posed:.2}; {best})",
                joint.error_px
            ));
        }
    }
    writeln!(page, "| {name} | {distance_m:.0} m | {} |", row.join(" | "))?;
    Ok(lines.0)
}

/// The bound of the parts whose errors are distances: all but textures.
fn metric_px(decision: &ItemDecision) -> f64 {
    let px = decision.decision.request.pixels_per_metre;
    let Outcome::Parts(choice) = &decision.decision.outcome else {
        return 0.0;
    };
    let chosen = decision.parts.parts.iter().zip(&choice.options);
    chosen
        .map(|(part, option)| px * part.options[*option].error_m)
        .sum()
}

/// The greatest distance of the original surface from the chosen combination, both moving, in pixels.
fn posed_px(packaged: &Packaged, decision: &ItemDecision) -> Result<f64> {
    let Some(cut) = &decision.cut else {
        return Ok(0.0);
    };
    let AdaptedItem::Layers(item) = adapt(&packaged.item, cut)? else {
        return Ok(0.0);
    };
    let shown = Figure::new(assemble(&item, &OpenOptions::default())?)?;
    let mut most = 0.0_f64;
    for clip in &shown.asset.clips {
        let original = packaged.figure.asset.clips.iter();
        if let Some(truth) = original.clone().find(|c| c.name == clip.name) {
            most = most.max(apart(&packaged.figure, truth, &shown, clip)?);
        }
    }
    Ok(most * decision.decision.request.pixels_per_metre)
}

/// Greatest distance of one moving surface from another, at eight frames.
fn apart(a: &Figure, of_a: &Clip, b: &Figure, of_b: &Clip) -> Result<f64> {
    let first = a.asset.mesh.len() as u32;
    let other = b.asset.mesh.triangles.iter();
    let other: Vec<[u32; 3]> = other.map(|t| t.map(|v| v + first)).collect();
    let mut most = 0.0_f64;
    for frame in (0..of_a.frames()).step_by(of_a.frames().div_ceil(8)) {
        let secs = frame as f64 / f64::from(of_a.rate_hz());
        let mut all = vertices(&a.asset.rig, &a.asset.mesh, of_a, secs);
        all.extend(vertices(&b.asset.rig, &b.asset.mesh, of_b, secs));
        let opts = DistanceOptions::default();
        let found = surface_distances(&a.asset.mesh.triangles, &[&other], &all, &[], &opts)?;
        most = most.max(f64::from(found[0].rest.max_metres));
    }
    Ok(most)
}

fn vertices(rig: &Rig, mesh: &Mesh, clip: &Clip, secs: f64) -> Vec<Vec3> {
    let mut posed = PosedMesh::new(rig, mesh);
    let mut weights = mesh.morph_weights.clone();
    sample_morphs(clip, secs, Wrap::Clamp, &mut weights);
    posed
        .pose_at(clip, secs, Wrap::Clamp)
        .skinned(&weights)
        .positions
}

const SWEEP: &str = "
## One budget over motion, mesh and textures

For each item and distance 24 budgets from the coarsest to the finest of everything, each as many times the one before. At a quarter, a
half and three quarters of the way: bytes for what can be cut, and the error of the joint choice, in px; in brackets the greatest distance when the chosen
combination is posed (without textures), and the least error of those cuts that meet the budget: one part cut alone and the others
whole, or all cut to equal shares (–: none does). The CSV file has all points.

| item | distance | a quarter | a half | three quarters |
| --- | --- | --- | --- | --- |
";

//! The report of `lod`; its field names are stable (`docs/commands.md`).

use super::{LodArgs, with_face};
use crate::fault::clean;
use crate::open;
use crate::table::{Table, warnings};
use articula::evaluate::{
    Costs, ErrorPx, EvaluatedClip, MethodRow, MethodTable, PathSummary, ScheduleReport,
};
use articula::face::FaceWithBody;
use articula::{Figure, MotionTables};
use clap::ValueEnum;
use serde::Serialize;

/// Report of one clip under one method or all methods.
#[derive(Debug, Default, Serialize)]
pub(super) struct LodReport {
    pub(super) file: String,
    pub(super) clip: Option<String>,
    pub(super) method: String,
    pub(super) calibrate_px: Option<f32>,
    pub(super) frames: usize,
    pub(super) rate_hz: f32,
    /// Joints of the skin.
    pub(super) joints: usize,
    /// Joints that the clip rotates, without the root.
    pub(super) joints_moving: usize,
    pub(super) viewport_px: [f32; 2],
    pub(super) fov_deg: f32,
    pub(super) azimuths_deg: Vec<f32>,
    pub(super) vertices_watched: usize,
    pub(super) seed: u64,
    pub(super) rows: Vec<MethodRow>,
    /// Fields of a moving camera only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) camera_path: Option<PathSummary>,
    /// Schedules only: one entry for each kind of transition, that of the flags first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) schedule: Option<Vec<ScheduleReport>>,
    /// The face beside the body, with `--face` only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) face: Option<FaceWithBody>,
    /// Costs by zone, depth and complexity, where they are plotted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) costs: Option<Costs>,
    /// Files written.
    pub(super) written: Vec<String>,
    pub(super) warnings: Vec<String>,
}

impl LodReport {
    /// Makes the report of a clip.
    pub(super) fn new(scene: &EvaluatedClip<'_>, args: &LodArgs, tables: &[MethodTable]) -> Self {
        let asset = &scene.figure.asset;
        let clip = &asset.clips[scene.clip].at_key_rate();
        let mut moving = articula::build::moving_joints(asset, clip);
        if !asset.rig.skin_joints().is_empty() {
            moving = moving.intersection(asset.rig.skin_joints());
        }
        let mut report = Self {
            clip: Some(clip.name.clone()),
            frames: clip.frames(),
            rate_hz: clip.rate_hz(),
            joints_moving: moving.len(),
            azimuths_deg: scene.setup.azimuths_deg.clone(),
            rows: tables.iter().flat_map(|t| t.rows.clone()).collect(),
            warnings: {
                let mut warnings = open::warnings(scene.figure.opened.warnings());
                warnings.extend(MotionTables::stored(scene.figure, scene.clip).warnings);
                warnings
            },
            ..Self::at_rest(scene.figure, args)
        };
        if moving.is_empty() {
            let what = "no joint rotates in this clip, so there are no updates to save";
            report.warnings.push(what.into());
        }
        if asset.mesh.is_empty() {
            let what = "no mesh: errors are measured at the joints";
            report.warnings.push(what.into());
        }
        if report.rows.iter().any(|r| r.meets_target == Some(false)) {
            let what = "some rows miss the target: no parameter of the method meets it";
            report.warnings.push(what.into());
        }
        report
    }

    /// The report of a character without a clip.
    pub(super) fn at_rest(figure: &Figure, args: &LodArgs) -> Self {
        let asset = &figure.asset;
        let setup = args.setup();
        let method = args.method.method().to_possible_value();
        Self {
            file: figure.opened.name().to_owned(),
            method: method.map_or(String::new(), |m| m.get_name().to_owned()),
            calibrate_px: args.calibrate,
            joints: asset.rig.skin_joints().len(),
            viewport_px: [setup.viewport.width_px, setup.viewport.height_px],
            fov_deg: args.view.fov_deg,
            azimuths_deg: setup.azimuths_deg,
            vertices_watched: setup.points.min(asset.mesh.len()),
            seed: args.seed,
            warnings: std::iter::once("the file has no clip: rest pose only".into())
                .chain(open::warnings(figure.opened.warnings()))
                .collect(),
            ..Self::default()
        }
    }

    /// Character, clip and method on one line.
    pub(super) fn heading(&self) -> String {
        let name = self.file.rsplit(['/', '\\']).next().unwrap_or(&self.file);
        let clip = self.clip.as_ref();
        let clip = clip.map_or("rest pose".to_owned(), |c| format!("clip \"{c}\""));
        clean(&format!("{name}, {clip}, {}", self.method))
    }

    /// Notes below the heading of a contact sheet.
    pub(super) fn notes(&self) -> Vec<String> {
        let tuned = match self.calibrate_px {
            Some(px) => format!("calibrated to {px} px of p95 error"),
            None => "not calibrated".into(),
        };
        vec![
            format!(
                "{} frames at {} Hz, {} joints, {} of them moving; {tuned}.",
                self.frames,
                hundredths(self.rate_hz),
                self.joints,
                self.joints_moving
            ),
            "First row: reference. Below: reduced; in the corner at its true size on the screen, where it fits."
                .into(),
            "px: displacement of the skin from this side at this distance, 95th percentile over vertices."
                .into(),
        ]
    }

    /// Formats the report for people.
    pub(super) fn text(&self) -> String {
        let mut text = format!("{}\n", self.heading());
        if self.clip.is_some() {
            text.push_str(&format!(
                "{} frames at {} Hz, {} joints, {} moving; {} x {} px, {} degrees\n",
                self.frames,
                hundredths(self.rate_hz),
                self.joints,
                self.joints_moving,
                self.viewport_px[0],
                self.viewport_px[1],
                self.fov_deg
            ));
        }
        let rows = self.rows();
        if !rows.is_empty() {
            text.push('\n');
            text.push_str(&rows.text());
        }
        text.extend(self.face.iter().map(with_face::text));
        if let Some(path) = &self.camera_path {
            let bound = path.bound_px;
            let bound = bound.map_or("no bound".to_owned(), |px| format!("bound {px:.2} px"));
            text.push_str(&format!(
                "moving camera: {} frames at {} Hz, {:.1} to {:.1} m; maximum joint error {:.2} px, {bound}\n",
                path.frames,
                path.display_hz,
                path.distance_m_min,
                path.distance_m_max,
                path.joint_error_px_max,
            ));
        }
        if let Some(schedule) = &self.schedule {
            text.push('\n');
            text.push_str(&schedule_table(schedule).text());
        }
        text.push_str(&warnings(&self.warnings));
        for file in &self.written {
            text.push_str(&format!("wrote {}\n", clean(file)));
        }
        text
    }

    fn rows(&self) -> Table {
        let mut table = Table::new(&[
            "method",
            "distance",
            "updates saved",
            "frames without update",
            "parameter",
            "p50 px",
            "p95 px",
            "max px",
            "worst vertex",
            "hands",
            "face",
            "feet",
            "joints sampled",
            "FK joints",
        ]);
        for row in &self.rows {
            let variant = row.variant.map_or(String::new(), |v| format!(" {v}"));
            let parameter = row
                .level
                .clone()
                .unwrap_or_else(|| significant(row.parameter));
            let part = |part: Option<ErrorPx>| match part {
                Some(part) => format!("{:.2}", part.p95),
                None => "-".to_owned(),
            };
            let missed = if row.meets_target == Some(false) {
                " !"
            } else {
                ""
            };
            table.row([
                format!("{}{variant}", row.method),
                format!("{} m", hundredths(row.distance_m)),
                format!("{:.1}%", 100.0 * row.joint_update_gain),
                format!("{:.1}%", 100.0 * row.evaluations_saved),
                parameter,
                format!("{:.2}", row.error_px.p50),
                format!("{:.2}{missed}", row.error_px.p95),
                format!("{:.2}", row.error_px.max),
                format!("{:.2}", row.error_px.worst_vertex),
                part(row.hands_px),
                part(row.face_px),
                part(row.feet_px),
                format!("{:.1}", row.joints_sampled),
                format!("{:.1}", row.fk_joints),
            ]);
        }
        table
    }
}

/// One line for each change under each kind of transition.
fn schedule_table(schedule: &[ScheduleReport]) -> Table {
    let mut table = Table::new(&[
        "time",
        "level",
        "joints",
        "transition",
        "px before",
        "px at",
        "px after",
        "jump per frame",
        "gap",
    ]);
    for played in schedule {
        for change in &played.changes {
            table.row([
                format!("{:.2} s", change.t),
                change.level.clone(),
                change.joints.to_string(),
                played.transition.to_owned(),
                format!("{:.2}", change.error_px.before),
                format!("{:.2}", change.error_px.at),
                format!("{:.2}", change.error_px.after),
                format!("{:.2}°", change.jump_deg),
                format!("{:.2}°", change.gap_deg),
            ]);
        }
    }
    table
}

/// A value rounded to two decimals.
fn hundredths(value: f32) -> f32 {
    (value * 100.0).round() / 100.0
}

/// A value with four significant digits.
fn significant(value: f32) -> String {
    if value == 0.0 || value.fract() == 0.0 {
        return format!("{value}");
    }
    let digits = (3 - value.abs().log10().floor() as i32).clamp(0, 8);
    format!("{value:.*}", digits as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_digits_count() {
        assert_eq!(significant(0.001_234_56), "0.001235");
        assert_eq!(significant(0.25), "0.2500");
        assert_eq!(significant(3.0), "3");
        assert_eq!(significant(0.0), "0");
    }
}
